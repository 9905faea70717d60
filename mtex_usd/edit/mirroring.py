"""Mirroring: left and right exchanged.

Turns are mirrored in skeleton axes relative to rest, so neither the orientation of the joints nor a rest pose that is
not quite symmetric matters. What it does to contacts: a foot's contact becomes the other foot's at the same frames; on
a symmetric skeleton it stands as still as before, on others it moves by the difference of the legs.
"""

from dataclasses import replace
from functools import lru_cache
from typing import Literal

import numpy as np
import numpy.typing as npt

from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.anatomy import find_anatomy
from mtex_usd.motion.anatomy.words import split_words
from mtex_usd.motion.arguments import as_clip, as_word
from mtex_usd.motion.channels import (
    to_local_rotations,
    to_local_translations,
    to_skeleton_rotations,
    to_skeleton_translations,
)
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import IntArray, Skeleton
from mtex_usd.texture.facing import find_hips, find_root, measure_heading

__all__ = ["mirror", "pair_joints"]

FloatArray = npt.NDArray[np.float64]

_OTHER_SIDE = {"left": "right", "l": "r", "lft": "rgt"}
_SWAPPED = _OTHER_SIDE | {right: left for left, right in _OTHER_SIDE.items()}
_NEAR = 0.03  # of the skeleton's extent: how far from the mirrored place a partner may rest
_NEARLY_AXIS = np.cos(np.radians(10.0))


def mirror(clip: Clip, *, plane: Literal["rest", "facing"] = "rest") -> Clip:
    """Exchange left and right.

    Parameters
    ----------
    clip
        A clip of a skeleton with two legs, or at least two hips.
    plane
        ``"rest"``: about the plane between the hips at rest, so a character that walks to +X of its skeleton then walks
        to -X. ``"facing"``: about the upright plane through the character along the way it faces at the first frame, so
        it begins in the same place and direction, and turns the other way.

    Returns
    -------
    Clip
        Every joint has the mirrored motion of its partner; joints in the middle that of themselves. Mirrored twice the
        motion is the original to rounding.

    Raises
    ------
    InputError
        Where the skeleton has no left and right, or for another plane.

    Notes
    -----
    Contacts: the other foot's at the same frames, as still as before.

    With ``"facing"`` the way the hips face at the first frame counts, and while walking they swing: by 4.3 degrees
    on the sample walk, so its mirrored way goes off by 8.6. Begin where they face along the way, or use ``"rest"``.
    """
    as_clip(clip)
    as_word(plane, ("rest", "facing"), "bad plane to mirror about")
    across, _ = _find_plane(clip.skeleton)
    partners = pair_joints(clip.skeleton)
    turns = to_skeleton_rotations(clip.rotations, clip.skeleton)[:, partners]
    offsets = to_skeleton_translations(clip.translations, clip.skeleton)[:, partners]
    # The axis of a turn is mirrored as an arrow and then turned round, because left-handed becomes right-handed.
    turns[..., 1:] = -_reflect(turns[..., 1:], across)
    rotations = to_local_rotations(turns, clip.skeleton)
    translations = to_local_translations(_reflect(offsets, across), clip.skeleton)
    mirrored = replace(clip, rotations=rotations, translations=translations, scales=clip.scales[:, partners])
    return mirrored if plane == "rest" else _face_as(mirrored, clip)


def _reflect(vectors: FloatArray, across: FloatArray) -> FloatArray:
    return np.asarray(vectors - 2.0 * (vectors @ across)[..., None] * across)


def _find_plane(skeleton: Skeleton) -> tuple[FloatArray, FloatArray]:
    """Level unit vector from hip to hip at rest, an axis of the skeleton where it is nearly that, and their middle."""
    hips = find_hips(skeleton)
    if hips is None:
        raise InputError("the skeleton has no left and right", expected="two legs", fix="Name the joints' sides.")
    places = skeleton.rest_positions[list(hips)]
    way = places[1] - places[0]
    level = way - (way @ skeleton.up) * skeleton.up
    level /= np.linalg.norm(level)
    nearest: FloatArray = np.eye(3)[np.argmax(np.abs(level))]
    # A scanned body is never quite straight; its plane of symmetry is meant.
    return nearest if abs(level @ nearest) >= _NEARLY_AXIS else level, places.mean(axis=0)


