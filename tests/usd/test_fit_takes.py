"""Takes on characters of other skeletons: pairs on sketch and take, and what plays is what was computed."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, Vt

import mtex_usd
from mtex_usd.cli.usdmtex import main
from mtex_usd.constraints.retargeting import FittedTake, retarget
from mtex_usd.errors import InputError
from mtex_usd.usd.fit_takes import fit_takes
from tests.anatomy_support import rename_joints
from tests.retargeting_support import HUMAN, angle_apart, direction, human, last, lowered, move
from tests.synthetic import block, walk
from tests.usd.playback import local_transforms, no_diagnostics, select_variant, transform
from tests.usd.schema_support import open_text

TAIL = {"tail1": ("hips", (0.0, 0.9, -0.2)), "tail2": ("tail1", (0.0, 0.8, -0.4))}
FLUKE = {"fluke1": ("hips", (0.1, 0.9, -0.2)), "fluke2": ("fluke1", (0.3, 0.8, -0.4))}
NAMES = ("with", "without")


def moving(body: dict[str, object], seed: int) -> mtex_usd.Clip:
    return move(human(body, seed=seed), np.random.default_rng(seed))


def fit(*, sketch: tuple[str, ...] = (), takes: tuple[tuple[str, ...], ...] = ((), ())) -> tuple[FittedTake, ...]:
    """Fit a take with a fluke and one without to a character with a tail, with these names in their pairs."""
    own = dict(zip(NAMES, takes, strict=True))
    text = "\n".join(
        f'def SkelAnimation "{name}" (prepend apiSchemas = ["MtexRetargetAPI"])\n'
        f"{{\nuniform token[] mtex:retarget:pairs = [{', '.join(map(_quote, pairs))}]\n}}"
        for name, pairs in {"sketch": sketch, **own}.items()
    )
    stage = open_text(text)
    clips = [moving({**HUMAN, **FLUKE}, 1), moving(HUMAN, 2)]
    prims = [stage.GetPrimAtPath(f"/{name}") for name in NAMES]
    return fit_takes(stage.GetPrimAtPath("/sketch"), moving({**HUMAN, **TAIL}, 3), prims, clips)


def _quote(name: str) -> str:
    return f'"{name}"'


def mapped(fitted: FittedTake) -> dict[str, list[str]]:
    assert fitted.joint_map is not None
    return {last(joint): [last(other) for other in by] for joint, by in fitted.joint_map.mapped.items()}


def test_without_pairs_takes_of_the_same_names_are_left_alone() -> None:
    assert [take.joint_map for take in fit()] == [None, None]


def test_pairs_on_the_sketch_are_for_the_takes_that_have_the_joints() -> None:
    first, second = fit(sketch=("tail1", "fluke1", "tail2", "fluke2"))
    assert (mapped(first)["tail1"], mapped(first)["tail2"]) == (["fluke1"], ["fluke2"])
    assert (
        angle_apart(
            direction(first.clip, "tail1", "tail2"), direction(moving({**HUMAN, **FLUKE}, 1), "fluke1", "fluke2")
        )
        < 1e-9
    )
    assert second.joint_map is None


def test_pairs_on_a_take_are_for_that_take() -> None:
    first, second = fit(takes=((), ("head", "neck")))
    assert first.joint_map is None
    assert mapped(second)["head"] == ["neck"]


@pytest.mark.parametrize("spelling", ["head", "hips/spine/chest/neck/head"])
@pytest.mark.parametrize("own_spelling", ["head", "hips/spine/chest/neck/head"])
def test_a_take_is_stronger_than_the_sketch_however_a_joint_is_spelled(spelling: str, own_spelling: str) -> None:
    first, second = fit(sketch=(spelling, "neck"), takes=((own_spelling, "left.hand"), ()))
    assert mapped(first)["head"] == ["left.hand"]
    assert mapped(second)["head"] == ["neck"]


def test_a_joint_left_at_rest_is_so_for_all_takes() -> None:
    fitted = fit(sketch=("head", ""))
    assert ["head" in mapped(take) for take in fitted] == [False, False]
    assert all("head" not in map(last, take.clip.joints) for take in fitted)


def test_a_take_may_take_back_what_the_sketch_leaves_at_rest() -> None:
    first, second = fit(sketch=("head", ""), takes=(("head", "head"), ()))
    assert mapped(first)["head"] == ["head"]
    assert "head" not in mapped(second)


@pytest.mark.parametrize(
    ("sketch", "take", "message"),
    [
        (
            ("head", "nose"),
            (),
            r"^/sketch\.mtex:retarget:pairs: no take has a joint 'nose'; expected one of hips, spine",
        ),
        (
            ("nose", "head"),
            (),
            r"^/sketch\.mtex:retarget:pairs: the character has no joint 'nose'; expected one of hips",
        ),
        ((), ("head", "nose"), r"^/with: 'nose' names no joint to retarget; expected one of the joints hips, spine"),
        ((), ("nose", "head"), r"^/with: 'nose' names no joint to retarget"),
        ((), ("head", "fluke1", "neck/head", "fluke2"), r"^/with: 'neck/head' names no joint"),
        ((), ("head", "neck", "hips/spine/chest/neck/head", "head"), r"^/with: a joint is paired twice"),
        (("head",), (), r"^/sketch\.mtex:retarget:pairs: a joint lacks its partner"),
    ],
)
def test_names_that_are_not_there(sketch: tuple[str, ...], take: tuple[str, ...], message: str) -> None:
    with pytest.raises(InputError, match=message):
        fit(sketch=sketch, takes=(take, ()))


# Whole shots ---------------------------------------------------------------------------------------------------------

FRAMES = 72


def characters() -> dict[str, mtex_usd.Skeleton]:
    """Two characters of different joint names, orientations, builds and sizes, neither like the takes' skeleton."""
    other = rename_joints(human({**lowered(HUMAN, 50.0), **TAIL}, size=1.4, seed=2), lambda i, _: f"bone_{i}")
    return {"Ann": rename_joints(human(seed=1), lambda _, name: name.replace(".", "_")), "Bob": other}


