"""Channels: single curves of a joint, read in the skeleton's own axes (Gleicher 2000, section 1.2).

A joint's rotation is read relative to rest and in skeleton axes, D = W (R_rest^-1 R) W^-1, so that ``rx`` turns about
the skeleton's x axis on every rig, however its joints are oriented. Angles are in degrees, translations in stage units
and relative to rest.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np
import numpy.typing as npt

from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.skeleton import FloatArray, Skeleton

__all__ = [
    "KINDS",
    "Channel",
    "choose_euler_order",
    "resolve_channels",
    "to_local_rotations",
    "to_local_translations",
    "to_skeleton_rotations",
    "to_skeleton_translations",
    "unrolled_angles",
]

KINDS = ("rx", "ry", "rz", "tx", "ty", "tz")
_GROUPS = {"r": KINDS[:3], "t": KINDS[3:]}
_ALL = slice(None)
_GLOB_CHARACTERS = frozenset("*?[")

# In this order of preference: the capture world's usual order first, so that recorded angles read as in their files.
_EULER_ORDERS = ("ZYX", "YZX", "XYZ", "ZXY", "XZY", "YXZ")
# The middle angle is exact up to 90 degrees; below this bound the other two stay well conditioned.
_SAFE_MIDDLE_ANGLE = np.radians(65.0)


@dataclass(frozen=True, order=True)
class Channel:
    """One scalar curve: a joint (index into the skeleton) and a kind, one of ``rx ry rz tx ty tz``."""

    joint: int
    kind: str

    @property
    def is_rotation(self) -> bool:
        """Whether the values are angles."""
        return self.kind[0] == "r"

    @property
    def axis(self) -> int:
        """0, 1 or 2 for x, y or z."""
        return "xyz".index(self.kind[1])

    def name(self, joints: Sequence[str]) -> str:
        """Full channel token, joint path and kind."""
        return f"{joints[self.joint]}.{self.kind}"


def resolve_channels(tokens: Iterable[str], joints: Sequence[str], *, source: str) -> tuple[Channel, ...]:
    """Resolve channel tokens against a skeleton's joints.

    Parameters
    ----------
    tokens
        ``joint`` or ``joint.channel``; joint is a full path, a last name where that is unique, or a glob (on the last
        name, or on the whole path where it holds a slash); channel is one of `KINDS`, ``r`` or ``t``; left out means
        ``r``.
    joints
        Joint paths of the skeleton.
    source
        What messages call the list, such as ``mtex:match of /Shot/Sketch``.

    Returns
    -------
    tuple of Channel
        In the order of the tokens, each once.

    Raises
    ------
    InputError
        An unknown joint or channel, or a last name several joints have; the message lists what there is.
    """
    found: dict[Channel, None] = {}
    for token in tokens:
        joint_part, kinds = _split_token(token, source)
        for joint in _find_joints(joint_part, joints, token, source):
            found.update({Channel(joint, kind): None for kind in kinds})
    return tuple(found)


def _split_token(token: str, source: str) -> tuple[str, tuple[str, ...]]:
    joint, dot, kind = token.rpartition(".")
    if not dot:
        return token, _GROUPS["r"]
    if kind in _GROUPS:
        return joint, _GROUPS[kind]
    if kind in KINDS:
        return joint, (kind,)
    raise InputError(
        f"{source}: unknown channel in {token!r}", expected=f"one of {' '.join(KINDS)} r t", found=kind or "nothing"
    )


def _find_joints(name: str, joints: Sequence[str], token: str, source: str) -> list[int]:
    if name in joints:
        return [joints.index(name)]
    last_names = [joint.rpartition("/")[2] for joint in joints]
    if _GLOB_CHARACTERS & set(name):
        subjects = joints if "/" in name else last_names
        hits = [i for i, subject in enumerate(subjects) if fnmatchcase(subject, name)]
    else:
        hits = [i for i, last in enumerate(last_names) if last == name]
        if len(hits) > 1:
            paths = ", ".join(joints[i] for i in hits)
            raise InputError(f"{source}: {token!r} names several joints", found=paths, fix="Write the full joint path.")
    if not hits:
        raise InputError(
            f"{source}: no joint fits {token!r}", expected=f"one of the joints {', '.join(last_names)}", found=name
        )
    return hits


def to_skeleton_rotations(rotations: FloatArray, skeleton: Skeleton) -> FloatArray:
    """Turn local rotations [F, J, 4] into D = W (R_rest^-1 R) W^-1."""
    orientation = skeleton.rest_orientations
    left = quaternion.multiply(orientation, quaternion.conjugate(skeleton.rest_rotations))
    return _turn_between(left, rotations, quaternion.conjugate(orientation))


def to_local_rotations(
    rotations: FloatArray, skeleton: Skeleton, *, joints: Sequence[int] | slice = _ALL
) -> FloatArray:
    """Invert :func:`to_skeleton_rotations`, for all joints or for the rotations of some of them."""
    orientation = skeleton.rest_orientations[joints]
    left = quaternion.multiply(skeleton.rest_rotations[joints], quaternion.conjugate(orientation))
    return _turn_between(left, rotations, orientation)


def _turn_between(left: FloatArray, rotations: FloatArray, right: FloatArray) -> FloatArray:
    """Give left * rotation * right for all frames; [J, 4], [F, J, 4], [J, 4] to [F, J, 4]."""
    # Linear in the rotation: one matrix per joint does both products at once.
    return _transform(rotations, quaternion.multiply(quaternion.multiply(left, np.eye(4)[:, None]), right))


def _transform(rows: FloatArray, matrices: FloatArray) -> FloatArray:
    """Multiply the rows of every joint by its matrix, [F, J, N] and [N, J, N] to [F, J, N]."""
    return np.swapaxes(np.swapaxes(rows, 0, 1) @ np.swapaxes(matrices, 0, 1), 0, 1)


def _parent_orientations(skeleton: Skeleton) -> FloatArray:
    identity = np.array([[1.0, 0.0, 0.0, 0.0]])
    return np.concatenate([skeleton.rest_orientations, identity])[skeleton.parents]


def to_skeleton_translations(translations: FloatArray, skeleton: Skeleton) -> FloatArray:
    """Turn local translations [F, J, 3] into offsets from rest along the skeleton's axes."""
    turns = quaternion.rotate(_parent_orientations(skeleton), np.eye(3)[:, None])
    return _transform(translations - skeleton.rest_translations, turns)


