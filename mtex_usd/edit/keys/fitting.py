"""Where keys go: added where a motion is off by too much, taken away again where it can do without.

Adding: in each cubic that is to blame a key is set at the centre of what is wrong with it; cubics that are as short as
they can be get their ends pinned and broken. Taking away: every third key of each channel goes at once, and those whose
absence is to blame for an error come back.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.keys.hermite import Fit, KeySet, fit_curves

__all__ = ["Blame", "State", "add_keys", "drop_keys", "start_keys"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

Blame = Callable[[FloatArray], FloatArray]
"""From errors of channels [C, T] to how much each is to blame at each sample, 0 where not at all, [C, T]."""

_ROUNDS = 200
_CROWDED = 6  # frames: where keys come this near there is a corner, which a broken key makes alone
_STRIDE = 3
_RETURNS = 2


@dataclass(frozen=True, eq=False)
class State:
    """Keys and the curves through them.

    Parameters
    ----------
    samples
        What is fitted, frame by frame, shape [C, T].
    keys
        The keys.
    fixed
        Keys that may not go, shape [C, T].
    curves
        The fitted curves, shape [C, T].
    """

    samples: FloatArray
    keys: KeySet
    fixed: BoolArray
    curves: FloatArray

    @property
    def errors(self) -> FloatArray:
        """How far each curve is off, shape [C, T]."""
        return np.asarray(self.curves - self.samples)

    def refit(self, keys: KeySet, changed: IntArray) -> "State":
        """Exchange the keys; only the channels that changed are fitted again."""
        curves = np.array(self.curves)
        if changed.size:
            curves[changed] = fit_curves(self.samples[changed], keys.rows(changed)).curves
        return replace(self, keys=keys, curves=curves)

    def layout(self, channels: IntArray) -> Fit:
        """Give the segments of some channels, with their curves, without what the keys hold."""
        placed = self.keys.placed[channels]
        rows, places = np.nonzero(placed)
        gaps = np.append(np.diff(rows * placed.shape[1] + places), 0)
        blank = np.zeros(len(rows))
        lengths = np.where(places == placed.shape[1] - 1, 0, gaps)
        return Fit(self.curves[channels], rows, places, blank, blank, blank, lengths)


def start_keys(samples: FloatArray, frames: IntArray) -> State:
    """Begin with the fixed keys.

    Parameters
    ----------
    samples
        What is to be fitted, shape [C, T].
    frames
        Frames that are keys of every channel; the first and the last are added.
    """
    fixed = np.zeros(samples.shape, dtype=np.bool_)
    fixed[:, frames] = True
    fixed[:, [0, -1]] = True
    keys = KeySet(fixed, fixed, np.zeros_like(fixed))
    return State(samples, keys, fixed, fit_curves(samples, keys).curves)


def add_keys(state: State, blame: Blame) -> State:
    """Add keys until nothing is to blame, or no key can be added that would help.

    Parameters
    ----------
    state
        Where to begin.
    blame
        What is wrong with errors of the channels.
    """
    for _ in range(_ROUNDS):
        weights = blame(state.errors)
        guilty = np.flatnonzero(weights.any(axis=1))
        if not guilty.size:
            break
        keys = _insert(state, guilty, weights[guilty])
        changed = _differing(state.keys, keys)
        if not changed.size:
            break
        state = state.refit(keys, changed)
    return state


def _differing(before: KeySet, after: KeySet) -> IntArray:
    pairs = (
        (before.placed, after.placed),
        (before.pinned, after.pinned),
        (before.broken, after.broken),
    )
    return np.flatnonzero(np.any([(a != b).any(axis=1) for a, b in pairs], axis=0))


def _insert(state: State, guilty: IntArray, weights: FloatArray) -> KeySet:
    """Set one key in every segment that is to blame; weights are those of the guilty channels, [G, T]."""
    layout = state.layout(guilty)
    keys = state.keys.rows(guilty)
    placed, pinned, broken = np.array(keys.placed), np.array(keys.pinned), np.array(keys.broken)
    bad = np.add.reduceat(weights.ravel(), layout.starts) > 0.0
    long = layout.lengths > 1
    split = np.flatnonzero(bad & long)
    placed[layout.channels[split], _centres(layout, weights, split)] = True
    short = np.flatnonzero(bad & ~long)
    ends = np.unique(np.concatenate([short, short[layout.lengths[short] > 0] + 1]))
    pinned[layout.channels[ends], layout.samples[ends]] = True
    crowded = split[layout.lengths[split] <= _CROWDED]
    corners = np.unique(np.concatenate([ends, crowded, crowded + 1]))
    broken[layout.channels[corners], layout.samples[corners]] = True
    return state.keys.with_rows(guilty, KeySet(placed, pinned, broken))


def _centres(layout: Fit, weights: FloatArray, split: IntArray) -> IntArray:
    """Frame inside each segment, nearest the centre of what is wrong with it."""
    times = np.broadcast_to(np.arange(weights.shape[1], dtype=np.float64), weights.shape)
    total = np.add.reduceat(weights.ravel(), layout.starts)[split]
    moment = np.add.reduceat((weights * times).ravel(), layout.starts)[split]
    nearest = np.round(moment / total).astype(np.intp)
    first = layout.samples[split]
    return np.clip(nearest, first + 1, first + layout.lengths[split] - 1)


def drop_keys(state: State, blame: Blame, *, passes: int) -> State:
    """Take keys away that are not needed.

    Parameters
    ----------
    state
        Keys with which nothing is to blame.
    blame
        As :func:`add_keys` takes it.
    passes
        How many times a part of the keys is tried.
    """
    for number in range(passes):
        state = _drop_some(state, blame, number % _STRIDE)
    return state


def _drop_some(state: State, blame: Blame, phase: int) -> State:
    rank = np.cumsum(state.keys.placed, axis=1)
    removed = state.keys.placed & ~state.fixed & (rank % _STRIDE == phase)
    found = state.refit(state.keys.without(removed), np.flatnonzero(removed.any(axis=1)))
    for _ in range(_RETURNS):
        weights = blame(found.errors)
        if not weights.any():
            return found
        back = _to_return(found, weights, removed)
        if not back.any():
            break
        removed &= ~back
        found = found.refit(state.keys.without(removed), np.flatnonzero(back.any(axis=1)))
    # What returning keys do not mend new ones do, often fewer and at better places.
    mended = add_keys(found, blame)
    return mended if mended.keys.placed.sum() < state.keys.placed.sum() else state


def _to_return(found: State, weights: FloatArray, removed: BoolArray) -> BoolArray:
    """Find the removed keys in segments that are to blame, else those next to them."""
    rows = np.flatnonzero(removed.any(axis=1))
    layout = found.layout(rows)
    bad = np.add.reduceat(weights[rows].ravel(), layout.starts) > 0.0
    empty = np.add.reduceat(removed[rows].ravel().astype(np.intp), layout.starts) == 0
    beside = bad & empty
    bad[:-1] |= beside[1:]
    bad[1:] |= beside[:-1]
    back = np.zeros_like(removed)
    back[rows] = bad[layout.segments] & removed[rows]
    return back
