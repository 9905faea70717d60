"""Takes as a character can use them: as they are where their skeleton is the character's, else retargeted."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from mtex_usd.constraints.retargeting.joint_map import JointMap, Pair, map_joints
from mtex_usd.constraints.retargeting.retarget import retarget_mapped
from mtex_usd.constraints.retargeting.transfer import bone_leans
from mtex_usd.motion.anatomy import find_anatomy
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.correspondence import corresponding_joints, keep_joints
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["FittedTake", "fit_take"]

# Bones that rest this far apart, in radians, are one bone; further, and the poses would differ to the eye.
_SAME_REST = np.radians(2.0)


@dataclass(frozen=True, eq=False, kw_only=True)
class FittedTake:
    """A take for one character.

    Parameters
    ----------
    clip
        The take itself, or its motion on those joints of the character that its own map to.
    joint_map
        What mapped to what where it was retargeted, else None.
    """

    clip: Clip
    joint_map: JointMap | None


def fit_take(take: Clip, sketch: Clip, pairs: Sequence[Pair] = ()) -> FittedTake:
    """Give a take on a character's joints.

    Parameters
    ----------
    take
        On a skeleton of its own.
    sketch
        On the character's.
    pairs
        What the user says about joints.

    Returns
    -------
    FittedTake
        The take as it is where joints of the same names stand for the same bones at rest, or where one of the
        skeletons is no humanoid and nothing is said about it; names alone decide there.

    Raises
    ------
    InputError
        Where a pair names a joint that is not there.
    """
    if not pairs and _is_same(take.skeleton, sketch.skeleton):
        return FittedTake(clip=take, joint_map=None)
    joint_map = _map_cached(take.skeleton, sketch.skeleton, tuple(pairs))
    motion = retarget_mapped(take, joint_map, like=sketch)
    mapped = [share.joint for share in joint_map.shares]
    return FittedTake(clip=keep_joints(motion, mapped), joint_map=joint_map)


_map_cached = lru_cache(maxsize=64)(map_joints)


@lru_cache(maxsize=64)
def _is_same(take: Skeleton, character: Skeleton) -> bool:
    """Whether a take can be read by the names of its joints."""
    if take.joints == character.joints and np.array_equal(take.rest, character.rest):
        return True
    if find_anatomy(take) is None or find_anatomy(character) is None:
        return True
    joint_map = _map_cached(take, character, ())
    named = corresponding_joints(take.joints, character.joints)
    if not all(body.is_upright for body in joint_map.stance.bodies):
        return False
    for section in joint_map.sections:
        if [named.get(joint) for joint in section.target.joints] != list(section.source.joints):
            return False
    return all(lean < _SAME_REST for section in joint_map.sections for lean in bone_leans(section, joint_map.stance))
