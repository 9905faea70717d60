"""Flipped limbs are turned back, and only they."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.edit.cleaning import repair_flips
from mtex_usd.edit.cleaning.flips import find_flips, interpolate_swivel
from mtex_usd.edit.cleaning.limbs import captured_joints, find_limbs
from mtex_usd.motion import quaternion
from mtex_usd.motion.skeleton import Skeleton
from tests.cleaning_support import (
    LEFT_FOOT,
    LEFT_HAND,
    LEFT_TOE,
    RIGHT_FOOT,
    RIGHT_HAND,
    RIGHT_TOE,
    chain_of,
    changed_frames,
    flip,
    make_walk,
    positions,
)
from tests.synthetic import LEFT_ARM, LEFT_LEG, RIGHT_ARM, RIGHT_LEG, make_skeleton


def test_limbs_are_found_by_their_names():
    clip = make_walk(8)
    ends = [clip.joints[limb.end] for limb in find_limbs(clip.skeleton)]
    assert sorted(ends) == sorted([LEFT_FOOT, RIGHT_FOOT, LEFT_HAND, RIGHT_HAND])


@pytest.mark.parametrize("oriented", [None, 4])
def test_limbs_are_found_by_their_shape_where_names_say_nothing(oriented):
    skeleton = make_walk(8, oriented=oriented).skeleton
    numbers = {joint.rpartition("/")[2]: f"j{i}" for i, joint in enumerate(skeleton.joints)}
    joints = tuple("/".join(numbers[name] for name in joint.split("/")) for joint in skeleton.joints)
    assert find_limbs(replace(skeleton, joints=joints)) == find_limbs(skeleton)


@pytest.mark.parametrize(
    ("names", "middle"),
    [
        ("Hips LeftUpLeg LeftLeg LeftFoot", 2),
        ("Hips LHipJoint LeftUpLeg LeftLeg LeftFoot", 3),
        ("mixamorig_Hips mixamorig_RightUpLeg mixamorig_RightLeg mixamorig_RightFoot", 2),
        ("pelvis thigh_l calf_l foot_l", 2),
        ("root upperarm_r lowerarm_r hand_r", 2),
        ("hips leftUpperLeg leftLowerLeg leftFoot", 2),
        ("Hips LeftHip LeftKnee LeftAnkle", 2),
        ("root lhipjoint lfemur ltibia lfoot", 3),
        ("Chest LeftCollar LeftShoulder LeftElbow LeftWrist", 3),
    ],
)
def test_common_names_of_knees_and_elbows(names, middle):
    path, joints = "", []
    for name in names.split():
        path = f"{path}/{name}" if path else name
        joints.append(path)
    rest = np.tile(np.eye(4), (len(joints), 1, 1))
    rest[:, 3, 1] = -1.0
    assert [limb.middle for limb in find_limbs(Skeleton(joints=tuple(joints), rest=rest))] == [middle]


def test_a_skeleton_without_feet_has_no_legs():
    assert find_limbs(make_skeleton(("Hips", "Hips/Spine"))) == ()


def test_toes_and_constant_joints_are_not_captured():
    clip = make_walk(60)
    captured = {clip.joints[joint] for joint in captured_joints(clip)}
    assert LEFT_FOOT in captured
    assert not captured & {LEFT_TOE, RIGHT_TOE}


@pytest.mark.parametrize("upper", [LEFT_LEG, RIGHT_LEG, LEFT_ARM, RIGHT_ARM])
@pytest.mark.parametrize(("first", "last"), [(100, 100), (100, 105), (80, 99)])
def test_a_flipped_run_is_turned_back(upper, first, last):
    clip = make_walk()
    result = repair_flips(flip(clip, upper, first, last))
    _, middle, end = chain_of(clip, upper)
    before, after = positions(clip), positions(result.clip)
    assert np.abs(before[:, end] - after[:, end]).max() < 1e-9
    assert np.abs(before[:, middle] - after[:, middle]).max() < 0.5
    assert {(change.first, change.last) for change in result.changes} == {(first, last)}
    assert [change.joint for change in result.changes] == [upper, clip.joints[end]]


def test_the_ends_own_rotation_is_interpolated():
    clip = make_walk()
    _, _, end = chain_of(clip, LEFT_LEG)
    result = repair_flips(flip(clip, LEFT_LEG, 100, 105))
    assert np.degrees(quaternion.angle_between(clip.rotations[:, end], result.clip.rotations[:, end])).max() < 2.0


def test_nothing_else_changes_by_a_bit():
    flipped = flip(make_walk(), LEFT_LEG, 100, 105)
    changed = changed_frames(flipped, repair_flips(flipped).clip)
    top, _, end = chain_of(flipped, LEFT_LEG)
    expected = np.zeros_like(changed)
    expected[100:106, [top, end]] = True
    assert (changed == expected).all()


def test_several_runs_alternate_with_good_frames():
    clip = make_walk()
    flipped = flip(flip(flip(clip, RIGHT_LEG, 60, 65), RIGHT_LEG, 70, 74), RIGHT_LEG, 77, 85)
    runs = {(change.first, change.last) for change in repair_flips(flipped).changes}
    assert runs == {(60, 65), (70, 74), (77, 85)}


def test_oriented_joints_make_no_difference():
    clip = make_walk(oriented=3)
    result = repair_flips(flip(clip, LEFT_LEG, 100, 105))
    assert (
        np.abs(
            positions(clip)[:, chain_of(clip, LEFT_LEG)[1]] - positions(result.clip)[:, chain_of(clip, LEFT_LEG)[1]]
        ).max()
        < 0.5
    )


@pytest.mark.parametrize(("first", "last"), [(0, 5), (234, 239)])
def test_a_run_at_an_end_of_the_clip_holds_the_nearest_good_swivel(first, last):
    clip = make_walk()
    result = repair_flips(flip(clip, LEFT_LEG, first, last))
    middle = chain_of(clip, LEFT_LEG)[1]
    assert {(change.first, change.last) for change in result.changes} == {(first, last)}
    assert np.abs(positions(clip)[:, middle] - positions(result.clip)[:, middle]).max() < 2.0


def test_a_flip_that_lasts_is_reported_and_left():
    flipped = flip(make_walk(480), LEFT_LEG, 200, 330)
    result = repair_flips(flipped)
    assert result.clip is flipped
    assert result.changes == ()
    assert [(note.first, note.joint) for note in result.notes] == [(200, LEFT_LEG), (331, LEFT_LEG)]
    assert "no repair" in str(result.notes[0])


def test_a_longer_limit_repairs_it():
    flipped = flip(make_walk(480), LEFT_LEG, 200, 270)
    assert repair_flips(flipped).changes == ()
    assert {(change.first, change.last) for change in repair_flips(flipped, longest_s=0.7).changes} == {(200, 270)}


def test_a_smaller_jump_is_a_flip_where_asked_for():
    flipped = flip(make_walk(), LEFT_LEG, 100, 105, degrees=45.0)
    assert repair_flips(flipped).changes == ()
    assert {(c.first, c.last) for c in repair_flips(flipped, jump_deg=30.0).changes} == {(100, 105)}


def test_fast_clean_motion_comes_back_as_it_is():
    clip = make_walk(rate=24.0, stride_hz=2.5)
    assert repair_flips(clip).clip is clip


def test_swivel_is_interpolated_the_short_way_round():
    angles = np.radians([170.0, 0.0, 0.0, 0.0, -170.0])
    assert np.degrees(interpolate_swivel(angles, 1, 3)) == pytest.approx([175.0, 180.0, 185.0])


def test_the_shorter_side_of_a_jump_is_the_flip():
    angles = np.zeros(100)
    angles[40:48] = np.pi
    jumps = np.abs(np.diff(angles, prepend=0.0)) > 1.0
    assert find_flips(angles, jumps, 120.0, longest_s=0.5) == [(40, 47)]


def test_change_reads_as_a_sentence():
    result = repair_flips(flip(make_walk(), LEFT_LEG, 100, 105))
    assert str(result.changes[0]) == (
        "flips: LeftUpLeg frames 100-105: turned back by up to 180 degrees, LeftLeg with it, LeftFoot kept in place"
    )
