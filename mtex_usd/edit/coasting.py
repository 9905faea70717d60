"""A motion going on from one of its frames by inertia: joints come to rest, the root keeps its speed and its way."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.mixing import Strand
from mtex_usd.edit.root import level, pose_joint
from mtex_usd.motion import quaternion

__all__ = ["coast_from", "coast_into"]

FloatArray = npt.NDArray[np.float64]

_VELOCITY_S = 0.1  # the velocity is the mean over so long


def coast_from(strand: Strand, frame: int, count: int) -> Strand:
    """Go on from a frame for a number of frames.

    Parameters
    ----------
    strand
        The motion; its last tenth of a second up to the frame tells its velocity.
    frame
        The frame.
    count
        How many frames to add.

    Returns
    -------
    Strand
        The frame and what follows, 1 + count frames.
    """
    return _coast(strand, frame, max(0, frame - _reach(strand)), np.arange(count + 1))


def coast_into(strand: Strand, frame: int, count: int) -> Strand:
    """Come into a frame from a number of frames before it, as :func:`coast_from` in reverse."""
    inner = min(strand.clip.frame_count - 1, frame + _reach(strand))
    return _coast(strand, frame, inner, np.arange(count, -1, -1))


def _reach(strand: Strand) -> int:
    return max(1, round(_VELOCITY_S * strand.clip.rate))


def _coast(strand: Strand, frame: int, inner: int, away: npt.NDArray[np.intp]) -> Strand:
    """Give the poses so many frames away from a frame, on the side that an inner frame is not."""
    clip, apart = strand.clip, max(abs(frame - inner), 1)
    steps = away / apart
    # Slower and slower: the speed falls evenly to nothing over all of it.
    slowing = steps * (1.0 - away / (2.0 * max(int(away.max()), 1)))
    turn = quaternion.log(quaternion.multiply(quaternion.conjugate(clip.rotations[inner]), clip.rotations[frame]))
    move = clip.translations[frame] - clip.translations[inner]
    coasted = replace(
        clip,
        rotations=quaternion.multiply(clip.rotations[frame], quaternion.exp(slowing[:, None, None] * turn)),
        translations=clip.translations[frame] + slowing[:, None, None] * move,
        scales=clip.scales[frame][None].repeat(len(away), axis=0),
    )
    up = clip.skeleton.up
    rotations, positions = pose_joint(clip.skeleton, strand.joint, coasted.rotations, coasted.translations)
    way = level(strand.positions[frame] + steps[:, None] * (strand.positions[frame] - strand.positions[inner]), up)
    return Strand(
        clip=coasted,
        joint=strand.joint,
        rotations=rotations,
        positions=way + (positions @ up)[:, None] * up,
        heading=np.full(len(away), strand.heading[frame]),
    )
