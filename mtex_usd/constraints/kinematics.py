"""Where points of the body are, and how they move when joints turn."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.motion import quaternion
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["Pose", "place_points", "pose_skeleton", "turn_columns"]

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class Pose:
    """All joints in skeleton space.

    Parameters
    ----------
    positions
        Joint positions, skeleton units, shape [F, J, 3].
    orientations
        Joint rotations, real part first, shape [F, J, 4].
    """

    positions: FloatArray
    orientations: FloatArray

    def place(self, joint: int, offset: FloatArray) -> FloatArray:
        """Give where a point of a joint is, skeleton space, shape [F, 3]; its offset [3] is in the joint's space."""
        return self.positions[:, joint] + quaternion.rotate(self.orientations[:, joint], offset)


def pose_skeleton(skeleton: Skeleton, rotations: FloatArray, translations: FloatArray) -> Pose:
    """Place all joints; rotations [F, J, 4] and translations [F, J, 3] are relative to the parent."""
    positions, orientations = skeleton.world_pose(rotations, translations)
    return Pose(positions=positions, orientations=orientations)


def place_points(
    skeleton: Skeleton,
    joints: Sequence[int],
    offsets: FloatArray,
    rotations: FloatArray,
    translations: FloatArray,
) -> FloatArray:
    """Give where some points of the body are.

    Parameters
    ----------
    skeleton
        The skeleton.
    joints
        The joint each point belongs to, length N.
    offsets
        The points in their joint's space, skeleton units, shape [N, 3].
    rotations, translations
        Of all joints, relative to the parent, shapes [F, J, 4] and [F, J, 3].

    Returns
    -------
    FloatArray
        Skeleton space, shape [F, N, 3].
    """
    positions, orientations = skeleton.world_pose(rotations, translations)
    return positions[:, list(joints)] + quaternion.rotate(orientations[:, list(joints)], offsets)


def turn_columns(axes: FloatArray, pivots: FloatArray, points: FloatArray) -> FloatArray:
    """Give how points move per radian of turns about axes.

    Parameters
    ----------
    axes
        Unit axes in skeleton space, shape [..., N, 3].
    pivots
        A point of each axis, skeleton units, shape [..., N, 3].
    points
        The points that are turned, shape [..., 3].

    Returns
    -------
    FloatArray
        Skeleton units per radian, shape [..., 3, N]: the point's Jacobian.
    """
    return np.swapaxes(np.cross(axes, points[..., None, :] - pivots), -1, -2)
