"""Noise: a zero-phase low-pass that stays away from contacts and fast hits.

Gleicher 2000, section 1.3: the high frequencies that make noise are also those that make a kick snap and an impact hit.
So the frames around them keep their bits; the filter is a Gaussian, since a sharper one rings beside what is sharp.
"""

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.cleaning.limbs import body_size, captured_joints, find_limbs
from mtex_usd.edit.cleaning.report import CleaningResult, Finding, list_runs
from mtex_usd.motion import quaternion
from mtex_usd.motion.arguments import as_clip_with_gaps, as_number
from mtex_usd.motion.clip import Clip

__all__ = ["find_sharp_frames", "measure_noise", "smooth_noise"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

_HIT = 6.0  # times the median acceleration of a limb's end
_HARD_HIT = 15.0  # sizes of the body per second squared: what is slower is no hit
_STANDING = 0.15  # sizes of the body per second: a foot that moves less stands, if it is low
_LOW = 0.06  # sizes of the body above the lowest place of the foot
_SHORTEST_CONTACT_S = 0.05
_DIFFERENCES = 4
_REACH = 4.0  # standard deviations that the filter is padded by


def smooth_noise(clip: Clip, *, cutoff_hz: float = 8.0, keep_s: float = 0.05) -> CleaningResult:
    """Low-pass all captured joints, away from contacts and hits.

    Parameters
    ----------
    clip
        The clip.
    cutoff_hz
        Frequency that is let through at 70 %; from half the rate on nothing is done.
    keep_s
        How far around a sharp frame nothing is changed, seconds; the filter comes in over as much again.

    Returns
    -------
    CleaningResult
        One change for each stretch that was filtered.

    Raises
    ------
    InputError
        Where a number is out of range.
    """
    as_clip_with_gaps(clip)
    cutoff_hz = as_number(
        cutoff_hz, "cutoff of the noise filter", expected="a frequency above 0", most=math.inf, unit="Hz"
    )
    keep_s = as_number(keep_s, "keep_s", expected="0 to a thousand seconds", least=0.0, most=1000.0)
    if cutoff_hz >= 0.5 * clip.rate:
        return CleaningResult(clip=clip)
    weights = _filter_weights(find_sharp_frames(clip, cutoff_hz=cutoff_hz), round(keep_s * clip.rate))
    what = f"low-passed at {cutoff_hz:g} Hz"
    changes = [
        Finding(step="noise", joint="", first=first, last=last, what=what) for first, last in list_runs(weights > 0.0)
    ]
    joints = captured_joints(clip)
    if not (changes and joints):
        return CleaningResult(clip=clip)
    return CleaningResult(clip=_blend(clip, joints, cutoff_hz, weights), changes=tuple(changes))


def measure_noise(clip: Clip) -> float:
    """Estimate the noise of the noisiest captured joint, degrees of standard deviation per axis.

    Parameters
    ----------
    clip
        The clip.

    Notes
    -----
    The median of the fourth differences, in which smooth movement is small, scaled as for white noise (Gasser, Sroka
    and Jennen-Steinmetz 1986 do so with second ones). Below about 60 frames/s fast movement counts in part.
    """
    joints = captured_joints(clip)
    if not joints or clip.frame_count <= _DIFFERENCES:
        return 0.0
    rotations = quaternion.unroll(clip.rotations[:, joints])
    rough = np.linalg.norm(np.diff(rotations, n=_DIFFERENCES, axis=0), axis=-1)
    # Half angles; sqrt(70) is the norm of 1 -4 6 -4 1, 1.538 the median length of a standard normal vector in space.
    return float(np.degrees(2.0 * np.median(rough, axis=0).max() / (np.sqrt(70.0) * 1.538)))


def find_sharp_frames(clip: Clip, *, cutoff_hz: float = 8.0) -> BoolArray:
    """Mark the frames where a foot meets or leaves the floor and where the end of a limb hits or is thrown.

    Parameters
    ----------
    clip
        The clip.
    cutoff_hz
        Cutoff of the low-pass that is to follow; movement is measured up to twice that.

    Returns
    -------
    BoolArray
        Shape [F].
    """
    sharp = np.zeros(clip.frame_count, dtype=np.bool_)
    ends = [limb.end for limb in find_limbs(clip.skeleton)]
    if not ends or clip.frame_count < 3:
        return sharp
    positions = clip.skeleton.joint_positions(ends, clip.rotations, clip.translations) / body_size(clip.skeleton)
    calm = _smooth(positions.reshape(clip.frame_count, -1), clip.rate, 2.0 * cutoff_hz).reshape(positions.shape)
    for place in np.moveaxis(calm, 1, 0):
        sharp |= _find_hits(place, clip.rate) | _find_touches(place, clip.rate, clip.skeleton.up)
    return sharp


def _find_hits(places: FloatArray, rate: float) -> BoolArray:
    accelerations = np.linalg.norm(np.gradient(np.gradient(places, axis=0), axis=0), axis=-1) * rate * rate
    return np.asarray(accelerations > max(_HARD_HIT, _HIT * float(np.median(accelerations))))


def _find_touches(places: FloatArray, rate: float, up: FloatArray) -> BoolArray:
    heights = places @ up
    speeds = np.linalg.norm(np.gradient(places, axis=0), axis=-1) * rate
    standing = (speeds < _STANDING) & (heights < heights.min() + _LOW)
    touches = np.zeros(len(places), dtype=np.bool_)
    for first, last in list_runs(standing):
        if last - first + 1 >= _SHORTEST_CONTACT_S * rate:
            touches[[first, last]] = True
    return touches


def _filter_weights(sharp: BoolArray, keep: int) -> FloatArray:
    """How much of the filtered motion is taken at each frame: 0 within `keep` of a sharp one, 1 beyond twice that."""
    if not sharp.any():
        return np.ones(len(sharp))
    where = np.flatnonzero(sharp)
    distances = np.abs(np.arange(len(sharp))[:, None] - where).min(axis=1)
    ramp = np.clip((distances - keep) / max(keep, 1), 0.0, 1.0)
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * ramp))


