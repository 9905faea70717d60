"""Slow twin of the choice of flipped runs: every way to call frames good or flipped is tried.

Costs in seconds: a repaired frame its duration, a border of a run where nothing jumps 1/12, 0.05 per radian between the
two sides, 2.5 per radian and frame beyond 600 degrees per second; a jump between two good frames 1. Not allowed: runs
longer than the limit, and sides that differ by more than 160 degrees.
"""

from itertools import product
from math import inf, pi, radians


def cost_of(flipped, angles, jumps, rate, longest):
    """Cost of one choice; all arguments are lists over frames, `longest` is in frames."""
    frames = len(angles)
    total = 0.0
    for frame in range(1, frames):
        if jumps[frame] and not flipped[frame] and not flipped[frame - 1]:
            total += 1.0
    if jumps[0] and not flipped[0]:
        total += 1.0
    frame = 0
    while frame < frames:
        if not flipped[frame]:
            frame += 1
            continue
        last = frame
        while last + 1 < frames and flipped[last + 1]:
            last += 1
        total += cost_of_run(frame, last, angles, jumps, rate, longest)
        frame = last + 1
    return total


def cost_of_run(first, last, angles, jumps, rate, longest):
    """Cost of one run."""
    length = last - first + 1
    if length > longest:
        return inf
    cost = length / rate
    if first == 0 or not jumps[first]:
        cost += 1.0 / 12.0
    if last == len(angles) - 1 or not jumps[last + 1]:
        cost += 1.0 / 12.0
    if first == 0 or last == len(angles) - 1:
        return cost
    gap = abs((angles[last + 1] - angles[first - 1] + pi) % (2.0 * pi) - pi)
    if gap > radians(160.0):
        return inf
    return cost + 0.05 * gap + 2.5 * max(gap / (length + 1) - radians(600.0) / rate, 0.0)


def least_cost(angles, jumps, rate, longest):
    """Cost of the cheapest choice."""
    choices = product((False, True), repeat=len(angles))
    return min(cost_of(flipped, angles, jumps, rate, longest) for flipped in choices)
