"""Joint names as words: what is side, what is noise, and by which words a joint may be known."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

__all__ = ["Reading", "is_noise", "read_names", "side_of", "split_words", "strip_numbering"]

_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
_GLUED_SIDE = re.compile(r"(left|right)(.+)")
_SIDES = {"left": "left", "l": "left", "lft": "left", "right": "right", "r": "right", "rgt": "right"}
_NOISE = frozenset({"joint", "jnt", "jt", "bind", "bone", "bn", "def", "skin", "skn"})
_NO_BODY = frozenset({"ik", "fk", "mch", "org", "ctrl", "pole"})
_COPY_DIGITS = 3  # what Blender appends to a copy: ".001"
_NUMBERED = re.compile(r"_(\d+)$")
_MOSTLY = 0.9
_LEAST_NUMBERED = 4  # names: of fewer an even numbering may be chance


@dataclass(frozen=True, order=True)
class Reading:
    """One way to read a name.

    Parameters
    ----------
    cost
        How many words of noise and how many of prefix were left out; the fewer, the likelier the reading.
    side
        ``"left"``, ``"right"`` or empty.
    key
        What is left, run together, in lower case.
    """

    cost: tuple[int, int]
    side: str
    key: str


def split_words(name: str) -> list[str]:
    """Split a name at humps, digits and whatever is no letter, in lower case; a glued ``left`` is a word of its own."""
    words: list[str] = []
    for word in (found.lower() for found in _WORD.findall(name)):
        glued = _GLUED_SIDE.fullmatch(word)
        words += glued.groups() if glued else [word]
    return words


def strip_numbering(names: Sequence[str]) -> list[str]:
    """Take off the running number that some exporters put behind every name."""
    numbers = [int(found[1]) for found in map(_NUMBERED.search, names) if found]
    is_numbered = len(numbers) >= max(_MOSTLY * len(names), _LEAST_NUMBERED) and len(set(numbers)) == len(numbers)
    return [_NUMBERED.sub("", name) for name in names] if is_numbered else list(names)


def _find_side(words: Sequence[str]) -> int | None:
    """Give the place of the word that tells the side; of several the last one, whole words before letters."""
    places = [place for place, word in enumerate(words) if word in _SIDES]
    return max(places, key=lambda place: (len(words[place]) > 1, place), default=None)


def side_of(name: str) -> str:
    """Give the side a name tells, empty where it tells none."""
    words = split_words(name)
    place = _find_side(words)
    return "" if place is None else _SIDES[words[place]]


def read_names(name: str) -> Iterator[Reading]:
    """List the ways to read a name.

    Parameters
    ----------
    name
        The last name of a joint's path.
    """
    words = split_words(name)
    place = _find_side(words)
    if _NO_BODY.isdisjoint(words):
        yield from _read_without_side(words) if place is None else _read_with_side(words, place)


def _read_with_side(words: list[str], place: int) -> Iterator[Reading]:
    side, before, after = _SIDES[words[place]], words[:place], words[place + 1 :]
    if _denoise(after)[-1:] != [[]]:
        # Behind a side stands nothing but the part: LeftFrontLeg is no LeftLeg.
        for noise, part in enumerate(_denoise(after)):
            yield Reading((noise, len(before)), side, "".join(part))
    else:
        for noise, part in enumerate(_denoise(before), start=len(after)):
            for prefix in range(len(part)):
                yield Reading((noise, prefix), side, "".join(part[prefix:]))


def _read_without_side(words: list[str]) -> Iterator[Reading]:
    for noise, part in enumerate(_denoise(words)):
        for prefix in range(len(part)):
            key = "".join(part[prefix:])
            yield Reading((noise, prefix), "", key)
            if key[0] in "lr":
                yield Reading((noise, prefix), _SIDES[key[0]], key[1:])


def _denoise(words: list[str]) -> list[list[str]]:
    """Give the words, and what is left of them as one word of noise after the other is taken from the end."""
    left = [words]
    while left[-1] and is_noise(left[-1][-1]):
        left.append(left[-1][:-1])
    return left


def is_noise(word: str) -> bool:
    """Tell whether a word at the end of a name says nothing: the kind of node, or the number of a copy."""
    return word in _NOISE or (word.isdigit() and len(word) == _COPY_DIGITS)
