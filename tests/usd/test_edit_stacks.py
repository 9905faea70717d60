"""Stacks of edits on stages: what is written plays as computed and second runs keep what was chosen."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdSkel, Vt

import mtex_usd
from mtex_usd import edit
from mtex_usd.errors import StageError
from mtex_usd.usd.custom_data import from_metadata
from tests.synthetic import LEFT_ARM, RIGHT_ARM, make_skeleton
from tests.usd import edit_support as support
from tests.usd.edit_support import (
    ANIMATION,
    FRAMES,
    MODEL,
    NAMES,
    OTHER,
    STACKS,
    by_variant,
    play,
    play_clip,
    read,
    variants_of,
    write_shot,
)
from tests.usd.playback import no_diagnostics, select_variant, skeleton_query

RAISED = edit.Displacement(keys=[edit.PoseChange(frame=30, rotations={"LeftArm": (0, 0, 40)})], scope=(12.0, 12.0))


@pytest.fixture
def shot(tmp_path: Path) -> Path:
    return write_shot(tmp_path, STACKS, NAMES)


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
