"""Recorded motion of any known format into take libraries."""

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from mtex_usd.edit.cleaning import Finding, check_steps
from mtex_usd.errors import InputError
from mtex_usd.formats.amc import read_amc
from mtex_usd.formats.bvh import read_bvh
from mtex_usd.formats.detect import FileKind, Source, detect_format, find_sources
from mtex_usd.formats.recording import FormatError, NoMotionError, Recording
from mtex_usd.motion.arguments import as_number, as_whole_number
from mtex_usd.progress import ProgressCallback, report_progress
from mtex_usd.usd.arguments import FilePath, as_file_path, as_file_paths, as_text
from mtex_usd.usd.atomic import check_target
from mtex_usd.usd.clean_recording import clean_recording
from mtex_usd.usd.take_entries import Provenance, TakeEntry, list_entries, open_library_layer
from mtex_usd.usd.take_library import TakeLibrary, WrittenTake
from mtex_usd.usd.usd_process import UsdReader

__all__ = [
    "CleanedTake",
    "FailedFile",
    "ImportResult",
    "import_takes",
    "list_takes",
]


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
class CleanedTake:
    """What the clean-up did to a take; frames count from 0 in the file.

    Parameters
    ----------
    prim_path
        The take.
    changes
        Every repair.
    notes
        What was found and left as it is.
    """

    prim_path: str
    changes: tuple[Finding, ...]
    notes: tuple[Finding, ...]


@dataclass(frozen=True, kw_only=True)
class ImportResult:
    """What :func:`import_takes` did.

    Parameters
    ----------
    out
        The library.
    takes
        The takes added to it, in the order of the files.
    failures
        The files left out.
    notes
        What a user should know: captures that are in the library already, files in folders without motion, what a
        reader had to leave out.
    cleaned
        What the clean-up did to each of `takes`; empty where none was asked for.
    """

    out: Path
    takes: tuple[WrittenTake, ...]
    failures: tuple[FailedFile, ...]
    notes: tuple[str, ...] = ()
    cleaned: tuple[CleanedTake, ...] = ()


def import_takes(  # noqa: PLR0913 - options with names of their own
    file_paths: FilePath | Iterable[FilePath],
    *,
    out: FilePath,
    meters_per_unit: float = 0.01,
    up_axis: str = "Y",
    rate: float | None = None,
    skeleton: FilePath | None = None,
    skip_frames: int = 0,
    clean: Sequence[str] = (),
    style: str = "",
    licence: str = "",
    replace_library: bool = False,
    strict: bool = False,
    progress: ProgressCallback | None = None,
) -> ImportResult:
    """Add recorded motions to a take library.

    Parameters
    ----------
    file_paths
        One or several: BVH, AMC (with its ASF), glTF and USD files, told by their content; folders, and patterns
        such as ``walks/*.amc``.
    out
        The ``.usd``, ``.usdc`` or ``.usda`` library. Where one is there already the takes are added to it; a capture
        that it has, of the same content and with the same options, is left out with a note.
    meters_per_unit
        Length in metres of one unit of BVH files, which do not say; ASF, glTF and USD files do.
    up_axis
        ``"Y"`` or ``"Z"``: which axis is up in BVH and ASF files; glTF and USD files say.
    rate
        Frames per second of AMC files that do not say (by default 120), and to sample glTF files at (by default the
        rate of their keys, 30 where those are uneven).
    skeleton
        The ASF file of AMC files; by default the one beside each that has its name or is the only one.
    skip_frames
        How many frames to leave out at the start of each motion, such as a calibration pose.
    clean
        Steps of the clean-up, by name, or ``("auto",)``; see :mod:`mtex_usd.edit.cleaning`.
    style
        Written on every take as ``mtex:take:style``; by default what a USD take says itself.
    licence
        A note on the terms, kept with every take.
    replace_library
        Begin anew where there is a library.
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
        Where an option is out of range, `out` may not be written or is no take library, no file can be read, or with
        `strict` any cannot.

    Examples
    --------
    >>> result = import_takes(["07_01.bvh", "amc/*.amc"], out="takes.usd", skip_frames=1)  # doctest: +SKIP
    """
    _check_options(meters_per_unit, skip_frames, rate, up_axis)
    as_text(style, "style")
    as_text(licence, "licence")
    check_steps(clean)
    target = as_file_path(out, "out")
    check_target(target, "takes")
    sources, lost = find_sources(as_file_paths(file_paths, "file_paths"), leave_out=target)
    if not sources and not lost:
        raise InputError("no files to import", expected="at least one BVH, AMC, glTF or USD file")
    reading = _Reading(
        meters_per_unit,
        up_axis,
        rate,
        as_file_path(skeleton, "skeleton") if skeleton else None,
        skip_frames,
        UsdReader(),
    )
    job = _Job(
        reading,
        tuple(clean),
        style,
        licence,
        TakeLibrary.open(target) if target.exists() and not replace_library else None,
    )
    job.failures += [_describe_failure(error) for error in lost]
    with reading.usd_reader:
        for done, source in enumerate(sources):
            report_progress(progress, done, len(sources), source.file_path.name)
            job.import_file(source)
    _check_failures(job, strict=strict)
    if job.collection is not None and job.collection.takes:
        job.collection.write(target)
    report_progress(progress, len(sources), len(sources), "")
    takes = job.collection.takes if job.collection is not None else ()
    return ImportResult(
        out=target, takes=takes, failures=tuple(job.failures), notes=tuple(job.notes), cleaned=tuple(job.cleaned)
    )


def list_takes(file_path: FilePath) -> tuple[TakeEntry, ...]:
    """List what is in a take library.

    Parameters
    ----------
    file_path
        A library that :func:`import_takes` wrote.

    Raises
    ------
    InputError
        Where it cannot be read or is no take library.
    """
    return list_entries(open_library_layer(as_file_path(file_path, "file_path")))


