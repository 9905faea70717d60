"""Joint limits that a solve keeps: how far joints may turn, but no narrower than the motion itself turns them."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.spacetime import RotationRange
from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import to_skeleton_rotations
from mtex_usd.motion.clip import Clip

__all__ = ["JointRange", "to_ranges"]

FloatArray = npt.NDArray[np.float64]

# That of Acclaim files, whose limits these mostly are: x is applied first.
_ORDER = "ZYX"


@dataclass(frozen=True, eq=False, kw_only=True)
class JointRange:
    """How far one joint may turn, relative to rest.

    Parameters
    ----------
    joint
        Index of the joint.
    axes
        Orientation, in skeleton space and at rest, of the axes the angles are about, real first, shape [4].
    lower, upper
        Degrees about x, y and z, shape [3]; infinite where free.
    """

    joint: int
    axes: FloatArray
    lower: FloatArray
    upper: FloatArray


def to_ranges(clip: Clip, limits: Sequence[JointRange], joints: Collection[int]) -> tuple[RotationRange, ...]:
    """Give the constraints that keep joints within their limits.

    Parameters
    ----------
    clip
        The motion. Where it breaks a limit itself, as captures do, it may go on to do so, but no farther.
    limits
        Of any joints.
    joints
        Those that are going to be turned.
    """
    turns = to_skeleton_rotations(clip.rotations, clip.skeleton)
    return tuple(_to_range(clip, limit, turns[:, limit.joint]) for limit in limits if limit.joint in joints)


def _to_range(clip: Clip, limit: JointRange, turns: FloatArray) -> RotationRange:
    own = quaternion.multiply(quaternion.multiply(quaternion.conjugate(limit.axes), turns), limit.axes)
    angles = quaternion.to_euler(own, _ORDER)
    return RotationRange(
        f"limits of {clip.joints[limit.joint].rpartition('/')[2]}",
        clip.joints[limit.joint],
        np.arange(clip.frame_count),
        np.minimum(limit.lower, angles.min(axis=0)),
        np.maximum(limit.upper, angles.max(axis=0)),
        order=_ORDER,
        axes=limit.axes,
    )
