"""Laws of filters, equalizer, robust filters, wave-shaping and mirroring that hold for every motion."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mtex_usd.edit import bandpass, equalize, highpass, lowpass, median, mirror, robust_mean, waveshape
from mtex_usd.edit.curve_space import make_curve_space
from mtex_usd.motion import quaternion
from tests.cleaning_support import make_walk
from tests.synthetic import turned, walk

SEEDS = st.integers(0, 2**32 - 1)
FRAMES = st.integers(2, 60)
FREQUENCIES = st.floats(0.01, 11.9)
GAINS = st.lists(st.floats(-30.0, 12.0), max_size=6)


def same_bits(a, b):
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ("rotations", "translations", "scales"))


def apart(a, b):
    """Largest angle in degrees and largest distance of the translations."""
    angle = np.degrees(quaternion.angle_between(a.rotations, b.rotations)).max()
    return max(angle, np.abs(a.translations - b.translations).max())


@settings(max_examples=40)
@given(SEEDS, FRAMES, st.integers(1, 16))
def test_identities_keep_every_bit(seed, frames, order):
    clip = walk(frames, seed=seed)
    assert same_bits(lowpass(clip, frequency=12.0, order=order), clip)
    assert same_bits(highpass(clip, frequency=0.0, order=order), clip)
    assert same_bits(bandpass(clip, frequencies=(0.0, 12.0), order=order), clip)
    assert same_bits(equalize(clip, gains=[0.0] * order, residual_gain=0.0), clip)
    assert same_bits(median(clip, window_s=0.08), clip)
    assert same_bits(robust_mean(clip, window_s=0.08), clip)
    assert same_bits(waveshape(clip, points=[(-1.0, -1.0), (2.0, 2.0)], channels=["*"]), clip)


@settings(max_examples=40)
@given(SEEDS, FRAMES, FREQUENCIES, st.integers(1, 16))
def test_unit_rotations_of_any_length_come_out_finite(seed, frames, frequency, order):
    clip = walk(frames, seed=seed)
    for result in (lowpass(clip, frequency=frequency, order=order), highpass(clip, frequency=frequency, order=order)):
        assert np.isfinite(result.translations).all()
        np.testing.assert_allclose(np.linalg.norm(result.rotations, axis=-1), 1.0, atol=1e-9)


@settings(max_examples=30)
@given(SEEDS, FRAMES, FREQUENCIES, st.floats(-180.0, 180.0))
def test_the_way_the_character_faces_makes_no_difference(seed, frames, frequency, heading):
    clip = walk(frames, seed=seed)
    for edit in (
        lambda clip: lowpass(clip, frequency=frequency),
        lambda clip: equalize(clip, gains=[-6.0, 3.0, -np.inf]),
    ):
        assert apart(edit(turned(clip, heading)), turned(edit(clip), heading)) < 1e-5


@settings(max_examples=30)
@given(SEEDS, FRAMES, FREQUENCIES)
def test_low_and_high_make_the_whole(seed, frames, frequency):
    clip = walk(frames, seed=seed)
    curves = make_curve_space(clip, ["Hips.t"]).curves
    low = make_curve_space(lowpass(clip, frequency=frequency, channels=["Hips.t"]), ["Hips.t"]).curves
    high = make_curve_space(highpass(clip, frequency=frequency, channels=["Hips.t"]), ["Hips.t"]).curves
    np.testing.assert_allclose(low + high - curves.mean(axis=0), curves, atol=1e-8)


@settings(max_examples=30)
@given(SEEDS, FRAMES, GAINS)
def test_gains_of_single_channels_add_up_in_decibels(seed, frames, gains):
    """The change of a channel is linear in each band's factor."""
    clip = walk(frames, seed=seed)
    changes = []
    for factor in (1.0, 2.0, 3.0):
        decibels = [20.0 * np.log10(factor) for _ in gains]
        result = equalize(clip, gains=decibels, channels=["Hips.t"])
        changes.append(result.translations - clip.translations)
    np.testing.assert_allclose(changes[2], 2.0 * changes[1], atol=1e-8)
    assert not changes[0].any()


@settings(max_examples=30)
@given(SEEDS, st.integers(8, 60), st.floats(1e-9, 0.5))
def test_a_median_stays_among_the_values_of_its_window_and_keeps_the_ends(seed, frames, window_s):
    clip = walk(frames, seed=seed)
    window_s = min(window_s, (frames - 1) / clip.rate)
    half = int(0.5 * window_s * clip.rate + 1e-6)
    result = median(clip, window_s=window_s, channels=["Hips.t"])
    assert np.array_equal(result.translations[[0, -1]], clip.translations[[0, -1]])
    for frame in range(half, frames - half):
        window = clip.translations[frame - half : frame + half + 1, 0]
        assert (result.translations[frame, 0] <= window.max(axis=0) + 1e-9).all()
        assert (result.translations[frame, 0] >= window.min(axis=0) - 1e-9).all()


@settings(max_examples=30)
@given(SEEDS, st.integers(8, 60), st.floats(0.1, 0.5), st.floats(0.0, 0.5))
def test_a_robust_mean_lets_steady_movement_pass(seed, frames, window_s, discard):
    clip = walk(frames, seed=seed)
    steps = np.random.default_rng(seed).standard_normal(3)
    translations = np.array(clip.translations)
    translations[:, 0] = np.arange(frames)[:, None] * steps
    clip = replace(clip, translations=translations)
    window_s = min(window_s, (frames - 1) / clip.rate)
    result = robust_mean(clip, window_s=window_s, discard=discard, channels=["Hips.t"])
    np.testing.assert_allclose(result.translations, clip.translations, atol=1e-9)


@settings(max_examples=30)
@given(SEEDS, st.lists(st.floats(0.5, 30.0), min_size=1, max_size=5), st.floats(0.0, 2.0))
def test_shaping_keeps_the_order_of_values(seed, steps, slope):
    clip = walk(30, seed=seed)
    x = np.concatenate([[-20.0], -20.0 + np.cumsum(steps)])
    points = [(float(a), float(slope * a + 0.1 * number)) for number, a in enumerate(x)]
    shaped = waveshape(clip, points=points, channels=["Hips.ty"])
    before, after = clip.translations[:, 0, 1], shaped.translations[:, 0, 1]
    order = np.argsort(before, kind="stable")
    assert (np.diff(after[order]) > -1e-9).all()


@settings(max_examples=30)
@given(
    SEEDS,
    st.integers(2, 30),
    st.sampled_from([None, 1, 2]),
    st.floats(-180.0, 180.0),
    st.sampled_from(["rest", "facing"]),
)
def test_mirrored_twice_is_the_original(seed, frames, oriented, heading, plane):
    clip = turned(make_walk(frames, seed=seed, oriented=oriented), heading)
    clip = replace(clip, scales=1.0 + np.random.default_rng(seed).random(clip.scales.shape))
    twice = mirror(mirror(clip, plane=plane), plane=plane)
    assert quaternion.angle_between(twice.rotations, clip.rotations).max() < 1e-12
    np.testing.assert_allclose(twice.translations, clip.translations, rtol=0.0, atol=1e-10)
    assert np.array_equal(twice.scales, clip.scales)
