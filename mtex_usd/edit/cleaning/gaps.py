"""Gaps: frames without data, or with the last pose held in the middle of a movement, are interpolated."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.cleaning.report import CleaningResult, Finding, list_runs
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.arguments import as_clip_with_gaps, as_number, as_whole_number
from mtex_usd.motion.clip import Clip

__all__ = ["fill_gaps"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

_SUPPORT = 2  # frames on either side that a gap is interpolated from
_NO_LENGTH = 1e-6


def fill_gaps(clip: Clip, *, longest_s: float = 0.25, fewest_held: int = 2, least_deg: float = 0.5) -> CleaningResult:
    """Interpolate missing frames, joint by joint, and held frames of the whole pose.

    A joint is missing where a number is not finite or a quaternion has no length. The pose is held where all joints
    keep their bits while the clip moves on either side. Gaps are filled with a cubic that goes on as the two frames on
    either side do; at the ends of the clip the nearest frame is held.

    Parameters
    ----------
    clip
        The clip; its rotations and translations may hold nan.
    longest_s
        Longest gap that is filled, seconds; longer gaps of held frames are left and reported, longer missing ones are
        filled all the same and reported.
    fewest_held
        Fewest frames equal to the one before that are a gap.
    least_deg
        Least turn of some joint, per frame at 120 frames/s, on both sides of held frames; less is standing still.

    Returns
    -------
    CleaningResult
        One change per gap and joint, with an empty joint for the whole pose.

    Raises
    ------
    InputError
        Where a joint has no frame with data, or a number is out of range.
    """
    as_clip_with_gaps(clip)
    longest_s = as_number(longest_s, "longest_s", expected="0 seconds or more", least=0.0)
    fewest_held = as_whole_number(fewest_held, "fewest_held", least=1)
    least_deg = as_number(least_deg, "least_deg", expected="0 degrees or more", least=0.0)
    missing = _find_missing(clip)
    filled = _fill_missing(clip, missing, longest_s)
    return filled.then(_fill_held(filled.clip, longest_s, fewest_held, np.radians(least_deg) * 120.0 / clip.rate))


def _find_missing(clip: Clip) -> BoolArray:
    """Mark joints without data, shape [F, J]."""
    values = np.concatenate([clip.rotations, clip.translations], axis=-1)
    finite: BoolArray = np.isfinite(values).all(axis=-1)
    lengths = np.linalg.norm(np.where(finite[..., None], clip.rotations, 0.0), axis=-1)
    return np.asarray(~finite | (lengths < _NO_LENGTH), dtype=np.bool_)


def _fill_missing(clip: Clip, missing: BoolArray, longest_s: float) -> CleaningResult:
    changes: list[Finding] = []
    notes: list[Finding] = []
    for joint in np.flatnonzero(missing.any(axis=0)).tolist():
        name = clip.joints[joint]
        if missing[:, joint].all():
            raise InputError(f"clip {clip.name}: {name} has no data at any frame", fix="Leave the joint out.")
        clip = _fill(clip, [joint], missing[:, joint])
        for first, last in list_runs(missing[:, joint]):
            changes.append(Finding(step="gaps", joint=name, first=first, last=last, what="no data, interpolated"))
            if last - first + 1 > longest_s * clip.rate:
                notes.append(Finding(step="gaps", joint=name, first=first, last=last, what="long without data"))
    return CleaningResult(clip=clip, changes=tuple(changes), notes=tuple(notes))


def _fill_held(clip: Clip, longest_s: float, fewest_held: int, least: float) -> CleaningResult:
    held = np.zeros(clip.frame_count, dtype=np.bool_)
    changes: list[Finding] = []
    notes: list[Finding] = []
    for first, last in _find_held(clip, fewest_held, least):
        if last - first + 1 > longest_s * clip.rate:
            notes.append(Finding(step="gaps", joint="", first=first, last=last, what="pose held long, left as it is"))
        else:
            held[first : last + 1] = True
            changes.append(Finding(step="gaps", joint="", first=first, last=last, what="pose held, interpolated"))
    filled = _fill(clip, list(range(len(clip.joints))), held) if changes else clip
    return CleaningResult(clip=filled, changes=tuple(changes), notes=tuple(notes))


def _find_held(clip: Clip, fewest: int, least: float) -> list[tuple[int, int]]:
    steps = quaternion.angle_between(clip.rotations[:-1], clip.rotations[1:]).max(axis=1, initial=0.0)
    same = np.asarray((clip.rotations[1:] == clip.rotations[:-1]).all(axis=(1, 2)))
    same &= np.asarray((clip.translations[1:] == clip.translations[:-1]).all(axis=(1, 2)))
    runs = [(first + 1, last + 1) for first, last in list_runs(same)]
    inside = [(first, last) for first, last in runs if first >= 2 and last < clip.frame_count - 1]
    moving = [(first, last) for first, last in inside if min(steps[first - 2], steps[last]) > least]
    return [(first, last) for first, last in moving if last - first + 1 >= fewest]


def _fill(clip: Clip, joints: list[int], gaps: BoolArray) -> Clip:
    rotations, translations = np.array(clip.rotations), np.array(clip.translations)
    for joint in joints:
        _fill_rotations(rotations[:, joint], gaps)
        _fill_values(translations[:, joint], gaps)
    return replace(clip, rotations=rotations, translations=translations)


def _fill_rotations(rotations: FloatArray, gaps: BoolArray) -> None:
    if (rotations[~gaps] == rotations[~gaps][0]).all():
        rotations[gaps] = rotations[~gaps][0]
        return
    sided = np.array(rotations)
    sided[~gaps] = quaternion.unroll(rotations[~gaps])
    _fill_values(sided, gaps)
    # The frames kept keep their bits; those filled are on the side of the kept frame before them.
    kept = np.maximum.accumulate(np.where(gaps, 0, np.arange(len(gaps))))
    kept = np.where(gaps[kept], int(np.argmin(gaps)), kept)
    signs = np.where(np.sum(sided[kept] * rotations[kept], axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    rotations[gaps] = quaternion.normalize((sided * signs)[gaps])


def _fill_values(values: FloatArray, gaps: BoolArray) -> None:
    """Fill in place; shape [F, N]."""
    from scipy.interpolate import CubicHermiteSpline  # noqa: PLC0415  (slow to import, seldom used)

    frames = np.flatnonzero(~gaps)
    for first, last in list_runs(gaps):
        before, after = frames[frames < first][-_SUPPORT:], frames[frames > last][:_SUPPORT]
        if not (before.size and after.size):
            values[first : last + 1] = values[after[0] if after.size else before[-1]]
            continue
        ends = [before[-1], after[0]]
        slopes = [_slope(values, before, ends), _slope(values, after, ends)]
        values[first : last + 1] = CubicHermiteSpline(ends, values[ends], slopes)(np.arange(first, last + 1))


def _slope(values: FloatArray, frames: npt.NDArray[np.intp], ends: list[np.intp]) -> FloatArray:
    first, last = (frames[0], frames[-1]) if len(frames) > 1 else ends
    return np.asarray((values[last] - values[first]) / (last - first))
