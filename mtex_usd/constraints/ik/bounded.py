"""Quadratic problems with bounds, many small ones at once."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

__all__ = ["solve_bounded"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

_ROUNDS = 4  # times the number of unknowns
_PULL = 1e-12  # of the largest slope: a held unknown that is pulled inward by less stays


def solve_bounded(hessian: FloatArray, gradient: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Find the least of g·s + s·H s / 2 with lower <= s <= upper.

    Parameters
    ----------
    hessian
        Positive definite H, shape [F, C, C].
    gradient
        The slope g at zero, shape [F, C].
    lower, upper
        Bounds with zero between them, shape [F, C].

    Returns
    -------
    FloatArray
        The least's s, shape [F, C].

    Notes
    -----
    The primal active-set method (Nocedal and Wright 2006, section 16.5): go toward the least with what is held held;
    hold what runs into its bound on the way; at the least, let go what is pulled inward most; end where nothing is.
    """
    steps = np.linalg.solve(hessian, -gradient[..., None])[..., 0]
    outside = np.flatnonzero(((steps < lower) | (steps > upper)).any(axis=1))
    if outside.size:
        steps[outside] = _search(hessian[outside], gradient[outside], lower[outside], upper[outside])
    return np.asarray(steps)


@dataclass(eq=False, kw_only=True)
class _Problems:
    """Where each search stands."""

    steps: FloatArray
    held: BoolArray
    open: BoolArray


def _search(hessian: FloatArray, gradient: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    count, unknowns = gradient.shape
    locked = lower >= upper
    pushed = ((gradient > 0.0) & (lower >= 0.0)) | ((gradient < 0.0) & (upper <= 0.0))
    problems = _Problems(
        steps=np.clip(np.zeros(gradient.shape), lower, upper), held=locked | pushed, open=np.ones(count, dtype=np.bool_)
    )
    for _ in range(_ROUNDS * unknowns):
        which = np.flatnonzero(problems.open)
        if not which.size:
            break
        whole = _advance(problems, which, hessian, gradient, lower, upper)
        _let_go(problems, which[whole], hessian, gradient, upper, locked)
    return problems.steps


def _advance(
    problems: _Problems,
    which: IntArray,
    hessian: FloatArray,
    gradient: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
) -> BoolArray:
    """Go toward the least with what is held held, up to the first bound; whether that was the whole way, [W]."""
    steps, held = problems.steps[which], problems.held[which]
    matrix = np.where(held[..., None], np.eye(hessian.shape[1]), hessian[which])
    way = np.linalg.solve(matrix, np.where(held, steps, -gradient[which])[..., None])[..., 0] - steps
    way[held] = 0.0
    room = np.where(way > 0.0, upper[which], lower[which]) - steps
    shares = np.divide(room, way, out=np.full(way.shape, np.inf), where=way != 0.0)
    share = np.minimum(shares.min(axis=1), 1.0)
    blocked = (shares <= share[:, None]) & (share < 1.0)[:, None]
    moved = np.clip(steps + share[:, None] * way, lower[which], upper[which])
    # On the bound exactly, not beside it by rounding.
    bounds = np.where(way > 0.0, upper[which], lower[which])
    problems.steps[which] = np.where(blocked, bounds, moved)
    problems.held[which] = held | blocked
    return np.asarray(~blocked.any(axis=1))


def _let_go(
    problems: _Problems,
    which: IntArray,
    hessian: FloatArray,
    gradient: FloatArray,
    upper: FloatArray,
    locked: BoolArray,
) -> None:
    """Let go what is held and pulled inward most; where nothing is, the problem is solved."""
    slope = np.einsum("fij,fj->fi", hessian[which], problems.steps[which]) + gradient[which]
    at_upper = problems.steps[which] >= upper[which]
    pull = np.where(problems.held[which] & ~locked[which], np.where(at_upper, slope, -slope), -np.inf)
    strongest = np.argmax(pull, axis=1)
    wrong = pull[np.arange(len(which)), strongest] > _PULL * np.abs(slope).max(axis=1)
    problems.held[which[wrong], strongest[wrong]] = False
    problems.open[which[~wrong]] = False
