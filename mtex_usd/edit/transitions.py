"""Where one motion can go over into another (Gleicher 2000, section 1.6.4): the frames where they are most alike.

Two moments are compared by joint positions and velocities over a window around each, from the root and in the facing
frame: place and direction do not count, what the body does before and after does.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.pose_features import check_pair, common_joints, pose_positions
from mtex_usd.errors import InputError
from mtex_usd.motion.arguments import MOST_FRAMES, as_frame, as_number, refuse
from mtex_usd.motion.clip import Clip

__all__ = ["Transition", "find_transition", "half_window", "is_itself", "least_loop", "measure_transition"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

_VELOCITY_S = 0.1  # a metre per second of difference counts as so many metres
_MOMENTS = 9  # of the window that are compared
_ROWS = 256  # frames compared at once: memory of rows times frames
_LEAST_LOOP_S = 0.5  # a loop may not be shorter: frames a moment apart are always alike


@dataclass(frozen=True, kw_only=True)
class Transition:
    """The moments where one motion is best left and the other entered.

    Parameters
    ----------
    frame, other_frame
        Frames of the two that come to lie on each other.
    distance
        How far they are apart there, metres of an average adult: root mean square over the joints and the window,
        velocities counted as what they make in a tenth of a second.
    """

    frame: int
    other_frame: int
    distance: float


def find_transition(
    clip: Clip,
    other: Clip,
    *,
    window_s: float = 0.4,
    frames: tuple[int, int] | None = None,
    other_frames: tuple[int, int] | None = None,
) -> Transition:
    """Find where two motions are most alike.

    Parameters
    ----------
    clip
        The motion to leave.
    other
        The motion to enter; the clip itself to find its best loop, which enters at least half a second before it
        leaves.
    window_s
        How long around a moment motions are compared, seconds.
    frames, other_frames
        First and last frame, both included, to look for the moments in; None for everywhere the window fits.

    Returns
    -------
    Transition
        The first of the best.

    Raises
    ------
    InputError
        Different rates, no joint in common, a window that is empty or longer than a motion, a range without frames or
        with frames the motion does not have.
    """
    check_pair(clip, other)
    half = half_window(clip, window_s)
    ranges = [_check_range(each, half, given) for each, given in ((clip, frames), (other, other_frames))]
    features = _read_features(clip, other)
    least = least_loop(clip, half) if is_itself(clip, other) else None
    best = _search(features, ranges, _moments(half), least)
    if best is None:
        raise InputError(
            f"{clip.name or 'the clip'} has no loop in the range",
            expected=f"frames to leave at least {least} after those to enter",
            found=f"{ranges[0]} and {ranges[1]}",
        )
    return best


def half_window(clip: Clip, window_s: float) -> int:
    """Give how many frames a window reaches to either side, at least one."""
    longest = MOST_FRAMES / clip.rate
    expected = f"a window above 0 seconds, at most {longest:g}"
    return max(1, round(0.5 * as_number(window_s, "window", expected=expected, most=longest) * clip.rate))


def is_itself(clip: Clip, other: Clip) -> bool:
    """Whether the other motion is the same one, though perhaps read twice."""
    arrays = ("rotations", "translations")
    return other is clip or all(np.array_equal(getattr(clip, name), getattr(other, name)) for name in arrays)


def least_loop(clip: Clip, half: int) -> int:
    """Give how many frames a loop has at least, with a window of so many frames to either side of its seam."""
    return max(2 * half, round(_LEAST_LOOP_S * clip.rate))


def measure_transition(clip: Clip, other: Clip, frame: int, other_frame: int, *, half: int) -> Transition:
    """Measure a transition at given frames, over what of the window both motions have.

    Parameters
    ----------
    clip, other
        The motions.
    frame, other_frame
        Frames of the two.
    half
        How many frames the window reaches to either side.
    """
    one, two = _read_features(clip, other)
    moments = [k for k in _moments(half) if 0 <= frame + k < len(one) and 0 <= other_frame + k < len(two)]
    apart = [np.square(one[frame + k] - two[other_frame + k]).sum() for k in moments or [0]]
    return Transition(frame=frame, other_frame=other_frame, distance=float(np.sqrt(np.mean(apart))))


def _check_range(clip: Clip, half: int, given: tuple[int, int] | None) -> tuple[int, int]:
    """Give the first and last frame the window fits around, within what is asked for."""
    first, last = (0, clip.frame_count - 1) if given is None else _as_range(clip, given)
    first, last = max(first, half), min(last, clip.frame_count - 1 - half)
    if first > last:
        raise InputError(
            f"no frame of {clip.name or 'the clip'} is left to look at",
            expected=f"a range with {half} frames on either side, within {clip.frame_count} frames",
            found="the whole clip" if given is None else f"{given[0]} to {given[1]}",
            fix="Use a shorter window or a wider range.",
        )
    return first, last


def _as_range(clip: Clip, given: object) -> tuple[int, int]:
    """Take a first and a last frame, which may be the wrong way round."""
    name = f"range of frames of {clip.name or 'the clip'}"
    if not isinstance(given, Sequence) or isinstance(given, str | bytes) or len(given) != 2:
        raise refuse(given, name, "a first and a last frame")
    return as_frame(given[0], name, clip), as_frame(given[1], name, clip)


def _moments(half: int) -> list[int]:
    """Frames of the window, from its middle."""
    return sorted({int(k) for k in np.round(np.linspace(-half, half, _MOMENTS))})


def _read_features(clip: Clip, other: Clip) -> tuple[FloatArray, FloatArray]:
    """Features whose distance is the root mean square distance of the joints, [F, D] and [G, D]."""
    joints = common_joints(clip, other)
    return _read(clip, joints.of_clip), _read(other, joints.of_other)


def _read(clip: Clip, joints: Sequence[int]) -> FloatArray:
    positions = pose_positions(clip, joints)
    velocities = _VELOCITY_S * clip.rate * np.gradient(positions, axis=0)
    flat = np.concatenate([positions, velocities], axis=1).reshape(clip.frame_count, -1)
    return np.asarray(flat / np.sqrt(len(joints)))


def _search(
    features: tuple[FloatArray, FloatArray], ranges: Sequence[tuple[int, int]], moments: list[int], least: int | None
) -> Transition | None:
    """Compare all pairs of frames, some rows at a time."""
    best: Transition | None = None
    (first, last), (begin, end) = ranges
    for top in range(first, last + 1, _ROWS):
        rows = np.arange(top, min(top + _ROWS, last + 1))
        squares = _compare_windows(features, rows, np.arange(begin, end + 1), moments)
        if least is not None:
            squares[rows[:, None] - np.arange(begin, end + 1) < least] = np.inf
        row, column = np.unravel_index(int(np.argmin(squares)), squares.shape)
        distance = float(np.sqrt(squares[row, column]))
        if np.isfinite(distance) and (best is None or distance < best.distance):
            best = Transition(frame=int(rows[row]), other_frame=begin + int(column), distance=distance)
    return best


def _compare_windows(
    features: tuple[FloatArray, FloatArray], rows: IntArray, columns: IntArray, moments: list[int]
) -> FloatArray:
    """Mean square distances of the windows around rows and columns, which run along diagonals of those of the poses."""
    half = moments[-1]
    poses = features[0][rows[0] - half : rows[-1] + half + 1], features[1][columns[0] - half : columns[-1] + half + 1]
    squares = _square_distances(*poses)
    total = np.zeros((len(rows), len(columns)))
    for moment in moments:
        at = half + moment
        total += squares[at : at + len(rows), at : at + len(columns)]
    return np.asarray(total / len(moments))


def _square_distances(rows: FloatArray, columns: FloatArray) -> FloatArray:
    squares = np.square(rows).sum(axis=1)[:, None] + np.square(columns).sum(axis=1) - 2.0 * rows @ columns.T
    return np.asarray(np.maximum(squares, 0.0))
