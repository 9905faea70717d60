"""Rehearsals: how well a choice finds held-out takes again, judged without making the motion.

For a band and a channel that cuts, all fragments are sampled at a few points once; every set of match channels then
only weighs the same distances differently, and the best path through them is found for all sets at once. What is
left out is the stretching, joining and filtering of whole motions, which moves the error little beside which fragments
are chosen: on the captures of the benchmark the two errors correlate by 0.98. They order choices; they are not shown.
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.motion.channels import Channel
from mtex_usd.texture.matching import candidate_count
from mtex_usd.texture.recipe import Recipe
from mtex_usd.texture.suggestion.choices import Choice
from mtex_usd.texture.suggestion.sampling import Cast, Fragments, cut_band, read_band

__all__ = ["rehearse_choices"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

# Each costs more than all the one before and what is measured ever add up to.
_NOT_CONSECUTIVE = 1e9
_TOO_LONG = 1e12


def rehearse_choices(
    cast: Cast,
    choices: Sequence[Choice],
    root: int,
    recipe: Recipe,
    *,
    report: Callable[[int, int], None] | None = None,
) -> dict[Choice, float]:
    """Judge choices by what their best paths would copy.

    Parameters
    ----------
    cast
        The clips of all trials.
    choices
        What to judge; those that share band and cutting channel cost little more than one. Each cuts by one of the
        channels that occur.
    root
        The character's root joint.
    recipe
        All that is not chosen.
    report
        Called with how much is done, and of how much.

    Returns
    -------
    dict
        Mean error over the trials, metres.
    """
    channels = tuple(sorted({channel for choice in choices for channel in (*choice.match, choice.break_channel)}))
    groups: dict[int, dict[Channel, list[Choice]]] = {}
    for choice in choices:
        groups.setdefault(choice.band, {}).setdefault(choice.break_channel, []).append(choice)
    found: dict[Choice, float] = {}
    for band, cuts in groups.items():
        curves = read_band(cast, channels, root, band, recipe)
        for channel, members in cuts.items():
            fragments = cut_band(cast, curves, channels.index(channel))
            found.update(zip(members, _rehearse(cast, fragments, channels, members, recipe), strict=True))
            if report is not None:
                report(len(found), len(choices))
    return found


def _rehearse(
    cast: Cast, fragments: Fragments, channels: Sequence[Channel], members: Sequence[Choice], recipe: Recipe
) -> list[float]:
    """Go through all trials with choices that share their fragments; the mean error of each."""
    chosen = np.array([[channel in choice.match for choice in members] for channel in channels], dtype=np.float64)
    pool = fragments.of(fragments.clip < cast.take_count)
    joins = _cost_joins(pool, recipe)
    errors = []
    for sketch, held in enumerate(cast.held.tolist()):
        own = fragments.of(fragments.clip == cast.take_count + sketch)
        layers = _match(own, pool, held, chosen, recipe)
        errors.append(_follow(layers, joins) / (own.lengths + 1).sum())
    return [float(error) for error in np.mean(errors, axis=0)]


@dataclass(frozen=True, eq=False)
class _Layer:
    """One sketch fragment's K candidates in each of R choices, all of shape [K, R]: which, their cost and error."""

    candidates: IntArray
    costs: FloatArray
    errors: FloatArray


def _match(own: Fragments, pool: Fragments, held: int, chosen: FloatArray, recipe: Recipe) -> list[_Layer]:
    """Find the fragments of the pool nearest to each of a trial's in every choice of channels, [C, R]."""
    usable = pool.clip != held
    keep = candidate_count(recipe.candidates, int(usable.sum()))
    per_channel = _distances(own, pool)
    layers = []
    for number, length in enumerate(own.lengths.tolist()):
        distances = per_channel[:, :, number].T @ chosen
        too_long = pool.lengths > recipe.max_stretch * length
        if not too_long[usable].all():
            distances[too_long] = _TOO_LONG
        distances[~usable] = np.inf
        nearest = np.argpartition(distances, keep - 1, axis=0)[:keep]
        apart = np.linalg.norm(pool.places - own.places[number], axis=-1).mean(axis=(1, 2))
        costs = np.take_along_axis(distances, nearest, axis=0)
        layers.append(_Layer(nearest, costs, apart[nearest] * (length + 1)))
    return layers


def _distances(own: Fragments, pool: Fragments) -> FloatArray:
    """Squared distance per frame of every pair of fragments in every channel, shape [C, N, Q]."""
    a, b = (
        np.moveaxis(each.features.reshape(len(each.clip), -1, each.features.shape[-1]), 2, 0) for each in (pool, own)
    )
    squares = np.square(a).sum(axis=2)[:, :, None] + np.square(b).sum(axis=2)[:, None]
    return np.asarray(np.maximum(squares - 2.0 * a @ np.swapaxes(b, 1, 2), 0.0))


def _cost_joins(pool: Fragments, recipe: Recipe) -> FloatArray:
    """Cost of going from one fragment of the pool to another, shape [N, N]."""
    consecutive = (pool.clip[:, None] == pool.clip) & (pool.frames[:, 1:] == pool.frames[:, 0])
    if recipe.path_cost == "consecutive":
        return np.where(consecutive, 0.0, _NOT_CONSECUTIVE)
    squares = np.square(pool.ends).sum(axis=1)[:, None] + np.square(pool.begins).sum(axis=1)
    squares = np.maximum(squares - 2.0 * pool.ends @ pool.begins.T, 0.0)
    return np.where(consecutive, 0.0, recipe.path_weight * squares / max(pool.ends.shape[1], 1))


def _follow(layers: Sequence[_Layer], joins: FloatArray) -> FloatArray:
    """Go the cheapest way through the layers in every choice, and sum up its errors, shape [R]."""
    total, error = layers[0].costs, layers[0].errors
    for before, layer in itertools.pairwise(layers):
        ways = total[:, None] + joins[before.candidates[:, None], layer.candidates[None]]
        best = ways.argmin(axis=0)
        total = np.take_along_axis(ways, best[None], axis=0)[0] + layer.costs
        error = np.take_along_axis(error, best, axis=0) + layer.errors
    return np.asarray(np.take_along_axis(error, total.argmin(axis=0)[None], axis=0)[0])
