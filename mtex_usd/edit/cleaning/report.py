"""What a step of the clean-up did: the clip after it, what was changed where, and what a user should look at."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from mtex_usd.motion.clip import Clip

__all__ = ["CleaningResult", "Finding", "list_runs"]


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One repair, or one thing found and left as it is.

    Parameters
    ----------
    step
        Name of the step, such as ``flips``.
    joint
        Path of the joint; empty where the whole pose is meant.
    first, last
        First and last frame it is about, counted from 0 in the clip that was given.
    what
        What was done, or what is there.
    """

    step: str
    joint: str
    first: int
    last: int
    what: str

    def __str__(self) -> str:
        """Give one line: step, joint, frames and what."""
        frames = f"frame {self.first}" if self.first == self.last else f"frames {self.first}-{self.last}"
        where = f"{self.joint.rpartition('/')[2]} {frames}" if self.joint else frames
        return f"{self.step}: {where}: {self.what}"


@dataclass(frozen=True, eq=False, kw_only=True)
class CleaningResult:
    """A clip after one or more steps of the clean-up.

    Parameters
    ----------
    clip
        The clip; the very one that was given where nothing was changed.
    changes
        Every repair, in the order made.
    notes
        What was found and left as it is.
    dropped_frames
        How many frames were taken off the start.
    """

    clip: Clip
    changes: tuple[Finding, ...] = ()
    notes: tuple[Finding, ...] = ()
    dropped_frames: int = 0

    def then(self, following: "CleaningResult") -> "CleaningResult":
        """Add what a step made of this result's clip.

        Parameters
        ----------
        following
            Result of that step; its frames are counted on from those dropped so far.
        """
        return CleaningResult(
            clip=following.clip,
            changes=self.changes + _move(following.changes, self.dropped_frames),
            notes=self.notes + _move(following.notes, self.dropped_frames),
            dropped_frames=self.dropped_frames + following.dropped_frames,
        )


def _move(findings: Sequence[Finding], frames: int) -> tuple[Finding, ...]:
    return tuple(replace(finding, first=finding.first + frames, last=finding.last + frames) for finding in findings)


def list_runs(frames: npt.NDArray[np.bool_] | Iterable[bool]) -> list[tuple[int, int]]:
    """List the first and last index of every run of true values.

    Parameters
    ----------
    frames
        One value per frame, shape [F].
    """
    marked = np.concatenate([[False], np.asarray(frames, dtype=np.bool_), [False]])
    edges = np.flatnonzero(marked[1:] != marked[:-1])
    return [(int(first), int(end) - 1) for first, end in zip(edges[::2], edges[1::2], strict=True)]
