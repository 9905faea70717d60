"""The root, the hips and the heading."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.motion import quaternion
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.texture.facing import Facing, find_hips, find_root, measure_heading
from tests.synthetic import HIPS, JOINTS, LEFT_LEG, POSITIONS, RIGHT_LEG, SPINE, make_clip, make_skeleton, walk


def still(frames, skeleton):
    return np.tile([1.0, 0.0, 0.0, 0.0], (frames, len(skeleton.joints), 1))


def test_the_root_is_the_topmost_joint_that_moves():
    clip = walk(20)
    assert find_root(clip) == 0
    translations = np.array(clip.translations)
    translations[:, JOINTS.index(SPINE)] += np.sin(np.arange(20.0))[:, None]
    assert find_root(replace(clip, translations=translations)) == 0
    translations[:, 0] = translations[0, 0]
    assert find_root(replace(clip, translations=translations)) == JOINTS.index(SPINE)


def test_no_root_where_nothing_moves():
    clip = walk(20)
    assert find_root(replace(clip, translations=np.tile(clip.translations[:1], (20, 1, 1)))) is None


def test_float_noise_is_no_movement():
    clip = walk(20)
    noise = 1e-5 * np.random.default_rng(0).standard_normal((20, 1, 1))
    assert find_root(replace(clip, translations=clip.translations[:1] + noise)) is None


@pytest.mark.parametrize("oriented", [None, 1, 2, 3])
def test_hips_of_a_humanoid(oriented):
    assert find_hips(make_skeleton(oriented=oriented)) == (JOINTS.index(LEFT_LEG), JOINTS.index(RIGHT_LEG))


def test_hips_behind_joints_of_no_length():
    """As in the CMU skeleton: LHipJoint and RHipJoint lie on the pelvis, the legs begin one joint further."""
    positions = {HIPS: POSITIONS[HIPS], SPINE: POSITIONS[SPINE], "Hips/LHipJoint": POSITIONS[HIPS]}
    positions["Hips/LHipJoint/LeftUpLeg"] = POSITIONS[LEFT_LEG]
    positions["Hips/LHipJoint/LeftUpLeg/LeftLeg"] = (9.0, 45.0, 0.0)
    positions["Hips/RHipJoint"] = POSITIONS[HIPS]
    positions["Hips/RHipJoint/RightUpLeg"] = POSITIONS[RIGHT_LEG]
    positions["Hips/RHipJoint/RightUpLeg/RightLeg"] = (-9.0, 45.0, 0.0)
    skeleton = make_skeleton(tuple(positions), oriented=4, positions=positions)
    assert find_hips(skeleton) == (3, 6)


def test_hips_below_a_reference_joint():
    positions = {"Root": (0.0, 0.0, 0.0), **{f"Root/{joint}": at for joint, at in POSITIONS.items()}}
    skeleton = make_skeleton(tuple(positions), positions=positions)
    names = [skeleton.joints[i] for i in find_hips(skeleton)]
    assert names == [f"Root/{LEFT_LEG}", f"Root/{RIGHT_LEG}"]


def test_hips_with_toes_and_hands_that_hang():
    positions = dict(POSITIONS)
    for side, x in (("Left", 9.0), ("Right", -9.0)):
        leg = f"Hips/{side}UpLeg/{side}Leg"
        positions[f"{leg}/{side}Foot"] = (x, 8.0, 0.0)
        positions[f"{leg}/{side}Foot/{side}Toe"] = (x, 0.0, 15.0)
        positions[f"{leg}/{side}Foot/{side}Heel"] = (x, 0.0, -5.0)
        positions[f"Hips/Spine/{side}Arm/{side}ForeArm/{side}Hand"] = (2.0 * x, 70.0, 0.0)
    joints = tuple(sorted(positions, key=lambda joint: joint.count("/")))
    skeleton = make_skeleton(joints, positions=positions)
    assert {skeleton.joints[i] for i in find_hips(skeleton)} == {LEFT_LEG, RIGHT_LEG}


def test_no_hips_on_one_chain():
    skeleton = make_skeleton(("A", "A/B"), positions={"A": (0.0, 0.0, 0.0), "A/B": (0.0, 10.0, 0.0)})
    assert find_hips(skeleton) is None


@pytest.mark.parametrize("degrees", [0.0, 40.0, -130.0, 175.0])
def test_heading_is_the_turn_since_rest(degrees):
    skeleton = make_skeleton(oriented=2)
    turns = still(8, skeleton)
    turns[:, 0] = quaternion.exp(np.radians([0.0, degrees, 0.0]))
    clip = make_clip(skeleton, 24.0, turns, np.tile(POSITIONS[HIPS], (8, 1)))
    np.testing.assert_allclose(np.degrees(measure_heading(clip, 0)), degrees, atol=1e-9)


def test_heading_counts_on_through_whole_turns():
    skeleton = make_skeleton()
    degrees = np.arange(0.0, 900.0, 20.0)
    turns = still(len(degrees), skeleton)
    turns[:, 0] = quaternion.exp(np.radians(degrees)[:, None] * np.array([0.0, 1.0, 0.0]))
    clip = make_clip(skeleton, 24.0, turns, np.tile(POSITIONS[HIPS], (len(degrees), 1)))
    np.testing.assert_allclose(np.degrees(measure_heading(clip, 0)), degrees, atol=1e-9)


def test_leaning_is_not_turning():
    skeleton = make_skeleton()
    turns = still(8, skeleton)
    turns[:, 0] = quaternion.exp(np.radians([[30.0, 0.0, 0.0]] * 4 + [[0.0, 0.0, 30.0]] * 4))
    clip = make_clip(skeleton, 24.0, turns, np.tile(POSITIONS[HIPS], (8, 1)))
    np.testing.assert_allclose(measure_heading(clip, 0), 0.0, atol=1e-9)


def test_without_hips_the_root_joint_tells_the_heading():
    skeleton = make_skeleton(("A", "A/B"), positions={"A": (0.0, 0.0, 0.0), "A/B": (0.0, 10.0, 0.0)}, oriented=1)
    turns = still(8, skeleton)
    turns[:, 0] = quaternion.exp(np.radians([0.0, 70.0, 0.0]))
    clip = make_clip(skeleton, 24.0, turns, np.zeros((8, 3)))
    np.testing.assert_allclose(np.degrees(measure_heading(clip, 0)), 70.0, atol=1e-9)


def test_up_is_where_the_skeleton_says():
    """The same walk on a Z-up skeleton has the same heading."""
    to_z_up = quaternion.exp(np.radians([90.0, 0.0, 0.0]))
    clip = walk(60, heading=30.0)
    rest = np.array(clip.skeleton.rest)
    rest[0, :3, :3] = rest[0, :3, :3] @ quaternion.rotate(to_z_up, np.eye(3))
    rest[0, 3, :3] = quaternion.rotate(to_z_up, rest[0, 3, :3])
    skeleton = Skeleton(joints=clip.joints, rest=rest, up=np.array([0.0, 0.0, 1.0]))
    rotations, translations = np.array(clip.rotations), np.array(clip.translations)
    rotations[:, 0] = quaternion.multiply(to_z_up, rotations[:, 0])
    translations[:, 0] = quaternion.rotate(to_z_up, translations[:, 0])
    upright = replace(clip, skeleton=skeleton, rotations=rotations, translations=translations)
    np.testing.assert_allclose(measure_heading(upright, 0), measure_heading(clip, 0), atol=1e-9)


def test_the_sway_of_a_stride_is_not_heading():
    """Hips swing to and fro with every stride; the facing frame stays."""
    clip = walk(240, heading=25.0, seed=3)
    swing = np.degrees(measure_heading(clip, 0))
    facing = np.degrees(Facing.of_clip(clip, 0, 4).heading)
    assert np.ptp(swing[48:-48]) > 7.0
    assert np.ptp(facing[48:-48]) < 0.15 * np.ptp(swing[48:-48])
    np.testing.assert_allclose(facing[48:-48], 25.0, atol=1.0)


def test_a_straight_walk_travels_along_its_own_forward():
    clip = walk(120, heading=60.0)
    travel = Facing.of_clip(clip, 0, 4).unroll_travel(clip.translations[:, 0])
    gone = travel[-1] - travel[0]
    assert gone[2] > 100.0
    assert abs(gone[0]) < 0.05 * gone[2]
