"""Joints by depth, so that all joints of one depth can be computed at once."""

import numpy as np
import numpy.typing as npt

__all__ = ["list_levels"]

IntArray = npt.NDArray[np.intp]


def list_levels(parents: IntArray) -> list[tuple[IntArray, IntArray]]:
    """List the joints that have a parent, with their parents, by depth.

    Parameters
    ----------
    parents
        Parent by joint, -1 for a root, a parent before its children, shape [J].
    """
    depths = np.zeros(len(parents), dtype=np.intp)
    for joint, parent in enumerate(parents.tolist()):
        depths[joint] = depths[parent] + 1 if parent >= 0 else 0
    of_depth = [np.flatnonzero(depths == depth) for depth in range(1, int(depths.max()) + 1)]
    return [(joints, parents[joints]) for joints in of_depth]
