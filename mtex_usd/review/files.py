"""Writing pages and pictures whole, over nothing but what this project wrote before."""

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from mtex_usd.errors import InputError

__all__ = ["check_file", "write_file"]


def check_file(file_path: Path, *, ending: str, is_ours: Callable[[Path], bool], option: str) -> None:
    """Refuse a file that cannot be written or is somebody else's, before any work is done for it.

    Parameters
    ----------
    file_path
        Where the file is asked for.
    ending
        What its name has to end in, such as ``".html"``.
    is_ours
        Tells whether an existing file is one that this project wrote.
    option
        What the user would change, such as ``"--report"``.

    Raises
    ------
    InputError
        Naming the file and what is wrong.
    """
    fix = f"Choose another name for {option}."
    if file_path.suffix.lower() != ending:
        raise InputError(f"cannot write {file_path}", expected=f"a name ending in {ending}", fix=fix)
    folder = file_path.parent
    if not folder.is_dir():
        raise InputError(f"cannot write {file_path}", expected="an existing folder", found=str(folder))
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"cannot write {file_path}: folder {folder} is not writable")
    if file_path.is_dir():
        raise InputError(f"cannot write {file_path}: it is a folder", fix=fix)
    if file_path.exists() and not is_ours(file_path):
        raise InputError(f"{file_path} exists and was not written by usdmtex; it is left alone", fix=fix)


def write_file(file_path: Path, content: bytes) -> None:
    """Write a file, replaced whole or not at all.

    Parameters
    ----------
    file_path
        Where to.
    content
        All of it.

    Raises
    ------
    InputError
        Where the file system refuses.
    """
    try:
        _replace(Path(os.path.realpath(file_path)), content)
    except OSError as error:
        raise InputError(f"cannot write {file_path}: {error.strerror}") from error


def _replace(target: Path, content: bytes) -> None:
    handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        Path(temporary).chmod(0o644)
        Path(temporary).replace(target)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
