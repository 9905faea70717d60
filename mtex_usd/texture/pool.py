"""The takes as a pool of fragments for one way of matching.

A way of matching is a set of match channels, a break channel and a band; time segments may each have their own. For
each, every take is decomposed, cut and laid end to end with the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.errors import InputError
from mtex_usd.motion.channels import Channel
from mtex_usd.texture.fragments import DEAD_BAND, cut_at, find_turns, merge_breaks
from mtex_usd.texture.matching import Features
from mtex_usd.texture.pyramid import band_limit, decompose
from mtex_usd.texture.reading import Motion
from mtex_usd.texture.recipe import Recipe
from mtex_usd.texture.roles import Span
from mtex_usd.texture.space import Space, goes_along_ground

__all__ = ["Matching", "Pool", "build_pool"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]
BoolArray = npt.NDArray[np.bool_]

# Derivatives are per 1/24 s, the frame of the paper, at any rate.
_DERIVATIVE_RATE = 24.0


@dataclass(frozen=True)
class Matching:
    """One way of matching."""

    match: tuple[Channel, ...]
    break_channel: Channel
    band: int

    @classmethod
    def of_span(cls, span: Span) -> "Matching":
        """Give the way a span is matched."""
        return cls(span.match, span.break_channel, span.match_band)


@dataclass(frozen=True, eq=False)
class Pool:
    """Sketch and takes, cut and measured for one way of matching.

    Parameters
    ----------
    sketch_turns
        Frames where the sketch's break channel turns round.
    sketch
        Features of the sketch.
    features
        Features of the usable takes end to end.
    fragments
        First and last frame in the pool, shape [N, 2].
    take_of
        Which motion each fragment is from, shape [N].
    starts
        Pool frame at which each fragment's take begins, shape [N].
    skipped
        Takes too short for one fragment.
    """

    sketch_turns: IntArray
    sketch: Features
    features: Features
    fragments: IntArray
    take_of: IntArray
    starts: IntArray
    skipped: tuple[int, ...]


def build_pool(sketch: Motion, takes: Sequence[Motion], space: Space, matching: Matching, recipe: Recipe) -> Pool:
    """Decompose, cut and measure sketch and takes for one way of matching.

    Raises
    ------
    InputError
        Where no take is long enough to have the band.
    """
    # A sketch too short for any band is matched on its residual, for which a fragment's two frames will do.
    least = 2 ** min(matching.band, _limit(sketch)) + 1
    usable = [i for i, take in enumerate(takes) if take.clip.frame_count >= least]
    if not usable:
        longest = max(take.clip.frame_count for take in takes)
        raise InputError(
            f"{sketch.clip.name}: every take is too short for one fragment",
            expected=f"{least} frames at {sketch.clip.rate:g} frames/s for band {matching.band}",
            found=f"{longest} at the most",
        )
    clips = [sketch, *(takes[i] for i in usable)]
    curves = _match_curves(clips, space, matching.match)
    measured = [_measure(c, clip, space, matching, recipe) for c, clip in zip(curves, clips, strict=True)]
    bands = [_break_band(m, clip, space, matching) for m, clip in zip(measured, clips, strict=True)]
    dead_band = DEAD_BAND * max(float(np.ptp(band)) for band in bands)
    turns = [find_turns(band, dead_band) for band in bands]
    pooled, fragments, owner, starts = _lay_end_to_end(measured[1:], turns[1:])
    weights = _column_weights(pooled, fragments, matching.match)
    return Pool(
        sketch_turns=turns[0],
        sketch=_weigh(measured[0], weights),
        features=_weigh(pooled, weights),
        fragments=fragments,
        take_of=np.array(usable, dtype=np.intp)[owner],
        starts=starts,
        skipped=tuple(i for i in range(len(takes)) if i not in usable),
    )


def _limit(sketch: Motion) -> int:
    return band_limit(sketch.clip.frame_count)


def _break_band(measured: Features, clip: Motion, space: Space, matching: Matching) -> FloatArray:
    """The band whose turns cut a clip, shape [F]."""
    if matching.break_channel in matching.match:
        return measured.band[:, matching.match.index(matching.break_channel)]
    curve = space.read_channel(clip, matching.break_channel)[:, None]
    return decompose(curve).band(matching.band)[:, 0]


def _match_curves(clips: Sequence[Motion], space: Space, match: Sequence[Channel]) -> list[FloatArray]:
    """Match channels of every clip, [F, M] each, on the turn nearest the first clip's."""
    curves = [np.stack([space.read_channel(clip, channel) for channel in match], axis=1) for clip in clips]
    turning = np.array([channel.is_rotation for channel in match])
    wanted = curves[0].mean(axis=0)
    return [c + np.where(turning, 360.0 * np.round((wanted - c.mean(axis=0)) / 360.0), 0.0) for c in curves]


