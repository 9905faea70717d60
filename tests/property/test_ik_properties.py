"""Laws of inverse kinematics, on random bodies in random poses."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mtex_usd.constraints.ik import Goal, make_joint_limits, solve_ik, solve_two_bone
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from tests.synthetic import random_rotations
from tests.unit.test_ik_solver import FOOT, HAND, HIP, JOINTS, KNEE, joint_places, make_skeleton

SEEDS = st.integers(0, 2**32 - 1)
FRAMES = 6


def random_clip(seed, *, spread=0.4, oriented=True):
    """A body with joints oriented at random, its poses not far from one another."""
    rng = np.random.default_rng(seed)
    plain = make_skeleton()
    rest = np.array(plain.rest)
    turns = random_rotations(rng, len(JOINTS)) if oriented else np.tile([1.0, 0.0, 0.0, 0.0], (len(JOINTS), 1))
    rest[:, :3, :3] = quaternion.rotate(turns[:, None], np.eye(3))
    skeleton = replace(plain, rest=rest)
    vectors = rng.normal(0.0, spread, (len(JOINTS), 3)) + 0.05 * rng.standard_normal((FRAMES, len(JOINTS), 3))
    vectors[:, KNEE, 0] += 0.8
    return Clip(
        skeleton=skeleton,
        rate=24.0,
        rotations=quaternion.multiply(turns, quaternion.exp(vectors)),
        translations=np.tile(skeleton.rest_translations, (FRAMES, 1, 1)),
        scales=np.ones((FRAMES, len(JOINTS), 3)),
    )


def posed(clip, seed, size):
    """The clip with every joint but the root turned a little further."""
    rng = np.random.default_rng(seed + 1)
    turn = quaternion.exp(rng.uniform(-size, size, (len(JOINTS), 3)))
    rotations = quaternion.multiply(clip.rotations, turn)
    rotations[:, 0] = clip.rotations[:, 0]
    return replace(clip, rotations=rotations)


def pose_goals(clip, joints=(FOOT, HAND), *, oriented=True):
    """Goals that a pose meets."""
    positions, world = clip.skeleton.world_pose(clip.rotations, clip.translations)
    return [Goal(joint=j, place=positions[:, j], orientation=world[:, j] if oriented else None) for j in joints]


@settings(max_examples=15)
@given(seed=SEEDS, size=st.floats(0.01, 0.5))
def test_goals_of_another_pose_are_reached_at_no_more_change(seed, size):
    clip = random_clip(seed)
    other = posed(clip, seed, size)
    result = solve_ik(clip, pose_goals(other))
    assert result.reached.all()
    change = [
        np.square(quaternion.angle_between(c.rotations, clip.rotations)).sum(axis=1) for c in (result.clip, other)
    ]
    assert (change[0] <= change[1] * (1.0 + 1e-6) + 1e-9).all()


@settings(max_examples=15)
@given(seed=SEEDS)
def test_goals_met_change_nothing(seed):
    clip = random_clip(seed)
    np.testing.assert_array_equal(solve_ik(clip, pose_goals(clip)).clip.rotations, clip.rotations)


@settings(max_examples=10)
@given(seed=SEEDS, scale=st.floats(1e-2, 1e2))
def test_neither_scale_nor_turn_of_the_whole_change_the_angles(seed, scale):
    clip = random_clip(seed)
    goals = pose_goals(posed(clip, seed, 0.2), oriented=False)
    q = random_rotations(np.random.default_rng(seed), 1)[0]
    rest = np.array(clip.skeleton.rest)
    rest[:, 3, :3] *= scale
    skeleton = replace(clip.skeleton, rest=rest, meters_per_unit=clip.skeleton.meters_per_unit / scale)
    rotations, translations = np.array(clip.rotations), scale * clip.translations
    rotations[:, 0] = quaternion.multiply(q, rotations[:, 0])
    translations[:, 0] = quaternion.rotate(q, translations[:, 0])
    other = replace(clip, skeleton=skeleton, rotations=rotations, translations=translations)
    moved = [replace(goal, place=quaternion.rotate(q, scale * goal.place)) for goal in goals]
    own, found = solve_ik(clip, goals), solve_ik(other, moved)
    assert quaternion.angle_between(own.clip.rotations[:, 1:], found.clip.rotations[:, 1:]).max() < 1e-5
    np.testing.assert_allclose(own.distances_m, found.distances_m, atol=1e-7)


@settings(max_examples=15)
@given(seed=SEEDS, shift=st.tuples(*[st.floats(-30.0, 30.0)] * 3))
def test_limits_are_never_broken(seed, shift):
    """As scipy reads the angles, on joints whose axes are those of random frames."""
    clip = random_clip(seed, oriented=False)
    rng = np.random.default_rng(seed)
    frames = random_rotations(rng, len(JOINTS))
    angles = _scipy_angles(clip, frames)
    lower, upper = (
        angles.min(axis=0) - rng.uniform(0.0, 20.0, (9, 3)),
        angles.max(axis=0) + rng.uniform(0.0, 20.0, (9, 3)),
    )
    ranges = {}
    for joint in (HIP, KNEE, FOOT):
        for column, channel in enumerate(("rz", "ry", "rx")):
            ranges[joint, channel] = (lower[joint, column], upper[joint, column])
    limits = make_joint_limits(clip.skeleton, ranges, orientations=frames)
    goal = Goal(joint=FOOT, place=joint_places(clip, FOOT) + np.array(shift))
    result = solve_ik(clip, [goal], limits=limits)
    after = limits.measure(clip.skeleton, result.clip.rotations)[:, [HIP, KNEE, FOOT]]
    assert (after >= lower[[HIP, KNEE, FOOT]] - 1e-7).all()
    assert (after <= upper[[HIP, KNEE, FOOT]] + 1e-7).all()
    # The given poses are within the limits, so that none needs to end farther off than it began.
    assert result.distances_m.max() <= 0.01 * np.linalg.norm(shift) + 1e-4
    read = [Rotation.from_euler("ZYX", after[:, k], degrees=True) for k in range(3)]
    for joint, rotation in zip((HIP, KNEE, FOOT), read, strict=True):
        frame = Rotation.from_quat(frames[joint], scalar_first=True)
        own = Rotation.from_quat(result.clip.rotations[:, joint], scalar_first=True)
        assert (frame * rotation * frame.inv() * own.inv()).magnitude().max() < 1e-7


def _scipy_angles(clip, frames):
    """Angles about z, y and x of frames, degrees, [F, J, 3], of joints that rest unturned."""
    out = []
    for joint, frame in enumerate(Rotation.from_quat(frames, scalar_first=True)):
        own = Rotation.from_quat(clip.rotations[:, joint], scalar_first=True)
        out.append((frame.inv() * own * frame).as_euler("ZYX", degrees=True))
    return np.stack(out, axis=1)


@settings(max_examples=30)
@given(seed=SEEDS, size=st.floats(0.01, 1.0))
def test_two_bones_reach_what_another_pose_of_them_reaches(seed, size):
    clip = random_clip(seed)
    goal = pose_goals(posed(clip, seed, size), (FOOT,))[0]
    hip = joint_places(clip, HIP)
    # The hip stays; so does the goal's distance from it.
    place = hip + (goal.place - joint_places(posed(clip, seed, size), HIP))
    result = solve_two_bone(clip, upper=HIP, middle=KNEE, end=FOOT, place=place, orientation=goal.orientation)
    within = np.linalg.norm(place - hip, axis=1) <= 0.995 * 83.0
    assert result.distances_m[within].max(initial=0.0) < 1e-9
    assert result.angles.max() < 1e-5
    np.testing.assert_allclose(np.linalg.norm(result.clip.rotations, axis=2), 1.0, atol=1e-12)


@settings(max_examples=10)
@given(seed=SEEDS, reach=st.floats(0.3, 1.2))
def test_smooth_goals_give_smooth_limbs(seed, reach):
    """A foot led evenly along a line, in reach or not: no joint moves much faster than the leg's length allows."""
    clip = random_clip(seed)
    frames = 80
    still = replace(
        clip,
        rotations=np.repeat(clip.rotations[:1], frames, axis=0),
        translations=np.repeat(clip.translations[:1], frames, axis=0),
        scales=np.ones((frames, len(JOINTS), 3)),
    )
    hip, foot = joint_places(still, HIP), joint_places(still, FOOT)
    way = (foot - hip) / np.linalg.norm(foot - hip, axis=1, keepdims=True)
    start = np.linalg.norm(foot - hip, axis=1)[0]

    def lead_to(end):
        return hip + way * np.linspace(start, end * 83.0, frames)[:, None]

    place = lead_to(reach)
    result = solve_two_bone(still, upper=HIP, middle=KNEE, end=FOOT, place=place)
    steps = quaternion.angle_between(result.clip.rotations[1:], result.clip.rotations[:-1])
    assert steps.max() < 0.2
    # The solver goes on to the very limit, where a knee straightens infinitely fast.
    solved = solve_ik(still, [Goal(joint=FOOT, place=lead_to(min(reach, 0.97)))])
    assert quaternion.angle_between(solved.clip.rotations[1:], solved.clip.rotations[:-1]).max() < 0.2
