"""Fragments of all clips sampled at a few points, for one band: what rehearsals compare."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import Channel
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.fragments import DEAD_BAND, cut_at, find_turns, merge_breaks
from mtex_usd.texture.matching import stretch_linearly
from mtex_usd.texture.pyramid import decompose
from mtex_usd.texture.recipe import Recipe
from mtex_usd.texture.suggestion.choices import read_curves
from mtex_usd.texture.suggestion.measuring import Ends
from mtex_usd.texture.suggestion.trials import Trial

__all__ = ["BandCurves", "Cast", "Fragments", "cut_band", "read_band", "read_cast"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]
BoolArray = npt.NDArray[np.bool_]

_SAMPLES = 16
_PLACE_SAMPLES = 8
_DERIVATIVE_RATE = 24.0


@dataclass(frozen=True, eq=False)
class Cast:
    """All clips of all trials with what is copied of them, which no choice changes; takes first, then sketches.

    Parameters
    ----------
    clips
        Takes and sketches, length T + S.
    take_count
        How many of them are takes (T).
    held
        The take each sketch is of, shape [S].
    places
        Where the ends of the bones to be found are on a resting body, metres, shape [F, E * 3] each; of a sketch those
        of what it is of.
    poses
        The joints to be found as rotation vectors about their mean over the takes, degrees, shape [F, D] each.
    """

    clips: tuple[Clip, ...]
    take_count: int
    held: IntArray
    places: tuple[FloatArray, ...]
    poses: tuple[FloatArray, ...]


def read_cast(takes: Sequence[Clip], trials: Sequence[Trial], ends: Ends) -> Cast:
    """Read everything that no choice changes.

    Parameters
    ----------
    takes
        All takes, those that trials hold out included.
    trials
        The trials.
    ends
        What is measured.
    """
    true = [*takes, *(trial.truth for trial in trials)]
    turns = [clip.rotations[:, ends.joints] for clip in true]
    back = quaternion.conjugate(quaternion.mean(np.concatenate(turns[: len(takes)])))
    vectors = [quaternion.unroll_vectors(quaternion.log(quaternion.multiply(back, turn))) for turn in turns]
    return Cast(
        clips=(*takes, *(trial.sketch for trial in trials)),
        take_count=len(takes),
        held=np.array([trial.held for trial in trials]),
        places=tuple(ends.place(clip, _rest(clip)).reshape(clip.frame_count, -1) for clip in true),
        poses=tuple(np.degrees(vector).reshape(len(vector), -1) for vector in vectors),
    )


def _rest(clip: Clip) -> Clip:
    """A resting body for as long as a clip lasts."""
    frames = clip.frame_count
    return replace(
        clip,
        rotations=np.tile(clip.skeleton.rest_rotations, (frames, 1, 1)),
        translations=np.tile(clip.skeleton.rest_translations, (frames, 1, 1)),
    )


@dataclass(frozen=True, eq=False)
class BandCurves:
    """Match channels of every clip at one band.

    Parameters
    ----------
    bands
        The band alone, shape [F, C] each.
    features
        What is compared, values and slopes, shape [F, 2 * C] each.
    turning
        Channels that are rotations, shape [C].
    travel
        Channels of which only the course within a fragment counts, shape [C].
    """

    bands: tuple[FloatArray, ...]
    features: tuple[FloatArray, ...]
    turning: BoolArray
    travel: BoolArray


def read_band(cast: Cast, channels: Sequence[Channel], root: int, band: int, recipe: Recipe) -> BandCurves:
    """Decompose all channels of all clips.

    Parameters
    ----------
    cast
        The clips.
    channels
        Length C.
    root
        The character's root joint.
    band
        Match band.
    recipe
        Whether what is slower than the band matches too, and how much slopes count.
    """
    turning = np.array([channel.is_rotation for channel in channels])
    curves = _on_nearest_turn(read_curves(cast.clips, channels, root, band=band), turning)
    pyramids = [decompose(curve) for curve in curves]
    bands = tuple(pyramid.band(band) for pyramid in pyramids)
    values = [p.at_or_below(min(band, p.count + 1)) if recipe.match_lower else p.band(band) for p in pyramids]
    per_frame = cast.clips[0].rate / _DERIVATIVE_RATE * np.sqrt(recipe.derivative_weight)
    features = [np.concatenate([value, per_frame * np.gradient(value, axis=0)], axis=1) for value in values]
    up = np.abs(cast.clips[0].skeleton.up)
    travel = np.array([not c.is_rotation and c.joint == root and up[c.axis] < 0.5 for c in channels])
    return BandCurves(bands, tuple(features), turning, travel)


def _on_nearest_turn(curves: Sequence[FloatArray], turning: BoolArray) -> list[FloatArray]:
    wanted = curves[0].mean(axis=0)
    return [c + np.where(turning, 360.0 * np.round((wanted - c.mean(axis=0)) / 360.0), 0.0) for c in curves]


@dataclass(frozen=True, eq=False)
class Fragments:
    """All clips' fragments at one band and cutting channel, N of them, sampled at S points.

    Parameters
    ----------
    clip
        Which clip each is of, shape [N].
    frames
        First and last frame in that clip, shape [N, 2].
    features
        Values and slopes of all channels, scaled so that squared differences sum up to those per frame, shape
        [N, S, 2, C].
    places
        Where the ends of the bones to be found are, metres, shape [N, S', E, 3].
    begins, ends
        The pose to be found at both ends, degrees, shape [N, D].
    """

    clip: IntArray
    frames: IntArray
    features: FloatArray
    places: FloatArray
    begins: FloatArray
    ends: FloatArray

    @property
    def lengths(self) -> IntArray:
        """Frames from first to last, shape [N]."""
        return np.asarray(self.frames[:, 1] - self.frames[:, 0])

    def of(self, members: IntArray | BoolArray) -> "Fragments":
        """Give some of them."""
        return Fragments(
            self.clip[members],
            self.frames[members],
            self.features[members],
            self.places[members],
            self.begins[members],
            self.ends[members],
        )


def cut_band(cast: Cast, curves: BandCurves, column: int) -> Fragments:
    """Cut all clips where a channel's band turns round, and sample the fragments.

    Parameters
    ----------
    cast, curves
        As :func:`read_cast` and :func:`read_band` give them.
    column
        The channel that cuts.
    """
    dead_band = DEAD_BAND * max(float(np.ptp(band[:, column])) for band in curves.bands)
    cuts = [cut_at(merge_breaks(len(band), find_turns(band[:, column], dead_band))) for band in curves.bands]
    parts = [_sample(cast, curves, number, frames) for number, frames in enumerate(cuts)]
    taken = np.concatenate([part.features[:, :, 0] for part in parts[: cast.take_count]])
    weights = _weigh(taken.std(axis=(0, 1)), curves.turning)
    return Fragments(
        clip=np.concatenate([part.clip for part in parts]),
        frames=np.concatenate(cuts),
        features=np.concatenate([part.features for part in parts]) * (weights / np.sqrt(_SAMPLES)),
        places=np.concatenate([part.places for part in parts]),
        begins=np.concatenate([part.begins for part in parts]),
        ends=np.concatenate([part.ends for part in parts]),
    )


def _sample(cast: Cast, curves: BandCurves, number: int, frames: IntArray) -> Fragments:
    """Sample one clip's fragments."""
    count, poses = len(frames), cast.poses[number]
    features = stretch_linearly(curves.features[number], frames, _SAMPLES).reshape(count, _SAMPLES, 2, -1)
    means = features[:, :, 0].mean(axis=1, keepdims=True)
    features[:, :, 0] -= np.where(curves.travel, means, 0.0)
    places = stretch_linearly(cast.places[number], frames, _PLACE_SAMPLES).reshape(count, _PLACE_SAMPLES, -1, 3)
    clip = np.full(count, number)
    return Fragments(clip, frames, features, places, poses[frames[:, 0]], poses[frames[:, 1]])


def _weigh(deviation: FloatArray, turning: BoolArray) -> FloatArray:
    """Scale translations to the rotations' mean standard deviation, shape [C]."""
    if turning.all() or not turning.any():
        return np.ones(len(turning))
    scaled = np.divide(deviation[turning].mean(), deviation, out=np.zeros(len(turning)), where=deviation > 0.0)
    return np.where(turning, 1.0, scaled)