def _blend(clip: Clip, joints: list[int], cutoff_hz: float, weights: FloatArray) -> Clip:
    taken = np.flatnonzero(weights > 0.0)
    part = weights[taken, None, None]
    rotations, translations = np.array(clip.rotations), np.array(clip.translations)
    raw = clip.rotations[:, joints]
    smooth = _smooth_rotations(raw, clip.rate, cutoff_hz)
    rotations[taken[:, None], joints] = quaternion.normalize((1.0 - part) * raw[taken] + part * smooth[taken])
    moving = np.flatnonzero(np.ptp(clip.translations, axis=0).any(axis=-1))
    moved = _smooth(clip.translations[:, moving].reshape(clip.frame_count, -1), clip.rate, cutoff_hz)
    steps = moved.reshape(clip.frame_count, -1, 3) - clip.translations[:, moving]
    translations[taken[:, None], moving] += part * steps[taken]
    return replace(clip, rotations=rotations, translations=translations)


def _smooth_rotations(rotations: FloatArray, rate: float, cutoff_hz: float) -> FloatArray:
    """Low-passed rotations with the signs of the given ones, shape [F, J, 4]."""
    flat = quaternion.unroll(rotations).reshape(len(rotations), -1)
    smooth = quaternion.normalize(_smooth(flat, rate, cutoff_hz).reshape(rotations.shape))
    signs = np.where(np.sum(smooth * rotations, axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    return np.asarray(smooth * signs)


def _smooth(values: FloatArray, rate: float, cutoff_hz: float) -> FloatArray:
    """Gaussian that lets the cutoff through at 70 %, continued at the ends by point reflection; shape [F, N]."""
    from scipy.ndimage import gaussian_filter1d  # noqa: PLC0415  (slow to import, seldom used)

    if len(values) < 2:
        return values
    deviation = rate * np.sqrt(0.5 * np.log(2.0)) / (2.0 * np.pi * cutoff_hz) * np.sqrt(2.0)
    reach = int(np.ceil(_REACH * deviation))
    padded = np.pad(values, ((reach, reach), (0, 0)), mode="reflect", reflect_type="odd")
    return np.asarray(gaussian_filter1d(padded, deviation, axis=0)[reach:-reach])
