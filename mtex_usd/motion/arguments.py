"""What Python callers give as motions, numbers, words and tokens: taken where it is plain what is meant, else refused.

Every function gives back what it was given in one type, or raises an InputError that says what was expected and found.
"""

import sys
from collections.abc import Iterable, Mapping
from contextlib import suppress
from numbers import Integral, Real

import numpy as np
import numpy.typing as npt

from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip

__all__ = [
    "MOST_FRAMES",
    "as_clip",
    "as_clip_with_gaps",
    "as_clips",
    "as_frame",
    "as_frame_count",
    "as_number",
    "as_numbers",
    "as_tokens",
    "as_whole_number",
    "as_word",
    "refuse",
]

FloatArray = npt.NDArray[np.float64]

MOST_FRAMES = 200_000
"""More than two hours at 24 frames/s; what asks for more is a slip, and would fill the memory."""

_ABOVE_0 = sys.float_info.min
_LARGEST = sys.float_info.max
_LONGEST_TEXT = 60


def as_clip(value: object, name: str = "clip") -> Clip:
    """Take a motion with a number everywhere.

    Parameters
    ----------
    value
        The motion.
    name
        What the caller calls it, for the message.

    Raises
    ------
    InputError
        Where it is no Clip, or holds a number that is not finite.
    """
    clip = as_clip_with_gaps(value, name)
    if not all(np.isfinite(values).all() for values in (clip.rotations, clip.translations, clip.scales)):
        raise InputError(
            f"{clip.name or name} has gaps",
            expected="finite numbers everywhere",
            found="a number that is not",
            fix="Fill them first, with the gaps step of the clean-up.",
        )
    return clip


def as_clip_with_gaps(value: object, name: str = "clip") -> Clip:
    """Take a motion that may hold nan where nothing was captured.

    Raises
    ------
    InputError
        Where it is no Clip.
    """
    if not isinstance(value, Clip):
        raise refuse(value, name, "a Clip")
    return value


def as_clips(values: object, name: str) -> list[Clip]:
    """Take several motions; a single one counts as one.

    Raises
    ------
    InputError
        As :func:`as_clip`.
    """
    if isinstance(values, Clip):
        return [as_clip(values, name)]
    if not isinstance(values, Iterable) or isinstance(values, str | bytes | Mapping):
        raise refuse(values, name, "a Clip, or several")
    return [as_clip(value, name) for value in values]


def as_number(
    value: object,
    name: str,
    *,
    expected: str = "a finite number above 0",
    least: float = _ABOVE_0,
    most: float = _LARGEST,
    unit: str = "",
) -> float:
    """Take a number, Python's or numpy's.

    Parameters
    ----------
    value
        The number.
    name, expected
        What the caller calls it and what it should be, for the message.
    least, most
        The range, both included; infinite to allow infinity.
    unit
        Behind the number in the message.

    Raises
    ------
    InputError
        Where it is out of range, nan or anything else, such as True or a text.
    """
    if not isinstance(value, Real) or isinstance(value, bool):
        raise refuse(value, name, expected)
    try:
        number = float(value)
    except OverflowError:
        raise refuse(value, name, expected) from None
    if not least <= number <= most:
        raise InputError(f"bad {name}", expected=expected, found=f"{number:g} {unit}".rstrip())
    return number


def as_whole_number(value: object, name: str, *, least: int = 0, most: int | None = None, expected: str = "") -> int:
    """Take a whole number, Python's or numpy's.

    Parameters
    ----------
    value
        The number.
    name
        What the caller calls it, for the message.
    least, most
        The range, both included; None for no upper end.
    expected
        For the message; empty for what the range says.

    Raises
    ------
    InputError
        Where it is out of range or anything else, such as True or 2.5.
    """
    what = expected or (f"a whole number of at least {least}" if most is None else f"a whole number, {least} to {most}")
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise refuse(value, name, what)
    number = int(value)
    if number < least or (most is not None and number > most):
        raise refuse(number, name, what)
    return number


def as_frame(value: object, name: str, clip: Clip) -> int:
    """Take the number of one of a clip's frames, counted from 0.

    Raises
    ------
    InputError
        Where there is no such frame.
    """
    return as_whole_number(value, name, most=clip.frame_count - 1)


def as_frame_count(value: object, name: str = "frame count", *, least: int = 2) -> int:
    """Take a number of frames to make.

    Raises
    ------
    InputError
        Where it is no whole number of at least `least`, or above :data:`MOST_FRAMES`.
    """
    expected = f"a whole number of frames, at least {least} and at most {MOST_FRAMES}"
    return as_whole_number(value, name, least=least, most=MOST_FRAMES, expected=expected)


def as_numbers(value: object, name: str, *, expected: str) -> FloatArray:
    """Take numbers in rows, or a single one, as an array; their shape is for the caller to check.

    Parameters
    ----------
    value
        Numbers, nested evenly.
    name, expected
        What the caller calls them and what they should be, for the message.

    Raises
    ------
    InputError
        Where they are texts, truth values, nested unevenly or anything else; nan is a number here.
    """
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):
        raise refuse(value, name, expected) from None
    if array.dtype.kind not in "iuf":
        raise refuse(value, name, expected)
    return array.astype(np.float64)


def as_tokens(values: object, name: str = "channels", *, expected: str = "a list of channel tokens") -> tuple[str, ...]:
    """Take a list of texts; a single text is refused, since a list of its letters may be what was meant elsewhere.

    Raises
    ------
    InputError
        Where it is a single text, no list, or holds anything but texts.
    """
    if not isinstance(values, Iterable) or isinstance(values, str | bytes | Mapping):
        raise refuse(values, name, expected)
    tokens = tuple(values)
    strange = [token for token in tokens if not isinstance(token, str)]
    if strange:
        raise refuse(strange[0], name, expected)
    return tokens


def as_word(value: object, words: Iterable[str], message: str) -> str:
    """Take one of a few words.

    Parameters
    ----------
    value
        The word.
    words
        Those there are.
    message
        What to say where it is none of them.

    Raises
    ------
    InputError
        Where it is none of them.
    """
    allowed = tuple(words)
    if not isinstance(value, str) or value not in allowed:
        raise InputError(message, expected=" or ".join(allowed), found=_describe(value))
    return value


def refuse(value: object, name: str, expected: str) -> InputError:
    """Make the error for a value that is not what was expected."""
    return InputError(f"bad {name}", expected=expected, found=_describe(value))


def _describe(value: object) -> str:
    """Show what is short enough to be recognised by, else its type."""
    text = ""
    if value is None or isinstance(value, str | bytes | bool | int | float | list | tuple):
        # Python refuses to write whole numbers of thousands of digits.
        with suppress(ValueError):
            text = repr(value)
    kind = type(value).__name__
    return text if 0 < len(text) <= _LONGEST_TEXT else f"{'an' if kind[0] in 'aeiouAEIOU' else 'a'} {kind}"
