"""Edits with other motions: blends, transitions and loops, and changes that are layered on top."""

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.alignment import align
from mtex_usd.edit.blending import blend
from mtex_usd.edit.displacement import Displacement, PoseChange, displace
from mtex_usd.edit.frames import take_frames
from mtex_usd.edit.joins import join
from mtex_usd.edit.stack.edit import Edit, Outcome, to_frames
from mtex_usd.edit.stack.span import span_weights
from mtex_usd.edit.transitions import Transition, find_transition
from mtex_usd.edit.warping import warp_time
from mtex_usd.motion.clip import Clip

__all__ = ["run_blend", "run_displace", "run_join"]

FloatArray = npt.NDArray[np.float64]


def run_blend(clip: Clip, edit: Edit) -> Outcome:
    """Run ``blend``; where the motions are not aligned they are blended time code by time code."""
    weights = _weights(clip, edit)
    span = span_weights(edit, clip)
    if span is not None:
        weights = weights * span[:, None]
    bring = _bring_into_step if edit.settings.get("align", False) else _at_times_of
    others = [bring(clip, other, edit, weights) for other in edit.others]
    done = blend(clip, others, weights=weights, place=edit.settings.get("place", "first"))
    return Outcome(clip=done.clip, notes=tuple(map(str, done.notes)))


def _weights(clip: Clip, edit: Edit) -> FloatArray:
    """Weights of the others at every frame, [F, K]: one each, or one each per key with straight lines between."""
    given, count = np.asarray(edit.settings["weights"], dtype=np.float64), len(edit.others)
    keys = edit.frames("keys", clip)
    rows = max(len(keys), 1)
    if given.size != rows * count:
        per_key = f" at each of {rows} keys" if len(keys) else ""
        expected = f"one for each of {count} other motions{per_key}"
        raise edit.fail("weights do not fit", expected=expected, found=f"{given.size} weights")
    if not len(keys):
        return np.repeat(given[None], clip.frame_count, axis=0)
    if (np.diff(keys) <= 0.0).any():
        raise edit.fail("keys are not in order", expected="time codes that rise", found=str(edit.settings["keys"]))
    frames = np.arange(clip.frame_count)
    return np.stack([np.interp(frames, keys, column) for column in given.reshape(rows, count).T], axis=1)


def _bring_into_step(clip: Clip, other: Clip, edit: Edit, _: FloatArray) -> Clip:
    chosen = edit.pick(max_slope="maxSlope", band_s="band", free_s="free")
    return warp_time(other, pairs=align(other, clip, **chosen).pairs, frame_count=clip.frame_count)


def _at_times_of(clip: Clip, other: Clip, edit: Edit, weights: FloatArray) -> Clip:
    """Take the frames of another motion at the times of the clip; where nothing counts it need not be there."""
    first = round(float(to_frames(np.array([clip.start]), other)[0]))
    frames = first + np.arange(clip.frame_count)
    inside = (frames >= 0) & (frames < other.frame_count)
    if weights[~inside].any():
        raise edit.fail(
            f"{other.name} is not there for all of the motion",
            expected=f"time codes {clip.time_codes[0]:g} to {clip.time_codes[-1]:g}",
            found=f"{other.time_codes[0]:g} to {other.time_codes[-1]:g}",
            fix="Set align, give start and end, or retime the other by a layer offset.",
        )
    return take_frames(other, np.clip(frames, 0, other.frame_count - 1))


def run_join(clip: Clip, edit: Edit) -> Outcome:
    """Run ``join``; with no other motion the clip is closed to a loop."""
    if len(edit.others) > 1:
        raise edit.fail("too many motions", expected="one, or none for a loop", found=f"{len(edit.others)}")
    other = edit.others[0] if edit.others else clip
    chosen = edit.pick(blend_s="joinTime", method="method")
    done = join(clip, other, transition=_transition(clip, other, edit), **chosen)
    return Outcome(clip=done.clip, notes=tuple(map(str, done.notes)))


def _transition(clip: Clip, other: Clip, edit: Edit) -> Transition | None:
    """Where to leave and to enter, as far as that is said."""
    left, entered = edit.whole_frames("from", clip), edit.whole_frames("to", other)
    if len(left) > 1 or len(entered) > 1:
        raise edit.fail("from and to do not fit", expected="at most one time code each")
    searched = edit.whole_frames("start", clip), edit.whole_frames("end", clip)
    if not (left or entered or any(searched)):
        return None
    if left and any(searched):
        raise edit.fail("start and end say where to look, and from says it already", fix="Remove the one or the other.")
    if left and entered:
        return Transition(frame=left[0], other_frame=entered[0], distance=float("nan"))
    first, last = (searched[0] or [0])[0], (searched[1] or [clip.frame_count - 1])[0]
    frames = (left[0], left[0]) if left else (first, last)
    return find_transition(clip, other, frames=frames, other_frames=(entered[0], entered[0]) if entered else None)


def run_displace(clip: Clip, edit: Edit) -> Clip:
    """Run ``displace``: towards another motion at the keys, or by what is said for each key and joint."""
    if len(edit.others) > 1:
        raise edit.fail("too many motions", expected="one that has the poses", found=f"{len(edit.others)}")
    said = [name for name in ("rotations", "translations") if name in edit.settings]
    if bool(edit.others) == bool(said):
        raise edit.fail("no change, or two", expected="either with, or rotations and translations")
    if not len(edit.settings["keys"]):
        raise edit.fail("no key", expected="time codes in keys")
    keys = _changes_to(clip, edit) if edit.others else _changes_said(clip, edit)
    scope = edit.settings.get("scope")
    frames = None if scope is None else (scope[0] * clip.rate, scope[1] * clip.rate)
    return displace(clip, Displacement(keys=keys, scope=frames))


def _changes_to(clip: Clip, edit: Edit) -> list[PoseChange]:
    (target,) = edit.others
    channels = edit.settings.get("channels", ())
    pairs = zip(edit.whole_frames("keys", clip), edit.whole_frames("keys", target), strict=True)
    return [
        PoseChange.to_clip(clip, target, frame=frame, target_frame=there, channels=channels) for frame, there in pairs
    ]


def _changes_said(clip: Clip, edit: Edit) -> list[PoseChange]:
    joints, frames = edit.settings.get("channels", ()), edit.frames("keys", clip)
    if not joints:
        raise edit.fail("no joint is named", expected="joints in channels")
    if len(set(joints)) < len(joints):
        raise edit.fail("a joint is named twice", expected="every joint of channels once", found=", ".join(joints))
    tables = {}
    for name in ("rotations", "translations"):
        values = np.asarray(edit.settings.get(name, ()), dtype=np.float64)
        if len(values) not in (0, len(frames) * len(joints)):
            expected = f"{len(joints)} for each of {len(frames)} keys, those of the first key first"
            raise edit.fail(f"{name} do not fit", expected=expected, found=f"{len(values)}")
        tables[name] = values.reshape(-1, len(joints), 3)
    return [
        PoseChange(
            frame=float(frame),
            **{name: dict(zip(joints, table[i].tolist(), strict=True)) for name, table in tables.items() if len(table)},
        )
        for i, frame in enumerate(frames)
    ]
