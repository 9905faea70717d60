"""The root in skeleton space: read, moved over the floor, and put back, whatever joints are above it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.texture.facing import Facing, find_root, measure_heading
from mtex_usd.texture.pyramid import decompose, nearest_band

__all__ = ["RootMotion", "choose_root", "level", "move_level", "place_root", "pose_joint", "read_root"]

FloatArray = npt.NDArray[np.float64]

_STRIDE_HZ = 0.8  # what turns about as slowly as this, or faster, is swing and not heading


@dataclass(frozen=True, eq=False, kw_only=True)
class RootMotion:
    """How the root moves.

    Parameters
    ----------
    joint
        Index of the root.
    rotations, positions
        In skeleton space, shapes [F, 4] and [F, 3], skeleton units.
    raw_heading
        Turn of the hips about up since rest, radians, continuous, shape [F].
    up
        Up in skeleton space, shape [3].
    rate
        Frames per second.
    """

    joint: int
    rotations: FloatArray
    positions: FloatArray
    raw_heading: FloatArray
    up: FloatArray
    rate: float

    @cached_property
    def facing(self) -> Facing:
        """The facing frame: the heading less what is as fast as a stride or faster."""
        bands = decompose(self.raw_heading[:, None])
        slow = bands.at_or_below(nearest_band(_STRIDE_HZ, self.rate) + 1)
        return Facing(slow[:, 0], self.up)


def choose_root(clips: Sequence[Clip]) -> int:
    """Choose the joint that carries the travel of motions on the same joints: the topmost one that moves in any.

    Parameters
    ----------
    clips
        Motions on the same joints.

    Returns
    -------
    int
        Index of the joint; the first one where none moves.
    """
    found = [root for root in map(find_root, clips) if root is not None]
    return min(found, key=lambda joint: clips[0].joints[joint].count("/"), default=0)


def read_root(clip: Clip, *, joint: int | None = None) -> RootMotion:
    """Read how the root moves in skeleton space.

    Parameters
    ----------
    clip
        The motion.
    joint
        Index of the root; None for the topmost joint that moves.
    """
    root = choose_root([clip]) if joint is None else joint
    rotations, positions = pose_joint(clip.skeleton, root, clip.rotations, clip.translations)
    return RootMotion(
        joint=root,
        rotations=rotations,
        positions=positions,
        raw_heading=measure_heading(clip, root),
        up=clip.skeleton.up,
        rate=clip.rate,
    )


def pose_joint(
    skeleton: Skeleton, joint: int, rotations: FloatArray, translations: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Give the rotation [F, 4] and position [F, 3] of a joint in skeleton space.

    Parameters
    ----------
    skeleton
        The skeleton.
    joint
        Index of the joint.
    rotations, translations
        Relative to the parent, shapes [F, J, 4] and [F, J, 3].
    """
    chain = skeleton.chain(joint)
    world, place = rotations[:, chain[0]], translations[:, chain[0]]
    for part in chain[1:]:
        place = place + quaternion.rotate(world, translations[:, part])
        world = quaternion.multiply(world, rotations[:, part])
    return world, place


def place_root(clip: Clip, rotations: FloatArray, positions: FloatArray, *, joint: int) -> Clip:
    """Put the root where it is wanted in skeleton space; what is below moves with it.

    Parameters
    ----------
    clip
        The motion.
    rotations, positions
        In skeleton space, shapes [F, 4] and [F, 3].
    joint
        Index of the root.
    """
    parent = int(clip.skeleton.parents[joint])
    if parent >= 0:
        world, place = pose_joint(clip.skeleton, parent, clip.rotations, clip.translations)
        back = quaternion.conjugate(world)
        rotations, positions = quaternion.multiply(back, rotations), quaternion.rotate(back, positions - place)
    new_rotations, new_translations = np.array(clip.rotations), np.array(clip.translations)
    new_rotations[:, joint], new_translations[:, joint] = rotations, positions
    return replace(clip, rotations=new_rotations, translations=new_translations)


def level(vectors: FloatArray, up: FloatArray) -> FloatArray:
    """Take the part along up out of vectors [..., 3]."""
    return np.asarray(vectors - (vectors @ up)[..., None] * up)


def move_level(
    rotations: FloatArray, positions: FloatArray, *, turn: float, pivot: FloatArray, goal: FloatArray, up: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Turn a root about up and move it over the floor so that one place comes to another; heights stay.

    Parameters
    ----------
    rotations, positions
        In skeleton space, shapes [F, 4] and [F, 3].
    turn
        Radians about up.
    pivot, goal
        The place to move, and where to, shape [3]; their heights do not matter.
    up
        Up in skeleton space, shape [3].
    """
    turning = quaternion.exp(turn * up)
    moved = quaternion.rotate(turning, positions - level(pivot, up)) + level(goal, up)
    return quaternion.multiply(turning, rotations), moved
