"""Even grids of time and resampling clips onto them, low-passed before anything is dropped.

Motion above half the new rate does not vanish when frames are dropped, it comes back as slow motion that never was
(Gleicher 2000, section 1.6.2.1). So every reduction is a windowed-sinc low-pass evaluated at the new frames, with the
filter that ``scipy.signal.resample_poly`` uses by default: for whole-number ratios the results are the same. Writing it
as a kernel of time covers any ratio, and spares users the import of ``scipy.signal``.
"""

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array

from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import FloatArray

__all__ = ["LOW_PASS_REACH", "find_even_step", "frame_time_codes", "low_pass_kernel", "prefer_step", "resample_clip"]

_SAME_RATE = 1e-6  # rates this near, relative, are one rate
_FRAME_FITS = 1e-6  # how far past the end, in frames, a frame still belongs to the range
LOW_PASS_REACH = 10  # zero crossings on either side of the filter's middle, as resample_poly
_KAISER_BETA = 5.0  # as resample_poly
_LARGEST_TERM = 1000  # of the fraction that stands for the ratio of the rates when the filter's gain is summed

_JITTER = 0.25  # of a step: how far the distance of two samples may be from a whole number of steps
_MOSTLY = 0.9  # of the distances must be that near for the samples to be an even recording
_NEAR_STEP = 1e-3  # relative: 24 and 23.976 frames/s are this far apart, the nearer one is meant
_EXACT_STEP = 1e-9  # relative: the same step but for rounding
_OFF_GRID = 0.1  # of a step: the preferred grid must pass nearly all samples this near
_EXACT_FRAME = 1e-6  # of a step: samples this near their grid are on it


def find_even_step(time_codes: FloatArray) -> float | None:
    """Measure the distance of evenly recorded samples, whose time codes may be rounded, drift, or skip some frames.

    Parameters
    ----------
    time_codes
        When there are samples, increasing, shape [S].

    Returns
    -------
    float or None
        Time codes from one frame to the next; None where the samples are fewer than two or not even, as hand-set keys.
    """
    gaps = np.diff(time_codes)
    if not gaps.size:
        return None
    steps = np.round(gaps / np.median(gaps))
    even = np.abs(gaps / np.median(gaps) - steps) <= _JITTER
    return float(gaps.sum() / steps.sum()) if even.mean() >= _MOSTLY else None


def prefer_step(time_codes: FloatArray, step: float, preferred: Sequence[float]) -> float:
    """Replace a measured step by the one that was likely meant.

    Parameters
    ----------
    time_codes
        When there are samples, increasing, shape [S].
    step
        What :func:`find_even_step` measured.
    preferred
        Steps that are likely meant, such as that of the stage's frames.

    Returns
    -------
    float
        The nearest preferred step that is within 1e-3 of the measured and whose grid stays within a tenth of a step of
        the samples; the measured one if there is none, or if the samples lie on its grid exactly.
    """
    # A recording at 119.88 is not one at 120 / 1.001: samples that are exactly even may not be moved.
    tolerance = _EXACT_STEP if _follows(time_codes, step, _EXACT_FRAME) else _NEAR_STEP
    near = [likely for likely in preferred if abs(likely / step - 1.0) <= tolerance]
    fitting = [likely for likely in near if _follows(time_codes, likely, _OFF_GRID)]
    return min(fitting, key=lambda likely: abs(likely - step), default=step)


def _follows(time_codes: FloatArray, step: float, slack: float) -> bool:
    frames = (time_codes - time_codes[0]) / step
    return bool((np.abs(frames - np.round(frames)) <= slack).mean() >= _MOSTLY)


def frame_time_codes(start: float, end: float, time_codes_per_frame: float) -> FloatArray:
    """List the time codes of an even grid.

    Parameters
    ----------
    start, end
        Range in time codes; the grid begins at start and includes end where a frame is there within 1e-6 of a frame.
    time_codes_per_frame
        Distance of two frames in time codes, above 0.

    Returns
    -------
    FloatArray
        Shape [F], F at least 1.

    Raises
    ------
    InputError
        Where the range runs backwards, a number is not finite, or the distance is not positive.
    """
    if not (np.isfinite([start, end, time_codes_per_frame]).all() and start <= end and time_codes_per_frame > 0.0):
        raise InputError(
            "bad range of frames",
            expected="start <= end and a positive distance of the frames",
            found=f"start {start:g}, end {end:g}, distance {time_codes_per_frame:g} time codes",
        )
    frames = np.arange(_frames_within((end - start) / time_codes_per_frame), dtype=np.float64)
    return start + time_codes_per_frame * frames


