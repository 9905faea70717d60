"""The two-bone limbs of a skeleton, found by names or shape, and the joints that carry no captured motion.

A limb is an upper joint, a middle one and an end (hip, knee, ankle; shoulder, elbow, wrist). Its swivel is the angle of
the middle about the line from the upper joint to the end: the one freedom that leaves both where they are.
"""

import re
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["Limb", "Swivel", "body_size", "captured_joints", "find_limbs", "measure_swivel"]

FloatArray = npt.NDArray[np.float64]

_MIDDLE_NAME = re.compile(r"knee|shin|calf|tibia|elbow|radius|low(er)?_?(leg|arm)|fore_?arm|leg([_.]?[lr])?$")
_OTHER_NAME = re.compile(r"twist|roll|end$|nub|^up|up(per)?_?leg|thigh")
_NO_BONE = 1e-3  # of the body's size
_SHORTEST_BONE = 0.08  # of the body's size: below are pelvis, spine, hands and feet
_LEAST_RATIO = 0.4  # of the two bones of a limb: a foot is shorter beside its shank
_STILL = 1e-6  # radians: a joint that turns less in the whole clip carries nothing
_ANTIPODE = 1e-9


@dataclass(frozen=True, kw_only=True)
class Limb:
    """Indices of the joints of a two-bone limb.

    Parameters
    ----------
    upper, middle, end
        Hip, knee and ankle, or shoulder, elbow and wrist.
    """

    upper: int
    middle: int
    end: int


@dataclass(frozen=True, eq=False, kw_only=True)
class Swivel:
    """How a limb is turned about the line from its upper joint to its end, in the frame of the upper joint's parent.

    Parameters
    ----------
    angles
        Radians in (-pi, pi], shape [F]; zero is an arbitrary but fixed direction carried from the rest pose by the
        shortest turn of the line.
    offsets
        How far the middle is off the line, in lengths of the limb, shape [F].
    axes
        Unit vectors along the line, shape [F, 3].
    middles, ends
        Places of the middle and the end from the upper joint, in lengths of the limb, shape [F, 3].
    """

    angles: FloatArray
    offsets: FloatArray
    axes: FloatArray
    middles: FloatArray
    ends: FloatArray


@lru_cache(maxsize=64)
def body_size(skeleton: Skeleton) -> float:
    """Give the largest extent of the rest pose along an axis, skeleton units: the height or the span of the arms."""
    positions = skeleton.rest_positions
    return float(np.ptp(positions, axis=0).max())


@lru_cache(maxsize=64)
def find_limbs(skeleton: Skeleton) -> tuple[Limb, ...]:
    """Find the limbs by the names of knees and elbows in the common conventions, else by the lengths of the bones.

    Parameters
    ----------
    skeleton
        Any skeleton; one without limbs gives none.
    """
    chains = _chains(skeleton)
    named = [chain for chain in chains if _is_middle(skeleton.joints[chain.middle])]
    return tuple(sorted(named or _pick_by_length(skeleton, chains), key=lambda limb: limb.upper))


def _is_middle(joint: str) -> bool:
    name = joint.rpartition("/")[2].lower()
    return bool(_MIDDLE_NAME.search(name)) and not _OTHER_NAME.search(name)


def _chains(skeleton: Skeleton) -> list[Limb]:
    """Every joint that has a parent and a grandparent, with them; of several children the one farthest away."""
    parents = skeleton.parents
    lengths = np.linalg.norm(skeleton.rest_translations, axis=-1)
    ends: dict[int, int] = {}
    for end in np.argsort(-lengths, kind="stable").tolist():
        ends.setdefault(int(parents[end]), end)
    return [
        Limb(upper=int(parents[middle]), middle=middle, end=end)
        for middle, end in ends.items()
        if middle >= 0
        and parents[middle] >= 0
        and parents[parents[middle]] >= 0
        and min(lengths[middle], lengths[end]) > _NO_BONE * body_size(skeleton)
    ]


