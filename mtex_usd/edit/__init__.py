"""Edits of recorded motion: pure functions from clip to clip.

They are loaded when they are first used, so that what needs one of them does not wait for all.
"""

from typing import TYPE_CHECKING

from mtex_usd.lazy import load_lazily

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

__getattr__, __dir__ = load_lazily(
    __name__,
    {
        "alignment": ("Alignment", "align"),
        "blending": ("BlendResult", "blend"),
        "displacement": ("Displacement", "PoseChange", "displace"),
        "filters": ("bandpass", "equalize", "highpass", "lowpass"),
        "joins": ("JoinResult", "join"),
        "keys": ("KeyCurve", "ReducedKeys", "ReducedPoses", "reduce_keys", "reduce_poses"),
        "mirroring": ("mirror",),
        "robust": ("median", "robust_mean"),
        "shaping": ("make_soft_limits", "waveshape"),
        "stack.edit": ("Edit", "Outcome"),
        "stack.run": ("run_stack",),
        "timing": ("scale_time", "shift_time"),
        "transitions": ("Transition", "find_transition"),
        "warping": ("TimeWarp", "warp_time"),
    },
)
