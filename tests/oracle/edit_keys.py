"""Slow twins of key reduction: dense least squares, curves by De Casteljau, poses by scipy's slerp."""

from itertools import pairwise

import numpy as np
from scipy.spatial.transform import Rotation, Slerp


def fit_hermite(samples, keys, pinned, broken, stiffness):
    """Fit one curve; keys, pinned and broken are lists of sample numbers. Gives the curve at the samples."""
    unknowns = {}
    for key in keys:
        unknowns[key, "value"] = len(unknowns)
        unknowns[key, "after"] = len(unknowns)
        unknowns[key, "before"] = len(unknowns) if key in broken else unknowns[key, "after"]
    rows, right = [], []
    for start, end in pairwise(keys):
        length = end - start
        names = ((start, "value"), (start, "after"), (end, "value"), (end, "before"))
        for sample in range(start, end):
            _add_row(rows, right, unknowns, names, _basis((sample - start) / length, length), samples[sample])
        # The integral of the squared second derivative, exact by Gauss with two points.
        for u in (0.5 - np.sqrt(1.0 / 12.0), 0.5 + np.sqrt(1.0 / 12.0)):
            bend = np.array([12 * u - 6, (6 * u - 4) * length, 6 - 12 * u, (6 * u - 2) * length]) / length**2
            _add_row(rows, right, unknowns, names, bend * np.sqrt(0.5 * length * stiffness), 0.0)
    _add_row(rows, right, unknowns, ((keys[-1], "value"),), [1.0], samples[keys[-1]])
    matrix, right = np.array(rows), np.array(right)
    held = {unknowns[key, "value"]: samples[key] for key in pinned}
    free = [place for place in range(matrix.shape[1]) if place not in held]
    right = right - sum(matrix[:, place] * value for place, value in held.items())
    solved = np.zeros(matrix.shape[1])
    solved[list(held)] = list(held.values())
    solved[free] = np.linalg.lstsq(matrix[:, free], right, rcond=None)[0]
    curve = []
    for sample in range(len(samples)):
        number = min(max(k for k, key in enumerate(keys) if key <= sample), len(keys) - 2)
        start, end = keys[number], keys[number + 1]
        names = ((start, "value"), (start, "after"), (end, "value"), (end, "before"))
        weights = _basis((sample - start) / (end - start), end - start)
        curve.append(sum(w * solved[unknowns[name]] for w, name in zip(weights, names, strict=True)))
    return np.array(curve)


def _add_row(rows, right, unknowns, names, weights, value):
    width = max(unknowns.values()) + 1
    row = np.zeros(width)
    for name, weight in zip(names, weights, strict=True):
        row[unknowns[name]] += weight
    rows.append(row)
    right.append(value)


def _basis(u, length):
    return [
        2 * u**3 - 3 * u**2 + 1,
        (u**3 - 2 * u**2 + u) * length,
        3 * u**2 - 2 * u**3,
        (u**3 - u**2) * length,
    ]


def evaluate_bezier(times, values, before, after, time):
    """Evaluate a curve of keys with tangents a third of the interval wide, by De Casteljau."""
    if time <= times[0]:
        return values[0]
    if time >= times[-1]:
        return values[-1]
    k = max(i for i, t in enumerate(times) if t <= time)
    width = (times[k + 1] - times[k]) / 3.0
    points = [values[k], values[k] + width * after[k], values[k + 1] - width * before[k + 1], values[k + 1]]
    u = (time - times[k]) / (times[k + 1] - times[k])
    while len(points) > 1:
        points = [(1.0 - u) * a + u * b for a, b in pairwise(points)]
    return points[0]


def play_rotations(frames, rotations, times):
    """Slerp one joint's keys [N, 4] at times in frames, [T, 4]."""
    if len(frames) == 1:
        return np.tile(rotations, (len(times), 1))
    return Slerp(frames, Rotation.from_quat(rotations, scalar_first=True))(times).as_quat(scalar_first=True)


def angles_between(a, b):
    """Angles in degrees of rotations [..., 4]."""
    turn = Rotation.from_quat(a.reshape(-1, 4), scalar_first=True).inv() * Rotation.from_quat(
        b.reshape(-1, 4), scalar_first=True
    )
    return np.degrees(turn.magnitude()).reshape(a.shape[:-1])


def place_joints(parents, rotations, translations):
    """Forward kinematics of one frame with matrices, [J, 4] and [J, 3] to [J, 3]."""
    world, places = [], []
    for joint, parent in enumerate(parents):
        matrix = Rotation.from_quat(rotations[joint], scalar_first=True).as_matrix()
        if parent < 0:
            world.append(matrix)
            places.append(translations[joint])
        else:
            places.append(places[parent] + world[parent] @ translations[joint])
            world.append(world[parent] @ matrix)
    return np.array(places)


def line_error(values):
    """The least largest distance of a straight line from values at even steps: half the worst bulge of any three."""
    count = len(values)
    bulges = [
        abs(values[j] - values[i] - (values[k] - values[i]) * (j - i) / (k - i))
        for i in range(count)
        for j in range(i + 1, count)
        for k in range(j + 1, count)
    ]
    return max(bulges, default=0.0) / 2.0


def fewest_keys(possible, frames):
    """Fewest keys from the first frame to the last where possible(start, end) tells which stretches there may be."""
    fewest = [1] + [frames + 1] * (frames - 1)
    for end in range(1, frames):
        fewest[end] = 1 + min(fewest[start] for start in range(end) if end - start == 1 or possible(start, end))
    return fewest[-1]


def fit_linear_keys(rotations, frames):
    """Play the quaternions [F, 4] that linear interpolation between keys makes nearest in the least-squares sense."""
    count, signs = len(rotations), np.ones(len(rotations))
    for frame in range(1, count):
        signs[frame] = signs[frame - 1] * (1.0 if rotations[frame] @ rotations[frame - 1] >= 0.0 else -1.0)
    hats = np.array([np.interp(np.arange(count), frames, row) for row in np.eye(len(frames))]).T
    keys = np.linalg.lstsq(hats, rotations * signs[:, None], rcond=None)[0]
    return play_rotations(frames, keys / np.linalg.norm(keys, axis=1, keepdims=True), np.arange(count))
