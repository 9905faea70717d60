"""What may be chosen: which channels match, which of them cuts, and on which band."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from mtex_usd.motion.channels import Channel
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.pyramid import band_limit, decompose, peak_frequency
from mtex_usd.texture.reading import read_sketch
from mtex_usd.texture.recipe import Recipe
from mtex_usd.texture.space import Space, choose_orders

__all__ = ["MOST_CHANNELS", "Choice", "list_bands", "list_pairs", "moving_channels", "read_curves"]

FloatArray = npt.NDArray[np.float64]

MOST_CHANNELS = 16
"""More channels than this are not tried: those that swing most are."""

# From the pace of steps of a run down to a slow sway, Hz; at 24 frames/s bands 3 to 6.
_FASTEST_HZ = 2.4
_SLOWEST_HZ = 0.15
# A channel that swings less than this part of what the liveliest does says little about the rest of the body.
_LEAST_SWING = 0.25
_ANY_BAND = 4


@dataclass(frozen=True)
class Choice:
    """Match channels, the first of which cuts, and the band.

    Parameters
    ----------
    match
        Channels of the character's skeleton.
    break_channel
        Where the motion is cut.
    band
        Match band, 1 is the highest frequency.
    """

    match: tuple[Channel, ...]
    break_channel: Channel
    band: int

    def apply_to(self, recipe: Recipe, joints: Sequence[str]) -> Recipe:
        """Give a recipe that matches in this way, everywhere.

        Parameters
        ----------
        recipe
            What is textured and synthesized, and how; its segments are dropped.
        joints
            Joint paths of the character's skeleton.
        """
        return replace(
            recipe,
            match=self.tokens(joints),
            break_channel=self.break_channel.name(joints),
            match_band=self.band,
            segments=(),
        )

    def tokens(self, joints: Sequence[str]) -> tuple[str, ...]:
        """Give the match channels as the schema has them."""
        return tuple(channel.name(joints) for channel in self.match)


def list_pairs(channels: Sequence[Channel], bands: Sequence[int]) -> tuple[Choice, ...]:
    """Give every pair of channels in either order (the first one cuts) on every band."""
    pairs = itertools.permutations(channels, 2)
    return tuple(Choice(pair, pair[0], band) for pair, band in itertools.product(pairs, bands))


def list_bands(frame_counts: Sequence[int], rate: float) -> tuple[int, ...]:
    """Give the bands that peak between 0.15 and 2.4 Hz and that clips are long enough for.

    Parameters
    ----------
    frame_counts
        Of the sketch, and of what has to be matched.
    rate
        Frames per second.

    Returns
    -------
    tuple of int
        Rising; where clips are too short for any, the lowest band they have, at least 1.
    """
    most = max(1, min(map(band_limit, frame_counts)))
    bands = [band for band in range(1, most + 1) if _SLOWEST_HZ <= peak_frequency(band, rate) <= _FASTEST_HZ]
    return tuple(bands) or (most,)


def read_curves(
    clips: Sequence[Clip], channels: Sequence[Channel], root: int, *, band: int = _ANY_BAND
) -> list[FloatArray]:
    """Read channels of clips on one skeleton, degrees and stage units, shape [F, C] each.

    Parameters
    ----------
    clips
        Sketches and takes on the character's skeleton.
    channels
        Length C.
    root
        The character's root joint.
    band
        What is slower than this band is heading.
    """
    motions = [read_sketch(clip, root, band) for clip in clips]
    turning = sorted({channel.joint for channel in channels if channel.is_rotation})
    space = Space(root, (), (), choose_orders(turning, motions, root), np.empty((0, 4)))
    return [np.stack([space.read_channel(motion, channel) for channel in channels], axis=1) for motion in motions]


def moving_channels(
    takes: Sequence[Clip], channels: Sequence[Channel], root: int, bands: Sequence[int]
) -> tuple[Channel, ...]:
    """Give the channels that swing enough in the takes to tell anything, the liveliest first.

    Parameters
    ----------
    takes
        On the character's skeleton.
    channels
        What the sketch animates and is not synthesized.
    root
        The character's root joint.
    bands
        Where swings count.

    Notes
    -----
    A swing is the root mean square of the bands; that of a translation is the angle under which it is seen from a
    body's height away.
    """
    if not channels:
        return ()
    curves = read_curves(takes, channels, root)
    squares = [np.square(decompose(curve).sum_of(min(bands), max(bands))) for curve in curves]
    swings = np.sqrt(np.concatenate(squares).mean(axis=0))
    per_height = np.degrees(1.0 / max(takes[0].skeleton.height, float(np.finfo(np.float64).tiny)))
    swings = swings * [1.0 if channel.is_rotation else per_height for channel in channels]
    order = np.argsort(-swings, kind="stable")[:MOST_CHANNELS]
    return tuple(channels[i] for i in order if swings[i] >= _LEAST_SWING * swings[order[0]] and swings[i] > 0.0)
