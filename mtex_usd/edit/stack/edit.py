"""One edit as it is declared: the operation's name and its settings, in seconds, Hz and time codes."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip

if TYPE_CHECKING:
    from mtex_usd.edit.keys import ReducedKeys, ReducedPoses

__all__ = ["WHOLE_FRAME", "ContactFinder", "Edit", "Outcome", "to_frames"]

FloatArray = npt.NDArray[np.float64]

ContactFinder = Callable[[Clip, str], Sequence[int]]
"""Gives the frames of a clip at which contacts begin and end, for ``detect`` or ``declared``."""

WHOLE_FRAME = 1e-6
"""How near to a frame a time code has to be where only frames will do, frames: layer offsets and scales round."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Edit:
    """One step of an edit stack.

    Parameters
    ----------
    name
        What the user calls it; messages name it.
    op
        The operation, one of :data:`mtex_usd.edit.stack.OPERATIONS`.
    settings
        What is authored, by the name of the property below ``mtex:edit:<name>:``; the rest falls back.
    others
        The motions of ``with``, on the joints of the clip that is edited and at its rate.
    """

    name: str
    op: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    others: tuple[Clip, ...] = ()

    def pick(self, **names: str) -> dict[str, Any]:
        """Give the authored ones of some settings, by the names that a function has for them.

        Parameters
        ----------
        **names
            Name of the setting by name of the argument.
        """
        return {argument: self.settings[name] for argument, name in names.items() if name in self.settings}

    def frames(self, name: str, clip: Clip) -> FloatArray:
        """Turn the time codes of a setting into frames of a clip, counted from 0; none where it is not authored.

        Parameters
        ----------
        name
            A setting of one time code or several.
        clip
            The clip as it is when the edit begins.
        """
        return to_frames(np.atleast_1d(np.asarray(self.settings.get(name, ()), dtype=np.float64)), clip)

    def whole_frames(self, name: str, clip: Clip, *, beyond: bool = False) -> list[int]:
        """As :meth:`frames`, where only whole frames will do.

        Parameters
        ----------
        name, clip
            As for :meth:`frames`.
        beyond
            Whether frames after the clip's last count as well.

        Raises
        ------
        InputError
            Where a time code lies between two frames or outside the clip.
        """
        frames = self.frames(name, clip)
        near = np.round(frames)
        bad = (np.abs(frames - near) > WHOLE_FRAME) | (near < 0) | ((near >= clip.frame_count) & (not beyond))
        if bad.any():
            time_codes = clip.time_codes
            raise self.fail(
                f"{name} is not at a frame of the motion",
                expected=f"time codes from {time_codes[0]:g}{'' if beyond else f' to {time_codes[-1]:g}'}, "
                f"{clip.time_codes_per_frame:g} apart",
                found=f"{np.atleast_1d(self.settings[name])[bad.argmax()]:g}",
            )
        return [int(frame) for frame in near]

    def fail(self, what: str, *, expected: str = "", found: str = "", fix: str = "") -> InputError:
        """Make the error of this edit.

        Parameters
        ----------
        what
            What is wrong.
        expected, found, fix
            As for :class:`mtex_usd.errors.InputError`.
        """
        return InputError(f"edit {self.name} ({self.op}): {what}", expected=expected, found=found, fix=fix)


def to_frames(time_codes: FloatArray, clip: Clip) -> FloatArray:
    """Turn time codes into frames of a clip, counted from 0."""
    return (time_codes - clip.start) / clip.time_codes_per_frame


@dataclass(frozen=True, eq=False, kw_only=True)
class Outcome:
    """What an edit, or a stack of them, made of a motion.

    Parameters
    ----------
    clip
        The motion.
    keys
        The motion by few keys, where the last edit reduced them: curves, or poses.
    notes
        What a user should know.
    """

    clip: Clip
    keys: "ReducedKeys | ReducedPoses | None" = None
    notes: tuple[str, ...] = ()
