"""Which format a file has, by what it holds, and which files a user means by folders and patterns."""

import glob
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from mtex_usd.formats.recording import FormatError

__all__ = ["FileKind", "Source", "detect_format", "find_sources"]

FileKind = Literal["bvh", "asf", "amc", "gltf", "usd"]

_HEAD = 65536  # bytes; comments and a documentation section may come first
_USD = (b"#usda", b"PXR-USDC", b"PK\x03\x04")
_ASF = {":version", ":name", ":units", ":documentation", ":root", ":bonedata", ":hierarchy"}
_AMC = {":fully-specified", ":degrees", ":radians", ":samples-per-second"}


@dataclass(frozen=True, kw_only=True)
class Source:
    """A file to import.

    Parameters
    ----------
    file_path
        The file.
    found
        Whether a folder or pattern led to it, so that it need not be motion at all.
    """

    file_path: Path
    found: bool


def detect_format(file_path: Path) -> FileKind:
    """Tell a file's format by its first bytes; its name does not matter.

    Parameters
    ----------
    file_path
        The file.

    Raises
    ------
    FormatError
        Where it cannot be opened, is empty, or is none of the formats.
    """
    try:
        with file_path.open("rb") as file:
            head = file.read(_HEAD)
    except OSError as error:
        raise FormatError(file_path, None, f"cannot be read: {error.strerror}") from error
    if not head.strip():
        raise FormatError(file_path, 1, "the file is empty")
    kind = _detect_binary(head) or _detect_text(head.removeprefix(b"\xef\xbb\xbf"))
    if kind is None:
        raise FormatError(file_path, None, "is no motion file: expected BVH, ASF/AMC, glTF or USD")
    return kind


def _detect_binary(head: bytes) -> FileKind | None:
    if head.startswith(_USD):
        return "usd"
    return "gltf" if head.startswith(b"glTF") else None


def _detect_text(head: bytes) -> FileKind | None:
    if head.lstrip()[:1] == b"{":
        return "gltf"
    if b"\0" in head:
        return None
    lines = (line.split(b"#", 1)[0].split() for line in head.replace(b"\r", b"\n").split(b"\n"))
    words = next((line for line in lines if line), None)
    return _detect_word(words) if words else None


def _detect_word(words: list[bytes]) -> FileKind | None:
    first = words[0].decode("latin-1").lower()
    if first == "hierarchy":
        return "bvh"
    if first in _ASF:
        return "asf"
    return "amc" if first in _AMC or (first.isdecimal() and len(words) == 1) else None


def find_sources(
    file_paths: Iterable[Path], *, leave_out: Path | None = None
) -> tuple[list[Source], list[FormatError]]:
    """Find the files behind folders and patterns.

    Parameters
    ----------
    file_paths
        Files, folders (searched with all folders below for files of a known format) and patterns such as
        ``walks/*.bvh`` or ``**/*.amc`` for shells that leave them as they are.
    leave_out
        A file that folders and patterns do not lead to: the one to be written.

    Returns
    -------
    tuple
        The files, each once, in the order given and by name within folders; and what led to none.
    """
    sources: dict[str, Source] = {}
    errors = []
    for file_path in file_paths:
        if not (file_path.is_dir() or _is_pattern(file_path)):
            sources.setdefault(os.path.realpath(file_path), Source(file_path=file_path, found=False))
            continue
        found = [path for path in _expand(file_path) if leave_out is None or not _is_same(path, leave_out)]
        if not found:
            what = "the folder holds" if file_path.is_dir() else "the pattern leads to"
            errors.append(FormatError(file_path, None, f"{what} no BVH, ASF/AMC, glTF or USD file"))
        for path in found:
            sources.setdefault(os.path.realpath(path), Source(file_path=path, found=True))
    return list(sources.values()), errors


def _is_pattern(file_path: Path) -> bool:
    return glob.has_magic(str(file_path)) and not file_path.exists()


def _is_same(file_path: Path, other: Path) -> bool:
    return os.path.realpath(file_path) == os.path.realpath(other)


def _expand(file_path: Path) -> list[Path]:
    if file_path.is_dir():
        return sorted(_walk(file_path))
    matches = sorted(Path(match) for match in glob.glob(str(file_path), recursive=True))  # noqa: PTH207 - absolute too
    folders = [path for match in matches if match.is_dir() for path in sorted(_walk(match))]
    return [match for match in matches if match.is_file()] + folders


def _walk(folder: Path) -> Iterator[Path]:
    for parent, names, files in os.walk(folder):
        names[:] = sorted(name for name in names if not name.startswith("."))
        for name in files:
            path = Path(parent) / name
            if not name.startswith(".") and _is_known(path):
                yield path


def _is_known(file_path: Path) -> bool:
    try:
        detect_format(file_path)
    except FormatError:
        return False
    return True
