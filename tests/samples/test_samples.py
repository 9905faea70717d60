"""The sample stages: written as committed, valid, and a natural walk on the ground.

What is measured here is measured on the composed stages through UsdSkel, not taken from the generator.
"""

import re
from fnmatch import fnmatchcase
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdSkel, UsdUtils, UsdValidation
from scipy.spatial.transform import Rotation

from tests.samples import humanoid
from tests.samples.gait_tables import TABLES
from tests.samples.make_samples import FOLDER, differing, main

FloatArray = npt.NDArray[np.float64]

STAGES = ("humanoid.usda", "takes.usda", "walk.usda", "walk_to_stop.usda", "phrase.usda")
SHOTS = STAGES[2:]
WRITTEN_BY_HAND = "edits.usda"
WALKS = ("walk_slow", "walk_natural", "walk_brisk")
PHRASES = ("phrase_reach", "phrase_turn")
RATE = 24.0
# A recorded walk stays this near the ground; a sketch of few keys dips its toes between them.
TAKE_DEPTH_CM = 0.5
SKETCH_DEPTH_CM = 3.0
HEEL_DOWN_CM = 0.8
# The ankle is where feet that stand still part most from means of other people, and at most in the slow walk.
LEAST_CORRELATION = {"hip": 0.95, "knee": 0.95, "ankle": 0.92, "shoulder": 0.95, "elbow": 0.95}


def _local_transforms(stage: Usd.Stage, skeleton_path: str, animation_path: str) -> FloatArray:
    """Joint-local transforms of an animation on a skeleton through UsdSkel, shape [F, J, 4, 4]."""
    skeleton = UsdSkel.Skeleton(stage.GetPrimAtPath(skeleton_path))
    query = UsdSkel.Cache().GetSkelQuery(skeleton)
    animation = UsdSkel.Cache().GetAnimQuery(UsdSkel.Animation(stage.GetPrimAtPath(animation_path)))
    mapper = UsdSkel.AnimMapper(animation.GetJointOrder(), query.GetJointOrder())
    rest = skeleton.GetRestTransformsAttr().Get()
    times = animation.GetJointTransformTimeSamples()
    frames = [np.array(mapper.RemapTransforms(animation.ComputeJointLocalTransforms(t), rest)) for t in times]
    return np.array(frames)


def _world(local: FloatArray) -> FloatArray:
    out = local.copy()
    for joint, parent in enumerate(humanoid.PARENTS):
        if parent >= 0:
            out[:, joint] = local[:, joint] @ out[:, parent]
    return out


def _soles(local: FloatArray) -> FloatArray:
    """Heel, ball and toe tip of both feet, shape [F, 2, 3, 3]."""
    world = _world(local)
    feet = []
    for side in ("Left", "Right"):
        points = [(humanoid.index_of(side + name), np.array([*offset, 1.0])) for name, offset in humanoid.SOLE_POINTS]
        feet.append([point @ world[:, joint] for joint, point in points])
    return np.moveaxis(np.array(feet)[..., :3], 2, 0)


def _angles(local: FloatArray, name: str) -> FloatArray:
    """Turns about x, y and z in degrees, shape [F, 3]."""
    matrices = np.swapaxes(local[:, humanoid.index_of(name), :3, :3], -1, -2)
    return np.asarray(Rotation.from_matrix(matrices).as_euler("XYZ", degrees=True))


def _heel_strikes(local: FloatArray, side: str) -> FloatArray:
    """Times in frames at which a heel comes to the ground after it was well off it."""
    heel = _soles(local)[:, ("Left", "Right").index(side), 0, 1]
    down = np.flatnonzero((heel[:-1] > HEEL_DOWN_CM) & (heel[1:] <= HEEL_DOWN_CM))
    landed = [f for f in down if heel[max(f - 8, 0) : f].max(initial=0.0) > 10.0]
    return np.array([f + (heel[f] - HEEL_DOWN_CM) / (heel[f] - heel[f + 1]) for f in landed])


def _cycles(curve: FloatArray, strikes: FloatArray) -> FloatArray:
    """Cut a curve [F] at heel strikes and sample each stride every 5 %; shape [S, 20]."""
    phase = np.arange(20) / 20.0
    frames = np.arange(len(curve))
    return np.array([np.interp(a + phase * (b - a), frames, curve) for a, b in pairwise(strikes)])


