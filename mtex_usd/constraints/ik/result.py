"""What inverse kinematics gives back."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.ik.goals import Goal, goal_errors
from mtex_usd.constraints.kinematics import pose_skeleton
from mtex_usd.motion.clip import Clip

__all__ = ["IkResult", "make_result"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False, kw_only=True)
class IkResult:
    """The motion and how far it stays from its goals.

    Parameters
    ----------
    clip
        The motion; joints that were not to move are the input's, bit for bit.
    distances_m
        From each point to its goal, metres, shape [F, G]; 0 where the goal is idle.
    angles
        From each joint's orientation to the one wanted, degrees, shape [F, G]; 0 where none is wanted.
    reached
        Frames at which every goal is met within the tolerance, shape [F].
    """

    clip: Clip
    distances_m: FloatArray
    angles: FloatArray
    reached: BoolArray


def make_result(clip: Clip, goals: Sequence[Goal], tolerance_m: float, tolerance_deg: float) -> IkResult:
    """Measure a solved clip against its goals."""
    pose = pose_skeleton(clip.skeleton, clip.rotations, clip.translations)
    distances, angles = goal_errors(goals, pose)
    metres, degrees = distances * clip.skeleton.meters_per_unit, np.degrees(angles)
    reached = ((metres <= tolerance_m) & (degrees <= tolerance_deg)).all(axis=1)
    return IkResult(clip=clip, distances_m=metres, angles=degrees, reached=np.asarray(reached))
