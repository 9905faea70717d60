"""Constraints as rows of numbers: what is asked of a point, a distance, an orientation or a joint's angles at a frame.

Every kind of constraint comes down to these few tables, each evaluated for all constraints at once. A row is one number
that shall be zero, or not above zero, with its derivative by the problem's channels at its frame.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.spacetime.samples import State
from mtex_usd.constraints.spacetime.turning import inverse_right_jacobian, log_vector
from mtex_usd.motion.skeleton import FloatArray, IntArray

__all__ = ["DistanceTable", "OrientationTable", "PointTable", "RowInfo", "Table", "concatenate", "no_rows", "reorder"]

BoolArray = npt.NDArray[np.bool_]
_NO_LENGTH = 1e-12  # metres


@dataclass(frozen=True, eq=False, kw_only=True)
class RowInfo:
    """What the solver has to know of rows besides their values; each field has shape [R] but for the normals.

    Parameters
    ----------
    frame
        The frame each row is about.
    owner
        Number of the constraint each row is from.
    group
        Rows with the same number are the parts of one vector, whose length is what the tolerance is about.
    tolerance
        How far from met it may be, metres or radians.
    length
        Whether it is in metres; else in radians.
    inequality
        Whether it may be below zero.
    place
        Number of the free place the row's point shall be at; -1 for none.
    normal
        Direction along which that place counts, [R, 3].
    """

    frame: IntArray
    owner: IntArray
    group: IntArray
    tolerance: FloatArray
    length: BoolArray
    inequality: BoolArray
    place: IntArray
    normal: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Table(ABC):
    """Rows of one kind.

    Parameters
    ----------
    info
        What the solver has to know of them.
    """

    info: RowInfo

    @abstractmethod
    def residual(self, state: State) -> FloatArray:
        """Values [R]: zero where met; for inequalities zero or below."""

    @abstractmethod
    def jacobian(self, state: State) -> FloatArray:
        """Derivatives by the problem's channels at the rows' frames, [R, C]."""

    def pull_points(self, state: State, multipliers: FloatArray, points: FloatArray) -> None:  # noqa: B027
        """Add what rows, weighed by multipliers [R], pull at points [S, 3]."""

    def pull_turns(self, state: State, multipliers: FloatArray, turns: FloatArray) -> None:  # noqa: B027
        """Add what rows, weighed by multipliers [R], turn at orientations [T, 3]."""

    def curve(self, state: State, multipliers: FloatArray, bends: FloatArray) -> None:  # noqa: B027
        """Add second derivatives [U, C, C] by what is watched, as far as rows are not linear in it."""


def no_rows() -> RowInfo:
    """Describe no rows at all."""
    whole, real, truth = np.zeros(0, dtype=np.intp), np.zeros(0), np.zeros(0, dtype=np.bool_)
    return RowInfo(
        frame=whole,
        owner=whole,
        group=whole,
        tolerance=real,
        length=truth,
        inequality=truth,
        place=whole,
        normal=np.zeros((0, 3)),
    )


def reorder(info: RowInfo, order: IntArray) -> RowInfo:
    """Choose rows by their numbers."""
    return RowInfo(**{field.name: getattr(info, field.name)[order] for field in fields(info)})


T = TypeVar("T")


def concatenate(pieces: list[T]) -> T:
    """Put tables, or any dataclasses of arrays, one behind the other."""
    first = pieces[0]
    if len(pieces) == 1:
        return first
    joined = {}
    for field in fields(first):  # type: ignore[arg-type]
        values = [getattr(piece, field.name) for piece in pieces]
        joined[field.name] = np.concatenate(values) if isinstance(values[0], np.ndarray) else concatenate(values)
    return type(first)(**joined)


@dataclass(frozen=True, eq=False, kw_only=True)
class PointTable(Table):
    """A coordinate of a point: normal · (point - other point or free place) - bound.

    Parameters
    ----------
    info
        The rows.
    sample, other
        Which point at which frame, and from which it is seen, [R]; -1 for no other.
    bound
        Metres, [R].
    """

    sample: IntArray
    other: IntArray
    bound: FloatArray

    def residual(self, state: State) -> FloatArray:
        """Values in metres, [R]."""
        points = state.positions[self.sample]
        seen, held = self.other >= 0, self.info.place >= 0
        points[seen] -= state.positions[self.other[seen]]
        points[held] -= state.places[self.info.place[held]]
        return np.asarray(np.einsum("ri,ri->r", self.info.normal, points) - self.bound)

    def jacobian(self, state: State) -> FloatArray:
        """Derivatives [R, C]."""
        by_channels = state.position_jacobians[self.sample]
        seen = self.other >= 0
        if seen.any():
            by_channels[seen] -= state.position_jacobians[self.other[seen]]
        return np.asarray((self.info.normal[:, None, :] @ by_channels)[:, 0])

    def pull_points(self, state: State, multipliers: FloatArray, points: FloatArray) -> None:  # noqa: ARG002
        """Add the rows' pulls along their normals."""
        forces = multipliers[:, None] * self.info.normal
        seen = self.other >= 0
        np.add.at(points, self.sample, forces)
        np.subtract.at(points, self.other[seen], forces[seen])


