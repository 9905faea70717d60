"""Places where the solver stands still and should not: saddles of the objective.

No small turn of the knee of a straight leg brings the ankle nearer to the hip: there the objective is level and bends
downward to both sides, as it does between two ways to bend that are equally good. The way down is along the direction
of the strongest negative curvature.
"""

import numpy as np
import numpy.typing as npt

__all__ = ["find_ridges"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

_LEVEL = 1e-6  # of what a change costs: what bends downward by less is level


def find_ridges(hessian: FloatArray, held: BoolArray) -> tuple[IntArray, FloatArray]:
    """Find the problems whose objective bends downward somewhere.

    Parameters
    ----------
    hessian
        Second derivatives, shape [F, C, C].
    held
        Which coordinates are at a bound and stay there, shape [F, C].

    Returns
    -------
    tuple of IntArray and FloatArray
        Which they are, length R, and the unit direction in which each bends downward most, shape [R, C].
    """
    # What is held bends upward, and apart from the rest.
    apart = held[:, :, None] | held[:, None, :]
    free = np.where(apart, np.eye(hessian.shape[1]), hessian)
    try:
        np.linalg.cholesky(free)
    except np.linalg.LinAlgError:
        curvatures, directions = np.linalg.eigh(free)
        ridges = np.flatnonzero(curvatures[:, 0] < -_LEVEL)
        return ridges, _orient(directions[ridges, :, 0])
    return np.zeros(0, dtype=np.intp), np.zeros((0, hessian.shape[1]))


def _orient(ways: FloatArray) -> FloatArray:
    """Give all directions [R, C] the sign that makes them point the same way, since an eigenvector has either."""
    if not len(ways):
        return ways
    common = np.linalg.eigh(ways.T @ ways)[1][:, -1]
    common *= np.sign(common[np.argmax(np.abs(common))])
    return np.asarray(np.where(ways @ common < 0.0, -1.0, 1.0)[:, None] * ways)
