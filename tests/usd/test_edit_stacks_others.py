"""Edits with motions from elsewhere: joints in another order, other skeletons, and motions with edits of their own."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

import mtex_usd
from mtex_usd import edit
from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip
from tests.synthetic import JOINTS, POSITIONS, make_skeleton, on_joints, skeleton_turns, walk
from tests.usd import edit_support as support
from tests.usd.edit_support import ANIMATION, BEFORE, FRAMES, HALF, OTHER, angles, read, write_shot


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
