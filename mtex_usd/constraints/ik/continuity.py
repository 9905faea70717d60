"""Frames that have found another way to bend than their neighbours.

The least change is one of several near solutions, and two of them can be as good: a leg that is all but straight bends
forward or backward with the noise. Between two jumps of the change from one frame to the next is a stretch of frames
that went another way; a stretch that is shorter than those beside it is solved again, from and near where they are.
Gleicher 2000, section 1.7.1, names both criteria: as near as possible to the given pose, or to the frame before.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.ik.newton import minimize
from mtex_usd.constraints.ik.objective import Objective

__all__ = ["mend_jumps"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

_JUMP = 0.3  # radians from one frame to the next: no smooth motion changes its change that fast
_WARM = 0.03  # softness that keeps the search near where it begins
_WORSE = 2.0  # times the squared change of their own solutions is accepted for frames that follow their neighbours
_MISSED = 1e-3  # part of what a goal is missed by that makes no difference
_REACHED = 1e-6  # lengths of the limb: goals missed by less are met
_PASSES = 6


@dataclass(frozen=True, kw_only=True)
class _Stretch:
    """Frames from first to last, both included, and the frames before and after them that they are to go on from.

    A longer stretch follows a shorter one only to come nearer to its goals.
    """

    first: int
    last: int
    before: int
    after: int
    longer: bool


def mend_jumps(objective: Objective, values: FloatArray, frames: IntArray, *, rounds: int) -> FloatArray:
    """Solve stretches of frames that went another way again, from the frames beside them.

    Parameters
    ----------
    objective
        What is made small.
    values
        Of all frames of the clip, shape [F, N, 3].
    frames
        The frames that were solved; beside others there is nothing to mend.
    rounds
        Of the solver.

    Returns
    -------
    FloatArray
        Shape [F, N, 3]. A stretch is replaced where that leaves smaller jumps, misses no goal by more, and changes the
        pose at most twice as much.
    """
    out = np.array(values)
    tried: set[_Stretch] = set()
    for _ in range(_PASSES):
        stretches = _find_stretches(objective, out, frames, tried)
        if not stretches:
            break
        tried.update(stretches)
        at = np.concatenate([np.arange(s.first, s.last + 1) for s in stretches])
        guide, found = np.array(out), np.array(out)
        for stretch in stretches:
            guide[stretch.first : stretch.last + 1] = _bridge(out, stretch)
        guided = replace(objective, guide=guide)
        found[at] = minimize(guided, guide[at], at, rounds=rounds, softness=_WARM)
        for stretch in stretches:
            if _is_better(objective, out, found, stretch):
                out[stretch.first : stretch.last + 1] = found[stretch.first : stretch.last + 1]
    return out


def _find_stretches(objective: Objective, values: FloatArray, frames: IntArray, tried: set[_Stretch]) -> list[_Stretch]:
    """List stretches to solve again, none beside another: of two the shorter, and if that has failed the other."""
    jumps, joined = _find_jumps(objective, values, frames)
    edges = [0, *(np.flatnonzero(jumps | ~joined) + 1).tolist(), len(values)]
    # Of two as long it is every other one.
    ranks = [(end - first, number % 2 == 0) for number, (first, end) in enumerate(pairwise(edges))]
    found: dict[int, _Stretch] = {}
    for number, (first, end) in enumerate(pairwise(edges)):
        beside = {first - 1: number - 1} if first > 0 and jumps[first - 1] else {}
        beside |= {end: number + 1} if end < len(values) and jumps[end - 1] else {}
        if beside:
            longer = any(ranks[other] < ranks[number] for other in beside.values())
            found[number] = _Stretch(first=first, last=end - 1, before=min(beside), after=max(beside), longer=longer)
    waiting = {number: ranks[number] for number, stretch in found.items() if stretch not in tried}
    return [
        found[own] for own, rank in waiting.items() if all(waiting.get(n, rank) >= rank for n in (own - 1, own + 1))
    ]


def _bridge(values: FloatArray, stretch: _Stretch) -> FloatArray:
    """Give values that go evenly from the frame before a stretch to the frame after it; of one alone, that one's."""
    frames = np.arange(stretch.first, stretch.last + 1)
    ends = values[[stretch.before, stretch.after]]
    if stretch.before == stretch.after:
        return np.repeat(ends[:1], len(frames), axis=0)
    shares = ((frames - stretch.before) / (stretch.after - stretch.before))[:, None, None]
    return np.asarray((1.0 - shares) * ends[0] + shares * ends[1])


def _find_jumps(objective: Objective, values: FloatArray, frames: IntArray) -> tuple[BoolArray, BoolArray]:
    """Find from which frame to the next the change jumps, and where it should not: the same goals hold; [F - 1]."""
    solved = np.zeros(len(values), dtype=np.bool_)
    solved[frames] = True
    held = np.stack([goal.is_active() for goal in objective.goals], axis=1)
    joined = np.asarray((held[1:] == held[:-1]).all(axis=1)) & solved[1:] & solved[:-1]
    return joined & (_steps(values) > _JUMP), joined


def _steps(values: FloatArray) -> FloatArray:
    """Give the largest change of a coordinate from each frame to the next, [F, N, 3] to [F - 1]."""
    return np.asarray(np.abs(np.diff(values, axis=0)).max(axis=(1, 2), initial=0.0))


def _is_better(objective: Objective, before: FloatArray, after: FloatArray, stretch: _Stretch) -> bool:
    inside = np.arange(stretch.first, stretch.last + 1)
    around = slice(max(stretch.first - 1, 0), stretch.last + 2)
    mixed = np.array(before[around])
    mixed[inside - around.start] = after[inside]
    smoother = _roughness(mixed) < _roughness(before[around])
    if not smoother:
        return False
    weights = np.array([goal.weight for goal in objective.goals])[:, None]
    own, found = (np.linalg.norm(weights * objective.errors(values[inside], inside)) for values in (before, after))
    change, now = (np.square(values[inside]).sum() for values in (before, after))
    if stretch.longer:
        return bool(found < own * (1.0 - _MISSED) - _REACHED)
    return bool(found <= own * (1.0 + _MISSED) + _REACHED and now <= _WORSE * change)


def _roughness(values: FloatArray) -> float:
    return float(np.maximum(_steps(values) - _JUMP, 0.0).sum())
