"""Cutting motion into fragments (Pullen & Bregler 2002, section 3.2).

A fragment is the frames between two breaks, both ends included: the last frame of one is the first of the next. A break
is where the break channel's band turns round.
"""

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

__all__ = ["DEAD_BAND", "cut_at", "find_turns", "merge_breaks"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

# Swings smaller than this part of the range of the channel's band, over sketch and takes, do not break, or noise in a
# hold would make many fragments.
DEAD_BAND = 0.02


def find_turns(curve: FloatArray, dead_band: float) -> IntArray:
    """Find the frames where a curve turns round.

    Parameters
    ----------
    curve
        One band of the break channel, shape [F].
    dead_band
        Swings smaller than this, in the curve's unit, are not turns.

    Returns
    -------
    IntArray
        Frames of the turns, ends not included, rising. On a plateau the sign before it holds: its last frame is the
        turn.
    """
    turns: list[int] = []
    low = high = 0
    direction = 0
    for frame, value in enumerate(curve.tolist()):
        high = frame if value >= curve[high] else high
        low = frame if value <= curve[low] else low
        if direction >= 0 and _fell(curve[high], value, dead_band):
            _record(turns, high, direction)
            direction, low = -1, frame
        elif direction <= 0 and _fell(value, curve[low], dead_band):
            _record(turns, low, direction)
            direction, high = 1, frame
    return np.array(turns, dtype=np.intp)


def _fell(upper: float, lower: float, dead_band: float) -> bool:
    return upper > lower and upper - lower >= dead_band


def _record(turns: list[int], frame: int, direction: int) -> None:
    """Note a turn, unless it only tells which way the curve sets out."""
    if direction != 0:
        turns.append(frame)


def merge_breaks(frame_count: int, turns: Iterable[int], borders: Iterable[int] = ()) -> IntArray:
    """Give all breaks of a clip: its first and last frame, the turns and the segment borders, rising, each once."""
    breaks = {0, frame_count - 1, *turns, *borders}
    return np.array(sorted(b for b in breaks if 0 <= b < frame_count), dtype=np.intp)


def cut_at(breaks: IntArray) -> IntArray:
    """Turn breaks [Q + 1] into fragments [Q, 2] of first and last frame."""
    return np.stack([breaks[:-1], breaks[1:]], axis=1)
