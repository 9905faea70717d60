"""Damped steps toward the least of many small problems at once, one per frame, within bounds.

Levenberg's method: a step of the model with damping added, taken if the objective falls, else tried again with more.
With goals hard at once, every step would follow them blindly wherever the pose is free; so they begin soft and are
hardened in stages (an augmented Lagrangian), which leads along poses that each change least for what they reach.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.ik.bounded import solve_bounded
from mtex_usd.constraints.ik.objective import Aim, Model, Objective
from mtex_usd.constraints.ik.ridges import find_ridges

__all__ = ["HARDEST", "minimize"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

HARDEST = 1e-3  # softness in the end: what a goal is missed by that cannot be reached is then the least but for 1e-6
_HARDEN = 0.2  # what the softness is multiplied by from one stage to the next
_NEAR = 1e-3  # radians: after a shorter step the next stage begins
_LARGEST_STEP = 0.5  # radians
_DONE = 1e-8  # radians: the last step is shorter
_LEVEL = 1e-14  # of the objective: a smaller fall is rounding
_FIRST_DAMPING = 1.0  # as if changes cost twice as much
_LESS, _MORE = 0.2, 8.0
_KEPT = 0.5  # of what the model promised
_LEAST_DAMPING = 1e-3
_STAGE_ROUNDS = 25  # after so many a stage need not settle before the next begins
_PUSH = 0.1  # radians: off a ridge
_MOST_PUSHES = 3
_WARM = 0.03  # softness at which a frame that was pushed goes on
_SAME = 1e-6  # of the objective


@dataclass(eq=False, kw_only=True)
class _Search:
    """Where every frame of the search stands; arrays over all its frames."""

    objective: Objective
    frames: IntArray
    lower: FloatArray
    upper: FloatArray
    values: FloatArray
    softness: FloatArray
    shift: FloatArray
    damping: FloatArray
    pushes: IntArray
    tries: IntArray
    open: BoolArray

    def advance(self) -> None:
        """Try one step of every frame that is not done."""
        which = np.flatnonzero(self.open)
        values, frames, aim = self.values[which], self.frames[which], self._aim(which)
        model = self.objective.model(values, frames, aim)
        steps, promised = self._find_steps(model, which)
        tried = np.clip(self.objective.coordinates.step(values, steps), self.lower[which], self.upper[which])
        fall = model.value - self.objective.value(tried, frames, aim)
        better = fall > 0.0
        self.values[which[better]] = tried[better]
        self._adapt_damping(which, fall, promised)
        size, level = np.abs(steps).max(axis=(1, 2)), np.abs(promised) <= _LEVEL * model.value
        hardest = aim.softness <= HARDEST
        self.tries[which] += 1
        near = np.where(hardest, size < _DONE, (better & (size < _NEAR)) | (self.tries[which] >= _STAGE_ROUNDS))
        settled = which[near | level]
        settled = np.setdiff1d(settled, self._leave_ridges(settled))
        self.open[settled[self.softness[settled] <= HARDEST]] = False
        self._change_softness(settled, np.maximum(self.softness[settled] * _HARDEN, HARDEST))

    def _aim(self, which: IntArray) -> Aim:
        return Aim(softness=self.softness[which], shift=self.shift[which])

    def _find_steps(self, model: Model, which: IntArray) -> tuple[FloatArray, FloatArray]:
        """Give steps [F, N, 3] within the bounds, and by how much the model says the objective falls, [F]."""
        values = self.values[which]
        flat = (len(values), -1)
        lower, upper = ((bound[which] - values).reshape(flat) for bound in (self.lower, self.upper))
        damping = self.damping[which][:, None, None] * np.eye(model.hessian.shape[1])
        hessian = model.hessian + damping
        steps = _bounded_steps(hessian, model.gradient, lower, upper)
        promised = _promise(hessian, model.gradient, steps)
        uphill = np.flatnonzero(promised <= 0.0)
        if uphill.size:
            upward = _bend_upward(model.hessian[uphill]) + damping[uphill]
            steps[uphill] = _bounded_steps(upward, model.gradient[uphill], lower[uphill], upper[uphill])
            promised[uphill] = _promise(upward, model.gradient[uphill], steps[uphill])
        return steps.reshape(values.shape), promised

    def _adapt_damping(self, which: IntArray, fall: FloatArray, promised: FloatArray) -> None:
        """Damp more after a step that failed, less after one that did what the model said."""
        damping = self.damping[which]
        eased = np.where(fall > _KEPT * promised, damping * _LESS, damping)
        damping = np.where(fall > 0.0, eased, np.maximum(damping * _MORE, _FIRST_DAMPING))
        self.damping[which] = np.where(damping < _LEAST_DAMPING, 0.0, damping)

    def _change_softness(self, which: IntArray, softness: FloatArray) -> None:
        """Begin the next stage of some frames."""
        if which.size:
            errors = self.objective.errors(self.values[which], self.frames[which])
            aim = self._aim(which).harden(errors, softness)
            self.softness[which], self.shift[which], self.tries[which] = aim.softness, aim.shift, 0

    def _leave_ridges(self, which: IntArray) -> IntArray:
        """Push those of some frames that stand on a ridge off it, to the lower side; which they were."""
        which = which[self.pushes[which] < _MOST_PUSHES]
        if not which.size:
            return which
        values, frames, aim = self.values[which], self.frames[which], self._aim(which)
        held = ((values <= self.lower[which]) | (values >= self.upper[which])).reshape(len(which), -1)
        ridges, ways = find_ridges(self.objective.model(values, frames, aim).hessian, held)
        which = which[ridges]
        self.pushes[which] += 1
        # Hard goals leave a narrow valley, in which no push gets far.
        self._change_softness(which, np.maximum(self.softness[which], _WARM))
        self.values[which] = self._lower_side(which, _PUSH * ways.reshape(-1, *values.shape[1:]))
        self.damping[which] = 0.0
        return which

    def _lower_side(self, which: IntArray, push: FloatArray) -> FloatArray:
        sides, heights = [], []
        for side in (push, -push):
            moved = self.objective.coordinates.step(self.values[which], side)
            sides.append(np.clip(moved, self.lower[which], self.upper[which]))
            heights.append(self.objective.value(sides[-1], self.frames[which], self._aim(which)))
        # Sides as good as each other must not alternate from frame to frame by rounding.
        other = heights[1] < heights[0] * (1.0 - _SAME)
        return np.where(other[:, None, None], sides[1], sides[0])


def minimize(
    objective: Objective, values: FloatArray, frames: IntArray, *, rounds: int, softness: float | None = None
) -> FloatArray:
    """Find the least change that meets the goals, near some values.

    Parameters
    ----------
    objective
        What to make small.
    values
        Where to begin, shape [F, N, 3].
    frames
        Which frames of the clip these are, shape [F].
    rounds
        How many steps are tried at most.
    softness
        What to begin with; the smaller, the nearer the search stays to where it begins. By the errors where None.

    Returns
    -------
    FloatArray
        Values within the bounds, shape [F, N, 3].
    """
    lower, upper = objective.coordinates.bounds(frames)
    values = np.clip(values, lower, upper)
    errors = objective.errors(values, frames)
    by_error = np.sqrt(np.linalg.norm(errors, axis=2).max(axis=1))
    search = _Search(
        objective=objective,
        frames=frames,
        lower=lower,
        upper=upper,
        values=values,
        softness=np.clip(by_error if softness is None else np.full(len(frames), softness), HARDEST, 1.0),
        shift=np.zeros(errors.shape),
        damping=np.zeros(len(frames)),
        pushes=np.zeros(len(frames), dtype=np.intp),
        tries=np.zeros(len(frames), dtype=np.intp),
        open=np.ones(len(frames), dtype=np.bool_),
    )
    for _ in range(rounds):
        if not search.open.any():
            break
        search.advance()
    return search.values


def _bend_upward(hessian: FloatArray) -> FloatArray:
    """Turn negative curvatures round, so that a step leads down from a ridge instead of up to it."""
    curvatures, directions = np.linalg.eigh(hessian)
    steep = np.maximum(np.abs(curvatures), 1e-12 * np.abs(curvatures).max(axis=1, keepdims=True))
    return np.asarray((directions * steep[:, None, :]) @ np.swapaxes(directions, 1, 2))


def _bounded_steps(hessian: FloatArray, gradient: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    steps = solve_bounded(hessian, gradient, lower, upper)
    longest = np.abs(steps).max(axis=1, keepdims=True)
    return np.asarray(steps * (_LARGEST_STEP / np.maximum(longest, _LARGEST_STEP)))


def _promise(hessian: FloatArray, gradient: FloatArray, steps: FloatArray) -> FloatArray:
    """Give by how much the model falls, [F]."""
    bent = np.einsum("fij,fj->fi", hessian, steps)
    return np.asarray(-np.einsum("fi,fi->f", steps, gradient + 0.5 * bent))