@pytest.fixture(scope="module")
def takes() -> dict[str, FloatArray]:
    """Local transforms of every take, by name."""
    stage = Usd.Stage.Open(str(FOLDER / "takes.usda"))
    return {name: _local_transforms(stage, "/Takes/Skeleton", f"/Takes/{name}") for name in WALKS + PHRASES}


def test_the_committed_stages_are_what_the_script_writes() -> None:
    assert differing(FOLDER) == []
    # What usdmtex and its siblings make of them, as the README's commands do, is the user's own.
    made = re.compile(r"\.(mtex|edit|constrain|conform)\.")
    there_are = sorted(p.name for p in FOLDER.glob("*.usd*") if not made.search(p.name))
    assert there_are == sorted([*STAGES, WRITTEN_BY_HAND])


def test_a_second_run_writes_the_same_bytes_elsewhere(tmp_path: Path) -> None:
    assert main(["--folder", str(tmp_path)]) == 0
    for name in STAGES:
        assert (tmp_path / name).read_bytes() == (FOLDER / name).read_bytes()
    assert main(["--check", "--folder", str(tmp_path)]) == 0


def test_check_names_the_stage_that_differs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["--folder", str(tmp_path)])
    with (tmp_path / "phrase.usda").open("a") as stage:
        stage.write("\n")
    assert main(["--check", "--folder", str(tmp_path)]) == 1
    lines = capsys.readouterr().err.splitlines()
    assert [Path(line.split()[0]).name for line in lines] == ["phrase.usda"]


@pytest.mark.parametrize("name", STAGES)
def test_stage_opens_without_diagnostics_and_validates(name: str) -> None:
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    stage = Usd.Stage.Open(str(FOLDER / name))
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert delegate.TakeUncoalescedDiagnostics() == []
    assert len(validators) >= 30
    assert [f"{error.GetName()}: {error.GetMessage()}" for error in errors] == []


@pytest.mark.parametrize("name", STAGES)
def test_stage_has_all_root_metadata_and_is_small(name: str) -> None:
    layer = Sdf.Layer.FindOrOpen(str(FOLDER / name))
    for key in ("timeCodesPerSecond", "framesPerSecond", "startTimeCode", "endTimeCode", "upAxis", "metersPerUnit"):
        assert layer.pseudoRoot.HasInfo(key), key
    assert layer.defaultPrim
    assert (FOLDER / name).stat().st_size < 1_500_000


def test_the_body_is_closed_and_follows_its_joints() -> None:
    stage = Usd.Stage.Open(str(FOLDER / "humanoid.usda"))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/Humanoid/Body"))
    points = np.array(mesh.GetPointsAttr().Get())
    ends = np.cumsum(mesh.GetFaceVertexCountsAttr().Get())
    faces = np.split(np.array(mesh.GetFaceVertexIndicesAttr().Get()), ends[:-1])
    edges = [(a, b) for face in faces for a, b in zip(face, np.roll(face, -1), strict=True)]
    assert len(set(edges)) == len(edges) == len({(b, a) for a, b in edges} & set(edges))
    volume = sum(
        np.dot(points[f[0]], np.cross(points[f[i]], points[f[i + 1]])) / 6.0
        for f in faces
        for i in range(1, len(f) - 1)
    )
    # Seventy litres, give or take what the tubes share and leave out.
    assert 50_000.0 < volume < 90_000.0
    query = UsdSkel.Cache()
    query.Populate(UsdSkel.Root(stage.GetPrimAtPath("/Humanoid")), Usd.PrimDefaultPredicate)
    assert query.GetSkinningQuery(mesh.GetPrim()).IsRigidlyDeformed() is False
    assert query.GetSkinningQuery(mesh.GetPrim()).HasJointInfluences()


