"""Slow twin of the spacetime solve: the same splines, everything dense, left to scipy.optimize's SLSQP.

Lengths are metres, angles radians. Nothing is imported from the package; rotations are scipy's. The places of points
that keep still are no unknowns here: every frame is compared with the first.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import BSpline
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

RIDGE = 1e-8
STEP = 1e-6


@dataclass(frozen=True, eq=False, kw_only=True)
class Motion:
    """One character: parent indices, rotations [F, J, 4] real first, translations [F, J, 3], and what may move."""

    parents: list
    rotations: np.ndarray
    translations: np.ndarray
    turning: list
    root: int

    @property
    def channels(self):
        return 3 * len(self.turning) + 3

    def points(self, changes, joint, offset):
        """A point of a joint at every frame, for changes [F, C]."""
        orientation, position = self.place(changes, joint)
        return position + orientation.apply(np.tile(offset, (len(position), 1)))

    def place(self, changes, joint):
        """Orientation and position of a joint, by recursion."""
        local = Rotation.from_quat(self.rotations[:, joint], scalar_first=True)
        offset = self.translations[:, joint]
        if joint in self.turning:
            first = 3 * self.turning.index(joint)
            local = local * Rotation.from_rotvec(changes[:, first : first + 3])
        if joint == self.root:
            offset = offset + changes[:, -3:]
        if self.parents[joint] < 0:
            return local, offset
        above, origin = self.place(changes, self.parents[joint])
        return above * local, origin + above.apply(offset)


def residuals(motion, changes, constraint):
    """Numbers that shall be zero, or not below zero for "above"; a row per number, with the frames it is about."""
    kind, joint, offset, frames, *rest = constraint
    points = motion.points(changes, joint, offset)[frames]
    if kind == "at":
        return (points - rest[0]).ravel()
    if kind == "still":
        return (points[1:] - points[0]).ravel()
    if kind == "above":
        normal, height = rest
        return points @ normal - height
    if kind == "apart":
        other_joint, other_offset, distance = rest
        other = motion.points(changes, other_joint, other_offset)[frames]
        return np.linalg.norm(points - other, axis=1) - distance
    raise ValueError(kind)


def derivatives(motion, changes, constraint):
    """Of the residuals by all changes, dense [N, F, C], by central differences of all frames of a channel at once."""
    count = len(residuals(motion, changes, constraint))
    frames = np.asarray(constraint[3])
    out = np.zeros((count, *changes.shape))
    for channel in range(changes.shape[1]):
        if constraint[0] == "still":
            _still(out, motion, changes, constraint, channel)
            continue
        more, less = np.array(changes), np.array(changes)
        more[:, channel] += STEP
        less[:, channel] -= STEP
        slope = (residuals(motion, more, constraint) - residuals(motion, less, constraint)) / (2.0 * STEP)
        out[np.arange(count), np.repeat(frames, count // len(frames)), channel] = slope
    return out


def _still(out, motion, changes, constraint, channel):
    _, joint, offset, frames = constraint
    more, less = np.array(changes), np.array(changes)
    more[:, channel] += STEP
    less[:, channel] -= STEP
    slope = (motion.points(more, joint, offset) - motion.points(less, joint, offset)) / (2.0 * STEP)
    for row, frame in enumerate(frames[1:]):
        for axis in range(3):
            out[3 * row + axis, frame, channel] = slope[frame, axis]
            out[3 * row + axis, frames[0], channel] -= slope[frames[0], axis]


def cost_matrix(extended, frame_count, smoothness, cycles_per_frame):
    """Of one channel: squares over the frames plus the integral of the second derivative's square."""
    count = len(extended) - 4
    spline = BSpline(extended, np.eye(count), 3)
    basis = spline(np.arange(frame_count))
    matrix = basis.T @ basis
    matrix += RIDGE * np.trace(matrix) / count * np.eye(count)
    bent = spline.derivative(2)
    for begin, end in pairwise(extended[3:-3]):
        # The second derivative is a line on each span, so Simpson's rule is exact for its square.
        ends = bent(np.array([begin + 1e-12, 0.5 * (begin + end), end - 1e-12]))
        parts = [share * np.outer(row, row) for share, row in zip((1.0, 4.0, 1.0), ends, strict=True)]
        matrix += smoothness / (2.0 * np.pi * cycles_per_frame) ** 4 * (end - begin) / 6.0 * sum(parts)
    return basis, matrix


def solve(motion, constraints, extended, weights, *, smoothness, cycles_per_frame, tolerance=1e-12):
    """Give the coefficients [K, C] of the least change, its cost, and the residuals left."""
    frame_count = len(motion.rotations)
    basis, matrix = cost_matrix(extended, frame_count, smoothness, cycles_per_frame)
    shape = (basis.shape[1], motion.channels)

    def cost(x):
        coefficients = x.reshape(shape)
        slope = matrix @ coefficients * weights
        return 0.5 * float(np.sum(coefficients * slope)), slope.ravel()

    def rows(x, constraint):
        return residuals(motion, basis @ x.reshape(shape), constraint)

    def slopes(x, constraint):
        by_change = derivatives(motion, basis @ x.reshape(shape), constraint)
        return np.einsum("nfc,fk->nkc", by_change, basis).reshape(len(by_change), -1)

    listed = [
        {"type": "ineq" if c[0] == "above" else "eq", "fun": rows, "jac": slopes, "args": (c,)} for c in constraints
    ]
    options = {"maxiter": 500, "ftol": tolerance}
    found = minimize(cost, np.zeros(np.prod(shape)), jac=True, method="SLSQP", constraints=listed, options=options)
    left = np.concatenate([rows(found.x, c) for c in constraints])
    return found.x.reshape(shape), found.fun, left
