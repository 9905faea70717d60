"""The root and the way the character faces.

The root's rotation and travel are read in the character's facing frame, so that a take walking another way still fits.
The heading is the turn of the hip-to-hip axis about up since rest, smoothed to what is slower than the match band.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from mtex_usd.motion import quaternion
from mtex_usd.motion.anatomy import find_anatomy
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import IntArray, Skeleton
from mtex_usd.texture.pyramid import decompose

__all__ = ["Facing", "find_hips", "find_root", "measure_heading", "replace_yaw"]

FloatArray = npt.NDArray[np.float64]

_STILL = 1e-6


def find_root(clip: Clip) -> int | None:
    """Give the topmost joint with animated translation, None where no joint has."""
    moving = np.ptp(clip.translations, axis=0).max(axis=-1) > _STILL * clip.skeleton.height
    if not moving.any():
        return None
    depths = np.array([joint.count("/") for joint in clip.joints])
    return int(np.flatnonzero(moving)[np.argmin(depths[moving])])


@lru_cache(maxsize=64)
def find_hips(skeleton: Skeleton) -> tuple[int, int] | None:
    """Find the two joints the legs begin with.

    On a humanoid the thighs; else the legs are the two chains that end lowest at rest and part nearest the root, and
    the hips their first joints that stand apart. None where the skeleton has no two such chains.
    """
    anatomy = find_anatomy(skeleton)
    if anatomy is not None and {"left.thigh", "right.thigh"} <= anatomy.parts.keys():
        left, right = anatomy.parts["left.thigh"], anatomy.parts["right.thigh"]
        return min(left, right), max(left, right)
    return _find_lowest_limbs(skeleton)


def _find_lowest_limbs(skeleton: Skeleton) -> tuple[int, int] | None:
    """Give the first joints that stand apart of the two chains that end lowest at rest."""
    positions = skeleton.rest_positions
    heights = positions @ skeleton.up
    chains = [skeleton.chain(leaf) for leaf in _leaves(skeleton.parents)]
    lowest = min(chains, key=lambda chain: heights[chain[-1]])
    low = [chain for chain in chains if heights[chain[-1]] <= heights[lowest[-1]] + 0.15 * skeleton.height]
    others = [chain for chain in low if chain[0] == lowest[0] and chain is not lowest]
    if not others:
        return None
    other = min(others, key=lambda chain: _shared(lowest, chain))
    shared = _shared(lowest, other)
    for a, b in zip(lowest[shared:], other[shared:], strict=False):
        apart = positions[a] - positions[b]
        if np.linalg.norm(apart - (apart @ skeleton.up) * skeleton.up) > 0.01 * skeleton.height:
            return min(a, b), max(a, b)
    return None


def _leaves(parents: IntArray) -> list[int]:
    return sorted(set(range(len(parents))) - set(parents.tolist()))


def _shared(a: list[int], b: list[int]) -> int:
    """How many joints two chains have in common."""
    return sum(x == y for x, y in zip(a, b, strict=False))


def _across(skeleton: Skeleton, hips: tuple[int, int], rotations: FloatArray, translations: FloatArray) -> FloatArray:
    """From the first hip to the second, shape [..., 3]."""
    positions = skeleton.joint_positions(hips, rotations, translations)
    return np.asarray(positions[..., 1, :] - positions[..., 0, :])


@lru_cache(maxsize=64)
def _rest_directions(skeleton: Skeleton, hips: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
    """The level part of the way across the hips at rest, and what it becomes after a quarter turn about up."""
    across = _across(skeleton, hips, skeleton.rest_rotations, skeleton.rest_translations)
    level = across - (across @ skeleton.up) * skeleton.up
    return level, np.cross(skeleton.up, level)


def measure_heading(clip: Clip, root: int) -> FloatArray:
    """Turn of the hip axis about up since rest, radians, continuous in time, shape [F].

    Where the skeleton has no hips, the turn of the root joint about up.
    """
    skeleton = clip.skeleton
    hips = find_hips(skeleton)
    if hips is None:
        world = skeleton.world_rotations(clip.rotations)[:, root]
        turned = quaternion.multiply(world, quaternion.conjugate(skeleton.rest_orientations[root]))
        return np.unwrap(quaternion.twist(turned, skeleton.up))
    across = _across(skeleton, hips, clip.rotations, clip.translations)
    level, turned = _rest_directions(skeleton, hips)
    return np.unwrap(np.arctan2(across @ turned, across @ level))


@dataclass(frozen=True, eq=False)
class Facing:
    """A clip's facing frame over time.

    Parameters
    ----------
    heading
        Smoothed heading in radians, shape [F].
    up
        Up in skeleton space, shape [3].
    """

    heading: FloatArray
    up: FloatArray

    @classmethod
    def of_clip(cls, clip: Clip, root: int, match_band: int) -> "Facing":
        """Measure a clip's facing, keeping what is slower than the match band."""
        heading = measure_heading(clip, root)[:, None]
        return cls(decompose(heading).at_or_below(match_band + 1)[:, 0], clip.skeleton.up)

    def _turns(self, angles: FloatArray) -> FloatArray:
        return quaternion.exp(angles[:, None] * self.up)

    def into(self, rotations: FloatArray) -> FloatArray:
        """Bring rotations [F, 4] from skeleton space into the facing frame."""
        return quaternion.multiply(self._turns(-self.heading), rotations)

    def out_of(self, rotations: FloatArray) -> FloatArray:
        """Bring rotations [F, 4] from the facing frame back into skeleton space."""
        return quaternion.multiply(self._turns(self.heading), rotations)

    def _midway(self) -> FloatArray:
        return 0.5 * (self.heading[1:] + self.heading[:-1])

    def unroll_travel(self, positions: FloatArray) -> FloatArray:
        """Straighten the root's path: every step is laid along the way the character faces; [F, 3] to [F, 3]."""
        start = quaternion.rotate(self._turns(-self.heading[:1]), positions[:1])
        steps = quaternion.rotate(self._turns(-self._midway()), np.diff(positions, axis=0))
        return np.cumsum(np.concatenate([start, steps]), axis=0)

    def roll_travel(self, travel: FloatArray) -> FloatArray:
        """Invert :meth:`unroll_travel`."""
        start = quaternion.rotate(self._turns(self.heading[:1]), travel[:1])
        steps = quaternion.rotate(self._turns(self._midway()), np.diff(travel, axis=0))
        return np.cumsum(np.concatenate([start, steps]), axis=0)


def replace_yaw(rotations: FloatArray, yaw_of: FloatArray, up: FloatArray) -> FloatArray:
    """Give rotations the turn about up of others; both [F, 4], in the same frame.

    A rotation is read as its tilt first, then its turn about up; only the turn is exchanged.
    """
    turn = quaternion.twist(yaw_of, up) - quaternion.twist(rotations, up)
    return quaternion.multiply(quaternion.exp(turn[:, None] * up), rotations)
