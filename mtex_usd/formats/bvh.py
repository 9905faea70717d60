"""Biovision hierarchy files (.bvh): joints, offsets and motion as arrays.

The format is described by Meredith & Maddock 2001, *Motion Capture File Formats Explained*, section 3; where exporters
differ, see :mod:`mtex_usd.formats.bvh_text`.
"""

from functools import reduce
from pathlib import Path

import numpy as np
import numpy.typing as npt

from mtex_usd.formats.bvh_motion import parse_motion
from mtex_usd.formats.bvh_text import BvhJoint, parse_hierarchy, read_text
from mtex_usd.formats.recording import Recording
from mtex_usd.formats.turns import turn_about
from mtex_usd.motion import quaternion

__all__ = ["read_bvh"]

FloatArray = npt.NDArray[np.float64]


def read_bvh(file_path: Path) -> Recording:
    """Read a BVH file.

    Parameters
    ----------
    file_path
        The file.

    Returns
    -------
    Recording
        Every frame of the file; End Sites are no joints and are left out.

    Raises
    ------
    FormatError
        Where the file cannot be read, with line and reason.
    """
    text = read_text(file_path)
    joints = parse_hierarchy(text)
    motion = parse_motion(text, channel_count=sum(len(joint.channels) for joint in joints))
    columns = _split_columns(joints)
    return Recording(
        source=file_path,
        names=tuple(joint.name for joint in joints),
        parents=tuple(joint.parent for joint in joints),
        offsets=np.array([joint.offset for joint in joints], dtype=np.float64),
        rate=motion.rate,
        rotations=quaternion.unroll(_compose_rotations(joints, columns, motion.values)),
        translations=_place_joints(joints, columns, motion.values),
    )


def _split_columns(joints: tuple[BvhJoint, ...]) -> tuple[int, ...]:
    """Give the first column of each joint's values."""
    ends = np.cumsum([len(joint.channels) for joint in joints])
    return tuple(int(end) - len(joint.channels) for end, joint in zip(ends, joints, strict=True))


def _compose_rotations(joints: tuple[BvhJoint, ...], columns: tuple[int, ...], values: FloatArray) -> FloatArray:
    """Compose each joint's rotations in the order listed, the first one outermost; shape [F, J, 4]."""
    rotations = np.zeros((len(values), len(joints), 4))
    rotations[..., 0] = 1.0
    for order, members in _group_by_rotations(joints).items():
        turns = []
        for position, axis in enumerate(order):
            picked = [columns[j] + _rotation_columns(joints[j])[position] for j in members]
            turns.append(turn_about("xyz".index(axis), values[:, picked]))
        if turns:
            rotations[:, members] = reduce(quaternion.multiply, turns)
    return rotations


def _group_by_rotations(joints: tuple[BvhJoint, ...]) -> dict[str, list[int]]:
    """Put joints with the same rotation channels together, so that each group is one array operation."""
    groups: dict[str, list[int]] = {}
    for j, joint in enumerate(joints):
        order = "".join(joint.channels[column][1] for column in _rotation_columns(joint))
        groups.setdefault(order, []).append(j)
    return groups


def _rotation_columns(joint: BvhJoint) -> list[int]:
    return [column for column, channel in enumerate(joint.channels) if channel.startswith("r")]


def _place_joints(joints: tuple[BvhJoint, ...], columns: tuple[int, ...], values: FloatArray) -> FloatArray:
    """Translations relative to the parent, shape [F, J, 3].

    Position channels stand in place of the OFFSET, at the root and elsewhere, as Blender's importer takes them too:
    exporters that write positions for every joint repeat the offsets there, and adding them would double every bone.
    An axis without a channel keeps the OFFSET.
    """
    offsets = np.array([joint.offset for joint in joints], dtype=np.float64)
    translations = np.repeat(offsets[None], len(values), axis=0)
    for j, joint in enumerate(joints):
        for column, channel in enumerate(joint.channels, start=columns[j]):
            if channel.startswith("p"):
                translations[:, j, "xyz".index(channel[1])] = values[:, column]
    return translations
