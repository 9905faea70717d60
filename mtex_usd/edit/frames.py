"""Frames of clips taken out and put together."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from mtex_usd.motion.clip import Clip

__all__ = ["append_frames", "take_frames"]


def take_frames(clip: Clip, frames: npt.NDArray[np.intp] | slice) -> Clip:
    """Give some frames of a motion, in the order asked for; the first time code stays.

    Parameters
    ----------
    clip
        The motion.
    frames
        Their numbers, shape [N], or a slice.
    """
    return replace(
        clip, rotations=clip.rotations[frames], translations=clip.translations[frames], scales=clip.scales[frames]
    )


def append_frames(clip: Clip, other: Clip, *, skipped: int = 0) -> Clip:
    """Put a motion on the same joints behind another, as it is.

    Parameters
    ----------
    clip
        The motion to begin with; its name, rate and time codes hold.
    other
        The motion to go on with.
    skipped
        How many of its first frames are left out.
    """
    return replace(
        clip,
        rotations=np.concatenate([clip.rotations, other.rotations[skipped:]]),
        translations=np.concatenate([clip.translations, other.translations[skipped:]]),
        scales=np.concatenate([clip.scales, other.scales[skipped:]]),
    )
