"""What was matched with what: the bands that were cut and compared, the candidates, and which of them follow on."""

import itertools

import numpy as np
import numpy.typing as npt

from mtex_usd.motion.channels import Channel
from mtex_usd.review.plots.curves import short_names
from mtex_usd.review.plots.quantized import pack_rows
from mtex_usd.review.plots.retrace import Retraced
from mtex_usd.texture.candidates import Candidates
from mtex_usd.texture.pool import Matching, Pool
from mtex_usd.texture.pyramid import decompose

__all__ = ["describe_fragments", "describe_ways"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

# Whole numbers that the takes' match curves may fill in the page, two bytes each.
_MOST_VALUES = 200_000


def describe_ways(told: Retraced) -> list[dict[str, object]]:
    """Give each way of matching: one for the recipe, more where time segments have channels or bands of their own.

    Parameters
    ----------
    told
        The result with its steps.

    Returns
    -------
    list
        ``labels`` and ``units`` of the match channels that are in the page, ``left_out`` the number of those that are
        not; ``sketch`` [M, F] and ``pool`` [M, N], what was compared; ``cut`` [1, F], the band the sketch was cut by;
        ``starts``, pool frame at which a take begins, by take, -1 where it is too short; ``fragments``, first and last
        pool frame of the take fragments, flat.
    """
    return [_describe_way(told, matching, pool) for matching, pool in told.ground.pools.items()]


def _describe_way(told: Retraced, matching: Matching, pool: Pool) -> dict[str, object]:
    names = short_names(told.character.sketch.joints)
    shown = matching.match[: max(1, _MOST_VALUES // len(pool.features.values))]
    columns = slice(len(shown))
    return {
        "labels": [f"{names[channel.joint]}.{channel.kind}" for channel in shown],
        "units": ["°" if channel.is_rotation else "units as degrees" for channel in shown],
        "left_out": len(matching.match) - len(shown),
        "centred": pool.features.centred[columns].tolist(),
        "breakLabel": f"{names[matching.break_channel.joint]}.{matching.break_channel.kind}",
        "band": matching.band,
        "lower": bool(told.character.recipe.match_lower),
        "sketch": pack_rows(pool.sketch.values[:, columns].T),
        "pool": pack_rows(pool.features.values[:, columns].T),
        "cut": pack_rows(_cut_band(told, matching.break_channel, matching.band)[None]),
        "starts": _take_starts(told, pool),
        "fragments": pool.fragments.ravel().tolist(),
    }


def _cut_band(told: Retraced, channel: Channel, band: int) -> FloatArray:
    """The band whose turns cut the sketch, shape [F]."""
    curve = told.space.read_channel(told.ground.sketch, channel)
    return decompose(curve[:, None]).band(band)[:, 0]


def _take_starts(told: Retraced, pool: Pool) -> list[int]:
    starts = [-1] * len(told.ground.takes)
    for take, start in zip(pool.take_of.tolist(), pool.starts.tolist(), strict=True):
        starts[take] = start
    return starts


def describe_fragments(told: Retraced) -> list[dict[str, object]]:
    """Give the sketch's fragments with their candidates, closest first.

    Parameters
    ----------
    told
        The result with its steps.

    Returns
    -------
    list
        Per sketch fragment its ``first`` and ``last`` frame, its ``way`` of matching, and by candidate ``take``,
        ``takeFirst``, ``takeLast``, ``number`` (which fragment of its take, from 1), ``distance`` and ``scale``.
        ``joins`` are the zero-cost joins with the next fragment: pairs of candidates, flat.
    """
    ways = list(told.ground.pools)
    roles = told.ground.roles
    joins = [*(_zero_cost_joins(a, b) for a, b in itertools.pairwise(told.candidates)), []]
    described = []
    for fragment, found, pairs in zip(told.fragments, told.candidates, joins, strict=True):
        first, last = fragment.tolist()
        way = ways.index(Matching.of_span(roles.span_at(first)))
        candidates = _describe_candidates(found, told.ground.pools[ways[way]])
        described.append({"first": first, "last": last, "way": way, **candidates, "joins": pairs})
    return described


def _describe_candidates(found: Candidates, pool: Pool) -> dict[str, object]:
    return {
        "take": found.take.tolist(),
        "takeFirst": found.first.tolist(),
        "takeLast": found.last.tolist(),
        "number": _fragment_numbers(found, pool),
        "distance": [float(f"{distance:.5g}") for distance in found.distance],
        "scale": [float(f"{scale:.4g}") for scale in found.scale],
        "lifted": found.stretch_lifted,
    }


def _fragment_numbers(found: Candidates, pool: Pool) -> list[int]:
    """Which fragment of its take each candidate is, from 1."""
    local = pool.fragments[:, 0] - pool.starts
    return [
        int(np.count_nonzero((pool.take_of == take) & (local <= first)))
        for take, first in zip(found.take, found.first, strict=True)
    ]


def _zero_cost_joins(left: Candidates, right: Candidates) -> list[int]:
    """Pairs of candidates that followed each other in their take, flat."""
    follows = (left.take[:, None] == right.take) & (left.last[:, None] == right.first)
    return [int(number) for number in np.argwhere(follows).ravel()]
