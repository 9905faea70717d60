"""The clean-up on what a file reader gives, before it becomes a take."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.cleaning import CleaningResult, Finding, clean_clip
from mtex_usd.formats.recording import Recording
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.usd.names import build_joint_paths

__all__ = ["CleanedRecording", "clean_recording"]

FloatArray = npt.NDArray[np.float64]

_UP = {"Y": np.array([0.0, 1.0, 0.0]), "Z": np.array([0.0, 0.0, 1.0])}


@dataclass(frozen=True, eq=False, kw_only=True)
class CleanedRecording:
    """A recording after the clean-up.

    Parameters
    ----------
    recording
        The recording; the very one that was given where nothing was changed.
    changes
        Every repair; frames count from 0 in the file.
    notes
        What was found and left as it is.
    """

    recording: Recording
    changes: tuple[Finding, ...] = ()
    notes: tuple[Finding, ...] = ()


def clean_recording(recording: Recording, steps: Sequence[str]) -> CleanedRecording:
    """Run steps of the clean-up on a recording.

    Parameters
    ----------
    recording
        The recording.
    steps
        As :func:`mtex_usd.edit.cleaning.clean_clip` takes them; none gives the recording back.

    Raises
    ------
    InputError
        For an unknown step.
    """
    if not steps:
        return CleanedRecording(recording=recording)
    up, floor_height = _find_floor(recording)
    clip = _to_clip(recording, up)
    result = clean_clip(clip, steps, floor_height=floor_height)
    skipped = recording.skipped_frames
    changes, notes = (
        tuple(replace(found, first=found.first + skipped, last=found.last + skipped) for found in findings)
        for findings in (result.changes, result.notes)
    )
    cleaned = recording if result.clip is clip else _take_over(recording, result)
    return CleanedRecording(recording=cleaned, changes=changes, notes=notes)


def _find_floor(recording: Recording) -> tuple[FloatArray, float]:
    """Up in skeleton space, a unit vector, and the height along it of the floor of the file's world."""
    up = _UP[recording.up_axis or "Y"]
    if recording.placement is None:
        return up, 0.0
    within = recording.placement[:3, :3] @ up
    length = float(np.linalg.norm(within))
    return within / length, -float(recording.placement[3, :3] @ up) / length


def _to_clip(recording: Recording, up: FloatArray) -> Clip:
    skeleton = Skeleton(
        joints=recording.joint_paths or build_joint_paths(recording.names, recording.parents),
        rest=recording.rest_transforms,
        up=up,
        meters_per_unit=recording.meters_per_unit or 0.01,
    )
    return Clip(
        skeleton=skeleton,
        rate=recording.rate,
        rotations=recording.rotations,
        translations=recording.translations,
        scales=np.ones(recording.translations.shape) if recording.scales is None else recording.scales,
        name=str(recording.source),
    )


def _take_over(recording: Recording, result: CleaningResult) -> Recording:
    shortened = recording.without_first(result.dropped_frames)
    return replace(shortened, rotations=result.clip.rotations, translations=result.clip.translations)
