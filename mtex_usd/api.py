"""What pipelines call from Python; the commands are thin layers over it."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from mtex_usd.errors import InputError
from mtex_usd.formats.bvh import read_bvh
from mtex_usd.formats.recording import FormatError, Recording
from mtex_usd.results import PathVariant, Result
from mtex_usd.texture.engine import texture_motion
from mtex_usd.texture.result import TexturedMotion
from mtex_usd.usd.atomic import check_target
from mtex_usd.usd.check import check_override
from mtex_usd.usd.clip_io import read_clip, write_clip
from mtex_usd.usd.override import ORIGINAL, variant_names, write_override
from mtex_usd.usd.plugin import registration_status
from mtex_usd.usd.shot import Job, build_result, describe_variant, find_cast, read_jobs
from mtex_usd.usd.source_stage import SourceStage, open_source
from mtex_usd.usd.take_library import TakeLibrary, WrittenTake
from mtex_usd.usd.thin_root import thin_root_path

__all__ = [
    "FailedFile",
    "ImportResult",
    "ProgressCallback",
    "import_takes",
    "process",
    "read_clip",
    "write_clip",
]

ProgressCallback = Callable[[int, int, str], None]
"""Called with how many are done, how many there are, and what is next."""


@dataclass(frozen=True, kw_only=True)
class FailedFile:
    """A file that could not be imported.

    Parameters
    ----------
    source
        The file.
    line
        Line number from 1; None where the reason is not on a line.
    reason
        What is wrong.
    """

    source: Path
    line: int | None
    reason: str

    def __str__(self) -> str:
        """Give ``file:line: reason``."""
        place = str(self.source) if self.line is None else f"{self.source}:{self.line}"
        return f"{place}: {self.reason}"


@dataclass(frozen=True, kw_only=True)
class ImportResult:
    """What :func:`import_takes` did.

    Parameters
    ----------
    out
        The file written.
    takes
        The takes in it, in the order of the files.
    failures
        The files left out.
    """

    out: Path
    takes: tuple[WrittenTake, ...]
    failures: tuple[FailedFile, ...]


def import_takes(
    file_paths: Iterable[str | Path],
    *,
    out: str | Path,
    meters_per_unit: float = 0.01,
    up_axis: str = "Y",
    skip_frames: int = 0,
    style: str = "",
    strict: bool = False,
    progress: ProgressCallback | None = None,
) -> ImportResult:
    """Write recorded motions as takes into one USD file.

    Parameters
    ----------
    file_paths
        BVH files.
    out
        The ``.usd``, ``.usdc`` or ``.usda`` file to write; replaced if it is a take library of an earlier run.
    meters_per_unit
        Length in metres of one unit of the files.
    up_axis
        ``"Y"`` or ``"Z"``: which axis is up in the files.
    skip_frames
        How many frames to leave out at the start of each file, such as a calibration pose.
    style
        Written on every take as ``mtex:take:style``.
    strict
        Write nothing unless every file can be read.
    progress
        Called before each file and after the last.

    Returns
    -------
    ImportResult
        The takes written, and the files that were not and why.

    Raises
    ------
    InputError
        Where an option is out of range, `out` may not be written, no file can be read, or with `strict` any cannot.

    Examples
    --------
    >>> result = import_takes(["07_01.bvh", "07_02.bvh"], out="takes.usd", meters_per_unit=0.05644, skip_frames=1)
    ... # doctest: +SKIP
    """
    sources = [Path(file_path) for file_path in file_paths]
    _check_options(sources, meters_per_unit, up_axis, skip_frames)
    check_target(Path(out))
    library = TakeLibrary(meters_per_unit=meters_per_unit, up_axis=up_axis)
    failures = []
    for done, source in enumerate(sources):
        _report(progress, done, len(sources), source.name)
        try:
            library.add(_read_recording(source, skip_frames), style=style)
        except FormatError as error:
            failures.append(FailedFile(source=error.file_path, line=error.line, reason=error.reason))
    _check_failures(failures, strict=strict, any_good=bool(library.takes))
    library.write(Path(out))
    _report(progress, len(sources), len(sources), "")
    return ImportResult(out=Path(out), takes=library.takes, failures=tuple(failures))


def _read_recording(source: Path, skip_frames: int) -> Recording:
    return read_bvh(source).without_first(skip_frames)


def _report(progress: ProgressCallback | None, done: int, total: int, what: str) -> None:
    if progress is not None:
        progress(done, total, what)


def _check_options(sources: list[Path], meters_per_unit: float, up_axis: str, skip_frames: int) -> None:
    if not sources:
        raise InputError("no files to import", expected="at least one BVH file")
    if not (math.isfinite(meters_per_unit) and meters_per_unit > 0.0):
        raise InputError("bad metres per unit", expected="a number above 0", found=str(meters_per_unit))
    if up_axis not in {"Y", "Z"}:
        raise InputError("bad up axis", expected="Y or Z", found=repr(up_axis))
    if skip_frames < 0:
        raise InputError("bad number of frames to skip", expected="0 or more", found=str(skip_frames))


def _check_failures(failures: list[FailedFile], *, strict: bool, any_good: bool) -> None:
    if failures and (strict or not any_good):
        why = "--strict" if any_good else "no file could be read"
        listed = "\n  ".join(str(failure) for failure in failures)
        raise InputError(f"nothing written ({why}):\n  {listed}")


def process(
    stage_path: str | Path,
    *,
    out: str | Path | None = None,
    anim: Sequence[str] = (),
    paths: int | None = None,
    candidates: int | None = None,
    band: int | None = None,
    select: str | None = None,
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
        Prim paths of the sketches to work on; by default all.
    paths, candidates, band
        Instead of what the recipes say in ``mtex:paths``, ``mtex:candidates`` and ``mtex:matchBand``.
    select
        The variant to select; by default the user's earlier choice, else ``path_01``.
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
    ResultError
        What was written does not read back as computed.

    Examples
    --------
    >>> for result in process("shot.usda", paths=5):  # doctest: +SKIP
    ...     print(result.anim, [variant.distance for variant in result.variants])
    """
    overrides = _recipe_overrides(paths, candidates, band)
    source = open_source(Path(stage_path))
    target = _choose_target(source, Path(stage_path), out)
    check_target(target)
    check_target(thin_root_path(target))
    cast = find_cast(source.stage, only=anim, previous=target)
    finished: list[tuple[Job, TexturedMotion]] = []
    for done, job in enumerate(read_jobs(source.stage, cast.wanted)):
        _report(progress, done, len(cast.wanted), str(job.character.animation))
        recipe = replace(job.recipe, **overrides)
        motion = texture_motion(job.sketch, job.takes, recipe)
        _check_selection(select, motion)
        finished.append((job, motion))
    built = [build_result(job, motion) for job, motion in finished]
    if not dry_run:
        _, root = write_override(source.stage, built, target, select=select, keep=cast.others)
        check_override(root, built)
    _report(progress, len(cast.wanted), len(cast.wanted), "")
    return tuple(_describe(job, motion, target, cast.left_out) for job, motion in finished)


