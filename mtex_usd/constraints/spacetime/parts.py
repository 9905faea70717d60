"""Solving part of a motion in time, with the rest of its spline held."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from mtex_usd.constraints.spacetime.knots import DEGREE, Knots, cut_knots
from mtex_usd.constraints.spacetime.memory import Memory
from mtex_usd.constraints.spacetime.problem import Problem, compile_problem
from mtex_usd.constraints.spacetime.refine import Outcome, refine_until_met
from mtex_usd.constraints.spacetime.scene import Scene
from mtex_usd.errors import NoSolutionError
from mtex_usd.motion.skeleton import FloatArray, IntArray

__all__ = ["Part", "solve_part"]

_WIDER = 2.0  # times the margin, where the constraints cannot be met within


@dataclass(frozen=True, eq=False, kw_only=True)
class Part:
    """A part that was solved.

    Parameters
    ----------
    memory
        The whole with the part put in.
    outcome
        Where the search ended.
    violations
        Of the constraints in it, metres or radians, by name.
    window
        Its first and last frame.
    """

    memory: Memory
    outcome: Outcome
    violations: Mapping[str, float]
    window: tuple[int, int]


def solve_part(memory: Memory, first: float, last: float, margin: float) -> Part:
    """Solve the frames from first to last and a margin on either side.

    Points that keep still across the border of the part keep the places they have.

    Raises
    ------
    NoSolutionError
        Where the constraints cannot be met though the margin was widened to the whole motion.
    """
    while True:
        knots, begin = _cut(memory.knots, first - margin, last + margin)
        try:
            return _solve(memory, knots, begin)
        except NoSolutionError:
            if knots.count == memory.knots.count:
                raise
        margin *= _WIDER


def _cut(knots: Knots, first: float, last: float) -> tuple[Knots, int]:
    """Give the spline over a range of frames, and the number of its first coefficient."""
    begin, end = (int(span) for span in knots.span_of([max(first, 0.0), min(last, knots.frame_count - 1.0)]))
    # The outermost coefficients of a part are kept, so there have to be more.
    begin, end = max(begin - DEGREE, 0), min(end + DEGREE, len(knots.breaks) - 2)
    return cut_knots(knots, begin, end), begin


def _solve(memory: Memory, knots: Knots, begin: int) -> Part:
    end = begin + knots.count
    window = (int(knots.frames[0]), int(knots.frames[-1]))
    problem = _problem_in(memory, window)
    outcome = refine_until_met(
        problem,
        memory.settings,
        knots,
        memory.coefficients[begin:end],
        multipliers=problem.find_pulls(memory.pulls),
        kept=(DEGREE if begin > 0 else 0, DEGREE if end < memory.knots.count else 0),
    )
    added = np.setdiff1d(outcome.knots.extended, memory.knots.extended)
    extended = np.sort(np.concatenate([memory.knots.extended, added]))
    coefficients = [memory.coefficients[:begin], outcome.coefficients, memory.coefficients[end:]]
    solved = replace(
        memory,
        knots=Knots(extended, 0, memory.knots.frame_count),
        coefficients=np.concatenate(coefficients),
        places={**memory.places, **problem.name_places(outcome.places)},
        pulls={**memory.pulls, **_merge_pulls(memory, problem.name_pulls(outcome.multipliers))},
    )
    return Part(memory=solved, outcome=outcome, violations=problem.name_violations(outcome.evaluation), window=window)


def _problem_in(memory: Memory, window: tuple[int, int]) -> Problem:
    spans = memory.spans
    names = [name for name, span in spans.items() if span[0] <= window[1] and span[1] >= window[0]]
    inside = [memory.constraints[name] for name in names]
    scene = Scene(clips=memory.clips, window=window, known_places=memory.places)
    scene.write_all(inside)
    return compile_problem(memory.cast, inside, scene)


def _merge_pulls(
    memory: Memory, inside: Mapping[str, tuple[IntArray, FloatArray]]
) -> dict[str, tuple[IntArray, FloatArray]]:
    """Put the multipliers inside a part into those of the constraints that reach beyond it."""
    out = dict(inside)
    for name, (frames, multipliers) in inside.items():
        before, values = memory.pulls.get(name, (frames, multipliers))
        here = np.isin(before, frames)
        if here.sum() == len(frames) < len(before):
            merged = np.array(values)
            merged[here] = multipliers
            out[name] = (before, merged)
    return out
