"""Slow twin of the inverse kinematics: one frame at a time by scipy's general least squares, with numeric derivatives.

The objective is the same sum of squares, errors in lengths of the limb counted a thousand times as much as radians of
change; joints are placed one by one from scipy's rotations.
"""

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

HARD = 1e3
ORDER = "ZYX"


def place_joints(parents, rotations, translations):
    """World rotations and positions of one frame: lists of J."""
    world, positions = [], []
    for joint, parent in enumerate(parents):
        if parent < 0:
            world.append(rotations[joint])
            positions.append(np.array(translations[joint]))
        else:
            world.append(world[parent] * rotations[joint])
            positions.append(positions[parent] + world[parent].apply(translations[joint]))
    return world, positions


def solve_frame(parents, rotations, translations, moving, goals, ranges=None):
    """Solve one frame.

    Rotations are J of scipy's; goals are (joint, offset, place, orientation or None, reach, weight); `ranges` gives, by
    joint, lower and upper angles in degrees about z, y and x of the skeleton, for joints that rest unturned. Returns
    rotations, distances and the objective.
    """
    ranges = ranges or {}
    base = np.array([_angles(rotations[joint]) if joint in ranges else np.zeros(3) for joint in moving])
    lower = np.array([np.radians(ranges[joint][0]) if joint in ranges else np.full(3, -np.inf) for joint in moving])
    upper = np.array([np.radians(ranges[joint][1]) if joint in ranges else np.full(3, np.inf) for joint in moving])
    lower, upper = lower - base, upper - base
    # scipy wants room between the bounds: a locked angle is left out of its unknowns.
    free = (upper - lower) > 1e-9
    fixed = np.clip(np.zeros(base.shape), np.where(free, -np.inf, lower), np.where(free, np.inf, lower))

    def pose(x):
        values = fixed.copy()
        values[free] = x
        out = list(rotations)
        for joint, angles, value in zip(moving, base, values, strict=True):
            if joint in ranges:
                out[joint] = Rotation.from_euler(ORDER, angles + value)
            else:
                out[joint] = Rotation.from_rotvec(value) * rotations[joint]
        return out, values

    def residuals(x):
        turned, values = pose(x)
        world, positions = place_joints(parents, turned, translations)
        parts = [values.ravel()]
        for joint, offset, place, orientation, reach, weight in goals:
            error = (positions[joint] + world[joint].apply(offset) - place) / reach
            parts.append(HARD * weight * error)
            if orientation is not None:
                parts.append(HARD * weight * (world[joint] * orientation.inv()).as_rotvec())
        return np.concatenate(parts)

    begin = np.clip(np.zeros(free.sum()), lower[free] + 1e-12, upper[free] - 1e-12)
    found = least_squares(
        residuals, begin, bounds=(lower[free], upper[free]), jac="3-point", xtol=1e-14, ftol=1e-14, gtol=1e-12
    )
    turned, _ = pose(found.x)
    world, positions = place_joints(parents, turned, translations)
    distances = [
        float(np.linalg.norm(positions[joint] + world[joint].apply(offset) - place))
        for joint, offset, place, *_ in goals
    ]
    return turned, distances, float(2.0 * found.cost)


def _angles(rotation):
    return rotation.as_euler(ORDER)


def cost_of(parents, before, after, translations, moving, goals, ranges=None):
    """The objective of a given answer, for comparison: twice scipy's cost."""
    ranges = ranges or {}
    total = 0.0
    for joint in moving:
        if joint in ranges:
            change = _angles(after[joint]) - _angles(before[joint])
            total += float(np.sum(np.square(change - 2.0 * np.pi * np.round(change / (2.0 * np.pi)))))
        else:
            total += float(np.sum(np.square((after[joint] * before[joint].inv()).as_rotvec())))
    world, positions = place_joints(parents, after, translations)
    for joint, offset, place, orientation, reach, weight in goals:
        error = (positions[joint] + world[joint].apply(offset) - place) / reach
        total += float(np.sum(np.square(HARD * weight * error)))
        if orientation is not None:
            total += float(np.sum(np.square(HARD * weight * (world[joint] * orientation.inv()).as_rotvec())))
    return total
