"""What the constraints look at: points and joint orientations of the characters at frames, with derivatives."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mtex_usd.constraints.spacetime.character import Character, Pose, Posing
from mtex_usd.constraints.spacetime.turning import cross_matrix
from mtex_usd.motion.skeleton import FloatArray, IntArray

__all__ = ["Handle", "Observer", "State", "Watch"]


@dataclass(frozen=True)
class Handle:
    """A weighted sum of points fixed to joints of one character: one point, or the centre of mass.

    Parameters
    ----------
    clip
        Number of the character.
    joints
        The joints, length H.
    weights
        What each point counts, length H.
    offsets
        Where each is in its joint's space, metres, length H.
    """

    clip: int
    joints: tuple[int, ...]
    weights: tuple[float, ...] = (1.0,)
    offsets: tuple[tuple[float, float, float], ...] = ((0.0, 0.0, 0.0),)


@dataclass(frozen=True, eq=False)
class Watch:
    """One handle, or one joint's orientation, at some frames.

    Parameters
    ----------
    handle
        What is watched; for an orientation the single joint counts.
    at
        Positions of its frames among those evaluated, [N].
    """

    handle: Handle
    at: IntArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Observer:
    """Everything that is watched in one problem.

    Parameters
    ----------
    posings
        The characters, at the U frames that are evaluated.
    points, turns
        Points and orientations, whose samples are counted in this order.
    frames
        The frames that are evaluated, [U].
    column_count
        Channels of the whole problem, C.
    """

    posings: tuple[Posing, ...]
    points: tuple[Watch, ...]
    turns: tuple[Watch, ...]
    frames: IntArray
    column_count: int

    def observe(self, changes: FloatArray, places: FloatArray) -> "State":
        """Displace all characters by channels [U, C]; free places [Q, 3] in metres."""
        poses = tuple(posing.pose(changes) for posing in self.posings)
        return State(observer=self, poses=poses, places=places)


@dataclass(frozen=True, eq=False, kw_only=True)
class State:
    """The samples for one displacement; S points and T orientations."""

    observer: Observer
    poses: tuple[Pose, ...]
    places: FloatArray

    @cached_property
    def _parts(self) -> list[FloatArray]:
        return [_part_positions(self.poses[w.handle.clip], w) for w in self.observer.points]

    @cached_property
    def positions(self) -> FloatArray:
        """Points in metres, [S, 3]."""
        sums = [np.array(w.handle.weights) @ p for w, p in zip(self.observer.points, self._parts, strict=True)]
        return _stack(sums, (3,))

    @cached_property
    def position_jacobians(self) -> FloatArray:
        """Their derivatives by the channels, [S, 3, C]."""
        columns = self.observer.column_count
        out = np.zeros((len(self.positions), 3, columns))
        first = 0
        for watch, parts in zip(self.observer.points, self._parts, strict=True):
            _fill_moves(out[first : first + len(watch.at)], self.poses[watch.handle.clip], watch, parts)
            first += len(watch.at)
        return out

    @cached_property
    def orientations(self) -> FloatArray:
        """Orientations in skeleton space, matrices [T, 3, 3]."""
        found = [self.poses[w.handle.clip].world[w.at, w.handle.joints[0]] for w in self.observer.turns]
        return _stack(found, (3, 3))

    @cached_property
    def turn_jacobians(self) -> FloatArray:
        """How fast they turn, in skeleton space, by the channels, [T, 3, C]."""
        out = np.zeros((len(self.orientations), 3, self.observer.column_count))
        first = 0
        for watch in self.observer.turns:
            pose = self.poses[watch.handle.clip]
            slots = np.flatnonzero(_carried(pose.character, watch.handle).any(axis=1))
            axes = pose.axes[watch.at[:, None], slots]
            out[first : first + len(watch.at), :, pose.character.rotation_columns(slots)] = _by_column(axes)
            first += len(watch.at)
        return out

    def bend(self, point_pulls: FloatArray, turn_pulls: FloatArray) -> FloatArray:
        """Second derivatives by the channels of all samples, each weighed by a pull.

        Parameters
        ----------
        point_pulls, turn_pulls
            Weights of the points' coordinates [S, 3] and of the orientations' turns in skeleton space [T, 3].

        Returns
        -------
        FloatArray
            Symmetric matrices, one per evaluated frame, [U, C, C].

        Notes
        -----
        Exact where a joint is not displaced yet; the second derivative of a joint's own rotation vector elsewhere is
        left out. It steers the search and decides nothing.
        """
        columns = self.observer.column_count
        out = np.zeros((len(self.observer.frames), columns, columns))
        for watches, pulls, moves, share in (
            (self.observer.points, point_pulls, self.position_jacobians, 1.0),
            (self.observer.turns, turn_pulls, self.turn_jacobians, 0.5),
        ):
            first = 0
            for watch in watches:
                part = slice(first, first + len(watch.at))
                if pulls[part].any():
                    _add_bend(out, self.poses[watch.handle.clip], watch, share * pulls[part], moves[part])
                first = part.stop
        return out


def _add_bend(out: FloatArray, pose: Pose, watch: Watch, pulls: FloatArray, moves: FloatArray) -> None:
    """Add what turning one joint does to the derivative by another below it."""
    character = pose.character
    slots = np.flatnonzero(_carried(character, watch.handle).any(axis=1))
    columns = character.rotation_columns(slots)
    joints = _joints(character, slots)
    axes = _by_column(pose.axes[watch.at[:, None], slots])
    levers = np.swapaxes(cross_matrix(pulls) @ axes, 1, 2) @ moves[:, :, columns]
    above = character.above[np.ix_(joints, joints)] - 0.5 * np.eye(len(joints))
    levers *= np.repeat(np.repeat(above, 3, axis=0), 3, axis=1)
    out[watch.at[:, None, None], columns[:, None], columns] += levers + np.swapaxes(levers, 1, 2)


def _stack(parts: Sequence[FloatArray], shape: tuple[int, ...]) -> FloatArray:
    return np.concatenate(parts) if parts else np.zeros((0, *shape))


def _part_positions(pose: Pose, watch: Watch) -> FloatArray:
    """Positions of a handle's points, [N, H, 3]."""
    index = (watch.at[:, None], np.array(watch.handle.joints))
    offsets = np.array(watch.handle.offsets)
    if not offsets.any():
        return np.asarray(pose.origins[index])
    return np.asarray(pose.origins[index] + (pose.world[index] @ offsets[:, :, None])[..., 0])


