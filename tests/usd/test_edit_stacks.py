"""Stacks of edits on stages: what is written plays as computed, times move with layers, motions come from anywhere."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdSkel, Vt

import mtex_usd
from mtex_usd import edit
from mtex_usd.errors import InputError, StageError
from mtex_usd.motion.clip import Clip
from mtex_usd.usd.custom_data import from_metadata
from tests.quality.edit_support import load
from tests.synthetic import JOINTS, LEFT_ARM, POSITIONS, RIGHT_ARM, make_skeleton, on_joints, skeleton_turns, walk
from tests.usd import edit_support as support
from tests.usd.edit_support import ANIMATION, FRAMES, MODEL, OTHER, play, play_clip, variants_of, write_shot
from tests.usd.playback import no_diagnostics, select_variant, skeleton_query

STACKS = """
    uniform token[] mtex:edits = ["calm", "raise"]
    uniform token[] mtex:edits:slower = ["slow"]
    uniform token[] mtex:edits:other = ["half"]
    uniform token mtex:edit:calm:op = "lowpass"
    uniform double[] mtex:edit:calm:frequencies = [1.5]
    uniform token[] mtex:edit:calm:channels = ["*Arm"]
    uniform token mtex:edit:raise:op = "displace"
    uniform timecode[] mtex:edit:raise:keys = [30]
    uniform token[] mtex:edit:raise:channels = ["LeftArm"]
    uniform double3[] mtex:edit:raise:rotations = [(0, 0, 40)]
    uniform double2 mtex:edit:raise:scope = (0.5, 0.5)
    uniform token mtex:edit:slow:op = "scaleTime"
    uniform double mtex:edit:slow:factor = 1.5
    uniform token mtex:edit:half:op = "blend"
    rel mtex:edit:half:with = </Takes/Other>
    uniform double[] mtex:edit:half:weights = [0.5]
