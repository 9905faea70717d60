"""A skeleton's rest pose as lengths of bones and branches of joints."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mtex_usd.motion.anatomy.tree import Tree
from mtex_usd.motion.skeleton import FloatArray

__all__ = ["Shape", "unit"]

_AT_ORIGIN = 1e-4  # of the body's size


@dataclass(frozen=True, eq=False)
class Shape:
    """The hierarchy with its rest pose, less leaves that have no place in it.

    Parameters
    ----------
    tree
        The hierarchy.
    """

    tree: Tree

    @cached_property
    def positions(self) -> FloatArray:
        """Joint positions at rest, shape [J, 3]."""
        return self.tree.skeleton.rest_positions

    @cached_property
    def children(self) -> list[list[int]]:
        """Children by joint, without leaves that a broken rest pose puts at the origin of the skeleton's space."""
        size = float(np.ptp(self.positions, axis=0).max())
        at_origin = np.linalg.norm(self.positions, axis=-1) <= _AT_ORIGIN * size
        return [
            [child for child in children if self.tree.children[child] or not at_origin[child] or at_origin[joint]]
            for joint, children in enumerate(self.tree.children)
        ]

    @cached_property
    def lengths(self) -> FloatArray:
        """Length of the bone that ends at each joint, shape [J]."""
        return np.asarray(np.linalg.norm(self.tree.skeleton.rest_translations, axis=-1))

    @cached_property
    def reaches(self) -> list[float]:
        """Length of the longest way down from each joint."""
        reaches = [0.0] * len(self.children)
        for joint in reversed(range(len(reaches))):
            reaches[joint] = max((self.lengths[child] + reaches[child] for child in self.children[joint]), default=0.0)
        return reaches

    def branch(self, start: int) -> list[int]:
        """Joints of the longest way down."""
        joints = [start]
        while further := self.children[joints[-1]]:
            joints.append(max(further, key=lambda child: self.lengths[child] + self.reaches[child]))
        return joints

    def length(self, branch: list[int]) -> float:
        """Length of a branch from its first joint to its last."""
        return float(self.lengths[branch[1:]].sum())

    def apart(self, a: int, b: int) -> float:
        """Distance of two joints at rest."""
        return float(np.linalg.norm(self.positions[a] - self.positions[b]))

    def mean(self, joints: list[int]) -> FloatArray:
        """Middle of joints at rest, shape [3]."""
        return np.asarray(self.positions[joints].mean(axis=0))


def unit(vector: FloatArray) -> FloatArray:
    """Scale a vector to unit length, one of no length to itself."""
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0.0 else vector
