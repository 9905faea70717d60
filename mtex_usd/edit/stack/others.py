"""Bringing the other motions of edits onto the joints of the motion that is edited."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from mtex_usd.motion.clip import Clip
from mtex_usd.motion.correspondence import corresponding_joints

__all__ = ["complete_joints", "put_on_joints"]

FloatArray = npt.NDArray[np.float64]

_SAME_REST = 1e-5  # stage units


def put_on_joints(other: Clip, like: Clip) -> Clip:
    """Give a motion on the joints of another, by the joints' names.

    Parameters
    ----------
    other
        On joints some of which are called as those of `like`; others are left out.
    like
        Gives the skeleton, and the motion of the joints that `other` does not have.

    Returns
    -------
    Clip
        The motion itself where it is on these joints already. Bones have the lengths that they have in `like`; joints
        that move away from their parents are where they were.
    """
    if other.joints == like.joints and np.array_equal(other.rest, like.rest):
        return other
    named = corresponding_joints(other.joints, like.joints)
    here, there = list(named.keys()), list(named.values())
    skeleton, shape = like.skeleton, (other.frame_count, 1, 1)
    rotations, translations = np.tile(skeleton.rest_rotations, shape), np.tile(skeleton.rest_translations, shape)
    rotations[:, here] = other.rotations[:, there]
    translations[:, here] = other.translations[:, there] + _lengthening(other, like, here, there)
    scales = np.ones_like(translations)
    scales[:, here] = other.scales[:, there]
    put = replace(other, skeleton=skeleton, rotations=rotations, translations=translations, scales=scales)
    return complete_joints(put, like, here)


def _lengthening(other: Clip, like: Clip, here: list[int], there: list[int]) -> FloatArray:
    """How much longer bones are, [J, 3]; nothing for the first joints and for those that move from their places."""
    longer = like.skeleton.rest_translations[here] - other.skeleton.rest_translations[there]
    moves = np.ptp(other.translations[:, there], axis=0) > _SAME_REST
    first = np.asarray(other.parents)[there] < 0
    still = np.abs(longer) <= _SAME_REST
    as_it_is = moves.any(axis=1) | still.all(axis=1) | first
    return np.where(as_it_is[:, None], 0.0, longer)


def complete_joints(other: Clip, like: Clip, known: Collection[int]) -> Clip:
    """Let the joints that a motion says nothing of move as in another motion at the same time, held beyond its ends.

    Parameters
    ----------
    other
        On the joints of `like`.
    like
        What moves those joints.
    known
        Indices of the joints that `other` says something of; what is above one of them stays as it is, or that would
        move along.
    """
    kept = set(known)
    for joint in tuple(kept):
        parent = int(like.parents[joint])
        while parent >= 0:
            kept.add(parent)
            parent = int(like.parents[parent])
    open_joints = [joint for joint in range(len(like.joints)) if joint not in kept]
    if not open_joints:
        return other
    frames = np.rint((other.time_codes - like.start) / like.time_codes_per_frame).astype(np.intp)
    frames = np.clip(frames, 0, like.frame_count - 1)
    arrays = {}
    for name in ("rotations", "translations", "scales"):
        arrays[name] = np.array(getattr(other, name))
        arrays[name][:, open_joints] = getattr(like, name)[frames][:, open_joints]
    return replace(other, **arrays)  # type: ignore[arg-type]
