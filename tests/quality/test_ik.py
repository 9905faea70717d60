"""Inverse kinematics on CMU captures: a walk with the limits of its own ASF file, feet and hands led elsewhere."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mtex_usd.constraints.ik import Goal, make_joint_limits, solve_ik, solve_two_bone
from mtex_usd.formats.amc import read_amc
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.motion.timing import resample_clip

LEG = ("lfemur", "ltibia", "lfoot")


@cache
def load(data_dir, name="91_02"):
    recording = read_amc(data_dir / "cmu_asfamc" / "91" / f"{name}.amc")
    joints = []
    for joint, parent in zip(recording.names, recording.parents, strict=True):
        joints.append(joint if parent < 0 else f"{joints[parent]}/{joint}")
    clip = Clip(
        skeleton=Skeleton(
            joints=tuple(joints), rest=recording.rest_transforms, meters_per_unit=recording.meters_per_unit
        ),
        rate=recording.rate,
        rotations=recording.rotations,
        translations=recording.translations,
        scales=np.ones(recording.translations.shape),
        name=name,
    )
    return recording, resample_clip(clip, 24.0)


@cache
def load_limits(data_dir):
    """The limits of the file; a bone that has some may not turn about the axes it lists none for."""
    recording, clip = load(data_dir)
    ranges = {}
    for joint in {limit.joint for limit in recording.limits}:
        ranges |= {(joint, channel): (0.0, 0.0) for channel in ("rx", "ry", "rz")}
    ranges |= {(limit.joint, limit.channel): (limit.lower, limit.upper) for limit in recording.limits}
    return make_joint_limits(clip.skeleton, ranges, orientations=recording.dof_axes)


def index(clip, name):
    return [joint.rpartition("/")[2] for joint in clip.joints].index(name)


def place(clip, name):
    return clip.skeleton.joint_positions([index(clip, name)], clip.rotations, clip.translations)[:, 0]


def lead(clip, name, metres):
    """Goals that leave the capture and come back to it smoothly."""
    along = np.sin(np.linspace(0.0, np.pi, clip.frame_count)) ** 2
    return place(clip, name) + np.outer(along, metres) / clip.skeleton.meters_per_unit


def test_angles_of_the_file_are_the_files_own(data_dir):
    """Those of 91_02.amc at its first frame, as the text has them."""
    recording, _ = load(data_dir)
    lines = (data_dir / "cmu_asfamc" / "91" / "91_02.amc").read_text().split("\n")
    first = {line.split()[0]: line.split()[1:] for line in lines[3 : lines.index("2")] if line and line[0].isalpha()}
    clip = Clip(
        skeleton=load(data_dir)[1].skeleton,
        rate=120.0,
        rotations=recording.rotations[:1],
        translations=recording.translations[:1],
        scales=np.ones(recording.translations[:1].shape),
    )
    angles = load_limits(data_dir).measure(clip.skeleton, clip.rotations)[0]
    for name in ("lfemur", "rfemur", "lhumerus", "thorax"):
        np.testing.assert_allclose(angles[index(clip, name)][::-1], [float(word) for word in first[name]], atol=1e-6)
    np.testing.assert_allclose(angles[index(clip, "ltibia")], [0.0, 0.0, float(first["ltibia"][0])], atol=1e-6)


def test_a_leg_with_its_limits_follows_smooth_goals(data_dir):
    _, clip = load(data_dir)
    limits = load_limits(data_dir)
    joints = [index(clip, name) for name in LEG]
    goal = Goal(joint=joints[2], place=lead(clip, "lfoot", [0.05, 0.10, 0.05]))
    result = solve_ik(clip, [goal], limits=limits)
    assert result.reached.mean() > 0.98
    assert limits.excess(clip.skeleton, result.clip.rotations)[:, joints].max() < 1e-6
    # The knee is a hinge in the file: its other two axes stay locked.
    knee = limits.measure(clip.skeleton, result.clip.rotations)[:, joints[1]]
    np.testing.assert_allclose(knee[:, :2], 0.0, atol=1e-9)
    assert _fastest(result.clip, joints) < 1.5 * _fastest(clip, joints)
    others = [joint for joint in range(len(clip.joints)) if joint not in clip.skeleton.chain(joints[2])]
    np.testing.assert_array_equal(result.clip.rotations[:, others], clip.rotations[:, others])


def test_feet_and_a_hand_together_with_the_spine(data_dir):
    _, clip = load(data_dir)
    names = {"lfoot": [0.0, 0.08, 0.0], "rfoot": [0.0, 0.0, 0.08], "rhand": [0.1, 0.15, 0.2]}
    goals = [Goal(joint=index(clip, name), place=lead(clip, name, shift)) for name, shift in names.items()]
    result = solve_ik(clip, goals)
    # A leg of the capture that is all but straight cannot reach eight centimetres further.
    assert result.reached.mean() > 0.6
    assert result.distances_m[:, 2].max() < 1e-4
    assert _fastest(result.clip, range(len(clip.joints))) < 1.5 * _fastest(clip, range(len(clip.joints)))


@pytest.mark.parametrize("shift", [[0.0, 0.08, 0.0], [0.05, 0.15, -0.1]])
def test_two_bones_follow_smooth_goals_exactly(data_dir, shift):
    _, clip = load(data_dir)
    joints = [index(clip, name) for name in LEG]
    target = lead(clip, "lfoot", shift)
    _, world = clip.skeleton.world_pose(clip.rotations, clip.translations)
    result = solve_two_bone(
        clip,
        upper=joints[0],
        middle=joints[1],
        end=joints[2],
        place=target,
        orientation=world[:, joints[2]],
    )
    hip = place(clip, "lfemur")
    lengths = np.linalg.norm(clip.skeleton.rest_translations[joints[1:]], axis=1)
    within = np.linalg.norm(target - hip, axis=1) < 0.995 * lengths.sum()
    assert within.mean() > 0.8
    assert result.distances_m[within].max() < 1e-4
    assert _fastest(result.clip, joints) < 1.5 * _fastest(clip, joints)


def test_the_knee_bends_forward_where_it_is_all_but_straight(data_dir):
    """The knee's axis in the thigh is that of the capture's own bends, at every frame of the result."""
    _, clip = load(data_dir)
    joints = [index(clip, name) for name in LEG]
    still = replace(clip, name="raised")
    result = solve_two_bone(
        still, upper=joints[0], middle=joints[1], end=joints[2], place=lead(clip, "lfoot", [0.0, 0.12, 0.0])
    )
    turns = Rotation.from_quat(result.clip.rotations[:, joints[1]], scalar_first=True).as_rotvec()
    bent = np.linalg.norm(turns, axis=1) > 0.1
    axes = turns[bent] / np.linalg.norm(turns[bent], axis=1, keepdims=True)
    assert (axes @ axes.mean(axis=0)).min() > 0.9


def _fastest(clip, joints):
    """The fastest turn of any of some joints, radians per frame."""
    kept = clip.rotations[:, list(joints)]
    return float(quaternion.angle_between(kept[1:], kept[:-1]).max())