"""
NAMES = ("calm", "raise", "slow", "half")
RAISED = edit.Displacement(keys=[edit.PoseChange(frame=30, rotations={"LeftArm": (0, 0, 40)})], scope=(12.0, 12.0))


@pytest.fixture
def shot(tmp_path: Path) -> Path:
    return write_shot(tmp_path, STACKS, NAMES)


def by_variant(results: tuple[Any, ...]) -> dict[str, Any]:
    return {result.variant: result for result in results}


def read(stage: Path, prim_path: str = ANIMATION) -> Clip:
    return mtex_usd.read_clip(stage, prim_path)


def assert_close(one: Clip, two: Clip, *, degrees: float = 1e-3, units: float = 1e-3) -> None:
    assert one.joints == two.joints
    np.testing.assert_allclose(one.time_codes, two.time_codes, atol=1e-9)
    cosine = np.abs((one.rotations * two.rotations).sum(axis=-1))
    assert 2.0 * np.degrees(np.arccos(np.clip(cosine, 0.0, 1.0))).max() <= max(degrees, 1e-5)
    np.testing.assert_allclose(one.translations, two.translations, atol=units)


# --- the override layer ---


def test_results_are_the_functions(shot: Path) -> None:
    found = by_variant(mtex_usd.apply_edits(shot))
    clip, other = read(shot), read(shot, OTHER)
    assert other.joints != clip.joints  # it has no skeleton that tells their order
    index = [other.joints.index(joint) for joint in clip.joints]
    other = replace(clip, rotations=other.rotations[:, index], translations=other.translations[:, index])
    expected = {
        "edited": edit.displace(edit.lowpass(clip, frequency=1.5, channels=["*Arm"]), RAISED),
        "slower": edit.scale_time(clip, factor=1.5),
        "other": edit.blend(clip, other, weights=0.5, place="first").clip,
    }
    assert set(found) == set(expected)
    for name, result in found.items():
        np.testing.assert_allclose(result.clip.rotations, expected[name].rotations, atol=1e-9, err_msg=name)
        np.testing.assert_allclose(result.clip.translations, expected[name].translations, atol=1e-6, err_msg=name)


def test_variants_play_as_computed(shot: Path) -> None:
    """Every frame of every variant, through UsdSkel, on the thin root."""
    before = play(shot, range(FRAMES))
    found = by_variant(mtex_usd.apply_edits(shot))
    (root,) = {result.stage for result in found.values()}
    with no_diagnostics():
        for name, result in found.items():
            played = play(root, result.clip.time_codes.tolist(), name)
            np.testing.assert_allclose(played, play_clip(result.clip), atol=2e-4, err_msg=name)
        np.testing.assert_array_equal(play(root, range(FRAMES), "original"), before)
    np.testing.assert_array_equal(play(root, range(FRAMES)), play(root, range(FRAMES), "edited"))


def test_variants_and_selection(shot: Path) -> None:
    (layer,) = {result.layer for result in mtex_usd.apply_edits(shot)}
    assert layer == shot.with_name("shot.edit.usd")
    assert variants_of(layer) == (["edited", "original", "other", "slower"], "edited")


def test_without_a_first_stack_the_first_name_is_selected(tmp_path: Path) -> None:
    body = STACKS.replace("mtex:edits =", "mtex:edits:calm =")
    (layer,) = {result.layer for result in mtex_usd.apply_edits(write_shot(tmp_path, body, NAMES))}
    assert variants_of(layer) == (["calm", "original", "other", "slower"], "calm")


def test_the_stage_runs_as_long_as_the_longest_variant(shot: Path) -> None:
    root = Usd.Stage.Open(str(mtex_usd.apply_edits(shot)[0].stage))
    assert (root.GetStartTimeCode(), root.GetEndTimeCode()) == (0.0, 88.0)


def test_what_a_variant_carries(shot: Path) -> None:
    found = by_variant(mtex_usd.apply_edits(shot))
    for name, edits in (("edited", ["calm", "raise"]), ("slower", ["slow"]), ("other", ["half"])):
        data = from_metadata(support.read_custom_data(found[name].stage, name))
        assert data == found[name].custom_data
        assert (data["edit"], [each["name"] for each in data["edits"]]) == (name, edits)
    assert found["edited"].custom_data["edits"][0] == {"name": "calm", "op": "lowpass"}


def test_joints_without_an_edit_keep_their_bits(shot: Path) -> None:
    found = by_variant(mtex_usd.apply_edits(shot))
    source, result = Usd.Stage.Open(str(shot)), Usd.Stage.Open(str(found["edited"].stage))
    joints = list(source.GetPrimAtPath(ANIMATION).GetAttribute("joints").Get())
    changed = {joint for joint in joints if joint.endswith("Arm")}
    for time in range(FRAMES):
        pair = [
            np.array(stage.GetPrimAtPath(path).GetAttribute("rotations").Get(time))
            for stage, path in ((source, ANIMATION), (result, f"{ANIMATION}_mtex"))
        ]
        same = (pair[0] == pair[1]).all(axis=-1)
        assert all(same[i] for i, joint in enumerate(joints) if joint not in changed)
    assert not same.all() or changed


def test_results_carry_no_declarations(shot: Path) -> None:
    """Or a second run would edit what the first made."""
    stage = Usd.Stage.Open(str(mtex_usd.apply_edits(shot)[0].stage))
    for name in ("edited", "original"):
        select_variant(stage, MODEL, "mtex", name)
        prim = stage.GetPrimAtPath(f"{ANIMATION}_mtex")
        assert not [each for each in prim.GetPrimTypeInfo().GetAppliedAPISchemas() if each.startswith("Mtex")]


def test_a_second_run_gives_equal_bytes_and_keeps_the_selection(shot: Path) -> None:
    (layer, root) = {(result.layer, result.stage) for result in mtex_usd.apply_edits(shot)}.pop()
    first = {path.name: path.read_bytes() for path in shot.parent.iterdir()}
    mtex_usd.apply_edits(root)  # from the thin root: the original is edited, not the result
    assert {path.name: path.read_bytes() for path in shot.parent.iterdir()} == first
    thin = Sdf.Layer.FindOrOpen(str(root))
    Sdf.CreatePrimInLayer(thin, MODEL).variantSelections["mtex"] = "slower"
    thin.Save()
    mtex_usd.apply_edits(shot)
    assert variants_of(layer)[1] == "slower"
    stage = Usd.Stage.Open(str(root))
    assert stage.GetPrimAtPath(MODEL).GetVariantSet("mtex").GetVariantSelection() == "slower"
    mtex_usd.apply_edits(shot, select="original")
    assert variants_of(layer)[1] == "original"


def test_a_selection_whose_stack_is_gone_falls_to_the_first(shot: Path) -> None:
    layer = mtex_usd.apply_edits(shot, select="slower")[0].layer
    write_shot(shot.parent, STACKS.replace("mtex:edits:slower", "mtex:edits:late"), NAMES)
    mtex_usd.apply_edits(shot)
    assert variants_of(layer) == (["edited", "late", "original", "other"], "edited")


# --- layers that move time ---


TIMED = """
    uniform token[] mtex:edits = ["warp", "raise", "calm"]
    uniform token[] mtex:edits:looped = ["loop"]
    uniform token mtex:edit:warp:op = "warpTime"
    uniform timecode[] mtex:edit:warp:from = [0, 20, 59]
    uniform timecode[] mtex:edit:warp:to = [0, 24.5, 59]
    uniform timecode mtex:edit:warp:end = 49
    uniform token mtex:edit:raise:op = "displace"
    uniform timecode[] mtex:edit:raise:keys = [10, 30]
    rel mtex:edit:raise:with = </Takes/Other>
    uniform token mtex:edit:calm:op = "blend"
    rel mtex:edit:calm:with = </Takes/Other>
    uniform double[] mtex:edit:calm:weights = [0, 1, 0.5]
    uniform timecode[] mtex:edit:calm:keys = [5, 20, 30]
    uniform timecode mtex:edit:calm:start = 12
    uniform timecode mtex:edit:calm:end = 40
    uniform double mtex:edit:calm:ramp = 0
    uniform token mtex:edit:loop:op = "join"
    uniform timecode mtex:edit:loop:start = 30
    uniform timecode mtex:edit:loop:end = 59
