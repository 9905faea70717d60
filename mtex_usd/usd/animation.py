"""Sampling SkelAnimations through the composed stage, so that layer offsets, clips, variants and references count.

A sketch is read on the grid of the stage's frames, a take at the rate it was recorded with. What is read stays in
single precision, bit for bit as USD gives it.
"""

from dataclasses import dataclass, replace
from typing import cast

import numpy as np
import numpy.typing as npt
from pxr import Usd

from mtex_usd.errors import InputError, StageError
from mtex_usd.motion import timing
from mtex_usd.motion.skeleton import FloatArray
from mtex_usd.usd.schema import TakeSettings
from mtex_usd.usd.stage_rate import StageRate, stage_rate

__all__ = ["AnimationSamples", "sample_sketch", "sample_take"]

SingleArray = npt.NDArray[np.float32]

_ATTRIBUTES = {"rotations": 4, "translations": 3, "scales": 3}
_REAL_FIRST = [3, 0, 1, 2]  # USD keeps i, j, k, real in memory
_SAME_TIME = 1e-6  # of a frame
_SLOWEST_RECORDING = 10.0  # frames per second; even samples further apart are keys on a beat, not a recording
_FASTEST_RECORDING = 10000.0  # faster ones are times that differ by rounding
_NTSC = 1.001  # 24 and 30 frames per second are 23.976 and 29.97 in its family
_MOST_FRAMES = 200_000  # more than two hours


@dataclass(frozen=True, eq=False, kw_only=True)
class AnimationSamples:
    """What a SkelAnimation holds at even times, as USD gives it.

    Parameters
    ----------
    name
        Path of the prim.
    joints
        Joint paths in the animation's own order, length J.
    rate
        Frames per second of the grid.
    time_codes_per_frame
        How far one frame is in time codes of the stage.
    time_codes
        Time codes of the frames, shape [F]; the very time of an authored sample where one is within 1e-6 of a frame.
    rotations
        Relative to the parent, real part first, neither normalised nor sign-continuous, shape [F, J, 4].
    translations, scales
        Relative to the parent, in stage units, shape [F, J, 3]; shape [F, J, 3].
    sample_times
        Times of all authored samples of the three attributes, shape [S]; none where there are only defaults.
    missing
        Which of the three attributes the animation does not author. Their arrays hold NaN
        until :func:`~mtex_usd.usd.sampled_clip.fill_missing`.
    """

    name: str
    joints: tuple[str, ...]
    rate: float
    time_codes_per_frame: float
    time_codes: FloatArray
    rotations: SingleArray
    translations: SingleArray
    scales: SingleArray
    sample_times: FloatArray
    missing: tuple[str, ...] = ()


def sample_sketch(stage: Usd.Stage, prim: Usd.Prim) -> AnimationSamples:
    """Sample a sketch at every frame of the stage, from its first authored sample through its last.

    Parameters
    ----------
    stage
        The composed stage.
    prim
        A SkelAnimation. Where it has only default values the frames are those of the stage's start to end.

    Returns
    -------
    AnimationSamples
        At an authored sample's time exactly the authored bits.

    Raises
    ------
    InputError
        Where the prim is no SkelAnimation.
    StageError
        Where it has no joints or values, an array does not fit the joints, or a default-only sketch is on a stage
        without a time range.
    """
    queries = _open_queries(prim)
    rate = stage_rate(stage)
    times = _all_times(_sample_times(queries))
    start, end = (times[0], times[-1]) if times.size else _stage_range(stage, prim)
    step = rate.time_codes_per_frame
    grid = _snap(_even_grid(prim, start, end, step), times, step)
    return _read_samples(prim, queries, grid, times, rate)


