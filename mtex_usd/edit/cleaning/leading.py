"""Frames before the capture: a T-pose added for software that wants one, and junk after it."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.cleaning.limbs import captured_joints
from mtex_usd.edit.cleaning.report import CleaningResult, Finding
from mtex_usd.motion import quaternion
from mtex_usd.motion.arguments import as_clip_with_gaps, as_number
from mtex_usd.motion.clip import Clip

__all__ = ["trim_leading"]

_FEWEST_FRAMES = 8  # below there is no telling how the clip moves
_AT_REST = np.radians(6.0)
_WITHIN_S = 0.05
_WITHIN_FRAMES = 3


def trim_leading(clip: Clip, *, least_deg: float = 5.0, times_usual: float = 8.0) -> CleaningResult:
    """Take off the frames before the last jump of the whole pose within the first 0.05 s (or 3 frames).

    A jump away from the rest pose counts sooner, since at low rates the first step of a movement is large as well.

    Parameters
    ----------
    clip
        The clip.
    least_deg
        Least mean turn of the captured joints, from one frame to the next, that is a jump, degrees.
    times_usual
        It must also be so many times the median over the rest of the clip.

    Returns
    -------
    CleaningResult
        The clip begins later; the time codes of the frames left are the same.

    Raises
    ------
    InputError
        Where a number is out of range.
    """
    as_clip_with_gaps(clip)
    least_deg = as_number(least_deg, "least_deg", expected="0 degrees or more", least=0.0)
    times_usual = as_number(times_usual, "times_usual", expected="0 or more", least=0.0)
    count = _count_leading(clip, np.radians(least_deg), times_usual)
    if count == 0:
        return CleaningResult(clip=clip)
    change = Finding(step="leading", joint="", first=0, last=count - 1, what="taken off, the pose jumps after it")
    return CleaningResult(clip=_without_first(clip, count), changes=(change,), dropped_frames=count)


def _count_leading(clip: Clip, least: float, times_usual: float) -> int:
    joints = captured_joints(clip)
    if clip.frame_count < _FEWEST_FRAMES or not joints:
        return 0
    steps = _mean_turns(clip, joints)
    within = min(max(_WITHIN_FRAMES, round(_WITHIN_S * clip.rate)), len(steps) // 2)
    usual = float(np.median(steps[within:]))
    at_rest = _mean_distance_to_rest(clip, joints)[:within] < _AT_REST
    limits = np.where(at_rest, np.maximum(2.0 * least, 2.0 * usual), np.maximum(least, times_usual * usual))
    jumps = np.flatnonzero(steps[:within] > limits)
    return int(jumps[-1]) + 1 if jumps.size else 0


def _mean_distance_to_rest(clip: Clip, joints: list[int]) -> npt.NDArray[np.float64]:
    """Mean angle of the joints from their rest pose, radians, shape [F]."""
    rest = clip.skeleton.rest_rotations[joints]
    return np.asarray(quaternion.angle_between(rest, clip.rotations[:, joints]).mean(axis=1))


def _mean_turns(clip: Clip, joints: list[int]) -> npt.NDArray[np.float64]:
    """Mean turn of the joints from each frame to the next, radians, shape [F - 1]."""
    rotations = clip.rotations[:, joints]
    return np.asarray(quaternion.angle_between(rotations[:-1], rotations[1:]).mean(axis=1))


def _without_first(clip: Clip, count: int) -> Clip:
    return replace(
        clip,
        rotations=clip.rotations[count:],
        translations=clip.translations[count:],
        scales=clip.scales[count:],
        start=clip.start + count * clip.time_codes_per_frame,
    )
