"""Edits of time: shifted, scaled, warped, and brought into step with another motion."""

import numpy as np

from mtex_usd.edit.alignment import align
from mtex_usd.edit.stack.edit import Edit
from mtex_usd.edit.timing import scale_time, shift_time
from mtex_usd.edit.warping import warp_time
from mtex_usd.motion.clip import Clip

__all__ = ["run_align", "run_scale_time", "run_shift_time", "run_warp_time"]


def run_shift_time(clip: Clip, edit: Edit) -> Clip:
    """Run ``shiftTime``: what happens at ``from`` happens at ``to``."""
    source, goal = edit.frames("from", clip), edit.frames("to", clip)
    if len(source) != 1 or len(goal) != 1:
        found = f"{len(source)} and {len(goal)} time codes"
        raise edit.fail("from and to do not fit", expected="one time code each", found=found)
    shift_s = float(goal[0] - source[0]) / clip.rate
    return shift_time(clip, shift_s=shift_s, **edit.pick(ends="ends", channels="channels"))


def run_scale_time(clip: Clip, edit: Edit) -> Clip:
    """Run ``scaleTime``."""
    chosen = edit.pick(ends="ends", channels="channels")
    return scale_time(clip, factor=edit.settings.get("factor", 1.0), frame_count=_frame_count(clip, edit), **chosen)


def run_warp_time(clip: Clip, edit: Edit) -> Clip:
    """Run ``warpTime``: what happens at each of ``from`` happens at its partner of ``to``."""
    source, goal = edit.frames("from", clip), edit.frames("to", clip)
    if len(source) != len(goal) or not len(source):
        found = f"{len(source)} and {len(goal)}"
        raise edit.fail("from and to do not fit", expected="as many time codes in both, in pairs", found=found)
    chosen = edit.pick(ends="ends", channels="channels")
    pairs = np.stack([source, goal], axis=1)
    return warp_time(clip, pairs=pairs, frame_count=_frame_count(clip, edit), **chosen)


def run_align(clip: Clip, edit: Edit) -> Clip:
    """Run ``align``: warp the motion into the time of another, from its first frame on."""
    (reference,) = edit.others
    chosen = edit.pick(channels="channels", max_slope="maxSlope", band_s="band", free_s="free")
    pairs = align(clip, reference, **chosen).pairs
    return warp_time(clip, pairs=pairs, frame_count=reference.frame_count)


def _frame_count(clip: Clip, edit: Edit) -> int | None:
    """How many frames there are up to ``end``; None where the motion itself says."""
    if "end" not in edit.settings:
        if "ends" in edit.settings and "channels" not in edit.settings:
            raise edit.fail("nothing follows the motion, for there is no end", fix="Give end, or remove ends.")
        return None
    (last,) = edit.whole_frames("end", clip, beyond=True)
    return last + 1
