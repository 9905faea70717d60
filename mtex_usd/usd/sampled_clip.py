"""Samples on a skeleton: what is missing filled from rest, joints added, and all as a clip in double precision."""

from dataclasses import replace
from typing import NoReturn, cast

import numpy as np
import numpy.typing as npt

from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import FloatArray, Skeleton
from mtex_usd.usd.animation import AnimationSamples

__all__ = ["add_joints", "fill_missing", "from_clip", "to_clip"]

SingleArray = npt.NDArray[np.float32]

_ARRAYS = ("rotations", "translations", "scales")
_SHORTEST_QUATERNION = 1e-6


def fill_missing(samples: AnimationSamples, skeleton: Skeleton) -> AnimationSamples:
    """Fill attributes the animation does not author from the skeleton's rest; ``missing`` goes on naming them.

    Parameters
    ----------
    samples
        As sampled.
    skeleton
        Gives the rest; joints it does not have get no rotation, no translation and unit scale.

    Returns
    -------
    AnimationSamples
        Without NaN in the missing attributes.
    """
    if not samples.missing:
        return samples
    index = {joint: i for i, joint in enumerate(skeleton.joints)}
    which = np.array([index.get(joint, -1) for joint in samples.joints], dtype=np.intp)
    neutral = {"rotations": [1.0, 0.0, 0.0, 0.0], "translations": [0.0, 0.0, 0.0], "scales": [1.0, 1.0, 1.0]}
    filled = {}
    for name in samples.missing:
        # The last row is for joints that the skeleton does not have.
        rest = np.concatenate([_rest(skeleton, name), [neutral[name]]]).astype(np.float32)
        filled[name] = np.repeat(rest[None, which], len(samples.time_codes), axis=0)
    return replace(samples, **filled)  # type: ignore[arg-type]


def _rest(skeleton: Skeleton, name: str) -> FloatArray:
    if name == "rotations":
        return skeleton.rest_rotations
    if name == "translations":
        return skeleton.rest_translations
    upper = skeleton.rest[:, :3, :3]
    mirrored = np.where(np.linalg.det(upper) < 0.0, -1.0, 1.0)[:, None]  # all three axes, as UsdSkel decomposes
    return cast(FloatArray, mirrored * np.linalg.norm(upper, axis=-1))


def to_clip(samples: AnimationSamples, skeleton: Skeleton) -> Clip:
    """Put samples onto all joints of a skeleton.

    Parameters
    ----------
    samples
        Its joints may be a subset of the skeleton's in any order; others are left out.
    skeleton
        Gives the joints, their order, and the rest for joints and attributes that the animation lacks.

    Returns
    -------
    Clip
        Double precision, quaternions of unit length and sign-continuous along time, named as the prim.

    Raises
    ------
    InputError
        Where a number is not finite or a rotation has no length (named with joint and time), or no joint is the
        skeleton's.
    """
    index = {joint: i for i, joint in enumerate(skeleton.joints)}
    source = [i for i, joint in enumerate(samples.joints) if joint in index]
    if not source:
        raise InputError(
            f"{samples.name} and its skeleton have no joint in common",
            expected=f"joints such as {skeleton.joints[0] if skeleton.joints else '(the skeleton has none)'}",
            found=f"{samples.joints[0]} and {len(samples.joints) - 1} more",
        )
    target = [index[samples.joints[i]] for i in source]
    filled = fill_missing(samples, skeleton)
    arrays = {name: _on_skeleton(filled, skeleton, name, source, target) for name in _ARRAYS}
    return Clip(
        skeleton=skeleton,
        rate=samples.rate,
        rotations=_unit(samples, skeleton, arrays["rotations"]),
        translations=arrays["translations"],
        scales=arrays["scales"],
        start=float(samples.time_codes[0]),
        time_codes_per_frame=samples.time_codes_per_frame,
        name=samples.name,
    )


