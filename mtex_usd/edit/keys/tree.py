"""Joints by depth, so that all joints of one depth can be computed at once, and sums over what joints carry."""

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["add_up", "find_carried", "list_levels"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]


def list_levels(parents: IntArray) -> list[tuple[IntArray, IntArray]]:
    """List the joints that have a parent, with their parents, by depth.

    Parameters
    ----------
    parents
        Parent by joint, -1 for a root, a parent before its children, shape [J].
    """
    return _list_levels(tuple(parents.tolist()))


@lru_cache(maxsize=8)
def _list_levels(parents: tuple[int, ...]) -> list[tuple[IntArray, IntArray]]:
    depths = np.zeros(len(parents), dtype=np.intp)
    for joint, parent in enumerate(parents):
        depths[joint] = depths[parent] + 1 if parent >= 0 else 0
    of_depth = [np.flatnonzero(depths == depth) for depth in range(1, int(depths.max()) + 1)]
    return [(joints, np.array(parents, dtype=np.intp)[joints]) for joints in of_depth]


def find_carried(parents: IntArray, precision: type[np.float32 | np.float64]) -> "csr_array":
    """Tell which joints (rows) are carried along by which (columns), themselves included, 1 or 0, shape [J, J].

    Parameters
    ----------
    parents
        Parent by joint, as :func:`list_levels` takes them.
    precision
        Type of the result.
    """
    from scipy.sparse import csr_array  # noqa: PLC0415  (slow to import, seldom used)

    carried: FloatArray = np.eye(len(parents), dtype=precision)
    for joints, above in list_levels(parents):
        carried[joints] += carried[above]
    # Sparse not for space: a dense product would start threads, which cost more than so small a sum.
    return csr_array(carried)


def add_up(weights: "csr_array", *parts: FloatArray) -> list[FloatArray]:
    """Give weighted sums over joints.

    Parameters
    ----------
    weights
        Shape [J, J].
    parts
        What is summed up, each [J, ...].
    """
    return [(weights @ part.reshape(len(part), -1)).reshape(part.shape) for part in parts]
