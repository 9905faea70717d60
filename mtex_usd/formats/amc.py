"""Acclaim motion files (.amc): the motion of an ASF skeleton as arrays.

A bone's angles turn it about its own axes C, which are fixed in the rest pose, the first channel first: relative to the
parent the rotation is C M C⁻¹. The root's preset ``orientation`` is such an axis, its ``position`` is added.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np
import numpy.typing as npt

from mtex_usd.formats.asf import AsfBone, AsfSkeleton, read_asf
from mtex_usd.formats.recording import ChannelLimit, FormatError, Recording
from mtex_usd.formats.source_text import LARGEST, SourceText, decode_lines, parse_number
from mtex_usd.formats.turns import compose_fixed
from mtex_usd.motion import quaternion

__all__ = ["DEFAULT_RATE", "find_skeleton", "read_amc"]

FloatArray = npt.NDArray[np.float64]

DEFAULT_RATE = 120.0
"""Frames per second where neither the file nor the caller tells: that of most optical systems, and of CMU's files."""


def find_skeleton(file_path: Path) -> Path:
    """Find the skeleton file of a motion file in the same folder.

    Parameters
    ----------
    file_path
        The AMC file.

    Returns
    -------
    Path
        The .asf file with the same stem; else the one whose stem begins the motion's, the longest of them (``91.asf``
        for ``91_13.amc``); else the only one.

    Raises
    ------
    FormatError
        Where there is none, or none of several fits.
    """
    try:
        found = sorted(other for other in file_path.parent.iterdir() if other.suffix.lower() == ".asf")
    except OSError as error:
        raise FormatError(file_path, None, f"cannot be read: {error.strerror}") from error
    fitting = [other for other in found if file_path.stem.lower().startswith(other.stem.lower())]
    if fitting:
        return max(fitting, key=lambda other: len(other.stem))
    if len(found) == 1:
        return found[0]
    there_are = f"none of {', '.join(other.name for other in found)} has its name" if found else "there is no .asf file"
    raise FormatError(file_path, None, f"no skeleton beside it: {there_are}; name one with --skeleton")