"""
RETARGETED = "".join(f"rel mtex:edit:{name}:with = </Takes/Other>\n" for name in ("raise", "calm"))
HEADER = "#usda 1.0\n(\n timeCodesPerSecond = {rate}\n framesPerSecond = 24\n metersPerUnit = 0.01\n upAxis = 'Y'\n"


def write_timed(folder: Path) -> None:
    """Write ``edits.usda``, with edits that name times."""
    write_shot(folder, TIMED, ("warp", "raise", "calm", "loop"), name="edits.usda")


def write_moved(folder: Path, *, how: str, offset: float, rate: float) -> Path:
    """Write a shot that has the animation and its edits in a sublayer or by references that are moved in time."""
    moved = f"(offset = {offset})"
    header = HEADER.format(rate=rate)
    shot = folder / f"{how}.usda"
    if how == "sublayer":
        shot.write_text(f"{header} subLayers = [@./edits.usda@ {moved}]\n)\n", encoding="utf-8")
        return shot
    # A reference to /Hero alone drops the targets outside it, so they are named again.
    bodies = {"Hero": f'over "Walk"\n{{\n{RETARGETED}}}', "Takes": ""}
    prims = [
        f'def "{name}" (\n prepend references = @./edits.usda@</{name}> {moved}\n)\n{{\n{body}\n}}\n'
        for name, body in bodies.items()
    ]
    shot.write_text(f"{header})\n{''.join(prims)}", encoding="utf-8")
    return shot


@pytest.mark.parametrize("how", ["sublayer", "reference"])
@pytest.mark.parametrize(("offset", "rate"), [(100.0, 24.0), (-37.0, 24.0), (-37.5, 24.0), (10.0, 48.0), (3.0, 120.0)])
def test_edits_move_with_the_animation(tmp_path: Path, how: str, offset: float, rate: float) -> None:
    """What is done to which pose stays the same, wherever in time a layer puts the motion.

    USD scales by the rates of layer and stage by itself.
    """
    scale = rate / 24.0
    write_timed(tmp_path)
    plain = by_variant(mtex_usd.apply_edits(tmp_path / "edits.usda"))
    shot = write_moved(tmp_path, how=how, offset=offset, rate=rate)
    moved = by_variant(mtex_usd.apply_edits(shot))
    assert set(moved) == {"edited", "looped"}
    for name, result in plain.items():
        times = result.clip.time_codes
        np.testing.assert_allclose(moved[name].clip.time_codes[[0, -1]], offset + scale * times[[0, -1]], atol=1e-9)
        played = play(moved[name].stage, (offset + scale * times).tolist(), name)
        np.testing.assert_allclose(played, play(result.stage, times.tolist(), name), atol=5e-4)


# --- motions from elsewhere ---

HALF = """
    uniform token[] mtex:edits = ["half"]
    uniform token mtex:edit:half:op = "blend"
    rel mtex:edit:half:with = <%s>
    uniform double[] mtex:edit:half:weights = [%s]
"""


def add_take(folder: Path, clip: Clip, *, bound: bool, name: str = "Foreign") -> None:
    """Add a take to ``base.usda``, with a Skeleton of its own or none."""
    support.write_base(folder)
    stage = Usd.Stage.Open(str(folder / "base.usda"))
    support.write_animation(stage, f"/Takes/{name}", clip)
    if bound:
        support.write_skeleton(stage, f"/Takes/{name}Rig", clip.skeleton, f"/Takes/{name}")
    stage.Save()


def blend_with(folder: Path, clip: Clip, weight: float, *, bound: bool) -> tuple[Clip, Clip]:
    """Blend the walk with a take; gives the walk and the result."""
    add_take(folder, clip, bound=bound)
    shot = write_shot(folder, HALF % ("/Takes/Foreign", weight), ["half"])
    (result,) = mtex_usd.apply_edits(shot)
    return read(shot), result.clip


ORDER = tuple(sorted(JOINTS, key=lambda joint: (joint.count("/"), joint)))


@pytest.mark.parametrize("bound", [True, False])
def test_joints_in_another_order(tmp_path: Path, bound: bool) -> None:
    other = walk(FRAMES, seed=7)
    assert other.joints != ORDER
    clip, result = blend_with(tmp_path, on_joints(other, ORDER), 1.0, bound=bound)
    np.testing.assert_allclose(angles(result, other)[:, 1:], 0.0, atol=0.01)
    assert result.joints == clip.joints


@pytest.mark.parametrize("bound", [True, False])
def test_displacing_towards_a_take_with_joints_in_another_order(tmp_path: Path, bound: bool) -> None:
    other = walk(FRAMES, seed=7)
    add_take(tmp_path, on_joints(other, ORDER), bound=bound)
    body = HALF.replace('"blend"', '"displace"').replace(
        "double[] mtex:edit:half:weights", "timecode[] mtex:edit:half:keys"
    )
    shot = write_shot(tmp_path, body % ("/Takes/Foreign", 20), ["half"])
    (result,) = mtex_usd.apply_edits(shot)
    assert angles(result.clip, other)[20].max() < 0.01
    assert angles(read(shot), other)[20].max() > 5.0


def test_a_take_on_a_skeleton_with_other_axes_is_retargeted(tmp_path: Path) -> None:
    other = walk(FRAMES, seed=7, skeleton=make_skeleton(oriented=5))
    clip, result = blend_with(tmp_path, other, 1.0, bound=True)
    assert angles(clip, other).max() > 60.0  # the same movement, in other numbers
    turns = skeleton_turns(result), skeleton_turns(other)
    legs = [i for i, joint in enumerate(clip.joints) if joint.endswith(("Leg", "Arm"))]
    apart = 2.0 * np.degrees(np.arccos(np.clip(np.abs((turns[0] * turns[1]).sum(-1)), 0.0, 1.0)))[:, legs]
    assert np.median(apart) < 3.0


def test_a_take_on_a_smaller_skeleton_leaves_the_bones_as_long_as_they_are(tmp_path: Path) -> None:
    small = {joint: tuple(0.5 * x for x in place) for joint, place in POSITIONS.items()}
    other = walk(FRAMES, seed=7, skeleton=make_skeleton(positions=small))
    other = replace(other, translations=0.5 * walk(FRAMES, seed=7).translations)
    clip, result = blend_with(tmp_path, other, 0.5, bound=True)
    np.testing.assert_allclose(
        np.linalg.norm(result.translations[:, 1:], axis=-1), np.linalg.norm(clip.translations[:, 1:], axis=-1), atol=0.1
    )
    height = clip.translations[:, 0, 1].mean()
    assert result.translations[:, 0, 1].mean() == pytest.approx(height, abs=0.05 * height)


@pytest.mark.parametrize("bound", [True, False])
def test_joints_that_the_other_lacks_move_as_before(tmp_path: Path, bound: bool) -> None:
    other = walk(FRAMES, seed=7)
    some = tuple(joint for joint in other.joints if "Arm" not in joint)
    clip, result = blend_with(tmp_path, on_joints(other, some), 0.5, bound=bound)
    arms = [i for i, joint in enumerate(clip.joints) if "Arm" in joint]
    legs = [i for i, joint in enumerate(clip.joints) if "Leg" in joint]
    assert angles(result, clip)[:, arms].max() < 1e-3
    assert angles(result, clip)[:, legs].max() > 3.0


def angles(one: Clip, two: Clip) -> np.ndarray:
    """Degrees between the joints of clips on the same joints, [F, J]."""
    cosine = np.abs((one.rotations * two.rotations).sum(axis=-1))
    return 2.0 * np.degrees(np.arccos(np.clip(cosine, 0.0, 1.0)))


BEFORE = """
    uniform token[] mtex:edits:before = ["quick"]
    uniform token mtex:edit:quick:op = "scaleTime"
    uniform double mtex:edit:quick:factor = 0.5
    uniform timecode mtex:edit:quick:end = 59
    uniform token mtex:edit:quick:ends = "loop"