def write_pair_shot(folder: Path) -> Path:
    """Write a shot with both characters, each walking with its legs alone, and one library of walks for both."""
    motions = [walk(240, seed=seed, name=f"/Takes/walk_{seed}") for seed in (1, 2)]
    for seed, motion in enumerate(motions, start=1):
        mtex_usd.write_clip(motion, folder / f"walk_{seed}.usd", f"/Takes{seed}/walk")
    stage = Usd.Stage.CreateNew(str(folder / "shot.usda"))
    stage.SetMetadata("upAxis", "Y")
    stage.SetMetadata("metersPerUnit", 0.01)
    stage.SetTimeCodesPerSecond(24)
    stage.SetEndTimeCode(FRAMES - 1)
    stage.DefinePrim("/Takes", "Scope")
    for seed in (1, 2):
        stage.DefinePrim(f"/Takes/Set{seed}").GetReferences().AddReference(f"./walk_{seed}.usd", f"/Takes{seed}")
    for name, skeleton in characters().items():
        _add_character(stage, folder, name, skeleton)
    stage.Save()
    return folder / "shot.usda"


def _add_character(stage: Usd.Stage, folder: Path, name: str, skeleton: mtex_usd.Skeleton) -> None:
    motion = retarget(walk(FRAMES, seed=7), skeleton)
    parts = part_joints(skeleton)
    legs = [skeleton.joints[parts[part]] for part in ("hips", "left.thigh", "left.shin", "right.thigh", "right.shin")]
    mtex_usd.write_clip(block(motion, legs), folder / f"{name}.usd", f"/{name}/Walk")
    prim = stage.DefinePrim(f"/{name}")
    prim.GetReferences().AddReference(f"./{name}.usd", f"/{name}")
    Usd.ModelAPI(prim).SetKind("component")
    sketch = stage.GetPrimAtPath(f"/{name}/Walk")
    sketch.AddAppliedSchema("MtexSketchAPI")
    sketch.CreateRelationship("mtex:takes").SetTargets(["/Takes"])
    roles = {
        "match": [f"{last(skeleton.joints[parts['left.thigh']])}.rx"],
        "synthesize": [last(skeleton.joints[parts[p]]) for p in ("left.upperArm", "left.foreArm", "right.upperArm")],
    }
    for role, tokens in roles.items():
        set_tokens(sketch, f"mtex:{role}", tokens)


def part_joints(skeleton: mtex_usd.Skeleton) -> dict[str, int]:
    """Joint by part: the order of joints is that of the body in either."""
    order = [last(joint) for joint in human({**HUMAN, **TAIL}).joints]
    return {part: order.index(part) for part in order if order.index(part) < len(skeleton.joints)}