@pytest.mark.parametrize("name", SHOTS)
def test_shot_binds_its_sketch(name: str) -> None:
    stage = Usd.Stage.Open(str(FOLDER / name))
    cache = UsdSkel.Cache()
    cache.Populate(UsdSkel.Root(stage.GetPrimAtPath("/Humanoid")), Usd.PrimDefaultPredicate)
    query = cache.GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath("/Humanoid/Skeleton")))
    animation = query.GetAnimQuery()
    assert animation.GetPrim().GetPath() == "/Humanoid/Sketch"
    assert len(animation.GetJointTransformTimeSamples()) == stage.GetEndTimeCode() + 1
    assert np.ptp(np.array(query.ComputeJointSkelTransforms(0.0)) - query.ComputeJointSkelTransforms(60.0)) > 1.0
    targets = stage.GetPrimAtPath("/Humanoid/Sketch").GetRelationship("mtex:takes").GetTargets()
    assert [str(target) for target in targets] == ["/Takes"]
    assert stage.GetPrimAtPath("/Takes/walk_slow").IsValid()


@pytest.mark.parametrize("name", SHOTS)
def test_every_role_token_finds_joints_and_no_joint_has_two_roles(name: str) -> None:
    stage = Usd.Stage.Open(str(FOLDER / name))
    sketch = stage.GetPrimAtPath("/Humanoid/Sketch")

    def joints(role: str) -> set[str]:
        found: set[str] = set()
        for token in sketch.GetAttribute(f"mtex:{role}").Get():
            hits = {joint for joint in humanoid.NAMES if fnmatchcase(joint, token.partition(".")[0])}
            assert hits, token
            found |= hits
        return found

    sketched = {joint.rpartition("/")[2] for joint in UsdSkel.Animation(sketch).GetJointsAttr().Get()}
    assert joints("match") <= sketched
    assert joints("texture") <= sketched
    assert joints("synthesize").isdisjoint(sketched)
    assert joints("synthesize") | sketched == set(humanoid.NAMES) - {"LeftToe", "RightToe"}


def test_segments_cover_the_stop_without_overlap() -> None:
    stage = Usd.Stage.Open(str(FOLDER / "walk_to_stop.usda"))
    sketch = stage.GetPrimAtPath("/Humanoid/Sketch")
    spans = [[sketch.GetAttribute(f"mtex:segment:{n}:{e}").Get() for e in ("start", "end")] for n in ("stride", "stop")]
    assert spans[0][0] == 0
    assert spans[0][1] + 1 == spans[1][0]
    assert spans[1][1] == stage.GetEndTimeCode()
    assert sketch.GetAttribute("mtex:scale").Get() is True


@pytest.mark.parametrize("name", WALKS + PHRASES)
def test_takes_carry_their_range_style_and_skeleton(name: str) -> None:
    stage = Usd.Stage.Open(str(FOLDER / "takes.usda"))
    prim = stage.GetPrimAtPath(f"/Takes/{name}")
    assert "MtexTakeAPI" in prim.GetMetadata("apiSchemas").GetAppliedItems()
    assert prim.GetAttribute("mtex:take:start").Get() == 0
    assert prim.GetAttribute("mtex:take:end").Get() == 239
    assert prim.GetAttribute("mtex:take:style").Get() == name.partition("_")[0]
    assert [str(t) for t in prim.GetRelationship("mtex:take:skeleton").GetTargets()] == ["/Takes/Skeleton"]


@pytest.mark.parametrize("name", WALKS + PHRASES)
def test_bones_keep_their_lengths(takes: dict[str, FloatArray], name: str) -> None:
    places = takes[name][:, 1:, 3, :3]
    assert np.abs(places - humanoid.OFFSETS[1:]).max() < 1e-4
    scales = np.linalg.norm(takes[name][:, :, :3, :3], axis=-1)
    assert np.abs(scales - 1.0).max() < 5e-5


@pytest.mark.parametrize("name", WALKS + PHRASES)
def test_a_foot_is_on_the_ground_and_none_below(takes: dict[str, FloatArray], name: str) -> None:
    height = _soles(takes[name])[..., 1]
    assert height.min() > -TAKE_DEPTH_CM
    assert height.min(axis=(1, 2)).max() < TAKE_DEPTH_CM