def sample_take(stage: Usd.Stage, prim: Usd.Prim, settings: TakeSettings) -> AnimationSamples:
    """Sample a take at its own even rate, within its usable range.

    The rate is that of the authored samples as the composed stage places them, rounded or drifting times put back on an
    even grid (see :func:`mtex_usd.motion.timing.find_even_step`); of the three attributes the one with most samples
    counts. Uneven samples, and even ones slower than ten per second, are hand-set keys: they are read at the stage's
    rate. Only defaults, or one sample, give one frame.

    Parameters
    ----------
    stage
        The composed stage.
    prim
        A SkelAnimation.
    settings
        Its usable range, in time codes of the stage.

    Returns
    -------
    AnimationSamples
        The first frame is the first sample of the range, or the range's start where the samples are hand-set keys.

    Raises
    ------
    InputError
        Where the prim is no SkelAnimation, or nothing is recorded in the range.
    StageError
        As :func:`sample_sketch`.
    """
    queries = _open_queries(prim)
    frames = stage_rate(stage)
    own_times = _sample_times(queries)
    times = _all_times(own_times)
    if not times.size:
        pose_time = settings.start if settings.start is not None else stage.GetStartTimeCode()
        return _read_samples(prim, queries, np.array([pose_time]), times, frames)
    first = times[0] if settings.start is None else max(times[0], settings.start)
    last = times[-1] if settings.end is None else min(times[-1], settings.end)
    usable = _times_within(max(own_times, key=len), first, last, frames)
    step = _recorded_step(usable, frames)
    if step is None:
        grid = _key_grid(prim, first, last, frames)
    else:
        grid = _recorded_grid(usable, first, last, step)
        frames = replace(frames, rate=frames.time_codes_per_second / step)
    return _read_samples(prim, queries, _snap(grid, times, frames.time_codes_per_frame), times, frames)


def _times_within(times: FloatArray, first: float, last: float, frames: StageRate) -> FloatArray:
    slack = _SAME_TIME * frames.time_codes_per_frame
    return times[(times >= first - slack) & (times <= last + slack)]


def _recorded_grid(usable: FloatArray, first: float, last: float, step: float) -> FloatArray:
    """Lay a grid on the recorded samples that reaches as far as those of the other attributes."""
    before = np.ceil((first - usable[0]) / step - _SAME_TIME)
    after = np.floor((last - usable[0]) / step + _SAME_TIME)
    whole = round((usable[-1] - usable[0]) / step)  # the last sample may be a little early
    return cast(FloatArray, usable[0] + step * np.arange(min(before, 0), max(after, whole) + 1))


def _key_grid(prim: Usd.Prim, first: float, last: float, frames: StageRate) -> FloatArray:
    if last < first:
        raise InputError(
            f"{prim.GetPath()}: the take has no samples in its usable range",
            found=f"the range begins at {first:g} and ends at {last:g}",
            fix="Correct mtex:take:start and mtex:take:end, which are time codes of the layer that authors them.",
        )
    return _even_grid(prim, first, last, frames.time_codes_per_frame)


def _even_grid(prim: Usd.Prim, start: float, end: float, step: float) -> FloatArray:
    """List the frames' time codes; a stray key far away would fill the machine instead."""
    if (end - start) / step > _MOST_FRAMES:
        raise InputError(
            f"{prim.GetPath()}: too many frames",
            expected=f"at most {_MOST_FRAMES} frames",
            found=f"samples from time code {start:g} to {end:g}",
            fix="Remove the stray key, or narrow mtex:take:start and mtex:take:end.",
        )
    return timing.frame_time_codes(start, end, step)


def _recorded_step(times: FloatArray, frames: StageRate) -> float | None:
    """Measure the step of a recording in time codes and settle it; None for hand-set keys."""
    step = timing.find_even_step(times)
    measured = frames.time_codes_per_second / step if step else 0.0
    if step is None or not _SLOWEST_RECORDING <= measured <= _FASTEST_RECORDING:
        return None
    likely = [frames.rate, frames.time_codes_per_second, round(measured), round(measured * _NTSC) / _NTSC]
    return timing.prefer_step(times, step, [frames.time_codes_per_second / rate for rate in likely])


def _open_queries(prim: Usd.Prim) -> dict[str, Usd.AttributeQuery]:
    if not prim.IsA("SkelAnimation"):
        raise InputError(
            f"{prim.GetPath()} is no animation",
            expected="a SkelAnimation",
            found=prim.GetTypeName() or "a typeless prim",
        )
    queries = {name: Usd.AttributeQuery(prim.GetAttribute(name)) for name in _ATTRIBUTES}
    if not any(query.HasAuthoredValue() for query in queries.values()):
        raise StageError(f"{prim.GetPath()} holds no animation", expected="rotations, translations or scales")
    return queries


