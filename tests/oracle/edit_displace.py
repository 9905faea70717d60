"""Slow twin of motion warping: a clamped cubic spline solved as one dense system, one frame at a time."""

import numpy as np
from scipy.spatial.transform import Rotation


def clamped_spline(frames, values, frame):
    """Value at a frame of the cubic spline through keys with no slope at its ends, held beyond them."""
    count = len(frames)
    if count == 1:
        return values[0]
    frame = min(max(frame, frames[0]), frames[-1])
    steps = np.diff(frames)
    system, right = np.eye(count), np.zeros((count, 3))
    for k in range(1, count - 1):
        # Equal bend on both sides of a key.
        system[k, k - 1 : k + 2] = [1 / steps[k - 1], 2 / steps[k - 1] + 2 / steps[k], 1 / steps[k]]
        right[k] = 3 * ((values[k] - values[k - 1]) / steps[k - 1] ** 2 + (values[k + 1] - values[k]) / steps[k] ** 2)
    slopes = np.linalg.solve(system, right)
    k = min(int(np.searchsorted(frames, frame, side="right")) - 1, count - 2)
    h, t = steps[k], (frame - frames[k]) / steps[k]
    return (
        (1 + 2 * t) * (1 - t) ** 2 * values[k]
        + t * (1 - t) ** 2 * h * slopes[k]
        + t * t * (3 - 2 * t) * values[k + 1]
        + t * t * (t - 1) * h * slopes[k + 1]
    )


def turned(rotation, orientation, degrees):
    """A joint's local rotation after a turn given about the skeleton's axes; orientation is the joint's at rest."""
    vector = Rotation.from_quat(orientation, scalar_first=True).inv().apply(np.radians(degrees))
    return (Rotation.from_quat(rotation, scalar_first=True) * Rotation.from_rotvec(vector)).as_quat(scalar_first=True)
