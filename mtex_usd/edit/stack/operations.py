"""Which operations there are, and what settings each of them takes."""

from collections.abc import Mapping
from dataclasses import dataclass

from mtex_usd.edit.stack.edit import Edit

__all__ = ["OPERATIONS", "SPAN", "Operation", "check_edit"]

SPAN = ("start", "end", "ramp")
"""The settings of the span in which an edit acts: first and last time code, and how long the fade takes, seconds."""


@dataclass(frozen=True, kw_only=True)
class Operation:
    """What an operation takes.

    Parameters
    ----------
    needs
        Settings that have to be authored.
    takes
        Settings that may be.
    others
        How many other motions it takes, least and most; None for any number.
    """

    needs: tuple[str, ...] = ()
    takes: tuple[str, ...] = ()
    others: tuple[int, int | None] = (0, 0)

    @property
    def settings(self) -> tuple[str, ...]:
        """All settings it may have, ``with`` included."""
        named = ("with",) if self.others[1] != 0 else ()
        return (*self.needs, *self.takes, *named)


_FILTER = Operation(needs=("frequencies",), takes=("channels", "order", *SPAN))
_AFTER = ("ends", "end", "channels")

OPERATIONS: Mapping[str, Operation] = {
    "lowpass": _FILTER,
    "highpass": _FILTER,
    "bandpass": _FILTER,
    "equalize": Operation(needs=("gains",), takes=("residualGain", "channels", *SPAN)),
    "median": Operation(needs=("window",), takes=("channels", *SPAN)),
    "robustMean": Operation(needs=("window",), takes=("discard", "channels", *SPAN)),
    "waveshape": Operation(needs=("channels",), takes=("points", "about", "limits", "softness", *SPAN)),
    "mirror": Operation(takes=("plane",)),
    "shiftTime": Operation(needs=("from", "to"), takes=("ends", "channels")),
    "scaleTime": Operation(takes=("factor", *_AFTER)),
    "warpTime": Operation(needs=("from", "to"), takes=_AFTER),
    "align": Operation(takes=("channels", "maxSlope", "band", "free"), others=(1, 1)),
    "blend": Operation(
        needs=("weights",), takes=("keys", "place", "align", "maxSlope", "band", "free", *SPAN), others=(1, None)
    ),
    "join": Operation(takes=("from", "to", "start", "end", "joinTime", "method"), others=(0, 1)),
    "displace": Operation(needs=("keys",), takes=("channels", "rotations", "translations", "scope"), others=(0, 1)),
    "reduceKeys": Operation(
        takes=("form", "tolerance", "distance", "keyCount", "keys", "contacts", "robust", "channels")
    ),
}
"""Every operation by the name it has in ``mtex:edit:<name>:op``."""


def check_edit(edit: Edit) -> None:
    """Refuse an edit whose operation is unknown, lacks a setting or has one that it does not know.

    Parameters
    ----------
    edit
        The edit.

    Raises
    ------
    InputError
        Naming the edit and the setting.
    """
    operation = OPERATIONS.get(edit.op)
    if operation is None:
        raise edit.fail("there is no such operation", expected=f"one of {', '.join(OPERATIONS)}", found=repr(edit.op))
    missing = [name for name in operation.needs if name not in edit.settings]
    if missing:
        raise edit.fail(f"{missing[0]} is not said", expected=", ".join(operation.needs))
    strange = [name for name in edit.settings if name not in operation.settings]
    if strange:
        raise edit.fail(f"it takes no {strange[0]}", expected=f"only {', '.join(operation.settings)}")
    least, most = operation.others
    if len(edit.others) < least or (most is not None and len(edit.others) > most):
        wanted = str(least) if least == most else f"{least} to {most}" if most is not None else f"{least} or more"
        raise edit.fail("with does not fit", expected=f"{wanted} other motions", found=f"{len(edit.others)}")
