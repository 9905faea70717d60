"""Solving the linear systems of the search in time that grows with the frames, not with their square.

The unknowns are the spline's coefficients, ordered by knots, and the free places of points that shall keep still. A
coefficient meets only those of nearby knots, so the system is banded; a place meets all knots of its interval, which no
band could hold. So the knots are eliminated block by block from left to right (a frontal Cholesky factorisation), and
a place travels along from the first block that meets it to the last, where it is eliminated too.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg.lapack import dpotrf, dtrtrs

from mtex_usd.constraints.spacetime.knots import DEGREE, Knots
from mtex_usd.motion.skeleton import FloatArray, IntArray

__all__ = ["Factors", "Layout", "RowSystem", "factorize", "solve_factors"]

_PAD = 1.0  # cost of the coefficients that fill up the last block and act on no frame


@dataclass(frozen=True, eq=False, kw_only=True)
class RowSystem:
    """The linearised constraints, sorted by frame.

    Parameters
    ----------
    frame
        From the knots' first, [R], not decreasing.
    jacobian
        By the channels at the frame, [R, C].
    place
        Number of the free place of each row, -1 for none, [R].
    normal
        Minus the derivative by that place, [R, 3].
    """

    frame: IntArray
    jacobian: FloatArray
    place: IntArray
    normal: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class _Front:
    """Unknowns of one step of the elimination, by their numbers in the vector of all."""

    open: IntArray
    done: IntArray
    rest: IntArray
    carried: IntArray
    returned: IntArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Layout:
    """How the unknowns are cut into blocks.

    Parameters
    ----------
    knots
        The spline.
    cost
        Symmetric matrix of the squared change of one channel over its coefficients, banded, as diagonals: [W, K] where
        row `i` holds the entries (k, k + i), zero past the end.
    weights
        What each channel counts, [C].
    place_first, place_last
        First and last frame each free place is about, counted from the knots' first, [Q].
    kept
        How many coefficients at the beginning and at the end are no unknowns.
    """

    knots: Knots
    cost: FloatArray
    weights: FloatArray
    place_first: IntArray
    place_last: IntArray
    kept: tuple[int, int] = (0, 0)

    @property
    def free(self) -> slice:
        """The coefficients that are unknowns, per channel (K')."""
        return slice(self.kept[0], self.knots.count - self.kept[1])

    @cached_property
    def knots_per_block(self) -> int:
        """As few as keep a block from meeting the next but one."""
        return len(self.cost) - 1

    @cached_property
    def block_count(self) -> int:
        """How many blocks there are (B)."""
        return -(-(self.knots.count - sum(self.kept)) // self.knots_per_block)

    @property
    def channel_count(self) -> int:
        """Channels of the problem (C)."""
        return len(self.weights)

    @property
    def block_size(self) -> int:
        """Coefficients of all channels in one block."""
        return self.knots_per_block * self.channel_count

    @property
    def size(self) -> int:
        """Unknowns: the blocks', then three per place."""
        return self.block_count * self.block_size + 3 * len(self.place_first)

    def split(self, vector: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give the coefficients [K, C], none where kept, and the places [Q, 3] of a vector of all unknowns."""
        count = self.block_count * self.block_size
        coefficients = np.zeros((self.knots.count, self.channel_count))
        free = coefficients[self.free]
        free[:] = vector[:count].reshape(-1, self.channel_count)[: len(free)]
        return coefficients, vector[count:].reshape(-1, 3)

    def join(self, coefficients: FloatArray, places: FloatArray) -> FloatArray:
        """Do the opposite of :meth:`split`."""
        out, count = np.zeros(self.size), self.block_count * self.block_size
        free = coefficients[self.free]
        out[:count].reshape(-1, self.channel_count)[: len(free)] = free
        out[count:] = places.ravel()
        return out

    def pull_back(self, coefficients: FloatArray) -> FloatArray:
        """Multiply coefficients [K, C] by the cost and the weights."""
        count = len(coefficients)
        out = self.cost[0, :, None] * coefficients
        for offset, diagonal in enumerate(self.cost[1:], start=1):
            values = diagonal[: count - offset, None]
            out[: count - offset] += values * coefficients[offset:]
            out[offset:] += values * coefficients[: count - offset]
        return np.asarray(out * self.weights)

    @cached_property
    def block_of_frame(self) -> IntArray:
        """The block of the first unknown that acts on each frame, [F]."""
        return np.clip((self.knots.first - self.kept[0]) // self.knots_per_block, 0, self.block_count - 1)

    @cached_property
    def spread(self) -> FloatArray:
        """The basis at each frame over the knots of its block and the next, [F, 2 knots_per_block]."""
        out = np.zeros((self.knots.frame_count, 2 * self.knots_per_block))
        begin = self.kept[0] + self.knots_per_block * self.block_of_frame
        column = self.knots.first[:, None] + np.arange(DEGREE + 1)
        inside = (column >= self.free.start) & (column < self.free.stop)
        frame = np.broadcast_to(np.arange(len(out))[:, None], column.shape)
        out[frame[inside], (column - begin[:, None])[inside]] = self.knots.values[inside]
        return out

    @cached_property
    def cost_blocks(self) -> FloatArray:
        """The cost's blocks with their right neighbours, [B, knots_per_block, 2 knots_per_block]."""
        size, count = self.knots_per_block, self.knots.count - sum(self.kept)
        out = np.zeros((self.block_count, size, 2 * size))
        padded = np.zeros((len(self.cost), self.block_count * size))
        padded[0, count:] = _PAD
        for offset, diagonal in enumerate(self.cost):
            padded[offset, : count - offset] = diagonal[self.free][: count - offset]
            for row in range(size):
                values = padded[offset, row::size]
                out[:, row, row + offset] = values
                if 0 < offset < size - row:
                    out[:, row + offset, row] = values
        return out

    @cached_property
    def fronts(self) -> tuple[_Front, ...]:
        """What is eliminated at each block, and what it is passed on to."""
        begins = self.block_of_frame[self.place_first]
        ends = self.block_of_frame[self.place_last]
        order = np.lexsort((np.arange(len(ends)), ends))
        fronts: list[_Front] = []
        carried = np.zeros(0, dtype=np.intp)
        for block in range(self.block_count):
            opened = order[(begins[order] <= block) & (ends[order] >= block)]
            front = self._front(block, opened, int((ends[opened] == block).sum()), carried)
            fronts.append(front)
            carried = opened[ends[opened] > block]
        return tuple(fronts)

    def _front(self, block: int, opened: IntArray, closing: int, carried: IntArray) -> _Front:
        size, last = self.block_size, block == self.block_count - 1
        own = np.arange(block * size, (block + 1) * size)
        following = np.arange((block + 1) * size, (block + 1) * size if last else (block + 2) * size)
        numbers = self.block_count * size + (3 * opened[:, None] + np.arange(3)).ravel()
        position = np.flatnonzero(np.isin(opened, carried))
        staying = 3 * (len(opened) - closing)
        return _Front(
            open=opened,
            done=np.concatenate([own, numbers[: 3 * closing]]),
            rest=np.concatenate([numbers[3 * closing :], following]),
            carried=np.concatenate([np.arange(size), size + (3 * position[:, None] + np.arange(3)).ravel()]),
            returned=np.concatenate([staying + np.arange(len(following)), np.arange(staying)]),
        )


@dataclass(frozen=True, eq=False)
class Factors:
    """Cholesky factors of a system, front by front: the pivots [E, E] and what couples them to the rest [E, R]."""

    layout: Layout
    pivots: Sequence[FloatArray]
    couplings: Sequence[FloatArray]


def factorize(
    layout: Layout, rows: RowSystem, *, bends: FloatArray | None = None, bend_frames: IntArray | None = None
) -> Factors:
    """Factor the cost plus the squares of the rows.

    Parameters
    ----------
    layout
        The unknowns and the cost.
    rows
        Scaled by the roots of their penalties.
    bends, bend_frames
        Second derivatives to add [U, C, C] at frames [U], increasing, from the knots' first.

    Raises
    ------
    ArithmeticError
        Where the system is not positive definite.
    """
    pivots, couplings = [], []
    borders = _borders(layout, rows.frame)
    bent = None if bends is None or bend_frames is None else _Bends(bends, bend_frames, _borders(layout, bend_frames))
    carry = np.zeros((layout.block_size, layout.block_size))
    for block, front in enumerate(layout.fronts):
        matrix = _assemble(layout, block, carry, front)
        followed = block < layout.block_count - 1
        if bent is not None:
            _add_bends(layout, matrix, bent, block, followed=followed)
        part = slice(borders[block], borders[block + 1])
        if part.start < part.stop:
            wide = _widen(layout, rows, part, front.open)[:, : len(matrix)]
            matrix += wide.T @ wide
        done = len(front.done)
        pivot, failed = dpotrf(matrix[:done, :done].T, lower=True, clean=False)
        if failed:
            raise ArithmeticError("the system of the spacetime search is not positive definite")
        coupling, _ = dtrtrs(pivot, matrix[:done, done:], lower=True)
        passed = matrix[done:, done:] - coupling.T @ coupling
        carry = passed[np.ix_(front.returned, front.returned)]
        pivots.append(pivot)
        couplings.append(coupling)
    return Factors(layout, pivots, couplings)


def _assemble(layout: Layout, block: int, carry: FloatArray, front: _Front) -> FloatArray:
    """Put what was passed on and the cost into a front: own coefficients, places, the next block's coefficients."""
    size, knots, channels = layout.block_size, layout.knots_per_block, layout.channel_count
    matrix = np.zeros((len(front.done) + len(front.rest),) * 2)
    matrix[np.ix_(front.carried, front.carried)] = carry
    cost = layout.cost_blocks[block][:, :, None] * layout.weights
    own = matrix[:size, :size].reshape(knots, channels, knots, channels)
    np.einsum("iaja->ija", own)[...] += cost[:, :knots]
    if block < layout.block_count - 1:
        following = np.zeros((knots, channels, knots, channels))
        np.einsum("iaja->ija", following)[...] = cost[:, knots:]
        matrix[:size, -size:] += following.reshape(size, size)
    return matrix


@dataclass(frozen=True, eq=False)
class _Bends:
    """Second derivatives [U, C, C] at frames [U], and where each block's begin, [B + 1]."""

    values: FloatArray
    frames: IntArray
    borders: IntArray


def _borders(layout: Layout, frames: IntArray) -> IntArray:
    """Find where the frames of each block begin, [B + 1]."""
    return np.searchsorted(layout.block_of_frame[frames], np.arange(layout.block_count + 1))


def _add_bends(layout: Layout, matrix: FloatArray, bent: _Bends, block: int, *, followed: bool) -> None:
    part = slice(bent.borders[block], bent.borders[block + 1])
    if part.start == part.stop or not bent.values[part].any():
        return
    size, knots, channels = layout.block_size, layout.knots_per_block, layout.channel_count
    basis = layout.spread[bent.frames[part]]
    pairs = (basis[:, :, None] * basis[:, None, :]).reshape(len(basis), -1)
    wide = (pairs.T @ bent.values[part].reshape(len(basis), -1)).reshape(2 * knots, 2 * knots, channels, channels)
    both = wide.transpose(0, 2, 1, 3).reshape(2 * size, 2 * size)
    matrix[:size, :size] += both[:size, :size]
    if followed:
        matrix[:size, -size:] += both[:size, size:]
        matrix[-size:, -size:] += both[size:, size:]


def _widen(layout: Layout, rows: RowSystem, part: slice, opened: IntArray) -> FloatArray:
    """Rows over a front's unknowns, the next block's last, [r, front]."""
    size = layout.block_size
    jacobian = rows.jacobian[part]
    over_knots = layout.spread[rows.frame[part]][:, :, None] * jacobian[:, None, :]
    flat = over_knots.reshape(len(jacobian), -1)
    if not opened.size:
        return np.asarray(flat)
    places = np.zeros((len(jacobian), len(opened), 3))
    held = np.flatnonzero(rows.place[part] >= 0)
    which = _positions_in(opened, rows.place[part][held])
    places[held, which] = -rows.normal[part][held]
    return np.concatenate([flat[:, :size], places.reshape(len(jacobian), -1), flat[:, size:]], axis=1)


def _positions_in(values: IntArray, wanted: IntArray) -> IntArray:
    order = np.argsort(values)
    return np.asarray(order[np.searchsorted(values[order], wanted)])


def solve_factors(factors: Factors, right: FloatArray) -> FloatArray:
    """Solve for one right side, [layout.size]."""
    vector = np.array(right)
    steps = list(zip(factors.layout.fronts, factors.pivots, factors.couplings, strict=True))
    for front, pivot, coupling in steps:
        own, _ = dtrtrs(pivot, vector[front.done], lower=True)
        vector[front.done] = own
        vector[front.rest] -= coupling.T @ own
    for front, pivot, coupling in reversed(steps):
        own = vector[front.done] - coupling @ vector[front.rest]
        vector[front.done], _ = dtrtrs(pivot, own, lower=True, trans=1)
    return vector
