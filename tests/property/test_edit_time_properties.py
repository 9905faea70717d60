"""Laws of shifting, scaling and warping time that hold for every motion."""

from dataclasses import replace

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mtex_usd.edit import TimeWarp, scale_time, shift_time, warp_time
from mtex_usd.edit.sampling import sample_curves
from mtex_usd.motion import quaternion
from tests.oracle import edit_time as oracle
from tests.synthetic import turned, walk

SEEDS = st.integers(0, 2**32 - 1)
ENDS = st.sampled_from(["hold", "loop", "extrapolate"])


def same_bits(a, b):
    names = ("rotations", "translations", "scales")
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in names)


@st.composite
def increasing_pairs(draw):
    """Correspondences that neither cross nor coincide."""
    count = draw(st.integers(1, 6))
    steps = draw(st.lists(st.tuples(st.floats(0.5, 20.0), st.floats(0.5, 20.0)), min_size=count, max_size=count))
    begin = np.array(draw(st.tuples(st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))))
    return begin + np.cumsum(np.array(steps), axis=0)


@settings(max_examples=40)
@given(SEEDS, st.integers(2, 40), ENDS)
def test_identities_keep_every_bit(seed, frames, ends):
    clip = walk(frames, seed=seed)
    last = frames - 1
    for same in (
        shift_time(clip, shift_s=0.0, ends=ends),
        scale_time(clip, factor=1.0, ends=ends),
        warp_time(clip, pairs=[(0, 0)], ends=ends),
        warp_time(clip, pairs=[(0, 0), (0.3 * last, 0.3 * last), (last, last)], ends=ends),
    ):
        assert same_bits(same, clip)


@settings(max_examples=40)
@given(SEEDS, st.integers(2, 40), st.integers(-50, 50), ENDS)
def test_whole_frames_are_shifted_bit_for_bit(seed, frames, shift, ends):
    clip = walk(frames, seed=seed)
    shifted = shift_time(clip, shift_s=shift / clip.rate, ends=ends)
    assert shifted.frame_count == frames
    kept = max(frames - abs(shift), 0)
    new, old = (slice(shift, None), slice(0, kept)) if shift >= 0 else (slice(0, kept), slice(-shift, None))
    np.testing.assert_array_equal(shifted.rotations[new][:kept], clip.rotations[old])
    np.testing.assert_array_equal(shifted.translations[new][:kept], clip.translations[old])


@settings(max_examples=40)
@given(SEEDS, st.integers(2, 40), st.floats(0.2, 5.0), ENDS)
def test_scaling_gives_the_length_and_unit_quaternions(seed, frames, factor, ends):
    clip = walk(frames, seed=seed)
    scaled = scale_time(clip, factor=factor, ends=ends)
    assert scaled.frame_count == max(int(np.floor((frames - 1) * factor + 1e-6)) + 1, 2)
    assert (scaled.rate, scaled.start) == (clip.rate, clip.start)
    np.testing.assert_allclose(np.linalg.norm(scaled.rotations, axis=-1), 1.0, atol=1e-12)


@settings(max_examples=40)
@given(SEEDS, st.integers(8, 40), st.floats(0.3, 3.0), ENDS, st.floats(-180.0, 180.0))
def test_turning_the_whole_motion_commutes(seed, frames, factor, ends, degrees):
    """Nothing depends on the way the character faces."""
    clip = walk(frames, seed=seed)
    one = turned(scale_time(clip, factor=factor, ends=ends, frame_count=2 * frames), degrees)
    other = scale_time(turned(clip, degrees), factor=factor, ends=ends, frame_count=2 * frames)
    np.testing.assert_allclose(one.translations, other.translations, atol=1e-7)
    assert quaternion.angle_between(one.rotations, other.rotations).max() < 1e-7


@given(increasing_pairs())
def test_exchanged_pairs_are_the_inverse(pairs):
    warp = TimeWarp(pairs)
    frames = np.linspace(pairs[0, 1] - 10.0, pairs[-1, 1] + 10.0, 200)
    times, speeds = warp.source_times(frames)
    back, inverse_speeds = warp.inverse.source_times(times)
    np.testing.assert_allclose(back, frames, atol=1e-9)
    np.testing.assert_allclose(speeds * inverse_speeds, 1.0, rtol=1e-6)


@given(increasing_pairs())
def test_warps_go_through_their_pairs_and_never_back(pairs):
    warp = TimeWarp(pairs)
    np.testing.assert_allclose(warp.source_times(pairs[:, 1])[0], pairs[:, 0], atol=1e-9)
    times, speeds = warp.source_times(np.linspace(pairs[0, 1] - 10.0, pairs[-1, 1] + 10.0, 300))
    assert (np.diff(times) > 0.0).all()
    assert (speeds > 0.0).all()


@given(increasing_pairs())
def test_warp_equals_the_slow_twin(pairs):
    points = oracle.curve_points(pairs.tolist(), count=60)
    np.testing.assert_allclose(TimeWarp(pairs).source_times(points[:, 1])[0], points[:, 0], atol=1e-8)


@given(
    SEEDS, st.integers(2, 30), st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(1.01, 6.0)), min_size=1, max_size=6)
)
def test_filter_equals_the_slow_twin(seed, frames, wanted):
    curve = np.cumsum(np.random.default_rng(seed).standard_normal(frames))
    assume(np.ptp(curve) > 0.0)
    times = np.array([where for where, _ in wanted]) * (frames - 1)
    speeds = np.array([speed for _, speed in wanted])
    expected = [oracle.low_pass_at(curve, time, speed) for time, speed in zip(times, speeds, strict=True)]
    found = sample_curves(curve[:, None], times, speeds)[:, 0]
    np.testing.assert_allclose(found, expected, atol=1e-8 * max(1.0, float(np.abs(curve).max())))


@settings(max_examples=40)
@given(SEEDS, st.integers(3, 30), st.floats(-20.0, 20.0), ENDS)
def test_a_spin_at_even_speed_keeps_its_even_speed(seed, frames, shift, ends):
    """Interpolation, extrapolation and loops of what is even are even."""
    clip = walk(frames, seed=seed)
    spin = np.linspace(0.0, 0.05 * (frames - 1), frames)[:, None] * np.array([0.0, 1.0, 0.0])
    rotations = np.tile(clip.skeleton.rest_rotations, (frames, 1, 1))
    rotations[:, 1] = quaternion.exp(spin)
    even = replace(clip, rotations=rotations, translations=np.tile(clip.translations[0], (frames, 1, 1)))
    shifted = shift_time(even, shift_s=shift / clip.rate, ends=ends)
    angles = quaternion.twist(shifted.rotations[:, 1], np.array([0.0, 1.0, 0.0]))
    expected = 0.05 * (np.arange(frames) - shift)
    if ends == "hold":
        expected = np.clip(expected, 0.0, 0.05 * (frames - 1))
    if ends != "loop":
        np.testing.assert_allclose(np.unwrap(angles), expected + np.unwrap(angles)[0] - expected[0], atol=1e-5)
    np.testing.assert_allclose(shifted.translations, even.translations, atol=1e-9)
