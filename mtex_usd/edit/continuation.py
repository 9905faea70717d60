"""What is beyond the ends of a motion: the last pose held, the motion repeated, or going on as it went."""

from dataclasses import replace
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.frames import take_frames
from mtex_usd.edit.root import RootMotion, move_level, place_root, read_root
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip

__all__ = ["Ends", "check_ends", "extend_clip"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

Ends = Literal["hold", "loop", "extrapolate"]

_VELOCITY_S = 0.1  # the velocity a motion goes on with is the mean over so long


def check_ends(ends: str) -> None:
    """Refuse a word that says nothing about the ends."""
    if ends not in get_args(Ends):
        raise InputError("unknown ends", expected=" or ".join(get_args(Ends)), found=repr(ends))


def extend_clip(clip: Clip, before: int, after: int, *, ends: Ends) -> Clip:
    """Add frames before the first and after the last.

    Parameters
    ----------
    clip
        The motion; a loop's last frame is the first of the next cycle, as :func:`~mtex_usd.edit.join` closes loops.
    before, after
        How many frames to add.
    ends
        ``hold``: the first and last pose. ``loop``: the poses repeat, and the root goes on from where it is and the way
        it faces; its height repeats as the poses do. ``extrapolate``: joints turn and move on as they did in the mean
        over the first or last tenth of a second; scales are held.

    Returns
    -------
    Clip
        The frames of the clip keep their bits.
    """
    if clip.frame_count < 2 or ends == "hold":
        return take_frames(clip, np.clip(np.arange(-before, clip.frame_count + after), 0, clip.frame_count - 1))
    if ends == "loop":
        return _loop(clip, before, after)
    return _extrapolate(clip, before, after)


def _loop(clip: Clip, before: int, after: int) -> Clip:
    period = clip.frame_count - 1
    frames = np.arange(-before, clip.frame_count + after)
    # The frame where two cycles meet is the one that is nearer to the clip's own.
    cycles = np.where(frames > 0, -(-frames // period) - 1, frames // period)
    repeated = take_frames(clip, frames - cycles * period)
    root = read_root(clip)
    moved = place_root(repeated, *_travel_on(root, cycles, frames - cycles * period), joint=root.joint)
    return _with_own(moved, clip, before)


def _travel_on(root: RootMotion, cycles: IntArray, frames: IntArray) -> tuple[FloatArray, FloatArray]:
    """Rotations [N, 4] and positions [N, 3] of the root, each cycle beginning where and as the one before ended."""
    turn = root.raw_heading[-1] - root.raw_heading[0]
    rotations, positions = np.array(root.rotations[frames]), np.array(root.positions[frames])
    for step in (1, -1):
        # Carries a root from one cycle into the next, or into the one before.
        pivot, goal = (root.positions[0], root.positions[-1])[::step]
        for cycle in range(step, step * (int((step * cycles).max()) + 1), step):
            on = cycles * step >= cycle * step
            rotations[on], positions[on] = move_level(
                rotations[on], positions[on], turn=step * turn, pivot=pivot, goal=goal, up=root.up
            )
    return rotations, positions


def _extrapolate(clip: Clip, before: int, after: int) -> Clip:
    count = min(clip.frame_count - 1, max(1, round(_VELOCITY_S * clip.rate)))
    head = _go_on(clip, 0, count, -np.arange(before, 0, -1))
    tail = _go_on(clip, -1, -1 - count, np.arange(1, after + 1))
    rotations, translations = (
        np.concatenate([head[i], own, tail[i]]) for i, own in enumerate((clip.rotations, clip.translations))
    )
    scales = np.concatenate([clip.scales[:1].repeat(before, 0), clip.scales, clip.scales[-1:].repeat(after, 0)])
    return replace(clip, rotations=rotations, translations=translations, scales=scales)


def _go_on(clip: Clip, end: int, inner: int, steps: IntArray) -> tuple[FloatArray, FloatArray]:
    """Rotations and translations so many frames from an end, at the mean velocity between it and an inner frame."""
    along = steps[:, None, None] / (end - inner)
    turn = quaternion.log(quaternion.multiply(quaternion.conjugate(clip.rotations[inner]), clip.rotations[end]))
    rotations = quaternion.multiply(clip.rotations[end], quaternion.exp(along * turn))
    return rotations, clip.translations[end] + along * (clip.translations[end] - clip.translations[inner])


def _with_own(extended: Clip, clip: Clip, before: int) -> Clip:
    """Put the clip's own frames back, bit for bit."""
    own = slice(before, before + clip.frame_count)
    for name in ("rotations", "translations", "scales"):
        getattr(extended, name)[own] = getattr(clip, name)
    return extended
