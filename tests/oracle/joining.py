"""Slow twin of joining, for one curve, written from Pullen & Bregler 2002, section 3.4, the misprint mended."""

import math


def join(fragments, continued, join_frames):
    """Join fragments of one curve; neighbours share a frame.

    Fragments are lists of numbers; continued says of each join whether the two were consecutive in their take.
    """
    moved = [skew(fragment, *_new_ends(fragments, i)) for i, fragment in enumerate(fragments)]
    joined = list(moved[0])
    for fragment in moved[1:]:
        joined += fragment[1:]
    at = 0
    for i in range(len(fragments) - 1):
        at += len(fragments[i]) - 1
        shorter = min(len(fragments[i]), len(fragments[i + 1]))
        reach = min(join_frames, (shorter - 1) // 2)
        if reach >= 3 and not continued[i]:
            smooth_join(joined, at, reach)
    return joined


def _new_ends(fragments, i):
    """Mean of the meeting points; the ends of the whole stay."""
    first, last = fragments[i][0], fragments[i][-1]
    if i > 0:
        first = (fragments[i - 1][-1] + first) / 2.0
    if i < len(fragments) - 1:
        last = (last + fragments[i + 1][0]) / 2.0
    return first, last


def skew(fragment, new_first, new_last):
    """Subtract the line through the old end points and add the line through the new ones."""
    steps = len(fragment) - 1
    out = []
    for t, value in enumerate(fragment):
        old_line = fragment[0] + (fragment[-1] - fragment[0]) * t / steps
        new_line = new_first + (new_last - new_first) * t / steps
        out.append(value - old_line + new_line)
    return out


def smooth_join(joined, at, reach):
    """Blend in the quadratic fitted to the frames with 2 <= |t| <= N."""
    times = [t for t in range(-reach, reach + 1) if abs(t) >= 2]
    c0, c1, c2 = fit_quadratic(times, [joined[at + t] for t in times])
    for t in range(-reach, reach + 1):
        weight = math.cos(math.pi * t / (2 * reach)) ** 2
        joined[at + t] = weight * (c0 + c1 * t + c2 * t * t) + (1.0 - weight) * joined[at + t]


def fit_quadratic(times, values):
    """Least squares by the normal equations; the times lie evenly about zero, so odd moments vanish."""
    n = len(times)
    s2 = sum(t * t for t in times)
    s4 = sum(t**4 for t in times)
    v0 = sum(values)
    v1 = sum(t * v for t, v in zip(times, values, strict=True))
    v2 = sum(t * t * v for t, v in zip(times, values, strict=True))
    determinant = n * s4 - s2 * s2
    return (v0 * s4 - v2 * s2) / determinant, v1 / s2, (v2 * n - v0 * s2) / determinant
