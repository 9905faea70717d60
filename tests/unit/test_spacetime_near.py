"""Solving again only where something changed."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.constraints.spacetime import Point, PointAt, PointStill, resolve_near, solve_spacetime
from mtex_usd.errors import InputError, NoSolutionError
from mtex_usd.motion import quaternion
from tests.spacetime_support import follow
from tests.synthetic import HEAD, LEFT_FOREARM, LEFT_KNEE, RIGHT_KNEE, walk

FRAMES = 240
CM = 0.01
HAND = Point(LEFT_FOREARM, (25.0, 0.0, 0.0))
FEET = {"left": Point(LEFT_KNEE, (0.0, -45.0, 0.0)), "right": Point(RIGHT_KNEE, (0.0, -45.0, 0.0))}
STEPS = {f"{side} {first}": (side, first) for first in range(10, 220, 28) for side in FEET}


def plant(name):
    side, first = STEPS[name]
    begin = first + 14 * (side == "right")
    return PointStill(name, FEET[side], np.arange(begin, begin + 10))


@pytest.fixture(scope="module")
def clip():
    return walk(FRAMES)


@pytest.fixture(scope="module")
def solved(clip):
    wave = PointAt("wave", HAND, [120], follow(clip, HAND)[120] + [0.0, 5.0, 0.0])
    return solve_spacetime(clip, [plant(name) for name in STEPS] + [wave])


def moved_wave(clip):
    return PointAt("wave", HAND, [120], follow(clip, HAND)[120] + [3.0, 8.0, 0.0])


def apart(a, b):
    """Largest angle between two solutions per frame, degrees."""
    return np.degrees(quaternion.angle_between(a.clips[0].rotations, b.clips[0].rotations)).max(axis=1)


def test_a_moved_constraint_is_met_and_the_others_still_are(clip, solved):
    moved = moved_wave(clip)
    solution = resolve_near(solved, moved)
    (result,) = solution.clips
    assert np.linalg.norm(follow(result, HAND)[120] - moved.place) * CM < 1e-4
    assert max(solution.residuals.values()) < 1e-4
    for name in STEPS:
        step = plant(name)
        held = follow(result, step.point)[step.frames]
        assert np.linalg.norm(held - held.mean(axis=0), axis=1).max() * CM < 2e-4


def test_what_is_far_keeps_its_bits(clip, solved):
    solution = resolve_near(solved, moved_wave(clip), margin_s=1.0)
    changed = np.flatnonzero((solution.clips[0].rotations != solved.clips[0].rotations).any(axis=(1, 2)))
    assert 120 in changed
    assert changed.min() >= 120 - 24 - 12
    assert changed.max() <= 120 + 24 + 12
    outside = np.r_[0:84, 157:FRAMES]
    np.testing.assert_array_equal(solution.clips[0].rotations[outside], solved.clips[0].rotations[outside])
    np.testing.assert_array_equal(solution.clips[0].translations[outside], solved.clips[0].translations[outside])


def test_it_comes_near_to_solving_the_whole(clip, solved):
    moved = moved_wave(clip)
    whole = solve_spacetime(clip, [*(plant(name) for name in STEPS), moved])
    near = resolve_near(solved, moved, margin_s=1.0)
    assert apart(near, solved).max() > 1.0
    assert apart(near, whole).max() < 0.1 * apart(near, solved).max()


def test_a_new_constraint_may_come_in_and_be_moved_again(clip, solved):
    place = follow(clip, Point(HEAD))[60] - [0.0, 3.0, 0.0]
    first = resolve_near(solved, PointAt("nod", Point(HEAD), [60], place))
    second = resolve_near(
        first, [PointAt("nod", Point(HEAD), [60], place + np.array([0.0, 2.0, 0.0])), moved_wave(clip)]
    )
    assert np.linalg.norm(follow(first.clips[0], Point(HEAD))[60] - place) * CM < 1e-4
    assert np.linalg.norm(follow(second.clips[0], Point(HEAD))[60] - place - [0.0, 2.0, 0.0]) * CM < 1e-4
    assert second.residuals.keys() == {*STEPS, "wave", "nod"}


def test_a_point_on_a_joint_that_nothing_moved_is_solved_over_the_whole(clip):
    wave = PointAt("wave", HAND, [120], follow(clip, HAND)[120] + 3.0)
    solved = solve_spacetime(clip, [wave])
    step = plant("left 10")
    solution = resolve_near(solved, step)
    held = follow(solution.clips[0], step.point)[step.frames]
    assert np.linalg.norm(held - held.mean(axis=0), axis=1).max() * CM < 1e-4
    assert solution.residuals.keys() == {"wave", "left 10"}


def test_points_keep_their_places_across_the_border(clip, solved):
    """The steps that last across the neighbourhood's borders are held where they were."""
    solution = resolve_near(solved, moved_wave(clip), margin_s=0.2)
    for name in STEPS:
        np.testing.assert_allclose(solution.places[name], solved.places[name], atol=2.0)
        step = plant(name)
        if step.frames[0] < 100 or step.frames[-1] > 140:
            np.testing.assert_array_equal(solution.places[name], solved.places[name])


def test_a_neighbourhood_that_is_too_small_grows():
    """The root has to travel, and in the first neighbourhood both ends of it are held."""
    clip = walk(FRAMES)
    feet = [PointAt("a", FEET["left"], [100], follow(clip, FEET["left"])[100])]
    solved = solve_spacetime(clip, feet, joint_weights=dict.fromkeys(clip.joints, np.inf))
    far = PointAt("a", FEET["left"], [100], follow(clip, FEET["left"])[100] + [30.0, 0.0, 0.0])
    solution = resolve_near(solved, far, margin_s=0.1)
    assert np.linalg.norm(follow(solution.clips[0], FEET["left"])[100] - far.place) * CM < 1e-4


def test_nothing_changed_is_the_same_solution(solved):
    assert resolve_near(solved, []) is solved


def test_what_cannot_be_met_anywhere_is_said(clip, solved):
    hand = follow(solved.clips[0], HAND)[120]
    with pytest.raises(NoSolutionError, match=r"2 of \d+ constraints cannot be met together.*wave by"):
        resolve_near(solved, PointAt("other", HAND, [120], hand + 10.0))


def test_a_bad_margin_and_shared_names_are_refused(clip, solved):
    with pytest.raises(InputError, match="bad margin of a neighbourhood; expected seconds above 0; found 0"):
        resolve_near(solved, moved_wave(clip), margin_s=0.0)
    with pytest.raises(InputError, match="constraints share a name; found wave"):
        resolve_near(solved, [moved_wave(clip), moved_wave(clip)])


def test_the_memory_is_not_changed(clip, solved):
    before = np.array(solved.memory.coefficients)
    resolve_near(solved, replace(moved_wave(clip), frames=[121]))
    np.testing.assert_array_equal(solved.memory.coefficients, before)
