"""Slow twins of comparing motions: dynamic time warping by recursion, transitions by trying every pair of frames."""

import math
from functools import cache

import numpy as np


def warping_cost(distances, *, band, steepest, free=0):
    """Least weighted mean distance of a path through a table [N, M], by recursion over every way to every cell."""
    rows, columns = distances.shape

    def allowed(i, j):
        return 0 <= i < rows and 0 <= j < columns and abs(j - round(i * (columns - 1) / (rows - 1))) <= band

    @cache
    def ways(i, j):
        """The cheapest total to a cell, and where that path began."""
        found = []
        if (i == 0 and j <= free) or (j == 0 and i <= free):
            found.append((2.0 * distances[i, j], (i, j)))
        for k in range(1, steepest + 1):
            for down, right in {(1, k), (k, 1)}:
                if not allowed(i - down, j - right):
                    continue
                cells = [(i - down + 1, j - right + 1)]
                cells += [(i - d, j) for d in range(down - 1)] if down > 1 else []
                cells += [(i, j - r) for r in range(right - 1)] if right > 1 else []
                if not all(allowed(*cell) for cell in cells):
                    continue
                before, begin = ways(i - down, j - right)
                entered, passed = cells[0], cells[1:]
                found.append((before + 2.0 * distances[entered] + sum(distances[cell] for cell in passed), begin))
        return min(found, default=(math.inf, (0, 0)))

    ends = [(i, columns - 1) for i in range(rows - 1 - free, rows)]
    ends += [(rows - 1, j) for j in range(columns - 1 - free, columns)]
    best = min(((*ways(*end), end) for end in ends if allowed(*end)), default=(math.inf, (0, 0), (0, 0)))
    total, begin, end = best
    return total / (end[0] - begin[0] + end[1] - begin[1] + 2)


def best_transition(one, other, *, rate, half, least=None):
    """Frames where two motions are most alike, and how far apart: positions [F, J, 3] and [G, J, 3] in metres."""
    moments = sorted({round(k) for k in np.linspace(-half, half, 9)})
    speeds = [np.gradient(each, axis=0) * rate * 0.1 for each in (one, other)]
    best = (math.inf, 0, 0)
    for i in range(half, len(one) - half):
        for j in range(half, len(other) - half):
            if least is not None and i - j < least:
                continue
            total = 0.0
            for k in moments:
                for joint in range(one.shape[1]):
                    total += np.sum((one[i + k, joint] - other[j + k, joint]) ** 2) / one.shape[1]
                    total += np.sum((speeds[0][i + k, joint] - speeds[1][j + k, joint]) ** 2) / one.shape[1]
            best = min(best, (math.sqrt(total / len(moments)), i, j))
    return best
