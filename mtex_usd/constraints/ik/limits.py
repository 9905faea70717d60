"""Joint limits: how far each joint may turn about three axes of its own.

A joint's turn is read as for channels, relative to rest and in skeleton axes, D = W (R_rest^-1 R) W^-1, and taken apart
into three turns about given axes, D = T(axis 0, a0) T(axis 1, a1) T(axis 2, a2) with column vectors, so the last is
applied first. Each angle has a range. The axes are those of the file the limits come from (an ASF bone has its own,
fixed in skeleton space at rest), the same as the skeleton's where nothing else is said.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.ik.turns import turn_about
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["JointAngles", "JointLimits", "make_joint_limits"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

_SQUARE = 1e-6  # how far from perpendicular unit vectors the axes may be


@dataclass(frozen=True, eq=False, kw_only=True)
class JointLimits:
    """Ranges of all joints of a skeleton.

    Parameters
    ----------
    axes
        Unit vectors in skeleton space at rest, perpendicular to each other; ``axes[j, k]`` is the axis of joint j's
        turn k, the one applied last first; shape [J, 3, 3]. A left-handed triple is allowed: any order of three axes.
    lower, upper
        Range of each angle in degrees, shape [J, 3]; infinite where free. An angle whose range is one value is locked.

    Raises
    ------
    InputError
        Where shapes do not fit, axes are not perpendicular unit vectors, or a range is empty.
    """

    axes: FloatArray
    lower: FloatArray
    upper: FloatArray

    def __post_init__(self) -> None:
        """Check shapes, axes and ranges."""
        count = len(self.axes)
        shapes = (self.axes.shape, self.lower.shape, self.upper.shape)
        expected = ((count, 3, 3), (count, 3), (count, 3))
        if shapes != expected:
            raise InputError("joint limits: shapes do not fit", expected=str(expected), found=str(shapes))
        if not np.allclose(self.axes @ np.swapaxes(self.axes, 1, 2), np.eye(3), atol=_SQUARE):
            raise InputError("joint limits: bad axes", expected="unit vectors perpendicular to each other")
        empty = np.argwhere(~(self.lower <= self.upper))
        if empty.size:
            joint, turn = (int(i) for i in empty[0])
            found = f"{self.lower[joint, turn]:g} to {self.upper[joint, turn]:g} degrees at joint {joint}, turn {turn}"
            raise InputError("joint limits: empty range", expected="lower <= upper", found=found)

    @property
    def limited(self) -> BoolArray:
        """Whether each joint has any limit, shape [J]."""
        return np.asarray((np.isfinite(self.lower) | np.isfinite(self.upper)).any(axis=1))

    def for_joints(self, joints: npt.NDArray[np.intp]) -> "JointLimits":
        """Give the limits of some of the joints."""
        return JointLimits(axes=self.axes[joints], lower=self.lower[joints], upper=self.upper[joints])

    def measure(self, skeleton: Skeleton, rotations: FloatArray) -> FloatArray:
        """Take rotations apart into the angles that are limited.

        Parameters
        ----------
        skeleton
            The skeleton the limits are for.
        rotations
            Relative to the parent, shape [F, J, 4].

        Returns
        -------
        FloatArray
            Degrees, shape [F, J, 3]; of the ways to write a rotation the one that breaks its limits least.
        """
        joints = np.arange(len(self.axes))
        return np.degrees(JointAngles(skeleton, self, joints).measure(rotations))

    def excess(self, skeleton: Skeleton, rotations: FloatArray) -> FloatArray:
        """Give by how many degrees each angle is outside its range, 0 inside; [F, J, 4] to [F, J, 3]."""
        angles = self.measure(skeleton, rotations)
        return np.maximum(np.maximum(self.lower - angles, angles - self.upper), 0.0)


def make_joint_limits(
    skeleton: Skeleton,
    ranges: Mapping[tuple[int, str], tuple[float, float]],
    *,
    orientations: FloatArray | None = None,
    order: str = "ZYX",
) -> JointLimits:
    """Build limits from ranges of channels.

    Parameters
    ----------
    skeleton
        The skeleton.
    ranges
        Lower and upper limit in degrees by joint index and channel ``"rx"``, ``"ry"`` or ``"rz"``; what is not listed
        is free. An axis that may not turn has a range of one value.
    orientations
        Orientation in skeleton space of the axes x, y and z of each joint, real part first, shape [J, 4]; the
        skeleton's own axes where None.
    order
        The turns from the one applied last to the one applied first; ``"ZYX"`` is that of an ASF file whose bones list
        ``rx ry rz``.

    Returns
    -------
    JointLimits
        Of all joints.

    Raises
    ------
    InputError
        An order that is none, an unknown channel or joint, or an empty range.
    """
    if sorted(order) != ["X", "Y", "Z"]:
        raise InputError("joint limits: bad order", expected="X, Y and Z in some order", found=order)
    count = len(skeleton.joints)
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)) if orientations is None else orientations
    axes = quaternion.rotate(turns[:, None], np.eye(3)[["XYZ".index(axis) for axis in order]])
    lower, upper = np.full((count, 3), -np.inf), np.full((count, 3), np.inf)
    for (joint, channel), (low, high) in ranges.items():
        if channel not in ("rx", "ry", "rz") or not 0 <= joint < count:
            expected = f"rx, ry or rz of one of {count} joints"
            raise InputError("joint limits: unknown channel", expected=expected, found=f"{channel} of joint {joint}")
        turn = order.index(channel[1].upper())
        lower[joint, turn], upper[joint, turn] = low, high
    return JointLimits(axes=axes, lower=lower, upper=upper)


class JointAngles:
    """Turns of some joints as three angles each, and back.

    Parameters
    ----------
    skeleton
        The skeleton.
    limits
        Their axes and ranges.
    joints
        The joints, length N.
    """

    def __init__(self, skeleton: Skeleton, limits: JointLimits, joints: npt.NDArray[np.intp]) -> None:
        axes = np.array(limits.axes[joints])
        flip = np.linalg.det(axes) < 0.0
        # A turn about the opposite axis is the opposite turn, and makes a left-handed triple right-handed.
        axes[flip, 2] *= -1.0
        self.lower, self.upper = np.radians(limits.lower[joints]), np.radians(limits.upper[joints])
        self.flip = flip
        lower, upper = self.lower[flip, 2].copy(), self.upper[flip, 2].copy()
        self.lower[flip, 2], self.upper[flip, 2] = -upper, -lower
        frame = quaternion.from_usd_matrix(_as_rows(axes))
        # The frame of the axes as the joint has it in its own space at rest: W^-1 A.
        own = quaternion.multiply(quaternion.conjugate(skeleton.rest_orientations[joints]), frame)
        self.before = quaternion.multiply(skeleton.rest_rotations[joints], own)
        self.after = quaternion.conjugate(own)
        self.joints = joints

    def measure(self, rotations: FloatArray) -> FloatArray:
        """Give angles in radians, signs as in the limits given, [F, J, 4] of all joints to [F, N, 3]."""
        angles = self.from_rotations(rotations[:, self.joints])
        angles[:, self.flip, 2] *= -1.0
        return angles

    def from_rotations(self, rotations: FloatArray) -> FloatArray:
        """Give angles in radians about the right-handed axes, [F, N, 4] to [F, N, 3]."""
        relative = quaternion.multiply(
            quaternion.multiply(quaternion.conjugate(self.before), rotations), quaternion.conjugate(self.after)
        )
        first = np.radians(quaternion.to_euler(relative, "XYZ"))
        other = np.stack([first[..., 0] + np.pi, np.pi - first[..., 1], first[..., 2] + np.pi], axis=-1)
        first, other = self._wrap(first), self._wrap(other)
        better = self._excess(other) < self._excess(first)
        return np.where(better[..., None], other, first)

    def to_rotations(self, angles: FloatArray) -> FloatArray:
        """Invert :meth:`from_rotations`, [F, N, 3] to [F, N, 4]."""
        turns = [turn_about(axis, angles[..., k]) for k, axis in enumerate(np.eye(3))]
        turn = quaternion.multiply(quaternion.multiply(turns[0], turns[1]), turns[2])
        return quaternion.multiply(quaternion.multiply(self.before, turn), self.after)

    def axes_in_parent(self, angles: FloatArray) -> FloatArray:
        """Give the axes that the angles turn about at a pose, in the parent's frame, rows of [F, N, 3, 3]."""
        x, y, z = np.eye(3)
        first = turn_about(x, angles[..., 0])
        second = quaternion.multiply(first, turn_about(y, angles[..., 1]))
        axes = [np.broadcast_to(x, angles.shape), quaternion.rotate(first, y), quaternion.rotate(second, z)]
        return quaternion.rotate(self.before[:, None], np.stack(axes, axis=-2))

    def _wrap(self, angles: FloatArray) -> FloatArray:
        """Choose the turn nearest to the middle of the range, or to none where a side is open."""
        with np.errstate(invalid="ignore"):
            middle = 0.5 * (self.lower + self.upper)
        middle = np.where(np.isfinite(middle), middle, 0.0)
        return np.asarray(angles - 2.0 * np.pi * np.round((angles - middle) / (2.0 * np.pi)))

    def _excess(self, angles: FloatArray) -> FloatArray:
        return np.asarray(np.maximum(np.maximum(self.lower - angles, angles - self.upper), 0.0).sum(axis=-1))


def _as_rows(axes: FloatArray) -> FloatArray:
    """Put turned axes as rows into USD matrices, [N, 3, 3] to [N, 4, 4]."""
    matrices = np.tile(np.eye(4), (len(axes), 1, 1))
    matrices[:, :3, :3] = axes
    return matrices
