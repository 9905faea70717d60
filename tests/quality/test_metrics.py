"""The benchmark's own measures, on motion whose answer is known."""

import numpy as np
import pytest

from mtex_usd.motion import quaternion
from tests.benchmarks.quality.baselines import ridge
from tests.benchmarks.quality.metrics import band_energy, npss, third_difference
from tests.benchmarks.quality.sweep import write_table
from tests.quality.real import angles, turn_limits


def wave(frames, cycles, *, shift=0.0):
    return np.sin(2.0 * np.pi * cycles * np.arange(frames) / frames + shift)[:, None]


class TestNpss:
    def test_phase_does_not_matter(self):
        assert npss(wave(64, 3), wave(64, 3, shift=1.0)) == pytest.approx(0.0, abs=1e-12)

    def test_amplitude_does_not_matter(self):
        assert npss(wave(64, 3), 5.0 * wave(64, 3)) == pytest.approx(0.0, abs=1e-12)

    def test_grows_with_the_distance_of_frequencies(self):
        near, far = npss(wave(64, 3), wave(64, 4)), npss(wave(64, 3), wave(64, 12))
        # Half of each spectrum lies at k, half at F - k: both halves move by one bin in 64.
        assert near == pytest.approx(1.0 / 64.0)
        assert far == pytest.approx(9.0 / 64.0)

    def test_curves_count_by_their_power(self):
        truth = np.concatenate([10.0 * wave(64, 3), wave(64, 3)], axis=1)
        wrong_small = np.concatenate([wave(64, 3), wave(64, 12)], axis=1)
        assert npss(truth, wrong_small) == pytest.approx(9.0 / 64.0 / 101.0)


class TestThirdDifference:
    def test_even_turning_has_none(self):
        turns = quaternion.exp(np.outer(np.arange(60), [0.3, 0.1, -0.2]))[:, None]
        assert third_difference(turns) < 1e-9

    def test_small_turns_are_the_curves_own(self):
        curve = 1e-3 * np.random.default_rng(3).standard_normal((40, 3))
        expected = np.degrees(np.sqrt(np.square(np.diff(curve, n=3, axis=0)).mean()))
        assert third_difference(quaternion.exp(curve)[:, None]) == pytest.approx(expected, rel=1e-3)


def test_band_energy_is_of_the_bands_asked_for():
    slow, quick = wave(256, 3), wave(256, 36)
    assert band_energy(quick, 2, 3) > 0.4 * np.square(quick).mean()
    assert band_energy(slow, 2, 3) < 0.02 * np.square(slow).mean()


class TestRidge:
    def test_finds_a_linear_law(self):
        rng = np.random.default_rng(5)
        inputs, law = rng.standard_normal((50, 4)), rng.standard_normal((4, 3))
        wanted = rng.standard_normal((7, 4))
        np.testing.assert_allclose(ridge(inputs, inputs @ law + 2.0, wanted, 1e-9), wanted @ law + 2.0, atol=1e-6)

    def test_a_large_penalty_gives_the_mean(self):
        rng = np.random.default_rng(5)
        inputs, outputs = rng.standard_normal((50, 4)), rng.standard_normal((50, 3))
        expected = np.tile(outputs.mean(axis=0), (50, 1))
        np.testing.assert_allclose(ridge(inputs, outputs, inputs, 1e9), expected, atol=1e-4)


def test_turn_limit_is_fragment_and_half_gaps():
    def spin(start, step, frames):
        return quaternion.exp(np.radians(np.outer(start + step * np.arange(frames), [1.0, 0.0, 0.0])))[:, None]

    limits = turn_limits([spin(0.0, 2.0, 6), spin(40.0, 5.0, 4)])
    # The gap is from 10 to 40 degrees: 15 on either side, over 5 steps and 3.
    np.testing.assert_allclose(limits[:5], 1.2 * (2.0 + 15.0 / 5.0))
    np.testing.assert_allclose(limits[5:], 1.2 * (5.0 + 15.0 / 3.0))
    np.testing.assert_allclose(angles(spin(0.0, 2.0, 6)), 2.0)


def test_table_is_markdown():
    assert write_table(["a", "b"], [["x", "1"]]) == ["| a | b |", "| --- | ---: |", "| x | 1 |"]
