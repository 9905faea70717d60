"""Stretching copied motion in time."""

import numpy as np
import pytest

from mtex_usd.texture.stretching import stretch_cubic


def test_a_fragment_of_the_right_length_is_copied_bit_for_bit():
    take = np.random.default_rng(0).standard_normal((50, 3))
    stretched = stretch_cubic(take, 10, 20, 11)
    np.testing.assert_array_equal(stretched, take[10:21])
    stretched[0] = 99.0
    assert take[10, 0] != 99.0


def test_slowing_down_passes_through_the_frames():
    take = np.cumsum(np.random.default_rng(0).standard_normal((50, 2)), axis=0)
    stretched = stretch_cubic(take, 10, 20, 21)
    np.testing.assert_allclose(stretched[::2], take[10:21], atol=1e-9)


def test_slowing_down_is_smooth():
    """A cubic follows a sine between frames; a straight line between them would not."""
    time = np.arange(60.0)
    stretched = stretch_cubic(np.sin(0.7 * time)[:, None], 20, 30, 81)[:, 0]
    np.testing.assert_allclose(stretched, np.sin(0.7 * np.linspace(20.0, 30.0, 81)), atol=2e-3)


@pytest.mark.parametrize("frames", [5, 21, 41, 81])
def test_a_straight_line_stays_straight(frames):
    line = 3.0 + 0.5 * np.arange(80.0)[:, None]
    stretched = stretch_cubic(line, 20, 60, frames)[:, 0]
    np.testing.assert_allclose(stretched, 3.0 + 0.5 * np.linspace(20.0, 60.0, frames), atol=1e-6)


def test_compression_removes_what_its_frames_cannot_carry():
    """At every third frame a wave of 0.4 cycles per frame would come back as one of 0.2."""
    time = np.arange(200.0)
    fast = np.cos(2.0 * np.pi * 0.4 * time)[:, None]
    compressed = stretch_cubic(fast, 50, 110, 21)
    assert np.abs(fast[50:111:3]).max() > 0.9
    assert np.abs(compressed).max() < 0.1


def test_compression_keeps_slow_motion():
    slow = np.cos(2.0 * np.pi * 0.01 * np.arange(200.0))[:, None]
    np.testing.assert_allclose(stretch_cubic(slow, 50, 110, 21), slow[50:111:3], atol=0.02)


def test_consecutive_fragments_meet():
    take = np.cumsum(np.random.default_rng(1).standard_normal((60, 2)), axis=0)
    for frames in (8, 30):
        left, right = stretch_cubic(take, 10, 25, frames), stretch_cubic(take, 25, 40, frames)
        np.testing.assert_allclose(left[-1], right[0], atol=1e-2)


@pytest.mark.parametrize(("first", "last", "frames"), [(0, 1, 2), (0, 1, 9), (0, 3, 2), (58, 59, 5), (0, 59, 2)])
def test_short_fragments_and_ends_of_takes(first, last, frames):
    take = np.cumsum(np.random.default_rng(2).standard_normal((60, 2)), axis=0)
    stretched = stretch_cubic(take, first, last, frames)
    assert stretched.shape == (frames, 2)
    assert np.isfinite(stretched).all()


def test_a_take_of_two_frames():
    np.testing.assert_allclose(stretch_cubic(np.array([[0.0], [4.0]]), 0, 1, 5)[:, 0], [0.0, 1.0, 2.0, 3.0, 4.0])