"""


def test_others_are_edited_before(tmp_path: Path) -> None:
    shot = write_shot(tmp_path, HALF % (OTHER, 1.0), ["half"], more=support.declare(OTHER, BEFORE, ["quick"]))
    (result,) = mtex_usd.apply_edits(shot)
    clip = walk(FRAMES, seed=2)
    quick = edit.scale_time(clip, factor=0.5, frame_count=FRAMES, ends="loop")
    np.testing.assert_allclose(angles(result.clip, quick)[:, 1:], 0.0, atol=0.01)
    assert angles(quick, clip)[:, 1:].max() > 5.0


def test_circles_are_refused(tmp_path: Path) -> None:
    """The other's edits need a blend with the walk, whose own edits need the other."""
    circle = BEFORE.replace('"scaleTime"', '"blend"').split("uniform double")[0]
    circle += "rel mtex:edit:quick:with = <%s>\n uniform double[] mtex:edit:quick:weights = [0.5]\n"
    before = HALF.replace("mtex:edits =", "mtex:edits:before =") + 'uniform token[] mtex:edits = ["half"]'
    more = support.declare(OTHER, circle % ANIMATION, ["quick"])
    shot = write_shot(tmp_path, before % (OTHER, 0.5), ["half"], more=more)
    with pytest.raises(
        InputError, match=r"its edits need themselves; found /Takes/Other -> /Hero/Walk -> /Takes/Other"
    ):
        mtex_usd.apply_edits(shot)


def test_a_circle_of_one_is_refused(tmp_path: Path) -> None:
    circle = BEFORE.replace('"scaleTime"', '"blend"').split("uniform double")[0]
    circle += f"rel mtex:edit:quick:with = <{OTHER}>\n uniform double[] mtex:edit:quick:weights = [0.5]\n"
    shot = write_shot(tmp_path, HALF % (OTHER, 0.5), ["half"], more=support.declare(OTHER, circle, ["quick"]))
    with pytest.raises(InputError, match=r"its edits need themselves; found /Takes/Other -> /Takes/Other"):
        mtex_usd.apply_edits(shot)


@pytest.mark.parametrize("target", ["", f"rel mtex:edit:loop:with = <{ANIMATION}>"])
def test_joining_an_animation_with_itself_closes_a_loop(tmp_path: Path, target: str) -> None:
    body = f'uniform token[] mtex:edits = ["loop"]\nuniform token mtex:edit:loop:op = "join"\n{target}'
    shot = write_shot(tmp_path, body, ["loop"])
    (result,) = mtex_usd.apply_edits(shot)
    clip = read(shot)
    expected = edit.join(clip, clip).clip
    assert result.clip.rotations.tobytes() == expected.rotations.tobytes()
    assert result.clip.frame_count < FRAMES
    first, last = result.clip.rotations[0, 1:], result.clip.rotations[-1, 1:]
    assert np.abs((first * last).sum(axis=-1)).min() > 1.0 - 1e-9