def read_amc(file_path: Path, *, skeleton: Path | None = None, rate: float | None = None) -> Recording:
    """Read an Acclaim motion with its skeleton.

    Parameters
    ----------
    file_path
        The .amc file.
    skeleton
        Its .asf file; found by :func:`find_skeleton` where None.
    rate
        Frames per second; where None what a line ``:SAMPLES-PER-SECOND`` says, else 120.

    Returns
    -------
    Recording
        A bone of the skeleton that the motion never names stays at rest.

    Raises
    ------
    FormatError
        Where either file cannot be read or they do not fit, with line and reason.
    """
    text = SourceText(file_path=file_path, lines=decode_lines(file_path))
    asf_path = skeleton or find_skeleton(file_path)
    asf = read_asf(asf_path)
    motion = _AmcParser(text, asf).parse()
    return Recording(
        source=file_path,
        names=tuple(bone.name for bone in asf.bones),
        parents=tuple(bone.parent for bone in asf.bones),
        offsets=np.array([bone.offset for bone in asf.bones]),
        rate=rate or motion.rate or DEFAULT_RATE,
        rotations=quaternion.unroll(_compose_rotations(asf.bones, motion)),
        translations=_place_bones(asf.bones, motion),
        meters_per_unit=asf.meters_per_unit,
        companions=(asf_path,),
        limits=tuple(_list_limits(asf.bones)),
        dof_axes=np.array([bone.axis for bone in asf.bones]) if any(bone.limits for bone in asf.bones) else None,
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class _Motion:
    """Values by bone, shape [F, D], degrees and file units."""

    rate: float | None
    frame_count: int
    values: tuple[FloatArray, ...]

    def channel(self, bones: Sequence[AsfBone], bone: int, channel: str) -> FloatArray:
        """Give the values of one channel, shape [F]; zeros where the bone has none."""
        dof = bones[bone].dof
        return self.values[bone][:, dof.index(channel)] if channel in dof else np.zeros(self.frame_count)


class _AmcParser:
    """Collects the rows of each bone; a frame begins at a line that holds its number alone."""

    def __init__(self, text: SourceText, asf: AsfSkeleton) -> None:
        self.text = text
        self.asf = asf
        self.in_radians = asf.in_radians
        self.rate: float | None = None
        self.index = {bone.name: i for i, bone in enumerate(asf.bones)}
        self.rows: list[list[list[str]]] = [[] for _ in asf.bones]
        self.lines: list[list[int]] = [[] for _ in asf.bones]
        self.numbers: list[int] = []
        self.present: set[int] | None = None

    def parse(self) -> _Motion:
        for index, line in enumerate(self.text.lines):
            words = line.split()
            if not words or words[0].startswith("#"):
                continue
            if words[0].startswith(":"):
                self._parse_header(index, words)
            elif len(words) == 1 and words[0].isdecimal():
                self._begin_frame(index, words[0])
            else:
                self._add_row(index, words)
        if not self.numbers:
            raise self.text.error(self.text.last, "the file has no frames")
        self._check_frame(self.text.last)
        values = tuple(self._to_numbers(bone) for bone in range(len(self.asf.bones)))
        return _Motion(rate=self.rate, frame_count=len(self.numbers), values=values)

    def _parse_header(self, index: int, words: list[str]) -> None:
        if self.numbers:
            raise self.text.error(index, f"{words[0][:40]} among the frames")
        match words[0].lower():
            case ":degrees":
                self.in_radians = False
            case ":radians":
                self.in_radians = True
            case ":samples-per-second":
                self.rate = parse_number(self.text, index, words[1] if len(words) == 2 else "")
                if not 1e-4 <= self.rate <= 1e6:
                    raise self.text.error(index, "expected samples per second above 0")

    def _begin_frame(self, index: int, word: str) -> None:
        number = int(word[:18])
        if self.numbers:
            self._check_frame(index)
            if number != self.numbers[-1] + 1:
                raise self.text.error(index, f"frame {number} comes after frame {self.numbers[-1]}")
        self.numbers.append(number)

    def _add_row(self, index: int, words: list[str]) -> None:
        if not self.numbers:
            raise self.text.error(
                index, f"not an AMC file: expected the number of the first frame, found {words[0][:40]!r}"
            )
        bone = self.index.get(words[0])
        if bone is None:
            raise self.text.error(index, f"{words[0][:40]!r} is no bone of {self.asf.file_path.name}")
        dof = self.asf.bones[bone].dof
        if len(words) != len(dof) + 1:
            reason = f"{words[0]} should have {len(dof)} values ({' '.join(dof) or 'it does not move'})"
            raise self.text.error(index, f"{reason}, found {len(words) - 1}")
        if len(self.rows[bone]) == len(self.numbers):
            raise self.text.error(index, f"frame {self.numbers[-1]} has {words[0]} twice")
        if self.present is not None and bone not in self.present:
            raise self.text.error(index, f"frame {self.numbers[-1]} has {words[0]}, which the first frame has not")
        self.rows[bone].append(words)
        self.lines[bone].append(index)

    def _check_frame(self, index: int) -> None:
        """Make sure that the frame that ends here has the bones of the first one."""
        if self.present is None:
            self.present = {bone for bone, rows in enumerate(self.rows) if rows}
        for bone in self.present:
            if len(self.rows[bone]) != len(self.numbers):
                reason = f"frame {self.numbers[-1]} has no line for {self.asf.bones[bone].name}"
                raise self.text.error(index, reason)

    def _to_numbers(self, bone: int) -> FloatArray:
        dof, rows = self.asf.bones[bone].dof, self.rows[bone]
        if not rows:
            return np.zeros((len(self.numbers), len(dof)))
        try:
            values = np.array(list(map(float, chain.from_iterable(row[1:] for row in rows))))
        except ValueError:
            values = np.array([np.nan])
        if not np.all(np.abs(values) < LARGEST):
            self._report_bad_number(bone)
        values = values.reshape(len(rows), len(dof))
        if self.in_radians:
            angles = [column for column, channel in enumerate(dof) if channel.startswith("r")]
            values[:, angles] = np.degrees(values[:, angles])
        return values

    def _report_bad_number(self, bone: int) -> None:
        for index, row in zip(self.lines[bone], self.rows[bone], strict=True):
            for word in row[1:]:
                parse_number(self.text, index, word)


def _compose_rotations(bones: Sequence[AsfBone], motion: _Motion) -> FloatArray:
    rotations = np.empty((motion.frame_count, len(bones), 4))
    for i, bone in enumerate(bones):
        channels = [channel for channel in bone.dof if channel.startswith("r")]
        angles = [motion.channel(bones, i, channel) for channel in channels]
        turn = compose_fixed([channel[1] for channel in channels], angles, frame_count=motion.frame_count)
        rotations[:, i] = quaternion.multiply(quaternion.multiply(bone.axis, turn), quaternion.conjugate(bone.axis))
    return rotations


def _place_bones(bones: Sequence[AsfBone], motion: _Motion) -> FloatArray:
    """Translations relative to the parent, shape [F, J, 3]; the channel l moves the far end of a bone along it."""
    translations = np.repeat(np.array([bone.offset for bone in bones])[None], motion.frame_count, axis=0)
    for i, bone in enumerate(bones):
        if any(channel.startswith("t") for channel in bone.dof):
            moved = np.stack([motion.channel(bones, i, f"t{axis}") for axis in "xyz"], axis=-1)
            translations[:, i] += moved if bone.parent < 0 else quaternion.rotate(bone.axis, moved)
        if bone.parent >= 0 and "l" in bones[bone.parent].dof:
            longer = motion.channel(bones, bone.parent, "l")
            translations[:, i] += longer[:, None] * bones[bone.parent].direction
    return translations


def _list_limits(bones: Sequence[AsfBone]) -> Iterable[ChannelLimit]:
    for i, bone in enumerate(bones):
        for channel, (lower, upper) in zip(bone.dof, bone.limits, strict=False):
            if np.isfinite(lower) or np.isfinite(upper):
                yield ChannelLimit(joint=i, channel=channel, lower=lower, upper=upper)
