"""What makes poses alike or not, whatever way the characters face and wherever they are.

Joint positions from the root, in the facing frame, in metres of an average adult: neither units nor size change what is
found. Joints beyond wrists and ankles are left out: on captures they carry nothing, or noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.cleaning.limbs import body_size, captured_joints
from mtex_usd.edit.root import RootMotion, read_root
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.arguments import as_clip
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.correspondence import corresponding_joints
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["Joints", "check_pair", "common_joints", "metres_per_unit", "pose_positions"]

FloatArray = npt.NDArray[np.float64]

_ADULT_M = 1.7


@dataclass(frozen=True)
class Joints:
    """The joints two motions are compared by: indices in the one and in the other, of the same length."""

    of_clip: tuple[int, ...]
    of_other: tuple[int, ...]


def metres_per_unit(skeleton: Skeleton) -> float:
    """Give the length of a skeleton unit where the body is that of an average adult."""
    return _ADULT_M / (body_size(skeleton) or _ADULT_M)


def common_joints(clip: Clip, other: Clip) -> Joints:
    """Find the joints to compare two motions by: those that both have, less what is beyond wrists and ankles.

    Parameters
    ----------
    clip, other
        The motions; joints correspond by path, or by last name where that is unique.

    Raises
    ------
    InputError
        Where they have no joint in common.
    """
    there = corresponding_joints(other.joints, clip.joints)
    if not there:
        raise InputError(
            f"{clip.name or 'the clip'} and {other.name or 'the other'} have no joint in common",
            expected=", ".join(clip.joints[:6]),
            found=", ".join(other.joints[:6]),
            fix="Retarget one to the other's skeleton first.",
        )
    moving = set(captured_joints(clip)) | {here for here in there if there[here] in captured_joints(other)}
    chosen = [joint for joint in there if joint in moving] or list(there)
    return Joints(tuple(chosen), tuple(there[joint] for joint in chosen))


def pose_positions(clip: Clip, joints: Sequence[int], *, root: RootMotion | None = None) -> FloatArray:
    """Place joints from the root, in the facing frame.

    Parameters
    ----------
    clip
        The motion.
    joints
        Indices, length N.
    root
        How the root moves, where that is known.

    Returns
    -------
    FloatArray
        Metres of an average adult, shape [F, N, 3].
    """
    moving = read_root(clip) if root is None else root
    positions = clip.skeleton.joint_positions(joints, clip.rotations, clip.translations)
    from_root = positions - moving.positions[:, None]
    back = quaternion.exp(-moving.facing.heading[:, None] * clip.skeleton.up)
    return quaternion.rotate(back[:, None], from_root) * metres_per_unit(clip.skeleton)


def check_pair(clip: Clip, other: Clip) -> None:
    """Refuse what is no motion, and two that are not at one rate or too short to be compared."""
    for each in (as_clip(clip), as_clip(other, "other clip")):
        if each.frame_count < 2:
            raise InputError(f"{each.name or 'a clip'} is too short", expected="at least 2 frames", found="1")
    if abs(clip.rate / other.rate - 1.0) > 1e-6:
        raise InputError(
            f"{clip.name or 'the clip'} and {other.name or 'the other'} have different rates",
            expected=f"{clip.rate:g} frames/s",
            found=f"{other.rate:g} frames/s",
            fix="Resample one first.",
        )
