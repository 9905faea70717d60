"""Solver flips: a limb turned about the line from its upper joint to its end, for one frame or a run of frames.

Where markers are seen badly, a solver finds the other solution of the limb: the middle (knee, elbow) jumps to the other
side, upper joint and end turn by 90 to 180 degrees, while the end itself stays nearly where it is (Gleicher 2000,
section 1.3: what changes too quickly is most likely the sensor's, not the performer's).

Which side of a jump is the wrong one is not in the data of that frame. What is left as captured and what is repaired is
chosen for the whole clip at once: the fewest and shortest repairs that leave no jump behind and turn the limb no faster
than people do.
"""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.cleaning.limbs import Limb, Swivel, find_limbs, measure_swivel
from mtex_usd.edit.cleaning.report import CleaningResult, Finding
from mtex_usd.motion import quaternion
from mtex_usd.motion.arguments import as_clip_with_gaps, as_number
from mtex_usd.motion.clip import Clip

__all__ = ["find_flips", "find_jumps", "interpolate_swivel", "repair_flips"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

_LEAST_OFFSET = 0.03  # lengths of the limb: nearer to the line the middle has no side
_MIDDLE_FARTHER = 1.5  # times the movement of the end
_RIGHT_ROUND = np.radians(120.0)
_BENT = 0.1  # lengths of the limb
_FASTEST_JUMP_S = 2400.0  # degrees per second: at low rates people turn an arm by 60 degrees between two frames
# Costs of a repair, in seconds of repaired motion.
_FREE_BORDER = 1.0 / 12.0  # a border where nothing jumps
_PER_RADIAN = 0.05  # of difference between what is on either side
_PER_FAST_RADIAN = 2.5  # per radian and frame of turning faster than people do
_UNRESOLVED = 1.0  # leaving a jump as it is
_FASTEST_S = np.radians(600.0)  # radians per second
_WIDEST = np.radians(160.0)  # between the two sides: more is no repair but another flip


def repair_flips(clip: Clip, *, jump_deg: float = 60.0, longest_s: float = 0.5) -> CleaningResult:
    """Turn flipped limbs back.

    Through every run the swivel is interpolated from the frame before to the frame after, the upper joint turned to
    suit, the middle one left as captured (so that the end stays exactly where the capture has it), and the end's own
    rotation interpolated. All other frames and joints keep their bits.

    Parameters
    ----------
    clip
        The clip.
    jump_deg
        Least jump of the swivel between two frames that is a flip, degrees; more below 40 frames/s.
    longest_s
        Longest run that is repaired, seconds.

    Returns
    -------
    CleaningResult
        Two changes per run, one for the upper joint and one for the end; jumps that no repair resolves are notes.

    Raises
    ------
    InputError
        Where a number is out of range.
    """
    as_clip_with_gaps(clip)
    jump_deg = as_number(jump_deg, "jump_deg", expected="degrees above 0")
    longest_s = as_number(longest_s, "longest_s", expected="0 seconds or more", least=0.0)
    rotations = clip.rotations
    changes: list[Finding] = []
    notes: list[Finding] = []
    for limb in find_limbs(clip.skeleton):
        swivel = measure_swivel(clip, limb)
        jumps = find_jumps(swivel, np.radians(max(jump_deg, _FASTEST_JUMP_S / clip.rate)))
        runs = find_flips(swivel.angles, jumps, clip.rate, longest_s=longest_s)
        for first, last in runs:
            rotations = _repair_run(rotations, limb, swivel, first, last)
            changes += _describe_run(clip, limb, swivel, first, last)
        notes += _describe_left(clip, limb, jumps, runs)
    repaired = replace(clip, rotations=rotations) if changes else clip
    return CleaningResult(clip=repaired, changes=tuple(changes), notes=tuple(notes))


def find_jumps(swivel: Swivel, least: float) -> BoolArray:
    """Mark the frames whose swivel differs from the frame before by more than `least` radians, shape [F].

    The middle must also move much farther than the end, or be far off the line and go right round; else the whole limb
    is thrown and nothing flips.
    """
    steps = np.abs(_nearest_turn(np.diff(swivel.angles, prepend=swivel.angles[:1])))
    off = swivel.offsets >= _LEAST_OFFSET
    seen = off & np.concatenate([off[:1], off[:-1]])
    still = _moved(swivel.middles) >= _MIDDLE_FARTHER * _moved(swivel.ends)
    round_and_bent = (steps > _RIGHT_ROUND) & (np.minimum(swivel.offsets, np.roll(swivel.offsets, 1)) >= _BENT)
    return np.asarray((steps > least) & seen & (still | round_and_bent))


def _moved(places: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(np.diff(places, axis=0, prepend=places[:1]), axis=-1))


def find_flips(angles: FloatArray, jumps: BoolArray, rate: float, *, longest_s: float) -> list[tuple[int, int]]:
    """Choose the runs of frames to repair, first and last frame of each.

    The cheapest choice by dynamic programming: a frame repaired costs its duration, a run more where its border is no
    jump, the more its two sides differ, and much more where that makes it turn too fast; a jump left costs a second.

    Parameters
    ----------
    angles
        Swivel in radians, shape [F].
    jumps
        Where it jumps from the frame before, shape [F].
    rate
        Frames per second.
    longest_s
        Longest run, seconds.
    """
    if not jumps.any():
        return []
    count, longest = len(angles), max(1, int(longest_s * rate))
    near = _spread(jumps, longest)
    # Frame f + 1 here is frame f of the clip, so that a frame before the first and one after the last can be kept.
    best, begins = np.zeros(count + 2), np.full(count + 2, -1)
    for end in range(1, count + 2):
        best[end] = best[end - 1] + (_UNRESOLVED if end <= count and jumps[end - 1] else 0.0)
        if not near[min(end, count) - 1]:
            continue
        firsts = np.arange(max(1, end - longest), end)
        costs = best[firsts - 1] + _cost_runs(angles, jumps, rate, firsts, end)
        if len(costs) and costs.min() < best[end]:
            best[end], begins[end] = costs.min(), firsts[costs.argmin()]
    return _trace_runs(begins)


def _spread(jumps: BoolArray, reach: int) -> BoolArray:
    """Mark the frames within reach of a jump."""
    frames = np.arange(len(jumps))
    where = np.flatnonzero(jumps)
    return np.asarray(np.abs(frames[:, None] - where[None, :]).min(axis=1) <= reach)


def _cost_runs(angles: FloatArray, jumps: BoolArray, rate: float, firsts: npt.NDArray[np.intp], end: int) -> FloatArray:
    """Cost of repairing from each of `firsts` up to before `end`, frames counted from 1, in seconds, shape [N]."""
    count = len(angles)
    lengths = end - firsts
    open_first, open_end = firsts == 1, end == count + 1
    borders = np.where(~open_first & jumps[firsts - 1], 0.0, _FREE_BORDER)
    borders = borders + (0.0 if not open_end and jumps[end - 1] else _FREE_BORDER)
    gaps = np.abs(_nearest_turn(angles[min(end, count) - 1] - angles[np.maximum(firsts - 2, 0)]))
    gaps = np.where(open_first | open_end, 0.0, gaps)
    too_fast = np.maximum(gaps / (lengths + 1) - _FASTEST_S / rate, 0.0)
    costs = lengths / rate + borders + _PER_RADIAN * gaps + _PER_FAST_RADIAN * too_fast
    return np.asarray(np.where(gaps > _WIDEST, np.inf, costs))


def _trace_runs(begins: npt.NDArray[np.intp]) -> list[tuple[int, int]]:
    runs: list[tuple[int, int]] = []
    end = len(begins) - 1
    while end > 0:
        if begins[end] >= 0:
            runs.append((int(begins[end]) - 1, end - 2))
            end = int(begins[end]) - 1
        else:
            end -= 1
    return runs[::-1]


def _repair_run(rotations: FloatArray, limb: Limb, swivel: Swivel, first: int, last: int) -> FloatArray:
    run = slice(first, last + 1)
    turn = _nearest_turn(interpolate_swivel(swivel.angles, first, last) - swivel.angles[run])
    turns = quaternion.exp(turn[:, None] * swivel.axes[run])
    repaired = np.array(rotations)
    repaired[run, limb.upper] = quaternion.multiply(turns, rotations[run, limb.upper])
    repaired[run, limb.end] = _interpolate_rotations(rotations[:, limb.end], first, last)
    for joint in (limb.upper, limb.end):
        repaired[run, joint] = _same_side(repaired[:, joint], first, last)
    return repaired


def interpolate_swivel(angles: FloatArray, first: int, last: int) -> FloatArray:
    """Interpolate angles through a run from the frame before it to the frame after it, the short way round.

    Parameters
    ----------
    angles
        Radians, shape [F].
    first, last
        The run; where it reaches an end of the clip the other side is held.

    Returns
    -------
    FloatArray
        Radians, not wrapped, shape [last - first + 1].
    """
    before, after, weights = _sides(len(angles), first, last)
    return np.asarray(angles[before] + weights * _nearest_turn(angles[after] - angles[before]))


def _interpolate_rotations(rotations: FloatArray, first: int, last: int) -> FloatArray:
    before, after, weights = _sides(len(rotations), first, last)
    turn = quaternion.log(quaternion.multiply(quaternion.conjugate(rotations[before]), rotations[after]))
    return quaternion.multiply(rotations[before], quaternion.exp(weights[:, None] * turn))


def _sides(count: int, first: int, last: int) -> tuple[int, int, FloatArray]:
    """Give the kept frames on both sides of a run and how far each of its frames is from one to the other."""
    before = first - 1 if first > 0 else last + 1
    after = last + 1 if last + 1 < count else before
    return before, after, np.arange(1, last - first + 2) / (last - first + 2)


def _same_side(rotations: FloatArray, first: int, last: int) -> FloatArray:
    """Choose signs that continue those of the frame before the run."""
    return quaternion.unroll(rotations[max(first - 1, 0) : last + 1])[-(last - first + 1) :]


def _nearest_turn(angles: FloatArray) -> FloatArray:
    return np.asarray(angles - 2.0 * np.pi * np.round(angles / (2.0 * np.pi)))


def _describe_run(clip: Clip, limb: Limb, swivel: Swivel, first: int, last: int) -> list[Finding]:
    turned = _nearest_turn(interpolate_swivel(swivel.angles, first, last) - swivel.angles[first : last + 1])
    most = float(np.degrees(np.abs(turned)).max())
    before, after, _ = _sides(clip.frame_count, first, last)
    across = float(
        np.degrees(quaternion.angle_between(clip.rotations[before, limb.end], clip.rotations[after, limb.end]))
    )
    middle, end = (clip.joints[joint].rpartition("/")[2] for joint in (limb.middle, limb.end))
    whats = {
        limb.upper: f"turned back by up to {most:.0f} degrees, {middle} with it, {end} kept in place",
        limb.end: f"kept in place, its rotation interpolated over {across:.0f} degrees",
    }
    return [
        Finding(step="flips", joint=clip.joints[joint], first=first, last=last, what=what)
        for joint, what in whats.items()
    ]


def _describe_left(clip: Clip, limb: Limb, jumps: BoolArray, runs: list[tuple[int, int]]) -> list[Finding]:
    name = clip.joints[limb.upper]
    touched = {frame for first, last in runs for frame in range(first, last + 2)}
    left = [int(frame) for frame in np.flatnonzero(jumps) if int(frame) not in touched]
    what = "it flips and no repair resolves it, left as captured"
    return [Finding(step="flips", joint=name, first=frame, last=frame, what=what) for frame in left]
