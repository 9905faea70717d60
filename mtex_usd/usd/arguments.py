"""What Python callers give as files, prims and numbers: taken where it is plain what is meant, else refused."""

import os
import sys
from collections.abc import Iterable
from numbers import Integral, Real
from pathlib import Path

from pxr import Sdf

from mtex_usd.errors import InputError

__all__ = [
    "FilePath",
    "PrimPath",
    "as_file_path",
    "as_file_paths",
    "as_number",
    "as_prim_path",
    "as_prim_paths",
    "as_text",
    "as_whole_number",
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
        Where it is anything else, such as an open stage, or empty.
    """
    if not isinstance(value, str | os.PathLike) or not os.fspath(value):
        raise _refuse(value, name, "the path of a file")
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
        raise _refuse(value, name, "the path of a prim")
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
        raise _refuse(value, name, "a text")
    return value


def as_whole_number(value: object, name: str, *, least: int) -> int:
    """Take a whole number, Python's or numpy's.

    Raises
    ------
    InputError
        Where it is less than `least` or anything else, such as True or 2.0.
    """
    if not isinstance(value, Integral) or isinstance(value, bool) or value < least:
        raise _refuse(value, name, f"a whole number of at least {least}")
    return int(value)


def as_number(
    value: object,
    name: str,
    *,
    expected: str = "a number above 0",
    least: float = sys.float_info.min,
    most: float = sys.float_info.max,
) -> float:
    """Take a number, Python's or numpy's.

    Parameters
    ----------
    value
        The number.
    name, expected
        What the caller calls it and what it should be, for the message.
    least, most
        The range, both included.

    Raises
    ------
    InputError
        Where it is out of range, not finite or anything else, such as True.
    """
    if not isinstance(value, Real) or isinstance(value, bool) or not least <= float(value) <= most:
        raise _refuse(value, name, expected)
    return float(value)


def _refuse(value: object, name: str, expected: str) -> InputError:
    plain = isinstance(value, str | bytes | int | float | None)
    return InputError(f"bad {name}", expected=expected, found=repr(value) if plain else f"a {type(value).__name__}")
