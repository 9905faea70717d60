"""Whatever numbers an edit is given, it gives a finite motion or one clear error, without a warning on the way."""

import math
import warnings

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mtex_usd import edit
from mtex_usd.errors import InputError
from tests.synthetic import walk

CLIPS = {frames: walk(frames) for frames in (2, 3, 9, 40)}
EXTREMES = [0.0, -1.0, 5e-324, 1e-12, 1e-7, 1e4, 1e6, 1e9, -1e9, 1e300, math.nan, math.inf, -math.inf]
NUMBERS = st.sampled_from(EXTREMES) | st.floats(-5.0, 50.0) | st.floats()
FRAMES = st.sampled_from(sorted(CLIPS))
ENDS = st.sampled_from(["hold", "loop", "extrapolate"])
COUNTS = st.none() | st.sampled_from([2, 5, 100, 3000])
RISING = st.lists(NUMBERS, min_size=3, max_size=3).map(sorted)


def is_fine(function, *given_values, **options):
    """Whether a motion came out, all numbers finite; False where it was refused."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            result = function(*given_values, **options)
        except InputError as error:
            assert error.expected or error.found
            return False
    clip = getattr(result, "clip", result)
    assert np.isfinite(clip.rotations).all()
    assert np.isfinite(clip.translations).all()
    return True


@settings(max_examples=60)
@given(FRAMES, NUMBERS, ENDS, COUNTS)
def test_times(frames, number, ends, count):
    clip = CLIPS[frames]
    if is_fine(edit.shift_time, clip, shift_s=number, ends=ends):
        assert math.isfinite(number)
    if is_fine(edit.scale_time, clip, factor=number, ends=ends, frame_count=count):
        assert number > 0.0


@settings(max_examples=60)
@given(FRAMES, RISING, RISING, ENDS, COUNTS)
def test_warps(frames, before, after, ends, count):
    pairs = list(zip(before, after, strict=True))
    if is_fine(edit.warp_time, CLIPS[frames], pairs=pairs, ends=ends, frame_count=count):
        assert np.isfinite(pairs).all()
    if is_fine(edit.waveshape, CLIPS[frames], points=pairs, channels=["LeftArm"]):
        assert np.isfinite(pairs).all()


@settings(max_examples=60)
@given(FRAMES, NUMBERS, NUMBERS)
def test_filters(frames, one, two):
    clip = CLIPS[frames]
    if is_fine(edit.lowpass, clip, frequency=one):
        assert one > 0.0
    if is_fine(edit.bandpass, clip, frequencies=(one, two)):
        assert 0.0 <= one < two
    if is_fine(edit.equalize, clip, gains=[one], residual_gain=two):
        assert max(one, two) < math.inf
    for operation in (edit.median, edit.robust_mean):
        if is_fine(operation, clip, window_s=one):
            assert 0.0 < one < math.inf


@settings(max_examples=40)
@given(FRAMES, FRAMES, NUMBERS, NUMBERS)
def test_mixing(frames, others, one, two):
    clip, other = CLIPS[frames], CLIPS[others]
    if is_fine(edit.blend, clip, other, weights=one, align_first=frames != others):
        assert math.isfinite(one)
    if is_fine(edit.join, clip, other, blend_s=one):
        assert one > 0.0
    key = edit.PoseChange(frame=one, rotations={"LeftArm": (two, 0.0, 0.0)})
    if is_fine(edit.displace, clip, edit.Displacement(keys=[key], scope=5.0)):
        assert math.isfinite(two)
