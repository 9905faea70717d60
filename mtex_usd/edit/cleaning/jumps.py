"""Jumps that are reported and left: a foot that itself steps to another place, a joint that turns round and stays so.

No repair of the leg can know where a foot was whose own place jumps, and which side of a lasting turn is right is not
in the data.
"""

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.cleaning.limbs import body_size, captured_joints, find_limbs
from mtex_usd.edit.cleaning.report import CleaningResult, Finding
from mtex_usd.motion import quaternion
from mtex_usd.motion.arguments import as_clip_with_gaps, as_number
from mtex_usd.motion.clip import Clip

__all__ = ["report_jumps"]

FloatArray = npt.NDArray[np.float64]

_STEP = "jumps"
_FULL_RATE = 60.0  # frames per second
_WIDEST_DEG = 150.0
_AROUND = 5  # steps whose median is the movement around a frame


def report_jumps(clip: Clip, *, least_size: float = 0.03, least_deg: float = 90.0) -> CleaningResult:
    """Note where the end of a limb jumps beyond the movement around, and where a captured joint turns round.

    Parameters
    ----------
    clip
        The clip, which is given back as it is.
    least_size
        Least jump of a limb's end that is noted, in sizes of the body, at 60 frames/s or more; the longer a frame, the
        more.
    least_deg
        The same for the turn of a joint, degrees.

    Returns
    -------
    CleaningResult
        Notes only; the frame of each is the one that was jumped to.

    Raises
    ------
    InputError
        Where a number is out of range.
    """
    as_clip_with_gaps(clip)
    least_size = as_number(least_size, "least_size", expected="0 or more", least=0.0)
    least_deg = as_number(least_deg, "least_deg", expected="0 degrees or more", least=0.0)
    if clip.frame_count <= _AROUND:
        return CleaningResult(clip=clip)
    longer = max(1.0, _FULL_RATE / clip.rate)
    notes = _note_steps(clip, longer * least_size * body_size(clip.skeleton))
    notes += _note_turns(clip, np.radians(min(longer * least_deg, max(least_deg, _WIDEST_DEG))))
    return CleaningResult(clip=clip, notes=tuple(notes))


def _note_steps(clip: Clip, least: float) -> list[Finding]:
    ends = [limb.end for limb in find_limbs(clip.skeleton)]
    if not ends:
        return []
    places = clip.skeleton.joint_positions(ends, clip.rotations, clip.translations)
    jumps = _measure_steps(places)
    return [
        _note(clip, ends[end], frame, f"its place jumps by {_in_metres(clip, jumps[frame, end])}, left as captured")
        for frame, end in np.argwhere(jumps > least).tolist()
    ]


def _measure_steps(places: FloatArray) -> FloatArray:
    """How far each place is from where the movement around would have it after the one before; [F, N, 3] to [F, N]."""
    steps = np.diff(places, axis=0)
    half = _AROUND // 2
    padded = np.pad(steps, ((half, half), (0, 0), (0, 0)), mode="edge")
    usual = np.median(np.lib.stride_tricks.sliding_window_view(padded, _AROUND, axis=0), axis=-1)
    beyond = np.linalg.norm(steps - usual, axis=-1)
    return np.concatenate([np.zeros((1, places.shape[1])), beyond])


def _in_metres(clip: Clip, length: float) -> str:
    return f"{length * clip.skeleton.meters_per_unit:.3f} m"


def _note_turns(clip: Clip, least: float) -> list[Finding]:
    joints = captured_joints(clip)
    turns = quaternion.angle_between(clip.rotations[:-1, joints], clip.rotations[1:, joints])
    return [
        _note(clip, joints[j], frame + 1, f"it turns by {np.degrees(turns[frame, j]):.0f} degrees, left as captured")
        for frame, j in np.argwhere(turns > least).tolist()
    ]


def _note(clip: Clip, joint: int, frame: int, what: str) -> Finding:
    return Finding(step=_STEP, joint=clip.joints[joint], first=frame, last=frame, what=what)
