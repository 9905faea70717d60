"""A take on another skeleton: rotations by direction, travel by the length of the legs (Gleicher 2000, 1.7.2.4)."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.retargeting.body import estimate_ground, rest_ground, stand_on
from mtex_usd.constraints.retargeting.joint_map import JointMap, Pair, as_pairs, map_joints
from mtex_usd.constraints.retargeting.transfer import rest_lean, turn_section
from mtex_usd.motion import quaternion
from mtex_usd.motion.arguments import as_clip, refuse
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["retarget", "retarget_mapped"]

FloatArray = npt.NDArray[np.float64]

_NO_LEAN = np.array([1.0, 0.0, 0.0, 0.0])


def retarget(clip: Clip, onto: Skeleton | Clip, *, pairs: Sequence[Pair | tuple[str, str]] = ()) -> Clip:
    """Put a motion on another humanoid's skeleton.

    Parameters
    ----------
    clip
        The motion, on a skeleton with any joint names, joint orientations, rest pose, up axis and units.
    onto
        The character's skeleton, or a motion of it, which also tells where its floor is.
    pairs
        Pairs (joint of the character, joint of the motion) that are stronger than what is recognised; an empty second
        name leaves a joint at rest.

    Returns
    -------
    Clip
        At the motion's rate, on all joints of the character. Bones of trunk, neck, arms and legs have the direction in
        space that the motion's have; pelvis, head, hands and feet turn as the motion's do since rest; joints nothing
        maps to are at rest. Bones keep the character's lengths, the hips' way is scaled by the length of the legs.

    Raises
    ------
    InputError
        Where one of the skeletons is no humanoid, or a pair names a joint that is not there.

    Examples
    --------
    >>> slim = mtex_usd.constraints.retarget(walk, character)  # doctest: +SKIP
    """
    as_clip(clip)
    skeleton = as_clip(onto, "character").skeleton if isinstance(onto, Clip) else onto
    if not isinstance(skeleton, Skeleton):
        raise refuse(onto, "character", "a Skeleton, or a Clip on it")
    joint_map = map_joints(clip.skeleton, skeleton, as_pairs(pairs))
    return retarget_mapped(clip, joint_map, like=onto if isinstance(onto, Clip) else None)


def retarget_mapped(clip: Clip, joint_map: JointMap, *, like: Clip | None = None) -> Clip:
    """Put a motion on a character whose joints are mapped.

    Parameters
    ----------
    clip
        The motion.
    joint_map
        From :func:`~mtex_usd.constraints.retargeting.joint_map.map_joints`.
    like
        A motion of the character, which tells where its floor is; without one the floor is where its rest pose stands,
        or zero where its hips rest at the origin as in captures.
    """
    stance = joint_map.stance
    positions, world = clip.skeleton.world_pose(clip.rotations, clip.translations)
    turns = quaternion.multiply(world, quaternion.conjugate(stance.source.rest_orientations))
    placed = _turn_joints(joint_map, turns, positions)
    rotations, world = _to_local(stance.target, placed, clip.frame_count)
    translations = np.tile(stance.target.rest_translations, (clip.frame_count, 1, 1))
    hips = joint_map.anatomies[1].parts["hips"]
    if hips in placed:
        places = _place_hips(clip, joint_map, positions, like)
        translations[:, hips] = _place_below(stance.target, hips, places, (rotations, translations), world)
    return replace(
        clip,
        skeleton=stance.target,
        rotations=quaternion.unroll(rotations),
        translations=translations,
        scales=np.ones_like(translations),
    )


def _turn_joints(joint_map: JointMap, turns: FloatArray, positions: FloatArray) -> dict[int, FloatArray]:
    """Rotations of the mapped joints in the character's space, [F, 4] each."""
    stance = joint_map.stance
    above = {section.target.end: section for section in joint_map.sections}
    placed = {}
    for section in joint_map.sections:
        before = above.get(section.target.joints[0]) if section.mode == "follow" else None
        lean = _NO_LEAN if before is None else rest_lean(before, stance)
        rotations = turn_section(section, stance, turns, positions, lean=lean)
        placed.update(dict(zip(section.target.joints, np.moveaxis(rotations, 1, 0), strict=True)))
    return placed


def _place_hips(clip: Clip, joint_map: JointMap, positions: FloatArray, like: Clip | None) -> FloatArray:
    """Places of the character's hips, shape [F, 3]: the motion's, from floor to floor, scaled."""
    stance, (found, wanted) = joint_map.stance, joint_map.anatomies
    source, target = stance.bodies
    ground = estimate_ground(clip, found, source)
    own_ground = rest_ground(stance.target, wanted, target) if like is None else estimate_ground(like, wanted, target)
    way = positions[:, found.parts["hips"]] - stand_on(stance.source, found, source, ground)
    return stand_on(stance.target, wanted, target, own_ground) + joint_map.scale * quaternion.rotate(stance.turn, way)


def _to_local(skeleton: Skeleton, placed: Mapping[int, FloatArray], frames: int) -> tuple[FloatArray, FloatArray]:
    """Rotations [F, J, 4] relative to the parent and in space; what is not placed is at rest."""
    rotations = np.tile(skeleton.rest_rotations, (frames, 1, 1))
    world = np.empty_like(rotations)
    for joint, parent in enumerate(skeleton.parents):
        above = world[:, parent] if parent >= 0 else _NO_LEAN
        world[:, joint] = placed.get(joint, quaternion.multiply(above, rotations[:, joint]))
        if joint in placed:
            rotations[:, joint] = quaternion.multiply(quaternion.conjugate(above), world[:, joint])
    return rotations, world


def _place_below(
    skeleton: Skeleton, joint: int, places: FloatArray, pose: tuple[FloatArray, FloatArray], world: FloatArray
) -> FloatArray:
    """Translations [F, 3] relative to its parent that put a joint in its places; a pose is rotations, translations."""
    parent = int(skeleton.parents[joint])
    if parent < 0:
        return places
    begin = skeleton.joint_positions([parent], *pose)[:, 0]
    return quaternion.rotate(quaternion.conjugate(world[:, parent]), places - begin)
