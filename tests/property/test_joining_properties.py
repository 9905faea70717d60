"""Laws of joining that hold for every path."""

import itertools

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from mtex_usd.motion import quaternion
from mtex_usd.texture.joining import join_curves, join_rotations
from tests.oracle import joining as twin

SEEDS = st.integers(0, 2**32 - 1)
COUNTS = st.integers(1, 6)
JOIN_FRAMES = st.integers(0, 20)
TURN_LIMIT = 1.2  # ALGORITHM, Joining


def random_lengths(rng, count):
    return rng.integers(2, 30, size=count)


def random_fragments(rng, count):
    return [
        np.cumsum(rng.standard_normal((n, 2)), axis=0) + 30.0 * rng.standard_normal(2)
        for n in random_lengths(rng, count)
    ]


def random_rotation_fragments(rng, count, joints, speed):
    """Smooth fragments, some much faster than others, whose ends may be any way apart."""
    fragments = []
    for n in random_lengths(rng, count):
        steps = quaternion.exp(speed * rng.choice([0.1, 1.0]) * rng.standard_normal((n, joints, 3)))
        turns = [quaternion.exp(2.0 * rng.standard_normal((joints, 3)))]
        for step in steps[1:]:
            turns.append(quaternion.multiply(turns[-1], step))
        fragments.append(np.stack(turns))
    return fragments


def plain(columns):
    none = np.zeros(columns, dtype=bool)
    return {"turning": none, "sliding": none}


@given(SEEDS, COUNTS, JOIN_FRAMES)
def test_curves_equal_the_slow_twin(seed, count, join_frames):
    rng = np.random.default_rng(seed)
    fragments = random_fragments(rng, count)
    continued = rng.random(count - 1) < 0.3
    joined = join_curves(fragments, continued, join_frames, **plain(2))
    for column in range(2):
        expected = twin.join([f[:, column].tolist() for f in fragments], continued.tolist(), join_frames)
        np.testing.assert_allclose(joined[:, column], expected, rtol=0, atol=1e-8)


@given(SEEDS, st.integers(2, 6), JOIN_FRAMES)
def test_consecutive_fragments_come_back_bit_for_bit(seed, count, join_frames):
    rng = np.random.default_rng(seed)
    breaks = np.concatenate([[0], np.cumsum(random_lengths(rng, count) - 1)])
    curve = np.cumsum(rng.standard_normal((breaks[-1] + 1, 2)), axis=0)
    fragments = [curve[a : b + 1] for a, b in itertools.pairwise(breaks)]
    joined = join_curves(fragments, np.ones(count - 1, dtype=bool), join_frames, **plain(2))
    np.testing.assert_array_equal(joined, curve)


@given(SEEDS, st.integers(2, 6), JOIN_FRAMES)
def test_consecutive_rotations_come_back_to_rounding(seed, count, join_frames):
    rng = np.random.default_rng(seed)
    breaks = np.concatenate([[0], np.cumsum(random_lengths(rng, count) - 1)])
    steps = quaternion.exp(0.3 * rng.standard_normal((breaks[-1] + 1, 2, 3)))
    take = steps.copy()
    for frame in range(1, len(take)):
        take[frame] = quaternion.multiply(take[frame - 1], steps[frame])
    fragments = [take[a : b + 1] for a, b in itertools.pairwise(breaks)]
    joined = join_rotations(fragments, np.ones(count - 1, dtype=bool), join_frames)
    assert quaternion.angle_between(joined, take).max() < 1e-7
    np.testing.assert_allclose(np.abs(np.sum(joined * take, axis=-1)), 1.0, atol=1e-12)


@given(SEEDS, st.integers(1, 6), JOIN_FRAMES)
def test_first_and_last_frame_of_a_path_stay(seed, count, join_frames):
    rng = np.random.default_rng(seed)
    fragments = random_fragments(rng, count)
    joined = join_curves(fragments, np.zeros(count - 1, dtype=bool), join_frames, **plain(2))
    np.testing.assert_allclose(joined[[0, -1]], [fragments[0][0], fragments[-1][-1]], atol=1e-9)


