"""Text files of recorded motion: their lines, and numbers in them with errors that name the line."""

import math
import re
from dataclasses import dataclass
from pathlib import Path

from mtex_usd.formats.recording import FormatError

__all__ = ["LARGEST", "SourceText", "decode_lines", "parse_count", "parse_number", "read_bytes"]

LARGEST = 3.4e38
"""What USD's single precision holds."""


@dataclass(frozen=True, kw_only=True)
class SourceText:
    """The lines of a file.

    Parameters
    ----------
    file_path
        The file.
    lines
        Its lines without line ends.
    """

    file_path: Path
    lines: tuple[str, ...]

    def error(self, index: int, reason: str) -> FormatError:
        """Make the error for the line of an index into `lines`."""
        return FormatError(self.file_path, index + 1, reason)

    @property
    def last(self) -> int:
        """Index of the last line that is not blank, 0 in an empty file."""
        return next((i for i in reversed(range(len(self.lines))) if self.lines[i].strip()), 0)


def read_bytes(file_path: Path) -> bytes:
    """Read a whole file.

    Parameters
    ----------
    file_path
        The file.

    Raises
    ------
    FormatError
        Where it cannot be opened.
    """
    try:
        return file_path.read_bytes()
    except OSError as error:
        raise FormatError(file_path, None, f"cannot be read: {error.strerror}") from error


def decode_lines(file_path: Path) -> tuple[str, ...]:
    """Read the lines of a text file with Windows, Unix or old Macintosh line ends.

    Parameters
    ----------
    file_path
        UTF-8, or failing that Latin-1: only names can hold more than ASCII, and old exporters used their own code page.

    Raises
    ------
    FormatError
        Where it cannot be opened, is empty or is no text.
    """
    data = read_bytes(file_path)
    if b"\0" in data:
        raise FormatError(file_path, data.count(b"\n", 0, data.index(b"\0")) + 1, "not a text file")
    if not data.strip():
        raise FormatError(file_path, 1, "the file is empty")
    return tuple(_decode(data).replace("\r\n", "\n").replace("\r", "\n").split("\n"))


def _decode(data: bytes) -> str:
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def parse_number(text: SourceText, index: int, word: str) -> float:
    """Read one number.

    Parameters
    ----------
    text, index
        The file and the line the word is on, for the message.
    word
        The number as written.

    Raises
    ------
    FormatError
        Where it is no number, not finite, or too large for single precision.
    """
    try:
        number = float(word)
    except ValueError:
        raise text.error(index, f"expected a number, found {word[:40]!r}") from None
    if not math.isfinite(number) or abs(number) > LARGEST:
        raise text.error(index, f"expected a finite number in single precision's range, found {word[:40]!r}")
    return number


def parse_count(text: SourceText, index: int, word: str, what: str) -> int:
    """Read how many of something there are.

    Parameters
    ----------
    text, index
        The file and the line the word is on, for the message.
    word
        The number as written.
    what
        What is counted, for the message.

    Raises
    ------
    FormatError
        Where it is no whole number of at most 18 digits.
    """
    if not re.fullmatch(r"[0-9]{1,18}", word):
        raise text.error(index, f"expected the number of {what}, found {word[:40]!r}")
    return int(word)
