"""Laws of aligning motions and of finding transitions."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mtex_usd.edit import TimeWarp, align, find_transition, warp_time
from mtex_usd.edit.dynamic_warping import find_path
from mtex_usd.edit.pose_features import common_joints, pose_positions
from mtex_usd.errors import InputError
from tests.oracle import edit_align as oracle
from tests.synthetic import turned, walk

SEEDS = st.integers(0, 2**32 - 1)


@settings(max_examples=150)
@given(SEEDS, st.integers(2, 14), st.integers(2, 14), st.integers(1, 6), st.integers(1, 4), st.integers(0, 3))
def test_cost_equals_the_slow_twin(seed, rows, columns, band, steepest, free):
    free = min(free, min(rows, columns) - 1)
    distances = np.random.default_rng(seed).uniform(0.0, 1.0, (rows, columns))
    path = find_path(
        lambda row, begin, end: distances[row, begin:end], distances.shape, band=band, steepest=steepest, free=free
    )
    expected = oracle.warping_cost(distances, band=band, steepest=steepest, free=free)
    if path is None:
        assert expected == np.inf
        return
    assert abs(path.cost - expected) < 1e-12
    steps = np.diff(path.cells, axis=0)
    assert (steps >= 0).all()
    assert (steps.max(axis=1, initial=0) <= 1).all()
    assert (path.cells[0].min(), path.cells[-1][0] == rows - 1 or path.cells[-1][1] == columns - 1) == (0, True)


@settings(max_examples=25)
@given(SEEDS, st.integers(2, 80), st.floats(-180.0, 180.0))
def test_a_motion_aligned_with_itself_stays_as_it_is(seed, frames, degrees):
    clip = walk(frames, seed=seed)
    found = align(clip, turned(clip, degrees))
    np.testing.assert_allclose(found.pairs[:, 0], found.pairs[:, 1], atol=1e-9)
    np.testing.assert_array_equal(found.path[:, 0], found.path[:, 1])
    assert found.cost < 1e-9


@settings(max_examples=25)
@given(SEEDS, st.integers(30, 90), st.floats(-0.12, 0.12), st.floats(0.8, 1.25))
def test_a_known_warp_is_found(seed, frames, bend, stretch):
    """To the sampling: a walk at 24 frames/s moves a foot by 15 cm between two of them."""
    clip = walk(frames, seed=seed)
    last = frames - 1
    warp = TimeWarp(np.array([(0.0, 0.0), (0.5 * last, (0.5 + bend) * stretch * last), (last, stretch * last)]))
    warped = warp_time(clip, pairs=warp.pairs)
    found = align(warped, clip)
    frames_there = np.arange(warped.frame_count, dtype=float)
    error = TimeWarp(found.inverse.pairs).source_times(frames_there)[0] - warp.source_times(frames_there)[0]
    assert np.abs(error).max() < 1.5
    assert np.abs(error).mean() < 0.5


@settings(max_examples=25)
@given(SEEDS, st.integers(20, 60), st.integers(20, 60))
def test_both_ways_cost_the_same(seed, frames, others):
    clip, other = walk(frames, seed=seed), walk(others, seed=seed + 1)
    try:
        one, back = align(clip, other, max_slope=4, band_s=10.0), align(other, clip, max_slope=4, band_s=10.0)
    except InputError:
        assert max(frames, others) > 3 * min(frames, others)
        return
    assert abs(one.cost - back.cost) < 1e-12
    np.testing.assert_array_equal(one.inverse.pairs, one.pairs[:, ::-1])


@settings(max_examples=10)
@given(SEEDS, st.integers(12, 24), st.integers(12, 24), st.booleans())
def test_transition_equals_the_slow_twin(seed, frames, others, to_itself):
    clip = walk(frames if not to_itself else 30, seed=seed)
    other = clip if to_itself else walk(others, seed=seed + 1)
    found = find_transition(clip, other, window_s=0.25)
    joints = common_joints(clip, other)
    half = max(1, round(0.5 * 0.25 * clip.rate))
    expected = oracle.best_transition(
        pose_positions(clip, joints.of_clip),
        pose_positions(other, joints.of_other),
        rate=clip.rate,
        half=half,
        least=max(2 * half, 12) if to_itself else None,
    )
    assert abs(found.distance - expected[0]) < 1e-6
    assert (found.frame, found.other_frame) == expected[1:]