def _sample_times(queries: dict[str, Usd.AttributeQuery]) -> list[FloatArray]:
    """Give the times of each attribute's samples; they may be keyed at times of their own."""
    return [np.array(query.GetTimeSamples(), dtype=np.float64) for query in queries.values()]


def _all_times(times: list[FloatArray]) -> FloatArray:
    if all(np.array_equal(own, times[0]) for own in times[1:]):
        return times[0]
    return np.unique(np.concatenate(times))


def _stage_range(stage: Usd.Stage, prim: Usd.Prim) -> tuple[float, float]:
    if not stage.HasAuthoredTimeCodeRange():
        raise StageError(
            f"{prim.GetPath()} has only default values and the stage has no time range",
            fix="Author startTimeCode and endTimeCode in the root layer, or keys on the animation.",
        )
    return stage.GetStartTimeCode(), stage.GetEndTimeCode()


def _snap(grid: FloatArray, times: FloatArray, step: float) -> FloatArray:
    """Move grid times that are an authored sample's but for rounding onto it, or USD would interpolate."""
    if not times.size:
        return grid
    after = np.clip(np.searchsorted(times, grid), 1, max(len(times) - 1, 1))
    left, right = times[after - 1], times[np.minimum(after, len(times) - 1)]
    nearest = np.where(grid - left < right - grid, left, right)
    return np.where(np.abs(nearest - grid) <= _SAME_TIME * step, nearest, grid)


def _read_samples(
    prim: Usd.Prim, queries: dict[str, Usd.AttributeQuery], grid: FloatArray, times: FloatArray, frames: StageRate
) -> AnimationSamples:
    joints = prim.GetAttribute("joints").Get()
    if not joints:
        raise StageError(f"{prim.GetPath()} names no joints", expected="the joints attribute in the animation")
    arrays = {name: _read_array(query, grid, len(joints), _ATTRIBUTES[name]) for name, query in queries.items()}
    return AnimationSamples(
        name=str(prim.GetPath()),
        joints=tuple(map(str, joints)),
        rate=frames.rate,
        time_codes_per_frame=frames.time_codes_per_frame,
        time_codes=grid,
        rotations=arrays["rotations"][..., _REAL_FIRST],
        translations=arrays["translations"],
        scales=arrays["scales"],
        sample_times=times,
        missing=tuple(name for name, query in queries.items() if not query.HasAuthoredValue()),
    )


def _read_array(query: Usd.AttributeQuery, grid: FloatArray, joint_count: int, width: int) -> SingleArray:
    if not query.HasAuthoredValue():
        return np.full((len(grid), joint_count, width), np.nan, dtype=np.float32)
    shape = (len(grid), joint_count, width)
    if not query.ValueMightBeTimeVarying():
        value = _checked(query.Get(grid[0]), query, grid[0], joint_count)
        return np.broadcast_to(np.asarray(value, dtype=np.float32), shape)
    get, time_codes = query.Get, grid.tolist()
    values = [get(time_code) for time_code in time_codes]
    if not all(value is not None and len(value) == joint_count for value in values):
        for value, time_code in zip(values, time_codes, strict=True):
            _checked(value, query, time_code, joint_count)
    # Joined as bytes, which takes a third of the time that numpy needs to look at every array.
    joined = np.frombuffer(b"".join(values), dtype=np.asarray(values[0]).dtype)
    return joined.astype(np.float32, copy=False).reshape(shape)


def _checked(value: object, query: Usd.AttributeQuery, time_code: float, joint_count: int) -> npt.ArrayLike:
    found = "no value" if value is None else str(len(value))  # type: ignore[arg-type]
    if found != str(joint_count):
        raise StageError(
            f"{query.GetAttribute().GetPath()} does not fit the joints at time code {time_code:g}",
            expected=f"{joint_count} elements, one per joint",
            found=found,
        )
    return cast(npt.ArrayLike, value)
