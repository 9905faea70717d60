"""Timelines as files: written whole, never over what is not ours or what somebody has edited."""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mtex_usd.errors import InputError
from mtex_usd.files import GENERATOR, check_ours, check_place, replace_file

__all__ = ["check_timeline_target", "parse_timeline", "read_timeline_text", "seal_timeline", "write_timeline_text"]

_WHAT = "timeline"
_MOST_LEVELS = 200  # OpenTimelineIO reads by recursion, and crashes where there is no end to it


def seal_timeline(text: str) -> str:
    """Add to a timeline's text a digest by which a later run tells that nobody has edited it.

    Parameters
    ----------
    text
        JSON of a timeline with ``metadata["mtex"]``.
    """
    content = json.loads(text)
    content["metadata"]["mtex"]["digest"] = _digest(content)
    return json.dumps(content, indent=4) + "\n"


def _digest(content: Mapping[str, Any]) -> str:
    """Digest of everything but the digest."""
    mark = {name: value for name, value in content["metadata"]["mtex"].items() if name != "digest"}
    whole = {**content, "metadata": {**content["metadata"], "mtex": mark}}
    return hashlib.sha256(json.dumps(whole, sort_keys=True).encode()).hexdigest()


def check_timeline_target(file_path: Path) -> None:
    """Make sure that a timeline may be written here, before any work is done for it.

    Parameters
    ----------
    file_path
        Where :func:`write_timeline_text` is going to write.

    Raises
    ------
    InputError
        Where the name does not end in .otio or is a folder's, the folder is missing or not writable, or what is there
        is not a timeline of ours as we wrote it.
    """
    check_place(file_path, what=_WHAT, endings=(".otio",))
    # Reading a pipe would wait for ever.
    content = _read_mark(file_path) if file_path.is_file() else None
    check_ours(file_path, what=_WHAT, is_ours=lambda _: content is not None)
    if content is not None and content["metadata"]["mtex"].get("digest") != _digest(content):
        raise InputError(
            f"{file_path} was edited since {GENERATOR} wrote it; it is left alone",
            fix="Choose another name for the timeline.",
        )


def _read_mark(file_path: Path) -> dict[str, Any] | None:
    """Give a timeline's content where it carries our mark."""
    try:
        content = parse_timeline(read_timeline_text(file_path), str(file_path))
        return content if content["metadata"]["mtex"]["generator"] == GENERATOR else None
    except (InputError, KeyError, TypeError):
        return None


def read_timeline_text(file_path: Path) -> str:
    """Read a timeline's text.

    Raises
    ------
    InputError
        Where there is no such file, it is a folder, it cannot be read, or it is no text.
    """
    if file_path.exists() and not file_path.is_file():
        raise InputError(f"cannot read {file_path}", expected="a file", found="a folder or a device")
    try:
        return file_path.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot read {file_path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise _not_a_timeline(str(file_path), "it is no text") from error


def parse_timeline(text: str, name: str) -> dict[str, Any]:
    """Parse a timeline's text as JSON, as far as to know that OpenTimelineIO can be trusted with it.

    Parameters
    ----------
    text
        Of an .otio file.
    name
        What messages call it.

    Raises
    ------
    InputError
        Where it is damaged or no OpenTimelineIO object.
    """
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise _not_a_timeline(name, str(error)) from error
    if not isinstance(content, dict) or not isinstance(content.get("OTIO_SCHEMA"), str):
        raise _not_a_timeline(name, "JSON that is not OpenTimelineIO's")
    _check_safe(content, name)
    return content


def _not_a_timeline(name: str, found: str) -> InputError:
    return InputError(f"{name} is damaged or no timeline", expected="an OpenTimelineIO file (.otio)", found=found)


def _check_safe(content: object, name: str) -> None:
    """Refuse what OpenTimelineIO would crash over."""
    level = [content]
    for _ in range(_MOST_LEVELS):
        objects = [value for value in level if isinstance(value, dict)]
        if any(each.get("OTIO_SCHEMA") == "Clip.1" and "media_references" in each for each in objects):
            raise _not_a_timeline(name, "a clip that is of the first schema and of a later one")
        lists = [value for value in level if isinstance(value, list)]
        level = [value for values in (*(each.values() for each in objects), *lists) for value in values]
        if not level:
            return
    raise _not_a_timeline(name, f"more than {_MOST_LEVELS} levels")


def write_timeline_text(file_path: Path, text: str) -> None:
    """Write a timeline, whole or not at all.

    Parameters
    ----------
    file_path
        Where to; a link is followed.
    text
        As :func:`mtex_usd.editorial.writing.build_timeline` gives it.

    Raises
    ------
    InputError
        As :func:`check_timeline_target`, and where the file system refuses.
    """
    check_timeline_target(file_path)
    replace_file(file_path, text.encode())
