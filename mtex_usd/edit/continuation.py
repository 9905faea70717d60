"""What is beyond the ends of a motion: the last pose held, the motion repeated, or going on as it went."""

from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.frames import take_frames
from mtex_usd.edit.root import RootMotion, level, place_root, read_root
from mtex_usd.motion import quaternion
from mtex_usd.motion.arguments import as_word
from mtex_usd.motion.clip import Clip

__all__ = ["Ends", "check_ends", "extend_clip"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

Ends = Literal["hold", "loop", "extrapolate"]

_VELOCITY_S = 0.1  # the velocity a motion goes on with is the mean over so long


def check_ends(ends: str) -> None:
    """Refuse a word that says nothing about the ends."""
    as_word(ends, get_args(Ends), "unknown ends")


def extend_clip(clip: Clip, first: int, last: int, *, ends: Ends) -> Clip:
    """Give a stretch of a motion that goes on beyond its ends.

    Parameters
    ----------
    clip
        The motion; a loop's last frame is the first of the next cycle, as :func:`~mtex_usd.edit.join` closes loops.
    first, last
        The stretch in frames of the clip, both included; any before the first and after the last.
    ends
        ``hold``: the first and last pose. ``loop``: the poses repeat, and the root goes on from where it is and the way
        it faces; its height repeats as the poses do. ``extrapolate``: joints turn and move on as they did in the mean
        over the first or last tenth of a second; scales are held.

    Returns
    -------
    Clip
        The frames of the clip keep their bits.
    """
    frames = np.arange(first, last + 1)
    if clip.frame_count < 2 or ends == "hold":
        return take_frames(clip, _hold(clip, frames))
    return _loop(clip, frames) if ends == "loop" else _extrapolate(clip, frames)


def _hold(clip: Clip, frames: IntArray) -> IntArray:
    return np.asarray(np.clip(frames, 0, clip.frame_count - 1))


def _loop(clip: Clip, frames: IntArray) -> Clip:
    period = clip.frame_count - 1
    # The frame where two cycles meet is the one that is nearer to the clip's own.
    cycles = np.where(frames > 0, -(-frames // period) - 1, frames // period)
    repeated = take_frames(clip, frames - cycles * period)
    root = read_root(clip)
    moved = place_root(repeated, *_travel_on(root, cycles, frames - cycles * period), joint=root.joint)
    own = cycles == 0
    for name in ("rotations", "translations"):
        getattr(moved, name)[own] = getattr(repeated, name)[own]
    return moved


def _travel_on(root: RootMotion, cycles: IntArray, frames: IntArray) -> tuple[FloatArray, FloatArray]:
    """Rotations [N, 4] and positions [N, 3] of the root, each cycle beginning where and as the one before ended."""
    turn = float(root.raw_heading[-1] - root.raw_heading[0])
    turning = quaternion.exp(turn * cycles[:, None] * root.up)
    # One cycle takes a place p on the floor to R p + step; so many take it to R^n p + (1 + R + ... + R^(n-1)) step.
    step = level(root.positions[-1] - quaternion.rotate(quaternion.exp(turn * root.up), root.positions[0]), root.up)
    half = 0.5 * (turn - 2.0 * np.pi * np.round(turn / (2.0 * np.pi)))
    # The sum, by sinc because turns may be none: sin(n half) / sin(half), turned by (n - 1) half.
    grown = cycles * np.sinc(cycles * half / np.pi) / np.sinc(half / np.pi)
    travel = grown[:, None] * quaternion.rotate(quaternion.exp((cycles - 1)[:, None] * half * root.up), step)
    positions = quaternion.rotate(turning, root.positions[frames]) + travel
    return quaternion.multiply(turning, root.rotations[frames]), positions


def _extrapolate(clip: Clip, frames: IntArray) -> Clip:
    count = min(clip.frame_count - 1, max(1, round(_VELOCITY_S * clip.rate)))
    extended = take_frames(clip, _hold(clip, frames))
    last = clip.frame_count - 1
    for beyond, end, inner in ((frames < 0, 0, count), (frames > last, last, last - count)):
        rotations, translations = _go_on(clip, end, inner, frames[beyond] - end)
        extended.rotations[beyond], extended.translations[beyond] = rotations, translations
    return extended


def _go_on(clip: Clip, end: int, inner: int, steps: IntArray) -> tuple[FloatArray, FloatArray]:
    """Rotations and translations so many frames from an end, at the mean velocity between it and an inner frame."""
    along = steps[:, None, None] / (end - inner)
    turn = quaternion.log(quaternion.multiply(quaternion.conjugate(clip.rotations[inner]), clip.rotations[end]))
    rotations = quaternion.multiply(clip.rotations[end], quaternion.exp(along * turn))
    return rotations, clip.translations[end] + along * (clip.translations[end] - clip.translations[inner])