def _pick_by_length(skeleton: Skeleton, chains: list[Limb]) -> list[Limb]:
    """Two long bones of about one length, the longest first; none shares a joint with another or carries one."""
    lengths = np.linalg.norm(skeleton.rest_translations, axis=-1)
    shortest = _SHORTEST_BONE * body_size(skeleton)
    inner = sorted(set(skeleton.parents.tolist()))
    found: list[Limb] = []
    for limb in sorted(chains, key=lambda limb: -min(lengths[limb.middle], lengths[limb.end])):
        shorter, longer = sorted((float(lengths[limb.middle]), float(lengths[limb.end])))
        branches = sum(int(skeleton.parents[joint]) == limb.upper for joint in inner if joint >= 0)
        fits = branches == 1 and shorter >= max(shortest, _LEAST_RATIO * longer)
        if fits and not any(_related(skeleton, limb, other) for other in found):
            found.append(limb)
    return found


def _related(skeleton: Skeleton, limb: Limb, other: Limb) -> bool:
    return limb.upper in skeleton.chain(other.end) or other.upper in skeleton.chain(limb.end)


def captured_joints(clip: Clip) -> list[int]:
    """List the joints that turn, less those below the end of a limb (fingers, thumbs, toes).

    Parameters
    ----------
    clip
        Any clip.
    """
    ends = {limb.end for limb in find_limbs(clip.skeleton)}
    turned = quaternion.angle_between(clip.rotations[:1], clip.rotations).max(axis=0) > _STILL
    return [
        joint for joint in range(len(clip.joints)) if turned[joint] and not ends & set(clip.skeleton.chain(joint)[:-1])
    ]


def measure_swivel(clip: Clip, limb: Limb) -> Swivel:
    """Measure a limb's swivel at every frame.

    Parameters
    ----------
    clip
        The clip.
    limb
        One of its limbs.
    """
    middles, ends = _limb_positions(limb, clip.rotations, clip.translations)
    axes = _unit(ends)
    off = middles - np.sum(middles * axes, axis=-1, keepdims=True) * axes
    across = _carry_reference(clip.skeleton, limb, axes)
    angles = np.arctan2(np.sum(off * np.cross(axes, across), axis=-1), np.sum(off * across, axis=-1))
    length = _length(clip.skeleton, limb)
    offsets = np.linalg.norm(off, axis=-1) / length
    return Swivel(angles=angles, offsets=offsets, axes=axes, middles=middles / length, ends=ends / length)


def _length(skeleton: Skeleton, limb: Limb) -> float:
    return float(np.linalg.norm(skeleton.rest_translations[[limb.middle, limb.end]], axis=-1).sum())


def _limb_positions(limb: Limb, rotations: FloatArray, translations: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Middle and end from the upper joint, in the frame of its parent, both [..., 3]."""
    lower = quaternion.rotate(rotations[..., limb.middle, :], translations[..., limb.end, :])
    upper = rotations[..., limb.upper, :]
    middles = quaternion.rotate(upper, translations[..., limb.middle, :])
    return middles, quaternion.rotate(upper, translations[..., limb.middle, :] + lower)


def _carry_reference(skeleton: Skeleton, limb: Limb, axes: FloatArray) -> FloatArray:
    """Turn a direction across the rest limb along with the line, the shortest way, shape [F, 3]."""
    _, end = _limb_positions(limb, skeleton.rest_rotations, skeleton.rest_translations)
    rest = _unit(end)
    across = _unit(np.cross(rest, np.eye(3)[np.argmin(np.abs(rest))]))
    cosines = np.maximum(1.0 + axes @ rest, _ANTIPODE)[:, None]
    turns = quaternion.normalize(np.concatenate([cosines, np.cross(rest, axes)], axis=-1))
    return quaternion.rotate(turns, np.broadcast_to(across, axes.shape))


def _unit(v: FloatArray) -> FloatArray:
    return np.asarray(v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-12))
