"""Searching on ever finer knots until all constraints are met and the search is at rest."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solveh_banded

from mtex_usd.constraints.spacetime.cost import cost_diagonals
from mtex_usd.constraints.spacetime.elimination import Layout
from mtex_usd.constraints.spacetime.knots import Knots, split_spans
from mtex_usd.constraints.spacetime.problem import Evaluation, Problem, Settings
from mtex_usd.constraints.spacetime.quadratic import Effort
from mtex_usd.constraints.spacetime.search import Progress, Search, Unknowns
from mtex_usd.errors import NoSolutionError
from mtex_usd.motion.skeleton import FloatArray, IntArray

__all__ = ["Outcome", "refine_until_met"]

_LEAST_STEP = 1e-4  # radians or reaches: the search is at rest when no channel would move by more
_SHRINKS = 0.3  # ratio of two steps below which the search is seen to close in
_MOST_STEPS = 200
_STALLED = 1e-4  # radians or reaches: steps as small, with constraints unmet, lead nowhere
_GAIN = 0.5  # of the violation: a step that leaves less is no standstill
_MOST_RESTORATIONS = 40
_REACH = 2  # spans on either side of one that is too stiff: a cubic reaches as far
_EFFORTS = (Effort(rounds=12, gain=0.4), Effort(rounds=100, gain=0.95))
_MOST_NAMES = 20


@dataclass(frozen=True, eq=False, kw_only=True)
class Outcome:
    """Where a search came to rest.

    Parameters
    ----------
    knots
        The spline.
    coefficients
        Its coefficients, [K, C].
    places
        Free places, metres, [Q, 3].
    multipliers
        Pulls of the rows, [R].
    evaluation
        The constraints.
    iterations
        Steps taken or replaced by finer knots.
    step
        Largest change of any channel in the last one, radians or reaches.
    restless
        Frames where the search has not come to rest, [N].
    """

    knots: Knots
    coefficients: FloatArray
    places: FloatArray
    multipliers: FloatArray
    evaluation: Evaluation
    iterations: int
    step: float
    restless: IntArray


def refine_until_met(
    problem: Problem,
    settings: Settings,
    knots: Knots,
    coefficients: FloatArray,
    *,
    multipliers: FloatArray | None = None,
    kept: tuple[int, int] = (0, 0),
    restless_share: float = 0.0,
) -> Outcome:
    """Search, adding knots where the spline holds the constraints back from being met.

    Parameters
    ----------
    problem
        The constraints.
    settings
        What a change costs.
    knots, coefficients
        Where to start, [K, C].
    multipliers
        Pulls of the rows to start from, [R]; None for none.
    kept
        How many coefficients at the beginning and the end keep their values.
    restless_share
        Share of the frames below which what has not come to rest is left so, to be solved in parts.

    Raises
    ------
    NoSolutionError
        Where constraints are still violated when the search rests on the finest knots.
    """
    pulls = np.zeros(len(problem.info.frame)) if multipliers is None else multipliers
    return _Refinement(problem, settings, kept, restless_share).run(knots, coefficients, pulls)


class _Refinement:
    """One search over ever finer knots."""

    def __init__(self, problem: Problem, settings: Settings, kept: tuple[int, int], restless_share: float) -> None:
        self._problem, self._settings, self._kept = problem, settings, kept
        self._restless_share = restless_share
        self._effort = 0

    def run(self, knots: Knots, coefficients: FloatArray, multipliers: FloatArray) -> Outcome:
        search = self._search_on(knots)
        now = self._begin(search, coefficients, multipliers)
        # Where a change was made before, less of it may do now.
        if now.evaluation.is_met and not coefficients.any():
            return _outcome(search, now, 0)
        if not self._problem.observer.column_count:
            raise no_solution(now.evaluation)
        for iteration in range(1, _MOST_STEPS + 1):
            plan = search.plan(now.unknowns, now.evaluation, _EFFORTS[self._effort])
            finer = self._split(search.layout.knots, plan.stiff_frames)
            if finer is not search.layout.knots:
                search, now = self._move_to(finer, search, plan.origin)
                continue
            before, now = now, search.take(plan)
            if now.evaluation.is_met and _still_to_go(before.step, now.step) <= _LEAST_STEP:
                return _outcome(search, now, iteration)
            restless = self._restless(now, search.layout.knots.first_frame)
            if len(restless) < self._restless_share * search.layout.knots.frame_count:
                return replace(_outcome(search, now, iteration), restless=restless)
            if self._is_stuck(before, now):
                break
        return _outcome(search, self._restore(search, now), iteration)

    def _restless(self, now: Progress, first_frame: int) -> IntArray:
        """Find the frames of the clip that moved in the last step or where a constraint is not met."""
        unmet = self._problem.info.frame[now.evaluation.violation > 1.0]
        moved = np.flatnonzero(now.steps > _LEAST_STEP) + first_frame
        return np.union1d(unmet, moved)

    def _restore(self, search: Search, rested: Progress) -> Progress:
        """Meet the constraints from where the search ended, at whatever cost, if they can be met at all."""
        now = rested
        for _ in range(_MOST_RESTORATIONS):
            if now.evaluation.is_met:
                return now
            now = search.restore(now.unknowns, now.evaluation, _EFFORTS[-1])
        if now.evaluation.is_met:
            return now
        raise no_solution(rested.evaluation)

    def _search_on(self, knots: Knots) -> Search:
        return Search(problem=self._problem, layout=_lay_out(self._problem, self._settings, knots, self._kept))

    def _begin(self, search: Search, coefficients: FloatArray, multipliers: FloatArray) -> Progress:
        at = self._problem.frames - search.layout.knots.first_frame
        places = self._problem.find_places(search.changes(coefficients)[at])
        unknowns = Unknowns(coefficients=coefficients, places=places, multipliers=multipliers)
        return Progress(unknowns=unknowns, evaluation=search.evaluate(coefficients, places))

    def _split(self, knots: Knots, frames: IntArray) -> Knots:
        if not frames.size:
            return knots
        return split_spans(knots, frames, reach=_REACH, kept=self._kept)

    def _move_to(self, finer: Knots, search: Search, unknowns: Unknowns) -> tuple[Search, Progress]:
        first, last = self._kept
        coefficients = _fit(finer, search.changes(unknowns.coefficients))
        coefficients[:first] = unknowns.coefficients[:first]
        coefficients[len(coefficients) - last :] = unknowns.coefficients[len(unknowns.coefficients) - last :]
        moved, fresh = replace(unknowns, coefficients=coefficients), self._search_on(finer)
        evaluation = fresh.evaluate(coefficients, moved.places)
        return fresh, Progress(unknowns=moved, evaluation=evaluation)

    def _is_stuck(self, before: Progress, now: Progress) -> bool:
        """Tell whether more of the same would lead nowhere; tries harder first."""
        gains = now.evaluation.worst_ratio < _GAIN * before.evaluation.worst_ratio
        if now.evaluation.is_met or gains or now.step > _STALLED:
            return False
        self._effort = min(self._effort + 1, len(_EFFORTS))
        return self._effort == len(_EFFORTS)


def _still_to_go(before: float, step: float) -> float:
    """Estimate how far the search would still go: steps that shrink by a ratio add up."""
    ratio = step / before if before > 0.0 else 1.0
    return step * ratio / (1.0 - ratio) if ratio < _SHRINKS else step


def _outcome(search: Search, rested: Progress, iterations: int) -> Outcome:
    return Outcome(
        knots=search.layout.knots,
        coefficients=rested.unknowns.coefficients,
        places=rested.unknowns.places,
        multipliers=rested.unknowns.multipliers,
        evaluation=rested.evaluation,
        iterations=iterations,
        step=rested.step,
        restless=np.zeros(0, dtype=np.intp),
    )


def no_solution(evaluation: Evaluation) -> NoSolutionError:
    """Name the constraints that are violated, the worst first, and by how much."""
    problem, worst = evaluation.problem, evaluation.worst()
    tolerance = np.array([constraint.tolerance for constraint in problem.constraints])
    unmet = [number for number in np.argsort(-worst / tolerance) if worst[number] > tolerance[number]]
    lengths = set(problem.info.owner[problem.info.length].tolist())
    found = [
        f"{problem.constraints[number].name} by "
        + (f"{1e3 * worst[number]:.3g} mm" if number in lengths else f"{np.degrees(worst[number]):.3g} degrees")
        for number in unmet[:_MOST_NAMES]
    ]
    more = len(unmet) - len(found)
    return NoSolutionError(
        f"{len(unmet)} of {len(problem.constraints)} constraints cannot be met together",
        expected="all within their tolerances",
        found="at the best compromise " + ", ".join(found) + (f", and {more} more" if more else ""),
        fix="Move or leave out one of them, allow a larger tolerance, or let more joints move.",
    )


def _lay_out(problem: Problem, settings: Settings, knots: Knots, kept: tuple[int, int]) -> Layout:
    rate = problem.cast.characters[0].clip.rate
    return Layout(
        knots=knots,
        cost=cost_diagonals(
            knots,
            cycles_per_frame=settings.frequency / rate,
            smoothness=settings.smoothness,
            highpass=settings.highpass,
        ),
        weights=problem.cast.weights,
        place_first=problem.place_frames[:, 0] - knots.first_frame,
        place_last=problem.place_frames[:, 1] - knots.first_frame,
        kept=kept,
    )


def _fit(knots: Knots, changes: FloatArray) -> FloatArray:
    """Give the coefficients [K, C] of curves that are known to be on finer knots, from their values [F, C]."""
    square = cost_diagonals(knots, cycles_per_frame=0.5, smoothness=0.0, highpass=0.0)
    return np.asarray(solveh_banded(square, knots.matrix.T @ changes, lower=True))
