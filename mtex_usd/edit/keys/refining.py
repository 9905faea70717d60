"""Poses on given keys that come as near to a motion as they can: the largest error least, not the mean.

Least squares with weights that grow where joints are turned or placed too far off (Lawson 1961). Each step is solved
for every joint by itself: what a place asks of the joints above it acts on them like a force at the place.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.keys.body import Body, angles_apart, compose, cross, distances, rotate
from mtex_usd.edit.keys.tree import add_up, find_carried

__all__ = ["Goal", "Refiner", "Spans"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

_FIRST_FORCE = 1e-2
_LEAST, _MOST = 1e-4, 1e2
_LESS, _MORE = 0.05, 3.0
_STIFFNESS = 1e-9
_PATIENCE, _BETTER = 6, 0.99  # steps without a gain
_NO_ANGLE = 1e-7


@dataclass(frozen=True, eq=False)
class Spans:
    """The frames between N keys.

    Parameters
    ----------
    frames
        Where the keys are, the first and the last frame among them, shape [N].
    pinned
        Keys that stay as they are, shape [N].
    """

    frames: IntArray
    pinned: BoolArray

    @cached_property
    def _lengths(self) -> IntArray:
        return np.append(np.diff(self.frames), 1)

    @cached_property
    def first(self) -> IntArray:
        """Which key each frame follows, shape [F]."""
        return np.repeat(np.arange(len(self.frames)), self._lengths)

    @cached_property
    def after(self) -> IntArray:
        """Which key comes then, the last again, shape [F]."""
        return np.minimum(self.first + 1, len(self.frames) - 1)

    @cached_property
    def part(self) -> FloatArray:
        """How far each frame is on the way, shape [F]."""
        return (np.arange(len(self.first)) - self.frames[self.first]) / self._lengths[self.first]

    def turn(self, turns: FloatArray) -> FloatArray:
        """Play rotations of the keys, [J, 4, N] to [J, 4, F]."""
        start, end = turns[..., self.first], turns[..., self.after]
        cosine = np.einsum("jit,jit->jt", start, end)
        angle = np.arccos(np.minimum(np.abs(cosine), 1.0))
        sine = np.sin(angle)
        near = sine < _NO_ANGLE
        safe = np.where(near, 1.0, sine)
        before = np.where(near, 1.0 - self.part, np.sin((1.0 - self.part) * angle) / safe)
        after = np.where(near, self.part, np.sin(self.part * angle) / safe) * np.where(cosine < 0.0, -1.0, 1.0)
        played = before[:, None] * start + after[:, None] * end
        return np.asarray(played / np.sqrt(np.einsum("jit,jit->jt", played, played))[:, None])

    def move(self, arms: FloatArray) -> FloatArray:
        """Play places of the keys, [J, 3, N] to [J, 3, F]."""
        return np.asarray((1.0 - self.part) * arms[..., self.first] + self.part * arms[..., self.after])

    def solve(self, weights: FloatArray, wanted: FloatArray) -> FloatArray:
        """Find changes of the keys, linear between them, that come nearest to wanted ones at the frames.

        Parameters
        ----------
        weights
            Shape [J, F].
        wanted
            Changes times weights, shape [J, 3, F].

        Returns
        -------
        FloatArray
            Shape [J, 3, N]; 0 where pinned.
        """
        from scipy.linalg import solveh_banded  # noqa: PLC0415  (slow to import, seldom used)

        start, end = 1.0 - self.part, self.part
        band, right = np.zeros((2, *weights[:, : len(self.frames)].shape)), self._sum(wanted * start)
        band[0] = self._sum(weights * start * start) + _STIFFNESS
        band[0, :, 1:] += self._sum(weights * end * end)[:, :-1]
        band[1] = self._sum(weights * start * end)
        right[..., 1:] += self._sum(wanted * end)[..., :-1]
        band[0, :, self.pinned], right[..., self.pinned] = 1.0, 0.0
        band[1, :, self.pinned | np.append(self.pinned[1:], True)] = 0.0
        rows = np.moveaxis(right, 1, 2).reshape(-1, 3)
        solved = solveh_banded(band.reshape(2, -1), rows, lower=True, check_finite=False)
        return np.moveaxis(solved.reshape(len(weights), -1, 3), 1, 2)

    def _sum(self, values: FloatArray) -> FloatArray:
        return np.asarray(np.add.reduceat(values, self.frames, axis=-1))


@dataclass(frozen=True, eq=False)
class Goal:
    """What poses have to come near to.

    Parameters
    ----------
    body
        The motion, frame by frame.
    degrees, units
        Largest angle and, in skeleton units, largest distance.
    counted
        Joints that have to be within these, shape [J].
    """

    body: Body
    degrees: float
    units: float
    counted: BoolArray

    def measure(self, played: Body) -> tuple[FloatArray, FloatArray]:
        """How many times the limits are reached by joints that count, turned and moved, both [J, F]."""
        turned = angles_apart(played.turns, self.body.turns) / self.degrees
        moved = distances(played.places, self.body.places) / self.units
        return turned * self.counted[:, None], moved * self.counted[:, None]


@dataclass(frozen=True, eq=False)
class _Weights:
    """Weights of joints' turns, [N, F], and of all joints' places, [J, F]."""

    turned: FloatArray
    moved: FloatArray

    def grow(self, turned: FloatArray, moved: FloatArray) -> None:
        """Grow where limits are passed so many times, and shrink where errors are small, in place."""
        # Where all is far off it is the larger errors that count.
        turned = turned / np.maximum(turned.max(axis=1, keepdims=True, initial=0.0) / _MORE, 1.0)
        for weights, passed in ((self.turned, turned), (self.moved, moved)):
            np.multiply(weights, np.clip(passed, _LESS, _MORE), out=weights, where=weights > 0.0)
        np.divide(self.turned, self.turned.max(axis=1, keepdims=True), out=self.turned)
        np.clip(self.turned, _LEAST, None, out=self.turned)
        np.clip(self.moved, _LEAST, _MOST, out=self.moved, where=self.moved > 0.0)


class Refiner:
    """Fits poses to one motion.

    Parameters
    ----------
    goal
        What the poses have to come near to.
    """

    def __init__(self, goal: Goal) -> None:
        self._goal = goal
        body = goal.body
        self._turning = np.flatnonzero(goal.counted & (np.ptp(body.turns, axis=-1) > 0.0).any(axis=1))
        self._moving = np.flatnonzero(goal.counted & (np.ptp(body.arms, axis=-1) > 0.0).any(axis=1))
        self._carried = find_carried(body.parents, np.float64)
        self._depths = (self._carried @ goal.counted.astype(np.float64) + 1.0)[:, None]

    def refine(self, spans: Spans, keys: Body, *, rounds: int) -> tuple[Body, FloatArray]:
        """Bring poses nearer.

        Parameters
        ----------
        spans
            Where the keys are.
        keys
            The poses, N times.
        rounds
            Steps at most; fewer where all is within the limits.

        Returns
        -------
        tuple of Body and FloatArray
            The poses, and how many times the limits are reached at every frame, shape [F].
        """
        turns, arms, weights = np.array(keys.turns), np.array(keys.arms), self._start_weights()
        played, moving = spans.turn(turns), spans.move(arms)
        best, least, patience = (keys, np.full(played.shape[-1], np.inf)), np.inf, _PATIENCE
        for _ in range(rounds):
            played[self._turning] = spans.turn(turns[self._turning])
            moving[self._moving] = spans.move(arms[self._moving])
            found = Body(keys.parents, np.array(played), np.array(moving))
            turned, moved = self._goal.measure(found)
            passed = np.maximum(turned.max(axis=0), moved.max(axis=0))
            excess = np.maximum(passed - 1.0, 0.0).sum()
            patience = _PATIENCE if excess < _BETTER * least else patience - 1
            if excess < least:
                best, least = (Body(keys.parents, np.array(turns), np.array(arms)), passed), excess
            if excess == 0.0 or patience == 0:
                break
            weights.grow(turned[self._turning], moved)
            self._step(spans, found, weights, turns, arms)
        return best

    def _start_weights(self) -> _Weights:
        counted = np.broadcast_to(self._goal.counted[:, None].astype(np.float64), self._goal.body.turns[:, 0].shape)
        return _Weights(np.ones((len(self._turning), counted.shape[1])), _FIRST_FORCE * counted)

    def _step(self, spans: Spans, found: Body, weights: _Weights, turns: FloatArray, arms: FloatArray) -> None:
        """Take one step, in place."""
        torque, resistance, force, load = self._pull(found, weights.moved)
        ahead = _turn_vectors(compose(self._goal.body.turns[self._turning], _invert(found.turns[self._turning])))
        turned = weights.turned / np.radians(self._goal.degrees) ** 2
        wanted = turned[:, None] * ahead + self._to_parents(found, torque, self._turning)
        change = spans.solve(turned + resistance[self._turning], wanted)
        turns[self._turning] = compose(_turns_of(change), turns[self._turning])
        if self._moving.size:
            arms[self._moving] += spans.solve(load[self._moving], self._to_parents(found, force, self._moving))

    def _pull(self, found: Body, weights: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Torque and resistance to it of every joint, [J, 3, F] and [J, F], then the same of forces."""
        below, centre = self._carried.T, found.places[:1]
        places, stiffness = found.places - centre, weights / self._goal.units**2
        forces = stiffness[:, None] * (self._goal.body.places - found.places)
        force, torque = add_up(below, forces, cross(places, forces))
        heavy = stiffness * self._depths
        square = np.einsum("jit,jit->jt", places, places)
        load, lever, inertia = add_up(below, heavy, heavy[:, None] * places, heavy * square)
        about = inertia - 2.0 * np.einsum("jit,jit->jt", places, lever) + square * load
        return torque - cross(places, force), np.maximum(about, 0.0), force, load

    def _to_parents(self, found: Body, vectors: FloatArray, joints: IntArray) -> FloatArray:
        """Turn vectors of some joints into their parents' axes, [J, 3, F] to [N, 3, F]."""
        parents = found.parents[joints]
        result, below = np.array(vectors[joints]), parents >= 0
        result[below] = rotate(_invert(found.total_turns[parents[below]]), result[below])
        return result


def _invert(turns: FloatArray) -> FloatArray:
    return np.asarray(turns * np.array([1.0, -1.0, -1.0, -1.0])[:, None])


def _turn_vectors(turns: FloatArray) -> FloatArray:
    """Rotation vectors in radians, [N, 4, T] to [N, 3, T]."""
    sine = np.sqrt(np.einsum("jit,jit->jt", turns[:, 1:], turns[:, 1:]))
    half = np.arctan2(sine, np.abs(turns[:, 0]))
    factor = np.where(sine > _NO_ANGLE, 2.0 * half / np.maximum(sine, _NO_ANGLE), 2.0)
    return np.asarray(turns[:, 1:] * np.where(turns[:, 0] < 0.0, -factor, factor)[:, None])


def _turns_of(vectors: FloatArray) -> FloatArray:
    """The inverse of :func:`_turn_vectors`."""
    angle = np.sqrt(np.einsum("jit,jit->jt", vectors, vectors))
    result = np.empty((len(vectors), 4, vectors.shape[-1]))
    result[:, 0] = np.cos(0.5 * angle)
    result[:, 1:] = (0.5 * np.sinc(0.5 * angle / np.pi))[:, None] * vectors
    return result
