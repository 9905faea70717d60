"""Time shifted and scaled (Gleicher 2000, sections 1.6.2 and 1.6.2.1).

What they do to contacts: the whole pose moves in time together, so a planted foot stays planted at the same place, for
longer or shorter. Where only some channels are shifted, those below the root's move without it and feet slide.
"""

import math
from collections.abc import Sequence

import numpy as np

from mtex_usd.edit.channel_part import take_channels
from mtex_usd.edit.continuation import Ends, check_ends
from mtex_usd.edit.sampling import sample_clip
from mtex_usd.errors import InputError
from mtex_usd.motion.arguments import MOST_FRAMES, as_clip, as_frame_count, as_number, as_tokens
from mtex_usd.motion.clip import Clip

__all__ = ["choose_frame_count", "scale_time", "shift_time"]

_LONGEST_SHIFT_S = 1e9
_FRAME_FITS = 1e-6  # how far past the end, in frames, a frame still belongs to the motion


def shift_time(clip: Clip, *, shift_s: float, ends: Ends = "hold", channels: Sequence[str] = ()) -> Clip:
    """Let a motion happen later or earlier, within the same frames.

    Parameters
    ----------
    clip
        The clip.
    shift_s
        How much later, seconds; below 0 earlier. Parts of a frame are interpolated with a cubic spline.
    ends
        What is seen where the motion is not yet there, or over: ``hold`` its first or last pose, ``loop`` the motion
        again, the root going on from where it is and the way it faces (its last frame is the first of the next cycle,
        as :func:`~mtex_usd.edit.join` closes loops), or ``extrapolate``, on and on as in the last tenth of a second.
    channels
        Channel tokens as in recipes: shift only these, so that an arm follows late; empty for the whole motion.

    Returns
    -------
    Clip
        As many frames as before; with a shift of 0 the clip as it is, by whole frames the frames bit for bit.

    Raises
    ------
    InputError
        A shift that is not finite, an unknown word for the ends, an unknown channel.

    Notes
    -----
    Contacts: moved in time, as still as before; between frames within 0.5 cm of it. The hips alone, 0.1 s late on
    the sample walk, make planted feet slide by 6 to 12 cm. Extrapolated, they slide and sink: it is for tenths of a
    second.
    """
    as_clip(clip)
    check_ends(ends)
    channels = as_tokens(channels)
    shift_s = as_number(
        shift_s,
        "shift of time",
        expected=f"a finite number of seconds, at most {_LONGEST_SHIFT_S:g}",
        least=-_LONGEST_SHIFT_S,
        most=_LONGEST_SHIFT_S,
    )
    if shift_s == 0.0:
        return take_channels(clip, clip, channels)
    shifted = sample_clip(clip, np.arange(clip.frame_count, dtype=np.float64) - shift_s * clip.rate, ends=ends)
    return take_channels(clip, shifted, channels)


def scale_time(
    clip: Clip,
    *,
    factor: float,
    ends: Ends = "hold",
    frame_count: int | None = None,
    channels: Sequence[str] = (),
) -> Clip:
    """Slow a motion down, or speed it up without aliasing.

    Parameters
    ----------
    clip
        The clip.
    factor
        Factor of the duration: 2 is half as fast. Below 1 what the frames cannot carry at the new speed is removed
        first, or it would come back as slow motion that never was; from 1 a cubic spline goes through the frames.
    ends
        What follows where `frame_count` asks for more than there is, as for :func:`shift_time`; a loop is filtered
        across its seam.
    frame_count
        Frames of the result; None for as many as the scaled motion fills, at least 2.
    channels
        Channel tokens as in recipes: scale only these, within the clip's own frames; empty for the whole motion.

    Returns
    -------
    Clip
        At the same rate, from the same first time code; with a factor of 1 the clip as it is. Distances stay, speeds
        change.

    Raises
    ------
    InputError
        A factor that is not above 0, fewer than 2 frames asked for, more than 200,000 in the result, an unknown word
        for the ends, an unknown channel.

    Notes
    -----
    Contacts: as still as before, for longer or shorter: on the sample walk within 1.1 cm as recorded, 0.6 cm at
    three times the speed.

    Examples
    --------
    >>> slower = mtex_usd.edit.scale_time(clip, factor=2.0)  # doctest: +SKIP
    """
    as_clip(clip)
    check_ends(ends)
    channels = as_tokens(channels)
    factor = as_number(factor, "factor of time", expected="a finite factor above 0, at least 1e-12", least=1e-12)
    fitting = max((clip.frame_count - 1) * factor, min(clip.frame_count, 2) - 1)
    count = choose_frame_count(frame_count, last=clip.frame_count - 1 if channels else fitting)
    if factor == 1.0 and count == clip.frame_count:
        return take_channels(clip, clip, channels)
    scaled = sample_clip(clip, np.arange(count) / factor, speeds=1.0 / factor, ends=ends)
    return take_channels(clip, scaled, channels)


def choose_frame_count(frame_count: int | None, *, last: float) -> int:
    """Give the number of frames that was asked for, or those up to a time.

    Parameters
    ----------
    frame_count
        What was asked for; None for nothing.
    last
        The time of the last frame there is something for, in frames.

    Raises
    ------
    InputError
        Where it is no whole number of at least 2, or more than memory should hold.
    """
    if frame_count is not None:
        return as_frame_count(frame_count)
    if not last < MOST_FRAMES:
        raise InputError(
            "too many frames",
            expected=f"at most {MOST_FRAMES} frames in the result",
            found=f"{last:.6g}",
            fix="Use smaller numbers, or give frame_count.",
        )
    return math.floor(last + _FRAME_FITS) + 1