def _fill_moves(out: FloatArray, pose: Pose, watch: Watch, parts: FloatArray) -> None:
    """Derivatives of a handle at its frames into [N, 3, C]."""
    character, weights = pose.character, np.array(watch.handle.weights)
    carried = _carried(character, watch.handle)
    slots = np.flatnonzero(carried.any(axis=1))
    shares = carried[slots] * weights
    levers = shares @ parts - shares.sum(axis=1)[:, None] * pose.origins[watch.at[:, None], _joints(character, slots)]
    moves = cross_matrix(-levers) @ pose.axes[watch.at[:, None], slots]
    out[:, :, character.rotation_columns(slots)] = _by_column(moves)
    if character.root >= 0:
        share = weights @ character.above[character.root, list(watch.handle.joints)]
        out[:, :, character.translation_columns] = share * pose.root_axes[watch.at]


def _carried(character: Character, handle: Handle) -> FloatArray:
    """Whether each turning joint carries each point, [A, H]."""
    turning = np.array(character.turning, dtype=np.intp)
    return np.asarray(character.above[np.ix_(turning, np.array(handle.joints))])


def _joints(character: Character, slots: IntArray) -> IntArray:
    return np.array(character.turning, dtype=np.intp)[slots]


def _by_column(axes: FloatArray) -> FloatArray:
    """Matrices per joint [N, A, 3, 3] side by side, [N, 3, 3 A]."""
    return np.swapaxes(axes, 1, 2).reshape(len(axes), 3, -1)
