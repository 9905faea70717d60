"""Choosing paths through the candidates (Pullen & Bregler 2002, section 3.3).

A path takes one candidate per sketch fragment. Its cost is a sum over fragments and joins, so the best paths are found
by dynamic programming that keeps, for every candidate, the best few partial paths of distinct choice; paths are never
listed.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

__all__ = ["Lattice", "Path", "consecutive_lattice", "continuity_lattice", "find_best_path", "find_paths"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Lattice:
    """All candidates with what they and their joins cost; Q fragments, K_q candidates each.

    Parameters
    ----------
    node_costs
        Q arrays of shape [K_q].
    join_costs
        Q - 1 arrays of shape [K_q, K_{q+1}], already zero where consecutive.
    consecutive
        Q - 1 arrays of shape [K_q, K_{q+1}]: whether the two followed each other in their take.
    fill_costs
        As `join_costs`, for ordering the paths that fill up once all distinct choices are taken.
    """

    node_costs: tuple[FloatArray, ...]
    join_costs: tuple[FloatArray, ...]
    consecutive: tuple[BoolArray, ...]
    fill_costs: tuple[FloatArray, ...]


@dataclass(frozen=True)
class Path:
    """One path of candidates.

    Parameters
    ----------
    choice
        Index of the candidate per sketch fragment, length Q.
    cost
        What it was ordered by.
    joins
        Its zero-cost joins as (position, left candidate, right candidate).
    """

    choice: tuple[int, ...]
    cost: float
    joins: frozenset[tuple[int, int, int]]


def consecutive_lattice(distances: Sequence[FloatArray], consecutive: Sequence[BoolArray]) -> Lattice:
    """Score as the paper: most zero-cost joins first, then the smallest sum of matching distances."""
    # One join outweighs any difference in distance.
    join = 1.0 + 2.0 * sum(float(d.max()) for d in distances)
    joins = tuple(np.where(zero, 0.0, join) for zero in consecutive)
    nothing = tuple(np.zeros(zero.shape) for zero in consecutive)
    return Lattice(tuple(distances), joins, tuple(consecutive), nothing)


def continuity_lattice(
    distances: Sequence[FloatArray],
    lengths: Sequence[int],
    consecutive: Sequence[BoolArray],
    gaps: Sequence[FloatArray],
    *,
    weight: float,
) -> Lattice:
    """Score by distance per frame plus the pose's jump at each join that is not consecutive.

    Parameters
    ----------
    distances
        Matching distances, Q arrays of shape [K_q].
    lengths
        Frames of each sketch fragment, length Q.
    consecutive
        Q - 1 arrays of shape [K_q, K_{q+1}].
    gaps
        Mean squared pose gap of each join, degrees squared, Q - 1 arrays of shape [K_q, K_{q+1}].
    weight
        What the gap counts beside the distance.
    """
    nodes = tuple(d / length for d, length in zip(distances, lengths, strict=True))
    joins = tuple(np.where(zero, 0.0, weight * gap) for zero, gap in zip(consecutive, gaps, strict=True))
    return Lattice(nodes, joins, tuple(consecutive), joins)


def find_paths(lattice: Lattice, count: int) -> tuple[Path, ...]:
    """Find the best distinct paths, best first.

    Two paths with the same set of zero-cost joins are one choice, represented by its cheapest path. All distinct
    choices come first; then the next cheapest paths fill up. Fewer than `count` come back where there are no more.
    """
    found = _search(lattice, lattice.join_costs, count, distinct=True)
    if len(found) < count:
        taken = {path.choice for path in found}
        rest = _search(lattice, lattice.fill_costs, count + len(found), distinct=False)
        found += [path for path in rest if path.choice not in taken][: count - len(found)]
    return tuple(found)


class _Keys:
    """Small numbers for the choices made so far, so that two partial paths can be told apart or found equal."""

    def __init__(self, *, distinct: bool) -> None:
        self._distinct = distinct
        self._numbers: dict[tuple[int, int, int, int], int] = {}

    def extend(self, key: int, position: int, left: int, right: int, *, joined: bool) -> int:
        """Give the key of a partial path after one more join; only zero-cost joins make a choice of its own."""
        if self._distinct and not joined:
            return key
        return self._numbers.setdefault((key, position, left, right), len(self._numbers) + 1)


@dataclass(frozen=True, eq=False)
class _Layer:
    """Partial paths that end at one position: E entries with candidate, cost, key and predecessor."""

    candidate: IntArray
    cost: FloatArray
    key: IntArray
    previous: IntArray


def _search(lattice: Lattice, join_costs: Sequence[FloatArray], count: int, *, distinct: bool) -> list[Path]:
    keys = _Keys(distinct=distinct)
    first = lattice.node_costs[0]
    start = np.zeros(len(first), dtype=np.intp) if distinct else -1 - np.arange(len(first))
    layers = [_Layer(np.arange(len(first)), first, start, np.full(len(first), -1))]
    for position, costs in enumerate(join_costs):
        zero = lattice.consecutive[position]
        layers.append(_extend(layers[-1], costs, zero, lattice.node_costs[position + 1], keys, position, count))
    return _collect(lattice, layers, count)


def _extend(
    layer: _Layer,
    join_costs: FloatArray,
    zero: BoolArray,
    node_costs: FloatArray,
    keys: _Keys,
    position: int,
    count: int,
) -> _Layer:
    """Lengthen every partial path by every candidate and keep the cheapest `count` of distinct keys at each."""
    totals = layer.cost + join_costs[layer.candidate].T
    lefts, own_keys, joined = layer.candidate.tolist(), layer.key.tolist(), zero.tolist()
    rights: list[int] = []
    entries: list[int] = []
    new_keys: list[int] = []
    for right, order in enumerate(np.argsort(totals, axis=1, kind="stable")):
        best: dict[int, int] = {}
        for entry in order.tolist():
            left = lefts[entry]
            key = keys.extend(own_keys[entry], position, left, right, joined=joined[left][right])
            best.setdefault(key, entry)
            if len(best) == count:
                break
        rights += [right] * len(best)
        entries += best.values()
        new_keys += best
    return _Layer(np.array(rights), totals[rights, entries] + node_costs[rights], np.array(new_keys), np.array(entries))


def _collect(lattice: Lattice, layers: Sequence[_Layer], count: int) -> list[Path]:
    """Read off the cheapest entries of distinct keys of the last layer."""
    last = layers[-1]
    seen: set[int] = set()
    paths = []
    for entry in np.argsort(last.cost, kind="stable").tolist():
        if int(last.key[entry]) in seen:
            continue
        seen.add(int(last.key[entry]))
        paths.append(_trace(lattice, layers, entry))
        if len(paths) == count:
            break
    return paths


def _trace(lattice: Lattice, layers: Sequence[_Layer], entry: int) -> Path:
    cost = float(layers[-1].cost[entry])
    choice: list[int] = []
    for layer in reversed(layers):
        choice.append(int(layer.candidate[entry]))
        entry = int(layer.previous[entry])
    return _make_path(lattice, choice[::-1], cost)


def _make_path(lattice: Lattice, choice: Sequence[int], cost: float) -> Path:
    pairs = enumerate(itertools.pairwise(choice))
    joins = frozenset((q, a, b) for q, (a, b) in pairs if lattice.consecutive[q][a, b])
    return Path(tuple(choice), cost, joins)


def find_best_path(lattice: Lattice, differs: Sequence[BoolArray]) -> Path | None:
    """Find the cheapest path that differs somewhere from each of several others.

    Parameters
    ----------
    lattice
        The candidates and their costs.
    differs
        Q arrays of shape [A, K_q]: whether a candidate differs enough there from each of A paths.

    Returns
    -------
    Path or None
        None where no path does.

    Notes
    -----
    The state of the search is the candidate and the set of paths already differed from, so the cost grows as 2**A.
    """
    sets = 1 << differs[0].shape[0]
    bits = [(1 << np.arange(sets.bit_length() - 1)) @ d for d in differs]
    cost = np.full((len(lattice.node_costs[0]), sets), np.inf)
    cost[np.arange(len(cost)), bits[0]] = lattice.node_costs[0]
    back: list[IntArray] = []
    for position, joins in enumerate(lattice.join_costs):
        cost, previous = _extend_sets(cost, joins, bits[position + 1])
        cost += lattice.node_costs[position + 1][:, None]
        back.append(previous)
    end = int(np.argmin(cost[:, -1]))
    if not np.isfinite(cost[end, -1]):
        return None
    choice, state = [end], end * sets + sets - 1
    for previous in reversed(back):
        state = int(previous.reshape(-1)[state])
        choice.append(state // sets)
    return _make_path(lattice, choice[::-1], float(cost[end, -1]))


def _extend_sets(cost: FloatArray, joins: FloatArray, bits: IntArray) -> tuple[FloatArray, IntArray]:
    """Lengthen by one fragment; costs [K, S] over candidates and sets to [K', S] with predecessors' flat states."""
    count, sets = len(bits), cost.shape[1]
    extended = np.full((count, sets), np.inf)
    previous = np.zeros((count, sets), dtype=np.intp)
    columns = np.arange(count)
    for subset in range(sets):
        totals = cost[:, subset, None] + joins
        left = np.argmin(totals, axis=0)
        best = totals[left, columns]
        reached = subset | bits
        better = columns[best < extended[columns, reached]]
        extended[better, reached[better]] = best[better]
        previous[better, reached[better]] = left[better] * sets + subset
    return extended, previous