@pytest.mark.parametrize("name", WALKS + PHRASES)
def test_a_flat_foot_stands_still(takes: dict[str, FloatArray], name: str) -> None:
    soles = _soles(takes[name])
    flat = soles[..., 1].max(axis=2) < TAKE_DEPTH_CM
    both = flat[1:] & flat[:-1]
    speed = np.linalg.norm(np.diff(soles.mean(axis=2), axis=0)[..., [0, 2]], axis=-1) * RATE
    assert both.sum() > 80
    assert np.percentile(speed[both], 95) < 3.0


@pytest.mark.parametrize("name", SHOTS)
def test_sketched_feet_stay_near_the_ground(name: str) -> None:
    stage = Usd.Stage.Open(str(FOLDER / name))
    height = _soles(_local_transforms(stage, "/Humanoid/Skeleton", "/Humanoid/Sketch"))[..., 1]
    assert height.min() > -SKETCH_DEPTH_CM
    assert height.min(axis=(1, 2)).max() < SKETCH_DEPTH_CM


@pytest.mark.parametrize("side", ["Left", "Right"])
@pytest.mark.parametrize("name", WALKS)
def test_mean_curves_follow_the_published_tables(takes: dict[str, FloatArray], name: str, side: str) -> None:
    strikes = _heel_strikes(takes[name], side)
    assert len(strikes) >= 6
    out = 1.0 if side == "Left" else -1.0
    curves = {
        "hip": -_angles(takes[name], f"{side}UpLeg")[:, 0],
        "knee": _angles(takes[name], f"{side}Leg")[:, 0],
        "ankle": -_angles(takes[name], f"{side}Foot")[:, 0],
        "shoulder": -_angles(takes[name], f"{side}Arm")[:, 0],
        "elbow": -out * _angles(takes[name], f"{side}ForeArm")[:, 1],
    }
    for table, curve in curves.items():
        mean = _cycles(curve, strikes).mean(axis=0)
        assert np.corrcoef(mean, TABLES[table])[0, 1] > LEAST_CORRELATION[table], table


@pytest.mark.parametrize("name", WALKS)
def test_left_and_right_are_alike_on_average_but_no_two_strides_are(takes: dict[str, FloatArray], name: str) -> None:
    for joint in ("UpLeg", "Leg"):
        left, right = (
            _cycles(_angles(takes[name], side + joint)[:, 0], _heel_strikes(takes[name], side))
            for side in ("Left", "Right")
        )
        assert np.sqrt(np.mean((left.mean(axis=0) - right.mean(axis=0)) ** 2)) < 3.0
        assert 0.5 < np.sqrt(np.mean(left.var(axis=0))) < 5.0


@pytest.mark.parametrize(("name", "speed"), [("walk_slow", 0.97), ("walk_natural", 1.33), ("walk_brisk", 1.71)])
def test_walks_travel_at_the_speed_of_their_cadence(takes: dict[str, FloatArray], name: str, speed: float) -> None:
    root = takes[name][:, 0, 3, :3] / 100.0
    travelled = np.linalg.norm(np.diff(root[:, [0, 2]], axis=0), axis=1)
    assert travelled.mean() * RATE == pytest.approx(speed, rel=0.05)
    assert 0.02 < np.ptp(root[:, 1]) < 0.08


@pytest.mark.parametrize("name", WALKS)
def test_arms_swing_against_the_legs_beside_the_body(takes: dict[str, FloatArray], name: str) -> None:
    world = _world(takes[name])
    for side in ("Left", "Right"):
        arm, leg = (_angles(takes[name], side + joint)[:, 0] for joint in ("Arm", "UpLeg"))
        assert np.corrcoef(arm, leg)[0, 1] < -0.7
        hand = world[:, humanoid.index_of(side + "Hand"), 3, :3] - world[:, 0, 3, :3]
        aside = np.linalg.norm(hand[:, [0, 2]], axis=1)
        assert aside.min() > 15.0
        assert aside.max() < 60.0


@pytest.mark.parametrize("name", PHRASES)
def test_phrases_move_the_arms_with_the_legs(takes: dict[str, FloatArray], name: str) -> None:
    knees = sum(_angles(takes[name], side + "Leg")[:, 0] for side in ("Left", "Right"))
    arms = -sum(_angles(takes[name], side + "Arm")[:, 0] for side in ("Left", "Right"))
    assert np.ptp(arms) > 40.0
    assert np.corrcoef(knees, arms)[0, 1] > 0.7
