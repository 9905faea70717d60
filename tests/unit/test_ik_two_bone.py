"""The analytic limb: exact in reach, gradual at its limit, on the side the limb bends to."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.constraints.ik import Goal, solve_ik, solve_two_bone
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from tests.unit.test_ik_solver import FOOT, HIP, JOINTS, KNEE, joint_places, make_clip, moved

LEG = {"upper": HIP, "middle": KNEE, "end": FOOT}
LENGTH = 83.0


def knee_angles(clip):
    """Angle between the bones, 0 where straight, radians."""
    hip, knee, foot = (joint_places(clip, joint) for joint in (HIP, KNEE, FOOT))
    cosines = np.sum((knee - hip) * (foot - knee), axis=1) / (42.0 * 41.0)
    return np.arccos(np.clip(cosines, -1.0, 1.0))


def straight_down(frames, distances):
    """A leg bent forward by a radian at every frame, and goals straight below the hip at distances."""
    clip = make_clip(frames, bend=1.0, sway=0.0)
    return clip, joint_places(clip, HIP) - np.outer(distances, [0.0, 1.0, 0.0])


def test_goals_in_reach_are_met_exactly_and_nothing_else_moves():
    clip = make_clip()
    place = moved(clip, FOOT, [5.0, 9.0, -4.0])
    result = solve_two_bone(clip, **LEG, place=place)
    assert result.reached.all()
    np.testing.assert_allclose(joint_places(result.clip, FOOT), place, atol=1e-9)
    still = [joint for joint in range(len(JOINTS)) if joint not in (HIP, KNEE)]
    np.testing.assert_array_equal(result.clip.rotations[:, still], clip.rotations[:, still])


def test_the_orientation_is_met_about_the_point():
    clip = make_clip()
    _, world = clip.skeleton.world_pose(clip.rotations, clip.translations)
    orientation = quaternion.multiply(quaternion.exp(np.array([0.2, -0.1, 0.3])), world[:, FOOT])
    offset = np.array([0.0, -7.0, 13.0])
    place = joint_places(clip, FOOT) + quaternion.rotate(orientation, offset) + [0.0, 6.0, 3.0]
    result = solve_two_bone(clip, **LEG, place=place, orientation=orientation, offset=offset)
    positions, world = result.clip.skeleton.world_pose(result.clip.rotations, result.clip.translations)
    np.testing.assert_allclose(positions[:, FOOT] + quaternion.rotate(world[:, FOOT], offset), place, atol=1e-9)
    assert quaternion.angle_between(world[:, FOOT], orientation).max() < 1e-9
    assert result.angles.max() < 1e-6


def test_a_point_of_the_end_is_met_without_turning_the_end():
    clip = make_clip()
    offset = np.array([0.0, -7.0, 13.0])
    _, world = clip.skeleton.world_pose(clip.rotations, clip.translations)
    place = joint_places(clip, FOOT) + quaternion.rotate(world[:, FOOT], offset) + [2.0, 6.0, 0.0]
    result = solve_two_bone(clip, **LEG, place=place, offset=offset)
    assert result.distances_m.max() < 1e-9
    np.testing.assert_array_equal(result.clip.rotations[:, FOOT], clip.rotations[:, FOOT])


def test_a_goal_met_changes_nothing():
    clip = make_clip()
    result = solve_two_bone(clip, **LEG, place=joint_places(clip, FOOT))
    np.testing.assert_array_equal(result.clip.rotations, clip.rotations)


def test_idle_frames_are_left_alone():
    clip = make_clip()
    place = moved(clip, FOOT, [0.0, 9.0, 0.0])
    active = np.arange(12) % 2 == 0
    place[~active] = np.nan
    result = solve_two_bone(clip, **LEG, place=place, active=active)
    np.testing.assert_array_equal(result.clip.rotations[~active], clip.rotations[~active])
    np.testing.assert_allclose(joint_places(result.clip, FOOT)[active], place[active], atol=1e-9)


def test_the_knee_keeps_its_side():
    """The swivel of the given pose: with the foot drawn straight toward the hip, the knee stays in its plane."""
    clip = make_clip(sway=0.0)
    hip, knee, foot = (joint_places(clip, joint) for joint in (HIP, KNEE, FOOT))
    result = solve_two_bone(clip, **LEG, place=foot + 0.2 * (hip - foot))
    normal = np.cross(knee - hip, foot - hip)
    after = joint_places(result.clip, KNEE) - hip
    np.testing.assert_allclose(np.sum(after * normal, axis=1), 0.0, atol=1e-6)
    assert (np.sum(np.cross(after, foot - hip) * normal, axis=1) > 0.0).all()


def test_beyond_its_reach_the_limb_points_to_the_goal_and_says_by_how_much():
    clip, place = straight_down(3, np.array([90.0, 120.0, 500.0]))
    result = solve_two_bone(clip, **LEG, place=place)
    assert not result.reached.any()
    np.testing.assert_allclose(result.distances_m[:, 0], [0.07, 0.37, 4.17], atol=0.0005)
    way = joint_places(result.clip, FOOT) - joint_places(clip, HIP)
    np.testing.assert_allclose(way[:, [0, 2]], 0.0, atol=1e-6)


def test_the_limb_straightens_without_a_snap():
    """The goal goes at even speed through the limit: the knee never turns faster than where it starts to ease."""
    frames = 400
    distances = np.linspace(0.97 * LENGTH, 1.03 * LENGTH, frames)
    clip, place = straight_down(frames, distances)
    knee = knee_angles(solve_two_bone(clip, **LEG, place=place, easing=0.01).clip)
    speeds = -np.diff(knee)
    before = distances[1:] < 0.99 * LENGTH
    assert (speeds >= -1e-7).all()
    assert speeds.max() < 1.2 * speeds[before].max()
    assert np.abs(np.diff(speeds)).max() < 0.1 * speeds.max()
    np.testing.assert_allclose(
        knee[distances < 0.99 * LENGTH],
        np.arccos((distances[distances < 0.99 * LENGTH] ** 2 - 42.0**2 - 41.0**2) / (2.0 * 42.0 * 41.0)),
        atol=1e-6,
    )


def test_a_straight_leg_bends_where_it_does_at_other_frames():
    """Bent but for a stretch that is straight within noise of a hundredth of a degree to any side."""
    frames = 40
    clip = make_clip(frames, bend=0.5, sway=0.0)
    rotations = np.array(clip.rotations)
    noise = np.random.default_rng(0).normal(0.0, 2e-4, (20, 3))
    rotations[10:30, KNEE] = quaternion.exp(noise)
    clip = replace(clip, rotations=rotations)
    hip = joint_places(clip, HIP)
    result = solve_two_bone(clip, **LEG, place=hip - [0.0, 76.0, 0.0])
    assert result.reached.all()
    ahead = joint_places(result.clip, KNEE) - hip
    assert quaternion.angle_between(result.clip.rotations[11:30], result.clip.rotations[10:29])[:, KNEE].max() < 0.02
    np.testing.assert_allclose(ahead[10:30], ahead[:1].repeat(20, axis=0), atol=1.0)


def test_a_pole_tells_where_a_straight_leg_bends():
    clip = make_clip(bend=0.0, sway=0.0)
    hip = joint_places(clip, HIP)
    result = solve_two_bone(clip, **LEG, place=hip - [0.0, 70.0, 0.0], pole=np.array([1.0, 0.0, 0.0]))
    ahead = joint_places(result.clip, KNEE) - hip
    assert (ahead[:, 0] > 15.0).all()
    np.testing.assert_allclose(ahead[:, 2], 0.0, atol=1e-6)


def test_too_near_a_goal_folds_the_limb():
    clip = make_clip()
    result = solve_two_bone(clip, **LEG, place=moved(clip, HIP, [0.0, 0.0, 0.01]))
    np.testing.assert_allclose(result.distances_m, 0.01 * (1.0 - 0.01), atol=1e-6)
    assert np.isfinite(result.clip.rotations).all()


def test_equals_the_solver_where_the_swivel_is_not_used():
    """A small change in the knee's own plane: the least change is that of the two joints."""
    clip = make_clip(sway=0.0)
    hip, foot = joint_places(clip, HIP), joint_places(clip, FOOT)
    place = foot + 0.1 * (hip - foot)
    analytic = solve_two_bone(clip, **LEG, place=place)
    solved = solve_ik(clip, [Goal(joint=FOOT, place=place)], joints=[HIP, KNEE])
    changes = [np.square(quaternion.angle_between(r.clip.rotations, clip.rotations)).sum() for r in (analytic, solved)]
    assert changes[0] == pytest.approx(changes[1], rel=1e-4)
    assert quaternion.angle_between(analytic.clip.rotations, solved.clip.rotations).max() < 1e-3


def test_no_chain_is_refused():
    clip = make_clip()
    with pytest.raises(InputError, match=r"two-bone: no chain.*Leg above UpLeg"):
        solve_two_bone(clip, upper=KNEE, middle=HIP, end=FOOT, place=joint_places(clip, FOOT))


def test_a_limb_that_never_bends_needs_a_pole():
    clip = make_clip(bend=0.0, sway=0.0)
    with pytest.raises(InputError, match=r"straight at every frame and at rest.*Give a pole"):
        solve_two_bone(clip, **LEG, place=moved(clip, FOOT, [0.0, 10.0, 0.0]))


@pytest.mark.parametrize("easing", [0.0, 1.0, -1.0, np.nan])
def test_bad_easing_is_refused(easing):
    clip = make_clip()
    with pytest.raises(InputError, match="bad easing"):
        solve_two_bone(clip, **LEG, place=joint_places(clip, FOOT), easing=easing)


def test_goals_that_do_not_fit_are_refused():
    with pytest.raises(InputError, match="place does not fit"):
        solve_two_bone(make_clip(), **LEG, place=np.zeros((12, 2)))