@given(SEEDS, st.integers(2, 6), st.integers(0, 2))
def test_rotations_meet_half_way_where_nothing_is_blended(seed, count, join_frames):
    rng = np.random.default_rng(seed)
    fragments = random_rotation_fragments(rng, count, 2, 0.1)
    joined = join_rotations(fragments, np.zeros(count - 1, dtype=bool), join_frames)
    at = 0
    for left, right in itertools.pairwise(fragments):
        at += len(left) - 1
        gap = quaternion.angle_between(left[-1], right[0])
        # Half way is not unique for turns half a circle apart.
        assume(gap.max() < np.pi - 1e-6)
        np.testing.assert_allclose(quaternion.angle_between(joined[at], left[-1]), 0.5 * gap, atol=1e-6)
        np.testing.assert_allclose(quaternion.angle_between(joined[at], right[0]), 0.5 * gap, atol=1e-6)


@given(SEEDS, st.integers(2, 5), st.integers(0, 16), st.sampled_from([0.0, 0.02, 0.1, 0.4]))
def test_no_joint_turns_faster_near_a_join_than_its_fragments_and_gaps_account_for(seed, count, join_frames, speed):
    """1.2 x (fastest turn of the stretched fragment + half the gaps at its two joins spread over its frames)."""
    rng = np.random.default_rng(seed)
    fragments = random_rotation_fragments(rng, count, 3, speed)
    joined = join_rotations(fragments, np.zeros(count - 1, dtype=bool), join_frames)
    turns = quaternion.angle_between(joined[:-1], joined[1:])
    gaps = [quaternion.angle_between(a[-1], b[0]) for a, b in itertools.pairwise(fragments)]
    gaps = [np.zeros(3), *gaps, np.zeros(3)]
    at = 0
    for number, fragment in enumerate(fragments):
        steps = len(fragment) - 1
        fastest = quaternion.angle_between(fragment[:-1], fragment[1:]).max(axis=0)
        limit = TURN_LIMIT * (fastest + 0.5 * (gaps[number] + gaps[number + 1]) / steps)
        assert np.all(turns[at : at + steps].max(axis=0) <= limit + 1e-7)
        at += steps


@given(SEEDS, st.integers(2, 6), JOIN_FRAMES)
def test_frames_further_than_n_from_every_join_are_only_skewed(seed, count, join_frames):
    rng = np.random.default_rng(seed)
    fragments = random_rotation_fragments(rng, count, 1, 0.1)
    apart = np.zeros(count - 1, dtype=bool)
    blended, skewed = join_rotations(fragments, apart, join_frames), join_rotations(fragments, apart, 0)
    joins = np.cumsum([len(f) - 1 for f in fragments])[:-1]
    frames = np.arange(len(blended))
    far = np.abs(frames[:, None] - joins).min(axis=1) >= join_frames
    assert quaternion.angle_between(blended[far], skewed[far]).max(initial=0.0) < 1e-7


@given(SEEDS, st.integers(2, 5), JOIN_FRAMES)
def test_turning_a_whole_path_commutes_with_joining(seed, count, join_frames):
    """Rotations are composed, not added: no axis is special."""
    rng = np.random.default_rng(seed)
    fragments = random_rotation_fragments(rng, count, 1, 0.1)
    gaps = [quaternion.angle_between(a[-1], b[0]) for a, b in itertools.pairwise(fragments)]
    assume(np.max(gaps) < np.pi - 1e-3)
    turn = quaternion.normalize(rng.standard_normal(4))
    apart = np.zeros(count - 1, dtype=bool)
    joined = join_rotations(fragments, apart, join_frames)
    of_turned = join_rotations([quaternion.multiply(turn, f) for f in fragments], apart, join_frames)
    assert quaternion.angle_between(quaternion.multiply(turn, joined), of_turned).max() < 1e-6
