"""Least-squares cubic Hermite curves through chosen keys, for many channels in one banded solve.

Samples are at even steps; a curve is a value and a slope at every key, a cubic between keys. Slopes before and after a
key are the same unless the key is broken; a pinned key keeps the sample's value. Every cubic touches four unknowns in a
row, so the normal equations of all channels together are one band matrix.
"""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt

__all__ = ["Fit", "KeySet", "fit_curves", "hermite_basis"]

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


@lru_cache(maxsize=4096)
def _segment_matrix(length: int) -> FloatArray:
    """Give the normal equations of a segment by itself, its first sample included and its last not, [4, 4]."""
    h = float(length)
    weights = hermite_basis(np.arange(length) / h, np.full(length, h))
    bending = np.array(
        [
            [12.0, 6.0 * h, -12.0, 6.0 * h],
            [6.0 * h, 4.0 * h * h, -6.0 * h, 2.0 * h * h],
            [-12.0, -6.0 * h, 12.0, -6.0 * h],
            [6.0 * h, 2.0 * h * h, -6.0 * h, 4.0 * h * h],
        ]
    )
    return np.asarray(weights @ weights.T + _STIFFNESS / h**3 * bending)


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
    parts = (np.arange(samples.size) - fit.starts[fit.segments.ravel()]) / np.maximum(lengths, 1)[fit.segments.ravel()]
    weights = hermite_basis(parts, lengths[fit.segments.ravel()].astype(np.float64))
    solved = _solve(fit, weights, samples, keys)
    following = np.minimum(np.arange(len(channels)) + 1, len(channels) - 1)
    ends = np.stack([solved.values, solved.slopes_after, solved.values[following], solved.slopes_before[following]])
    curves = np.einsum("am,am->m", weights, ends[:, fit.segments.ravel()])
    return replace(solved, curves=curves.reshape(samples.shape))


def _solve(fit: Fit, weights: FloatArray, samples: FloatArray, keys: KeySet) -> Fit:
    """Find values and slopes; the curves are left."""
    from scipy.linalg import solveh_banded  # noqa: PLC0415  (slow to import, seldom used)

    broken = keys.broken[fit.channels, fit.samples]
    # Unknowns key after key: value and slope; of broken keys slope before, value, slope after.
    value = np.cumsum(2 + broken) - 2
    before, after = value + np.where(broken, -1, 1), value + 1
    band, right = _assemble(fit, weights * samples.ravel(), value, broken)
    last = value[fit.lengths == 0]
    band[0, last] += 1.0
    # The slopes before a broken first key and after a broken last one belong to no segment.
    band[0, band[0] == 0.0] = 1.0
    right[last] += samples[:, -1]
    pinned = keys.pinned[fit.channels, fit.samples]
    _hold(band, right, value[pinned], samples[fit.channels[pinned], fit.samples[pinned]])
    found = solveh_banded(band, right, lower=True, check_finite=False, overwrite_ab=True, overwrite_b=True)
    return replace(fit, values=found[value], slopes_before=found[before], slopes_after=found[after])


def _assemble(fit: Fit, products: FloatArray, value: IntArray, broken: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Sum up the normal equations: lower band [4, U] and right side [U]; products are weights times samples [4, M]."""
    inner = np.flatnonzero(fit.lengths)
    sums = np.add.reduceat(products, fit.starts, axis=1)[:, inner]
    kinds, which = np.unique(fit.lengths[inner], return_inverse=True)
    first, swapped = value[inner], broken[inner + 1].astype(np.intp)
    # Before a broken key comes its slope, then its value: two tables, one with the last two unknowns exchanged.
    tables = np.stack([_segment_matrix(length) for length in kinds.tolist()])
    tables = np.stack([tables, tables[:, [0, 1, 3, 2]][:, :, [0, 1, 3, 2]]])
    matrices = np.ascontiguousarray(np.moveaxis(tables.reshape(-1, 16)[swapped * len(kinds) + which], 0, 1))
    ordered = np.where(swapped, sums[[0, 1, 3, 2]], sums)
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
