"""From a track to fragments: every clip's place on the sketch and its part of the take, or why that cannot be."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import opentimelineio as otio

from mtex_usd.editorial.media import find_take
from mtex_usd.editorial.reading import EditedTrack
from mtex_usd.editorial.records import FrameGrid, TakeMedia, mark_of
from mtex_usd.errors import InputError
from mtex_usd.texture.given import GivenFragment

__all__ = ["PlacedTrack", "place_track"]

# Times this near a frame, in frames, are that frame: other applications keep times in fewer digits.
_SAME_FRAME = 1e-3
_SAME_SPEED = 1e-6
# Beyond these it is damage and no edit.
_LONGEST_S = 1e8
_FASTEST = 1e6


@dataclass(frozen=True, kw_only=True)
class PlacedTrack:
    """A track as fragments of a path.

    Parameters
    ----------
    fragments
        From the sketch's first frame through its last.
    notes
        What was not as exact as the track has it.
    """

    fragments: tuple[GivenFragment, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class _Item:
    """A clip with its place, in frames of the shot from its first."""

    clip: otio.schema.Clip
    where: str
    begin: float
    end: float
    media_begin_s: float
    stretch: float


def place_track(
    track: EditedTrack, grid: FrameGrid, takes: Mapping[str, TakeMedia], *, max_stretch: float
) -> PlacedTrack:
    """Give the fragments that a track's clips stand for.

    Parameters
    ----------
    track
        As :func:`mtex_usd.editorial.reading.read_timeline` gives it.
    grid
        Frames of the sketch.
    takes
        The takes of the recipe by prim path, their frames at the sketch's rate.
    max_stretch
        Longest part of a take, in lengths of its place on the sketch.

    Raises
    ------
    InputError
        Naming the clip and its time code: gaps, transitions and what else is no clip; takes that are not the recipe's;
        parts outside a take; time warps that are not one even, forward stretch within the limit; clips without a frame
        of their own; clips that together are longer or shorter than the sketch.
    """
    _check_plain(track)
    items: list[_Item] = []
    position = 0.0
    for child in track.track:
        items.append(_read_item(child, position, track, grid))
        position = items[-1].end
    _check_length(track, items, grid)
    fragments = [_place(item, grid, takes, max_stretch) for item in items]
    notes = _list_notes(items, fragments)
    return PlacedTrack(fragments=tuple(_heal(items, _meet(fragments))), notes=tuple(notes))


def _check_plain(track: EditedTrack) -> None:
    if track.track.source_range is not None or list(track.track.effects):
        raise InputError(f"track {track.name} is trimmed or has an effect as a whole", fix="Edit its clips instead.")


def _read_item(child: object, position: float, track: EditedTrack, grid: FrameGrid) -> _Item:
    name = getattr(child, "name", "") or type(child).__name__
    where = f"track {track.name}: {name} at {grid.time_code_at(position):g}"
    if not isinstance(child, otio.schema.Clip):
        raise _refuse_child(child, where)
    if not child.enabled:
        raise InputError(f"{where} is disabled, which leaves a gap", expected="clips end to end", fix="Enable it.")
    begin_s, length_s = _read_range(child, where)
    return _Item(
        clip=child,
        where=where,
        begin=position,
        end=position + length_s * grid.rate,
        media_begin_s=begin_s,
        stretch=_read_stretch(child, where),
    )


def _refuse_child(child: object, where: str) -> InputError:
    if isinstance(child, otio.schema.Gap):
        return InputError(f"{where}: a gap", expected="clips end to end", fix="Close it; every frame needs a take.")
    if isinstance(child, otio.schema.Transition):
        return InputError(
            f"{where}: clips overlap in a transition", expected="cuts", fix="Remove it; joins are blended on their own."
        )
    return InputError(f"{where}: {type(child).__name__} nested in the track", expected="clips", fix="Flatten it.")


def _read_range(clip: otio.schema.Clip, where: str) -> tuple[float, float]:
    """Begin in the take and length in the track, seconds."""
    try:
        trimmed = clip.trimmed_range()
    except otio.exceptions.OTIOError as error:
        raise InputError(f"{where} has no range", expected="a source range", found=str(error)) from error
    seconds = [
        time.value / time.rate if time.rate > 0.0 else math.nan for time in (trimmed.start_time, trimmed.duration)
    ]
    if not all(abs(second) <= _LONGEST_S for second in seconds):
        raise InputError(f"{where}: bad source range", expected="finite times at rates above 0", found=str(trimmed))
    return seconds[0], seconds[1]


def _read_stretch(clip: otio.schema.Clip, where: str) -> float:
    effects = [effect for effect in clip.effects if effect.enabled]
    if not effects:
        return 1.0
    if len(effects) > 1 or not isinstance(effects[0], otio.schema.LinearTimeWarp):
        raise InputError(
            f"{where}: effects that a take cannot follow",
            expected="one LinearTimeWarp, or none",
            found=", ".join(type(effect).__name__ for effect in effects),
        )
    stretch = float(effects[0].time_scalar)
    if not 0.0 < stretch <= _FASTEST:
        kind = "stands still" if stretch == 0.0 else "runs backwards" if stretch < 0.0 else "cannot be followed"
        raise InputError(f"{where}: the time warp {kind}", expected="a time scalar above 0", found=f"{stretch:g}")
    return stretch


def _check_length(track: EditedTrack, items: list[_Item], grid: FrameGrid) -> None:
    found = items[-1].end if items else 0.0
    if items and round(found) == grid.frame_count:
        return
    last = f"; the last clip, {items[-1].where.partition(': ')[2]}, ends there" if items else ""
    raise InputError(
        f"track {track.name}: its clips end at {grid.time_code_at(found):g}{last}",
        expected=f"{grid.frame_count} frames, to end at {grid.time_code_at(grid.frame_count):g}",
        found=f"{found:g} frames",
        fix="Make the clips as long together as the sketch.",
    )


def _place(item: _Item, grid: FrameGrid, takes: Mapping[str, TakeMedia], max_stretch: float) -> GivenFragment:
    take = find_take(item.clip, item.where, takes)
    first, end = round(item.begin), round(item.end)
    is_last = end == grid.frame_count
    last = end - 1 if is_last else end
    if last <= first:
        raise InputError(f"{item.where} is too short", expected="a length of two frames" if is_last else "a frame")
    begin = _snap(item.media_begin_s * grid.rate - take.grid.first_frame)
    stop = _snap(begin + item.stretch * (item.end - item.begin - (1.0 if is_last else 0.0)))
    begin, stop = _check_range(item, take, begin, stop)
    _check_stretch(item, stop - begin, last - first, max_stretch)
    return GivenFragment(first=first, last=last, take=take.prim_path, take_first=begin, take_last=stop)


def _snap(frame: float) -> float:
    nearest = float(round(frame))
    return nearest if abs(frame - nearest) <= _SAME_FRAME else frame


def _check_range(item: _Item, take: TakeMedia, begin: float, stop: float) -> tuple[float, float]:
    """Refuse what the take has not; an end right after its last frame is that frame."""
    frames = take.grid.frame_count
    if begin < 0.0 or stop > frames:
        at = take.grid.time_code_at
        raise InputError(
            f"{item.where}: outside the take {take.prim_path}",
            expected=f"a part of {at(0):g} to {at(frames - 1):g} in the take's time codes",
            found=f"{at(begin):g} to {at(stop):g}",
            fix="Move the source range, shorten the clip, or slow its time warp down.",
        )
    return begin, min(stop, float(frames - 1))


def _check_stretch(item: _Item, taken: float, length: int, max_stretch: float) -> None:
    if taken < 1.0 - _SAME_FRAME:
        raise InputError(f"{item.where} plays {taken:g} frames of its take", expected="at least one")
    lifted = mark_of(item.clip.metadata).get("stretchLifted") is True
    if taken > max_stretch * length + _SAME_FRAME and not lifted:
        raise InputError(
            f"{item.where}: the time warp does not fit",
            expected=f"at most {max_stretch:g} times as fast as the take (mtex:maxStretch)",
            found=f"{taken / length:.4g}",
            fix="Use a shorter part of the take, or raise mtex:maxStretch.",
        )


def _meet(fragments: list[GivenFragment]) -> list[GivenFragment]:
    """Let what goes on in the same take go on at the very same place."""
    met = fragments[:1]
    for fragment in fragments[1:]:
        before = met[-1]
        goes_on = before.take == fragment.take and abs(before.take_last - fragment.take_first) <= _SAME_FRAME
        met.append(replace(fragment, take_first=before.take_last) if goes_on else fragment)
    return met


def _heal(items: list[_Item], fragments: list[GivenFragment]) -> list[GivenFragment]:
    """Put together what a razor cut and nobody moved: a clip in two halves plays as it did."""
    healed, before = fragments[:1], items[0]
    for item, fragment in zip(items[1:], fragments[1:], strict=True):
        if _is_through(before, item) and healed[-1].take_last == fragment.take_first:
            healed[-1] = replace(healed[-1], last=fragment.last, take_last=fragment.take_last)
        else:
            healed.append(fragment)
        before = item
    return healed


def _is_through(before: _Item, after: _Item) -> bool:
    """Whether two clips are parts of one that we wrote, at one speed."""
    marks = [mark_of(item.clip.metadata) for item in (before, after)]
    origins = [[mark.get(key) for key in ("take", "start", "end", "takeStart", "takeEnd")] for mark in marks]
    same_speed = math.isclose(before.stretch, after.stretch, rel_tol=_SAME_SPEED)
    return same_speed and None not in origins[0] and origins[0] == origins[1]


def _list_notes(items: list[_Item], fragments: list[GivenFragment]) -> list[str]:
    notes = []
    for item, fragment in zip(items, fragments, strict=True):
        if abs(item.begin - round(item.begin)) > _SAME_FRAME:
            notes.append(f"{item.where}: the cut lies between frames and is moved to the nearest")
        was = mark_of(item.clip.metadata).get("take", fragment.take)
        if was != fragment.take:
            notes.append(f"{item.where}: was {was}, its media is {fragment.take} now")
    return notes
