"""The text of a BVH file and the first of its two parts, the hierarchy.

BVH has no standard beyond Biovision's description; exporters differ. Read without complaint: keywords in any case, any
white space and line ends (Windows, Unix, old Macintosh), braces on any line, blank lines, joint names with spaces,
several ROOTs, joints without End Site, any number and order of channels, a byte order mark. Everything else that does
not add up is an error with its line.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from mtex_usd.formats.source_text import SourceText, decode_lines, parse_count, parse_number

__all__ = ["BvhJoint", "BvhText", "parse_hierarchy", "read_text"]

_CHANNELS = {f"{axis}{kind}".lower(): kind[0] + axis for axis in "xyz" for kind in ("position", "rotation")}


@dataclass(frozen=True, kw_only=True)
class BvhText(SourceText):
    """The lines of a file, and where its motion begins.

    Parameters
    ----------
    file_path, lines
        As in :class:`~mtex_usd.formats.source_text.SourceText`.
    motion_line
        Index in `lines` of the word MOTION; the number of lines where there is none.
    """

    motion_line: int


@dataclass(frozen=True, kw_only=True)
class BvhJoint:
    """One joint of the hierarchy.

    Parameters
    ----------
    name
        As the file writes it.
    parent
        Index of its parent, -1 for a root.
    offset
        Translation relative to the parent, file units.
    channels
        In the order of the values: ``"px"`` to ``"pz"`` for positions, ``"rx"`` to ``"rz"`` for rotations.
    """

    name: str
    parent: int
    offset: tuple[float, float, float]
    channels: tuple[str, ...]


class _Token(NamedTuple):
    text: str
    line: int


@dataclass(kw_only=True)
class _Draft:
    """A joint, or an End Site, whose closing brace has not come yet."""

    name: str
    line: int
    index: int | None
    parent: int
    offset: tuple[float, float, float] | None = None
    channels: tuple[str, ...] | None = None


def read_text(file_path: Path) -> BvhText:
    """Read the lines of a BVH file.

    Parameters
    ----------
    file_path
        The file.

    Raises
    ------
    FormatError
        Where it cannot be opened, is empty or is no text.
    """
    lines = decode_lines(file_path)
    motion = next((i for i, line in enumerate(lines) if line.strip().upper() == "MOTION"), len(lines))
    return BvhText(file_path=file_path, lines=lines, motion_line=motion)


def parse_hierarchy(text: BvhText) -> tuple[BvhJoint, ...]:
    """Read the joints.

    Parameters
    ----------
    text
        The file.

    Returns
    -------
    tuple of BvhJoint
        In the order of the file, a parent before its children.

    Raises
    ------
    FormatError
        Where a keyword, brace, OFFSET or CHANNELS is missing, doubled, misplaced or malformed.
    """
    return _HierarchyParser(text).parse()


def _tokenize(text: BvhText) -> Iterator[_Token]:
    for i, line in enumerate(text.lines[: text.motion_line]):
        for match in re.finditer(r"[{}]|[^\s{}]+", line):
            yield _Token(match.group(), i)


class _Cursor:
    """Tokens one after the other with a look at the next."""

    def __init__(self, text: BvhText) -> None:
        self._text = text
        self._tokens = _tokenize(text)
        self._next = next(self._tokens, None)

    def peek(self) -> _Token | None:
        return self._next

    def take(self, wanted: str) -> _Token:
        token = self._next
        if token is None:
            place = min(self._text.motion_line, self._text.last)
            raise self._text.error(place, f"the hierarchy ends where {wanted} is expected")
        self._next = next(self._tokens, None)
        return token

    def take_name(self, line: int) -> str:
        """Take what is left of the line up to the brace."""
        words = []
        while self._next is not None and self._next.line == line and self._next.text not in "{}":
            words.append(self.take("a name").text)
        return " ".join(words)

    def take_brace(self, owner: str) -> None:
        token = self.take(f"'{{' after {owner}")
        if token.text != "{":
            raise self._text.error(token.line, f"expected '{{' after {owner}, found {token.text[:40]!r}")


@dataclass
class _HierarchyParser:
    text: BvhText
    drafts: list[_Draft] = field(default_factory=list)
    open: list[_Draft] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.cursor = _Cursor(self.text)

    def parse(self) -> tuple[BvhJoint, ...]:
        first = self.cursor.take("HIERARCHY")
        if first.text.upper() != "HIERARCHY":
            raise self.text.error(first.line, f"not a BVH file: expected HIERARCHY, found {first.text[:40]!r}")
        while self.cursor.peek() is not None:
            self._parse_entry(self.cursor.take("an entry"))
        self._check_complete()
        return tuple(self._finish(draft) for draft in self.drafts)

    def _parse_entry(self, token: _Token) -> None:
        match token.text.upper():
            case "ROOT" | "JOINT" as keyword:
                self._open_joint(token, keyword)
            case "END":
                self._open_end_site(token)
            case "OFFSET":
                self._parse_offset(token)
            case "CHANNELS":
                self._parse_channels(token)
            case "}":
                self._close(token)
            case _:
                raise self.text.error(token.line, f"unexpected {token.text[:40]!r} in the hierarchy")

    def _open_joint(self, token: _Token, keyword: str) -> None:
        name = self.cursor.take_name(token.line)
        if not name:
            raise self.text.error(token.line, f"{keyword} without a name")
        if keyword == "ROOT" and self.open:
            raise self.text.error(token.line, f"ROOT {name} inside {self.open[-1].name}: a '}}' is missing before it")
        parent = -1 if keyword == "ROOT" else self._joint_index(token)
        draft = _Draft(name=name, line=token.line, index=len(self.drafts), parent=parent)
        self.drafts.append(draft)
        self._enter(draft)

    def _open_end_site(self, token: _Token) -> None:
        parent = self._joint_index(token)
        self.cursor.take_name(token.line)
        self._enter(_Draft(name="End Site", line=token.line, index=None, parent=parent))

    def _enter(self, draft: _Draft) -> None:
        self.cursor.take_brace(draft.name)
        self.open.append(draft)

    def _innermost(self, token: _Token) -> _Draft:
        if not self.open:
            raise self.text.error(token.line, f"{token.text} outside a ROOT")
        return self.open[-1]

    def _joint_index(self, token: _Token) -> int:
        index = self._innermost(token).index
        if index is None:
            raise self.text.error(token.line, f"{token.text} inside an End Site")
        return index

    def _parse_offset(self, token: _Token) -> None:
        draft = self._innermost(token)
        if draft.offset is not None:
            raise self.text.error(token.line, f"{draft.name} has a second OFFSET")
        x, y, z = (self._parse_coordinate(draft) for _ in range(3))
        draft.offset = (x, y, z)

    def _parse_coordinate(self, draft: _Draft) -> float:
        token = self.cursor.take(f"a number of the OFFSET of {draft.name}")
        return parse_number(self.text, token.line, token.text)

    def _parse_channels(self, token: _Token) -> None:
        self._joint_index(token)
        draft = self._innermost(token)
        if draft.channels is not None:
            raise self.text.error(token.line, f"{draft.name} has a second CHANNELS")
        word = self.cursor.take("the number of channels")
        count = parse_count(self.text, word.line, word.text, "channels")
        draft.channels = tuple(self._parse_channel(draft, count) for _ in range(count))
        self._check_positions(token, draft.channels)

    def _parse_channel(self, draft: _Draft, count: int) -> str:
        token = self.cursor.take(f"one of the {count} channels of {draft.name}")
        channel = _CHANNELS.get(token.text.lower())
        if channel is None:
            reason = f"{draft.name} should have {count} channels such as Xposition or Zrotation, found"
            raise self.text.error(token.line, f"{reason} {token.text[:40]!r}")
        return channel

    def _check_positions(self, token: _Token, channels: tuple[str, ...]) -> None:
        # A repeated rotation composes (Z X Z are proper Euler angles); a repeated position has no meaning.
        positions = [channel for channel in channels if channel.startswith("p")]
        if len(set(positions)) != len(positions):
            raise self.text.error(token.line, "the same position channel twice")

    def _close(self, token: _Token) -> None:
        if not self.open:
            raise self.text.error(token.line, "'}' closes nothing")
        draft = self.open.pop()
        if draft.index is None:
            return
        for keyword, value in (("OFFSET", draft.offset), ("CHANNELS", draft.channels)):
            if value is None:
                raise self.text.error(draft.line, f"{draft.name} has no {keyword}")

    def _check_complete(self) -> None:
        place = min(self.text.motion_line, self.text.last)
        if self.open:
            draft = self.open[-1]
            reason = f"the hierarchy ends inside {draft.name}, opened on line {draft.line + 1}: a '}}' is missing"
            raise self.text.error(place, reason)
        if not self.drafts:
            raise self.text.error(place, "the hierarchy ends without a ROOT")

    def _finish(self, draft: _Draft) -> BvhJoint:
        return BvhJoint(
            name=draft.name, parent=draft.parent, offset=draft.offset or (0.0, 0.0, 0.0), channels=draft.channels or ()
        )