def resample_clip(clip: Clip, rate: float) -> Clip:
    """Bring a clip to another frame rate.

    To a lower rate: zero-phase low-pass at half the new rate (the Kaiser-windowed sinc of
    ``scipy.signal.resample_poly``'s default), evaluated at the new frames; before the first and after the last frame
    the motion continues along the line through both, as ``padtype="line"``. To a higher rate: cubic spline through the
    frames. Rotations are treated as sign-continuous quaternion components and scaled to unit length again. Channels
    that never change keep their bits.

    Parameters
    ----------
    clip
        Any clip.
    rate
        New rate in frames per second. Within 1e-6, relative, of the clip's own the clip is returned as it is.

    Returns
    -------
    Clip
        Begins at the same time code; has as many frames as fit into the duration.

    Raises
    ------
    InputError
        Where the rate is not positive.

    Examples
    --------
    >>> resample_clip(take, 24.0).rate  # doctest: +SKIP
    24.0
    """
    if not (rate > 0.0 and np.isfinite(rate)):
        raise InputError(f"cannot resample {clip.name}", expected="a rate above 0", found=f"{rate:g} frames/s")
    ratio = rate / clip.rate
    if abs(ratio - 1.0) <= _SAME_RATE:
        return clip
    return replace(
        clip,
        rate=rate,
        rotations=quaternion.normalize(_resample(quaternion.unroll(clip.rotations), ratio)),
        translations=_resample(clip.translations, ratio),
        scales=_resample(clip.scales, ratio),
        time_codes_per_frame=clip.time_codes_per_frame / ratio,
    )


def _frames_within(frames: float) -> int:
    return int(np.floor(frames + _FRAME_FITS)) + 1


def _resample(values: FloatArray, ratio: float) -> FloatArray:
    # Most joints of a recording do not move apart: only what changes is filtered.
    columns = values.reshape(len(values), -1)
    count = _frames_within((len(columns) - 1) * ratio)
    moving = np.flatnonzero((columns != columns[0]).any(axis=0))
    out = np.repeat(columns[:1], count, axis=0)
    if moving.size:
        resample = _reduce if ratio < 1.0 else _refine
        out[:, moving] = resample(columns[:, moving], count, ratio)
    return out.reshape(count, *values.shape[1:])


def _refine(columns: FloatArray, count: int, ratio: float) -> FloatArray:
    from scipy.interpolate import CubicSpline  # noqa: PLC0415  (slow to import, seldom used)

    frames = np.minimum(np.arange(count) / ratio, len(columns) - 1)
    return CubicSpline(np.arange(len(columns)), columns, axis=0)(frames)  # type: ignore[no-any-return]


def _reduce(columns: FloatArray, count: int, ratio: float) -> FloatArray:
    last = len(columns) - 1
    slope = (columns[-1] - columns[0]) / last
    filtered = _reduction(len(columns), count, ratio) @ (columns - columns[0] - slope * np.arange(last + 1)[:, None])
    return filtered + columns[0] + slope * (np.arange(count) / ratio)[:, None]  # type: ignore[no-any-return]


@lru_cache(maxsize=64)
def _reduction(frame_count: int, count: int, ratio: float) -> csr_array:
    """Weights [count, frame_count] of the low-pass at the new frames; beyond the ends there is nothing to weigh."""
    times = np.arange(count) / ratio
    reach = int(np.ceil(LOW_PASS_REACH / ratio))
    nearest = np.round(times).astype(np.intp)
    phases, which = np.unique(np.round(nearest - times, 9), return_inverse=True)
    offsets = np.arange(-reach, reach + 1)
    weights = (low_pass_kernel(phases[:, None] + offsets, ratio) / _gain(ratio))[which.ravel()]
    frames = nearest[:, None] + offsets
    inside = (frames >= 0) & (frames < frame_count)
    rows = np.concatenate([[0], np.cumsum(inside.sum(axis=1))])
    return csr_array((weights[inside], frames[inside], rows), shape=(count, frame_count))


def low_pass_kernel(times: FloatArray, ratio: FloatArray | float) -> FloatArray:
    """Kaiser-windowed sinc that keeps what a lower rate can carry, not scaled.

    Parameters
    ----------
    times
        From its middle, in frames of the source; it is 0 beyond `LOW_PASS_REACH` / ratio.
    ratio
        New rate over the rate of the source, at most 1; broadcasts with the times.
    """
    within = np.clip(1.0 - np.square(times * ratio / LOW_PASS_REACH), 0.0, None)
    window = np.where(within > 0.0, np.i0(_KAISER_BETA * np.sqrt(within)), 0.0)
    return np.asarray(np.sinc(times * ratio) * window)


def _gain(ratio: float) -> float:
    """Sum of the kernel over the grid that both rates share: resample_poly scales its filter to 1 there."""
    fraction = Fraction(ratio).limit_denominator(_LARGEST_TERM)
    up, down = max(fraction.numerator, 1), fraction.denominator
    taps: npt.NDArray[np.float64] = np.arange(-LOW_PASS_REACH * down, LOW_PASS_REACH * down + 1) / up
    return float(low_pass_kernel(taps, up / down).sum()) / up
