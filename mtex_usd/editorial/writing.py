"""Paths as an OpenTimelineIO timeline: a track per path, a clip per fragment."""

from collections.abc import Mapping, Sequence

import opentimelineio as otio

from mtex_usd.editorial.files import seal_timeline
from mtex_usd.editorial.records import FORMAT, FrameGrid, SketchPaths, TakeMedia, TimelineHead
from mtex_usd.files import GENERATOR
from mtex_usd.texture.result import FragmentUse, Variant

__all__ = ["build_timeline"]


def build_timeline(head: TimelineHead, sketches: Sequence[SketchPaths], takes: Mapping[str, TakeMedia]) -> str:
    """Give a shot's timeline as the text of an .otio file.

    Parameters
    ----------
    head
        What it says about itself.
    sketches
        At least one. Of one sketch tracks are named as its variants; of several, with the sketch's name before.
    takes
        Every take that is used, by prim path.

    Returns
    -------
    str
        JSON in OpenTimelineIO's own form; the same for the same arguments.
    """
    timeline = otio.schema.Timeline(name=head.shot.stem)
    grid = sketches[0].grid
    timeline.global_start_time = otio.opentime.RationalTime(grid.first_frame, grid.rate)
    timeline.metadata["mtex"] = {
        "generator": GENERATOR,
        "format": FORMAT,
        "version": head.version,
        "shot": head.shot.as_posix(),
        "options": dict(head.options),
    }
    prefixes = _make_prefixes(sketches)
    for sketch, prefix in zip(sketches, prefixes, strict=True):
        for name, variant in sketch.variants.items():
            timeline.tracks.append(_build_track(prefix + name, name, variant, sketch, takes))
    return seal_timeline(str(timeline.to_json_string(indent=4)))


def _make_prefixes(sketches: Sequence[SketchPaths]) -> list[str]:
    """What stands before the names of tracks, so that no two are called the same."""
    if len(sketches) == 1:
        return [""]
    names = [_last_name(sketch.anim) for sketch in sketches]
    if len(set(names)) < len(names):
        names = [f"{_last_name(sketch.model)}_{name}" for sketch, name in zip(sketches, names, strict=True)]
    if len(set(names)) < len(names):
        names = [f"{name}_{number}" for number, name in enumerate(names, start=1)]
    return [f"{name}_" for name in names]


def _last_name(prim_path: str) -> str:
    return prim_path.rpartition("/")[2]


def _build_track(
    track_name: str, variant_name: str, variant: Variant, sketch: SketchPaths, takes: Mapping[str, TakeMedia]
) -> otio.schema.Track:
    track = otio.schema.Track(name=track_name, kind=otio.schema.TrackKind.Video)
    track.metadata["mtex"] = {
        "anim": sketch.anim,
        "model": sketch.model,
        "variantSet": sketch.variant_set,
        "variant": variant_name,
        "track": track_name,
        "rank": variant.rank,
        "distance": variant.distance,
        "zeroCostJoins": variant.zero_cost_joins,
        "recipe": sketch.recipe_digest,
    }
    for number, use in enumerate(variant.fragments, start=1):
        # The last frame of the shot is nobody's first, so the last clip has it.
        extra = 1 if number == len(variant.fragments) else 0
        track.append(_build_clip(use, extra, variant.rank, sketch, takes[use.take]))
    return track


def _build_clip(use: FragmentUse, extra: int, rank: int, sketch: SketchPaths, take: TakeMedia) -> otio.schema.Clip:
    length = round((use.end - use.start) / sketch.grid.time_codes_per_frame)
    stretch = (use.take_end - use.take_start) / (use.end - use.start)
    rate = take.grid.rate
    begin = use.take_start / take.grid.time_codes_per_frame
    source_range = otio.opentime.TimeRange(
        start_time=otio.opentime.RationalTime(begin, rate),
        duration=otio.opentime.RationalTime((length + extra) * (rate / sketch.grid.rate), rate),
    )
    clip = otio.schema.Clip(name=take.name, media_reference=_build_media(take), source_range=source_range)
    clip.effects.append(otio.schema.LinearTimeWarp(name="stretch", time_scalar=stretch))
    clip.metadata["mtex"] = {
        "take": use.take,
        "takeStart": use.take_start,
        "takeEnd": use.take_end,
        "start": use.start,
        "end": use.end,
        "rank": rank,
        "distance": use.distance,
        "scale": use.scale,
        "band": use.band,
        "stretchLifted": stretch > sketch.max_stretch,
    }
    return clip


def _build_media(take: TakeMedia) -> otio.schema.ExternalReference:
    media = otio.schema.ExternalReference(
        target_url=take.file_path.as_uri(), available_range=_available_range(take.grid)
    )
    media.name = take.name
    media.metadata["mtex"] = {"take": take.prim_path}
    return media


def _available_range(grid: FrameGrid) -> otio.opentime.TimeRange:
    return otio.opentime.TimeRange(
        start_time=otio.opentime.RationalTime(grid.first_frame, grid.rate),
        duration=otio.opentime.RationalTime(grid.frame_count, grid.rate),
    )
