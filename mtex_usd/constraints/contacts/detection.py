"""Contacts found by height and speed, each with two thresholds.

A point is planted while it is low and slow. One threshold alone breaks a step wherever a curve touches it; so a contact
begins with a moment that is surely one and reaches as far as it may still be one. Gleicher 2000, section 1.7.2.3,
finds footplants by height; height alone takes toes in mid swing for planted, which pass the floor by a centimetre, and
misses feet on captures whose floor rises (CMU 07_01 by 6 cm), so that here speed decides and height only rules out.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.contacts.curves import PointCurves, measure_points
from mtex_usd.constraints.contacts.effectors import Effector, body_scale, find_effectors
from mtex_usd.constraints.kinematics import place_points
from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip

__all__ = ["Contact", "detect_contacts", "estimate_ground"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

_LEAVE_HEIGHT = 1.5  # of the height, and of the speed below, at which a contact that has begun ends
_LEAVE_SPEED = 1.5
_STANDING = 0.1  # quantile of the heights while slow: the lowest place where the point stands, but for outliers
_LOWEST = 0.02  # quantile of all heights, where the point is never slow
_OWN_LEVEL_M = 0.04  # by which a point may stand higher or lower than the others, as joints sit inside the foot
_ONE_PLANT_M = 0.05  # two contacts this near, a moment apart, are one
_ROBUST_STEPS = 8
_ALL_ONE = 1e-9  # where half of the points are this much nearer to the mean than the farthest, they are one point
_GROUND_SPEED_M_S = 0.35


@dataclass(frozen=True, eq=False, kw_only=True)
class Contact:
    """One time that a point of the body is planted.

    Parameters
    ----------
    effector
        The point.
    first, last
        Frames, both included.
    point
        Where it is planted, skeleton space, skeleton units, shape [3]: the mean over the frames, less outliers.
    """

    effector: Effector
    first: int
    last: int
    point: FloatArray


def estimate_ground(clip: Clip, effectors: Sequence[Effector]) -> float:
    """Estimate the height of the floor the feet stand on.

    Parameters
    ----------
    clip
        A motion in which some of the effectors stand for a while.
    effectors
        Points of the feet.

    Returns
    -------
    float
        Height along up, skeleton units, at which the points themselves stand: the median over those that stand near
        the lowest.

    Raises
    ------
    InputError
        Where there are no effectors.
    """
    _check_effectors(effectors)
    scale = body_scale(clip.skeleton)
    curves = measure_points(_track(clip, effectors), clip.rate, clip.skeleton.up)
    return _ground(_levels(curves, _GROUND_SPEED_M_S * scale), scale)


def detect_contacts(
    clip: Clip,
    *,
    effectors: Sequence[Effector] | None = None,
    ground: float | None = None,
    height_m: float = 0.06,
    speed_m_s: float = 0.35,
    shortest_s: float = 0.1,
) -> tuple[Contact, ...]:
    """Find when and where points of the body are planted on the floor.

    Parameters
    ----------
    clip
        Any motion.
    effectors
        The points; those of :func:`find_effectors` where None.
    ground
        Height along up, skeleton units, at which the points stand; where None each one's own is estimated, not far
        from what :func:`estimate_ground` gives.
    height_m
        How high above that a contact may begin, metres; it ends at 1.5 times that.
    speed_m_s
        How fast a point may be where a contact begins, metres per second; it ends at 1.5 times that.
    shortest_s
        Contacts shorter than this, and gaps between two at the same place, are dropped, seconds.

    Returns
    -------
    tuple of Contact
        By effector, then by time; contacts of one effector do not overlap.

    Raises
    ------
    InputError
        Where a number is out of range, or the skeleton has no feet and no effectors are given.

    Notes
    -----
    Metres are those of an average adult: on other bodies they are scaled by the length of the legs, so that neither
    units nor size change what is found. On skeletons without legs they are true metres.
    """
    points = find_effectors(clip.skeleton, clip=clip) if effectors is None else tuple(effectors)
    _check_effectors(points)
    _check_numbers(ground, height_m, speed_m_s, shortest_s)
    scale = body_scale(clip.skeleton)
    positions = _track(clip, points)
    curves = measure_points(positions, clip.rate, clip.skeleton.up)
    levels = np.full(len(points), ground) if ground is not None else _own_levels(curves, speed_m_s * scale, scale)
    planted = _hysteresis(curves, levels, height_m * scale, speed_m_s * scale)
    contacts: list[Contact] = []
    for number, effector in enumerate(points):
        runs = _to_frames(_list_runs(planted[:, number]), curves.per_frame)
        merged = _merge(runs, positions[:, number], shortest_s * clip.rate, _ONE_PLANT_M * scale)
        contacts += [
            Contact(effector=effector, first=first, last=last, point=robust_mean(positions[first : last + 1, number]))
            for first, last in merged
            if last - first + 1 >= shortest_s * clip.rate
        ]
    return tuple(contacts)


def robust_mean(points: FloatArray) -> FloatArray:
    """Average points, those far from the others counting less; [F, 3] to [3]."""
    mean = np.mean(points, axis=0)
    for _ in range(_ROBUST_STEPS):
        away = np.linalg.norm(points - mean, axis=1)
        typical = float(np.median(away))
        if typical <= _ALL_ONE * away.max():
            break
        weights = 1.0 / (typical**2 + np.square(away))
        mean = weights @ points / weights.sum()
    return np.asarray(mean)


def _check_effectors(effectors: Sequence[Effector]) -> None:
    if not effectors:
        raise InputError("no effectors", expected="at least one point of the body")


def _check_numbers(ground: float | None, height_m: float, speed_m_s: float, shortest_s: float) -> None:
    for name, value in (("height_m", height_m), ("speed_m_s", speed_m_s), ("shortest_s", shortest_s)):
        if not (np.isfinite(value) and value > 0.0):
            raise InputError(f"bad {name}", expected="a finite number above 0", found=f"{value:g}")
    if ground is not None and not np.isfinite(ground):
        raise InputError("bad ground", expected="a finite height", found=f"{ground:g}")


def _track(clip: Clip, effectors: Sequence[Effector]) -> FloatArray:
    offsets = np.array([effector.offset for effector in effectors])
    joints = [effector.joint for effector in effectors]
    return place_points(clip.skeleton, joints, offsets, clip.rotations, clip.translations)


def _levels(curves: PointCurves, speed: float) -> FloatArray:
    """Give the lowest height at which each point stands, shape [N]."""
    return np.array([_level(curves, number, speed) for number in range(curves.heights.shape[1])])


def _level(curves: PointCurves, number: int, speed: float) -> float:
    heights, slow = curves.heights[:, number], curves.speeds[:, number] < speed
    if not slow.any():
        return float(np.quantile(heights, _LOWEST))
    return float(np.quantile(heights[slow], _STANDING))


def _ground(levels: FloatArray, scale: float) -> float:
    return float(np.median(levels[levels <= levels.min() + 2.0 * _OWN_LEVEL_M * scale]))


def _own_levels(curves: PointCurves, speed: float, scale: float) -> FloatArray:
    levels = _levels(curves, speed)
    ground, slack = _ground(levels, scale), _OWN_LEVEL_M * scale
    return np.clip(levels, ground - slack, ground + slack)


def _hysteresis(curves: PointCurves, levels: FloatArray, height: float, speed: float) -> BoolArray:
    """Mark the runs below the outer thresholds that are somewhere below the inner ones, shape [S, N]."""
    above = curves.heights - levels
    sure = (above <= height) & (curves.speeds <= speed)
    maybe = (above <= _LEAVE_HEIGHT * height) & (curves.speeds <= _LEAVE_SPEED * speed)
    marked = np.zeros(maybe.shape, dtype=np.bool_)
    for number in range(maybe.shape[1]):
        for first, last in _list_runs(maybe[:, number]):
            marked[first : last + 1, number] = sure[first : last + 1, number].any()
    return marked


def _list_runs(mask: BoolArray) -> list[tuple[int, int]]:
    """List the runs of True as (first, last), both included."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return [(int(first), int(end) - 1) for first, end in edges.reshape(-1, 2)]


def _to_frames(runs: Sequence[tuple[int, int]], per_frame: int) -> Iterator[tuple[int, int]]:
    """Give the frames inside each run of the fine grid, where there are any."""
    for first, last in runs:
        inside = (-(-first // per_frame), last // per_frame)
        if inside[0] <= inside[1]:
            yield inside


def _merge(
    runs: Iterator[tuple[int, int]], positions: FloatArray, gap: float, distance: float
) -> list[tuple[int, int]]:
    """Join runs that are one plant with a moment of doubt in it."""
    merged: list[tuple[int, int]] = []
    for run in runs:
        if merged and run[0] - merged[-1][1] <= gap and _same_place(positions, merged[-1], run, distance):
            merged[-1] = (merged[-1][0], run[1])
        else:
            merged.append(run)
    return merged


def _same_place(positions: FloatArray, a: tuple[int, int], b: tuple[int, int], distance: float) -> bool:
    places = [robust_mean(positions[first : last + 1]) for first, last in (a, b)]
    return bool(np.linalg.norm(places[0] - places[1]) <= distance)
