"""Slow twin of resampling: the filter of resample_poly's documentation, one output at a time.

Written from the documentation of ``scipy.signal.resample_poly`` (default window ``("kaiser", 5.0)``, half length
``10 * max(up, down)`` on the grid of both rates) and of ``scipy.signal.firwin``.
"""

import math

import numpy as np


def low_pass_taps(up, down):
    """Give the Kaiser-windowed sinc on the grid that both rates share, its sum scaled to up."""
    half = 10 * max(up, down)
    window = np.kaiser(2 * half + 1, 5.0)
    taps = []
    for i in range(-half, half + 1):
        angle = math.pi * i / max(up, down)
        taps.append((math.sin(angle) / angle if i else 1.0) * window[i + half])
    total = math.fsum(taps)
    return [tap * up / total for tap in taps]


def reduce_curve(curve, up, down):
    """Resample one curve by up/down (below 1), continued along the line through its ends."""
    taps = low_pass_taps(up, down)
    half = len(taps) // 2
    last = len(curve) - 1
    slope = (curve[-1] - curve[0]) / last
    bent = [value - curve[0] - slope * frame for frame, value in enumerate(curve)]
    out = []
    for k in range(last * up // down + 1):
        total = 0.0
        for frame, value in enumerate(bent):
            tap = k * down - frame * up  # on the shared grid
            if abs(tap) <= half:
                total += taps[tap + half] * value
        out.append(total + curve[0] + slope * k * down / up)
    return out
