"""The skeleton: joints, their parents and their rest pose, with forward kinematics."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt

from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion

__all__ = ["Skeleton", "parents_of"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]


def parents_of(joints: tuple[str, ...]) -> IntArray:
    """Give the index of each joint's nearest listed ancestor, -1 for a root.

    Parameters
    ----------
    joints
        Joint paths such as ``"Hips/Spine"``; an ancestor may be left out of the list.

    Returns
    -------
    IntArray
        Parent indices, shape [J].
    """
    index = {joint: i for i, joint in enumerate(joints)}
    parents = np.full(len(joints), -1, dtype=np.intp)
    for i, joint in enumerate(joints):
        ancestor = joint.rpartition("/")[0]
        while ancestor and ancestor not in index:
            ancestor = ancestor.rpartition("/")[0]
        if ancestor:
            parents[i] = index[ancestor]
    return parents


@dataclass(frozen=True, eq=False, kw_only=True)
class Skeleton:
    """A hierarchy of joints with its rest pose.

    Parameters
    ----------
    joints
        Joint paths, a parent before its children, length J.
    rest
        Rest transforms relative to the parent, shape [J, 4, 4], USD layout (row vectors, translation in the last row).
    up
        Unit vector that points up, in skeleton space, shape [3].
    meters_per_unit
        Length of one skeleton unit in metres.

    Raises
    ------
    InputError
        Where a joint comes before its parent, is listed twice, or the shapes do not fit.
    """

    joints: tuple[str, ...]
    rest: FloatArray
    up: FloatArray = field(default_factory=lambda: np.array([0.0, 1.0, 0.0]))
    meters_per_unit: float = 0.01

    def __post_init__(self) -> None:
        """Check that shapes fit and the joints are in order."""
        count = len(self.joints)
        if self.rest.shape != (count, 4, 4):
            raise InputError(
                "rest transforms do not fit the joints", expected=f"shape ({count}, 4, 4)", found=str(self.rest.shape)
            )
        if len(set(self.joints)) != count:
            twice = sorted({joint for joint in self.joints if self.joints.count(joint) > 1})
            raise InputError("joint paths are not unique", found=", ".join(twice))
        late = np.flatnonzero(self.parents >= np.arange(count))
        if late.size:
            raise InputError("a joint comes before its parent", found=self.joints[int(late[0])])

    @cached_property
    def parents(self) -> IntArray:
        """Index of each joint's parent, -1 for a root, shape [J]."""
        return parents_of(self.joints)

    @cached_property
    def rest_rotations(self) -> FloatArray:
        """Rest rotations relative to the parent, real first, shape [J, 4]."""
        return quaternion.from_usd_matrix(self.rest)

    @cached_property
    def rest_translations(self) -> FloatArray:
        """Rest translations relative to the parent, skeleton units, shape [J, 3]."""
        return np.ascontiguousarray(self.rest[:, 3, :3])

    @cached_property
    def rest_orientations(self) -> FloatArray:
        """Rest rotations in skeleton space (W of the channel definition), real first, shape [J, 4]."""
        return self.world_rotations(self.rest_rotations)

    @cached_property
    def rest_positions(self) -> FloatArray:
        """Joint positions at rest in skeleton space, skeleton units, shape [J, 3]."""
        positions, _ = self.world_pose(self.rest_rotations, self.rest_translations)
        return positions

    @cached_property
    def height(self) -> float:
        """Extent of the rest pose along up, in skeleton units."""
        along = self.rest_positions @ self.up
        return float(along.max() - along.min())

    def world_rotations(self, rotations: FloatArray) -> FloatArray:
        """Accumulate rotations relative to the parent into skeleton space; shapes [..., J, 4]."""
        world = np.array(rotations, dtype=np.float64)
        for joint, parent in enumerate(self.parents):
            if parent >= 0:
                world[..., joint, :] = quaternion.multiply(world[..., parent, :], world[..., joint, :])
        return world

    def world_pose(self, rotations: FloatArray, translations: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Forward kinematics without scales.

        Parameters
        ----------
        rotations, translations
            Relative to the parent, shapes [..., J, 4] (real first) and [..., J, 3] (skeleton units).

        Returns
        -------
        tuple of FloatArray
            Joint positions [..., J, 3] and rotations [..., J, 4] in skeleton space.
        """
        world = self.world_rotations(rotations)
        positions = np.array(np.broadcast_to(translations, (*world.shape[:-1], 3)), dtype=np.float64)
        for joint, parent in enumerate(self.parents):
            if parent >= 0:
                offset = quaternion.rotate(world[..., parent, :], positions[..., joint, :])
                positions[..., joint, :] = positions[..., parent, :] + offset
        return positions, world

    def joint_positions(self, joints: Sequence[int], rotations: FloatArray, translations: FloatArray) -> FloatArray:
        """Forward kinematics for a few joints, which costs no more than what is above them.

        Parameters
        ----------
        joints
            Indices of the joints, length N.
        rotations, translations
            Of all joints, as :meth:`world_pose` takes them.

        Returns
        -------
        FloatArray
            Positions in skeleton space, shape [..., N, 3].
        """
        part, needed = _part_above(self, tuple(joints))
        positions, _ = part.world_pose(rotations[..., needed, :], translations[..., needed, :])
        return positions[..., [needed.index(joint) for joint in joints], :]

    def chain(self, joint: int) -> list[int]:
        """Joints from the root down to a joint, itself included."""
        chain = [joint]
        while self.parents[chain[-1]] >= 0:
            chain.append(int(self.parents[chain[-1]]))
        return chain[::-1]


@lru_cache(maxsize=64)
def _part_above(skeleton: Skeleton, joints: tuple[int, ...]) -> tuple[Skeleton, list[int]]:
    """Give the skeleton of some joints and all above them, and where its joints are in the whole."""
    needed = sorted({above for joint in joints for above in skeleton.chain(joint)})
    part = replace(skeleton, joints=tuple(skeleton.joints[i] for i in needed), rest=skeleton.rest[needed])
    return part, needed
