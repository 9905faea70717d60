"""The candidates of every sketch fragment, and what joining any two of them costs."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.texture.fragments import cut_at, merge_breaks
from mtex_usd.texture.matching import Match, candidate_count, fit_scale, match_fragments
from mtex_usd.texture.paths import Lattice, consecutive_lattice, continuity_lattice
from mtex_usd.texture.pool import Matching, Pool
from mtex_usd.texture.recipe import Recipe
from mtex_usd.texture.roles import Roles, Span

__all__ = ["Candidates", "build_lattice", "find_candidates", "find_sketch_fragments"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]
BoolArray = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Candidates:
    """The candidates of one sketch fragment, closest first; all arrays of shape [K].

    Parameters
    ----------
    take
        Index of the take.
    first, last
        Frames in that take, both included; given fragments may begin and end between frames.
    distance
        Matching distance.
    scale
        Factor on the copied data.
    stretch_lifted
        Whether the stretch limit had to be lifted.
    """

    take: IntArray
    first: IntArray | FloatArray
    last: IntArray | FloatArray
    distance: FloatArray
    scale: FloatArray
    stretch_lifted: bool


def find_sketch_fragments(roles: Roles, pools: dict[Matching, Pool], frame_count: int) -> IntArray:
    """Cut the sketch, each span by its own break channel, the borders being breaks too; shape [Q, 2]."""
    turns = [
        turn
        for span in roles.spans
        for turn in pools[Matching.of_span(span)].sketch_turns
        if span.first < turn < span.last
    ]
    return cut_at(merge_breaks(frame_count, turns, roles.borders))


def find_candidates(
    roles: Roles, pools: dict[Matching, Pool], fragments: IntArray, recipe: Recipe
) -> tuple[Candidates, ...]:
    """Match every sketch fragment in its span's own way."""
    spans = [roles.span_at(int(first)) for first in fragments[:, 0]]
    found: dict[int, Candidates] = {}
    for matching, pool in pools.items():
        members = [q for q, span in enumerate(spans) if Matching.of_span(span) == matching]
        if not members:
            continue
        matches = match_fragments(
            pool.sketch,
            fragments[members],
            pool.features,
            pool.fragments,
            candidates=candidate_count(recipe.candidates, len(pool.fragments)),
            max_stretch=recipe.max_stretch,
        )
        for q, match in zip(members, matches, strict=True):
            found[q] = _locate(match, pool, fragments[q], spans[q])
    return tuple(found[q] for q in range(len(fragments)))


def _locate(match: Match, pool: Pool, fragment: IntArray, span: Span) -> Candidates:
    """Say where in which take the candidates are, and how they scale."""
    scale = np.ones(len(match.fragments))
    if span.scale:
        pairs = pool.fragments[match.fragments]
        scale = np.array([fit_scale(pool.sketch, fragment, pool.features, pair) for pair in pairs])
    local = pool.fragments[match.fragments] - pool.starts[match.fragments, None]
    take = pool.take_of[match.fragments]
    return Candidates(take, local[:, 0], local[:, 1], match.distances, scale, match.stretch_lifted)


def build_lattice(
    candidates: Sequence[Candidates],
    fragments: IntArray,
    curves: Sequence[FloatArray],
    sliding: BoolArray,
    recipe: Recipe,
) -> Lattice:
    """Cost all candidates and joins in the way the recipe asks.

    Parameters
    ----------
    candidates
        Per sketch fragment, length Q.
    fragments
        Sketch fragments, shape [Q, 2].
    curves
        Copied channels of every take, [F, C] each.
    sliding
        Columns of `curves` that carry on wherever they are, shape [C].
    recipe
        Path cost and weight.
    """
    distances = [c.distance for c in candidates]
    pairs = list(itertools.pairwise(candidates))
    consecutive = [_consecutive(left, right) for left, right in pairs]
    if recipe.path_cost == "consecutive":
        return consecutive_lattice(distances, consecutive)
    gaps = [_gaps(left, right, curves, ~sliding) for left, right in pairs]
    lengths = (fragments[:, 1] - fragments[:, 0] + 1).tolist()
    return continuity_lattice(distances, lengths, consecutive, gaps, weight=recipe.path_weight)


def _consecutive(left: Candidates, right: Candidates) -> BoolArray:
    """Whether the right fragment follows the left one in the same take, shape [K, K']."""
    return np.asarray((left.take[:, None] == right.take) & (left.last[:, None] == right.first))


def _gaps(left: Candidates, right: Candidates, curves: Sequence[FloatArray], counted: BoolArray) -> FloatArray:
    """Mean squared jump over the copied channels from the end of one to the beginning of the other, shape [K, K']."""
    ends = np.stack([curves[take][frame] for take, frame in zip(left.take, left.last, strict=True)])[:, counted]
    begins = np.stack([curves[take][frame] for take, frame in zip(right.take, right.first, strict=True)])[:, counted]
    squares = np.square(ends).sum(axis=1)[:, None] + np.square(begins).sum(axis=1) - 2.0 * ends @ begins.T
    return np.asarray(np.maximum(squares, 0.0) / max(int(counted.sum()), 1))