def _on_skeleton(
    samples: AnimationSamples, skeleton: Skeleton, name: str, source: list[int], target: list[int]
) -> FloatArray:
    values: SingleArray = getattr(samples, name)
    if source == target == list(range(len(skeleton.joints))) and values.shape[1] == len(target):
        out = values.astype(np.float64)  # the usual case, several times faster than by index
    else:
        out = np.repeat(_rest(skeleton, name)[None], len(values), axis=0)
        out[:, target] = values[:, source]
    finite = np.isfinite(out)
    if not finite.all():
        _refuse(samples, skeleton, np.logical_not(finite.all(axis=-1)), f"{name} are not finite")
    return out


def _unit(samples: AnimationSamples, skeleton: Skeleton, rotations: FloatArray) -> FloatArray:
    lengths = np.sqrt(np.einsum("fjk,fjk->fj", rotations, rotations))
    if lengths.min() < _SHORTEST_QUATERNION:
        _refuse(samples, skeleton, lengths < _SHORTEST_QUATERNION, "a rotation has no length")
    return quaternion.unroll(rotations / lengths[..., None])


def _refuse(
    samples: AnimationSamples, skeleton: Skeleton, bad: npt.NDArray[np.bool_] | np.bool_, what: str
) -> NoReturn:
    frame, joint = np.argwhere(bad)[0]
    raise InputError(
        f"{samples.name}: {what}",
        found=f"joint {skeleton.joints[joint]} at time code {samples.time_codes[frame]:g}",
        fix="Correct the animation there.",
    )


def add_joints(samples: AnimationSamples, added: tuple[str, ...], skeleton: Skeleton) -> AnimationSamples:
    """Append joints at rest.

    Parameters
    ----------
    samples
        As sampled, filled.
    added
        Paths of joints they do not have.
    skeleton
        Gives the rest.
    """
    if not added:
        return samples
    alone = replace(samples, joints=added, missing=_ARRAYS)
    rest = fill_missing(alone, skeleton)
    arrays = {name: np.concatenate([getattr(samples, name), getattr(rest, name)], axis=1) for name in _ARRAYS}
    return replace(samples, joints=samples.joints + added, **arrays)  # type: ignore[arg-type]


def from_clip(clip: Clip, like: AnimationSamples) -> AnimationSamples:
    """Give a clip as samples, at the clip's own frames.

    Parameters
    ----------
    clip
        The clip.
    like
        An animation on the same skeleton: its joints come first and in its order, then those that the clip moves or
        holds away from rest. Joints that the skeleton does not have keep their first sample; nothing plays them.
    """
    skeleton = clip.skeleton
    away = [_is_away(clip, j) for j in range(len(clip.joints))]
    added = tuple(joint for joint, moves in zip(clip.joints, away, strict=True) if moves and joint not in like.joints)
    first = {name: getattr(like, name)[:1] for name in _ARRAYS}
    base = add_joints(replace(like, time_codes=like.time_codes[:1], **first), added, skeleton)
    index = {joint: j for j, joint in enumerate(clip.joints)}
    known = [column for column, joint in enumerate(base.joints) if joint in index]
    source = [index[base.joints[column]] for column in known]
    arrays = {}
    for name in _ARRAYS:
        out = np.repeat(getattr(base, name), clip.frame_count, axis=0)
        out[:, known] = getattr(clip, name)[:, source]
        arrays[name] = out
    return replace(
        base,
        rate=clip.rate,
        time_codes_per_frame=clip.time_codes_per_frame,
        time_codes=clip.time_codes,
        sample_times=clip.time_codes,
        **arrays,  # type: ignore[arg-type]
    )


def _is_away(clip: Clip, joint: int) -> bool:
    rest = clip.skeleton
    values = ((clip.rotations, rest.rest_rotations), (clip.translations, rest.rest_translations))
    return any((array[:, joint] != at_rest[joint]).any() for array, at_rest in values)
