"""The points of the feet that touch the floor: a heel and the ball of the toes of each foot.

A skeleton has joints inside the foot, not its sole. The toe joint is near enough to the ball of the foot. The heel is
below the ankle, as far as the toe joint is below it, and behind it: so both are on one plane along the sole, and the
foot rolls about a point that stays where it is, which the ankle does not.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.contacts.curves import measure_points
from mtex_usd.constraints.kinematics import pose_skeleton
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.anatomy import find_anatomy
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["Effector", "body_scale", "find_effectors"]

FloatArray = npt.NDArray[np.float64]

_LEG_M = 0.95  # from the pelvis to the ankle along the bones, of the people the thresholds were set on
_HEEL_BEHIND = 0.3  # of the distance from ankle to toes: the heel bone reaches that far behind the ankle
_STILL_M_S = 0.2  # slower, both ends of a foot stand on something
_LEAST_STILL_S = 0.2  # of standing, to tell how the foot is held while it stands
_LOW_M = 0.03  # ankles this much above where they stand lowest stand flat too; on tiptoe they are higher
_LOWEST = 0.05  # quantile of the heights: the lowest but for outliers
_STEEPEST = 0.85  # sine of the slope from ankle to toes of a foot that stands; one that kneels is steeper
_SIDES = ("left", "right")


@dataclass(frozen=True, eq=False, kw_only=True)
class Effector:
    """A point of the body that touches things.

    Parameters
    ----------
    name
        Such as ``"left.heel"``.
    joint
        Index of the joint it moves with.
    offset
        Where it is in the joint's space, skeleton units, shape [3].
    """

    name: str
    joint: int
    offset: FloatArray


def find_effectors(skeleton: Skeleton, *, clip: Clip | None = None) -> tuple[Effector, ...]:
    """Find heel and toes of each foot.

    Parameters
    ----------
    skeleton
        A skeleton whose feet :func:`mtex_usd.motion.anatomy.find_anatomy` knows.
    clip
        A motion on the skeleton that shows how the feet are held where they stand; without one, or where it never
        stands, the rest pose is taken to stand flat.

    Returns
    -------
    tuple of Effector
        ``left.heel``, ``left.toes``, ``right.heel``, ``right.toes``; of a foot without toe joint the ankle alone, under
        the name of the heel.

    Raises
    ------
    InputError
        Where no foot is found.
    """
    parts = _parts(skeleton)
    found: list[Effector] = []
    for side in _SIDES:
        foot, toes = parts.get(f"{side}.foot"), parts.get(f"{side}.toes")
        if foot is None:
            continue
        found.append(Effector(name=f"{side}.heel", joint=foot, offset=_heel_offset(skeleton, clip, foot, toes)))
        if toes is not None:
            found.append(Effector(name=f"{side}.toes", joint=toes, offset=np.zeros(3)))
    if not found:
        raise InputError(
            "no feet found on the skeleton",
            expected="joints named as in a known convention, or shaped like legs",
            found=", ".join(joint.rpartition("/")[2] for joint in skeleton.joints[:12]),
            fix="Give the effectors.",
        )
    return tuple(found)


@lru_cache(maxsize=64)
def body_scale(skeleton: Skeleton) -> float:
    """Give how many skeleton units a metre of an average person is on this body.

    Parameters
    ----------
    skeleton
        Any skeleton; the legs are what is compared, from where they part to the ankles. One without legs is measured
        in true metres.
    """
    parts = _parts(skeleton)
    feet = [parts[f"{side}.foot"] for side in _SIDES if f"{side}.foot" in parts]
    if len(feet) < 2:
        return 1.0 / skeleton.meters_per_unit
    lengths = np.linalg.norm(skeleton.rest_translations, axis=1)
    left, right = (set(skeleton.chain(foot)) for foot in feet)
    leg = 0.5 * float(lengths[list(left ^ right)].sum())
    return leg / _LEG_M or 1.0 / skeleton.meters_per_unit


def _parts(skeleton: Skeleton) -> dict[str, int]:
    anatomy = find_anatomy(skeleton)
    return {} if anatomy is None else dict(anatomy.parts)


def _heel_offset(skeleton: Skeleton, clip: Clip | None, foot: int, toes: int | None) -> FloatArray:
    if toes is None:
        return np.zeros(3)
    to_toes = _between(skeleton, foot, toes)
    up = _sole_up(skeleton, clip, (foot, toes), to_toes)
    rise = min(float(to_toes @ up), 0.0)
    along = to_toes - (to_toes @ up) * up
    return np.asarray(rise * up - _HEEL_BEHIND * along)


def _between(skeleton: Skeleton, foot: int, toes: int) -> FloatArray:
    """Give the rest position of the toes in the foot's space, shape [3]."""
    apart = skeleton.rest_positions[toes] - skeleton.rest_positions[foot]
    return quaternion.rotate(quaternion.conjugate(skeleton.rest_orientations[foot]), apart)


def _sole_up(skeleton: Skeleton, clip: Clip | None, joints: tuple[int, int], to_toes: FloatArray) -> FloatArray:
    """Give the direction that is up, in the foot's space, while the foot stands flat, shape [3]."""
    foot, toes = joints
    rest = quaternion.rotate(quaternion.conjugate(skeleton.rest_orientations[foot]), skeleton.up)
    if clip is None:
        return rest
    standing = _standing_up(clip, foot, toes)
    if standing is None or abs(standing @ to_toes) > _STEEPEST * np.linalg.norm(to_toes):
        return rest
    return standing


def _standing_up(clip: Clip, foot: int, toes: int) -> FloatArray | None:
    """Give the middle of up in the foot's space over the frames where it stands lowest; None where it never does."""
    scale = body_scale(clip.skeleton)
    pose = pose_skeleton(clip.skeleton, clip.rotations, clip.translations)
    curves = measure_points(pose.positions[:, [foot, toes]], clip.rate, clip.skeleton.up)
    still = np.flatnonzero((curves.frame_speeds < _STILL_M_S * scale).all(axis=1))
    if len(still) < max(_LEAST_STILL_S * clip.rate, 2.0):
        return None
    heights = curves.frame_heights[still, 0]
    low = still[heights <= np.quantile(heights, _LOWEST) + _LOW_M * scale]
    ups = quaternion.rotate(quaternion.conjugate(pose.orientations[low, foot]), clip.skeleton.up)
    middle = np.median(ups, axis=0)
    return np.asarray(middle / np.linalg.norm(middle))
