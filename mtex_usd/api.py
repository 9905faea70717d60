"""What pipelines call from Python; the commands are thin layers over it."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from mtex_usd.constraining import constrain, find_contacts
from mtex_usd.editing import apply_edits
from mtex_usd.importing import (
    FailedFile,
    ImportResult,
    import_takes,
    list_takes,
)
from mtex_usd.motion.arguments import as_whole_number
from mtex_usd.presenting import Presentation, check_presentation, prepare_presentation
from mtex_usd.processing import finish_job
from mtex_usd.progress import ProgressCallback, report_progress
from mtex_usd.results import PathVariant, Result, list_retargets
from mtex_usd.usd.arguments import FilePath, PrimPath, as_file_path, as_prim_paths
from mtex_usd.usd.clip_io import read_clip, write_clip
from mtex_usd.usd.finished import Finished, build_result, describe_variants
from mtex_usd.usd.outputs import write_outputs
from mtex_usd.usd.override import ORIGINAL, check_outputs, variant_names
from mtex_usd.usd.plugin import registration_status
from mtex_usd.usd.selection import check_selection
from mtex_usd.usd.shot import find_cast, read_jobs
from mtex_usd.usd.source_stage import find_override, open_source
from mtex_usd.usd.thin_root import thin_root_path

__all__ = [
    "FailedFile",
    "ImportResult",
    "ProgressCallback",
    "apply_edits",
    "constrain",
    "find_contacts",
    "find_outputs",
    "import_takes",
    "list_takes",
    "process",
    "read_clip",
    "write_clip",
]


_MAKER = "usdmtex"


def process(  # noqa: PLR0913  (one for each option of the command)
    stage_path: FilePath,
    *,
    out: FilePath | None = None,
    anim: PrimPath | Sequence[PrimPath] = (),
    paths: int | None = None,
    candidates: int | None = None,
    band: int | None = None,
    select: str | None = None,
    timeline: FilePath | None = None,
    report: FilePath | None = None,
    sheet: FilePath | None = None,
    command: str = "",
    dry_run: bool = False,
    progress: ProgressCallback | None = None,
) -> tuple[Result, ...]:
    """Texture and synthesize every sketch of a shot into an override layer.

    Parameters
    ----------
    stage_path
        The shot, or the thin root of an earlier run. It and all it is made of stay as they are.
    out
        The override layer; by default ``<shot>.mtex.usd`` beside the shot, or where the thin root given has it.
    anim
        Prim path or paths of the sketches to work on; by default all. The others keep what an earlier run made.
    paths, candidates, band
        Instead of what the recipes say in ``mtex:paths``, ``mtex:candidates`` and ``mtex:matchBand``.
    select
        The variant to select; by default the user's earlier choice, else ``path_01``.
    timeline
        An .otio file to write as well: one track per path, one clip per fragment.
    report
        An .html file to write as well: the review page, with a player and all that led to the result.
    sheet
        A .png file to write as well: strobed figures, one row per variant.
    command
        What the review page says it was made by.
    dry_run
        Do everything but write.
    progress
        Called before each sketch and after the last.

    Returns
    -------
    tuple of Result
        One per sketch and character.

    Raises
    ------
    InputError
        Options, channels, takes or files that are not right.
    StageError
        No recipe, no animation, nothing to bind, or a stronger opinion in the way. Of several sketches those that no
        Skeleton can play are left out, and named in ``Result.left_out``, unless none is left.
    NoSolutionError
        Where contacts cannot be held together; nothing is written.
    ResultError
        What was written does not read back as computed.

    Examples
    --------
    >>> for result in process("shot.usda", paths=5):  # doctest: +SKIP
    ...     print(result.anim, [variant.distance for variant in result.variants])
    """
    overrides = _recipe_overrides(paths, candidates, band)
    sketches = as_prim_paths(anim, "anim")
    source = open_source(as_file_path(stage_path, "stage"))
    target, thin_root = find_outputs(stage_path, out=out)
    check_outputs(target, maker=_MAKER)
    asked = Presentation(
        timeline=_optional(timeline, "timeline"),
        report=_optional(report, "report"),
        sheet=_optional(sheet, "sheet"),
        command=command,
    )
    check_presentation(asked, [source.source_path, target, thin_root])
    cast = find_cast(source.stage, only=sketches, previous=target)
    finished: list[Finished] = []
    for done, job in enumerate(read_jobs(source.stage, cast.wanted)):
        report_progress(progress, done, len(cast.wanted), str(job.character.animation))
        recipe = replace(job.recipe, **overrides)
        finished.append(finish_job(job, recipe))
        names = variant_names(len(finished[-1].motion.variants))
        check_selection(select, (ORIGINAL, *names), job.character.animation)
    built = [build_result(each) for each in finished]
    write_presentation = prepare_presentation(asked, source, finished)
    write_outputs(source.stage, built, target, maker=_MAKER, select=select, keep=cast.others, dry_run=dry_run)
    if not dry_run:
        write_presentation()
    report_progress(progress, len(cast.wanted), len(cast.wanted), "")
    return tuple(_describe(each, target, cast.left_out) for each in finished)


def find_outputs(stage_path: FilePath, *, out: FilePath | None = None) -> tuple[Path, Path]:
    """Tell which files :func:`process` is going to write: the override layer and the thin root.

    Parameters
    ----------
    stage_path, out
        As for :func:`process`.

    Raises
    ------
    InputError
        Where the stage cannot be read, or a path is none.
    """
    shot = as_file_path(stage_path, "stage")
    target = find_override(shot) if out is None else as_file_path(out, "out")
    return target, thin_root_path(target)


def _optional(file_path: FilePath | None, name: str) -> Path | None:
    return None if file_path is None else as_file_path(file_path, name)


def _recipe_overrides(paths: int | None, candidates: int | None, band: int | None) -> dict[str, Any]:
    given = {"paths": paths, "candidates": candidates, "match_band": band}
    return {name: as_whole_number(value, name, least=1) for name, value in given.items() if value is not None}


def _describe(finished: Finished, target: Path, left_out: tuple[str, ...]) -> Result:
    job, motion = finished.job, finished.motion
    names = variant_names(len(motion.variants))
    status = registration_status()
    return Result(
        anim=str(job.character.animation),
        model=str(job.character.model),
        variantSet=job.character.variant_set,
        variants=tuple(
            PathVariant(name, variant, custom_data)
            for name, variant, custom_data in zip(names, motion.variants, describe_variants(finished), strict=True)
        ),
        texturing=motion,
        retargets=list_retargets(job.takes),
        layer=target,
        stage=thin_root_path(target),
        notes=motion.notes if status.registered else (*motion.notes, status.message),
        left_out=left_out,
    )
