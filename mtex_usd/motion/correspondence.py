"""Which joints of two skeletons are the same, and motions on part of their joints."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import FloatArray, Skeleton, parents_of

__all__ = ["corresponding_joints", "keep_joints"]


def corresponding_joints(joints: Sequence[str], wanted: Sequence[str]) -> dict[int, int]:
    """Find where joints are in another skeleton: by full path, then by last name where both have it once.

    Returns
    -------
    dict
        Index in `joints` by index in `wanted`; joints without a counterpart are left out.
    """
    by_path = {joint: i for i, joint in enumerate(joints)}
    by_name = _unique_names(joints)
    unique = _unique_names(wanted)
    found = {}
    for i, joint in enumerate(wanted):
        name = joint.rpartition("/")[2]
        if joint in by_path:
            found[i] = by_path[joint]
        elif name in by_name and name in unique:
            found[i] = by_name[name]
    return found


def _unique_names(joints: Sequence[str]) -> dict[str, int]:
    names = [joint.rpartition("/")[2] for joint in joints]
    return {name: i for i, name in enumerate(names) if names.count(name) == 1}


def keep_joints(clip: Clip, joints: Sequence[int]) -> Clip:
    """Give a motion on some of its joints, which move in space as before.

    Parameters
    ----------
    clip
        Any motion.
    joints
        Indices of the joints to keep, in the skeleton's order.

    Returns
    -------
    Clip
        Joints keep their paths; each is relative to the nearest kept above it, at rest as in motion.
    """
    kept = list(joints)
    paths = tuple(clip.joints[joint] for joint in kept)
    positions, world = clip.skeleton.world_pose(clip.rotations, clip.translations)
    rotations, translations = world[:, kept], positions[:, kept]
    for i, parent in enumerate(parents_of(paths)):
        if parent >= 0:
            back = quaternion.conjugate(world[:, kept[parent]])
            rotations[:, i] = quaternion.multiply(back, world[:, kept[i]])
            translations[:, i] = quaternion.rotate(back, positions[:, kept[i]] - positions[:, kept[parent]])
    skeleton = replace(clip.skeleton, joints=paths, rest=_compose_rest(clip.skeleton, kept))
    scales = clip.scales[:, kept]
    return replace(clip, skeleton=skeleton, rotations=rotations, translations=translations, scales=scales)


def _compose_rest(skeleton: Skeleton, kept: list[int]) -> FloatArray:
    """Rest transforms relative to the nearest kept joint above."""
    rest = np.array(skeleton.rest[kept])
    for i, joint in enumerate(kept):
        above = int(skeleton.parents[joint])
        while above >= 0 and above not in kept:
            rest[i] = rest[i] @ skeleton.rest[above]
            above = int(skeleton.parents[above])
    return rest
