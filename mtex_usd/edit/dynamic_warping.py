"""Dynamic time warping in a band, with limited slopes (Sakoe & Chiba 1978), in memory of frames times band.

A path goes from pair to pair of frames by (1, 1), (1, k) or (k, 1) with k up to the largest slope, and pays for every
cell it passes: twice the distance where it enters diagonally, once for those it then runs along. So the weights along
any path sum to the frames it covers in both motions, and their mean is comparable. Every step leads to another row, so
that whole rows are computed at once.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

__all__ = ["WarpingPath", "find_path"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]


@dataclass(frozen=True, eq=False, kw_only=True)
class WarpingPath:
    """The cheapest path.

    Parameters
    ----------
    cells
        Pairs of frames, both never falling, shape [P, 2].
    cost
        Weighted mean of the distances along it.
    """

    cells: IntArray
    cost: float


@dataclass(frozen=True, eq=False)
class _Table:
    """Least costs and the steps that led there; columns count from the band's first frame in each row."""

    costs: FloatArray
    steps: npt.NDArray[np.int16]
    starts: IntArray
    last_column: int


def find_path(
    distances: Callable[[int, int, int], FloatArray],
    shape: tuple[int, int],
    *,
    band: int,
    steepest: int,
    free: int = 0,
) -> WarpingPath | None:
    """Find the cheapest path through a table of distances.

    Parameters
    ----------
    distances
        Gives the distances of a row's frame to frames begin to end (excluded) of the other motion.
    shape
        Frames of both motions.
    band
        How many frames of the other motion a path may be off the straight line, at least 1.
    steepest
        Largest slope and, inverted, the smallest; at least 1.
    free
        How many frames at each end of either motion may stay unmatched.

    Returns
    -------
    WarpingPath or None
        None where no path keeps to the band and the slopes.
    """
    table = _fill(distances, shape, band=band, steepest=steepest, free=free)
    end = _find_end(table, shape, free)
    return None if end is None else _trace(table, *end)


def _band_starts(shape: tuple[int, int], band: int) -> IntArray:
    rows, columns = shape
    straight = np.round(np.arange(rows) * ((columns - 1) / max(rows - 1, 1)))
    return straight.astype(np.intp) - band


def _fill(
    distances: Callable[[int, int, int], FloatArray], shape: tuple[int, int], *, band: int, steepest: int, free: int
) -> _Table:
    rows, columns = shape
    width = 2 * band + 1
    starts = _band_starts(shape, band)
    local = np.full((rows, width), np.inf)
    costs = np.full((rows, width), np.inf)
    steps = np.zeros((rows, width), dtype=np.int16)
    for row in range(rows):
        begin, end = max(starts[row], 0), min(starts[row] + width, columns)
        inside = slice(begin - starts[row], end - starts[row])
        local[row, inside] = distances(row, begin, end)
        _open(costs[row], local[row], row, starts[row], free)
        for step in _list_steps(steepest):
            if step[0] <= row:
                _relax(costs, steps, local, starts, row, step)
    return _Table(costs, steps, starts, columns - 1)


def _list_steps(steepest: int) -> list[tuple[int, int]]:
    return [(1, 1), *((1, k) for k in range(2, steepest + 1)), *((k, 1) for k in range(2, steepest + 1))]


def _open(costs: FloatArray, local: FloatArray, row: int, start: int, free: int) -> None:
    """Let paths begin in this row."""
    frames = start + np.arange(len(costs))
    begins = (frames == 0) & (row <= free) if row else (frames >= 0) & (frames <= free)
    costs[begins] = 2.0 * local[begins]


def _relax(
    costs: FloatArray,
    steps: npt.NDArray[np.int16],
    local: FloatArray,
    starts: IntArray,
    row: int,
    step: tuple[int, int],
) -> None:
    """Improve a row by paths that come by one kind of step."""
    down, right = step
    origin = _shifted(costs[row - down], starts[row] - starts[row - down] - right)
    enter = row - down + 1
    reached = origin + 2.0 * _shifted(local[enter], starts[row] - starts[enter] - right + 1)
    for passed in range(enter + 1, row + 1):
        reached = reached + _shifted(local[passed], starts[row] - starts[passed])
    for back in range(right - 1):
        reached = reached + _shifted(local[row], -back)
    better = reached < costs[row]
    costs[row][better] = reached[better]
    steps[row][better] = down * 256 + right


def _shifted(values: FloatArray, by: int) -> FloatArray:
    """Give values[c + by] for every column c, infinite where there is none."""
    out = np.full_like(values, np.inf)
    low, high = max(0, -by), min(len(values), len(values) - by)
    if low < high:
        out[low:high] = values[low + by : high + by]
    return out


def _find_end(table: _Table, shape: tuple[int, int], free: int) -> tuple[int, int] | None:
    """Give the row and column where the cheapest complete path ends."""
    rows, columns = shape
    frames = table.starts[:, None] + np.arange(table.costs.shape[1])
    row_numbers = np.arange(rows)[:, None]
    last_row = (row_numbers == rows - 1) & (frames >= columns - 1 - free) & (frames < columns)
    last_column = (frames == columns - 1) & (row_numbers >= rows - 1 - free)
    ends = np.where(last_row | last_column, table.costs, np.inf)
    best = int(np.argmin(ends))
    row, column = divmod(best, ends.shape[1])
    return (row, column) if np.isfinite(ends[row, column]) else None


def _trace(table: _Table, row: int, column: int) -> WarpingPath:
    total, last = float(table.costs[row, column]), (row, int(table.starts[row]) + column)
    cells = [last]
    while table.steps[row, column]:
        down, right = divmod(int(table.steps[row, column]), 256)
        frame = int(table.starts[row]) + column
        # From the last cell of the step back to the one it was entered by.
        cells += [(row - k, frame) for k in range(1, down)] + [(row, frame - k) for k in range(1, right)]
        row, frame = row - down, frame - right
        column = frame - int(table.starts[row])
        cells.append((row, frame))
    begin = cells[-1]
    weight = last[0] - begin[0] + last[1] - begin[1] + 2
    return WarpingPath(cells=np.array(cells[::-1], dtype=np.intp), cost=total / weight)
