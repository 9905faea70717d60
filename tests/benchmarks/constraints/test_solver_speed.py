"""The solver's benchmark measures what it says; long times are for running it as a program."""

import numpy as np
import pytest

from tests.benchmarks.constraints.solver_speed import (
    LEAST_SPEEDUP,
    compare_near,
    compare_with_scipy,
    fit_power,
    time_lengths,
)


def test_it_is_much_faster_than_scipy_and_finds_the_same():
    found = compare_with_scipy()
    assert found.apart < 1e-3
    assert found.ratio > LEAST_SPEEDUP


def test_a_neighbourhood_takes_a_small_part_of_the_whole():
    """A smaller case than the program's, where the parts differ less."""
    found = compare_near(frames=120, joint_count=21, constraint_count=60)
    assert (found.joint_count, found.constraint_count) == (21, 60)
    assert found.ratio > 3.0


def test_lengths_are_timed_and_fitted():
    seconds = time_lengths([1, 2])
    assert list(seconds) == [100, 200]
    assert np.isfinite(fit_power(seconds))
    assert fit_power({frames: 0.002 * frames**1.1 for frames in (100, 1000, 10000)}) == pytest.approx(1.1)