def _check_options(meters_per_unit: float, skip_frames: int, rate: float | None, up_axis: str) -> None:
    as_number(meters_per_unit, "metres per unit")
    if up_axis not in {"Y", "Z"}:
        raise InputError("bad up axis", expected="Y or Z", found=repr(up_axis))
    as_whole_number(skip_frames, "number of frames to skip", least=0)
    if rate is not None:
        as_number(rate, "rate", expected="frames per second from 0.001 to 100000", least=1e-3, most=1e5)


@dataclass(frozen=True)
class _Reading:
    """How files are read."""

    meters_per_unit: float
    up_axis: str
    rate: float | None
    skeleton: Path | None
    skip_frames: int
    usd_reader: UsdReader

    def read(self, file_path: Path, kind: FileKind) -> tuple[list[Recording], Sequence[FormatError]]:
        """Give the motions of a file, and why some of them could not be read."""
        found, failures = self._read_whole(file_path, kind)
        recordings, failures = [], list(failures)
        for recording in found:
            try:
                recordings.append(self._finish(recording))
            except FormatError as error:
                failures.append(error)
        return recordings, failures

    def _read_whole(self, file_path: Path, kind: FileKind) -> tuple[Sequence[Recording], Sequence[FormatError]]:
        match kind:
            case "usd":
                takes = self.usd_reader.read(file_path)
                return takes.recordings, takes.failures
            case "gltf":
                # Imported here: no other format needs its reader.
                from mtex_usd.formats.gltf import read_gltf  # noqa: PLC0415

                return read_gltf(file_path, rate=self.rate), ()
            case "amc":
                return (read_amc(file_path, skeleton=self.skeleton, rate=self.rate),), ()
            case _:
                return (read_bvh(file_path),), ()

    def _finish(self, recording: Recording) -> Recording:
        """Fill in what the file does not say."""
        return replace(
            recording.without_first(self.skip_frames),
            meters_per_unit=recording.meters_per_unit or self.meters_per_unit,
            up_axis=recording.up_axis or self.up_axis,
        )


@dataclass
class _Job:
    """One import while it goes on."""

    reading: _Reading
    clean: tuple[str, ...]
    style: str
    licence: str
    collection: TakeLibrary | None
    failures: list[FailedFile] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    cleaned: list[CleanedTake] = field(default_factory=list)
    repeated: int = 0

    def import_file(self, source: Source) -> None:
        try:
            self._import(source.file_path)
        except NoMotionError as error:
            if source.found:
                self.notes.append(str(error))
            else:
                self.failures.append(_describe_failure(error))
        except FormatError as error:
            self.failures.append(_describe_failure(error))

    def _import(self, file_path: Path) -> None:
        kind = detect_format(file_path)
        if kind == "asf":
            # Shells expand 91/* to the skeleton as well.
            self.notes.append(f"{file_path}: is a skeleton, which is read with the .amc files it belongs to")
            return
        recordings, failures = self.reading.read(file_path, kind)
        self.failures += [_describe_failure(error) for error in failures]
        for recording in recordings:
            self._add(recording)

    def _add(self, recording: Recording) -> None:
        if self.collection is None:
            unit, up_axis = recording.meters_per_unit or self.reading.meters_per_unit, recording.up_axis or "Y"
            self.collection = TakeLibrary(meters_per_unit=unit, up_axis=up_axis)
        style = self.style or recording.style
        provenance = _describe_provenance(recording, style, self.licence, self.clean)
        known = self.collection.find(recording, provenance)
        if known is not None:
            self.repeated += 1
            what = f"{recording.source}{f' ({recording.clip})' if recording.clip else ''}"
            self.notes.append(f"{what}: is in the library already as {known}; left out")
            return
        self._write(self.collection, recording, style, provenance)
        self.notes += [f"{recording.source}: {note}" for note in recording.notes]

    def _write(self, library: TakeLibrary, recording: Recording, style: str, provenance: Provenance) -> None:
        cleaned = clean_recording(recording, self.clean)
        provenance = replace(provenance, changes=cleaned.changes, left=cleaned.notes)
        take = library.add(cleaned.recording, style=style, provenance=provenance)
        if self.clean:
            self.cleaned.append(CleanedTake(prim_path=take.prim_path, changes=cleaned.changes, notes=cleaned.notes))


def _describe_provenance(recording: Recording, style: str, licence: str, clean: tuple[str, ...]) -> Provenance:
    """Describe a recording's content and how it was read: only what makes it another take."""
    options = (
        f"metersPerUnit={recording.meters_per_unit:.9g} upAxis={recording.up_axis} rate={recording.rate:.9g} "
        f"skipFrames={recording.skipped_frames} style={style}"
    )
    if clean:
        options += f" clean={','.join(clean)}"
    return Provenance(
        sha256=_hash_file(recording.source),
        companions=tuple(f"{path.name} {_hash_file(path)}" for path in recording.companions),
        options=options,
        licence=licence,
    )


def _hash_file(file_path: Path) -> str:
    try:
        with file_path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise FormatError(file_path, None, f"cannot be read: {error.strerror}") from error


def _describe_failure(error: FormatError) -> FailedFile:
    return FailedFile(source=error.file_path, line=error.line, reason=error.reason)


def _check_failures(job: _Job, *, strict: bool) -> None:
    any_good = bool(job.repeated or (job.collection is not None and job.collection.takes))
    if any_good and not (job.failures and strict):
        return
    why = "--strict" if any_good else "no file could be read" if job.failures else "no file holds motion"
    listed = "\n  ".join([*map(str, job.failures), *([] if job.failures else job.notes)])
    raise InputError(f"nothing written ({why}):\n  {listed}")