def _measure(curves: FloatArray, clip: Motion, space: Space, matching: Matching, recipe: Recipe) -> Features:
    """Band (and what is below), slopes; columns not yet weighed against each other."""
    bands = decompose(curves)
    band = bands.band(matching.band)
    values = bands.at_or_below(matching.band) if recipe.match_lower or not bands.count else band
    slopes = np.gradient(values, axis=0) if len(values) > 1 else np.zeros_like(values)
    per_frame = clip.clip.rate / _DERIVATIVE_RATE * np.sqrt(recipe.derivative_weight)
    return Features(values, slopes * per_frame, band, _travel_columns(clip, space, matching.match))


def _travel_columns(clip: Motion, space: Space, match: Sequence[Channel]) -> BoolArray:
    """Columns that say where the root has got to along the ground: only their course within a fragment counts."""
    up = clip.clip.skeleton.up
    return np.array([goes_along_ground(channel, space.root, up) for channel in match], dtype=np.bool_)


def _lay_end_to_end(
    measured: Sequence[Features], turns: Sequence[IntArray]
) -> tuple[Features, IntArray, IntArray, IntArray]:
    """Concatenate takes; give the pool's features, its fragments, the take of each and where that take begins."""
    fragments, owner, starts = [], [], []
    at = 0
    for number, (features, own_turns) in enumerate(zip(measured, turns, strict=True)):
        cut = cut_at(merge_breaks(len(features.values), own_turns)) + at
        fragments.append(cut)
        owner.append(np.full(len(cut), number))
        starts.append(np.full(len(cut), at))
        at += len(features.values)
    pooled = Features(
        values=np.concatenate([f.values for f in measured]),
        slopes=np.concatenate([f.slopes for f in measured]),
        band=np.concatenate([f.band for f in measured]),
        centred=measured[0].centred,
    )
    return pooled, np.concatenate(fragments), np.concatenate(owner), np.concatenate(starts)


def _column_weights(pooled: Features, fragments: IntArray, match: Sequence[Channel]) -> FloatArray:
    """Scale translations to the rotations' mean standard deviation over the takes; rotations stay as they are, [M]."""
    turning = np.array([channel.is_rotation for channel in match])
    if turning.all() or not turning.any():
        return np.ones(len(match))
    deviation = np.array([_deviation(pooled, fragments, column) for column in range(len(match))])
    target = deviation[turning].mean()
    scaled = np.divide(target, deviation, out=np.zeros(len(match)), where=deviation > 0.0)
    return np.where(turning, 1.0, scaled)


def _deviation(pooled: Features, fragments: IntArray, column: int) -> float:
    values = pooled.values[:, column]
    if not pooled.centred[column]:
        return float(values.std())
    pieces = [values[first : last + 1] - values[first : last + 1].mean() for first, last in fragments]
    return float(np.concatenate(pieces).std())


def _weigh(features: Features, weights: FloatArray) -> Features:
    return Features(features.values * weights, features.slopes * weights, features.band * weights, features.centred)
