"""Slow twins of blending: scipy's rotations, one joint of one frame at a time."""

import numpy as np
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation


def between(a, b, weight):
    """The rotation so far on the way from one quaternion to another (real first), or beyond."""
    one, other = (Rotation.from_quat(q, scalar_first=True) for q in (a, b))
    way = (one.inv() * other).as_rotvec()
    return (one * Rotation.from_rotvec(weight * way)).as_quat(scalar_first=True)


def mean_rotation(quaternions, weights):
    """The rotation with the least weighted sum of squared angles to all, found by a general minimiser."""
    rotations = [Rotation.from_quat(q, scalar_first=True) for q in quaternions]
    start = rotations[int(np.argmax(weights))]

    def cost(vector):
        guess = start * Rotation.from_rotvec(vector)
        return sum(w * (guess.inv() * r).magnitude() ** 2 for w, r in zip(weights, rotations, strict=True))

    found = minimize(cost, np.zeros(3), method="BFGS", options={"gtol": 1e-9})
    return (start * Rotation.from_rotvec(found.x)).as_quat(scalar_first=True)


def walk_on(headings, positions, weights):
    """Places on the floor (x and z, Y up) that motions lead to whose turns and steps are mixed, frame by frame.

    Headings [N, F] turn +z towards +x, positions are [N, F, 3], weights [F, N].
    """
    heading = sum(w * h[0] for w, h in zip(weights[0], headings, strict=True))
    place = sum(w * p[0] for w, p in zip(weights[0], positions, strict=True))[[0, 2]]
    places = [place]
    for frame in range(1, len(weights)):
        weight = (weights[frame] + weights[frame - 1]) / 2.0
        turn = sum(w * (h[frame] - h[frame - 1]) for w, h in zip(weight, headings, strict=True))
        ahead = aside = 0.0
        for w, h, p in zip(weight, headings, positions, strict=True):
            facing = (h[frame] + h[frame - 1]) / 2.0
            dx, _, dz = p[frame] - p[frame - 1]
            ahead += w * (dx * np.sin(facing) + dz * np.cos(facing))
            aside += w * (dx * np.cos(facing) - dz * np.sin(facing))
        facing = heading + turn / 2.0
        heading = heading + turn
        place = place + np.array(
            [ahead * np.sin(facing) + aside * np.cos(facing), ahead * np.cos(facing) - aside * np.sin(facing)]
        )
        places.append(place)
    return np.array(places)
