"""How a body stands in its rest pose: where its head, its left, its front and its floor are.

A rest pose need not stand: some rigs keep one that lies on its back in the space its animation stands in. What the body
itself says then counts, and the turn that brings it upright is kept apart.
"""

import itertools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from mtex_usd.motion import quaternion
from mtex_usd.motion.anatomy import SIDES, Anatomy
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton

__all__ = [
    "Body",
    "estimate_ground",
    "measure_body",
    "measure_scale",
    "rest_ground",
    "shortest_turn",
    "stand_on",
    "stands_near_zero",
]

FloatArray = npt.NDArray[np.float64]

# A body within this of an axis was built along it; the few degrees are its build, not its stance.
_ALONG = np.cos(np.radians(25.0))
_NEARLY_OPPOSITE = -1.0 + 1e-6
_NO_LENGTH = 1e-6  # of the extent
_LOWEST_PERCENT = 2.0
# Of the height of the hips: joints of feet are above the floor, and hardly ever below.
_NEAR_ZERO = (-0.05, 0.2)
_LEG = ("thigh", "shin", "foot")


@dataclass(frozen=True, eq=False, kw_only=True)
class Body:
    """The rest pose as a body.

    Parameters
    ----------
    frame
        Rotation whose x, y and z axes are the body's left, up and front in skeleton space, real first, shape [4].
    upright
        Rotation that brings the rest pose upright in skeleton space, shape [4].
    lowest
        Height of the lowest joint of the feet in the upright rest pose, skeleton units along up; zero without feet.
    """

    frame: FloatArray
    upright: FloatArray
    lowest: float

    @property
    def is_upright(self) -> bool:
        """Whether the rest pose stands as it is."""
        return bool(abs(self.upright[0]) == 1.0)

    @property
    def standing(self) -> FloatArray:
        """The body's axes once it stands, real first, shape [4]."""
        return quaternion.multiply(self.upright, self.frame)


def measure_body(skeleton: Skeleton, anatomy: Anatomy) -> Body:
    """Measure the rest pose of a humanoid.

    Parameters
    ----------
    skeleton
        Any rest pose, upright or not.
    anatomy
        Its parts, the hips among them.

    Returns
    -------
    Body
        Up is the skeleton's own where the trunk is within 25 degrees of it, else the axis the trunk is built along.
    """
    positions, parts = skeleton.rest_positions, anatomy.parts
    up, side = _axes(skeleton, anatomy)
    frame = Rotation.from_matrix(np.stack([side, up, np.cross(side, up)], axis=1)).as_quat(scalar_first=True)
    upright = shortest_turn(up, skeleton.up, side)
    feet = [joint for part, joint in parts.items() if part.partition(".")[2] in ("foot", "toes")]
    heights = quaternion.rotate(upright, positions[feet]) @ skeleton.up if feet else np.zeros(1)
    return Body(frame=frame, upright=upright, lowest=float(heights.min()))


def estimate_ground(clip: Clip, anatomy: Anatomy, body: Body) -> float:
    """Tell the height of the floor in skeleton space: zero, or where the rest pose stands.

    Captured motion stands on zero; a rig may have its floor elsewhere. What is nearer to where the feet of the clip get
    to is taken; a rest pose that stands near zero stands on it.

    Parameters
    ----------
    clip, anatomy, body
        A motion, the parts of its skeleton and its rest pose as a body.

    Returns
    -------
    float
        Height along the skeleton's up, skeleton units.
    """
    feet = [anatomy.parts[f"{side}.foot"] for side in SIDES if f"{side}.foot" in anatomy.parts]
    if not feet:
        return 0.0
    positions = clip.skeleton.joint_positions(feet, clip.rotations, clip.translations)
    lowest = float(np.percentile(positions @ clip.skeleton.up, _LOWEST_PERCENT))
    floors = (0.0, _rest_floor(clip.skeleton, anatomy, body))
    return min(floors, key=lambda height: abs(lowest - height))


def rest_ground(skeleton: Skeleton, anatomy: Anatomy, body: Body) -> float:
    """Tell the height of the floor from the rest pose alone.

    Zero where the rest pose stands near it, or has its hips there as captures do, else where the rest pose stands.
    """
    hips = _hips_height(skeleton, anatomy, body)
    is_origin = abs(hips) < _NEAR_ZERO[1] * (hips - body.lowest)
    return 0.0 if is_origin else _rest_floor(skeleton, anatomy, body)


def stands_near_zero(skeleton: Skeleton, anatomy: Anatomy, body: Body) -> bool:
    """Tell whether the upright rest pose stands on the floor at zero, as that of a rig does."""
    least, most = (share * (_hips_height(skeleton, anatomy, body) - body.lowest) for share in _NEAR_ZERO)
    return bool(least < body.lowest < most)


def _rest_floor(skeleton: Skeleton, anatomy: Anatomy, body: Body) -> float:
    """Give the height the rest pose stands at, zero where it is near that."""
    return 0.0 if stands_near_zero(skeleton, anatomy, body) else body.lowest


def _hips_height(skeleton: Skeleton, anatomy: Anatomy, body: Body) -> float:
    hips = quaternion.rotate(body.upright, skeleton.rest_positions[anatomy.parts["hips"]])
    return float(hips @ skeleton.up)


