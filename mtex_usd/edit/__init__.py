"""Edits of recorded motion: pure functions from clip to clip.

They are loaded when they are first used, so that what needs one of them does not wait for all.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mtex_usd.edit.alignment import Alignment, align
    from mtex_usd.edit.blending import BlendResult, blend
    from mtex_usd.edit.displacement import Displacement, PoseChange, displace
    from mtex_usd.edit.filters import bandpass, equalize, highpass, lowpass
    from mtex_usd.edit.joins import JoinResult, join
    from mtex_usd.edit.keys import KeyCurve, ReducedKeys, ReducedPoses, reduce_keys, reduce_poses
    from mtex_usd.edit.mirroring import mirror
    from mtex_usd.edit.robust import median, robust_mean
    from mtex_usd.edit.shaping import make_soft_limits, waveshape
    from mtex_usd.edit.stack.edit import Edit, Outcome
    from mtex_usd.edit.stack.run import run_stack
    from mtex_usd.edit.timing import scale_time, shift_time
    from mtex_usd.edit.transitions import Transition, find_transition
    from mtex_usd.edit.warping import TimeWarp, warp_time

__all__ = [
    "Alignment",
    "BlendResult",
    "Displacement",
    "Edit",
    "JoinResult",
    "KeyCurve",
    "Outcome",
    "PoseChange",
    "ReducedKeys",
    "ReducedPoses",
    "TimeWarp",
    "Transition",
    "align",
    "bandpass",
    "blend",
    "displace",
    "equalize",
    "find_transition",
    "highpass",
    "join",
    "lowpass",
    "make_soft_limits",
    "median",
    "mirror",
    "reduce_keys",
    "reduce_poses",
    "robust_mean",
    "run_stack",
    "scale_time",
    "shift_time",
    "warp_time",
    "waveshape",
]

# Where each public name lives, below this package.
_HOMES = {
    **dict.fromkeys(("Alignment", "align"), "alignment"),
    **dict.fromkeys(("BlendResult", "blend"), "blending"),
    **dict.fromkeys(("Displacement", "PoseChange", "displace"), "displacement"),
    **dict.fromkeys(("JoinResult", "join"), "joins"),
    **dict.fromkeys(("bandpass", "equalize", "highpass", "lowpass"), "filters"),
    **dict.fromkeys(("KeyCurve", "ReducedKeys", "ReducedPoses", "reduce_keys", "reduce_poses"), "keys"),
    **dict.fromkeys(("median", "robust_mean"), "robust"),
    **dict.fromkeys(("make_soft_limits", "waveshape"), "shaping"),
    "mirror": "mirroring",
    **dict.fromkeys(("Edit", "Outcome"), "stack.edit"),
    "run_stack": "stack.run",
    **dict.fromkeys(("Transition", "find_transition"), "transitions"),
    **dict.fromkeys(("TimeWarp", "warp_time"), "warping"),
    **dict.fromkeys(("scale_time", "shift_time"), "timing"),
}


def __getattr__(name: str) -> object:
    """Load a public name from the module it lives in."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    """List the public names without loading them."""
    return sorted({*globals(), *__all__})
