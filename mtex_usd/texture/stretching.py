"""Stretching copied motion in time: cubic, low-passed first when it is compressed (Gleicher 2000, section 1.6.2.1)."""

from functools import lru_cache

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d

__all__ = ["stretch_cubic"]

FloatArray = npt.NDArray[np.float64]

# Frames beyond the fragment that the spline still sees; its influence fades by a factor of 4 a frame.
_CONTEXT = 8


def stretch_cubic(curves: FloatArray, first: int, last: int, frame_count: int) -> FloatArray:
    """Stretch or compress the frames first to last to a number of frames.

    Parameters
    ----------
    curves
        A whole take, shape [F, C]; what lies beyond the fragment shapes the spline at its ends.
    first, last
        First and last frame of the fragment, both included.
    frame_count
        Frames of the result (n), at least 2.

    Returns
    -------
    FloatArray
        Shape [n, C]; the fragment itself, bit for bit, where its length already fits.
    """
    step = (last - first) / (frame_count - 1)
    if step == 1.0:
        return np.array(curves[first : last + 1])
    begin, end = max(0, first - _CONTEXT), min(len(curves), last + 1 + _CONTEXT)
    window = curves[begin:end]
    if step > 1.0:
        window = _low_pass(window, step)
    return _spline_weights(len(window), first - begin, last - begin, frame_count) @ window


@lru_cache(maxsize=256)
def _spline_weights(length: int, first: int, last: int, frame_count: int) -> FloatArray:
    """The cubic spline as a matrix, shape [n, length]: it is linear in what it goes through, and lengths recur."""
    spline = CubicSpline(np.arange(length), np.eye(length))
    return np.asarray(spline(np.linspace(first, last, frame_count)))


def _low_pass(window: FloatArray, step: float) -> FloatArray:
    """Remove what a step of several frames cannot carry; the Gaussian that turns one frame's width into the step's."""
    sigma = 0.5 * np.sqrt(step * step - 1.0)
    margin = int(np.ceil(4.0 * sigma))
    padded = np.pad(window, ((margin, margin), (0, 0)), mode="reflect", reflect_type="odd")
    return np.asarray(gaussian_filter1d(padded, sigma, axis=0)[margin : margin + len(window)])
