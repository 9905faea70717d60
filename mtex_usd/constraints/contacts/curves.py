"""Heights and speeds of points as smooth curves of time, the same at any frame rate.

Speeds of captured points are drowned in noise unless they are smoothed, and smoothed over a number of frames they would
depend on the frame rate. So positions are refined to a fine grid where the rate is low, and filtered by a Gaussian of
fixed duration.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

__all__ = ["PointCurves", "measure_points"]

FloatArray = npt.NDArray[np.float64]

_FINE_RATE = 120.0  # frames/s: below, positions are refined by a cubic spline
_SMOOTHING_S = 0.025  # standard deviation: 5 mm of noise at 120/s leaves 0.04 m/s, a step's touch-down is not blurred
_REACH = 4.0  # of the filter, in standard deviations


@dataclass(frozen=True, eq=False, kw_only=True)
class PointCurves:
    """Heights and speeds of points on a fine grid of time.

    Parameters
    ----------
    per_frame
        Steps of the grid from one frame to the next (R).
    heights
        Along up, skeleton units, shape [(F - 1) R + 1, N].
    speeds
        Skeleton units per second, same shape.
    """

    per_frame: int
    heights: FloatArray
    speeds: FloatArray

    @property
    def frame_heights(self) -> FloatArray:
        """Heights at the frames, shape [F, N]."""
        return self.heights[:: self.per_frame]

    @property
    def frame_speeds(self) -> FloatArray:
        """Speeds at the frames, shape [F, N]."""
        return self.speeds[:: self.per_frame]


def measure_points(positions: FloatArray, rate: float, up: FloatArray) -> PointCurves:
    """Measure heights and speeds of points.

    Parameters
    ----------
    positions
        Skeleton space, skeleton units, shape [F, N, 3].
    rate
        Frames per second.
    up
        Unit vector, shape [3].

    Returns
    -------
    PointCurves
        Of a single frame all speeds are zero.
    """
    per_frame = max(int(np.ceil(_FINE_RATE / rate - 1e-6)), 1)
    fine = _refine(positions.reshape(len(positions), -1), per_frame)
    places, velocities = _smooth(fine, rate * per_frame)
    shape = (len(fine), *positions.shape[1:])
    return PointCurves(
        per_frame=per_frame,
        heights=places.reshape(shape) @ up,
        speeds=np.linalg.norm(velocities.reshape(shape), axis=-1),
    )


def _refine(columns: FloatArray, per_frame: int) -> FloatArray:
    if per_frame == 1 or len(columns) < 2:
        return columns
    from scipy.interpolate import CubicSpline  # noqa: PLC0415  (slow to import, only for low rates)

    times = np.arange((len(columns) - 1) * per_frame + 1) / per_frame
    return np.asarray(CubicSpline(np.arange(len(columns)), columns, axis=0)(times))


def _smooth(columns: FloatArray, rate: float) -> tuple[FloatArray, FloatArray]:
    """Give the columns and their derivatives per second, filtered; at the ends they continue by point reflection."""
    reach = max(int(np.ceil(_REACH * _SMOOTHING_S * rate)), 1)
    offsets = np.arange(-reach, reach + 1)
    kernel = np.exp(-0.5 * np.square(offsets / (_SMOOTHING_S * rate)))
    slope = offsets * kernel
    padded = _extend(columns, reach)
    places = _filter(padded, kernel / kernel.sum())
    velocities = _filter(padded, slope * rate / np.sum(slope * offsets))
    return places, velocities


def _filter(columns: FloatArray, weights: FloatArray) -> FloatArray:
    """Correlate every column with the weights where they fit whole."""
    return np.stack([np.convolve(column, weights[::-1], mode="valid") for column in columns.T], axis=1)


def _extend(columns: FloatArray, reach: int) -> FloatArray:
    if len(columns) == 1:
        return np.repeat(columns, 2 * reach + 1, axis=0)
    return np.asarray(np.pad(columns, ((reach, reach), (0, 0)), mode="reflect", reflect_type="odd"))
