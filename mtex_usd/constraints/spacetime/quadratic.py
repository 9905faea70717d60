"""One step's quadratic program: the least squared change that meets the linearised constraints.

Solved by the method of multipliers. All rounds use one factorisation; it is made anew only where an inequality starts
or stops to press. The quadratic form has the second derivatives of the constraints too, weighed by the last step's
multipliers, as far as that leaves it positive: without them the search crawls wherever a constraint pulls hard.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.spacetime.elimination import Factors, Layout, RowSystem, factorize, solve_factors
from mtex_usd.constraints.spacetime.problem import Evaluation
from mtex_usd.motion.skeleton import FloatArray, IntArray

__all__ = ["LESS_BEND", "Effort", "Quadratic"]

BoolArray = npt.NDArray[np.bool_]

_PENALTY = 1e5  # of a violation squared, in reaches or radians, beside the change squared
_SETS = 3  # of pressing inequalities tried per step
_LINEAR_SHARE = 0.01  # of the tolerance: linearised constraints are met when nearer
LESS_BEND = 0.7  # of the share of the second derivatives, where that leaves the form no longer positive
_LEAST_BEND = 0.15  # share below which they are left out
_ENTERING = 0.1  # of the tolerance: an inequality violated by less does not start to press
_ALONE = 0.3  # of what the whole leaves unmet: a frame that leaves less by itself is held back by the spline


@dataclass(frozen=True, kw_only=True)
class Effort:
    """How long the multipliers are improved.

    Parameters
    ----------
    rounds
        At most so often.
    gain
        A round that leaves more than this of the violation is the last.
    """

    rounds: int
    gain: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Quadratic:
    """The program at one iterate.

    Parameters
    ----------
    layout
        The spline with its cost.
    evaluation
        The constraints at the iterate.
    gradient
        Of the cost by the coefficients, [K, C].
    bends
        Second derivatives of the constraints, weighed, at the problem's frames, [U, C, C].
    bend_share
        How much of them to try first.
    pulls
        Multipliers of the last program, which tell the inequalities that press, [R].
    """

    layout: Layout
    evaluation: Evaluation
    gradient: FloatArray
    bends: FloatArray
    bend_share: float
    pulls: FloatArray

    @cached_property
    def frame(self) -> IntArray:
        """Frame of each row, from the knots' first, [R]."""
        return np.asarray(self.evaluation.problem.info.frame - self.layout.knots.first_frame)

    def solve(self, effort: Effort) -> tuple[FloatArray, FloatArray, float]:
        """Give the step, a vector of all unknowns, the multipliers [R] there, and the share of bends that was used."""
        residual = self.evaluation.residual
        # From none at every step: rows that ask the same twice would go on pulling against each other for ever.
        multipliers = np.zeros(len(residual))
        pressing, left = self._pressing(self.pulls + _PENALTY * residual), np.inf
        (factors, share), sets, rounds = self._factorize(pressing, self.bend_share), 0, 0
        while True:
            move = solve_factors(factors, -self._slopes(multipliers, pressing))
            linear = residual + self.change_of_rows(move)
            pull = multipliers + _PENALTY * linear
            now = self._pressing_next(pressing, pull, linear)
            if sets < _SETS and not np.array_equal(now, pressing):
                sets, pressing = sets + 1, now
                factors, share = self._factorize(now, share)
                continue
            multipliers = np.where(pressing, self._one_sided(pull), 0.0)
            before, left, rounds = left, float(np.abs(self._off(linear)).max()), rounds + 1
            if left <= _LINEAR_SHARE or rounds >= effort.rounds or left > effort.gain * before:
                return move, multipliers, share

    def find_stiff_frames(self, move: FloatArray, effort: Effort) -> IntArray:
        """Find the frames, from the clip's first, whose linearised rows the spline holds back from being met."""
        off = self._off(self.evaluation.residual + self.change_of_rows(move))
        frames = np.unique(self.frame[np.abs(off) > 1.0])
        if not frames.size:
            return frames
        alone = self.evaluation.residual + self._change_by_places(move)
        stiff = [frame for frame in frames if self._meets_alone(self.frame == frame, alone, off, effort)]
        return np.array(stiff, dtype=np.intp) + self.layout.knots.first_frame

    def change_of_rows(self, move: FloatArray) -> FloatArray:
        """Change of the rows [R] along a step, to first order."""
        coefficients, _ = self.layout.split(move)
        changes = (self.layout.knots.matrix @ coefficients)[self.frame]
        by_channels = np.einsum("rc,rc->r", self.evaluation.jacobian, changes)
        return np.asarray(by_channels + self._change_by_places(move))

    def _change_by_places(self, move: FloatArray) -> FloatArray:
        info, out = self.evaluation.problem.info, np.zeros(len(self.frame))
        _, places = self.layout.split(move)
        held = info.place >= 0
        out[held] = -np.einsum("ri,ri->r", info.normal[held], places[info.place[held]])
        return out

    def _meets_alone(self, at: BoolArray, alone: FloatArray, off: FloatArray, effort: Effort) -> bool:
        """Tell whether a frame, if its channels were free, would leave much less of its rows unmet."""
        rows = np.flatnonzero(at & self._pressing(off))
        jacobian = self.evaluation.jacobian[rows]
        soft = np.eye(len(rows)) / (effort.rounds * _PENALTY)
        left = soft @ np.linalg.solve((jacobian / self.layout.weights) @ jacobian.T + soft, alone[rows])
        tolerance = self.evaluation.problem.row_tolerance[rows]
        return bool(np.abs(left / tolerance).max() < _ALONE * np.abs(off[rows]).max())

    def _pressing(self, pull: FloatArray) -> BoolArray:
        return np.asarray(~self.evaluation.problem.info.inequality | (pull > 0.0))

    def _pressing_next(self, pressing: BoolArray, pull: FloatArray, linear: FloatArray) -> BoolArray:
        # Rows that rounding alone puts on the wrong side, as where an equality says the same, would come and go.
        entering = linear > _ENTERING * self.evaluation.problem.row_tolerance
        return np.asarray(~self.evaluation.problem.info.inequality | np.where(pressing, pull > 0.0, entering))

    def _one_sided(self, values: FloatArray) -> FloatArray:
        return np.where(self.evaluation.problem.info.inequality, np.maximum(values, 0.0), values)

    def _off(self, linear: FloatArray) -> FloatArray:
        """How far rows are from met, in tolerances."""
        return self._one_sided(linear) / self.evaluation.problem.row_tolerance

    def _factorize(self, pressing: BoolArray, share: float) -> tuple[Factors, float]:
        """Factor with as much of the second derivatives as leaves the form positive."""
        problem = self.evaluation.problem
        rows = RowSystem(
            frame=self.frame[pressing],
            jacobian=np.sqrt(_PENALTY) * self.evaluation.jacobian[pressing],
            place=problem.info.place[pressing],
            normal=np.sqrt(_PENALTY) * problem.info.normal[pressing],
        )
        bend_frames = problem.frames - self.layout.knots.first_frame
        while share > _LEAST_BEND:
            try:
                return factorize(self.layout, rows, bends=share * self.bends, bend_frames=bend_frames), share
            except ArithmeticError:
                share *= LESS_BEND
        return factorize(self.layout, rows), _LEAST_BEND

    def _slopes(self, multipliers: FloatArray, pressing: BoolArray) -> FloatArray:
        """Gradient of the augmented Lagrangian at the iterate by all unknowns."""
        info, layout = self.evaluation.problem.info, self.layout
        pull = np.where(pressing, multipliers + _PENALTY * self.evaluation.residual, 0.0)
        by_frame = np.zeros((layout.knots.frame_count, layout.channel_count))
        frames, starts = np.unique(self.frame, return_index=True)
        by_frame[frames] = np.add.reduceat(pull[:, None] * self.evaluation.jacobian, starts)
        by_place = np.zeros((len(layout.place_first), 3))
        held = info.place >= 0
        np.subtract.at(by_place, info.place[held], pull[held, None] * info.normal[held])
        return layout.join(self.gradient + layout.knots.matrix.T @ by_frame, by_place)