def test_blending_an_animation_with_itself_is_itself(tmp_path: Path) -> None:
    shot = write_shot(tmp_path, HALF % (ANIMATION, 0.5), ["half"])
    (result,) = mtex_usd.apply_edits(shot)
    assert angles(result.clip, read(shot)).max() < 1e-5


# --- keys ---

FEW = """
    uniform token[] mtex:edits = ["calm", "few"]
    uniform token[] mtex:edits:all = ["calm"]
    uniform token mtex:edit:calm:op = "lowpass"
    uniform double[] mtex:edit:calm:frequencies = [3]
    uniform token mtex:edit:few:op = "reduceKeys"
    uniform token mtex:edit:few:form = "poses"
    uniform double mtex:edit:few:tolerance = 1
    uniform double mtex:edit:few:distance = 0.01
    uniform timecode[] mtex:edit:few:keys = [17, 43]
"""


def test_poses_play_within_tolerance_at_sub_frames(tmp_path: Path) -> None:
    """What is written are the poses alone; UsdSkel's own slerp between them stays within both tolerances."""
    found = by_variant(mtex_usd.apply_edits(write_shot(tmp_path, FEW, ["calm", "few"])))
    few = found["edited"]
    stage = Usd.Stage.Open(str(few.stage))
    times = stage.GetPrimAtPath(f"{ANIMATION}_mtex").GetAttribute("rotations").GetTimeSamples()
    assert isinstance(few.keys, edit.ReducedPoses)
    assert times == few.keys.time_codes.tolist()
    assert {0.0, 17.0, 43.0, 59.0} <= set(times)
    assert len(times) < 0.75 * FRAMES
    sub_frames = np.linspace(0.0, 59.0, 59 * 5 + 1).tolist()
    whole, sparse = (play(few.stage, sub_frames, name) for name in ("all", "edited"))
    assert degrees_between(whole, sparse).max() <= 1.0 + 2e-3
    places = [place_matrices(few.clip.parents.tolist(), poses) for poses in (whole, sparse)]
    assert np.linalg.norm(places[0] - places[1], axis=-1).max() <= 1.0 + 1e-2


