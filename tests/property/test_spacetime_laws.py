"""Laws of the spacetime solve on random motions and constraints."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mtex_usd.constraints.spacetime import PlaneAbove, Point, PointAt, PointStill, solve_spacetime
from mtex_usd.constraints.spacetime.cost import cost_diagonals
from mtex_usd.constraints.spacetime.elimination import Layout, RowSystem, factorize, solve_factors
from mtex_usd.constraints.spacetime.knots import split_spans, uniform_knots
from mtex_usd.motion import quaternion
from tests.oracle.spacetime import cost_matrix
from tests.spacetime_support import follow
from tests.synthetic import JOINTS, LEFT_FOREARM, LEFT_KNEE, RIGHT_KNEE, make_skeleton, walk

SEEDS = st.integers(0, 2**32 - 1)
CM = 0.01
EXACT = 1e-7  # metres: within a tolerance, rounding decides which of many motions is found


def random_walk(rng, frames=30):
    return walk(frames, seed=int(rng.integers(1000)), skeleton=make_skeleton(oriented=int(rng.integers(1000))))


def random_wishes(rng, clip, tolerance=1e-4):
    """A reach, a step and a floor, on joints with random axes."""
    hand, foot, other = (
        Point(joint, tuple(rng.uniform(-20.0, 20.0, 3))) for joint in (LEFT_FOREARM, LEFT_KNEE, RIGHT_KNEE)
    )
    first, frame = (int(value) for value in rng.integers(0, 20, 2))
    floor = float(np.quantile(follow(clip, other)[:, 1], 0.3))
    return [
        PointAt("hand", hand, [frame], follow(clip, hand)[frame] + rng.uniform(-6.0, 6.0, 3), tolerance=tolerance),
        PointStill("step", foot, np.arange(first, first + 8), tolerance=tolerance),
        PlaneAbove("floor", other, np.arange(clip.frame_count), floor),
    ]


@settings(max_examples=15)
@given(SEEDS)
def test_constraints_are_met_and_what_none_is_about_keeps_its_bits(seed):
    rng = np.random.default_rng(seed)
    clip = random_walk(rng)
    wishes = random_wishes(rng, clip)
    (result,) = solve_spacetime(clip, wishes).clips
    hand, step, floor = wishes
    assert np.linalg.norm(follow(result, hand.point)[hand.frames[0]] - hand.place) * CM < 1.01e-4
    held = follow(result, step.point)[step.frames]
    assert np.linalg.norm(held - held.mean(axis=0), axis=1).max() * CM < 2e-4
    assert follow(result, floor.point)[:, 1].min() > floor.height - 0.0101
    head, right_arm = JOINTS.index("Hips/Spine/Head"), JOINTS.index("Hips/Spine/RightArm")
    np.testing.assert_array_equal(result.rotations[:, [head, right_arm]], clip.rotations[:, [head, right_arm]])
    np.testing.assert_array_equal(result.translations[:, 1:], clip.translations[:, 1:])
    np.testing.assert_allclose(np.linalg.norm(result.rotations, axis=2), 1.0, atol=1e-12)


@settings(max_examples=8)
@given(SEEDS)
def test_solving_twice_is_solving_once(seed):
    rng = np.random.default_rng(seed)
    clip = random_walk(rng)
    hand, _, floor = random_wishes(rng, clip)
    once = solve_spacetime(clip, [hand, floor]).clips[0]
    twice = solve_spacetime(once, [hand, floor])
    assert twice.iterations == 0
    assert twice.clips[0].rotations.tobytes() == once.rotations.tobytes()


@settings(max_examples=8)
@given(SEEDS)
def test_where_the_stage_stands_does_not_matter(seed):
    """Turned about up and moved, with its constraints, a motion changes as it did."""
    rng = np.random.default_rng(seed)
    clip = random_walk(rng)
    hand, step, _ = random_wishes(rng, clip, EXACT)
    angle, shift = rng.uniform(-3.0, 3.0), rng.uniform(-500.0, 500.0, 3)
    turn = quaternion.exp(np.array([0.0, angle, 0.0]))
    here = solve_spacetime(clip, [hand, step])
    moved = _placed(clip, turn, shift)
    there_hand = replace(hand, place=quaternion.rotate(turn, hand.place) + shift)
    there = solve_spacetime(moved, [there_hand, step])
    expected, found = (solution.displacements[0].rotations for solution in (here, there))
    np.testing.assert_allclose(found, expected, atol=1e-3)


def _placed(clip, turn, shift):
    rotations, translations = np.array(clip.rotations), np.array(clip.translations)
    rotations[:, 0] = quaternion.multiply(turn, rotations[:, 0])
    translations[:, 0] = quaternion.rotate(turn, translations[:, 0]) + shift
    return replace(clip, rotations=rotations, translations=translations)


@given(SEEDS)
def test_the_elimination_solves_the_whole_system(seed):
    """Against the same equations as one dense matrix, with places that live for random stretches of time."""
    rng = np.random.default_rng(seed)
    layout, rows = _random_system(rng)
    matrix = _dense(layout, rows)
    right = rng.standard_normal(layout.size)
    found = solve_factors(factorize(layout, rows), right)
    np.testing.assert_allclose(matrix @ found, right, atol=1e-7 * np.abs(matrix).max())


def _random_system(rng):
    frames, channels, places = int(rng.integers(8, 40)), int(rng.integers(1, 5)), int(rng.integers(0, 5))
    knots = split_spans(uniform_knots(frames, 2.0), rng.integers(0, frames, 3), reach=1)
    ends = np.sort(rng.integers(0, frames, (places, 2)), axis=1)
    kept = tuple(int(value) for value in rng.choice([0, 3], 2)) if knots.count > 9 else (0, 0)
    cost = cost_diagonals(knots, cycles_per_frame=0.25, smoothness=1.0, highpass=0.5)
    layout = Layout(
        knots=knots,
        cost=cost,
        weights=rng.uniform(0.5, 2.0, channels),
        place_first=ends[:, 0],
        place_last=ends[:, 1],
        kept=kept,
    )
    held = [
        (frame, place)
        for place, (a, b) in enumerate(ends)
        for frame in {a, b, *rng.integers(a, b + 1, 3)}
        for _ in "xyz"
    ]
    free = [(int(frame), -1) for frame in rng.integers(0, frames, 10)]
    listed = sorted(held + free)
    return layout, RowSystem(
        frame=np.array([frame for frame, _ in listed]),
        jacobian=rng.standard_normal((len(listed), channels)),
        place=np.array([place for _, place in listed]),
        normal=rng.standard_normal((len(listed), 3)),
    )


def _dense(layout, rows):
    knots, channels = layout.knots, layout.channel_count
    free = slice(layout.kept[0], knots.count - layout.kept[1])
    padded = layout.block_count * layout.block_size
    out = np.diag(np.concatenate([np.resize(layout.weights, padded), np.zeros(layout.size - padded)]))
    cost = sum(np.diag(row[: knots.count - i], i) for i, row in enumerate(layout.cost))
    cost = (cost + np.triu(cost, 1).T)[free, free]
    count = len(cost) * channels
    out[:count, :count] = np.kron(cost, np.diag(layout.weights))
    wide = np.zeros((len(rows.frame), layout.size))
    basis = knots.matrix.toarray()[rows.frame][:, free]
    wide[:, :count] = (basis[:, :, None] * rows.jacobian[:, None, :]).reshape(len(wide), -1)
    for row, place in enumerate(rows.place):
        if place >= 0:
            wide[row, padded + 3 * place : padded + 3 * place + 3] = -rows.normal[row]
    return out + wide.T @ wide


@given(st.integers(2, 60), st.floats(1.0, 5.0), SEEDS)
def test_splines_are_scipys_and_finer_knots_keep_them(frames, spacing, seed):
    rng = np.random.default_rng(seed)
    coarse = uniform_knots(frames, spacing)
    fine = split_spans(coarse, rng.integers(0, frames, 3), reach=1)
    for knots in (coarse, fine):
        basis, matrix = cost_matrix(knots.extended, frames, 3.0, 0.2)
        np.testing.assert_allclose(knots.matrix.toarray(), basis, atol=1e-12)
        ours = cost_diagonals(knots, cycles_per_frame=0.2, smoothness=3.0, highpass=0.0)
        for offset, row in enumerate(ours):
            np.testing.assert_allclose(row[: knots.count - offset], np.diag(matrix, offset), atol=1e-7 * matrix.max())
    values = coarse.matrix @ rng.standard_normal(coarse.count)
    left = values - fine.matrix @ np.linalg.lstsq(fine.matrix.toarray(), values, rcond=None)[0]
    assert np.abs(left).max() < 1e-9
    assert set(coarse.breaks) <= set(fine.breaks)