def to_local_translations(
    offsets: FloatArray, skeleton: Skeleton, *, joints: Sequence[int] | slice = _ALL
) -> FloatArray:
    """Invert :func:`to_skeleton_translations`, for all joints or for the offsets of some of them."""
    turns = quaternion.rotate(quaternion.conjugate(_parent_orientations(skeleton)[joints]), np.eye(3)[:, None])
    return _transform(offsets, turns) + skeleton.rest_translations[joints]


def choose_euler_order(rotations: FloatArray, *, outermost: str = "") -> str:
    """Choose the Euler order that stays clear of gimbal lock over all given rotations of one joint.

    Parameters
    ----------
    rotations
        Rotations in skeleton axes over sketch and takes, shape [F, 4].
    outermost
        Only consider orders that begin with this axis, ``X``, ``Y`` or ``Z``.

    Returns
    -------
    str
        An intrinsic order such as ``ZYX``: the first of a fixed preference whose middle angle stays below 65 degrees,
        else the one whose middle angle stays smallest (Gleicher 2000, section 1.2.1.1).
    """
    w, x, y, z = np.moveaxis(rotations, -1, 0)
    # The sine of the middle angle of intrinsic order ABC is the matrix element (A, C), up to sign.
    sines = {
        frozenset("XZ"): (2.0 * (x * z + w * y), 2.0 * (x * z - w * y)),
        frozenset("XY"): (2.0 * (x * y - w * z), 2.0 * (x * y + w * z)),
        frozenset("YZ"): (2.0 * (y * z - w * x), 2.0 * (y * z + w * x)),
    }
    largest = {}
    orders = [order for order in _EULER_ORDERS if order.startswith(outermost)]
    for order in orders:
        upper, lower = sines[frozenset((order[0], order[2]))]
        sine = upper if order[0] < order[2] else lower
        largest[order] = float(np.arcsin(np.clip(np.abs(sine), 0.0, 1.0)).max(initial=0.0))
        if largest[order] < _SAFE_MIDDLE_ANGLE:
            return order
    return min(orders, key=lambda order: largest[order])


def unrolled_angles(rotations: FloatArray, order: str) -> npt.NDArray[np.float64]:
    """Euler angles [F, 3] (x, y, z in degrees) of one joint, continuous in time; rotations [F, 4]."""
    angles = np.unwrap(quaternion.to_euler(rotations, order), period=360.0, axis=0)
    if np.abs(np.diff(angles, axis=0)).max(initial=0.0) < 90.0:
        return angles
    return _unroll_through_gimbal(angles, order)


def _unroll_through_gimbal(angles: FloatArray, order: str) -> FloatArray:
    """Choose frame by frame between the two angle triples of the same rotation, whichever is nearer."""
    first, middle, last = ("XYZ".index(axis) for axis in order)
    turns = np.array(angles)
    other = np.array(angles)
    other[:, [first, last]] += 180.0
    other[:, middle] = 180.0 - other[:, middle]
    for i in range(1, len(turns)):
        pair = np.stack([turns[i], other[i]])
        pair += 360.0 * np.round((turns[i - 1] - pair) / 360.0)
        turns[i] = pair[np.argmin(np.abs(pair - turns[i - 1]).sum(axis=1))]
    return turns