def degrees_between(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Angles between the rotations of matrices; from their difference, since an arc cosine loses small ones."""
    apart = np.linalg.norm(one[..., :3, :3] - two[..., :3, :3], axis=(-2, -1)) / np.sqrt(8.0)
    return 2.0 * np.degrees(np.arcsin(np.clip(apart, 0.0, 1.0)))


def place_matrices(parents: list[int], poses: np.ndarray) -> np.ndarray:
    """Where the joints of local matrices [F, J, 4, 4] are, [F, J, 3]."""
    world = np.array(poses)
    for joint, parent in enumerate(parents):
        if parent >= 0:
            world[:, joint] = poses[:, joint] @ world[:, parent]
    return world[..., 3, :3]


@pytest.mark.parametrize(("contacts", "kept"), [("declared", True), ("off", False)])
def test_borders_of_declared_contacts_are_kept(tmp_path: Path, contacts: str, kept: bool) -> None:
    contact = """
    uniform token mtex:contact:hand:joint = "LeftForeArm"
    uniform timecode[] mtex:contact:hand:intervals = [11, 12, 36, 37]
"""
    body = FEW.replace('["calm", "few"]', '["few"]').replace("tolerance = 1", "tolerance = 20").replace("0.01", "0.2")
    body += f'{contact}\nuniform token mtex:edit:few:contacts = "{contacts}"'
    shot = write_shot(tmp_path, body, ["calm", "few"], schemas=["MtexContactAPI:hand"])
    keys = by_variant(mtex_usd.apply_edits(shot))["edited"].keys
    assert ({11, 12, 36, 37} <= set(keys.frames.tolist())) == kept


def test_poses_between_which_something_is_edited_are_samples_again(tmp_path: Path) -> None:
    body = FEW.replace('["calm", "few"]', '["few", "calm"]')
    found = by_variant(mtex_usd.apply_edits(write_shot(tmp_path, body, ["calm", "few"])))
    assert found["edited"].keys is None
    stage = Usd.Stage.Open(str(found["edited"].stage))
    assert len(stage.GetPrimAtPath(f"{ANIMATION}_mtex").GetAttribute("rotations").GetTimeSamples()) == FRAMES


CAPTURE = """#usda 1.0
(
    subLayers = [@./walk.usd@]
    timeCodesPerSecond = 120
    framesPerSecond = 120
    metersPerUnit = 0.05644
    upAxis = "Y"
)
over "Walk"
{
    over "walk" (
        prepend apiSchemas = ["MtexEditStackAPI", "MtexEditAPI:curves", "MtexEditAPI:poses", "MtexEditAPI:calm"]
    )
    {
        uniform token[] mtex:edits:few = ["calm", "poses"]
        uniform token mtex:edit:calm:op = "lowpass"
        uniform double[] mtex:edit:calm:frequencies = [6]
        uniform token[] mtex:edits:curves = ["curves"]
        uniform token[] mtex:edits:poses = ["poses"]
        uniform token mtex:edit:curves:op = "reduceKeys"
        uniform token mtex:edit:poses:op = "reduceKeys"
        uniform token mtex:edit:poses:form = "poses"
    }
}
"""


@pytest.fixture(scope="module")
def capture(data_dir: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Reduce CMU 07_01 with the tolerances that the schema falls back to, half a degree and 5 mm."""
    folder = tmp_path_factory.mktemp("capture")
    mtex_usd.write_clip(load(data_dir, "07_01"), folder / "walk.usd", "/Walk/walk")
    (folder / "shot.usda").write_text(CAPTURE, encoding="utf-8")
    return by_variant(mtex_usd.apply_edits(folder / "shot.usda"))


@pytest.mark.parametrize("variant", ["curves", "poses"])
def test_reduced_captures_play_within_tolerance_at_sub_frames(capture: dict[str, Any], variant: str) -> None:
    """Against the capture itself, both through UsdSkel, at every quarter of a frame."""
    result, times = capture[variant], capture[variant].clip.time_codes
    sub_frames = np.linspace(times[0], times[-1], 4 * (len(times) - 1) + 1).tolist()
    named = {"skeleton": "/Walk/Skeleton", "model": "/Walk"}
    whole, reduced = (play(result.stage, sub_frames, name, **named) for name in ("original", variant))
    assert degrees_between(whole, reduced).max() <= 0.5 + 2e-3
    places = [place_matrices(result.clip.parents.tolist(), poses) for poses in (whole, reduced)]
    assert np.linalg.norm(places[0] - places[1], axis=-1).max() * 0.05644 <= 0.005 + 2e-5
    assert np.abs(whole - reduced).max() > 1e-4


def test_reduced_captures_have_few_poses(capture: dict[str, Any]) -> None:
    """Once what shakes in the fingers is out; as recorded they leave almost every frame."""
    stage = Usd.Stage.Open(str(capture["few"].stage))
    select_variant(stage, "/Walk", "mtex", "few")
    times = stage.GetPrimAtPath("/Walk/walk_mtex").GetAttribute("rotations").GetTimeSamples()
    assert len(times) == len(capture["few"].keys.frames) <= 0.4 * capture["few"].clip.frame_count


def test_scales_are_mirrored_too(tmp_path: Path) -> None:
    """Whatever the operation changed is written."""
    support.write_base(tmp_path)
    stage = Usd.Stage.Open(str(tmp_path / "base.usda"))
    attribute = stage.GetPrimAtPath(ANIMATION).GetAttribute("scales")
    joints = list(stage.GetPrimAtPath(ANIMATION).GetAttribute("joints").Get())
    sizes = np.array(attribute.Get())
    sizes[joints.index(LEFT_ARM)] = 2.0
    attribute.Set(Vt.Vec3hArray.FromNumpy(sizes.astype(np.float16)))
    stage.Save()
    body = 'uniform token[] mtex:edits = ["e"]\nuniform token mtex:edit:e:op = "mirror"'
    (result,) = mtex_usd.apply_edits(write_shot(tmp_path, body))
    np.testing.assert_allclose(play(result.stage, range(FRAMES), "edited"), play_clip(result.clip), atol=5e-4)
    stage = Usd.Stage.Open(str(result.stage))
    written = stage.GetPrimAtPath(f"{ANIMATION}_mtex").GetAttribute("scales").Get(10.0)
    big = [joint for joint, size in zip(joints, written, strict=True) if size[0] == 2.0]
    assert big == [RIGHT_ARM]


# --- before and after texturing ---

SKETCH = """
    rel mtex:takes = </Takes/Other>
    uniform token[] mtex:match = ["LeftUpLeg.rx"]
    uniform token[] mtex:texture = ["LeftUpLeg.rx"]
    uniform token[] mtex:synthesize = ["LeftArm", "RightArm"]
"""
AFTER = """
    uniform token[] mtex:edits:after = ["slow", "calm"]
    uniform token mtex:edit:slow:op = "scaleTime"
    uniform double mtex:edit:slow:factor = 1.5
    uniform token mtex:edit:calm:op = "lowpass"
    uniform double[] mtex:edit:calm:frequencies = [2]
"""


def write_sketch(folder: Path, body: str, edits: tuple[str, ...], *, more: str = "", name: str = "shot.usda") -> Path:
    if not (folder / "base.usda").exists():
        support.write_base(folder, take_frames=240)
    return write_shot(folder, body, edits, more=more, name=name, schemas=("MtexSketchAPI",))


def assert_same_variants(one: Any, two: Any) -> None:
    for mine, theirs in zip(one.variants, two.variants, strict=True):
        for fragment, other in zip(mine.fragments, theirs.fragments, strict=True):
            assert {**fragment, "distance": pytest.approx(fragment.distance)} == dict(other)
        np.testing.assert_allclose(mine.clip.rotations, theirs.clip.rotations, atol=1e-5)
        np.testing.assert_allclose(mine.clip.translations, theirs.clip.translations, atol=1e-3)


def test_edits_after_are_made_of_every_version(tmp_path: Path) -> None:
    (plain,) = mtex_usd.process(write_sketch(tmp_path, SKETCH, (), name="plain.usda"), paths=2)
    (result,) = mtex_usd.process(write_sketch(tmp_path, SKETCH + AFTER, ("slow", "calm")), paths=2)
    for before, after in zip(plain.variants, result.variants, strict=True):
        expected = edit.lowpass(edit.scale_time(before.clip, factor=1.5), frequency=2.0)
        assert after.clip.rotations.tobytes() == expected.rotations.tobytes()
        assert after.clip.frame_count == 89
        played = play(result.stage, after.clip.time_codes.tolist(), after.name)
        np.testing.assert_allclose(played, play_clip(expected), atol=2e-4)
    assert Usd.Stage.Open(str(result.stage)).GetEndTimeCode() == 88.0


def test_keys_after_texturing(tmp_path: Path) -> None:
    body = SKETCH + AFTER.replace('"slow", "calm"', '"few"') + FEW.split('"lowpass"')[1].split("frequencies = [3]")[1]
    (result,) = mtex_usd.process(write_sketch(tmp_path, body, ("slow", "calm", "few")), paths=2)
    stage = Usd.Stage.Open(str(result.stage))
    for variant in result.variants:
        select_variant(stage, MODEL, "mtex", variant.name)
        times = stage.GetPrimAtPath(f"{ANIMATION}_mtex").GetAttribute("rotations").GetTimeSamples()
        assert {0.0, 17.0, 43.0, 59.0} <= set(times)
        assert len(times) < FRAMES


@pytest.mark.parametrize("on", ["take", "sketch"])
def test_edits_before_are_made_of_takes(tmp_path: Path, on: str) -> None:
    """As if the takes had been edited by hand and written."""
    if on == "take":
        shot = write_sketch(tmp_path, SKETCH, (), more=support.declare(OTHER, BEFORE_LONG, ["quick"]))
    else:
        shot = write_sketch(tmp_path, SKETCH + BEFORE_LONG, ("quick",))
    (result,) = mtex_usd.process(shot, paths=2)
    by_hand = tmp_path / "by_hand"
    by_hand.mkdir()
    support.write_base(by_hand, take_frames=240)
    stage = Usd.Stage.Open(str(by_hand / "base.usda"))
    stage.RemovePrim(OTHER)
    support.write_animation(stage, OTHER, edit.scale_time(walk(240, seed=2), factor=0.5))
    stage.Save()
    (expected,) = mtex_usd.process(write_sketch(by_hand, SKETCH, ()), paths=2)
    assert_same_variants(result, expected)
    (untouched,) = mtex_usd.process(write_sketch(tmp_path, SKETCH, (), name="plain.usda"), paths=2)
    assert np.abs(untouched.variants[0].clip.rotations - result.variants[0].clip.rotations).max() > 0.01


BEFORE_LONG = BEFORE.split("    uniform timecode", maxsplit=1)[0]


def test_edits_before_with_another_motion_on_takes_of_another_skeleton(tmp_path: Path) -> None:
    """The sketch's edits bring a motion on its joints; its takes may have others."""
    support.write_base(tmp_path, take_frames=240)
    stage = Usd.Stage.Open(str(tmp_path / "base.usda"))
    foreign = walk(240, seed=9, skeleton=make_skeleton(oriented=5))
    support.write_animation(stage, "/Takes/Foreign", foreign)
    support.write_skeleton(stage, "/Takes/ForeignRig", foreign.skeleton, "/Takes/Foreign")
    stage.Save()
    body = SKETCH.replace("</Takes/Other>", "[</Takes/Other>, </Takes/Foreign>]") + HALF.replace(
        "edits =", "edits:before ="
    )
    shot = write_sketch(tmp_path, body % (OTHER, 0.5), ("half",))
    (result,) = mtex_usd.process(shot, paths=2)
    assert len(result.variants) == 2


# --- what is refused ---


@pytest.mark.parametrize(
    ("body", "error", "message"),
    [
        (
            STACKS.replace('"lowpass"', '"smooth"'),
            InputError,
            r"/Hero/Walk\.mtex:edit:calm:op is not allowed; .*found smooth",
        ),
        (
            STACKS + "uniform double mtex:edit:calm:factor = 2",
            InputError,
            r"/Hero/Walk: edit calm \(lowpass\): it takes no factor; expected only frequencies, channels, order",
        ),
        (
            STACKS.replace("uniform double[] mtex:edit:calm:frequencies = [1.5]", ""),
            InputError,
            r"/Hero/Walk: edit calm \(lowpass\): frequencies is not said",
        ),
        (
            STACKS.replace("</Takes/Other>", "[]"),
            InputError,
            r"edit half \(blend\): with does not fit; expected 1 or more",
        ),
        (
            STACKS.replace("</Takes/Other>", "</Hero/Rig>"),
            StageError,
            r"edit:half:with names no animation; .*/Hero/Rig, Skel",
        ),
        (STACKS.replace('["*Arm"]', '["Tail"]'), InputError, r"/Hero/Walk: edit calm \(lowpass\): .*Tail"),
        (
            STACKS.replace('"calm", "raise"', '"calm", "gone"'),
            InputError,
            r"names an edit that is not there.*found gone",
        ),
        (STACKS.replace("mtex:edits:other", "mtex:edits:original"), InputError, r"cannot be the name of a stack"),
        (STACKS.replace("= [30]", "= [nan]"), InputError, r"mtex:edit:raise:keys is not allowed; expected finite time"),
        (STACKS.replace("factor = 1.5", "factor = 1e9"), InputError, r"edit slow \(scaleTime\): .*too many frames"),
        ("uniform token[] mtex:edits = []", StageError, r"no animation to edit; .*found /Hero/Walk, /Takes/Other"),
    ],
)
def test_refusals(tmp_path: Path, body: str, error: type[Exception], message: str) -> None:
    shot = write_shot(tmp_path, body, NAMES)
    before = sorted(tmp_path.iterdir())
    with pytest.raises(error, match=message):
        mtex_usd.apply_edits(shot)
    assert sorted(tmp_path.iterdir()) == before


def test_the_last_of_several_animations_is_checked_before_anything_is_written(tmp_path: Path) -> None:
    shot = write_shot(tmp_path, STACKS, NAMES)
    before = sorted(tmp_path.iterdir())
    with pytest.raises(StageError, match=r"/Takes/Other has no stack of edits; expected MtexEditStackAPI"):
        mtex_usd.apply_edits(shot, anim=[ANIMATION, OTHER])
    assert sorted(tmp_path.iterdir()) == before


def test_takes_with_stacks_that_nobody_plays_are_left_out(tmp_path: Path) -> None:
    """The stack came along with the reference to a take of a library, which has it as well."""
    body = 'uniform token[] mtex:edits = ["e"]\nuniform token mtex:edit:e:op = "mirror"'
    shot = write_shot(tmp_path, body, more=support.declare(OTHER, body, ["e"]))
    (result,) = mtex_usd.apply_edits(shot)
    assert result.anim == ANIMATION
    assert result.notes == ("/Takes/Other is left out: no Skeleton plays /Takes/Other",)
    with pytest.raises(StageError, match=r"no Skeleton plays /Takes/Other"):
        mtex_usd.apply_edits(shot, anim=OTHER)


def test_stacks_that_nobody_plays_at_all(tmp_path: Path) -> None:
    body = 'uniform token[] mtex:edits = ["e"]\nuniform token mtex:edit:e:op = "mirror"'
    shot = write_shot(tmp_path, "", (), more=support.declare(OTHER, body, ["e"]))
    with pytest.raises(StageError, match=r"no Skeleton plays /Takes/Other; expected a bound Skeleton"):
        mtex_usd.apply_edits(shot)


def test_blend_shapes_that_do_not_come_along_are_noted(tmp_path: Path) -> None:
    support.write_base(tmp_path)
    stage = Usd.Stage.Open(str(tmp_path / "base.usda"))
    face = UsdSkel.Animation(stage.GetPrimAtPath(ANIMATION))
    face.CreateBlendShapesAttr(["smile"])
    weights = face.CreateBlendShapeWeightsAttr()
    weights.Set([0.0], 0.0)
    weights.Set([1.0], 59.0)
    stage.Save()
    found = by_variant(mtex_usd.apply_edits(write_shot(tmp_path, STACKS, NAMES)))
    note = "blend shapes keep their times: slow moves joints alone"
    assert [name for name, result in found.items() if note in result.notes] == ["slower"]
    stage = Usd.Stage.Open(str(found["slower"].stage))
    assert list(stage.GetPrimAtPath(f"{ANIMATION}_mtex").GetAttribute("blendShapeWeights").Get(59.0)) == [1.0]


def test_two_characters_with_one_animation_get_a_set_each(tmp_path: Path) -> None:
    support.write_base(tmp_path)
    stage = Usd.Stage.Open(str(tmp_path / "base.usda"))
    Usd.ModelAPI(UsdSkel.Root.Define(stage, "/Villain").GetPrim()).SetKind("component")
    support.write_skeleton(stage, "/Villain/Rig", make_skeleton(), ANIMATION)
    stage.Save()
    results = mtex_usd.apply_edits(write_shot(tmp_path, STACKS, NAMES))
    assert {result.model for result in results} == {"/Hero", "/Villain"}
    expected = play(results[0].stage, [10.0, 40.0], "edited")
    stage = Usd.Stage.Open(str(results[0].stage))
    select_variant(stage, MODEL, "mtex", "original")
    query = skeleton_query(stage, "/Villain/Rig")
    played = [[np.array(m) for m in query.ComputeJointLocalTransforms(time)] for time in (10.0, 40.0)]
    np.testing.assert_array_equal(played, expected)


@pytest.mark.parametrize("how", ["references", "payload", "instances"])
def test_edits_that_come_with_an_asset(tmp_path: Path, how: str) -> None:
    write_shot(
        tmp_path, STACKS.replace('mtex:edits:other = ["half"]', "mtex:edits:other = []"), NAMES, name="asset.usda"
    )
    arc = "payload" if how == "payload" else "references"
    meta = f"(prepend {arc} = @./asset.usda@</Hero>\n{'instanceable = true' if how == 'instances' else ''})"
    text = HEADER.format(rate=24.0) + ")\n" + "".join(f'def "{name}" {meta}\n{{\n}}\n' for name in ("Hero", "Twin"))
    (tmp_path / "shot.usda").write_text(text, encoding="utf-8")
    found = [result for result in mtex_usd.apply_edits(tmp_path / "shot.usda") if result.model == MODEL]
    assert [result.variant for result in found] == ["edited", "slower"]
    for result in found:
        times = result.clip.time_codes.tolist()
        np.testing.assert_allclose(play(result.stage, times, result.variant), play_clip(result.clip), atol=2e-4)
