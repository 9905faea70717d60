"""A character in a problem: which joints may move, and where its joints are for given displacements, with derivatives.

Lengths are metres here, angles radians. Everything is over the frames that some constraint looks at, all at once.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mtex_usd.constraints.spacetime.turning import exp_matrix, right_jacobian, to_matrix
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import FloatArray, IntArray

__all__ = ["Character", "Pose", "find_root", "measure_reach"]


def find_root(clip: Clip) -> int:
    """Give the topmost joint whose translation changes over time; the first joint where none does."""
    moving = (clip.translations != clip.translations[:1]).any(axis=(0, 2))
    return int(np.argmax(moving))


def measure_reach(clip: Clip) -> float:
    """Longest chain of bones from the root to a leaf, in metres, by the mean length of each bone over time."""
    lengths = np.sqrt(np.einsum("fji,fji->fj", clip.translations, clip.translations)).mean(axis=0)
    root, reach = find_root(clip), np.zeros(len(clip.joints))
    for joint, parent in enumerate(clip.parents):
        if parent >= 0 and joint != root:
            reach[joint] = reach[parent] + lengths[joint]
    longest = float(reach.max()) * clip.skeleton.meters_per_unit
    return longest if longest > 0.0 else 1.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Character:
    """One clip as the solver sees it.

    Parameters
    ----------
    clip
        The motion to change.
    turning
        Joints whose rotation may change, increasing, length A.
    root
        The joint whose translation may change; -1 where it may not.
    first_column
        Where its channels begin in the problem: 3 per turning joint, then 3 of the root's translation.
    """

    clip: Clip
    turning: tuple[int, ...]
    root: int
    first_column: int

    @property
    def column_count(self) -> int:
        """How many channels it has."""
        return 3 * len(self.turning) + (3 if self.root >= 0 else 0)

    @cached_property
    def levels(self) -> tuple[tuple[IntArray, IntArray], ...]:
        """Joints at each depth with their parents, from the top down."""
        parents, depth = self.clip.parents, np.zeros(len(self.clip.joints), dtype=np.intp)
        for joint, parent in enumerate(parents):
            depth[joint] = depth[parent] + 1 if parent >= 0 else 0
        rows = (np.flatnonzero(depth == level) for level in range(int(depth.max()) + 1))
        return tuple((joints, parents[joints]) for joints in rows)

    @cached_property
    def above(self) -> FloatArray:
        """Whether joint k is joint j or above it, as 0 and 1, [k, j]."""
        out = np.eye(len(self.clip.joints))
        for joint, parent in enumerate(self.clip.parents):
            if parent >= 0:
                out[:, joint] += out[:, parent]
        return out

    def rotation_columns(self, slots: IntArray) -> IntArray:
        """Columns of some turning joints, by their number among the turning ones, [3 * len(slots)]."""
        return np.asarray(self.first_column + (3 * slots[:, None] + np.arange(3)).ravel())

    @property
    def translation_columns(self) -> slice:
        """Columns of the root's translation."""
        first = self.first_column + 3 * len(self.turning)
        return slice(first, first + 3)


@dataclass(frozen=True, eq=False, kw_only=True)
class Pose:
    """Where a character is, at U frames.

    Parameters
    ----------
    character
        Whose pose it is.
    local
        Rotations relative to the parent, matrices [U, J, 3, 3].
    world
        Rotations in skeleton space, matrices [U, J, 3, 3].
    origins
        Joint positions in skeleton space, metres, [U, J, 3].
    axes
        Turn in skeleton space per change of a turning joint's rotation vector, columns, [U, A, 3, 3].
    jacobians
        The same in the joint's own axes, [U, A, 3, 3].
    """

    character: Character
    local: FloatArray
    world: FloatArray
    origins: FloatArray
    axes: FloatArray
    jacobians: FloatArray

    @cached_property
    def root_axes(self) -> FloatArray:
        """Movement in skeleton space per change of the root's translation, [U, 3, 3]."""
        parent = self.character.clip.parents[self.character.root]
        if parent < 0:
            return np.broadcast_to(np.eye(3), (len(self.world), 3, 3))
        return self.world[:, parent]


@dataclass(frozen=True, eq=False)
class Posing:
    """A character's motion at the frames some constraint looks at, ready to be displaced again and again.

    Parameters
    ----------
    character
        Whose motion it is.
    frames
        Those frames, [U].
    """

    character: Character
    frames: IntArray

    @cached_property
    def _local(self) -> FloatArray:
        return to_matrix(self.character.clip.rotations[self.frames])

    @cached_property
    def _offsets(self) -> FloatArray:
        clip = self.character.clip
        return clip.translations[self.frames] * clip.skeleton.meters_per_unit

    def pose(self, changes: FloatArray) -> Pose:
        """Displace by channels [U, C] of the whole problem."""
        character = self.character
        first, turning = character.first_column, np.array(character.turning, dtype=np.intp)
        vectors = changes[:, first : first + 3 * len(turning)].reshape(len(changes), len(turning), 3)
        local, offsets = np.array(self._local), np.array(self._offsets)
        local[:, turning] = local[:, turning] @ exp_matrix(vectors)
        if character.root >= 0:
            offsets[:, character.root] += changes[:, character.translation_columns]
        world, origins = _accumulate(character, local, offsets)
        jacobians = right_jacobian(vectors)
        axes = world[:, turning] @ jacobians
        return Pose(character=character, local=local, world=world, origins=origins, axes=axes, jacobians=jacobians)


def _accumulate(character: Character, local: FloatArray, offsets: FloatArray) -> tuple[FloatArray, FloatArray]:
    world, origins = np.array(local), np.array(offsets)
    for joints, parents in character.levels:
        inner = parents >= 0
        if inner.any():
            own, up = joints[inner], parents[inner]
            world[:, own] = world[:, up] @ local[:, own]
            origins[:, own] = origins[:, up] + (world[:, up] @ offsets[:, own, :, None])[..., 0]
    return world, origins
