"""Inverse kinematics by the solver: what is reached, what is left alone, limits, oracle, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mtex_usd.constraints.ik import Goal, JointLimits, make_joint_limits, solve_ik
from mtex_usd.constraints.ik.bounded import solve_bounded
from mtex_usd.constraints.ik.coordinates import Coordinates
from mtex_usd.constraints.ik.objective import Aim, Objective
from mtex_usd.constraints.ik.turns import inverse_left_jacobian, square_curvature
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from tests.oracle import ik as oracle

JOINTS = (
    "Hips",
    "Hips/Spine",
    "Hips/Spine/Arm",
    "Hips/Spine/Arm/ForeArm",
    "Hips/Spine/Arm/ForeArm/Hand",
    "Hips/UpLeg",
    "Hips/UpLeg/Leg",
    "Hips/UpLeg/Leg/Foot",
    "Hips/OtherLeg",
)
OFFSETS = np.array(
    [
        [0.0, 95.0, 0.0],
        [0.0, 45.0, 0.0],
        [18.0, 0.0, 0.0],
        [28.0, 0.0, 0.0],
        [26.0, 0.0, 0.0],
        [9.0, -5.0, 0.0],
        [0.0, -42.0, 0.0],
        [0.0, -41.0, 0.0],
        [-9.0, -5.0, 0.0],
    ]
)
SPINE, ARM, FOREARM, HAND, HIP, KNEE, FOOT = range(1, 8)


def make_skeleton(*, scale=1.0):
    rest = np.tile(np.eye(4), (len(JOINTS), 1, 1))
    rest[:, 3, :3] = scale * OFFSETS
    return Skeleton(joints=JOINTS, rest=rest)


def make_clip(frames=12, *, seed=0, bend=0.6, sway=0.2):
    """A body whose knee and elbow are bent and that sways smoothly."""
    rng = np.random.default_rng(seed)
    skeleton = make_skeleton()
    time = np.linspace(0.0, 1.0, frames)[:, None, None]
    phase = rng.uniform(0.0, 6.0, (len(JOINTS), 3))
    vectors = sway * np.sin(2.0 * np.pi * time + phase)
    vectors[:, KNEE] += [bend, 0.0, 0.0]
    vectors[:, FOREARM] += [0.0, -bend, 0.0]
    return Clip(
        skeleton=skeleton,
        rate=24.0,
        rotations=quaternion.exp(vectors),
        translations=np.tile(skeleton.rest_translations, (frames, 1, 1)),
        scales=np.ones((frames, len(JOINTS), 3)),
    )


def joint_places(clip, joint):
    return clip.skeleton.joint_positions([joint], clip.rotations, clip.translations)[:, 0]


def moved(clip, joint, shift):
    return joint_places(clip, joint) + np.asarray(shift)


def foot_goal(clip, shift, **options):
    return Goal(joint=FOOT, place=moved(clip, FOOT, shift), **options)


def knee_limits(skeleton):
    """A hinge for a knee, a range for a hip; z, y and x."""
    ranges = {(KNEE, "rx"): (0.0, 150.0), (KNEE, "ry"): (0.0, 0.0), (KNEE, "rz"): (0.0, 0.0)}
    ranges |= {(HIP, "rx"): (-40.0, 25.0), (HIP, "ry"): (-30.0, 30.0), (HIP, "rz"): (-20.0, 45.0)}
    return make_joint_limits(skeleton, ranges)


def scipy_angles(rotations):
    """Angles about z, y and x in degrees by scipy."""
    return Rotation.from_quat(rotations, scalar_first=True).as_euler("ZYX", degrees=True)


def test_a_goal_in_reach_is_reached_and_nothing_else_moves():
    clip = make_clip()
    result = solve_ik(clip, [foot_goal(clip, [4.0, 8.0, -3.0])])
    assert result.reached.all()
    assert result.distances_m.max() < 1e-6
    np.testing.assert_allclose(joint_places(result.clip, FOOT), moved(clip, FOOT, [4.0, 8.0, -3.0]), atol=1e-4)
    still = [joint for joint in range(len(JOINTS)) if joint not in (HIP, KNEE, FOOT)]
    np.testing.assert_array_equal(result.clip.rotations[:, still], clip.rotations[:, still])
    np.testing.assert_array_equal(result.clip.translations, clip.translations)


def test_place_and_orientation_of_a_point_are_reached_together():
    clip = make_clip()
    _, world = clip.skeleton.world_pose(clip.rotations, clip.translations)
    orientation = quaternion.multiply(quaternion.exp(np.array([0.1, 0.2, -0.1])), world[:, FOOT])
    offset = np.array([0.0, -6.0, 12.0])
    place = joint_places(clip, FOOT) + quaternion.rotate(orientation, offset) + [2.0, 5.0, 0.0]
    result = solve_ik(clip, [Goal(joint=FOOT, offset=offset, place=place, orientation=orientation)])
    assert result.reached.all()
    positions, world = result.clip.skeleton.world_pose(result.clip.rotations, result.clip.translations)
    np.testing.assert_allclose(positions[:, FOOT] + quaternion.rotate(world[:, FOOT], offset), place, atol=1e-4)
    assert quaternion.angle_between(world[:, FOOT], orientation).max() < 1e-6


def test_idle_frames_are_left_alone():
    clip = make_clip()
    active = np.arange(12) >= 6
    place = moved(clip, FOOT, [0.0, 8.0, 0.0])
    place[:6] = np.nan
    result = solve_ik(clip, [Goal(joint=FOOT, place=place, active=active)])
    np.testing.assert_array_equal(result.clip.rotations[:6], clip.rotations[:6])
    assert (result.clip.rotations[6:, KNEE] != clip.rotations[6:, KNEE]).any(axis=1).all()
    np.testing.assert_array_equal(result.distances_m[:6], 0.0)
    assert result.reached.all()


def test_a_goal_met_changes_nothing():
    clip = make_clip()
    result = solve_ik(clip, [foot_goal(clip, 0.0)], limits=None)
    np.testing.assert_array_equal(result.clip.rotations, clip.rotations)


def test_out_of_reach_the_limb_points_to_the_goal_and_says_by_how_much():
    clip = make_clip()
    hip = joint_places(clip, HIP)
    way = np.array([0.3, -0.9, 0.1]) / np.linalg.norm([0.3, -0.9, 0.1])
    result = solve_ik(clip, [Goal(joint=FOOT, place=hip + 120.0 * way)])
    np.testing.assert_allclose(result.distances_m[:, 0], (120.0 - 83.0) * 0.01, atol=1e-5)
    assert not result.reached.any()
    np.testing.assert_allclose(joint_places(result.clip, FOOT), hip + 83.0 * way, atol=0.05)


def test_a_straight_leg_bends_alike_at_every_frame():
    clip = make_clip(bend=0.0, sway=0.0)
    result = solve_ik(clip, [foot_goal(clip, [0.0, 12.0, 0.0])])
    assert result.reached.all()
    np.testing.assert_allclose(result.clip.rotations, np.repeat(result.clip.rotations[:1], 12, axis=0), atol=1e-5)


def test_a_leg_straight_but_for_noise_does_not_flap():
    """Bent by a hundredth of a degree forward and backward in turn, it has to choose one side for all frames."""
    clip = make_clip(frames=24, bend=0.0, sway=0.0)
    rotations = np.array(clip.rotations)
    rotations[:, KNEE] = quaternion.exp(np.outer(2e-4 * (-1.0) ** np.arange(24), [1.0, 0.0, 0.0]))
    result = solve_ik(replace(clip, rotations=rotations), [foot_goal(clip, [0.0, 12.0, 0.0])])
    assert result.reached.all()
    assert quaternion.angle_between(result.clip.rotations[1:], result.clip.rotations[:-1]).max() < 0.05


def test_limits_hold_and_locked_axes_stay():
    clip = make_clip(sway=0.1)
    rotations = np.array(clip.rotations)
    rotations[:, KNEE] = quaternion.exp(np.array([0.6, 0.0, 0.0]))
    clip = replace(clip, rotations=rotations)
    limits = knee_limits(clip.skeleton)
    result = solve_ik(clip, [foot_goal(clip, [25.0, 20.0, 20.0])], limits=limits)
    knee, hip = scipy_angles(result.clip.rotations[:, KNEE]), scipy_angles(result.clip.rotations[:, HIP])
    np.testing.assert_allclose(knee[:, :2], 0.0, atol=1e-12)
    assert knee[:, 2].min() >= -1e-9
    assert (hip >= np.array([-20.0, -30.0, -40.0]) - 1e-9).all()
    assert (hip <= np.array([45.0, 30.0, 25.0]) + 1e-9).all()
    assert limits.excess(clip.skeleton, result.clip.rotations).max() < 1e-9


def test_a_joint_outside_its_limits_is_brought_inside():
    clip = make_clip()
    limits = make_joint_limits(clip.skeleton, {(KNEE, "rx"): (0.0, 10.0)})
    result = solve_ik(clip, [foot_goal(clip, 0.0)], limits=limits)
    assert scipy_angles(result.clip.rotations[:, KNEE])[:, 2].max() <= 10.0 + 1e-9


def test_weights_decide_between_goals_that_fight():
    clip = make_clip()
    up, down = foot_goal(clip, [0.0, 10.0, 0.0], weight=10.0), foot_goal(clip, [0.0, 0.0, 10.0])
    result = solve_ik(clip, [up, down])
    assert (result.distances_m[:, 0] < 0.03 * result.distances_m[:, 1]).all()


def test_costly_joints_move_less():
    clip = make_clip()
    goal = Goal(joint=HAND, place=moved(clip, HAND, [-6.0, 4.0, 6.0]))
    costs = np.ones(len(JOINTS))
    free = solve_ik(clip, [goal], costs=costs)
    costs[SPINE] = 100.0
    stiff = solve_ik(clip, [goal], costs=costs)
    turn = [quaternion.angle_between(r.clip.rotations[:, SPINE], clip.rotations[:, SPINE]).max() for r in (free, stiff)]
    assert stiff.reached.all()
    assert turn[1] < 0.1 * turn[0]


def test_the_trunk_moves_only_if_asked():
    clip = make_clip()
    goal = foot_goal(clip, [0.0, 5.0, 5.0])
    np.testing.assert_array_equal(solve_ik(clip, [goal]).clip.rotations[:, 0], clip.rotations[:, 0])
    result = solve_ik(clip, [goal], joints=[0, HIP, KNEE])
    assert (result.clip.rotations[:, 0] != clip.rotations[:, 0]).any()
    np.testing.assert_array_equal(result.clip.rotations[:, FOOT], clip.rotations[:, FOOT])
    assert result.reached.all()


def test_goals_that_share_no_joint_are_solved_as_if_alone():
    clip = make_clip()
    foot = foot_goal(clip, [4.0, 8.0, -3.0])
    hand = Goal(joint=HAND, place=moved(clip, HAND, [-4.0, 3.0, 5.0]))
    both = solve_ik(clip, [foot, hand])
    alone = [solve_ik(clip, [goal]).clip.rotations for goal in (foot, hand)]
    np.testing.assert_array_equal(both.clip.rotations[:, [HIP, KNEE, FOOT]], alone[0][:, [HIP, KNEE, FOOT]])
    np.testing.assert_array_equal(both.clip.rotations[:, [ARM, FOREARM]], alone[1][:, [ARM, FOREARM]])
    assert both.distances_m.shape == (12, 2)


def test_two_goals_on_one_limb_are_solved_together():
    """A knee and an ankle: what the one wants the other has to allow."""
    clip = make_clip()
    other = solve_ik(clip, [foot_goal(clip, [3.0, 6.0, 2.0])]).clip
    goals = [Goal(joint=joint, place=joint_places(other, joint)) for joint in (KNEE, FOOT)]
    result = solve_ik(clip, goals)
    assert result.reached.all()
    np.testing.assert_allclose(joint_places(result.clip, KNEE), joint_places(other, KNEE), atol=1e-4)


def one_frame(clip, frame):
    """One frame alone, its knee a hinge."""
    rotations = np.array(clip.rotations[[frame]])
    rotations[:, KNEE] = quaternion.exp(np.array([0.6, 0.0, 0.0]))
    return replace(clip, rotations=rotations, translations=clip.translations[[frame]], scales=clip.scales[[frame]])


@pytest.mark.parametrize("limited", [False, True])
@pytest.mark.parametrize("frame", range(4))
def test_equals_the_slow_twin(limited, frame):
    clip = one_frame(make_clip(frames=4, seed=3), frame)
    limits = knee_limits(clip.skeleton) if limited else None
    ranges = {KNEE: ([0, 0, 0], [0, 0, 150]), HIP: ([-20, -30, -40], [45, 30, 25])} if limited else {}
    goals = [
        foot_goal(clip, [10.0, 12.0, 6.0]),
        Goal(joint=HAND, place=moved(clip, HAND, [4.0, -6.0, 9.0]), offset=np.array([8.0, 0.0, 0.0]), weight=0.5),
    ]
    moving = [SPINE, ARM, FOREARM, HAND, HIP, KNEE, FOOT]
    result = solve_ik(clip, goals, limits=limits)
    lengths = np.linalg.norm(OFFSETS, axis=1)
    reaches = (lengths[[KNEE, FOOT]].sum(), lengths[[ARM, FOREARM, HAND]].sum() + 8.0)
    own, found = ([Rotation.from_quat(q, scalar_first=True) for q in c.rotations[0]] for c in (clip, result.clip))
    wanted = [(g.joint, g.point, g.place[0], None, r, g.weight) for g, r in zip(goals, reaches, strict=True)]
    turned, distances, cost = oracle.solve_frame(clip.parents, own, clip.translations[0], moving, wanted, ranges)
    assert max(distances) < 0.01
    ours = oracle.cost_of(clip.parents, own, found, clip.translations[0], moving, wanted, ranges)
    assert ours == pytest.approx(cost, rel=1e-4)
    assert max((a.inv() * b).magnitude() for a, b in zip(turned, found, strict=True)) < 2e-3


@pytest.mark.parametrize("limited", [False, True])
@pytest.mark.parametrize("size", [0.0, 0.5])
def test_derivatives_equal_finite_differences(limited, size):
    clip = make_clip(frames=2, seed=1)
    _, world = clip.skeleton.world_pose(clip.rotations, clip.translations)
    rng = np.random.default_rng(5)
    goal = Goal(
        joint=FOOT,
        place=joint_places(clip, FOOT) + rng.uniform(-20.0, 20.0, (2, 3)),
        offset=np.array([2.0, -5.0, 9.0]),
        orientation=quaternion.multiply(quaternion.exp(np.array([0.4, -0.3, 0.2])), world[:, FOOT]),
    )
    moving = np.array([0, HIP, KNEE, FOOT])
    coordinates = Coordinates.of(clip, moving, knee_limits(clip.skeleton) if limited else None)
    objective = Objective(coordinates=coordinates, goals=[goal], reaches=[83.0], costs=np.array([1.0, 2.0, 0.5, 1.0]))
    frames, aim = np.arange(2), Aim.straight(np.array([1.0, 0.1]), 1)
    values = size * rng.standard_normal((2, 4, 3))
    model = objective.model(values, frames, aim)
    steps = 1e-4 * np.eye(12).reshape(12, 4, 3)

    def value(step):
        return objective.value(coordinates.step(values, np.broadcast_to(step, values.shape)), frames, aim)

    slope = np.stack([(value(s) - value(-s)) / 2e-4 for s in steps], axis=1)
    np.testing.assert_allclose(model.gradient, slope, atol=1e-6 * np.abs(slope).max())
    bend = [[(value(a + b) - value(a - b) - value(b - a) + value(-a - b)) / 4e-8 for a in steps] for b in steps]
    bend = np.moveaxis(np.array(bend), 2, 0)
    np.testing.assert_allclose(model.hessian, bend, atol=1e-5 * np.abs(bend).max())


def test_an_aim_beyond_the_goal_has_the_right_slope():
    clip = make_clip(frames=1)
    _, world = clip.skeleton.world_pose(clip.rotations, clip.translations)
    turned = quaternion.multiply(quaternion.exp(np.array([[0.3, 0.1, -0.2]])), world[:, FOOT])
    goal = foot_goal(clip, [3.0, 4.0, 5.0], orientation=turned)
    coordinates = Coordinates.of(clip, np.array([HIP, KNEE, FOOT]), None)
    objective = Objective(coordinates=coordinates, goals=[goal], reaches=[83.0], costs=np.ones(3))
    aim = Aim(softness=np.array([0.3]), shift=np.random.default_rng(2).normal(0.0, 0.2, (1, 1, 6)))
    values, frames = np.full((1, 3, 3), 0.2), np.arange(1)
    steps = 1e-5 * np.eye(9).reshape(9, 1, 3, 3)
    values_at = [
        [objective.value(coordinates.step(values, s), frames, aim)[0] for s in (step, -step)] for step in steps
    ]
    slope = [(a - b) / 2e-5 for a, b in values_at]
    np.testing.assert_allclose(objective.model(values, frames, aim).gradient[0], slope, rtol=1e-5, atol=1e-7)


@pytest.mark.parametrize("size", [1e-9, 1e-3, 0.5, 2.0, 3.0])
def test_calculus_of_rotations(size):
    rng = np.random.default_rng(4)
    axis = rng.standard_normal(3)
    vector = size * axis / np.linalg.norm(axis)
    step = 1e-6 * rng.standard_normal(3)
    base = Rotation.from_rotvec(vector)
    change = [(Rotation.from_rotvec(s) * base).as_rotvec() for s in (step, -step)]
    np.testing.assert_allclose(inverse_left_jacobian(vector) @ step, (change[0] - change[1]) / 2.0, atol=1e-13)
    step *= 1e3
    half = [0.5 * (Rotation.from_rotvec(s) * base).magnitude() ** 2 for s in (step, -step, 0.0 * step)]
    assert step @ square_curvature(vector) @ step == pytest.approx(
        half[0] + half[1] - 2.0 * half[2], rel=1e-3, abs=1e-12
    )


def test_bounded_steps_meet_the_conditions_of_a_minimum():
    """Inside the bounds the slope vanishes, on them it points outward."""
    rng = np.random.default_rng(0)
    root = rng.standard_normal((50, 8, 8))
    hessian = root @ np.swapaxes(root, 1, 2) + 0.1 * np.eye(8)
    gradient = rng.standard_normal((50, 8))
    lower, upper = -rng.uniform(0.0, 0.3, (50, 8)), rng.uniform(0.0, 0.3, (50, 8))
    lower[:, 0] = upper[:, 0] = 0.0
    steps = solve_bounded(hessian, gradient, lower, upper)
    slope = np.einsum("fij,fj->fi", hessian, steps) + gradient
    np.testing.assert_array_equal(steps[:, 0], 0.0)
    assert ((steps >= lower) & (steps <= upper)).all()
    inside = (steps > lower) & (steps < upper)
    settled = (np.abs(np.where(inside, slope, 0.0)).max(axis=1) < 1e-8) & (
        (slope * np.where(steps <= lower, -1.0, np.where(steps >= upper, 1.0, 0.0)) <= 1e-8) | (lower == upper)
    ).all(axis=1)
    assert settled.all()


def test_limits_read_as_scipy_reads_them():
    skeleton = make_skeleton()
    rng = np.random.default_rng(7)
    frames = Rotation.random(len(JOINTS), rng)
    rotations = Rotation.random(len(JOINTS) * 5, rng).as_quat(scalar_first=True).reshape(5, -1, 4)
    limits = make_joint_limits(skeleton, {}, orientations=frames.as_quat(scalar_first=True), order="YXZ")
    angles = limits.measure(skeleton, rotations)
    for joint, frame in enumerate(frames):
        turned = frame.inv() * Rotation.from_quat(rotations[:, joint], scalar_first=True) * frame
        own = Rotation.from_euler("YXZ", angles[:, joint], degrees=True)
        assert (own.inv() * turned).magnitude().max() < 1e-9


def test_limits_choose_the_reading_that_keeps_them():
    """A hip turned by 150 degrees about x reads as -30 with y and z turned over, unless the range says otherwise."""
    skeleton = make_skeleton()
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (1, len(JOINTS), 1))
    rotations[0, HIP] = Rotation.from_euler("ZYX", [10.0, 120.0, 20.0], degrees=True).as_quat(scalar_first=True)
    limits = make_joint_limits(skeleton, {(HIP, "rx"): (0.0, 30.0), (HIP, "ry"): (0, 170), (HIP, "rz"): (0.0, 30.0)})
    np.testing.assert_allclose(limits.measure(skeleton, rotations)[0, HIP], [10.0, 120.0, 20.0], atol=1e-9)
    assert limits.excess(skeleton, rotations)[0, HIP].max() < 1e-9


REFUSED = {
    "inverse kinematics without goals": lambda clip: solve_ik(clip, []),
    "goal 0: no such joint": lambda clip: solve_ik(clip, [replace(foot_goal(clip, 1.0), joint=99)]),
    "goal 0: bad weight": lambda clip: solve_ik(clip, [foot_goal(clip, 1.0, weight=0.0)]),
    r"goal 0: place does not fit.*\(12, 3\)": lambda clip: solve_ik(
        clip, [Goal(joint=FOOT, place=np.zeros((3, 3)), active=np.ones(12, dtype=bool))]
    ),
    "goal 0: active does not fit": lambda clip: solve_ik(clip, [foot_goal(clip, 1.0, active=np.ones(3, dtype=bool))]),
    "goal 0: offset does not fit": lambda clip: solve_ik(clip, [foot_goal(clip, 1.0, offset=np.zeros(2))]),
    "goal 0: place is not finite.*frame 0": lambda clip: solve_ik(clip, [foot_goal(clip, np.nan)]),
    "goal 0: orientations are not unit": lambda clip: solve_ik(
        clip, [foot_goal(clip, 1.0, orientation=np.full((12, 4), 0.1))]
    ),
    "goal 0: no joint that may turn moves": lambda clip: solve_ik(clip, [foot_goal(clip, 1.0)], joints=[HAND]),
    "joint limits do not fit the skeleton": lambda clip: solve_ik(
        clip, [foot_goal(clip, 1.0)], limits=make_joint_limits(clip.skeleton, {}).for_joints(np.arange(3))
    ),
    "costs do not fit": lambda clip: solve_ik(clip, [foot_goal(clip, 1.0)], costs=np.zeros(9)),
    "joint limits: bad order": lambda clip: make_joint_limits(clip.skeleton, {}, order="XYX"),
    "joint limits: unknown channel.*tx of joint 1": lambda clip: make_joint_limits(clip.skeleton, {(1, "tx"): (0, 1)}),
    "joint limits: empty range.*10 to 5": lambda clip: make_joint_limits(clip.skeleton, {(1, "rx"): (10.0, 5.0)}),
    "joint limits: bad axes": lambda _: JointLimits(
        axes=np.ones((1, 3, 3)), lower=np.zeros((1, 3)), upper=np.zeros((1, 3))
    ),
    "joint limits: shapes": lambda _: JointLimits(axes=np.eye(3)[None], lower=np.zeros((2, 3)), upper=np.zeros((1, 3))),
}


@pytest.mark.parametrize("message", REFUSED)
def test_bad_input_is_refused(message):
    with pytest.raises(InputError, match=message):
        REFUSED[message](make_clip())
