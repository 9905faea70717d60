"""What Python callers give as files, prims and texts: taken where it is plain what is meant, else refused."""

import os
import unicodedata
from collections.abc import Iterable
from pathlib import Path

from pxr import Sdf

from mtex_usd.motion.arguments import refuse

__all__ = [
    "FilePath",
    "PrimPath",
    "as_file_path",
    "as_file_paths",
    "as_prim_path",
    "as_prim_paths",
    "as_text",
]

FilePath = str | os.PathLike[str]
PrimPath = str | Sdf.Path


def as_file_path(value: object, name: str) -> Path:
    """Take the path of a file.

    Parameters
    ----------
    value
        A string or path object.
    name
        What the caller calls it, for the message.

    Raises
    ------
    InputError
        Where it is anything else, such as an open stage, or empty, or a name that USD cannot refer to.
    """
    if not isinstance(value, str | os.PathLike) or not os.fspath(value):
        raise refuse(value, name, "the path of a file")
    # USD refers to no others: a line break, or bytes that are no text, end in an error of its own.
    if any(unicodedata.category(character) in ("Cc", "Cs") for character in str(value)):
        raise refuse(str(value), name, "the path of a file without control characters, in UTF-8")
    return Path(value)


def as_file_paths(values: object, name: str) -> tuple[Path, ...]:
    """Take several paths of files; a single one counts as one.

    Raises
    ------
    InputError
        As :func:`as_file_path`.
    """
    many = values if isinstance(values, Iterable) and not isinstance(values, str | os.PathLike) else (values,)
    return tuple(as_file_path(value, name) for value in many)


def as_prim_path(value: object, name: str) -> str:
    """Take the path of a prim, a string or ``Sdf.Path``; whether there is such a prim is not looked at.

    Raises
    ------
    InputError
        Where it is anything else, such as a prim.
    """
    if not isinstance(value, str | Sdf.Path):
        raise refuse(value, name, "the path of a prim")
    return str(value)


def as_prim_paths(values: object, name: str) -> tuple[str, ...]:
    """Take several paths of prims; a single one counts as one.

    Raises
    ------
    InputError
        As :func:`as_prim_path`.
    """
    many = values if isinstance(values, Iterable) and not isinstance(values, str | Sdf.Path) else (values,)
    return tuple(as_prim_path(value, name) for value in many)


def as_text(value: object, name: str) -> str:
    """Take a text.

    Raises
    ------
    InputError
        Where it is anything else.
    """
    if not isinstance(value, str):
        raise refuse(value, name, "a text")
    return value