def stand_on(skeleton: Skeleton, anatomy: Anatomy, body: Body, ground: float) -> FloatArray:
    """Give the place on the floor below the hips of the upright rest pose, shape [3]."""
    hips = quaternion.rotate(body.upright, skeleton.rest_positions[anatomy.parts["hips"]])
    return np.asarray(hips + (ground - hips @ skeleton.up) * skeleton.up)


def measure_scale(source: Skeleton, found: Anatomy, target: Skeleton, wanted: Anatomy) -> float:
    """Give the length of the target's legs in those of the source's (Gleicher 2000, section 1.7.2.4).

    Parameters
    ----------
    source, found
        The take's skeleton and its parts.
    target, wanted
        The character's. What is measured is thigh and shin, as far as both have them; else the trunk.
    """
    for parts in ([f"{side}.{part}" for side in SIDES for part in _LEG], ["hips", "neck"], ["hips", "head"]):
        shared = [part for part in parts if part in found.parts and part in wanted.parts]
        own, other = (_length_along(*each, shared) for each in ((target, wanted), (source, found)))
        if own > 0.0 and other > 0.0:
            return own / other
    return 1.0


def _length_along(skeleton: Skeleton, anatomy: Anatomy, parts: list[str]) -> float:
    """Sum of the distances between parts that follow each other on one limb."""
    places = {part: skeleton.rest_positions[anatomy.parts[part]] for part in parts}
    pairs = itertools.pairwise(parts)
    return float(
        sum(
            np.linalg.norm(places[b] - places[a])
            for a, b in pairs
            if a.partition(".")[0] == b.partition(".")[0] or "." not in a
        )
    )


def shortest_turn(source: FloatArray, target: FloatArray, around: FloatArray) -> FloatArray:
    """Give the shortest rotations from unit vectors to others; where they are opposite, half a turn about `around`.

    Parameters
    ----------
    source, target, around
        Shapes [..., 3], broadcast; `around` is not along `source`.

    Returns
    -------
    FloatArray
        Real first, shape [..., 4].
    """
    source, target, around = np.broadcast_arrays(source, target, around)
    cosine = np.sum(source * target, axis=-1, keepdims=True)
    # Near half a turn the axis is all rounding: first half a turn about the given one, then what is left.
    is_opposite = cosine < _NEARLY_OPPOSITE
    sign = np.where(is_opposite, -1.0, 1.0)
    turn = np.concatenate([1.0 + sign * cosine, sign * np.cross(source, target)], axis=-1)
    half = np.concatenate([np.zeros_like(cosine), _across(around, source)], axis=-1)
    first = np.where(is_opposite, half, np.array([1.0, 0.0, 0.0, 0.0]))
    return quaternion.normalize(quaternion.multiply(turn, first))


def _axes(skeleton: Skeleton, anatomy: Anatomy) -> tuple[FloatArray, FloatArray]:
    """The body's up and left in skeleton space; without two thighs apart, the skeleton's own up and any side."""
    positions, parts = skeleton.rest_positions, anatomy.parts
    if {"left.thigh", "right.thigh"} <= parts.keys():
        left, right = positions[parts["left.thigh"]], positions[parts["right.thigh"]]
        trunk, least = _trunk(skeleton, anatomy), _NO_LENGTH * np.ptp(positions, axis=0).max()
        up = _snap(_unit(trunk), skeleton.up, *np.eye(3), *-np.eye(3)) if np.linalg.norm(trunk) > least else skeleton.up
        side = _across(left - right, up)
        if np.linalg.norm(side) > least:
            return up, _snap(_unit(side), *_level_axes(up))
    turn = shortest_turn(np.array([0.0, 1.0, 0.0]), skeleton.up, np.array([1.0, 0.0, 0.0]))
    return skeleton.up, quaternion.rotate(turn, np.array([1.0, 0.0, 0.0]))


def _trunk(skeleton: Skeleton, anatomy: Anatomy) -> FloatArray:
    """From between the thighs to the upper end of the trunk, or where there is none, from the knees up."""
    positions, parts = skeleton.rest_positions, anatomy.parts
    between = positions[[parts[f"{side}.thigh"] for side in SIDES]].mean(axis=0)
    top = next((parts[part] for part in ("neck", "head", "chest") if part in parts), None)
    if top is not None:
        return np.asarray(positions[top] - between)
    return np.asarray(between - positions[[parts.get(f"{side}.shin", parts["hips"]) for side in SIDES]].mean(axis=0))


def _across(vectors: FloatArray, axis: FloatArray) -> FloatArray:
    """The parts of vectors across unit axes; shapes [..., 3]."""
    return np.asarray(vectors - np.sum(vectors * axis, axis=-1, keepdims=True) * axis)


def _unit(vector: FloatArray) -> FloatArray:
    return np.asarray(vector / np.linalg.norm(vector))


def _snap(direction: FloatArray, *axes: FloatArray) -> FloatArray:
    """Give the first axis that a direction is along, else the direction."""
    return next((axis for axis in axes if direction @ axis > _ALONG), direction)


def _level_axes(up: FloatArray) -> list[FloatArray]:
    """Signed coordinate axes that are across a direction."""
    return [axis for axis in (*np.eye(3), *-np.eye(3)) if abs(axis @ up) < 1e-6]
