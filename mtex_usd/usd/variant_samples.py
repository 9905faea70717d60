"""What a variant says of a changed clip: the animation's own arrays, bit for bit, where nothing changed."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Union

import numpy as np

from mtex_usd.motion.clip import Clip
from mtex_usd.usd.animation import AnimationSamples
from mtex_usd.usd.override import VariantSamples
from mtex_usd.usd.sampled_clip import add_joints, from_clip

if TYPE_CHECKING:
    from mtex_usd.edit import ReducedKeys, ReducedPoses

__all__ = ["Keys", "build_variant", "keep_unchanged"]

_ARRAYS = ("rotations", "translations", "scales")

Keys = Union["ReducedKeys", "ReducedPoses"]
"""A motion by few keys."""


def build_variant(
    samples: AnimationSamples,
    before: Clip,
    after: Clip,
    custom_data: Mapping[str, object],
    *,
    keys: Keys | None = None,
) -> VariantSamples:
    """Give what the variant of a changed clip will say.

    Parameters
    ----------
    samples
        The animation as it was.
    before
        The same as a clip.
    after
        What was made of it.
    custom_data
        The variant's ``customData["mtex"]``.
    keys
        What was made of it by few keys: of poses only those are written, curves are written beside the samples.
    """
    from mtex_usd.edit import ReducedKeys, ReducedPoses  # noqa: PLC0415  (slow to import, seldom used)

    changed = keep_unchanged(samples, before, after)
    at = keys.frames if isinstance(keys, ReducedPoses) else slice(None)
    return VariantSamples(
        joints=changed.joints,
        time_codes=changed.time_codes[at],
        rotations=changed.rotations[at],
        translations=changed.translations[at],
        scales=changed.scales[at],
        custom_data=custom_data,
        curves=keys.curves if isinstance(keys, ReducedKeys) else (),
    )


def keep_unchanged(samples: AnimationSamples, before: Clip, after: Clip) -> AnimationSamples:
    """Give the samples of a changed clip: the animation's own arrays, bit for bit, where nothing was changed.

    Parameters
    ----------
    samples
        The animation as it was.
    before
        The same as a clip.
    after
        What was made of it. Where that has other frames, nothing is the animation's own.

    Returns
    -------
    AnimationSamples
        On the animation's joints, then those that came to move.
    """
    if not _same_frames(before, after):
        return from_clip(after, samples)
    pairs = [(getattr(before, name), getattr(after, name)) for name in _ARRAYS]
    changed = [j for j in range(len(after.joints)) if any((one[:, j] != two[:, j]).any() for one, two in pairs)]
    added = tuple(after.joints[j] for j in changed if after.joints[j] not in samples.joints)
    return _put(add_joints(samples, added, after.skeleton), after, changed)


def _same_frames(before: Clip, after: Clip) -> bool:
    return np.array_equal(before.time_codes, after.time_codes)


def _put(samples: AnimationSamples, clip: Clip, joints: list[int]) -> AnimationSamples:
    columns = [samples.joints.index(clip.joints[j]) for j in joints]
    arrays = {name: np.array(getattr(samples, name)) for name in _ARRAYS}
    for name, array in arrays.items():
        array[:, columns] = getattr(clip, name)[:, joints]
    return replace(samples, **arrays)  # type: ignore[arg-type]
