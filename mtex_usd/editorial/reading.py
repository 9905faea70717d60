"""Timelines read: their tracks, and what they say they were made of."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import opentimelineio as otio

from mtex_usd.editorial.files import parse_timeline, read_timeline_text
from mtex_usd.editorial.records import mark_of
from mtex_usd.errors import InputError

__all__ = ["EditedTimeline", "EditedTrack", "read_timeline", "select_tracks"]

# What OpenTimelineIO raises at objects that are not as they should be.
_DAMAGE = (ValueError, LookupError, TypeError, OverflowError, RuntimeError, otio.exceptions.OTIOError)


@dataclass(frozen=True, eq=False, kw_only=True)
class EditedTrack:
    """A track of a timeline.

    Parameters
    ----------
    name
        As the timeline has it; its number where it has none.
    anim, model
        Sketch and prim with the variant set that it was written for; empty where it does not say.
    recipe
        Digest of the recipe it was written with; empty where it does not say.
    variant
        What its variant is to be called: as the one it was written from, unless the track was renamed.
    track
        The track itself.
    """

    name: str
    anim: str
    model: str
    recipe: str
    variant: str
    track: otio.schema.Track


@dataclass(frozen=True, eq=False, kw_only=True)
class EditedTimeline:
    """A timeline, however it was edited.

    Parameters
    ----------
    file_path
        Where it was read from.
    band
        The match band that stood on the command line when it was written, else None.
    tracks
        Those of pictures; sound is nothing to us.
    notes
        What a user should know.
    """

    file_path: Path
    band: int | None
    tracks: tuple[EditedTrack, ...]
    notes: tuple[str, ...]


def read_timeline(file_path: Path) -> EditedTimeline:
    """Read a timeline; its tracks' items are not looked at yet.

    Parameters
    ----------
    file_path
        An .otio file, written by us and edited, or like one.

    Raises
    ------
    InputError
        Where it cannot be read, is damaged, is no timeline, or has no track.
    """
    timeline = _load(file_path)
    children = list(timeline.tracks)
    for child in children:
        if not isinstance(child, otio.schema.Track):
            raise InputError(
                f"{file_path}: {_describe(child)} lies between the tracks",
                expected="a timeline of tracks, nothing nested in it",
                fix="Flatten it in the editing application.",
            )
    if timeline.tracks.source_range is not None or list(timeline.tracks.effects):
        raise InputError(
            f"{file_path}: the timeline as a whole is trimmed or has an effect", fix="Edit its clips instead."
        )
    pictures = [track for track in children if track.kind == otio.schema.TrackKind.Video]
    if not pictures:
        raise InputError(f"{file_path} has no track", expected="at least one track of pictures")
    return EditedTimeline(
        file_path=file_path,
        band=_read_band(timeline, file_path),
        tracks=tuple(_read_track(track, number) for number, track in enumerate(pictures, start=1)),
        notes=tuple(f"track {track.name} is sound and left out" for track in children if track not in pictures),
    )


def _load(file_path: Path) -> otio.schema.Timeline:
    text = read_timeline_text(file_path)
    parse_timeline(text, str(file_path))
    try:
        loaded = otio.core.deserialize_json_from_string(text)
    except _DAMAGE as error:
        raise InputError(f"{file_path} is damaged", expected="an OpenTimelineIO file", found=str(error)) from error
    if not isinstance(loaded, otio.schema.Timeline) or loaded.tracks is None:
        raise InputError(f"{file_path} is no timeline", expected="a Timeline", found=_describe(loaded))
    return loaded


def _describe(found: object) -> str:
    name = getattr(found, "name", "")
    return f"{type(found).__name__} {name}".strip()


def _text_of(mark: Mapping[str, object], key: str) -> str:
    value = mark.get(key)
    return value if isinstance(value, str) else ""


def _read_band(timeline: otio.schema.Timeline, file_path: Path) -> int | None:
    options = mark_of(timeline.metadata).get("options")
    band = options.get("band") if isinstance(options, Mapping) else None
    if band is None or (isinstance(band, int) and not isinstance(band, bool) and band >= 1):
        return band
    raise InputError(f"{file_path}: bad option band", expected="a whole number of at least 1", found=repr(band))


def _read_track(track: otio.schema.Track, number: int) -> EditedTrack:
    mark = mark_of(track.metadata)
    name = track.name or f"track_{number:02d}"
    return EditedTrack(
        name=name,
        anim=_text_of(mark, "anim"),
        model=_text_of(mark, "model"),
        recipe=_text_of(mark, "recipe"),
        # Of several sketches tracks are called by sketch and variant, so that no two are called the same.
        variant=(_text_of(mark, "variant") if name == _text_of(mark, "track") else "") or name,
        track=track,
    )


def select_tracks(timeline: EditedTimeline, names: Sequence[str]) -> tuple[EditedTrack, ...]:
    """Give the tracks of some names in the timeline's order; all where none are named.

    Parameters
    ----------
    timeline
        The timeline.
    names
        Names of tracks.

    Raises
    ------
    InputError
        Where there is no track of a name.
    """
    there_are = [track.name for track in timeline.tracks]
    missing = [name for name in names if name not in there_are]
    if missing:
        raise InputError(f"{timeline.file_path} has no track {missing[0]}", expected=f"one of {', '.join(there_are)}")
    return tuple(track for track in timeline.tracks if not names or track.name in names)
