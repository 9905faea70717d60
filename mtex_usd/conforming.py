"""Shots and timelines: the paths of a run written for editorial, and edited timelines made into variants."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from mtex_usd.editorial.placing import place_track
from mtex_usd.editorial.reading import EditedTimeline, EditedTrack, read_timeline, select_tracks
from mtex_usd.editorial.records import FrameGrid, SketchPaths, TakeMedia, TimelineHead
from mtex_usd.editorial.writing import build_timeline
from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip
from mtex_usd.processing import finish_job
from mtex_usd.results import PathVariant, Result, list_retargets
from mtex_usd.texture.given import texture_given
from mtex_usd.texture.recipe import Recipe
from mtex_usd.usd.arguments import FilePath, PrimPath, as_file_path, as_prim_paths
from mtex_usd.usd.characters import Character
from mtex_usd.usd.clip_io import ClipReader
from mtex_usd.usd.edit_stacks import EditReader
from mtex_usd.usd.finished import Finished, build_result
from mtex_usd.usd.names import make_unique_names
from mtex_usd.usd.outputs import find_output, write_outputs
from mtex_usd.usd.override import ORIGINAL, CharacterResult, variant_names
from mtex_usd.usd.shot import Cast, Job, find_cast, read_jobs
from mtex_usd.usd.source_stage import SourceStage, open_source
from mtex_usd.usd.take_files import find_take_file
from mtex_usd.usd.thin_root import thin_root_path
from mtex_usd.version import VERSION

__all__ = ["conform", "describe_timeline"]

_MAKER = "usdmtex-conform"
_TIMELINE_KEY = "timeline"  # in a variant's customData["mtex"]: which timeline and track it was made from


@dataclass(frozen=True, eq=False, kw_only=True)
class _Made:
    """The tracks of one character made into variants."""

    finished: Finished
    result: CharacterResult
    notes: tuple[str, ...]


def describe_timeline(source: SourceStage, finished: Sequence[Finished]) -> str:
    """Give the paths of a run as the text of an OpenTimelineIO file.

    Parameters
    ----------
    source
        The shot.
    finished
        What was made of its sketches, at least one.

    Returns
    -------
    str
        For :func:`mtex_usd.editorial.files.write_timeline_text`.
    """
    used = {use.take for each in finished for variant in each.motion.variants for use in variant.fragments}
    reader = EditReader(source.stage, ClipReader(source.stage))
    takes = {
        name: _describe_take(source, name, reader.read_take(source.stage.GetPrimAtPath(name))) for name in sorted(used)
    }
    bands = [each.recipe.match_band for each in finished if each.recipe.match_band != each.job.recipe.match_band]
    head = TimelineHead(
        shot=source.source_path.absolute(), version=VERSION, options={"band": bands[0]} if bands else {}
    )
    return build_timeline(head, [_describe_paths(each) for each in finished], takes)


def _describe_take(source: SourceStage, prim_path: str, clip: Clip) -> TakeMedia:
    return TakeMedia(
        prim_path=prim_path, file_path=find_take_file(source.stage, prim_path), grid=FrameGrid.of_clip(clip)
    )


def _describe_paths(finished: Finished) -> SketchPaths:
    character, variants = finished.job.character, finished.motion.variants
    return SketchPaths(
        anim=str(character.animation),
        model=str(character.model),
        variant_set=character.variant_set,
        grid=FrameGrid.of_clip(finished.motion.sketch),
        variants=dict(zip(variant_names(len(variants)), variants, strict=True)),
        max_stretch=finished.recipe.max_stretch,
        recipe_digest=_digest(finished.job.recipe),
    )


def _digest(recipe: Recipe) -> str:
    return hashlib.sha256(repr(recipe).encode()).hexdigest()


def conform(
    timeline_path: FilePath,
    stage_path: FilePath,
    *,
    out: FilePath | None = None,
    anim: PrimPath | Sequence[PrimPath] = (),
    tracks: str | Sequence[str] = (),
    select: str | None = None,
    dry_run: bool = False,
) -> tuple[Result, ...]:
    """Make the tracks of an edited timeline into variants, as the paths they were written from were made.

    Parameters
    ----------
    timeline_path
        The .otio file.
    stage_path
        The shot, or the thin root of an earlier run. It and all it is made of stay as they are.
    out
        The override layer; by default ``<shot>.conform.usd`` beside the shot.
    anim
        Prim path or paths of the sketches; by default all that the timeline has tracks for.
    tracks
        Name or names of the tracks; by default all.
    select
        The variant to select; by default the user's earlier choice, else the first track's.
    dry_run
        Do everything but write.

    Returns
    -------
    tuple of Result
        One per sketch and character with tracks; variants are named as the tracks.

    Raises
    ------
    InputError
        A timeline that is damaged or cannot be followed, naming clip and time; nothing is written.
    StageError
        No such sketch, nothing that plays it, or a stronger opinion in the way.
    NoSolutionError
        Where contacts cannot be held together.
    ResultError
        What was written does not read back as computed.
    """
    timeline = read_timeline(as_file_path(timeline_path, "timeline"))
    source = open_source(as_file_path(stage_path, "stage"))
    target = find_output(source, out, word="conform", maker=_MAKER)
    wanted = select_tracks(timeline, (tracks,) if isinstance(tracks, str) else tracks)
    parts, cast = _assign(timeline, wanted, source, as_prim_paths(anim, "anim"), target)
    made = [_conform(job, parts[job.character], source, timeline) for job in read_jobs(source.stage, list(parts))]
    built = [each.result for each in made]
    keep = [*cast.others, *(character for character in cast.wanted if character not in parts)]
    write_outputs(source.stage, built, target, maker=_MAKER, select=select, keep=keep, dry_run=dry_run)
    return tuple(_describe(each, target) for each in made)


def _assign(
    timeline: EditedTimeline,
    tracks: Sequence[EditedTrack],
    source: SourceStage,
    asked: Sequence[str],
    target: Path,
) -> tuple[dict[Character, tuple[EditedTrack, ...]], Cast]:
    """Give each character its tracks."""
    said = dict.fromkeys(track.anim for track in tracks)
    cast = find_cast(source.stage, only=asked or (() if "" in said else tuple(said)), previous=target)
    parts: dict[Character, tuple[EditedTrack, ...]] = {}
    for track in tracks:
        if not asked or track.anim in ("", *asked):
            character = _find_character(track, cast, timeline)
            parts[character] = (*parts.get(character, ()), track)
    if not parts:
        raise InputError(
            f"{timeline.file_path} has no track for {', '.join(asked)}",
            expected=f"one of {', '.join(said)}",
            fix="Name another sketch with --anim.",
        )
    return parts, cast


def _find_character(track: EditedTrack, cast: Cast, timeline: EditedTimeline) -> Character:
    found = [
        character
        for character in cast.wanted
        if track.anim in ("", str(character.animation)) and track.model in ("", str(character.model))
    ]
    if len(found) == 1:
        return found[0]
    raise InputError(
        f"{timeline.file_path}: track {track.name} does not say which sketch it is for",
        expected="one of " + ", ".join(f"{each.animation} on {each.model}" for each in cast.wanted),
        found=f"{track.anim or 'none'} on {track.model or 'none'}",
        fix="Name one sketch with --anim.",
    )


def _conform(job: Job, tracks: Sequence[EditedTrack], source: SourceStage, timeline: EditedTimeline) -> _Made:
    takes = {take.clip.name: _describe_take(source, take.clip.name, take.clip) for take in job.takes}
    recipe = job.recipe if timeline.band is None else replace(job.recipe, match_band=timeline.band)
    grid = FrameGrid.of_clip(job.sketch)
    placed = [place_track(track, grid, takes, max_stretch=recipe.max_stretch) for track in tracks]
    texturing = partial(texture_given, paths=[each.fragments for each in placed])
    finished = finish_job(job, recipe, texturing=texturing)
    return _Made(
        finished=finished,
        result=_name_variants(finished, tracks, timeline),
        notes=(
            *timeline.notes,
            *(note for each in placed for note in each.notes),
            *_list_changed(job, tracks),
            *finished.motion.notes,
        ),
    )


def _name_variants(finished: Finished, tracks: Sequence[EditedTrack], timeline: EditedTimeline) -> CharacterResult:
    """Give what the variants will say, named as their tracks."""
    result = build_result(finished)
    names = make_unique_names([ORIGINAL, *(track.variant for track in tracks)])[1:]
    variants = tuple(
        replace(
            variant,
            custom_data={
                **variant.custom_data,
                _TIMELINE_KEY: {"file": timeline.file_path.name, "track": track.name},
            },
        )
        for variant, track in zip(result.variants, tracks, strict=True)
    )
    return replace(result, names=names, variants=variants)


def _list_changed(job: Job, tracks: Sequence[EditedTrack]) -> list[str]:
    digest = _digest(job.recipe)
    return [
        f"the recipe has changed since track {track.name} was written"
        for track in tracks
        if track.recipe not in ("", digest)
    ]


def _describe(made: _Made, target: Path) -> Result:
    character, motion = made.finished.job.character, made.finished.motion
    variants = zip(made.result.names, motion.variants, made.result.variants, strict=True)
    return Result(
        anim=str(character.animation),
        model=str(character.model),
        variantSet=character.variant_set,
        variants=tuple(PathVariant(name, variant, dict(samples.custom_data)) for name, variant, samples in variants),
        texturing=motion,
        retargets=list_retargets(made.finished.job.takes),
        layer=target,
        stage=thin_root_path(target),
        notes=made.notes,
    )
