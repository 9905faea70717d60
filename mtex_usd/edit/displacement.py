"""Motion warping (Witkin & Popovic 1995; Gleicher 2000, section 1.6.5): a smooth change added to a motion.

The change is given at a few frames and splined between them, so it moves the motion about and leaves its details alone.
It is a rotation vector d(t) per joint, in skeleton axes as channels are, and turns the joint after its own rotation,
D(t) exp(d(t)); translations are added.

What it does to contacts: a change of the root or of a leg moves planted feet along with it, smoothly but away from
where they stand. Give them back by inverse kinematics, or change only what carries no contact.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from mtex_usd.edit.curve_space import put_rotations, select_channels
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.arguments import as_clip, as_frame, as_number, as_numbers, as_tokens, refuse
from mtex_usd.motion.channels import (
    Channel,
    resolve_channels,
    to_local_translations,
    to_skeleton_rotations,
    to_skeleton_translations,
)
from mtex_usd.motion.clip import Clip

__all__ = ["Displacement", "PoseChange", "displace"]

FloatArray = npt.NDArray[np.float64]
Vector = Sequence[float] | FloatArray
_Part = TypeVar("_Part")

_LEAST_APART = 1e-6  # frames between two keys
_FARTHEST = 1e9  # frames, degrees, stage units
_FRAMES = f"a finite number of frames, none beyond {_FARTHEST:g}"


@dataclass(frozen=True, eq=False, kw_only=True)
class PoseChange:
    """A change of the pose at one frame.

    Parameters
    ----------
    frame
        When, in frames of the clip from its first; parts of a frame count.
    rotations
        Rotation vector by joint (token as in recipes): degrees about the skeleton's axes, after the joint's own
        rotation. Zero holds the joint where it is there.
    translations
        By joint, stage units along the skeleton's axes.
    """

    frame: float
    rotations: Mapping[str, Vector] = field(default_factory=dict)
    translations: Mapping[str, Vector] = field(default_factory=dict)

    @classmethod
    def to_pose(
        cls,
        clip: Clip,
        *,
        frame: int,
        rotations: FloatArray,
        translations: FloatArray | None = None,
        channels: Sequence[str] = (),
    ) -> "PoseChange":
        """Measure the change that makes a frame of a clip a given pose.

        Parameters
        ----------
        clip
            The clip that is to be changed.
        frame
            Which of its frames.
        rotations, translations
            The pose, relative to the parents, shapes [J, 4] and [J, 3]; no translations leave those alone.
        channels
            Channel tokens: only these change; empty for all.

        Raises
        ------
        InputError
            A frame that is not there, a pose that does not fit, an unknown channel.
        """
        _check_pose(clip, frame, rotations, translations)
        skeleton = clip.skeleton
        both = to_skeleton_rotations(np.stack([clip.rotations[frame], rotations]), skeleton)
        turns = np.degrees(quaternion.log(quaternion.multiply(quaternion.conjugate(both[0]), both[1])))
        moved = clip.translations[frame] if translations is None else translations
        places = to_skeleton_translations(np.stack([clip.translations[frame], moved]), skeleton)
        masks = _mask_channels(clip, channels)
        return cls(
            frame=frame,
            rotations=_changed(clip, turns, masks[0]),
            translations={} if translations is None else _changed(clip, places[1] - places[0], masks[1]),
        )

    @classmethod
    def to_clip(
        cls, clip: Clip, target: Clip, *, frame: int, target_frame: int | None = None, channels: Sequence[str] = ()
    ) -> "PoseChange":
        """Measure the change that makes a frame of a clip the pose of another animation.

        Parameters
        ----------
        clip
            The clip that is to be changed.
        target
            The other animation, on the same joints.
        frame, target_frame
            Which frame of the one, and of the other where it is not the same.
        channels
            Channel tokens: only these change; empty for all.

        Raises
        ------
        InputError
            Frames that are not there, other joints, an unknown channel.
        """
        as_clip(target, "target")
        at = as_frame(
            frame if target_frame is None else target_frame, f"frame of {target.name or 'the target'}", target
        )
        return cls.to_pose(
            clip,
            frame=frame,
            rotations=target.rotations[at],
            translations=target.translations[at],
            channels=channels,
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class Displacement:
    """A layer of change.

    Parameters
    ----------
    keys
        Changes at frames, in any order. Every joint goes through the keys that name it.
    scope
        How many frames before a joint's first and after its last key its change begins and is over; one number, or one
        for each side. None for a change that holds from its first frame to its last.
    """

    keys: Sequence[PoseChange]
    scope: float | tuple[float, float] | None = None


def displace(clip: Clip, layers: Displacement | Sequence[Displacement]) -> Clip:
    """Warp a motion by adding smooth changes.

    Parameters
    ----------
    clip
        The clip.
    layers
        One layer, or several that add up: their changes of a channel are summed, so their order does not matter. Two
        calls commute where they change different joints.

    Returns
    -------
    Clip
        Frames and joints without a change keep their bits.

    Raises
    ------
    InputError
        Two changes of a joint at one frame, a scope that is not above 0, numbers that are not finite, an unknown joint.

    Notes
    -----
    Contacts: feet move with what is changed above them: on the sample walk by 8 cm where the hips are moved 20 cm
    within a second and back, by 16 cm where they are turned by 30 degrees, by 5 cm where a thigh is turned by 15;
    arms and spine leave them alone.

    Examples
    --------
    >>> raise_arm = PoseChange(frame=40, rotations={"LeftArm": (0, 0, 30)})  # doctest: +SKIP
    >>> waving = displace(clip, Displacement(keys=[raise_arm], scope=15))  # doctest: +SKIP
    """
    as_clip(clip)
    each = [layers] if isinstance(layers, Displacement) else _list_of(layers, Displacement, "layers")
    turns, moves = (np.zeros((clip.frame_count, len(clip.joints), 3)) for _ in range(2))
    for layer in each:
        before, after = _check_scope(layer.scope)
        for total, kind in ((turns, "rotations"), (moves, "translations")):
            keys = _list_of(layer.keys, PoseChange, "keys of a displacement")
            for joint, (frames, values) in _collect(clip, keys, kind).items():
                total[:, joint] += _spline(frames, values, before, after, clip.frame_count)
    return _turn(_move(clip, moves), np.radians(turns))


def _turn(clip: Clip, turns: FloatArray) -> Clip:
    """Turn joints by rotation vectors in skeleton axes, radians, [F, J, 3]."""
    joints = np.flatnonzero(turns.any(axis=(0, 2))).tolist()
    if not joints:
        return clip
    # D exp(d) in skeleton axes is R exp(W^-1 d) in the joint's own.
    back = quaternion.conjugate(clip.skeleton.rest_orientations[joints])
    local = quaternion.exp(quaternion.rotate(back, turns[:, joints]))
    turned = quaternion.normalize(quaternion.multiply(clip.rotations[:, joints], local))
    changed = turns[:, joints].any(axis=-1, keepdims=True)
    return put_rotations(clip, joints, np.where(changed, turned, clip.rotations[:, joints]))


def _move(clip: Clip, moves: FloatArray) -> Clip:
    if not moves.any():
        return clip
    steps = to_local_translations(moves, clip.skeleton) - clip.skeleton.rest_translations
    changed = moves.any(axis=-1, keepdims=True)
    return replace(clip, translations=np.where(changed, clip.translations + steps, clip.translations))


def _list_of(values: object, kind: type[_Part], name: str) -> list[_Part]:
    """Take several of one kind of object."""
    if not isinstance(values, Iterable):
        raise refuse(values, name, f"a {kind.__name__}, or a list of them")
    listed = list(values)
    for value in listed:
        if not isinstance(value, kind):
            raise refuse(value, name, f"a {kind.__name__}, or a list of them")
    return listed


def _collect(clip: Clip, keys: Sequence[PoseChange], kind: str) -> dict[int, tuple[FloatArray, FloatArray]]:
    """Frames [K] and values [K, 3] of the keys of every joint, in time."""
    found: dict[int, list[tuple[float, FloatArray]]] = {}
    for key in keys:
        frame = as_number(key.frame, "frame of a change", expected=_FRAMES, least=-_FARTHEST, most=_FARTHEST)
        for token, vector in _list_vectors(key, kind):
            channels = resolve_channels([f"{token}.r"], clip.joints, source="keys of a displacement")
            value = _check_vector(token, frame, vector)
            for joint in dict.fromkeys(channel.joint for channel in channels):
                found.setdefault(joint, []).append((frame, value))
    return {joint: _order(clip, joint, pairs, kind) for joint, pairs in found.items()}


def _list_vectors(key: PoseChange, kind: str) -> list[tuple[str, object]]:
    given: object = getattr(key, kind)
    expected = "vectors by joint, such as {'LeftArm': (0, 0, 30)}"
    if not isinstance(given, Mapping):
        raise refuse(given, f"{kind} of a change", expected)
    return list(zip(as_tokens(list(given), f"{kind} of a change", expected=expected), given.values(), strict=True))


def _order(clip: Clip, joint: int, pairs: list[tuple[float, FloatArray]], kind: str) -> tuple[FloatArray, FloatArray]:
    pairs = sorted(pairs, key=lambda pair: pair[0])
    frames, values = np.array([pair[0] for pair in pairs]), np.array([pair[1] for pair in pairs])
    twice = np.flatnonzero(np.diff(frames) < _LEAST_APART)
    if twice.size:
        raise InputError(
            f"two changes of {clip.joints[joint]} at one frame",
            expected="at most one in a layer",
            found=f"frame {frames[twice[0]]:g} twice",
            fix="Put one into a layer of its own.",
        )
    if kind == "rotations":
        # Of two rotation vectors for one turn, the one that is nearer to the key before.
        values = np.degrees(quaternion.unroll_vectors(np.radians(values)[:, None]))[:, 0]
    return frames, values


def _spline(frames: FloatArray, values: FloatArray, before: float, after: float, frame_count: int) -> FloatArray:
    """Cubic spline through the keys, flat at its ends, at every frame of the clip, [F, 3]."""
    times = np.arange(frame_count, dtype=np.float64)
    none = np.zeros((1, 3))
    if np.isfinite(before):
        frames, values = np.concatenate([frames[:1] - before, frames]), np.concatenate([none, values])
    if np.isfinite(after):
        frames, values = np.concatenate([frames, frames[-1:] + after]), np.concatenate([values, none])
    if len(frames) == 1:
        return np.repeat(values, frame_count, axis=0)
    inside = np.clip(times, frames[0], frames[-1])
    change = np.asarray(CubicSpline(frames, values, bc_type="clamped")(inside))
    # The spline gives rounding for zero at its own ends, and nothing is to change there.
    change[(times <= frames[0])] = values[0]
    change[(times >= frames[-1])] = values[-1]
    return change


def _check_scope(scope: object) -> tuple[float, float]:
    """Give the frames before and after, infinite where the change holds."""
    if scope is None:
        return np.inf, np.inf
    expected = f"one or two finite numbers of frames above 0, none beyond {_FARTHEST:g}"
    given = as_numbers(scope, "scope of a displacement", expected=expected)
    if given.shape not in {(), (1,), (2,)} or not (given >= _LEAST_APART).all() or not (given <= _FARTHEST).all():
        raise refuse(scope, "scope of a displacement", expected)
    before, after = np.broadcast_to(given, 2).tolist()
    return before, after


def _check_vector(token: str, frame: float, vector: object) -> FloatArray:
    name, expected = f"change of {token} at frame {frame:g}", f"three finite numbers, none beyond {_FARTHEST:g}"
    value = as_numbers(vector, name, expected=expected)
    if value.shape != (3,) or not (np.abs(value) <= _FARTHEST).all():
        raise refuse(vector, name, expected)
    return value


def _check_pose(clip: Clip, frame: object, rotations: object, translations: object) -> None:
    as_clip(clip)
    as_frame(frame, f"frame of {clip.name or 'the clip'}", clip)
    for given, size in ((rotations, 4), (translations, 3)):
        if given is None and size == 3:
            continue
        shape = (len(clip.joints), size)
        values = as_numbers(given, "pose", expected=f"numbers, shape {shape}")
        if values.shape != shape or not np.isfinite(values).all():
            found = f"{values.shape}{'' if np.isfinite(values).all() else ' with a number that is not'}"
            raise InputError(
                "the pose does not fit the clip's joints", expected=f"finite numbers, shape {shape}", found=found
            )


def _mask_channels(clip: Clip, channels: Sequence[str]) -> tuple[FloatArray, FloatArray]:
    """Ones for the axes that may change, of rotations and of translations, both [J, 3]."""
    count = len(clip.joints)
    channels = as_tokens(channels)
    if not channels:
        return np.ones((count, 3)), np.ones((count, 3))
    masks = np.zeros((count, 3)), np.zeros((count, 3))
    chosen: Sequence[Channel] = select_channels(clip, channels)
    for channel in chosen:
        masks[0 if channel.is_rotation else 1][channel.joint, channel.axis] = 1.0
    return masks


def _changed(clip: Clip, vectors: FloatArray, mask: FloatArray) -> dict[str, FloatArray]:
    """By joint path the vectors of the joints that may change; those that do not are held."""
    return {clip.joints[joint]: vectors[joint] * mask[joint] for joint in np.flatnonzero(mask.any(axis=1))}
