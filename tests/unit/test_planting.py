"""Holding points: limbs, what texturing is held back from, limits, and what changes."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.constraints.planting import Hold, JointRange, find_limb, held_back, hold_motion, restore_feet, to_ranges
from mtex_usd.errors import NoSolutionError
from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import to_skeleton_rotations
from tests.synthetic import HIPS, JOINTS, LEFT_KNEE, LEFT_LEG, RIGHT_KNEE, SPINE, UP, walk

KNEE, LEG, HIP = JOINTS.index(LEFT_KNEE), JOINTS.index(LEFT_LEG), JOINTS.index(HIPS)
SOLE = np.array([0.0, -45.0, 0.0])


def hold(first, last, **kwargs):
    settings = {"name": "left 1", "joint": KNEE, "offset": SOLE, "still": True, **kwargs}
    return Hold(first=first, last=last, **settings)


def track(clip, joint, offset):
    positions, world = clip.skeleton.world_pose(clip.rotations, clip.translations)
    return positions[:, joint] + quaternion.rotate(world[:, joint], offset)


def test_nothing_to_hold_changes_nothing():
    clip = walk(40)
    held = hold_motion(clip, ())
    assert held.clip is clip
    assert held.solution is None


def test_what_is_held_keeps_still_and_the_other_side_keeps_its_bits():
    clip = walk(60)
    held = hold_motion(clip, [hold(20, 28)]).clip
    places = track(held, KNEE, SOLE)[20:29]
    assert np.linalg.norm(places - places.mean(axis=0), axis=1).max() < 0.05  # half a millimetre, in centimetres
    assert np.linalg.norm(np.ptp(track(clip, KNEE, SOLE)[20:29], axis=0)) > 1.0
    for joint in (JOINTS.index(RIGHT_KNEE), JOINTS.index(SPINE)):
        np.testing.assert_array_equal(held.rotations[:, joint], clip.rotations[:, joint])


def test_a_hold_has_its_height():
    clip = walk(60)
    wanted = float(track(clip, KNEE, SOLE)[24] @ UP) + 3.0
    held = hold_motion(clip, [hold(20, 28, height=wanted)]).clip
    np.testing.assert_allclose(track(held, KNEE, SOLE)[20:29] @ UP, wanted, atol=0.05)


def test_places_that_cannot_both_be_are_named():
    clip = walk(60)
    here = track(clip, KNEE, SOLE)[24:25]
    holds = [
        hold(24, 24, name="here 1", places=here, still=False),
        hold(24, 24, name="there 1", places=here + 20.0, still=False),
    ]
    with pytest.raises(NoSolutionError, match=r"here 1.*there 1|there 1.*here 1"):
        hold_motion(clip, holds)


def test_limits_are_kept_as_far_as_the_motion_keeps_them():
    clip = walk(60)
    turns = to_skeleton_rotations(clip.rotations, clip.skeleton)
    own = quaternion.to_euler(turns[:, KNEE], "ZYX")
    tight = JointRange(
        joint=KNEE, axes=np.array([1.0, 0.0, 0.0, 0.0]), lower=own.min(axis=0) + 1.0, upper=own.max(axis=0) - 1.0
    )
    (constraint,) = to_ranges(clip, [tight], [KNEE])
    np.testing.assert_allclose(constraint.lower, own.min(axis=0))
    held = hold_motion(clip, [hold(20, 28, height=float(track(clip, KNEE, SOLE)[24] @ UP) + 6.0)], limits=[tight]).clip
    angles = quaternion.to_euler(to_skeleton_rotations(held.rotations, held.skeleton)[:, KNEE], "ZYX")
    assert (angles > own.min(axis=0) - 0.1).all()
    assert (angles < own.max(axis=0) + 0.1).all()


def test_joints_that_hold_nothing_have_no_limits_to_keep():
    clip = walk(20)
    anything = JointRange(joint=JOINTS.index(SPINE), axes=np.eye(4)[0], lower=np.zeros(3), upper=np.zeros(3))
    assert to_ranges(clip, [anything], [KNEE]) == ()


def test_a_leg_is_a_limb_and_the_trunk_is_none():
    skeleton = walk(2).skeleton
    assert set(find_limb(skeleton, KNEE)) == {LEG, KNEE}
    assert find_limb(skeleton, HIP) == ()


def test_texturing_is_held_back_wholly_in_contact_and_ramps():
    skeleton = walk(2).skeleton
    held = held_back([hold(20, 30)], skeleton, frame_count=60, ramp_frames=8)
    assert set(held) == {LEG, KNEE}
    assert held[LEG][25] == 1.0
    assert held[LEG][0] == held[LEG][59] == 0.0
    assert np.abs(np.diff(held[LEG])).max() < 0.5


def test_feet_of_a_leg_without_ankle_are_left_alone():
    clip = walk(40)
    moved = replace(clip, translations=clip.translations + 1.0)
    assert restore_feet(moved, clip, [hold(10, 14)]) is moved


def test_what_slides_keeps_the_height_of_the_motion_it_is_held_on():
    clip = walk(60)
    moved = replace(clip, translations=clip.translations + np.array([0.0, 5.0, 0.0]) * (np.arange(11) == 0)[:, None])
    slide = hold(20, 28, still=False, keeps_height=True)
    for motion in (clip, moved):
        held = hold_motion(motion, [slide]).clip
        np.testing.assert_allclose(track(held, KNEE, SOLE)[20:29] @ UP, track(motion, KNEE, SOLE)[20] @ UP, atol=0.05)


def test_what_follows_moves_with_what_carries_it():
    clip = walk(60)
    carried = np.tile(np.eye(4), (9, 1, 1))
    carried[:, 3, 0] = np.linspace(100.0, 104.0, 9)
    held = hold_motion(clip, [hold(20, 28, still=False, carried=carried)]).clip
    way = track(held, KNEE, SOLE)[20:29] - track(clip, KNEE, SOLE)[20]
    np.testing.assert_allclose(way, np.linspace(0.0, 4.0, 9)[:, None] * np.eye(3)[0], atol=0.05)
