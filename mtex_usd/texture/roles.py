"""What each channel is for, and when: the recipe resolved against a skeleton and a frame range.

Time segments divide the sketch into spans; what no segment covers follows the recipe itself. Segment borders are
breaks, and role changes ramp over the join time (Pullen & Bregler 2002, section 4.1).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from mtex_usd.errors import InputError
from mtex_usd.motion.channels import Channel, resolve_channels
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.pyramid import band_limit, nearest_band
from mtex_usd.texture.recipe import Recipe, Segment

__all__ = ["MATCH_HZ", "SYNTHESIS_HZ", "TEXTURE_HZ", "Roles", "Span", "ramp", "resolve_roles"]

FloatArray = npt.NDArray[np.float64]

# What bands 4, 2-3 and 2 of the paper peak at, at its 24 frames/s.
MATCH_HZ = 0.8
TEXTURE_HZ = (3.4, 1.6)
SYNTHESIS_HZ = 3.4


@dataclass(frozen=True)
class Span:
    """Settings that hold from one frame to another, both included."""

    first: int
    last: int
    match: tuple[Channel, ...]
    break_channel: Channel
    match_band: int
    texture: frozenset[Channel]
    synthesize: frozenset[Channel]
    texture_bands: tuple[int, int]
    scale: bool


@dataclass(frozen=True)
class Roles:
    """The recipe over time.

    Parameters
    ----------
    spans
        Consecutive, sharing their border frames, covering the sketch.
    synthesis_band
        Highest-frequency band kept in synthesized channels.
    heading_band
        The match band of the recipe itself: what is slower is heading.
    notes
        What could not be as asked.
    """

    spans: tuple[Span, ...]
    synthesis_band: int
    heading_band: int
    notes: tuple[str, ...] = ()

    @property
    def borders(self) -> tuple[int, ...]:
        """Frames where one span hands over to the next."""
        return tuple(span.first for span in self.spans[1:])

    @property
    def copied(self) -> tuple[Channel, ...]:
        """Every channel that is textured or synthesized somewhere, sorted."""
        return tuple(sorted(frozenset().union(*(span.texture | span.synthesize for span in self.spans))))

    @property
    def used(self) -> tuple[Channel, ...]:
        """Every channel with a role, matching and breaking included, sorted."""
        read = {channel for span in self.spans for channel in (*span.match, span.break_channel)}
        return tuple(sorted({*self.copied, *read}))

    def span_at(self, frame: int) -> Span:
        """Give the span a fragment that begins at a frame belongs to."""
        return next(span for span in reversed(self.spans) if span.first <= frame)

    def weights(
        self, channels: Sequence[Channel], has_role: Callable[[Span], frozenset[Channel]], join_frames: int
    ) -> FloatArray:
        """Give how far channels have a role at every frame, 0 to 1, shape [F, C]."""
        steps = np.zeros((self.spans[-1].last + 1, len(channels)))
        for span in self.spans:
            members = has_role(span)
            steps[span.first : span.last + 1] = [channel in members for channel in channels]
        return ramp(steps, join_frames)


def ramp(steps: FloatArray, frames: int) -> FloatArray:
    """Turn steps along the first axis into smooth ramps of so many frames, centred on the step."""
    if frames < 2 or not np.diff(steps, axis=0).any():
        return steps
    window = np.hanning(2 * (frames // 2) + 3)
    margin = len(window) // 2
    padded = np.pad(steps, ((margin, margin), (0, 0)), mode="edge")
    smooth = [np.convolve(column, window / window.sum(), mode="valid") for column in padded.T]
    # Rounded, so that all and nothing are exactly that.
    return np.asarray(np.clip(np.round(np.stack(smooth, axis=1), 12), 0.0, 1.0))


def resolve_roles(recipe: Recipe, sketch: Clip, animated: tuple[Channel, ...]) -> Roles:
    """Resolve a recipe against the sketch.

    Parameters
    ----------
    recipe
        Tokens, bands and segments as authored.
    sketch
        The sketch on the frame grid.
    animated
        Channels that move in the sketch, for an empty match list; the first is where it breaks.

    Returns
    -------
    Roles
        Bands filled in by frequency and limited to what the sketch is long enough for.

    Raises
    ------
    InputError
        Unknown joints or channels, a channel both textured and synthesized, nothing to texture or synthesize, nothing
        to match, or a segment outside the sketch.
    """
    spans = tuple(
        _resolve_span(settings, recipe, sketch, animated, first, last)
        for first, last, settings in _divide(recipe.segments, sketch)
    )
    if not any(span.texture or span.synthesize for span in spans):
        raise InputError(
            f"{sketch.name}: nothing to do",
            expected="channels in mtex:texture or mtex:synthesize",
            found="both empty",
        )
    return Roles(
        spans,
        recipe.synthesis_band or nearest_band(SYNTHESIS_HZ, sketch.rate),
        _match_band(recipe.match_band, sketch),
        _band_notes(recipe, sketch),
    )


def _band_notes(recipe: Recipe, sketch: Clip) -> tuple[str, ...]:
    """Say where a match band is lower than the sketch is long enough for."""
    asked = {recipe.match_band, *(segment.match_band or 0 for segment in recipe.segments)}
    wanted = {band or nearest_band(MATCH_HZ, sketch.rate) for band in asked}
    limit, frames = band_limit(sketch.frame_count), sketch.frame_count
    return tuple(
        f"band {band} is too slow for a sketch of {frames} frames: matched on band {max(1, limit)}"
        for band in sorted(wanted)
        if band > limit
    )


def _divide(segments: Sequence[Segment], sketch: Clip) -> list[tuple[int, int, Segment | None]]:
    """Give frame ranges that cover the sketch, each with its segment or None."""
    last = sketch.frame_count - 1
    pieces: list[tuple[int, int, Segment | None]] = []
    at = 0
    for segment in sorted(segments, key=lambda s: s.start):
        start, end = _segment_frames(segment, sketch)
        # A segment that begins a frame after the one before ended leaves no frames between them.
        start = at if start <= at + 1 and pieces else start
        if start > at:
            pieces.append((at, start, None))
        pieces.append((start, end, segment))
        at = end
    if at < last or not pieces:
        pieces.append((at, last, None))
    return pieces


def _segment_frames(segment: Segment, sketch: Clip) -> tuple[int, int]:
    last = sketch.frame_count - 1
    start, end = ((t - sketch.start) / sketch.time_codes_per_frame for t in (segment.start, segment.end))
    first_frame, last_frame = max(0, round(start)), min(last, round(end))
    if last_frame <= first_frame:
        raise InputError(
            f"{sketch.name}: segment {segment.name!r} holds no frames of the sketch",
            expected=f"a range within {sketch.time_codes[0]:g} to {sketch.time_codes[-1]:g}",
            found=f"{segment.start:g} to {segment.end:g}",
        )
    return first_frame, last_frame


def _merge(recipe: Recipe, segment: Segment | None) -> Recipe:
    """Give the recipe as it stands within a segment."""
    if segment is None:
        return recipe
    authored = {
        name: value
        for name in ("match", "break_channel", "match_band", "texture", "synthesize", "texture_bands", "scale")
        if (value := getattr(segment, name)) is not None
    }
    return replace(recipe, **authored)


def _resolve_span(
    segment: Segment | None, recipe: Recipe, sketch: Clip, animated: tuple[Channel, ...], first: int, last: int
) -> Span:
    settings = _merge(recipe, segment)
    where = f"{sketch.name}, segment {segment.name}" if segment else sketch.name
    texture = resolve_channels(settings.texture, sketch.joints, source=f"{where}: texture")
    synthesize = resolve_channels(settings.synthesize, sketch.joints, source=f"{where}: synthesize")
    _forbid_both(texture, synthesize, sketch.joints, where)
    match = resolve_channels(settings.match, sketch.joints, source=f"{where}: match")
    match = match or tuple(channel for channel in animated if channel not in synthesize)
    if not match:
        raise InputError(f"{where}: nothing to match", expected="an animated channel, not synthesized", found="none")
    broken = resolve_channels(
        [settings.break_channel] if settings.break_channel else [], sketch.joints, source=f"{where}: break"
    )
    return Span(
        first=first,
        last=last,
        match=match,
        break_channel=_break_channel(broken, match, settings.break_channel, where),
        match_band=_match_band(settings.match_band, sketch),
        texture=frozenset(texture),
        synthesize=frozenset(synthesize),
        texture_bands=_texture_bands(settings.texture_bands, sketch.rate),
        scale=settings.scale,
    )


def _forbid_both(texture: Sequence[Channel], synthesize: Sequence[Channel], joints: Sequence[str], where: str) -> None:
    both = sorted(set(texture) & set(synthesize))
    if both:
        raise InputError(
            f"{where}: channels are both textured and synthesized",
            expected="one of the two for each channel",
            found=", ".join(channel.name(joints) for channel in both),
        )


def _break_channel(named: Sequence[Channel], match: Sequence[Channel], token: str, where: str) -> Channel:
    if not named:
        return match[0]
    if len(named) > 1:
        raise InputError(f"{where}: break names several channels", expected="one, such as LeftUpLeg.rx", found=token)
    return named[0]


def _match_band(requested: int, sketch: Clip) -> int:
    """Give the band to match on, at most the lowest the sketch is long enough for."""
    wanted = requested or nearest_band(MATCH_HZ, sketch.rate)
    return max(1, min(wanted, band_limit(sketch.frame_count)))


def _texture_bands(requested: tuple[int, int], rate: float) -> tuple[int, int]:
    """Fill in what is 0 by frequency, but no further than the band that is given."""
    first, last = requested
    usual_first, usual_last = (nearest_band(hz, rate) for hz in TEXTURE_HZ)
    return first or min(usual_first, last or usual_first), last or max(usual_last, first)
