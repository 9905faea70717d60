"""Files written whole: a temporary file beside the target, synced, then renamed over it.

A reader sees the old file or the new one, never half of one; a failure leaves what stood there. What is there and is
somebody else's work is never overwritten; who writes a kind of file tells its own from others'.
"""

import os
import secrets
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from mtex_usd.errors import InputError

__all__ = ["GENERATOR", "check_distinct", "check_ours", "check_place", "real_path", "replace_file", "replacing"]

GENERATOR = "usdmtex"
"""What files of ours say they were written by, and messages call it."""


def check_place(file_path: Path, *, what: str, endings: Sequence[str] = ()) -> None:
    """Make sure that a file of this name can be written, before any work is done for it.

    Parameters
    ----------
    file_path
        Where the file is asked for; a link is followed.
    what
        What it is going to be, such as ``"timeline"``.
    endings
        Those its name may have, such as ``".otio"``, in capitals as well; none for any.

    Raises
    ------
    InputError
        Where the name ends otherwise or is a folder's, or the folder is missing or not writable.
    """
    if endings and file_path.suffix.lower() not in endings:
        raise InputError(f"{file_path} is no {what} name", expected=f"a name ending in {', '.join(endings)}")
    folder = real_path(file_path).parent
    if not folder.is_dir():
        raise InputError(f"cannot write {file_path}: there is no folder {folder}", fix="Make it first.")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"cannot write {file_path}: folder {folder} is not writable")
    if file_path.is_dir():
        raise InputError(f"cannot write {file_path}: it is a folder", expected="a file name")


def check_ours(file_path: Path, *, what: str, is_ours: Callable[[Path], bool]) -> None:
    """Refuse a file that is there and was not written by this project.

    Parameters
    ----------
    file_path
        Where a file is going to be written.
    what
        What the user would give another name.
    is_ours
        Tells of a file that is there whether this project wrote it. One that it cannot read is not ours.

    Raises
    ------
    InputError
        Naming the file.
    """
    if os.path.lexists(real_path(file_path)) and not _holds(is_ours, file_path):
        raise InputError(
            f"{file_path} exists and was not written by {GENERATOR}; it is left alone",
            fix=f"Choose another name for the {what}.",
        )


def _holds(is_ours: Callable[[Path], bool], file_path: Path) -> bool:
    try:
        # Reading a pipe would wait for ever.
        return file_path.is_file() and is_ours(file_path)
    except OSError:
        return False


def check_distinct(file_path: Path, others: Iterable[Path], *, what: str) -> None:
    """Refuse a file that the same run reads or writes as something else.

    Parameters
    ----------
    file_path
        Where a file is going to be written.
    others
        The other files of the run.
    what
        What the user would give another name.

    Raises
    ------
    InputError
        Naming the file.
    """
    if real_path(file_path) in map(real_path, others):
        raise InputError(f"{file_path} is another file of this run", fix=f"Choose another name for the {what}.")


def replace_file(file_path: Path, content: bytes) -> None:
    """Write a file, all or nothing.

    Parameters
    ----------
    file_path
        Where to; a link is followed.
    content
        All of it.

    Raises
    ------
    InputError
        Where the file system refuses.
    """
    try:
        with replacing(file_path) as temporary:
            temporary.write_bytes(content)
    except OSError as error:
        raise InputError(f"cannot write {file_path}: {error.strerror or error}") from error


@contextmanager
def replacing(file_path: Path) -> Iterator[Path]:
    """Give the name of a temporary file that takes a file's place once the block has written it.

    Parameters
    ----------
    file_path
        The file; a link is followed. Permissions are those of any new file.

    Yields
    ------
    Path
        Beside the target and with its ending, since USD picks the format by it. Where the block fails it is deleted.

    Raises
    ------
    OSError
        Where the file system refuses.
    """
    target = real_path(file_path)
    # It starts with a dot, so that file browsers skip it.
    temporary = target.with_name(f".{target.stem}.{os.getpid()}-{secrets.token_hex(4)}{target.suffix}")
    try:
        yield temporary
        _sync(temporary)
        temporary.replace(target)
        _sync(target.parent)
    finally:
        temporary.unlink(missing_ok=True)


def _sync(file_path: Path) -> None:
    descriptor = os.open(file_path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def real_path(file_path: Path) -> Path:
    """Follow links: replacing the link itself would leave the file it names untouched."""
    return Path(os.path.realpath(file_path))
