"""USD's errors, and files it cannot read, in words for users."""

import re
from collections.abc import Callable
from pathlib import Path

from pxr import Sdf, Tf

from mtex_usd.errors import InputError

__all__ = ["describe_damage", "describe_error", "find_obstacle", "open_layer", "read_layer"]

# What the text parser was trying is the name of a C++ template.
_GRAMMAR = re.compile(r"parse error matching .* at '")
_PLACE = re.compile(r"^\S.*?:(\d+):\d+: ")
_FOLLOWS = re.compile(r"Failed to open layer @.*@")
_CRATE_HEAD = b"PXR-USDC"
_MOST_ERRORS = 10


def describe_error(error: Exception) -> str:
    """Give what an error says in one line, without USD's source file, line, function and grammar.

    Parameters
    ----------
    error
        Usually a ``Tf.ErrorException``, which carries one or more errors.
    """
    if not isinstance(error, Tf.ErrorException):
        return str(error)
    # One bracket too many can be thousands of errors, each of which quotes the rest of the file.
    said = [_comment(part) if isinstance(part, Tf.Error) else str(part) for part in error.args[:_MOST_ERRORS]]
    lines = dict.fromkeys(_GRAMMAR.sub("parse error at '", " ".join(text.split())) for text in said)
    # The text parser says each error twice, the second time with file and line.
    news = [line for line in lines if not any(line != other and other.endswith(line) for other in lines)]
    return "; ".join([line for line in news if not _FOLLOWS.fullmatch(line)] or news)


def _comment(part: Tf.Error) -> str:
    try:
        return str(part.commentary)
    except UnicodeDecodeError:  # it quotes bytes of a damaged file
        return "the file holds text that is not UTF-8"


def find_obstacle(file_path: Path) -> str:
    """Tell what keeps a file from being opened at all; empty for nothing.

    Parameters
    ----------
    file_path
        Any path.
    """
    try:
        if file_path.is_dir():
            return "a folder"
        if not file_path.is_file():
            return "no such file"
        with file_path.open("rb"):
            return ""
    except OSError as error:
        return str(error.strerror or error).lower()


def describe_damage(file_path: Path, error: Exception | None = None) -> str:
    """Tell what is wrong with a file that can be opened and that USD cannot read.

    Parameters
    ----------
    file_path
        The file.
    error
        What USD raised, if anything.
    """
    with file_path.open("rb") as file:
        head = file.read(len(_CRATE_HEAD))
    if not head:
        return "an empty file"
    if error is not None:
        return _PLACE.sub(r"line \1: ", describe_error(error))
    return "a crate file that is damaged or cut short" if head == _CRATE_HEAD else "something that USD does not know"


def open_layer(file_path: Path) -> Sdf.Layer:
    """Open a USD file as a layer.

    Parameters
    ----------
    file_path
        The file; one that this process has open already is given as it is there.

    Raises
    ------
    InputError
        Where it is missing, a folder, not allowed to be read, empty, damaged or no USD file; says which.
    """
    return _open(file_path, Sdf.Layer.FindOrOpen)


def read_layer(file_path: Path) -> Sdf.Layer:
    """Read a USD file into a layer of its own, as it is on disk now.

    Raises
    ------
    InputError
        As :func:`open_layer`.
    """
    return _open(file_path, Sdf.Layer.OpenAsAnonymous)


def _open(file_path: Path, opener: Callable[[str], Sdf.Layer | None]) -> Sdf.Layer:
    obstacle = find_obstacle(file_path)
    if obstacle:
        raise InputError(f"cannot open {file_path}", expected="a USD file", found=obstacle)
    try:
        layer = opener(str(file_path))
    except Tf.ErrorException as error:
        raise InputError(f"cannot read {file_path}: {describe_damage(file_path, error)}") from error
    if not layer:
        raise InputError(f"cannot read {file_path}", expected="a USD file", found=describe_damage(file_path))
    return layer
