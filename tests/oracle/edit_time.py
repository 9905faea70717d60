"""Slow twins of reading curves at any times: one value at a time, every frame beyond the ends reflected on its own."""

import math
from itertools import pairwise

import numpy as np


def value_beyond(curve, frame):
    """One value of a curve continued by point reflection half a frame beyond its ends."""
    count = len(curve)
    if 0 <= frame < count:
        return curve[frame]
    if frame < 0:
        slope_free = (curve[0] + curve[1]) / 2.0, (curve[1] + curve[min(2, count - 1)]) / 2.0
        centre = 2.0 * slope_free[0] - slope_free[1] if count > 2 else curve[0] - (curve[1] - curve[0]) / 2.0
        return 2.0 * centre - value_beyond(curve, -1 - frame)
    return value_beyond(curve[::-1], count - 1 - frame)


def low_pass_at(curve, time, speed):
    """Kaiser-windowed sinc that cuts at half the rate of frames that are so far apart, at one time."""
    reach = math.ceil(10.0 * speed)
    middle = round(time)
    total = weight = 0.0
    for frame in range(middle - reach, middle + reach + 1):
        away = (frame - time) / speed
        if abs(away) >= 10.0:
            continue
        sinc = math.sin(math.pi * away) / (math.pi * away) if away else 1.0
        tap = sinc * np.i0(5.0 * math.sqrt(1.0 - (away / 10.0) ** 2))
        total += tap * value_beyond(curve, frame)
        weight += tap
    return total / weight


def curve_points(pairs, *, count):
    """Points of the curve that a warp is, at even steps of the sum of both times; slow, from the formulas.

    Fritsch & Carlson's slopes as in the documentation of ``scipy.interpolate.PchipInterpolator``: weighted harmonic
    means. Beyond the pairs two more on either side, on lines of slope one.
    """
    reach = 1.0 + max(max(p[k] for p in pairs) - min(p[k] for p in pairs) for k in (0, 1)) / max(len(pairs) - 1, 1)
    knots = [[pairs[0][0] - r * reach, pairs[0][1] - r * reach] for r in (2, 1)]
    knots += [list(pair) for pair in pairs]
    knots += [[pairs[-1][0] + r * reach, pairs[-1][1] + r * reach] for r in (1, 2)]
    sums = [a + b for a, b in knots]
    lines = [_pchip(sums, [knot[k] for knot in knots]) for k in (0, 1)]
    at = np.linspace(sums[1], sums[-2], count)
    return np.array([[line(s) for line in lines] for s in at])


def _pchip(xs, ys):
    steps = [b - a for a, b in pairwise(xs)]
    slopes = [(b - a) / h for (a, b), h in zip(pairwise(ys), steps, strict=True)]
    inner = []
    for k in range(1, len(xs) - 1):
        first, second = 2.0 * steps[k] + steps[k - 1], steps[k] + 2.0 * steps[k - 1]
        inner.append((first + second) / (first / slopes[k - 1] + second / slopes[k]))

    def evaluate(x):
        k = min(max(sum(knot <= x for knot in xs) - 1, 1), len(xs) - 3)
        h, t = steps[k], (x - xs[k]) / steps[k]
        here, there = inner[k - 1] * h, inner[k] * h
        return (
            (1 + 2 * t) * (1 - t) ** 2 * ys[k]
            + t * (1 - t) ** 2 * here
            + t * t * (3 - 2 * t) * ys[k + 1]
            + t * t * (t - 1) * there
        )

    return evaluate
