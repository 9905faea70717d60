"""Pose keys: which stretches one slerp can follow, the path through them, and fits whose largest error is small."""

import numpy as np
import pytest

from mtex_usd.edit import reduce_poses
from mtex_usd.edit.keys.body import angles_apart, read_body
from mtex_usd.edit.keys.refining import Goal, Refiner, Spans
from mtex_usd.edit.keys.sampled import angles_to_turns, play_between, turns_to_angles
from mtex_usd.edit.keys.stretches import measure_stretches
from mtex_usd.motion import quaternion
from tests.benchmarks.pose_bound import count_needed_poses, find_reach
from tests.cleaning_support import add_noise, make_walk
from tests.oracle import edit_keys as oracle
from tests.synthetic import walk

ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")


def shake(frames, seed, degrees=1.0):
    """Rotations [F, 1, 4] about one axis, and their angles."""
    angles = np.cumsum(np.random.default_rng(seed).normal(scale=degrees, size=frames))
    return quaternion.exp(np.radians(angles)[:, None, None] * np.array([0.6, 0.0, 0.8])), angles


@pytest.mark.parametrize("order", ORDERS)
def test_angles_and_turns_are_each_other_s_inverse(order):
    angles = np.random.default_rng(3).uniform(-85.0, 85.0, (3, 50))
    turns = angles_to_turns(angles, order)
    assert oracle.angles_between(quaternion.from_euler(angles.T, order), turns.T).max() < 1e-6
    for sign in (1.0, -1.0):
        np.testing.assert_allclose(turns_to_angles(sign * turns, order), angles, atol=1e-9)


def test_bodies_are_placed_as_joint_after_joint():
    clip = make_walk(12, oriented=5)
    body = read_body(clip)
    for frame in (0, 5, 11):
        expected = oracle.place_joints(clip.parents, clip.rotations[frame], clip.translations[frame])
        np.testing.assert_allclose(body.places[..., frame], expected, atol=1e-12)
    rotations, translations = body.to_local(clip.skeleton)
    assert quaternion.angle_between(rotations, clip.rotations).max() < 1e-12
    np.testing.assert_allclose(translations, clip.translations, atol=1e-12)


def test_a_changed_body_is_what_it_would_be_from_the_start():
    before, after = read_body(make_walk(12, oriented=5)), read_body(add_noise(make_walk(12, oriented=5), 5.0))
    joints = np.arange(len(before.parents)) == 3
    turns = np.where(joints[:, None, None], after.turns, before.turns)
    changed = before.change(joints, turns, before.arms)
    fresh = type(before)(before.parents, turns, before.arms)
    np.testing.assert_allclose(changed.places, fresh.places, atol=1e-12)
    np.testing.assert_allclose(changed.total_turns, fresh.total_turns, atol=1e-12)
    assert (changed.places != before.places).any()


def test_a_part_of_a_body_is_placed_like_the_whole():
    body = read_body(make_walk(12, oriented=5))
    joints = np.flatnonzero(body.list_below(np.arange(len(body.parents)) == 0))[:4]
    np.testing.assert_allclose(body.only(joints).places, body.places[joints], atol=1e-12)


def test_stretches_are_possible_where_a_line_is_near_enough():
    rotations, angles = shake(40, 1)
    stretches = measure_stretches(rotations, np.radians(1.0), (0, 39))
    wrong = 0
    for number, length in enumerate(stretches.lengths.tolist()):
        for start in range(40 - length):
            error = oracle.line_error(angles[start : start + length + 1])
            possible = np.isfinite(stretches.prices[number, start])
            # Weights that have not settled overrate the least error a little; never underrate it.
            assert not possible or error <= 1.001
            wrong += not possible and error < 0.97
    assert wrong == 0


def test_no_stretch_passes_a_fixed_frame():
    rotations, _ = shake(40, 2, degrees=0.01)
    stretches = measure_stretches(rotations, np.radians(1.0), (0, 17, 18, 39))
    assert {0, 17, 18, 39} <= set(stretches.find_path(1.0).tolist())
    assert len(stretches.find_path(1.0)) < 12


def test_paths_have_the_fewest_keys_and_avoid_what_has_become_dear():
    rotations, angles = shake(40, 3)
    stretches = measure_stretches(rotations, np.radians(1.0), (0, 39))

    def is_possible(start, end):
        number = np.searchsorted(stretches.lengths, end - start)
        return number < len(stretches.lengths) and np.isfinite(stretches.prices[number, start])

    path = stretches.find_path(1e6)
    assert len(path) == oracle.fewest_keys(is_possible, len(angles))
    stretches.raise_prices(path, np.full(40, 99.0))
    assert set(path.tolist()) != set(stretches.find_path(1.0).tolist())


def test_refined_poses_pass_the_limits_by_less_than_least_squares():
    clip = add_noise(walk(60, seed=3, rate=120.0), 0.3)
    body, frames = read_body(clip), np.append(np.arange(0, 57, 3), 59)
    refiner = Refiner(Goal(body, 0.8, np.inf, np.ones(len(clip.joints), dtype=bool)))
    spans = Spans(frames, np.zeros(len(frames), dtype=bool))
    keys, passed = refiner.refine(spans, body.take(frames), rounds=40)
    np.testing.assert_allclose(angles_apart(spans.turn(keys.turns), body.turns).max(axis=0), 0.8 * passed, atol=1e-9)
    squares = np.stack([oracle.fit_linear_keys(clip.rotations[:, j], frames) for j in range(len(clip.joints))], axis=1)
    off = oracle.angles_between(squares, clip.rotations).max(axis=1)
    assert np.maximum(passed - 1.0, 0.0).sum() < 0.5 * np.maximum(off / 0.8 - 1.0, 0.0).sum()


def test_pinned_poses_stay():
    clip = add_noise(walk(30, seed=3), 0.5)
    body, frames = read_body(clip), np.arange(0, 30, 29)
    goal = Goal(body, 0.5, np.inf, np.ones(len(clip.joints), dtype=bool))
    keys, _ = Refiner(goal).refine(Spans(frames, np.array([True, False])), body.take(frames), rounds=8)
    np.testing.assert_allclose(keys.turns[..., 0], body.turns[..., 0], atol=1e-12)
    assert np.abs(keys.turns[..., 1] - body.turns[..., 29]).max() > 1e-3


def test_a_motion_made_of_slerps_comes_down_to_their_keys():
    sparse = walk(6, seed=2, rate=10.0)
    clip = play_between(sparse, 10)
    reduced = reduce_poses(clip, tolerance_deg=0.1, tolerance_m=0.001)
    assert reduced.key_count == 6
    assert count_needed_poses(clip.rotations, 0.1) <= 6


@pytest.mark.parametrize("noise", [0.0, 0.3, 1.0])
def test_poses_are_few_for_what_any_method_needs(noise):
    clip = add_noise(walk(120, rate=60.0, seed=4), noise)
    needed = count_needed_poses(clip.rotations, 0.5)
    assert needed <= reduce_poses(clip, tolerance_m=np.inf).key_count <= 1.15 * needed + 2


def test_the_bound_reaches_as_far_as_a_line_does():
    rotations, angles = shake(30, 5)
    reach = find_reach(rotations, 1.0)
    for start in range(29):
        lengths = [n for n in range(1, 30 - start) if oracle.line_error(angles[start : start + n + 1]) <= 1.0]
        assert reach[start] >= max(lengths)
        assert oracle.line_error(angles[start : start + reach[start] + 1]) <= 1.02
