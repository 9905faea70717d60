"""Edits of some channels only: what is not named keeps its bits."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.curve_space import choose_order, select_channels
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import (
    to_local_rotations,
    to_local_translations,
    to_skeleton_rotations,
    to_skeleton_translations,
    unrolled_angles,
)
from mtex_usd.motion.clip import Clip

__all__ = ["take_channels"]

FloatArray = npt.NDArray[np.float64]


def take_channels(clip: Clip, edited: Clip, channels: Sequence[str]) -> Clip:
    """Take some channels from an edited motion, everything else from the one before.

    Parameters
    ----------
    clip, edited
        Before and after the edit, on the same skeleton.
    channels
        Tokens as in recipes; empty for everything.

    Returns
    -------
    Clip
        Of a joint named in part the angles are exchanged in skeleton axes, in the Euler order that stays clear of
        gimbal lock in both.

    Raises
    ------
    InputError
        An unknown channel, or motions of different lengths.
    """
    if not channels:
        return edited
    wanted = select_channels(clip, channels)
    if clip.frame_count != edited.frame_count:
        raise InputError(
            "an edit of some channels cannot change the length of the clip",
            expected=f"{clip.frame_count} frames",
            found=f"{edited.frame_count}",
            fix="Give frame_count.",
        )
    rotations, translations = np.array(clip.rotations), np.array(clip.translations)
    for joint in sorted({channel.joint for channel in wanted}):
        turned = [c.axis for c in wanted if c.joint == joint and c.is_rotation]
        moved = [c.axis for c in wanted if c.joint == joint and not c.is_rotation]
        rotations[:, joint] = _exchange_angles(clip, edited, joint, turned)
        translations[:, joint] = _exchange_offsets(clip, edited, joint, moved)
    return replace(clip, rotations=rotations, translations=translations)


def _exchange_angles(clip: Clip, edited: Clip, joint: int, axes: list[int]) -> FloatArray:
    if len(axes) in (0, 3):
        return np.asarray((edited if axes else clip).rotations[:, joint])
    both = np.concatenate([to_skeleton_rotations(each.rotations, each.skeleton)[:, joint] for each in (clip, edited)])
    order = choose_order(clip, joint, both)
    own, other = (unrolled_angles(half, order) for half in np.split(both, 2))
    own[:, axes] = other[:, axes]
    return to_local_rotations(quaternion.from_euler(own, order)[:, None], clip.skeleton, joints=[joint])[:, 0]


def _exchange_offsets(clip: Clip, edited: Clip, joint: int, axes: list[int]) -> FloatArray:
    if len(axes) in (0, 3):
        return np.asarray((edited if axes else clip).translations[:, joint])
    own, other = (to_skeleton_translations(each.translations, each.skeleton) for each in (clip, edited))
    own[:, joint, axes] = other[:, joint, axes]
    return to_local_translations(own, clip.skeleton)[:, joint]
