"""The clip: shapes, times, and what it refuses."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from mtex_usd.errors import InputError
from tests.synthetic import JOINTS, walk


def test_what_a_clip_tells():
    clip = walk(5, start=101.0, step=2.0)
    assert clip.joints == JOINTS
    assert clip.frame_count == 5
    assert clip.rest.shape == (len(JOINTS), 4, 4)
    assert clip.parents[0] == -1
    np.testing.assert_array_equal(clip.time_codes, [101.0, 103.0, 105.0, 107.0, 109.0])


def test_a_clip_cannot_be_changed():
    with pytest.raises(FrozenInstanceError):
        walk(5).rate = 30.0


def test_shapes_must_fit():
    clip = walk(5, name="/Takes/a")
    with pytest.raises(InputError, match=r"clip /Takes/a: shapes do not fit; expected .*\(5, 11, 3\).*; found .*\(4,"):
        replace(clip, scales=clip.scales[:4])


def test_there_is_at_least_one_frame():
    clip = walk(5, name="/Takes/a")
    with pytest.raises(InputError, match="clip /Takes/a has no frames; expected at least one frame"):
        replace(clip, rotations=clip.rotations[:0], translations=clip.translations[:0], scales=clip.scales[:0])


@pytest.mark.parametrize("rate", [0.0, -24.0, float("nan"), float("inf")])
def test_the_rate_is_above_zero(rate):
    with pytest.raises(InputError, match="clip /Takes/a: bad rate; expected frames per second above 0"):
        replace(walk(5, name="/Takes/a"), rate=rate)
