"""The frequency bands: which frequency each holds, at which rate, and how they are summed."""

import numpy as np
import pytest

from mtex_usd.texture.pyramid import decompose, nearest_band, peak_frequency


# ALGORITHM: at 24 frames/s bands 2..7 peak at 3.4, 1.6, 0.8, 0.4, 0.2 and 0.1 Hz.
@pytest.mark.parametrize(
    ("number", "hertz"), [(2, 3.4), (3, 1.6), (4, 0.8), (5, 0.4), (6, 0.2), (7, 0.1)], ids="band {}".format
)
def test_peaks_at_24_frames_per_second(number, hertz):
    assert round(peak_frequency(number, 24.0), 1) == hertz


def test_band_1_holds_the_top_of_the_range():
    assert peak_frequency(1, 24.0) == pytest.approx(12.0)


def measure_response(number, hertz, rate):
    """Amplitude of a band's answer to a sine, away from the ends."""
    curve = np.sin(2.0 * np.pi * hertz * np.arange(6000) / rate)[:, None]
    middle = decompose(curve, most=number).band(number)[1500:-1500, 0]
    return np.sqrt(2.0 * np.mean(middle * middle))


@pytest.mark.parametrize("rate", [24.0, 60.0])
@pytest.mark.parametrize("number", [2, 3, 4, 5])
def test_a_sine_at_the_peak_is_answered_most(number, rate):
    peak = peak_frequency(number, rate)
    answer = measure_response(number, peak, rate)
    assert answer > measure_response(number, 0.9 * peak, rate)
    assert answer > measure_response(number, 1.1 * peak, rate)
    assert answer > 0.4


def test_bands_1_and_2_cross_near_4_4_hertz():
    assert measure_response(1, 4.2, 24.0) < measure_response(2, 4.2, 24.0)
    assert measure_response(1, 4.6, 24.0) > measure_response(2, 4.6, 24.0)


@pytest.mark.parametrize(
    ("rate", "match", "texture", "coarse"),
    [(24.0, 4, 2, 3), (25.0, 4, 2, 3), (30.0, 4, 2, 3), (60.0, 5, 3, 4), (120.0, 6, 4, 5)],
)
def test_nearest_band_follows_the_rate(rate, match, texture, coarse):
    assert (nearest_band(0.8, rate), nearest_band(3.4, rate), nearest_band(1.6, rate)) == (match, texture, coarse)


def test_nearest_band_among_few():
    assert nearest_band(0.8, 24.0, among=(1, 2)) == 2


def test_bands_a_clip_is_too_short_for_are_zero():
    bands = decompose(np.arange(6.0)[:, None] ** 2)
    assert bands.count == 2
    np.testing.assert_array_equal(bands.band(7), np.zeros((6, 1)))
    np.testing.assert_array_equal(bands.at_or_below(7), bands.residual)


def test_two_frames_have_only_a_residual():
    curve = np.array([[3.0], [-1.0]])
    bands = decompose(curve)
    assert bands.count == 0
    np.testing.assert_array_equal(bands.residual, curve)
    np.testing.assert_array_equal(bands.sum_of(2, 3), np.zeros((2, 1)))


def test_sums_of_bands():
    bands = decompose(np.random.default_rng(0).standard_normal((50, 3)))
    np.testing.assert_allclose(bands.sum_of(2, 3), bands.band(2) + bands.band(3))
    np.testing.assert_allclose(bands.at_or_below(4), bands.band(4) + bands.band(5) + bands.residual)


def test_most_leaves_the_rest_in_the_residual():
    curve = np.random.default_rng(0).standard_normal((50, 3))
    few, all_bands = decompose(curve, most=2), decompose(curve)
    assert few.count == 2
    np.testing.assert_allclose(few.residual, all_bands.at_or_below(3), atol=1e-12)
