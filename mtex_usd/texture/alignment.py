"""Bringing a take's skeleton space onto the sketch's: which way is up, which way it faces at rest, and how large it is.

A take of a Z-up library, of a character that faces another way at rest, or of a larger one then reads as the same
motion. Where the skeletons agree nothing is touched, to the bit.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.motion import quaternion
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.texture.facing import find_hips

__all__ = ["Alignment", "align_skeletons"]

FloatArray = npt.NDArray[np.float64]

_SAME_UP = 1e-3  # radians
_SAME_SIZE = 1e-3
# Rests face along an axis; hips a little askew are no reason to turn a take a little.
_ASKEW = np.radians(15.0)


@dataclass(frozen=True, eq=False)
class Alignment:
    """How a take's skeleton space is brought onto the sketch's.

    Parameters
    ----------
    turn
        Rotation from the take's axes to the sketch's, real first, shape [4]; None where they agree.
    scale
        Length of the sketch's legs in those of the take's.
    """

    turn: FloatArray | None
    scale: float

    def rotations(self, rotations: FloatArray) -> FloatArray:
        """Express rotations in skeleton axes [..., 4] in the sketch's axes."""
        if self.turn is None:
            return rotations
        return quaternion.multiply(quaternion.multiply(self.turn, rotations), quaternion.conjugate(self.turn))

    def offsets(self, offsets: FloatArray) -> FloatArray:
        """Express translations from rest [..., 3] in the sketch's axes and size."""
        turned = offsets if self.turn is None else quaternion.rotate(self.turn, offsets)
        return turned if self.scale == 1.0 else turned * self.scale


def align_skeletons(take: Skeleton, sketch: Skeleton, found: Mapping[int, int]) -> Alignment:
    """Measure how a take's skeleton has to be turned and scaled to stand as the sketch's does at rest.

    Parameters
    ----------
    take, sketch
        The two skeletons.
    found
        Joint of the take by joint of the sketch.

    Returns
    -------
    Alignment
        Up is laid on up; about up the hips are laid on the hips, to the nearest quarter turn where they are within 15
        degrees of one. The size is that of the legs (Gleicher 2000, section 1.7.2.4), else of all joints both have.
    """
    upright = _arc(take.up, sketch.up)
    hips = find_hips(sketch)
    legs = [i for i in range(len(sketch.joints)) if hips is None or set(hips) & set(sketch.chain(i)[:-1])]
    scale = _ratio(_extent(sketch, {i: i for i in found}, legs), _extent(take, found, legs))
    if hips is None or not set(hips) <= found.keys():
        return Alignment(upright, scale)
    about_up = _yaw_between(take, sketch, (found[hips[0]], found[hips[1]]), hips, upright)
    if about_up == 0.0:
        return Alignment(upright, scale)
    yaw = quaternion.exp(about_up * sketch.up)
    return Alignment(yaw if upright is None else quaternion.multiply(yaw, upright), scale)


def _arc(source: FloatArray, target: FloatArray) -> FloatArray | None:
    """The shortest rotation from one unit vector to another; None where they agree."""
    axis = np.cross(source, target)
    angle = float(np.arctan2(np.linalg.norm(axis), source @ target))
    if angle < _SAME_UP:
        return None
    if np.linalg.norm(axis) < _SAME_UP:  # opposite: any axis across will do
        axis = np.cross(source, np.eye(3)[np.argmin(np.abs(source))])
    return quaternion.exp(angle * axis / np.linalg.norm(axis))


def _yaw_between(
    take: Skeleton, sketch: Skeleton, take_hips: tuple[int, int], hips: tuple[int, int], upright: FloatArray | None
) -> float:
    """Turn about up from the take's hip axis to the sketch's at rest, radians."""
    own, other = sketch.rest_positions, take.rest_positions
    wanted = own[hips[1]] - own[hips[0]]
    given = other[take_hips[1]] - other[take_hips[0]]
    given = given if upright is None else quaternion.rotate(upright, given)
    sine = np.cross(given, wanted) @ sketch.up
    cosine = given @ wanted - (given @ sketch.up) * (wanted @ sketch.up)
    angle = float(np.arctan2(sine, cosine))
    quarter = np.pi / 2.0 * round(angle / (np.pi / 2.0))
    return quarter if abs(angle - quarter) < _ASKEW else angle


def _extent(skeleton: Skeleton, joints: Mapping[int, int], counted: list[int]) -> float:
    """Summed distance from each counted joint to the next above it, over joints that both skeletons have."""
    shared, places = set(joints.values()), skeleton.rest_positions
    lengths = [0.0]
    for joint in (joints[i] for i in counted if i in joints):
        above = [other for other in skeleton.chain(joint)[:-1] if other in shared]
        if above:
            lengths.append(float(np.linalg.norm(places[joint] - places[above[-1]])))
    return sum(lengths)


def _ratio(own: float, other: float) -> float:
    if own <= 0.0 or other <= 0.0 or abs(own / other - 1.0) < _SAME_SIZE:
        return 1.0
    return own / other
