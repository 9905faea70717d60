"""The search for the least change that meets the constraints.

Sequential quadratic programming: at every step the constraints are linearised and the least change that meets them is
found; the step is shortened until the augmented Lagrangian falls.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from mtex_usd.constraints.spacetime.elimination import Layout
from mtex_usd.constraints.spacetime.problem import Evaluation, Problem
from mtex_usd.constraints.spacetime.quadratic import LESS_BEND, Effort, Quadratic
from mtex_usd.motion.skeleton import FloatArray, IntArray

__all__ = ["Plan", "Progress", "Search", "Unknowns"]

_MERIT_PENALTY = 1e3  # less than in the program, or the search could not follow a curved constraint
_LONGEST_TURN = 0.7  # radians or reaches per step, beyond which the linearisation means nothing
_HALVINGS = 6
_ARMIJO = 1e-4


@dataclass(frozen=True, eq=False, kw_only=True)
class Unknowns:
    """What the search varies.

    Parameters
    ----------
    coefficients
        Of the displacement's splines, [K, C].
    places
        Free places, metres, [Q, 3].
    multipliers
        Pull of each row, [R].
    bend_share
        How much of the constraints' second derivatives left the last program positive.
    """

    coefficients: FloatArray
    places: FloatArray
    multipliers: FloatArray
    bend_share: float = 1.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Plan:
    """A step that was found and not yet taken.

    Parameters
    ----------
    origin
        Where it starts.
    goal
        Where it would end, with the multipliers there.
    lengths
        Largest change of any channel at each frame, radians or reaches, [F].
    value, slope
        Augmented Lagrangian at the start and its rate along the step.
    stiff_frames
        Frames that the spline holds back from being met.
    """

    origin: Unknowns
    goal: Unknowns
    lengths: FloatArray
    value: float
    slope: float
    stiff_frames: IntArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Progress:
    """One step done.

    Parameters
    ----------
    unknowns
        Where it led.
    evaluation
        The constraints there.
    steps
        Largest change of any channel at each frame, radians or reaches, [F]; none where nothing was done yet.
    """

    unknowns: Unknowns
    evaluation: Evaluation
    steps: FloatArray = field(default_factory=lambda: np.zeros(0))

    @property
    def step(self) -> float:
        """Largest change at any frame."""
        return float(self.steps.max(initial=0.0))


@dataclass(frozen=True, eq=False, kw_only=True)
class Search:
    """A problem on a spline.

    Parameters
    ----------
    problem
        The constraints.
    layout
        The spline with its cost.
    """

    problem: Problem
    layout: Layout

    def changes(self, coefficients: FloatArray) -> FloatArray:
        """Give the displacement at every frame of the knots, [F, C]."""
        return np.asarray(self.layout.knots.matrix @ coefficients)

    def evaluate(self, coefficients: FloatArray, places: FloatArray) -> Evaluation:
        """Evaluate the constraints for coefficients [K, C] and places [Q, 3] in metres."""
        at = self.problem.frames - self.layout.knots.first_frame
        return self.problem.evaluate(self.changes(coefficients)[at], places)

    def plan(self, origin: Unknowns, evaluation: Evaluation, effort: Effort) -> Plan:
        """Find the next step."""
        gradient = self.layout.pull_back(origin.coefficients)
        bends = evaluation.bend(origin.multipliers)
        program = Quadratic(
            layout=self.layout,
            evaluation=evaluation,
            gradient=gradient,
            bends=bends,
            bend_share=min(1.0, origin.bend_share / LESS_BEND),
            pulls=origin.multipliers,
        )
        move, multipliers, bend_share = program.solve(effort)
        coefficients, places = self.layout.split(move)
        pull = self._pull(evaluation, multipliers)
        slope = float(np.sum(gradient * coefficients) + pull @ program.change_of_rows(move))
        return Plan(
            origin=origin,
            goal=Unknowns(
                coefficients=origin.coefficients + coefficients,
                places=origin.places + self.problem.cast.reach * places,
                multipliers=multipliers,
                bend_share=bend_share,
            ),
            lengths=self._lengths(coefficients),
            value=self._merit(origin.coefficients, evaluation, multipliers),
            slope=min(slope, 0.0),
            stiff_frames=program.find_stiff_frames(move, effort),
        )

    def take(self, plan: Plan) -> Progress:
        """Go as far along a step as the augmented Lagrangian falls."""
        misled = 1.0
        share = min(1.0, _LONGEST_TURN / max(float(plan.lengths.max()), _LONGEST_TURN))
        for _ in range(_HALVINGS):
            unknowns = _between(plan.origin, plan.goal, share)
            evaluation = self.evaluate(unknowns.coefficients, unknowns.places)
            value = self._merit(unknowns.coefficients, evaluation, unknowns.multipliers)
            if value <= plan.value + _ARMIJO * share * plan.slope:
                break
            share *= 0.5
            # The second derivatives it was built on misled.
            misled = LESS_BEND**2
        unknowns = replace(unknowns, bend_share=misled * unknowns.bend_share)
        return Progress(unknowns=unknowns, evaluation=evaluation, steps=share * plan.lengths)

    def restore(self, unknowns: Unknowns, evaluation: Evaluation, effort: Effort) -> Progress:
        """Go to the nearest motion that meets the linearised constraints, whatever the change from the first costs."""
        program = Quadratic(
            layout=self.layout,
            evaluation=evaluation,
            gradient=np.zeros_like(unknowns.coefficients),
            bends=np.zeros((0, 0, 0)),
            bend_share=0.0,
            pulls=unknowns.multipliers,
        )
        move, _, _ = program.solve(effort)
        coefficients, places = self.layout.split(move)
        nearest = replace(
            unknowns,
            coefficients=unknowns.coefficients + coefficients,
            places=unknowns.places + self.problem.cast.reach * places,
        )
        found = self.evaluate(nearest.coefficients, nearest.places)
        return Progress(unknowns=nearest, evaluation=found, steps=self._lengths(coefficients))

    def _lengths(self, coefficients: FloatArray) -> FloatArray:
        """Largest change of any channel at each frame, weighed, [F]."""
        return np.asarray(np.abs(self.changes(coefficients) * np.sqrt(self.layout.weights)).max(axis=1))

    def _pull(self, evaluation: Evaluation, multipliers: FloatArray) -> FloatArray:
        pull = multipliers + _MERIT_PENALTY * evaluation.residual
        return np.where(self.problem.info.inequality, np.maximum(pull, 0.0), pull)

    def _merit(self, coefficients: FloatArray, evaluation: Evaluation, multipliers: FloatArray) -> float:
        """Augmented Lagrangian."""
        cost = 0.5 * float(np.sum(coefficients * self.layout.pull_back(coefficients)))
        pull = self._pull(evaluation, multipliers)
        return cost + float(pull @ pull - multipliers @ multipliers) / (2.0 * _MERIT_PENALTY)


def _between(origin: Unknowns, goal: Unknowns, share: float) -> Unknowns:
    """Go a share of the way; the multipliers are the goal's."""
    return Unknowns(
        coefficients=origin.coefficients + share * (goal.coefficients - origin.coefficients),
        places=origin.places + share * (goal.places - origin.places),
        multipliers=goal.multipliers,
        bend_share=goal.bend_share,
    )
