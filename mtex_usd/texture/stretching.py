"""Stretching copied motion in time: cubic, low-passed first when it is compressed (Gleicher 2000, section 1.6.2.1)."""

from functools import lru_cache

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline
from scipy.ndimage import convolve1d

__all__ = ["stretch_cubic"]

FloatArray = npt.NDArray[np.float64]

# Frames beyond the fragment that the spline still sees; its influence fades by a factor of 4 a frame.
_CONTEXT = 8
# The window that takes are resampled with, and how far it reaches in steps of the compressed motion.
_KAISER_BETA = 5.0
_REACH = 4.0


def stretch_cubic(curves: FloatArray, first: float, last: float, frame_count: int) -> FloatArray:
    """Stretch or compress the frames first to last to a number of frames.

    Parameters
    ----------
    curves
        A whole take, shape [F, C]; what lies beyond the fragment shapes the spline at its ends.
    first, last
        First and last frame of the fragment, both included; between frames the spline is read there.
    frame_count
        Frames of the result (n), at least 2.

    Returns
    -------
    FloatArray
        Shape [n, C]; the fragment itself, bit for bit, where its length already fits.
    """
    step = (last - first) / (frame_count - 1)
    if step == 1.0 and first == int(first):
        return np.array(curves[int(first) : int(last) + 1])
    margin = int(np.ceil(_REACH * step)) if step > 1.0 else 0
    context = _CONTEXT + margin
    begin, end = max(0, int(first) - context), min(len(curves), int(np.ceil(last)) + 1 + context)
    window = curves[begin:end]
    if margin:
        window = _low_pass(window, step, margin)
    return _spline_weights(len(window), first - begin, last - begin, frame_count) @ window


@lru_cache(maxsize=256)
def _spline_weights(length: int, first: float, last: float, frame_count: int) -> FloatArray:
    """The cubic spline as a matrix, shape [n, length]: it is linear in what it goes through, and lengths recur."""
    spline = CubicSpline(np.arange(length), np.eye(length))
    return np.asarray(spline(np.linspace(first, last, frame_count)))


def _low_pass(window: FloatArray, step: float, margin: int) -> FloatArray:
    """Remove what a step of several frames cannot carry: a Kaiser-windowed sinc that cuts at half a step's rate."""
    frames = np.arange(-margin, margin + 1)
    kernel = np.sinc(frames / step) * np.kaiser(len(frames), _KAISER_BETA)
    padded = np.pad(window, ((margin, margin), (0, 0)), mode="reflect", reflect_type="odd")
    return np.asarray(convolve1d(padded, kernel / kernel.sum(), axis=0)[margin : margin + len(window)])
