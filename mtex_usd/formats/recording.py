"""What a motion file says, before USD: joints by their own names, the rest pose, a transform per frame and joint."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from mtex_usd.errors import InputError

__all__ = ["ChannelLimit", "FormatError", "NoMotionError", "Recording"]

FloatArray = npt.NDArray[np.float64]

_LARGEST = float(np.finfo(np.float32).max)
_LARGEST_SCALE = float(np.finfo(np.float16).max)
_SLOWEST, _FASTEST = 1e-5, 1e7  # frames per second
_SMALLEST_UNIT, _LARGEST_UNIT = 1e-12, 1e12  # metres
_LONGEST_PATHS = 20_000_000  # characters of all joint paths, which grow with the square of the depth
_LONGEST_REASON = 500  # characters; damaged files make parsers quote them by the page


class FormatError(InputError):
    """A motion file that cannot be read.

    Parameters
    ----------
    file_path
        The file.
    line
        Line number from 1; None where the file could not be opened.
    reason
        What is wrong there.
    """

    def __init__(self, file_path: Path, line: int | None, reason: str) -> None:
        self.file_path = file_path
        self.line = line
        self.reason = _shorten(reason)
        place = str(file_path) if line is None else f"{file_path}:{line}"
        super().__init__(f"{place}: {self.reason}")

    def __reduce__(self) -> tuple[type["FormatError"], tuple[Path, int | None, str]]:
        """Let it be pickled, from one process to another."""
        return type(self), (self.file_path, self.line, self.reason)


def _shorten(reason: str) -> str:
    half = _LONGEST_REASON // 2
    return reason if len(reason) <= _LONGEST_REASON else f"{reason[:half]} … {reason[-half:]}"


class NoMotionError(FormatError):
    """A file that is in order but holds no motion of joints, such as a model or a set."""


@dataclass(frozen=True, kw_only=True)
class ChannelLimit:
    """How far one degree of freedom of a joint may go.

    Parameters
    ----------
    joint
        Index of the joint.
    channel
        ``"rx"``, ``"ry"``, ``"rz"``, ``"tx"``, ``"ty"``, ``"tz"`` or ``"l"`` (along the bone), about or along the
        joint's own axes (:attr:`Recording.dof_axes`).
    lower, upper
        Degrees for rotations, else file units; infinite where a side is open.
    """

    joint: int
    channel: str
    lower: float
    upper: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Recording:
    """One recorded motion on the skeleton of its file.

    Parameters
    ----------
    source
        The file it was read from.
    names
        Joint names as the file writes them, a parent before its children, length J; they may repeat.
    parents
        Parent index of each joint, -1 for a root, length J.
    offsets
        Rest translations relative to the parent, file units, shape [J, 3].
    rate
        Frames per second.
    rotations
        Relative to the parent, real part first, consecutive frames on the same side, shape [F, J, 4].
    translations
        Relative to the parent, file units, shape [F, J, 3].
    skipped_frames
        How many frames of the file come before the first one here.
    scales
        Relative to the parent, shape [F, J, 3]; None where every scale is 1.
    rest
        Rest transforms relative to the parent, shape [J, 4, 4], USD layout (row vectors); None where they are the
        `offsets` alone, without rotation.
    bind
        Bind transforms in skeleton space, shape [J, 4, 4], USD layout; None where they are the accumulated rest.
    joint_paths
        Joint paths to keep as they are; empty where they are to be built from `names`.
    meters_per_unit
        Length of a file unit in metres; None where the file does not say.
    up_axis
        ``"Y"`` or ``"Z"``; None where the file does not say.
    placement
        Transform from skeleton space to the file's world, shape [4, 4], USD layout; None where they are the same.
    clip
        Which of the motions of the file this is; empty where there is only one.
    style
        How it was performed, where the file says so.
    companions
        Further files its content came from, such as the skeleton of an AMC file or the buffers of a glTF file.
    limits
        Limits of degrees of freedom, where the file has them.
    dof_axes
        Orientation in skeleton space of the axes that `limits` are about, real part first, shape [J, 4]; None where
        there are no limits.
    notes
        What a user should know about the reading.

    Raises
    ------
    FormatError
        Where a number is not finite, or too large for the precision in which USD keeps it: single for rotations,
        translations and the rest pose, half for scales; the rate, unit or up axis is none; or joints hang on each other
        so deep that their paths would fill the memory.
    """

    source: Path
    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: FloatArray
    rate: float
    rotations: FloatArray
    translations: FloatArray
    skipped_frames: int = 0
    scales: FloatArray | None = None
    rest: FloatArray | None = None
    bind: FloatArray | None = None
    joint_paths: tuple[str, ...] = ()
    meters_per_unit: float | None = None
    up_axis: str | None = None
    placement: FloatArray | None = None
    clip: str = ""
    style: str = ""
    companions: tuple[Path, ...] = ()
    limits: tuple[ChannelLimit, ...] = ()
    dof_axes: FloatArray | None = None
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse numbers that a take cannot hold."""
        for name in ("rotations", "translations", "offsets", "rest", "bind", "placement"):
            self._check_range(name, _LARGEST)
        self._check_range("scales", _LARGEST_SCALE)
        self._check_depth()
        if not _SLOWEST <= self.rate <= _FASTEST:
            raise FormatError(self.source, None, f"bad rate of {self.rate:g} frames per second")
        if self.meters_per_unit is not None and not _SMALLEST_UNIT <= self.meters_per_unit <= _LARGEST_UNIT:
            raise FormatError(self.source, None, f"bad unit of {self.meters_per_unit:g} metres")
        if self.up_axis not in {None, "Y", "Z"}:
            raise FormatError(self.source, None, f"bad up axis {self.up_axis!r}; expected Y or Z")

    def _check_range(self, name: str, largest: float) -> None:
        values: FloatArray | None = getattr(self, name)
        # Not by np.abs, whose copy takes as long as the rest of the check; NaN is in no range.
        if values is None or not values.size or (values.max() <= largest and values.min() >= -largest):
            return
        reason = f"{name} hold a number that is not finite or larger than {largest:.5g}, which no take can hold"
        raise FormatError(self.source, None, f"{self.clip}: {reason}" if self.clip else reason)

    def _check_depth(self) -> None:
        lengths: list[int] = []
        for name, parent in zip(self.names, self.parents, strict=True):
            lengths.append(len(name) + (lengths[parent] + 1 if parent >= 0 else 0))
        if sum(lengths) > _LONGEST_PATHS:
            raise FormatError(self.source, None, f"its {len(lengths)} joints are nested too deep for any skeleton")

    @property
    def frame_count(self) -> int:
        """How many frames there are (F)."""
        return len(self.rotations)

    @property
    def rest_transforms(self) -> FloatArray:
        """Rest transforms relative to the parent, shape [J, 4, 4], USD layout."""
        if self.rest is not None:
            return self.rest
        transforms = np.tile(np.eye(4), (len(self.names), 1, 1))
        transforms[:, 3, :3] = self.offsets
        return transforms

    @property
    def bind_transforms(self) -> FloatArray:
        """Bind transforms in skeleton space, shape [J, 4, 4], USD layout."""
        if self.bind is not None:
            return self.bind
        world = self.rest_transforms.copy()
        for joint, parent in enumerate(self.parents):
            if parent >= 0:
                world[joint] = world[joint] @ world[parent]
        return world

    def without_first(self, frame_count: int) -> "Recording":
        """Leave out frames at the start, such as a calibration pose.

        Parameters
        ----------
        frame_count
            How many to leave out, 0 or more.

        Raises
        ------
        FormatError
            Where no frame would be left.
        """
        if frame_count >= self.frame_count:
            reason = f"nothing is left of its {self.frame_count} frames after skipping {frame_count}"
            raise FormatError(self.source, None, reason)
        return replace(
            self,
            rotations=self.rotations[frame_count:],
            translations=self.translations[frame_count:],
            scales=None if self.scales is None else self.scales[frame_count:],
            skipped_frames=self.skipped_frames + frame_count,
        )
