"""What a motion file says, before USD: joints by their own names, offsets, and a transform per frame and joint."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from mtex_usd.errors import InputError

__all__ = ["FormatError", "Recording"]

FloatArray = npt.NDArray[np.float64]


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
        self.reason = reason
        place = str(file_path) if line is None else f"{file_path}:{line}"
        super().__init__(f"{place}: {reason}")


@dataclass(frozen=True, eq=False, kw_only=True)
class Recording:
    """One recorded motion on the skeleton of its file; rest rotations are identity.

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
    """

    source: Path
    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: FloatArray
    rate: float
    rotations: FloatArray
    translations: FloatArray
    skipped_frames: int = 0

    @property
    def frame_count(self) -> int:
        """How many frames there are (F)."""
        return len(self.rotations)

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
            skipped_frames=self.skipped_frames + frame_count,
        )
