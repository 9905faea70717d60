"""The second part of a BVH file: frame count, frame time and one row of numbers per frame."""

import re
from dataclasses import dataclass
from decimal import Decimal
from itertools import chain

import numpy as np
import numpy.typing as npt

from mtex_usd.formats.bvh_text import BvhText
from mtex_usd.formats.source_text import parse_count, parse_number

__all__ = ["BvhMotion", "frame_time_to_rate", "parse_motion"]

FloatArray = npt.NDArray[np.float64]

_SHORTEST_FRAME_S, _LONGEST_FRAME_S = 1e-6, 1e4  # outside, the number is no frame time but a mistake
_NTSC_RATES = tuple(nominal * 1000.0 / 1001.0 for nominal in (24, 30, 48, 60, 72, 90, 96, 120, 144, 240))


@dataclass(frozen=True, eq=False, kw_only=True)
class BvhMotion:
    """The numbers of a BVH file.

    Parameters
    ----------
    rate
        Frames per second.
    values
        One row per frame, channels in the order of the hierarchy, shape [F, C]; degrees and file units.
    """

    rate: float
    values: FloatArray


def frame_time_to_rate(written: str) -> float:
    """Give the frame rate that a frame time was rounded from.

    Parameters
    ----------
    written
        Seconds as the file writes them, such as ``"0.008333"``.

    Returns
    -------
    float
        Frames per second: the nearest whole rate, else the nearest NTSC rate, else the nearest rate of three decimals
        (23.976), the first whose frame time agrees with all digits written; else the reciprocal. 0.008333 is 120, not
        120.0048, which in a minute would drift by a third of a frame against its sound.
    """
    frame_time = float(written)
    exponent = Decimal(written).as_tuple().exponent
    # Half a unit of the last digit, and the rounding of the writer's own double arithmetic.
    slack = 0.5 * 10.0 ** int(exponent) + 4e-15 * frame_time
    nearest_ntsc = min(_NTSC_RATES, key=lambda rate: abs(1.0 / rate - frame_time))
    for rate in (float(round(1.0 / frame_time)), nearest_ntsc, round(1.0 / frame_time, 3)):
        if rate > 0.0 and abs(1.0 / rate - frame_time) <= slack:
            return rate
    return 1.0 / frame_time


def parse_motion(text: BvhText, *, channel_count: int) -> BvhMotion:
    """Read the motion.

    Parameters
    ----------
    text
        The file.
    channel_count
        How many channels the hierarchy declares (C).

    Raises
    ------
    FormatError
        Where the section is missing or cut short, the header lines are malformed, a row has another number of values
        or something that is no finite number, or there are more or fewer rows than declared.
    """
    if text.motion_line == len(text.lines):
        raise text.error(text.last, "the file ends before the MOTION section")
    frames_line, frames = _parse_header(text, text.motion_line + 1, r"\s*frames\s*:?\s*([^\s:]\S*)\s*", "Frames: N")
    time_line, frame_time = _parse_header(
        text, frames_line + 1, r"\s*frame\s*time\s*:?\s*([^\s:]\S*)\s*", "Frame Time: S"
    )
    frame_count = _parse_frame_count(text, frames_line, frames)
    if not _SHORTEST_FRAME_S <= parse_number(text, time_line, frame_time) <= _LONGEST_FRAME_S:
        raise text.error(time_line, f"expected a frame time above 0 seconds, found {frame_time[:40]!r}")
    if channel_count == 0:
        raise text.error(text.motion_line, "no joint has a channel, so there is no motion")
    values = _Rows(text, time_line + 1, channel_count).parse(frame_count)
    return BvhMotion(rate=frame_time_to_rate(frame_time), values=values)


def _parse_header(text: BvhText, first: int, pattern: str, form: str) -> tuple[int, str]:
    """Find the next line that is not blank; give its index and the value it holds."""
    index = next((i for i in range(first, len(text.lines)) if text.lines[i].strip()), None)
    if index is None:
        raise text.error(text.last, f"the file ends where '{form}' is expected")
    match = re.fullmatch(pattern, text.lines[index], re.IGNORECASE)
    if match is None:
        raise text.error(index, f"expected '{form}', found {text.lines[index].strip()[:40]!r}")
    return index, match.group(1)


def _parse_frame_count(text: BvhText, index: int, word: str) -> int:
    frame_count = parse_count(text, index, word, "frames")
    if frame_count == 0:
        raise text.error(index, "the file has no frames")
    return frame_count


class _Rows:
    """The rows of numbers; a frame may be wrapped over several lines but starts on its own."""

    def __init__(self, text: BvhText, first: int, channel_count: int) -> None:
        self.text = text
        self.channel_count = channel_count
        split = [line.split() for line in text.lines[first:]]
        self.lines = [first + i for i, words in enumerate(split) if words]
        self.rows = [words for words in split if words]

    def parse(self, frame_count: int) -> FloatArray:
        starts = self._find_frames(frame_count)
        self._check_frame_count(frame_count, starts)
        return self._to_numbers().reshape(frame_count, self.channel_count)

    def _find_frames(self, frame_count: int) -> list[int]:
        """Give the row each frame starts on, checking that every frame ends at the end of a row."""
        counts = [len(row) for row in self.rows]
        if all(count == self.channel_count for count in counts):
            return list(range(len(counts)))
        starts, held = [], 0
        for i, count in enumerate(counts):
            if held == 0:
                starts.append(i)
            held += count
            if held > self.channel_count:
                raise self._count_error(starts[-1], held - count or count)
            held %= self.channel_count
        if held:
            raise self._cut_error(len(starts), frame_count, held) if starts else self._count_error(0, held)
        return starts

    def _count_error(self, row: int, found: int) -> Exception:
        return self.text.error(self.lines[row], f"expected {self.channel_count} values in a frame, found {found}")

    def _cut_error(self, frames: int, frame_count: int, found: int) -> Exception:
        reason = f"truncated: frame {frames} of {frame_count} has {found} of {self.channel_count} values"
        return self.text.error(self.text.last, reason)

    def _check_frame_count(self, frame_count: int, starts: list[int]) -> None:
        if len(starts) < frame_count:
            raise self.text.error(self.text.last, f"truncated: {frame_count} frames declared, {len(starts)} found")
        if len(starts) > frame_count:
            reason = f"{frame_count} frames declared, {len(starts)} found"
            raise self.text.error(self.lines[starts[frame_count]], reason)

    def _to_numbers(self) -> FloatArray:
        try:
            numbers = np.fromiter(map(float, chain.from_iterable(self.rows)), dtype=np.float64)
        except ValueError:
            numbers = np.array([np.nan])
        if not np.all(np.abs(numbers) < np.finfo(np.float32).max):
            self._report_bad_number()
        return numbers

    def _report_bad_number(self) -> None:
        for line, row in zip(self.lines, self.rows, strict=True):
            for word in row:
                parse_number(self.text, line, word)
