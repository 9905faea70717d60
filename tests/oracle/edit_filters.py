"""Slow twins of the filters of the motion editor, one curve or one joint at a time, with scipy."""

from itertools import pairwise

import numpy as np
from scipy.signal import butter, sosfiltfilt
from scipy.spatial.transform import Rotation


def lowpass(curve, frequency, rate, order):
    """Filter forward and backward a curve that is continued by point reflection over and over."""
    curve = np.asarray(curve, dtype=np.float64)
    last = len(curve) - 1
    line = curve[0] + (curve[last] - curve[0]) * np.arange(last + 1) / last
    rest = [value - level for value, level in zip(curve, line, strict=True)]
    margin = int(30.0 * rate / frequency) + 1000
    padded = []
    for frame in range(-margin, last + 1 + margin):
        place = frame % (2 * last)
        padded.append(rest[place] if place <= last else -rest[2 * last - place])
    smooth = sosfiltfilt(butter(order, frequency, fs=rate, output="sos"), padded, padlen=0)
    return line + smooth[margin : margin + last + 1]


def rolled_out(rotations):
    """Sum of the turns from frame to frame of one joint [F, 4], degrees in its own axes, [F, 3]."""
    turns = [_of(a).inv() * _of(b) for a, b in pairwise(rotations)]
    return np.cumsum([[0.0, 0.0, 0.0], *(turn.as_rotvec(degrees=True) for turn in turns)], axis=0)


def turned_by(rotations, vectors):
    """Turn each frame of one joint about its own axes, degrees."""
    return np.array(
        [
            (_of(q) * Rotation.from_rotvec(v, degrees=True)).as_quat(scalar_first=True)
            for q, v in zip(rotations, vectors, strict=True)
        ]
    )


def _of(q):
    return Rotation.from_quat(q, scalar_first=True)


def _reflected(items, frame, reflect):
    last = len(items) - 1
    if frame < 0:
        return reflect(items[0], items[-frame])
    if frame > last:
        return reflect(items[last], items[2 * last - frame])
    return items[frame]


def windows_of_values(curve, half):
    """The values around each frame, the curve continued by point reflection."""
    return [
        [_reflected(curve, k, lambda end, x: 2.0 * end - x) for k in range(frame - half, frame + half + 1)]
        for frame in range(len(curve))
    ]


def windows_of_rotations(rotations, half):
    """The rotations around each frame, each a scipy rotation."""
    items = [_of(q) for q in rotations]
    return [
        [_reflected(items, k, lambda end, x: end * x.inv() * end) for k in range(frame - half, frame + half + 1)]
        for frame in range(len(items))
    ]


def sum_of_angles(rotation, window):
    """What a median makes least, radians."""
    return sum((rotation.inv() * other).magnitude() for other in window)


def trimmed_mean(vectors, count):
    """Value at the middle of the line through vectors [N, D] less the `count` that are farthest, one by one."""
    vectors = np.asarray(vectors, dtype=np.float64)
    left = list(range(len(vectors)))
    for _ in range(count):
        mean = sum(vectors[k] for k in left) / len(left)
        left.remove(max(left, key=lambda k: np.linalg.norm(vectors[k] - mean)))
    times = np.array(left) - len(vectors) // 2
    return np.polyfit(times, vectors[left], 1)[1]


def trimmed_rotation(window, count):
    """The same of rotations, as turns from that with the least sum of angles to the others."""
    middle = min(window, key=lambda rotation: sum_of_angles(rotation, window))
    turns = [(middle.inv() * rotation).as_rotvec() for rotation in window]
    return middle * Rotation.from_rotvec(trimmed_mean(turns, count))


def mirrored_matrices(matrices, partners, across):
    """Mirror world turns since rest, [J, 3, 3], of a symmetric skeleton: reflect, with the partner's turn."""
    reflection = np.eye(3) - 2.0 * np.outer(across, across)
    return np.array([reflection @ matrices[partner] @ reflection for partner in partners])
