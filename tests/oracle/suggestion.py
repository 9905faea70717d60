"""Slow, obvious twins of what suggestions are measured by; nothing of the project is imported."""

import numpy as np


def _matrix(q):
    w, x, y, z = (float(value) for value in q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def place(rotations, translations, parents, joint, offset):
    """Where a point of a joint is in one pose: up the chain, one joint at a time; [J, 4], [J, 3] to [3]."""
    point = np.asarray(offset, dtype=float)
    while joint >= 0:
        point = _matrix(rotations[joint]) @ point + translations[joint]
        joint = int(parents[joint])
    return point


def mean_error(truth, result, parents, rest, filled, meters_per_unit):
    """Mean distance of the ends of filled-in bones, metres.

    `truth` and `result` are pairs of rotations [F, J, 4] and translations [F, J, 3]; `rest` the rest pose in the same
    form, one frame. The end of a bone is a child's place; a joint without children ends as far on as its own bone is
    long.
    """
    distances = []
    for frame in range(len(truth[0])):
        rotations = [result[0][frame][j] if j in filled else truth[0][frame][j] for j in range(len(parents))]
        translations = [result[1][frame][j] if j in filled else truth[1][frame][j] for j in range(len(parents))]
        for joint, offset in _ends(parents, rest, filled):
            there = place(truth[0][frame], truth[1][frame], parents, joint, offset)
            distances.append(np.linalg.norm(place(rotations, translations, parents, joint, offset) - there))
    return float(np.mean(distances)) * meters_per_unit


def _ends(parents, rest, filled):
    for joint in range(len(parents)):
        is_leaf = joint not in list(parents)
        if joint in filled and is_leaf:
            yield joint, _matrix(rest[0][joint]).T @ rest[1][joint]
        elif parents[joint] in filled:
            yield joint, np.zeros(3)


def third_difference(rotations):
    """Root mean square of the third difference of rotations [F, J, 4], taken about the first of each four poses."""
    squares = []
    for frame in range(len(rotations) - 3):
        for joint in range(rotations.shape[1]):
            first = _matrix(rotations[frame, joint]).T
            one, two, three = (_vector(first @ _matrix(rotations[frame + i, joint])) for i in (1, 2, 3))
            squares.extend((3 * one - 3 * two + three) ** 2)
    return float(np.sqrt(np.mean(squares)))


def _vector(matrix):
    angle = np.arccos(np.clip((np.trace(matrix) - 1) / 2, -1, 1))
    axis = np.array([matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1]])
    return axis * (0.5 if angle < 1e-6 else angle / (2 * np.sin(angle)))
