"""Acclaim skeleton files (.asf): bones, their axes, degrees of freedom and limits.

After M. Schafer 1995, *Acclaim Skeleton File Definition V1.10*, and the University of Wisconsin's and Carnegie Mellon's
notes on it. A bone starts where its parent ends; its angles turn it about its own axes, which are fixed in the rest
pose and lie in global space. Commas and brackets are white space, ``#`` begins a comment.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

from mtex_usd.formats.source_text import SourceText, decode_lines, parse_number
from mtex_usd.formats.turns import compose_fixed

__all__ = ["AsfBone", "AsfSkeleton", "read_asf"]

FloatArray = npt.NDArray[np.float64]

_INCH = 0.0254  # the unit of an ASF file is 1 / length inches
_CHANNELS = ("rx", "ry", "rz", "tx", "ty", "tz", "l")
_BLANK = str.maketrans(",()", "   ")
_ROOT = "root"


@dataclass(frozen=True, eq=False, kw_only=True)
class AsfBone:
    """One bone; the root is a bone without length.

    Parameters
    ----------
    name
        As the file writes it.
    parent
        Index of its parent, -1 for the root.
    offset
        Where it begins from where its parent does, file units, shape [3]; the root's position.
    direction
        Unit vector along the bone in global space, shape [3]; zero for the root.
    axis
        Orientation of its own axes in global space, real part first, shape [4].
    dof
        Its channels in the order of the values and of the turns, such as ``("rx", "rz")``.
    limits
        Lower and upper limit of each channel, degrees or file units; empty where the file gives none.
    """

    name: str
    parent: int
    offset: FloatArray
    direction: FloatArray
    axis: FloatArray
    dof: tuple[str, ...]
    limits: tuple[tuple[float, float], ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class AsfSkeleton:
    """A skeleton file.

    Parameters
    ----------
    file_path
        The file.
    bones
        A parent before its children; the first is the root.
    in_radians
        Whether its angles were radians, which motion files then follow unless they say otherwise.
    meters_per_unit
        Length of a file unit in metres.
    """

    file_path: Path
    bones: tuple[AsfBone, ...]
    in_radians: bool
    meters_per_unit: float


def read_asf(file_path: Path) -> AsfSkeleton:
    """Read an Acclaim skeleton.

    Parameters
    ----------
    file_path
        The file.

    Returns
    -------
    AsfSkeleton
        All angles in degrees.

    Raises
    ------
    FormatError
        Where the file cannot be read, with line and reason.
    """
    text = SourceText(file_path=file_path, lines=decode_lines(file_path))
    return _AsfParser(text).parse()


@dataclass(frozen=True)
class _Line:
    index: int
    words: tuple[str, ...]

    @property
    def keyword(self) -> str:
        return self.words[0].lower()


@dataclass(kw_only=True)
class _Draft:
    """A bone as far as it has been read."""

    line: int
    name: str = ""
    direction: FloatArray | None = None
    length: float | None = None
    angles: tuple[float, ...] = (0.0, 0.0, 0.0)
    order: str = "xyz"
    dof: tuple[str, ...] = ()
    limits: tuple[float, ...] = ()
    limits_line: int = 0
    children: list[str] = field(default_factory=list)
    offset: FloatArray = field(default_factory=lambda: np.zeros(3))


def _split_sections(text: SourceText) -> dict[str, list[_Line]]:
    """Give the lines of each section by its keyword, that of the keyword itself first."""
    sections: dict[str, list[_Line]] = {}
    current: list[_Line] | None = None
    for index, raw in enumerate(text.lines):
        words = raw.split("#", 1)[0].translate(_BLANK).split()
        if not words:
            continue
        line = _Line(index, tuple(words))
        if words[0].startswith(":"):
            if line.keyword in sections:
                raise text.error(index, f"a second {words[0]} section")
            current = sections[line.keyword] = []
        elif current is None:
            raise text.error(index, f"not an ASF file: expected a section such as :version, found {words[0][:40]!r}")
        current.append(line)
    return sections


class _AsfParser:
    def __init__(self, text: SourceText) -> None:
        self.text = text
        self.sections = _split_sections(text)
        self.in_radians = False
        self.length_factor = 1.0
        self.bones: dict[str, _Draft] = {}

    def parse(self) -> AsfSkeleton:
        self._parse_units()
        self._parse_root()
        for lines in self._split_blocks(":bonedata"):
            self._parse_bone(lines)
        self._parse_hierarchy()
        return AsfSkeleton(
            file_path=self.text.file_path,
            bones=self._order_bones(),
            in_radians=self.in_radians,
            meters_per_unit=_INCH / self.length_factor,
        )

    def _section(self, name: str) -> list[_Line]:
        if name not in self.sections:
            raise self.text.error(self.text.last, f"the file has no {name} section")
        return self.sections[name]

    def _parse_units(self) -> None:
        for line in self.sections.get(":units", [])[1:]:
            if line.keyword == "angle":
                self.in_radians = self._choose(line, {"deg": False, "rad": True})
            elif line.keyword == "length":
                (self.length_factor,) = self._numbers(line, 1)
                if not 1e-9 <= self.length_factor <= 1e9:
                    raise self.text.error(line.index, "expected a length above 0")

    def _choose(self, line: _Line, known: dict[str, bool]) -> bool:
        word = line.words[1].lower() if len(line.words) == 2 else ""
        if word[:3] not in known:
            raise self.text.error(line.index, f"expected {line.keyword} {' or '.join(known)}, found {word[:40]!r}")
        return known[word[:3]]

    def _numbers(self, line: _Line, count: int) -> tuple[float, ...]:
        words = line.words[1 : count + 1]
        if len(words) != count:
            reason = f"{line.words[0]} should have {count} numbers, found {len(words)}"
            raise self.text.error(line.index, reason)
        return tuple(parse_number(self.text, line.index, word) for word in words)

    def _angles(self, line: _Line, count: int) -> tuple[float, ...]:
        return tuple(self._to_degrees(angle) for angle in self._numbers(line, count))

    def _to_degrees(self, angle: float) -> float:
        return float(np.degrees(angle)) if self.in_radians else angle

    def _parse_root(self) -> None:
        lines = self._section(":root")
        root = self.bones[_ROOT] = _Draft(line=lines[0].index, name=_ROOT, direction=np.zeros(3), length=0.0)
        for line in lines[1:]:
            match line.keyword:
                case "order":
                    root.dof = self._channels(line)
                case "axis":
                    root.order = self._axis_order(line, line.words[1:])
                case "position":
                    root.offset = np.array(self._numbers(line, 3))
                case "orientation":
                    root.angles = self._angles(line, 3)
        if not root.dof:
            raise self.text.error(lines[0].index, "the root has no order")

    def _channels(self, line: _Line) -> tuple[str, ...]:
        channels = tuple(word.lower() for word in line.words[1:])
        for channel in channels:
            if channel not in _CHANNELS:
                raise self.text.error(line.index, f"expected one of {' '.join(_CHANNELS)}, found {channel[:40]!r}")
        if len(set(channels)) != len(channels):
            raise self.text.error(line.index, f"the same channel twice in {line.words[0]}")
        return channels

    def _axis_order(self, line: _Line, words: tuple[str, ...]) -> str:
        order = "".join(words).lower()
        if sorted(order) != ["x", "y", "z"]:
            raise self.text.error(line.index, f"expected an axis order such as XYZ, found {order[:40]!r}")
        return order

    def _split_blocks(self, name: str) -> Iterator[list[_Line]]:
        """Give what stands between each begin and end."""
        block: list[_Line] | None = None
        for line in self._section(name)[1:]:
            if line.keyword == "begin":
                if block is not None:
                    raise self.text.error(line.index, "begin before the end of the block before")
                block = [line]
            elif block is None:
                raise self.text.error(line.index, f"expected begin, found {line.words[0][:40]!r}")
            elif line.keyword == "end":
                yield block
                block = None
            else:
                block.append(line)
        if block is not None:
            raise self.text.error(
                self.text.last, f"a block of {name} is not ended; it begins on line {block[0].index + 1}"
            )

    def _parse_bone(self, lines: list[_Line]) -> None:
        bone = _Draft(line=lines[0].index)
        for line in self._join_limits(lines[1:]):
            self._parse_bone_line(bone, line)
        for what, value in (("name", bone.name or None), ("direction", bone.direction), ("length", bone.length)):
            if value is None:
                raise self.text.error(bone.line, f"the bone {bone.name or 'here'} has no {what}")
        self._check_bone(bone)
        self.bones[bone.name] = bone

    def _join_limits(self, lines: list[_Line]) -> Iterator[_Line]:
        """Put pairs of numbers on lines of their own to the keyword they belong to."""
        joined: list[_Line] = []
        for line in lines:
            if joined and _starts_with_number(line):
                joined[-1] = _Line(joined[-1].index, joined[-1].words + line.words)
            else:
                joined.append(line)
        yield from joined

    def _parse_bone_line(self, bone: _Draft, line: _Line) -> None:
        match line.keyword:
            case "name":
                bone.name = line.words[1] if len(line.words) == 2 else ""
            case "direction":
                bone.direction = np.array(self._numbers(line, 3))
            case "length":
                (bone.length,) = self._numbers(line, 1)
            case "axis":
                bone.angles = self._angles(line, 3)
                bone.order = self._axis_order(line, line.words[4:])
            case "dof":
                bone.dof = self._channels(line)
            case "limits":
                bone.limits = tuple(self._limit(line, word) for word in line.words[1:])
                bone.limits_line = line.index

    def _limit(self, line: _Line, word: str) -> float:
        if word.lower().lstrip("+-") in {"inf", "infinity"}:
            return float(word)
        return parse_number(self.text, line.index, word)

    def _check_bone(self, bone: _Draft) -> None:
        if bone.name in self.bones:
            raise self.text.error(bone.line, f"a second bone {bone.name}")
        if bone.limits and len(bone.limits) != 2 * len(bone.dof):
            reason = f"{bone.name} has {len(bone.dof)} degrees of freedom and {len(bone.limits)} numbers of limits"
            raise self.text.error(bone.limits_line, f"{reason}; expected a lower and an upper one for each")
        if bone.length and not np.any(bone.direction):
            raise self.text.error(bone.line, f"{bone.name} has a length and no direction")

    def _parse_hierarchy(self) -> None:
        placed = {_ROOT}
        for lines in self._split_blocks(":hierarchy"):
            for line in lines[1:]:
                for name in line.words:
                    if name not in self.bones:
                        raise self.text.error(line.index, f"the hierarchy names {name[:40]!r}, which is no bone")
                for child in line.words[1:]:
                    if child in placed:
                        raise self.text.error(line.index, f"{child} has a second place in the hierarchy")
                    placed.add(child)
                    self.bones[line.words[0]].children.append(child)

    def _order_bones(self) -> tuple[AsfBone, ...]:
        """Give the bones depth first."""
        ordered: list[AsfBone] = []
        waiting = [(_ROOT, -1)]
        while waiting:
            name, parent = waiting.pop()
            above = None if parent < 0 else self.bones[ordered[parent].name]
            waiting += [(child, len(ordered)) for child in reversed(self.bones[name].children)]
            ordered.append(self._finish(self.bones[name], parent, above))
        lost = self.bones.keys() - {bone.name for bone in ordered}
        if lost:
            first = min((self.bones[name] for name in lost), key=lambda bone: bone.line)
            raise self.text.error(first.line, f"{first.name} does not hang on the root in the hierarchy")
        return tuple(ordered)

    def _finish(self, draft: _Draft, parent: int, above: _Draft | None) -> AsfBone:
        turns = [np.array([draft.angles["xyz".index(axis)]]) for axis in draft.order]
        limits = zip(draft.limits[::2], draft.limits[1::2], strict=True)
        return AsfBone(
            name=draft.name,
            parent=parent,
            offset=draft.offset if above is None else _unit(above) * (above.length or 0.0),
            direction=_unit(draft),
            axis=compose_fixed(draft.order, turns, frame_count=1)[0],
            dof=draft.dof,
            limits=tuple(self._convert_limit(*pair) for pair in zip(draft.dof, limits, strict=bool(draft.limits))),
        )

    def _convert_limit(self, channel: str, limit: tuple[float, float]) -> tuple[float, float]:
        if not channel.startswith("r"):
            return limit
        return self._to_degrees(limit[0]), self._to_degrees(limit[1])


def _starts_with_number(line: _Line) -> bool:
    try:
        float(line.words[0])
    except ValueError:
        return False
    return True


def _unit(draft: _Draft) -> FloatArray:
    direction = np.zeros(3) if draft.direction is None else draft.direction
    length = float(np.linalg.norm(direction))
    return direction / length if length > 0.0 else direction
