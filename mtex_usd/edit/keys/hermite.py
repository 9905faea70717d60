"""Least-squares cubic Hermite curves through chosen keys, for many channels in one banded solve.

Samples are at even steps; a curve is a value and a slope at every key, a cubic between keys. Slopes before and after a
key are the same unless the key is broken; a pinned key keeps the sample's value. Every cubic touches four unknowns in a
row, so the normal equations of all channels together are one band matrix.
"""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt

__all__ = ["Fit", "KeySet", "Parts", "fit_curves", "hermite_basis", "spread_parts", "sweep_cubics"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

_STIFFNESS = 0.1  # of the bending energy, in sample steps: keeps curves from swinging between samples, no more
_BAND = 3


@dataclass(frozen=True, eq=False)
class KeySet:
    """Which samples are keys, and of what kind; arrays [C, T].

    Parameters
    ----------
    placed
        The keys; the first and the last sample of every channel are among them.
    pinned
        Keys whose value is the sample's.
    broken
        Keys whose slope before and after may differ.
    """

    placed: BoolArray
    pinned: BoolArray
    broken: BoolArray

    def rows(self, channels: IntArray) -> "KeySet":
        """Give the keys of some channels."""
        return KeySet(self.placed[channels], self.pinned[channels], self.broken[channels])

    def with_rows(self, channels: IntArray, keys: "KeySet") -> "KeySet":
        """Exchange the keys of some channels."""
        out = KeySet(np.array(self.placed), np.array(self.pinned), np.array(self.broken))
        out.placed[channels], out.pinned[channels], out.broken[channels] = keys.placed, keys.pinned, keys.broken
        return out

    def without(self, removed: BoolArray) -> "KeySet":
        """Take keys away."""
        return KeySet(self.placed & ~removed, self.pinned & ~removed, self.broken & ~removed)


@dataclass(frozen=True, eq=False)
class Fit:
    """Fitted curves; N keys of all channels in a row.

    Parameters
    ----------
    curves
        Values at the samples, shape [C, T].
    channels, samples
        Where each key is, shape [N].
    values, slopes_before, slopes_after
        What it holds, slopes per sample step, shape [N].
    lengths
        Steps to the channel's next key, 0 for its last, shape [N].
    """

    curves: FloatArray
    channels: IntArray
    samples: IntArray
    values: FloatArray
    slopes_before: FloatArray
    slopes_after: FloatArray
    lengths: IntArray

    @cached_property
    def starts(self) -> IntArray:
        """Where each key's segment begins in the samples of all channels in a row, shape [N]."""
        return np.asarray(self.channels * self.curves.shape[1] + self.samples)

    @cached_property
    def segments(self) -> IntArray:
        """Which key each sample follows, shape [C, T]."""
        return np.repeat(np.arange(len(self.values)), np.maximum(self.lengths, 1)).reshape(self.curves.shape)


def hermite_basis(u: FloatArray, lengths: FloatArray) -> FloatArray:
    """Give weights of value and slope at the start and at the end, at parts u of segments; [M] and [M] to [4, M]."""
    square = u * u
    rise = square * (3.0 - 2.0 * u)
    return np.stack([1.0 - rise, u * np.square(1.0 - u) * lengths, rise, square * (u - 1.0) * lengths])


# Value and slope at the start and at the end of a segment, as cubics: powers of the part from 0 to 1, lowest first.
_BASIS = np.array([[1.0, 0.0, -3.0, 2.0], [0.0, 1.0, -2.0, 1.0], [0.0, 0.0, 3.0, -2.0], [0.0, 0.0, -1.0, 1.0]])
_BENDING = np.array([[12.0, 6.0, -12.0, 6.0], [6.0, 4.0, -6.0, 2.0], [-12.0, -6.0, 12.0, -6.0], [6.0, 2.0, -6.0, 4.0]])
_SWAPPED = [0, 1, 3, 2]


@lru_cache(maxsize=16)
def _segment_matrices(longest: int) -> FloatArray:
    """Give the normal equations of segments by themselves, their first sample included and their last not.

    Twice, the second time with the last two unknowns exchanged, for every length, [2, longest + 1, 16].
    """
    lengths, powers = np.maximum(np.arange(longest + 1.0), 1.0), np.arange(2 * len(_BASIS) - 1)
    below = np.vstack([np.zeros(len(powers)), np.cumsum(np.arange(float(longest))[:, None] ** powers, axis=0)])
    moments = below / lengths[:, None] ** powers
    fitted = _BASIS @ moments[:, np.add.outer(powers[:4], powers[:4])] @ _BASIS.T
    scale = np.stack([np.ones_like(lengths), lengths] * 2, axis=1)
    matrices = fitted + _STIFFNESS / lengths[:, None, None] ** 3 * _BENDING
    matrices *= scale[:, :, None] * scale[:, None]
    exchanged = matrices[:, _SWAPPED][:, :, _SWAPPED]
    return np.stack([matrices, exchanged]).reshape(2, longest + 1, -1)


def fit_curves(samples: FloatArray, keys: KeySet) -> Fit:
    """Fit curves to samples.

    Parameters
    ----------
    samples
        Values at even steps, shape [C, T], T at least 2.
    keys
        Where the curves have keys.
    """
    channels, places = np.nonzero(keys.placed)
    gaps = np.append(np.diff(channels * samples.shape[1] + places), 0)
    lengths = np.where(places == samples.shape[1] - 1, 0, gaps)
    blank = np.zeros(len(channels))
    fit = Fit(samples, channels, places, blank, blank, blank, lengths)
    parts = spread_parts(np.maximum(lengths, 1))
    solved = _solve(fit, _sum_segments(fit, parts), samples, keys)
    curves = sweep_cubics(solved.values, solved.slopes_before, solved.slopes_after, lengths.astype(np.float64), parts)
    return replace(solved, curves=curves.reshape(samples.shape))


@dataclass(frozen=True, eq=False)
class Parts:
    """Samples of segments in a row: how many each has, [N], and how far in its segment each sample is, 0 to 1, [M]."""

    counts: IntArray
    parts: FloatArray


def spread_parts(counts: IntArray) -> Parts:
    """Give each segment so many samples, [N], at even steps, the first at its start and none at its end."""
    starts = np.cumsum(counts) - counts
    inside = np.arange(int(counts.sum()), dtype=np.float64)
    inside -= np.repeat(starts.astype(np.float64), counts)
    inside *= np.repeat(1.0 / counts, counts)
    return Parts(counts, inside)


def sweep_cubics(
    values: FloatArray, slopes_before: FloatArray, slopes_after: FloatArray, lengths: FloatArray, samples: Parts
) -> FloatArray:
    """Evaluate the cubics between keys in a row.

    Parameters
    ----------
    values, slopes_before, slopes_after
        What the keys of all curves hold, shape [N].
    lengths
        To the next key of the same curve, in the unit of the slopes; 0 for the last, shape [N].
    samples
        Where to look.

    Returns
    -------
    FloatArray
        Shape [M].
    """
    is_last = lengths == 0.0
    rise = np.where(is_last, 0.0, np.append(np.diff(values), 0.0))
    start, end = lengths * slopes_after, lengths * np.append(slopes_before[1:], 0.0)
    # Horner's scheme, from the highest power on.
    curve = np.repeat(start + end - 2.0 * rise, samples.counts)
    for factor in (3.0 * rise - 2.0 * start - end, start, values):
        curve *= samples.parts
        curve += np.repeat(factor, samples.counts)
    return curve


def _sum_segments(fit: Fit, samples: Parts) -> FloatArray:
    """Sum up weights times samples over each segment, [4, N], by the moments of the samples."""
    powers = np.empty((_BAND + 1, fit.curves.size))
    powers[0] = fit.curves.ravel()
    for power in range(_BAND):
        np.multiply(powers[power], samples.parts, out=powers[power + 1])
    moment = np.add.reduceat(powers, fit.starts, axis=1)
    fall = 3.0 * moment[2] - 2.0 * moment[3]
    start, end = moment[1] - 2.0 * moment[2] + moment[3], moment[3] - moment[2]
    return np.stack([moment[0] - fall, start * fit.lengths, fall, end * fit.lengths])


def _solve(fit: Fit, sums: FloatArray, samples: FloatArray, keys: KeySet) -> Fit:
    """Find values and slopes; the curves are left."""
    from scipy.linalg import solveh_banded  # noqa: PLC0415  (slow to import, seldom used)

    broken = keys.broken[fit.channels, fit.samples]
    # Unknowns key after key: value and slope; of broken keys slope before, value, slope after.
    value = np.cumsum(2 + broken) - 2
    before, after = value + np.where(broken, -1, 1), value + 1
    band, right = _assemble(fit, sums, value, broken)
    last = value[fit.lengths == 0]
    band[0, last] += 1.0
    # The slopes before a broken first key and after a broken last one belong to no segment.
    band[0, band[0] == 0.0] = 1.0
    right[last] += samples[:, -1]
    pinned = keys.pinned[fit.channels, fit.samples]
    _hold(band, right, value[pinned], samples[fit.channels[pinned], fit.samples[pinned]])
    found = solveh_banded(band, right, lower=True, check_finite=False, overwrite_ab=True, overwrite_b=True)
    return replace(fit, values=found[value], slopes_before=found[before], slopes_after=found[after])


def _assemble(fit: Fit, sums: FloatArray, value: IntArray, broken: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Sum up the normal equations: lower band [4, U] and right side [U]; sums are of weights times samples [4, N]."""
    inner = np.flatnonzero(fit.lengths)
    first, swapped = value[inner], broken[inner + 1].astype(np.intp)
    # Before a broken key comes its slope, then its value: the last two unknowns are exchanged.
    matrices = _segment_matrices(fit.curves.shape[1] - 1)[swapped, fit.lengths[inner]].T
    ordered = np.where(swapped, sums[_SWAPPED][:, inner], sums[:, inner])
    band, right = np.zeros((_BAND + 1, int(value[-1]) + 2)), np.zeros(int(value[-1]) + 2)
    for row in range(4):
        right[first + row] += ordered[row]
        for column in range(row + 1):
            band[row - column, first + column] += matrices[4 * row + column]
    return band, right


def _hold(band: FloatArray, right: FloatArray, unknowns: IntArray, values: FloatArray) -> None:
    """Take known unknowns out of the equations, in place."""
    known, is_held = np.zeros(len(right)), np.zeros(len(right), dtype=np.bool_)
    known[unknowns], is_held[unknowns] = values, True
    for below in range(1, _BAND + 1):
        right[below:] -= band[below, :-below] * known[:-below]
        right[:-below] -= band[below, :-below] * known[below:]
        band[below, :-below][is_held[:-below] | is_held[below:]] = 0.0
    band[0, unknowns] = 1.0
    right[unknowns] = values
