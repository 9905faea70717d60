"""Frequency bands: an undecimated Laplacian pyramid (Pullen & Bregler 2002, section 3.1; Gleicher 2000, section 1.6.3).

Band 1 is the highest frequency. Level k smooths with [1 4 6 4 1]/16 spread by 2**(k-1); the band is what that removes.
Nothing is dropped between levels (the paper's pyramid is decimated), so that a shifted motion has shifted bands: the
same motion matches alike whatever its phase. The price is memory, one copy of the curves per band.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

__all__ = ["Bands", "band_limit", "decompose", "nearest_band", "peak_frequency"]

FloatArray = npt.NDArray[np.float64]

KERNEL = np.array([1.0, 4.0, 6.0, 4.0, 1.0]) / 16.0


@dataclass(frozen=True, eq=False)
class Bands:
    """The bands of a set of curves; ``bands.sum(axis=0) + residual`` gives the curves back to rounding.

    Parameters
    ----------
    bands
        Shape [B, F, C], band k at index k - 1.
    residual
        What is left below the last band, shape [F, C].
    """

    bands: FloatArray
    residual: FloatArray

    @property
    def count(self) -> int:
        """How many bands there are (B)."""
        return len(self.bands)

    def band(self, number: int) -> FloatArray:
        """One band by its number from 1, shape [F, C]; zero where the clip is too short to have it."""
        if number > self.count:
            return np.zeros_like(self.residual)
        return np.asarray(self.bands[number - 1])

    def sum_of(self, first: int, last: int) -> FloatArray:
        """Sum of bands first to last, both included, shape [F, C]; bands the clip is too short for count as zero."""
        return np.asarray(self.bands[first - 1 : last].sum(axis=0))

    def at_or_below(self, number: int) -> FloatArray:
        """A band and everything of lower frequency, residual included, shape [F, C]."""
        return np.asarray(self.bands[number - 1 :].sum(axis=0)) + self.residual


def band_limit(frame_count: int) -> int:
    """Give the number of bands a clip of so many frames has: band k needs 2 * 2**(k-1) <= F - 1."""
    return max(0, (frame_count - 1).bit_length() - 1)


def decompose(curves: FloatArray, *, most: int | None = None) -> Bands:
    """Split curves into bands.

    Parameters
    ----------
    curves
        Values at even intervals, shape [F, C].
    most
        Make no more bands than this; the rest stays in the residual.

    Returns
    -------
    Bands
        As many bands as the length allows, and the residual.

    Notes
    -----
    Beyond the ends the curves continue by point reflection, so a straight line has no energy in any band.
    """
    count = band_limit(len(curves))
    if most is not None:
        count = min(count, most)
    bands = np.empty((count, *curves.shape))
    low = np.array(curves, dtype=np.float64)
    for level in range(count):
        smooth = _smooth(low, 2**level)
        np.subtract(low, smooth, out=bands[level])
        low = smooth
    return Bands(bands=bands, residual=low)


def _smooth(curves: FloatArray, step: int) -> FloatArray:
    """Convolve with the kernel spread by ``step`` frames."""
    frames, reach = len(curves), 2 * step
    # numpy's own padding takes longer than the rest; a band is made only where one reflection is enough.
    before, after = 2.0 * curves[0] - curves[reach:0:-1], 2.0 * curves[-1] - curves[-2 : -reach - 2 : -1]
    padded = np.concatenate([before, curves, after])
    out = KERNEL[2] * curves
    for tap in (0, 1, 3, 4):
        out += KERNEL[tap] * padded[tap * step : tap * step + frames]
    return np.asarray(out)


def peak_frequency(number: int, rate: float) -> float:
    """Frequency in Hz at which a band responds most, at a frame rate; the top of the range for band 1."""
    return rate * _relative_peak(number)


@lru_cache(maxsize=64)
def _relative_peak(number: int) -> float:
    omega = np.linspace(0.0, np.pi, 1 << 14) / 2.0 ** max(number - 2, 0)
    response = 1.0 - np.cos(2.0 ** (number - 1) * omega / 2.0) ** 4
    for level in range(number - 1):
        response = response * np.cos(2.0**level * omega / 2.0) ** 4
    return float(omega[np.argmax(response)] / (2.0 * np.pi))


def nearest_band(frequency: float, rate: float, *, among: Sequence[int] = tuple(range(1, 16))) -> int:
    """Give the band whose peak is nearest a frequency in Hz (by ratio) at a frame rate."""
    return min(among, key=lambda number: abs(math.log(peak_frequency(number, rate) / frequency)))
