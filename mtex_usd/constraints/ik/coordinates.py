"""The coordinates the solver works in: how far each joint is turned from the given pose.

A joint without limits has three coordinates, the rotation vector of its turn away from the given pose in its parent's
frame. A joint with limits has the changes of its three angles, so that a limit is a bound of one coordinate, and a
locked axis a coordinate that stays put. Arrays are [F, N, 3] over frames and the joints that may move.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.ik.limits import JointAngles, JointLimits
from mtex_usd.constraints.ik.turns import inverse_left_jacobian, square_curvature
from mtex_usd.constraints.kinematics import Pose
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip

__all__ = ["Coordinates"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]


@dataclass(frozen=True, eq=False, kw_only=True)
class Coordinates:
    """Coordinates of some joints at some frames.

    Parameters
    ----------
    clip
        The given poses.
    joints
        The joints that may move, ascending, length N.
    limited
        Which of them have limits, shape [N].
    angles
        Their limits; of the limited ones only.
    start
        Angles of the limited joints at the given poses, radians, shape [F, L, 3].
    """

    clip: Clip
    joints: IntArray
    limited: BoolArray
    angles: JointAngles | None
    start: FloatArray

    @classmethod
    def of(cls, clip: Clip, joints: IntArray, limits: JointLimits | None) -> "Coordinates":
        """Choose coordinates for joints of a clip."""
        limited = np.zeros(len(joints), dtype=np.bool_) if limits is None else limits.limited[joints]
        angles = None
        start = np.zeros((clip.frame_count, 0, 3))
        if limits is not None and limited.any():
            angles = JointAngles(clip.skeleton, limits, joints[limited])
            start = angles.from_rotations(clip.rotations[:, joints[limited]])
        return cls(clip=clip, joints=joints, limited=limited, angles=angles, start=start)

    def bounds(self, frames: IntArray) -> tuple[FloatArray, FloatArray]:
        """Give the least and the largest value of every coordinate, both [F, N, 3]."""
        shape = (len(frames), len(self.joints), 3)
        lower, upper = np.full(shape, -np.inf), np.full(shape, np.inf)
        if self.angles is not None:
            lower[:, self.limited] = self.angles.lower - self.start[frames]
            upper[:, self.limited] = self.angles.upper - self.start[frames]
        return lower, upper

    def rotations(self, values: FloatArray, frames: IntArray) -> FloatArray:
        """Give the joints' rotations relative to their parents, [F, N, 3] to [F, N, 4]."""
        turns = quaternion.exp(values)
        out = quaternion.multiply(turns, self.clip.rotations[np.ix_(frames, self.joints)])
        if self.angles is not None:
            out[:, self.limited] = self.angles.to_rotations(self.start[frames] + values[:, self.limited])
        return out

    def axes(self, values: FloatArray, frames: IntArray, pose: Pose) -> FloatArray:
        """Give the axes in skeleton space that a small step of each coordinate turns about, rows of [F, N, 3, 3]."""
        local = np.tile(np.eye(3), (len(frames), len(self.joints), 1, 1))
        if self.angles is not None:
            local[:, self.limited] = self.angles.axes_in_parent(self.start[frames] + values[:, self.limited])
        parents = self.clip.parents[self.joints]
        frame = np.where((parents >= 0)[:, None], pose.orientations[:, parents], np.array([1.0, 0.0, 0.0, 0.0]))
        return quaternion.rotate(frame[:, :, None], local)

    def step(self, values: FloatArray, steps: FloatArray) -> FloatArray:
        """Add steps along :meth:`axes` to values, both [F, N, 3]."""
        free = ~self.limited
        out = values + steps
        turned = quaternion.multiply(quaternion.exp(steps[:, free]), quaternion.exp(values[:, free]))
        out[:, free] = quaternion.log(turned)
        return out

    def curvature(self, values: FloatArray) -> FloatArray:
        """Give the second derivative of |value|^2 / 2 by steps, [F, N, 3] to [F, N, 3, 3]; the first is the value."""
        out = np.tile(np.eye(3), (*values.shape[:2], 1, 1))
        out[:, ~self.limited] = square_curvature(values[:, ~self.limited])
        return out

    def change(self, values: FloatArray) -> FloatArray:
        """Give how values change per step, [F, N, 3] to [F, N, 3, 3]."""
        out = np.tile(np.eye(3), (*values.shape[:2], 1, 1))
        out[:, ~self.limited] = inverse_left_jacobian(values[:, ~self.limited])
        return out