def _recipe_overrides(paths: int | None, candidates: int | None, band: int | None) -> dict[str, Any]:
    given = {"paths": paths, "candidates": candidates, "match_band": band}
    for name, value in given.items():
        if value is not None and not (isinstance(value, int) and value >= 1):
            raise InputError(f"bad {name}", expected="a whole number of at least 1", found=str(value))
    return {name: value for name, value in given.items() if value is not None}


def _choose_target(source: SourceStage, asked: Path, out: str | Path | None) -> Path:
    if out is not None:
        return Path(out)
    is_thin_root = asked.resolve() != source.source_path.resolve()
    if is_thin_root and source.previous_override is not None:
        return source.previous_override
    return asked.with_name(f"{asked.stem}.mtex.usd")


def _check_selection(select: str | None, motion: TexturedMotion) -> None:
    names = (ORIGINAL, *variant_names(len(motion.variants)))
    if select is not None and select not in names:
        raise InputError(f"{motion.sketch.name} gets no variant {select!r}", expected=f"one of {', '.join(names)}")


def _describe(job: Job, motion: TexturedMotion, target: Path, left_out: tuple[str, ...]) -> Result:
    names = variant_names(len(motion.variants))
    status = registration_status()
    return Result(
        anim=str(job.character.animation),
        model=str(job.character.model),
        variantSet=job.character.variant_set,
        variants=tuple(
            PathVariant(name, variant, describe_variant(variant, motion))
            for name, variant in zip(names, motion.variants, strict=True)
        ),
        texturing=motion,
        layer=target,
        stage=thin_root_path(target),
        notes=motion.notes if status.registered else (*motion.notes, status.message),
        left_out=left_out,
    )
