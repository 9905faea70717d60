"""Edits that act for some time only: faded in and out at the ends of their span."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.mixing import average_rotations
from mtex_usd.edit.stack.edit import WHOLE_FRAME, Edit, to_frames
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.roles import ramp

__all__ = ["limit_to_span", "span_weights"]

FloatArray = npt.NDArray[np.float64]

_RAMP_S = 0.4


def span_weights(edit: Edit, clip: Clip) -> FloatArray | None:
    """Tell how much of an edit counts at every frame.

    Parameters
    ----------
    edit
        The edit.
    clip
        The motion it is of.

    Returns
    -------
    FloatArray or None
        From 0 outside the span to 1 inside, shape [F]; the fades are centred on its ends. None where it has no ends.

    Raises
    ------
    InputError
        For a span without frames, and a fade that is far too long.
    """
    if "start" not in edit.settings and "end" not in edit.settings:
        return None
    start, end = (edit.settings.get(name, default) for name, default in (("start", -np.inf), ("end", np.inf)))
    frames = np.arange(clip.frame_count)
    first, last = (float(to_frames(np.array(time), clip)) for time in (start, end))
    inside = (frames >= first - WHOLE_FRAME) & (frames <= last + WHOLE_FRAME)
    if not inside.any():
        raise edit.fail(
            "there is no frame in its span",
            expected=f"a start and an end within {clip.time_codes[0]:g} to {clip.time_codes[-1]:g}",
            found=f"{start:g} to {end:g}",
        )
    ramp_s, longest = edit.settings.get("ramp", _RAMP_S), 2.0 * clip.frame_count / clip.rate
    if ramp_s > max(longest, _RAMP_S):
        expected = f"at most {longest:g} s, twice the length of the motion"
        raise edit.fail("the fade is longer than the motion can fill", expected=expected, found=f"{ramp_s:g} s")
    ramp_frames = round(ramp_s * clip.rate)
    return ramp(inside.astype(np.float64)[:, None], ramp_frames)[:, 0]


def limit_to_span(edit: Edit, before: Clip, after: Clip) -> Clip:
    """Keep what an edit did within its span, and fade to the motion before the edit.

    Parameters
    ----------
    edit
        The edit.
    before, after
        The motion before and after it, of the same frames.

    Returns
    -------
    Clip
        Bit for bit the one or the other where the weight is 0 or 1, and where an edit changed nothing.
    """
    weights = span_weights(edit, before)
    if weights is None or after is before:
        return after
    mix = np.stack([1.0 - weights, weights], axis=1)
    turned = (before.rotations != after.rotations).any(axis=-1, keepdims=True)
    joints = np.flatnonzero(turned.any(axis=(0, 2)))
    rotations = np.array(before.rotations)
    mixed = average_rotations([before.rotations[:, joints], after.rotations[:, joints]], mix)
    rotations[:, joints] = np.where(turned[:, joints], mixed, rotations[:, joints])
    spread = weights[:, None, None]
    translations = np.where(
        (before.translations != after.translations) & (spread < 1.0),
        before.translations + spread * (after.translations - before.translations),
        after.translations,
    )
    return replace(after, rotations=rotations, translations=translations)