def _face_as(mirrored: Clip, clip: Clip) -> Clip:
    """Turn a mirrored clip about up, and move it level, so that its root begins as the original's."""
    root = find_root(clip)
    root = 0 if root is None else root
    heading = measure_heading(clip, root)[0] - measure_heading(mirrored, root)[0]
    turn = quaternion.exp(heading * clip.skeleton.up)
    tops = np.flatnonzero(clip.parents < 0)
    rotations, translations = np.array(mirrored.rotations), np.array(mirrored.translations)
    rotations[:, tops] = quaternion.multiply(turn, rotations[:, tops])
    translations[:, tops] = quaternion.rotate(turn, translations[:, tops])
    turned = replace(mirrored, rotations=rotations, translations=translations)
    places = [_place(of, root) for of in (turned, clip)]
    translations[:, tops] += places[1] - places[0]
    return replace(turned, translations=translations)


def _place(clip: Clip, root: int) -> FloatArray:
    return np.asarray(clip.skeleton.joint_positions([root], clip.rotations[0], clip.translations[0])[0])


@lru_cache(maxsize=64)
def pair_joints(skeleton: Skeleton) -> IntArray:
    """Find every joint's partner on the other side.

    Parameters
    ----------
    skeleton
        A skeleton with two legs.

    Returns
    -------
    IntArray
        Index of the partner, the joint's own where it has none, shape [J]. Partners by the parts of the body; of other
        joints, children of partners whose names differ by left and right alone, or that rest at mirrored places.

    Raises
    ------
    InputError
        Where the skeleton has no left and right.
    """
    partners = _pair_parts(skeleton)
    words = [split_words(joint.rpartition("/")[2]) for joint in skeleton.joints]
    places = skeleton.rest_positions
    mirrored = _mirror_places(skeleton)
    near = _NEAR * float(np.ptp(places, axis=0).max())
    for joint, parent in enumerate(skeleton.parents.tolist()):
        if partners[joint] < 0:
            above = partners[parent] if parent >= 0 else -1
            others = [k for k in np.flatnonzero(skeleton.parents == above).tolist() if partners[k] < 0]
            partner = _find_by_words(joint, others, words)
            if partner is None and words[joint] == _swap_words(words[joint]):
                partner = _find_by_place(joint, others, places, mirrored, near)
            partner = joint if partner is None else partner
            partners[[joint, partner]] = partner, joint
    partners.flags.writeable = False
    return partners


def _pair_parts(skeleton: Skeleton) -> IntArray:
    """Partners of the parts of the body, -1 for all other joints."""
    partners = np.full(len(skeleton.joints), -1, dtype=np.intp)
    anatomy = find_anatomy(skeleton)
    parts = {} if anatomy is None else anatomy.parts
    for part, joint in parts.items():
        side, dot, name = part.partition(".")
        other = f"{_SWAPPED[side]}.{name}" if dot else part
        if other in parts:
            partners[joint] = parts[other]
    return partners


def _mirror_places(skeleton: Skeleton) -> FloatArray:
    """Where each joint would rest on the other side, shape [J, 3]."""
    across, middle = _find_plane(skeleton)
    return _reflect(skeleton.rest_positions - middle, across) + middle


def _swap_words(words: list[str]) -> list[str]:
    return [_SWAPPED.get(word, word) for word in words]


def _find_by_words(joint: int, others: list[int], words: list[list[str]]) -> int | None:
    """Give the joint of the same name on the other side, None where the name tells no side or there is none."""
    swapped = _swap_words(words[joint])
    return next((other for other in others if other != joint and words[other] == swapped != words[joint]), None)


def _find_by_place(joint: int, others: list[int], places: FloatArray, mirrored: FloatArray, near: float) -> int | None:
    """Give the joint that rests nearest the mirrored place, itself included, if it is near."""
    distances = np.linalg.norm(places[others] - mirrored[joint], axis=-1)
    nearest = int(np.argmin(distances)) if others else -1
    return others[nearest] if others and distances[nearest] <= near else None