def set_tokens(prim: Usd.Prim, name: str, tokens: list[str]) -> None:
    attribute = prim.CreateAttribute(name, Sdf.ValueTypeNames.TokenArray, False, Sdf.VariabilityUniform)
    attribute.Set(Vt.TokenArray(tokens))


@pytest.fixture
def shot(tmp_path: Path) -> Path:
    """Give the shot with two characters."""
    return write_pair_shot(tmp_path)


def test_characters_of_different_skeletons_share_a_library(shot: Path) -> None:
    with no_diagnostics():
        results = mtex_usd.process(shot, paths=2)
        stage = Usd.Stage.Open(str(results[0].stage))
    assert [result.anim for result in results] == ["/Ann/Walk", "/Bob/Walk"]
    for result in results:
        assert [retargeted.takes for retargeted in result.retargets] == [("/Takes/Set1/walk",), ("/Takes/Set2/walk",)]
        assert result.retargets[0].takeConvention == "MotionBuilder"
        for variant in result.variants:
            select_variant(stage, result.model, result.variantSet, variant.name)
            _assert_plays(stage, f"{result.model}/Skeleton", variant.motion.clip)
    assert [result.retargets[0].convention for result in results] == ["mixed", "hierarchy"]


def _assert_plays(stage: Usd.Stage, skeleton: str, clip: mtex_usd.Clip) -> None:
    for frame in (0, 31, clip.frame_count - 1):
        played = local_transforms(stage, skeleton, float(clip.time_codes[frame]))
        assert played.keys() == set(clip.joints)
        for j, joint in enumerate(clip.joints):
            wanted = transform(clip.rotations[frame, j], clip.translations[frame, j], clip.scales[frame, j])
            np.testing.assert_allclose(played[joint], wanted, atol=2e-5, err_msg=joint)


def test_arms_of_both_swing_as_a_takes_do(shot: Path) -> None:
    """The same legs and the same takes: both characters' arms point the same ways, whatever their rigs."""
    clips = [result.variants[0].clip for result in mtex_usd.process(shot, paths=1)]
    bones = []
    for clip in clips:
        parts = part_joints(clip.skeleton)
        places, _ = clip.skeleton.world_pose(clip.rotations, clip.translations)
        bone = places[:, parts["left.foreArm"]] - places[:, parts["left.upperArm"]]
        bones.append(bone / np.linalg.norm(bone, axis=-1, keepdims=True))
    assert bones[0].std(axis=0).max() > 0.05
    assert angle_apart(*bones) < np.radians(10.0)


@pytest.mark.parametrize("on", ["Ann", "Takes/Set1"])
def test_outputs_lose_the_retarget_schema(shot: Path, on: str) -> None:
    """A result is no sketch and no take: nothing of ours is applied to it."""
    stage = Usd.Stage.Open(str(shot))
    prim = stage.GetPrimAtPath(f"/{on}/{'Walk' if on == 'Ann' else 'walk'}")
    prim.AddAppliedSchema("MtexRetargetAPI")
    set_tokens(prim, "mtex:retarget:pairs", ["left_hand", "LeftForeArm"])
    stage.Save()
    result = mtex_usd.process(shot, paths=1, anim="/Ann/Walk")[0]
    assert any(joint.endswith("left_hand") for joint in result.retargets[0].mapped)
    played = Usd.Stage.Open(str(result.stage))
    for variant in ("original", "path_01"):
        select_variant(played, result.model, result.variantSet, variant)
        output = played.GetPrimAtPath("/Ann/Walk_mtex")
        assert output.GetTypeName() == "SkelAnimation"
        assert output.GetMetadata("apiSchemas").GetAppliedItems() == []


def test_the_command_names_a_pair_that_no_take_has(shot: Path, capsys: pytest.CaptureFixture[str]) -> None:
    stage = Usd.Stage.Open(str(shot))
    sketch = stage.GetPrimAtPath("/Ann/Walk")
    sketch.AddAppliedSchema("MtexRetargetAPI")
    set_tokens(sketch, "mtex:retarget:pairs", ["head", "antenna"])
    stage.Save()
    before = sorted(shot.parent.iterdir())
    assert main([str(shot)]) == 2
    message = capsys.readouterr().err
    assert "/Ann/Walk.mtex:retarget:pairs: no take has a joint 'antenna'; expected one of Hips, Spine" in message
    assert sorted(shot.parent.iterdir()) == before
