"""What is wanted of the pose, and how far from it a pose is."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.kinematics import Pose
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip

__all__ = ["Goal", "check_goals", "goal_errors"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False, kw_only=True)
class Goal:
    """A place, and maybe an orientation, for a point of the body.

    Parameters
    ----------
    joint
        Index of the joint the point belongs to.
    place
        Where the point is to be, skeleton space, skeleton units, shape [F, 3].
    offset
        The point in the joint's space, skeleton units, shape [3]; None for the joint itself.
    orientation
        How the joint is to be turned, skeleton space, real part first, shape [F, 4]; None where that is free.
    weight
        How much this goal counts beside others where not all can be reached, above 0.
    active
        At which frames it holds, shape [F]; None for all. What the goal says at other frames is not read.
    """

    joint: int
    place: FloatArray
    offset: FloatArray | None = None
    orientation: FloatArray | None = None
    weight: float = 1.0
    active: BoolArray | None = None

    @property
    def point(self) -> FloatArray:
        """The point in the joint's space, shape [3]."""
        return np.zeros(3) if self.offset is None else np.asarray(self.offset, dtype=np.float64)

    def is_active(self) -> BoolArray:
        """Give at which frames it holds, shape [F]."""
        return np.ones(len(self.place), dtype=np.bool_) if self.active is None else self.active

    def place_error(self, pose: Pose) -> FloatArray:
        """Give the way from where the point should be to where it is, skeleton units, shape [F, 3]; 0 while idle."""
        error = pose.place(self.joint, self.point) - self.place
        return np.where(self.is_active()[:, None], error, 0.0)

    def turn_error(self, pose: Pose) -> FloatArray:
        """Give the turn in skeleton space from the orientation wanted to the one there is, [F, 3]; 0 while idle."""
        if self.orientation is None:
            return np.zeros((len(self.place), 3))
        turn = quaternion.multiply(pose.orientations[:, self.joint], quaternion.conjugate(self.orientation))
        return np.where(self.is_active()[:, None], quaternion.log(turn), 0.0)

    def at_frames(self, frames: npt.NDArray[np.intp]) -> "Goal":
        """Give the same goal for some of the frames."""
        return Goal(
            joint=self.joint,
            place=self.place[frames],
            offset=self.offset,
            orientation=None if self.orientation is None else self.orientation[frames],
            weight=self.weight,
            active=None if self.active is None else self.active[frames],
        )


def goal_errors(goals: Sequence[Goal], pose: Pose) -> tuple[FloatArray, FloatArray]:
    """Measure how far a pose is from its goals.

    Parameters
    ----------
    goals
        The goals, G of them.
    pose
        Of all frames.

    Returns
    -------
    tuple of FloatArray
        Distances in skeleton units and angles in radians, both [F, G]; 0 where a goal is idle or wants none.
    """
    distances = [np.linalg.norm(goal.place_error(pose), axis=-1) for goal in goals]
    angles = [np.linalg.norm(goal.turn_error(pose), axis=-1) for goal in goals]
    return np.stack(distances, axis=1), np.stack(angles, axis=1)


def check_goals(clip: Clip, goals: Sequence[Goal]) -> None:
    """Make sure that goals fit a clip.

    Raises
    ------
    InputError
        Where there are none, a joint or shape does not fit, a number is not finite, or a weight is not positive.
    """
    if not goals:
        raise InputError("inverse kinematics without goals", expected="at least one")
    for number, goal in enumerate(goals):
        name = f"goal {number}"
        if not 0 <= goal.joint < len(clip.joints):
            raise InputError(f"{name}: no such joint", expected=f"0 to {len(clip.joints) - 1}", found=str(goal.joint))
        if not (np.isfinite(goal.weight) and goal.weight > 0.0):
            raise InputError(f"{name}: bad weight", expected="a finite number above 0", found=f"{goal.weight:g}")
        _check_shape(name, "offset", goal.point, (3,))
        _check_shape(name, "active", goal.is_active(), (clip.frame_count,))
        _check_curve(name, "place", goal.place, (clip.frame_count, 3), goal)
        if goal.orientation is not None:
            _check_curve(name, "orientation", goal.orientation, (clip.frame_count, 4), goal)


def _check_shape(name: str, what: str, values: npt.NDArray[np.generic], shape: tuple[int, ...]) -> None:
    if values.shape != shape:
        raise InputError(f"{name}: {what} does not fit", expected=f"shape {shape}", found=str(values.shape))


def _check_curve(name: str, what: str, values: FloatArray, shape: tuple[int, int], goal: Goal) -> None:
    _check_shape(name, what, values, shape)
    bad = np.flatnonzero(goal.is_active() & ~np.isfinite(values).all(axis=1))
    if bad.size:
        raise InputError(f"{name}: {what} is not finite", found=f"{values[bad[0]]} at frame {bad[0]}")
    if what == "orientation":
        lengths = np.linalg.norm(values[goal.is_active()], axis=1)
        if not np.allclose(lengths, 1.0, atol=1e-6):
            raise InputError(f"{name}: orientations are not unit quaternions", found=f"length {lengths.min():g}")
