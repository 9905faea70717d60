"""Outliers: samples so far from those around them that a fit does better without (Gleicher 2000, section 1.5)."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.keys.sampled import slerp
from mtex_usd.edit.robust import median
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip

__all__ = ["bridge_outliers", "find_outliers"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

_HALF_WINDOW = 2  # frames: up to two outliers in a row are told
_TIMES_USUAL = 6.0  # the usual distance from the median, of an outlier


def find_outliers(clip: Clip, *, least_degrees: float) -> BoolArray:
    """Find rotations that stand out by themselves.

    Parameters
    ----------
    clip
        The clip; with fewer than five frames nothing stands out.
    least_degrees
        Least distance from the median of five frames. It must also be six times the joint's usual one.

    Returns
    -------
    BoolArray
        Shape [F, J]; never the first or last frame.
    """
    if clip.frame_count <= 2 * _HALF_WINDOW:
        return np.zeros(clip.rotations.shape[:2], dtype=np.bool_)
    calm = median(clip, window_s=2.0 * _HALF_WINDOW / clip.rate, channels=["*.r"])
    distances = quaternion.angle_between(clip.rotations, calm.rotations)
    usual = _TIMES_USUAL * np.median(distances, axis=0)
    found = distances > np.maximum(np.radians(least_degrees), usual)
    found[[0, -1]] = False
    return np.asarray(found)


def bridge_outliers(clip: Clip, outliers: BoolArray) -> Clip:
    """Turn joints evenly across frames that are outliers.

    Parameters
    ----------
    clip
        The clip.
    outliers
        Which frames of which joints, shape [F, J], neither the first nor the last frame.
    """
    rotations = np.array(clip.rotations)
    frames = np.arange(clip.frame_count)
    for joint in np.flatnonzero(outliers.any(axis=0)).tolist():
        good, bad = frames[~outliers[:, joint]], frames[outliers[:, joint]]
        after = np.searchsorted(good, bad)
        start, end = good[after - 1], good[after]
        part = (bad - start) / (end - start)
        rotations[bad, joint] = slerp(rotations[start, joint], rotations[end, joint], part)
    return replace(clip, rotations=rotations)
