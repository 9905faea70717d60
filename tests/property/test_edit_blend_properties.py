"""Laws of blending and joining motions."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mtex_usd.edit import blend, join
from mtex_usd.edit.mixing import average_rotations, make_strand
from mtex_usd.motion import quaternion
from tests.oracle import edit_blend as oracle
from tests.synthetic import random_rotations, turned, walk

SEEDS = st.integers(0, 2**32 - 1)
WEIGHTS = st.floats(-1.0, 2.0)


def angle(a, b):
    return float(quaternion.angle_between(a.rotations, b.rotations).max())


@settings(max_examples=25)
@given(SEEDS, st.integers(2, 40), WEIGHTS, WEIGHTS)
def test_a_motion_blended_with_itself_is_itself(seed, frames, first, second):
    clip = walk(frames, seed=seed)
    for result in (
        blend(clip, clip, weights=first),
        blend(clip, [clip, clip], weights=[first, second]),
        blend(clip, clip, weights=np.linspace(first, second, frames), align_first=True),
    ):
        assert angle(result.clip, clip) < 1e-12
        np.testing.assert_allclose(result.clip.translations, clip.translations, atol=1e-9)
        np.testing.assert_allclose(result.weights.sum(axis=1), 1.0, atol=1e-15)
        assert result.distances.max() == 0.0


@settings(max_examples=25)
@given(SEEDS, st.integers(2, 40), st.floats(-180.0, 180.0))
def test_weights_of_nought_and_one_keep_every_bit(seed, frames, degrees):
    motions = [walk(frames, seed=seed), walk(frames, seed=seed + 1, heading=degrees), walk(frames, seed=seed + 2)]
    for weights, expected in (([0.0, 0.0], 0), ([1.0, 0.0], 1), ([0.0, 1.0], 2)):
        mixed = blend(motions[0], motions[1:], weights=weights).clip
        np.testing.assert_array_equal(mixed.rotations, motions[expected].rotations)
        np.testing.assert_array_equal(mixed.translations, motions[expected].translations)


@settings(max_examples=25)
@given(SEEDS, st.integers(4, 40))
def test_a_ramp_begins_as_the_one_and_ends_as_the_other(seed, frames):
    clip, other = walk(frames, seed=seed), walk(frames, seed=seed + 1, heading=70.0)
    ramp = np.clip(np.linspace(-0.5, 1.5, frames), 0.0, 1.0)
    mixed = blend(clip, other, weights=ramp).clip
    np.testing.assert_array_equal(mixed.rotations[ramp == 0.0], clip.rotations[ramp == 0.0])
    np.testing.assert_array_equal(mixed.translations[ramp == 0.0], clip.translations[ramp == 0.0])
    np.testing.assert_array_equal(mixed.rotations[ramp == 1.0, 1:], other.rotations[ramp == 1.0, 1:])


@settings(max_examples=30)
@given(SEEDS, st.integers(2, 30), WEIGHTS, st.floats(-180.0, 180.0))
def test_turning_all_motions_turns_the_blend(seed, frames, weight, degrees):
    clip, other = walk(frames, seed=seed), walk(frames, seed=seed + 1, heading=30.0)
    one = turned(blend(clip, other, weights=weight).clip, degrees)
    both = blend(turned(clip, degrees), turned(other, degrees), weights=weight).clip
    assert angle(one, both) < 1e-7
    np.testing.assert_allclose(one.translations, both.translations, atol=1e-7)


@settings(max_examples=30)
@given(SEEDS, st.integers(2, 30), st.floats(-179.0, 179.0), WEIGHTS)
def test_the_way_another_motion_faces_does_not_count(seed, frames, degrees, weight):
    """Begun where the clip begins, the blend is the same whichever way the other went."""
    clip, other = walk(frames, seed=seed), walk(frames, seed=seed + 1)
    one = blend(clip, other, weights=weight, place="first").clip
    same = blend(clip, turned(other, degrees), weights=weight, place="first").clip
    assert angle(one, same) < 1e-6
    np.testing.assert_allclose(one.translations, same.translations, atol=1e-6)


@given(SEEDS, WEIGHTS)
def test_two_rotations_equal_the_slow_twin(seed, weight):
    rng = np.random.default_rng(seed)
    a, b = random_rotations(rng, 2)
    found = average_rotations([a[None, None], b[None, None]], np.array([[1.0 - weight, weight]]))[0, 0]
    assert abs(abs(found @ oracle.between(a, b, weight)) - 1.0) < 1e-9


@settings(max_examples=25)
@given(SEEDS, st.lists(st.floats(0.0, 1.0), min_size=3, max_size=5))
def test_many_rotations_equal_the_slow_twin(seed, parts):
    rng = np.random.default_rng(seed)
    rotations = quaternion.multiply(random_rotations(rng), quaternion.exp(0.5 * rng.standard_normal((len(parts), 3))))
    weights = (np.array(parts) + 0.1) / (np.array(parts) + 0.1).sum()
    found = average_rotations(list(rotations[:, None, None]), weights[None])[0, 0]
    assert abs(abs(found @ oracle.mean_rotation(rotations, weights)) - 1.0) < 1e-9


@settings(max_examples=30)
@given(SEEDS, st.integers(3, 30), st.lists(WEIGHTS, min_size=2, max_size=2), st.floats(-90.0, 90.0))
def test_the_way_equals_the_slow_twin(seed, frames, ends, degrees):
    clip, other = walk(frames, seed=seed), walk(frames, seed=seed + 1, heading=degrees)
    ramp = np.linspace(*ends, frames)
    strands = [make_strand(each, 0) for each in (clip, other)]
    headings = np.array([strand.heading for strand in strands])
    headings[1] -= 2.0 * np.pi * np.round((headings[1][0] - headings[0][0]) / (2.0 * np.pi))
    positions = np.array([strand.positions for strand in strands])
    expected = oracle.walk_on(headings, positions, np.stack([1.0 - ramp, ramp], axis=1))
    mixed = blend(clip, other, weights=ramp).clip
    np.testing.assert_allclose(mixed.translations[:, 0][:, [0, 2]], expected, atol=1e-7)
    heights = (1.0 - ramp) * positions[0][:, 1] + ramp * positions[1][:, 1]
    np.testing.assert_allclose(mixed.translations[:, 0, 1], heights, atol=1e-9)


@settings(max_examples=25)
@given(SEEDS, st.integers(2, 60), st.integers(2, 60), st.floats(-180.0, 180.0))
def test_joined_motions_keep_what_is_outside_the_window(seed, frames, others, degrees):
    clip, other = walk(frames, seed=seed), walk(others, seed=seed + 1, heading=degrees)
    result = join(clip, other)
    head = result.first
    tail = result.clip.frame_count - 1 - result.last
    np.testing.assert_array_equal(result.clip.rotations[:head], clip.rotations[:head])
    np.testing.assert_array_equal(result.clip.translations[:head], clip.translations[:head])
    np.testing.assert_array_equal(result.clip.rotations[-tail:, 1:], other.rotations[-tail:, 1:])
    steps = [np.linalg.norm(np.diff(each.translations[:, 0], axis=0), axis=1) for each in (result.clip, other)]
    np.testing.assert_allclose(steps[0][len(steps[0]) - tail + 1 :], steps[1][len(steps[1]) - tail + 1 :], atol=1e-9)


@settings(max_examples=25)
@given(SEEDS, st.integers(2, 90))
def test_a_closed_loop_ends_in_its_first_pose(seed, frames):
    clip = walk(frames, seed=seed)
    cycle = join(clip, replace(clip)).clip
    np.testing.assert_array_equal(cycle.rotations[0, 1:], cycle.rotations[-1, 1:])
    heights = cycle.translations[[0, -1], 0, 1]
    assert abs(heights[0] - heights[1]) < 1e-9
