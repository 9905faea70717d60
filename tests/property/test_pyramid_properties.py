"""Laws of the frequency bands that hold for every curve."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mtex_usd.texture.pyramid import band_limit, decompose
from tests.oracle import pyramid as twin

SEEDS = st.integers(0, 2**32 - 1)


def random_curves(seed, frames, columns=2):
    return 100.0 * np.random.default_rng(seed).standard_normal((frames, columns))


@pytest.mark.parametrize("frames", range(1, 201))
def test_bands_and_residual_add_up_to_the_curve_at_every_length(frames):
    curves = random_curves(frames, frames)
    bands = decompose(curves)
    np.testing.assert_allclose(bands.bands.sum(axis=0) + bands.residual, curves, rtol=0, atol=1e-11)
    np.testing.assert_allclose(bands.at_or_below(1), curves, rtol=0, atol=1e-11)


@pytest.mark.parametrize("frames", range(1, 201))
def test_a_band_is_made_only_where_its_kernel_fits(frames):
    count = decompose(random_curves(frames, frames)).count
    assert count == band_limit(frames) == twin.count_bands(frames)
    assert all(2 * 2 ** (k - 1) <= frames - 1 for k in range(1, count + 1))
    assert 2 * 2**count > frames - 1


@given(SEEDS, st.integers(1, 140))
def test_equals_the_slow_twin(seed, frames):
    curves = random_curves(seed, frames, columns=1)
    bands, residual = twin.decompose(curves[:, 0].tolist())
    found = decompose(curves)
    np.testing.assert_allclose(found.residual[:, 0], residual, rtol=0, atol=1e-9)
    assert found.count == len(bands)
    for number, band in enumerate(bands, start=1):
        np.testing.assert_allclose(found.band(number)[:, 0], band, rtol=0, atol=1e-9)


@given(st.floats(-500.0, 500.0), st.floats(-20.0, 20.0), st.integers(3, 200))
def test_a_straight_line_has_no_energy_in_any_band(offset, slope, frames):
    line = offset + slope * np.arange(frames, dtype=np.float64)[:, None]
    bands = decompose(line)
    np.testing.assert_allclose(bands.bands, 0.0, atol=1e-9)
    np.testing.assert_allclose(bands.residual, line, atol=1e-9)


@given(SEEDS, st.integers(1, 40), st.integers(1, 4))
def test_a_shifted_curve_has_shifted_bands_away_from_the_ends(seed, shift, number):
    curve = random_curves(seed, 240, columns=1)
    whole, part = decompose(curve, most=4), decompose(curve[shift:], most=4)
    margin = 2 * (2**number - 1)
    np.testing.assert_allclose(
        part.band(number)[margin : -margin or None],
        whole.band(number)[shift + margin : -margin or None],
        rtol=0,
        atol=1e-9,
    )


@given(SEEDS, st.integers(2, 100), st.floats(-3.0, 3.0))
def test_is_linear(seed, frames, factor):
    one, other = random_curves(seed, frames), random_curves(seed + 1, frames)
    summed = decompose(one + factor * other).bands
    np.testing.assert_allclose(summed, decompose(one).bands + factor * decompose(other).bands, rtol=0, atol=1e-9)


@given(SEEDS, st.integers(2, 100))
def test_played_backwards_the_bands_run_backwards(seed, frames):
    curves = random_curves(seed, frames)
    np.testing.assert_allclose(decompose(curves[::-1]).bands, decompose(curves).bands[:, ::-1], rtol=0, atol=1e-9)