@dataclass(frozen=True, eq=False, kw_only=True)
class DistanceTable(Table):
    """How much farther apart two points are than they shall be.

    Parameters
    ----------
    info
        The rows.
    sample, other
        Which points at which frames, [R].
    distance
        Metres, above zero, [R].
    """

    sample: IntArray
    other: IntArray
    distance: FloatArray

    def _apart(self, state: State) -> tuple[FloatArray, FloatArray]:
        between = state.positions[self.sample] - state.positions[self.other]
        return between, np.sqrt(np.einsum("ri,ri->r", between, between))

    def residual(self, state: State) -> FloatArray:
        """Values in metres, [R]."""
        return self._apart(state)[1] - self.distance

    def jacobian(self, state: State) -> FloatArray:
        """Derivatives [R, C]."""
        between, length = self._apart(state)
        direction = between / np.maximum(length, _NO_LENGTH)[:, None]
        difference = state.position_jacobians[self.sample] - state.position_jacobians[self.other]
        return np.asarray((direction[:, None, :] @ difference)[:, 0])

    def pull_points(self, state: State, multipliers: FloatArray, points: FloatArray) -> None:
        """Add the rows' pulls along the line between the points."""
        between, length = self._apart(state)
        forces = (multipliers / np.maximum(length, _NO_LENGTH))[:, None] * between
        np.add.at(points, self.sample, forces)
        np.subtract.at(points, self.other, forces)

    def curve(self, state: State, multipliers: FloatArray, bends: FloatArray) -> None:
        """Add what moving a point across the line between the two makes of its length."""
        between, length = self._apart(state)
        length = np.maximum(length, _NO_LENGTH)
        difference = state.position_jacobians[self.sample] - state.position_jacobians[self.other]
        along = ((between / length[:, None])[:, None, :] @ difference)[:, 0]
        across = np.swapaxes(difference, 1, 2) @ difference - along[:, :, None] * along[:, None, :]
        at = np.searchsorted(state.observer.frames, self.info.frame)
        np.add.at(bends, at, (multipliers / length)[:, None, None] * across)


@dataclass(frozen=True, eq=False, kw_only=True)
class OrientationTable(Table):
    """The rotation vector from the orientation asked for to a joint's, three rows per frame.

    Parameters
    ----------
    info
        The rows, [3 N].
    sample
        Which joint at which frame, [N].
    target
        Orientation in skeleton space, matrices [N, 3, 3].
    """

    sample: IntArray
    target: FloatArray

    def _vectors(self, state: State) -> FloatArray:
        return log_vector(np.swapaxes(self.target, -1, -2) @ state.orientations[self.sample])

    def residual(self, state: State) -> FloatArray:
        """Values in radians, [3 N]."""
        return self._vectors(state).ravel()

    def jacobian(self, state: State) -> FloatArray:
        """Derivatives [3 N, C]."""
        own = np.swapaxes(state.orientations[self.sample], -1, -2) @ state.turn_jacobians[self.sample]
        return (inverse_right_jacobian(self._vectors(state)) @ own).reshape(3 * len(self.sample), -1)

    def pull_turns(self, state: State, multipliers: FloatArray, turns: FloatArray) -> None:
        """Add the rows' pulls about the skeleton's axes."""
        forces = np.swapaxes(inverse_right_jacobian(self._vectors(state)), -1, -2) @ multipliers.reshape(-1, 3, 1)
        np.add.at(turns, self.sample, (state.orientations[self.sample] @ forces)[..., 0])
