"""Spikes: single frames, or a few, that lie far from what is around them, by median and robust filters.

Gleicher 2000, section 1.6.3.2, with rotation distance in place of the difference of values. Only what lies too far from
the filter's result is replaced by it; all else keeps its bits.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.cleaning.limbs import body_size, captured_joints
from mtex_usd.edit.cleaning.report import CleaningResult, Finding, list_runs
from mtex_usd.motion import quaternion
from mtex_usd.motion.arguments import as_clip_with_gaps, as_number, as_word
from mtex_usd.motion.clip import Clip

__all__ = ["SpikeFilter", "repair_spikes"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

SpikeFilter = Literal["median", "robust"]
"""What replaces a spike: the median of the frames around it, or their mean without the outlying half."""

_LEAST_WINDOW = 3


def repair_spikes(
    clip: Clip,
    *,
    least_deg: float = 45.0,
    least_size: float = 0.05,
    window_s: float = 0.06,
    spike_filter: SpikeFilter = "robust",
) -> CleaningResult:
    """Replace what lies far from its surroundings.

    Parameters
    ----------
    clip
        The clip.
    least_deg
        Least distance from the median of the window that is a spike, degrees.
    least_size
        The same for the translation of roots, in sizes of the body.
    window_s
        Length of the window, seconds; at least 3 frames. Spikes shorter than half of it are found.
    spike_filter
        ``"median"`` or ``"robust"``.

    Returns
    -------
    CleaningResult
        One change per run of frames and joint.

    Raises
    ------
    InputError
        For another filter, or a number out of range.
    """
    as_clip_with_gaps(clip)
    as_word(spike_filter, get_args(SpikeFilter), "unknown spike filter")
    least_deg = as_number(least_deg, "least_deg", expected="0 degrees or more", least=0.0)
    least_size = as_number(least_size, "least_size", expected="0 or more", least=0.0)
    window_s = as_number(window_s, "window", expected="seconds above 0, at most a thousand", most=1000.0)
    half = max(_LEAST_WINDOW, round(window_s * clip.rate)) // 2
    if clip.frame_count < 2 * half + 1:
        return CleaningResult(clip=clip)
    turned = _repair_rotations(clip, half, np.radians(least_deg), spike_filter)
    moved = _repair_translations(turned.clip, half, least_size * body_size(clip.skeleton), spike_filter)
    return turned.then(moved)


def _repair_rotations(clip: Clip, half: int, least: float, spike_filter: SpikeFilter) -> CleaningResult:
    rotations = clip.rotations
    changes: list[Finding] = []
    for joint in captured_joints(clip):
        windows = _windows(rotations[:, joint], half)
        distances = quaternion.angle_between(windows[:, :, None], windows[:, None, :])
        medians = _take(windows, distances.sum(axis=-1).argmin(axis=-1))
        far = quaternion.angle_between(rotations[:, joint], medians) > least
        spikes = _keep_passing(far, rotations[:, joint], quaternion.angle_between, least)
        if spikes.any():
            filtered = medians if spike_filter == "median" else _mean_rotations(windows, distances)
            rotations = _replace(rotations, joint, spikes, filtered)
            changes += _describe(clip, joint, spikes, "rotation")
    return _result(replace(clip, rotations=rotations) if changes else clip, changes)


def _repair_translations(clip: Clip, half: int, least: float, spike_filter: SpikeFilter) -> CleaningResult:
    translations = clip.translations
    changes: list[Finding] = []
    for joint in np.flatnonzero(clip.parents < 0).tolist() if least > 0.0 else ():
        windows = _windows(translations[:, joint], half)
        distances = np.linalg.norm(windows[:, :, None] - windows[:, None, :], axis=-1)
        medians = np.median(windows, axis=1)
        far = _distance(translations[:, joint], medians) > least
        spikes = _keep_passing(far, translations[:, joint], _distance, least)
        if spikes.any():
            filtered = medians if spike_filter == "median" else _inner(windows, distances).mean(axis=1)
            translations = _replace(translations, joint, spikes, filtered)
            changes += _describe(clip, joint, spikes, "translation")
    return _result(replace(clip, translations=translations) if changes else clip, changes)


def _distance(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(a - b, axis=-1))


def _keep_passing(
    far: BoolArray, values: FloatArray, distance: Callable[[FloatArray, FloatArray], FloatArray], least: float
) -> BoolArray:
    """Keep the runs that go away again: what lasts is another pose, not a spike."""
    spikes = np.zeros_like(far)
    for first, last in list_runs(far):
        before, after = max(first - 1, 0), min(last + 1, len(far) - 1)
        inside = first > 0 and last + 1 < len(far)
        spikes[first : last + 1] = not inside or distance(values[before], values[after]) <= 0.5 * least
    return spikes


def _result(clip: Clip, changes: list[Finding]) -> CleaningResult:
    return CleaningResult(clip=clip, changes=tuple(changes))


def _windows(values: FloatArray, half: int) -> FloatArray:
    """The frames around each frame, the ends repeated; [F, N] to [F, 2 half + 1, N]."""
    padded = np.pad(values, ((half, half), (0, 0)), mode="edge")
    return np.swapaxes(np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1, axis=0), 1, 2)


def _take(windows: FloatArray, index: npt.NDArray[np.intp]) -> FloatArray:
    return windows[np.arange(len(windows)), index]


def _inner(windows: FloatArray, distances: FloatArray) -> FloatArray:
    """The half of each window that is nearest to all of it."""
    order = np.argsort(distances.sum(axis=-1), axis=-1, kind="stable")[:, : windows.shape[1] // 2 + 1]
    return np.take_along_axis(windows, order[..., None], axis=1)


def _mean_rotations(windows: FloatArray, distances: FloatArray) -> FloatArray:
    inner = _inner(windows, distances)
    signs = np.where(np.sum(inner * inner[:, :1], axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    return quaternion.normalize((inner * signs).mean(axis=1))


def _replace(values: FloatArray, joint: int, spikes: BoolArray, filtered: FloatArray) -> FloatArray:
    out = np.array(values)
    out[spikes, joint] = filtered[spikes]
    return out


def _describe(clip: Clip, joint: int, spikes: BoolArray, what: str) -> list[Finding]:
    return [
        Finding(step="spikes", joint=clip.joints[joint], first=first, last=last, what=f"{what} replaced, a spike")
        for first, last in list_runs(spikes)
    ]
