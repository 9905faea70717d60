"""What of a skeleton is drawn: its bones, the side of the body each is on, the ends that leave trails, its front."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.motion.anatomy import find_anatomy
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.texture.facing import find_hips

__all__ = ["Body", "describe_body", "find_bones", "find_front", "find_sides"]

FloatArray = npt.NDArray[np.float64]

_LONGEST_BONE = 0.5  # of the body's height; what is longer ties a figure to its origin
_SHORTEST_BONE = 0.002
_MOST_LONG = 0.25  # of the bones; where more are long, as in an arm alone, they are the figure
_FLATTEST = 0.25  # of its length a figure counts as high, however flat it lies
_TRAVEL = 0.5  # of the height: who goes less than that far is seen from where the hips face
_TRAIL_PARTS = ("left.hand", "right.hand", "left.foot", "right.foot")
_MOST_ENDS = 6


@dataclass(frozen=True, eq=False, kw_only=True)
class Body:
    """How a character is drawn.

    Parameters
    ----------
    bones
        Joint indices (parent, joint) of each bone.
    sides
        ``"left"``, ``"right"`` or ``"middle"`` of each joint.
    head
        Index of the head, None where it is not known.
    ends
        Joints that leave trails: hands and feet, or the last joints of the longest chains.
    front
        Level unit vector from which the figure is seen at best, skeleton space, shape [3]: the way it goes or faces.
    height
        Of the figure at the first frame along up, skeleton units; of what lies flat, a quarter of its length.
    floor
        Height of the floor along up, skeleton units.
    """

    bones: tuple[tuple[int, int], ...]
    sides: tuple[str, ...]
    head: int | None
    ends: tuple[int, ...]
    front: FloatArray
    height: float
    floor: float


def describe_body(skeleton: Skeleton, positions: FloatArray) -> Body:
    """Tell how a character is drawn.

    Parameters
    ----------
    skeleton
        Its skeleton.
    positions
        A motion of it, skeleton space, shape [F, J, 3].
    """
    bones = find_bones(skeleton, positions[0])
    drawn = sorted({joint for bone in bones for joint in bone}) or list(range(len(skeleton.joints)))
    height = _find_height(positions[0, drawn], skeleton.up)
    anatomy = find_anatomy(skeleton)
    return Body(
        bones=bones,
        sides=find_sides(skeleton),
        head=anatomy.parts.get("head") if anatomy is not None else None,
        ends=_find_ends(skeleton),
        front=_find_way(skeleton, positions, height),
        height=height,
        floor=_find_floor(positions[:, drawn] @ skeleton.up, height),
    )


def find_bones(skeleton: Skeleton, pose: FloatArray) -> tuple[tuple[int, int], ...]:
    """Give the bones worth drawing: not those without length, nor those from a far origin to the body.

    Parameters
    ----------
    skeleton
        The skeleton.
    pose
        Joint positions, skeleton space, shape [J, 3].
    """
    height = _extent(pose @ skeleton.up) or 1.0
    lengths = {
        (parent, joint): float(np.linalg.norm(pose[joint] - pose[parent]))
        for joint, parent in enumerate(skeleton.parents.tolist())
        if parent >= 0
    }
    bones = [bone for bone, length in lengths.items() if length > _SHORTEST_BONE * height]
    usual = [bone for bone in bones if lengths[bone] < _LONGEST_BONE * height]
    return tuple(usual if len(bones) - len(usual) <= _MOST_LONG * len(bones) else bones)


def _find_height(points: FloatArray, up: FloatArray) -> float:
    return max(_extent(points @ up), _FLATTEST * float(np.ptp(points, axis=0).max())) or 1.0


def _extent(heights: FloatArray) -> float:
    return float(np.ptp(heights))


def find_sides(skeleton: Skeleton) -> tuple[str, ...]:
    """Tell which side of the body each joint is on; all in the middle where the skeleton is no humanoid."""
    anatomy = find_anatomy(skeleton)
    begins = {} if anatomy is None else anatomy.parts
    sided = {joint: part.partition(".")[0] for part, joint in begins.items() if "." in part}
    return tuple(_side_of(skeleton.chain(joint), sided) for joint in range(len(skeleton.joints)))


def _side_of(chain: Sequence[int], sided: dict[int, str]) -> str:
    return next((sided[joint] for joint in chain if joint in sided), "middle")


def _find_ends(skeleton: Skeleton) -> tuple[int, ...]:
    anatomy = find_anatomy(skeleton)
    parts = {} if anatomy is None else anatomy.parts
    known = tuple(parts[part] for part in _TRAIL_PARTS if part in parts)
    if known:
        return known
    leaves = sorted(set(range(len(skeleton.joints))) - set(skeleton.parents.tolist()))
    by_depth = sorted(leaves, key=lambda joint: -len(skeleton.chain(joint)))
    return tuple(sorted(by_depth[:_MOST_ENDS]))


def find_front(skeleton: Skeleton, pose: FloatArray) -> FloatArray:
    """Give the level direction that a figure faces, a unit vector [3] in skeleton space.

    Parameters
    ----------
    skeleton
        The skeleton; of one without hips some level direction is given.
    pose
        Joint positions, skeleton space, shape [J, 3].
    """
    hips = find_hips(skeleton)
    across = pose[hips[1]] - pose[hips[0]] if hips else np.roll(skeleton.up, 1)
    anatomy = find_anatomy(skeleton)
    if anatomy is not None and hips and hips[0] == anatomy.parts.get("right.thigh"):
        across = -across
    return _unit(np.cross(skeleton.up, across), np.roll(skeleton.up, -1))


def _find_way(skeleton: Skeleton, positions: FloatArray, height: float) -> FloatArray:
    """The way a motion goes, or faces where it goes nowhere."""
    travel = positions[-1].mean(axis=0) - positions[0].mean(axis=0)
    level = travel - (travel @ skeleton.up) * skeleton.up
    facing = find_front(skeleton, positions[len(positions) // 2])
    return _unit(level, facing) if np.linalg.norm(level) > _TRAVEL * height else facing


def _unit(vector: FloatArray, otherwise: FloatArray) -> FloatArray:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0.0 else otherwise


def _find_floor(heights: FloatArray, height: float) -> float:
    """The level the lowest joints come down to, but for outliers; zero where it is as good as that."""
    lowest = float(np.quantile(heights.min(axis=1), 0.05))
    return 0.0 if 0.0 <= lowest < 0.1 * height else lowest
