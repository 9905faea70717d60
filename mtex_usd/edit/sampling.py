"""Motion read at any times, with a low-pass that follows the local speed (Gleicher 2000, sections 1.6.2.1, 1.6.2.2).

Where time runs no faster than recorded, a cubic spline goes through the frames. Where it runs faster, each new frame is
a windowed-sinc average whose cutoff suits the speed at that very frame, so that what is too fast to be carried is
removed there and nowhere else. Frames that fall on recorded ones at recorded speed or below keep their bits.
"""

from dataclasses import replace

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline
from scipy.sparse import csr_array

from mtex_usd.edit.continuation import Ends, check_ends, extend_clip
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.arguments import MOST_FRAMES
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.timing import LOW_PASS_REACH, low_pass_kernel

__all__ = ["sample_clip", "sample_curves"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

_ON_FRAME = 1e-9  # of a frame: times this near a frame are on it
_PHASE_DIGITS = 9  # of a frame, by which the filter's rows are told apart
_FASTER = 1.0 + 1e-9  # speeds above are filtered
_MOST_PASSED = 2_500_000  # frames of the clip passed faster than recorded: the filter has 20 weights for each
_FASTEST = MOST_FRAMES / LOW_PASS_REACH  # the filter reaches that far beyond the ends


def sample_clip(clip: Clip, times: FloatArray, *, speeds: FloatArray | float = 1.0, ends: Ends = "hold") -> Clip:
    """Read a motion at given times.

    Parameters
    ----------
    clip
        The motion.
    times
        In frames of the clip, shape [N]; may lie before its first and after its last frame.
    speeds
        How many frames of the clip pass from one new frame to the next, there; shape [N] or one for all.
    ends
        What is beyond the ends: ``hold`` the first and last pose, ``loop`` with the root going on, or ``extrapolate``.

    Returns
    -------
    Clip
        N frames at the clip's rate, beginning at its first time code.

    Raises
    ------
    InputError
        For an unknown word for the ends, and where time runs so fast, or so far, that it would fill the memory.
    """
    check_ends(ends)
    speeds = np.broadcast_to(np.asarray(speeds, dtype=np.float64), times.shape)
    _check_speeds(speeds)
    source, first = clip, 0
    if ends == "hold":
        times = np.clip(times, 0.0, clip.frame_count - 1.0)
    else:
        source, first = _extend_to(clip, times, float(speeds.max()), ends)
    times = times - first
    rotations = _sample_rotations(source.rotations, times, speeds)
    return replace(
        clip,
        rotations=rotations,
        translations=_sample(source.translations, times, speeds),
        scales=_sample(source.scales, times, speeds),
    )


def _check_speeds(speeds: FloatArray) -> None:
    passed, fastest = float(speeds[speeds > _FASTER].sum()), float(speeds.max())
    if not (passed <= _MOST_PASSED and fastest <= _FASTEST):
        raise InputError(
            "time runs too fast",
            expected=f"at most {_FASTEST:g} frames of the clip from frame to frame, {_MOST_PASSED} in all",
            found=f"{fastest:.6g}, {passed:.6g} in all",
            fix="Speed it up less, or ask for fewer frames.",
        )


def _extend_to(clip: Clip, times: FloatArray, speed: float, ends: Ends) -> tuple[Clip, int]:
    """Continue a clip over the times, a loop farther so that the filter sees it go round; give its first frame too."""
    first, last = int(np.floor(times.min())), int(np.ceil(times.max()))
    is_beyond = first >= clip.frame_count or last < 0
    if not is_beyond:
        first, last = min(first, 0), max(last, clip.frame_count - 1)
    margin = int(np.ceil((LOW_PASS_REACH + 1) * max(speed, 1.0))) if ends == "loop" or is_beyond else 0
    if last - first > MOST_FRAMES + clip.frame_count:
        raise InputError(
            "the times lie too far apart",
            expected=f"at most {MOST_FRAMES} frames beyond the clip's {clip.frame_count}",
            found=f"frames {first} to {last}",
            fix="Use smaller numbers, or hold the ends.",
        )
    return extend_clip(clip, first - margin, last + margin, ends=ends), first - margin


def _sample_rotations(rotations: FloatArray, times: FloatArray, speeds: FloatArray) -> FloatArray:
    on_frame = _on_frame(times, speeds)
    if on_frame.all():
        return np.asarray(rotations[_nearest(times)])
    sampled = _sample(quaternion.unroll(rotations), times, speeds)
    sampled[~on_frame] = quaternion.normalize(sampled[~on_frame])
    return sampled


def _sample(values: FloatArray, times: FloatArray, speeds: FloatArray) -> FloatArray:
    sampled = sample_curves(values.reshape(len(values), -1), times, speeds)
    return sampled.reshape(len(times), *values.shape[1:])


def sample_curves(curves: FloatArray, times: FloatArray, speeds: FloatArray) -> FloatArray:
    """Read curves at times within their frames.

    Parameters
    ----------
    curves
        Shape [F, C].
    times
        In frames, between 0 and F - 1, shape [N].
    speeds
        Frames of the curves per new frame, shape [N].

    Returns
    -------
    FloatArray
        Shape [N, C]. Curves that never change keep their bits.
    """
    out = np.array(curves[_nearest(times)])
    moving = np.flatnonzero((curves != curves[0]).any(axis=0))
    fast = speeds > _FASTER
    between = ~fast & ~_on_frame(times, speeds)
    if moving.size and between.any():
        out[np.ix_(between, moving)] = CubicSpline(np.arange(len(curves)), curves[:, moving])(times[between])
    if moving.size and fast.any():
        out[np.ix_(fast, moving)] = _low_pass(curves[:, moving], times[fast], speeds[fast])
    return out


def _nearest(times: FloatArray) -> IntArray:
    return np.round(times).astype(np.intp)


def _on_frame(times: FloatArray, speeds: FloatArray) -> BoolArray:
    return np.asarray((np.abs(times - np.round(times)) <= _ON_FRAME) & (speeds <= _FASTER))


def _low_pass(curves: FloatArray, times: FloatArray, speeds: FloatArray) -> FloatArray:
    pad = int(np.ceil(LOW_PASS_REACH * speeds.max()))
    return np.asarray(_weigh(times + pad, speeds, len(curves) + 2 * pad) @ _reflect(curves, pad))


def _weigh(times: FloatArray, speeds: FloatArray, frame_count: int) -> csr_array:
    """Weights [N, frame_count] of the low-pass, each row cut at its own speed and summing to one."""
    phases = np.round(times - np.round(times), _PHASE_DIGITS)
    # At an even speed few rows differ, and the kernel is what takes the time.
    kinds, which = np.unique(np.stack([phases, speeds], axis=1), axis=0, return_inverse=True)
    reach = np.ceil(LOW_PASS_REACH * kinds[:, 1]).astype(np.intp)
    begins, kind, offsets = _lay_out(reach)
    weights = low_pass_kernel(offsets - kinds[kind, 0], 1.0 / kinds[kind, 1])
    weights /= np.add.reduceat(weights, begins[:-1])[kind]
    rows, row, offsets = _lay_out(reach[which.ravel()])
    values = weights[begins[which.ravel()][row] + reach[which.ravel()][row] + offsets]
    return csr_array((values, _nearest(times)[row] + offsets, rows), shape=(len(times), frame_count))


def _lay_out(reach: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Lay rows that reach so far to either side behind each other: begins [N + 1], row and offset of each value."""
    counts = 2 * reach + 1
    begins = np.concatenate([[0], np.cumsum(counts)])
    row = np.repeat(np.arange(len(reach)), counts)
    return begins, row, np.arange(begins[-1]) - begins[row] - reach[row]


def _reflect(curves: FloatArray, pad: int) -> FloatArray:
    """Continue curves by point reflection, as often as it takes, half a frame beyond their ends.

    The centres are extrapolated from means of two frames. So a line goes on as a line, and a motion that alternates
    from frame to frame goes on alternating: reflected about its last frame it would leave that frame's own value.
    """
    count = len(curves)
    frames = np.concatenate([np.arange(-pad, 0), np.arange(count, count + pad)])
    turns, inside = np.divmod(frames, count)
    low, high = _centre(curves), _centre(curves[::-1])
    drift = 2.0 * (high - low)
    mirrored = (turns % 2 == 1)[:, None]
    plain = curves[inside] + 0.5 * turns[:, None] * drift
    turned = 2.0 * low + 0.5 * (turns + 1)[:, None] * drift - curves[count - 1 - inside]
    beyond = np.where(mirrored, turned, plain)
    return np.concatenate([beyond[:pad], curves, beyond[pad:]])


def _centre(curves: FloatArray) -> FloatArray:
    """Give the value half a frame before the first."""
    if len(curves) == 2:
        return np.asarray(1.5 * curves[0] - 0.5 * curves[1])
    return np.asarray(curves[0] + 0.5 * (curves[1] - curves[2]))
