"""Numbers that tell how a variant moves, without a truth to compare with: jerk and detail against the takes', feet."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.contacts import Contact, detect_contacts, find_effectors
from mtex_usd.constraints.kinematics import pose_skeleton
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.correspondence import corresponding_joints
from mtex_usd.review.shot import ReviewedCharacter
from mtex_usd.texture.pyramid import decompose, nearest_band

__all__ = ["Measure", "MotionNumbers", "band_energy", "foot_slide", "largest_turn", "third_difference"]

FloatArray = npt.NDArray[np.float64]

_DETAIL_HZ = (3.4, 1.6)  # where the paper's texture bands peak
_LEAST_FRAMES = 5


@dataclass(frozen=True, kw_only=True)
class MotionNumbers:
    """How one motion moves; None where a number has no meaning.

    Parameters
    ----------
    jerk
        Third difference of the copied joints' rotations relative to the takes'; 1 is as smooth as captured motion.
    detail
        Energy of the copied joints near 1.6 and 3.4 Hz relative to the takes'; 1 is as lively.
    turn
        Largest turn of a copied joint from one frame to the next, degrees.
    slide_cm
        How far feet slide while the sketch has them planted, mean over its contacts, centimetres.
    """

    jerk: float | None
    detail: float | None
    turn: float
    slide_cm: float | None


@dataclass(frozen=True, eq=False)
class Measure:
    """Measures motions on one character against its takes.

    Parameters
    ----------
    character
        Whose joints were copied, from what.
    """

    character: ReviewedCharacter

    def measure(self, clip: Clip) -> MotionNumbers:
        """Give the numbers of a motion on the character's skeleton."""
        rotations = clip.rotations[:, self._joints]
        return MotionNumbers(
            jerk=_ratio(third_difference(rotations), self._usual_jerk),
            detail=_ratio(self._detail(rotations), self._usual_detail),
            turn=largest_turn(rotations),
            slide_cm=_to_cm(foot_slide(clip, self._contacts), clip),
        )

    @cached_property
    def _joints(self) -> list[int]:
        """Joints copied of the takes, by one rotation at least."""
        names = [name.rpartition(".") for name in self.character.channels]
        paths = dict.fromkeys(joint for joint, _, axis in names if axis.startswith("r"))
        return [self.character.sketch.joints.index(path) for path in paths]

    @cached_property
    def _taken(self) -> list[FloatArray]:
        """The copied joints' rotations in every take that has them and is long enough to measure."""
        wanted = [self.character.sketch.joints[joint] for joint in self._joints]
        found = [(take, corresponding_joints(take.joints, wanted)) for take in self.character.takes]
        return [
            take.rotations[:, [index[i] for i in range(len(wanted))]]
            for take, index in found
            if len(index) == len(wanted) and take.frame_count >= _LEAST_FRAMES
        ]

    @cached_property
    def _usual_jerk(self) -> float | None:
        return _pool([third_difference(taken) for taken in self._taken], self._taken, power=2.0)

    @cached_property
    def _usual_detail(self) -> float | None:
        return _pool([self._detail(taken) for taken in self._taken], self._taken, power=1.0)

    @cached_property
    def _means(self) -> FloatArray:
        return quaternion.mean(np.concatenate(self._taken)) if self._taken else np.empty((0, 4))

    def _detail(self, rotations: FloatArray) -> float:
        if not self._taken:
            return float("nan")
        bands = [nearest_band(frequency, self.character.sketch.rate) for frequency in _DETAIL_HZ]
        relative = quaternion.multiply(quaternion.conjugate(self._means), rotations)
        vectors = np.degrees(quaternion.unroll_vectors(quaternion.log(relative)))
        return band_energy(vectors.reshape(len(vectors), -1), min(bands), max(bands))

    @cached_property
    def _contacts(self) -> tuple[Contact, ...]:
        return _find_contacts(self.character.sketch)


def _find_contacts(sketch: Clip) -> tuple[Contact, ...]:
    try:
        return detect_contacts(sketch, effectors=find_effectors(sketch.skeleton, clip=sketch))
    except InputError:  # who has no feet plants none
        return ()


def _ratio(value: float, usual: float | None) -> float | None:
    return value / usual if usual else None


def _to_cm(length: float | None, clip: Clip) -> float | None:
    return None if length is None else 100.0 * clip.skeleton.meters_per_unit * length


def _pool(values: Sequence[float], taken: Sequence[FloatArray], *, power: float) -> float | None:
    """Mean over takes, or root mean square with power 2, every frame counting alike; None without takes."""
    if not values:
        return None
    frames = [len(rotations) for rotations in taken]
    return float(np.average(np.power(values, power), weights=frames) ** (1.0 / power))


def third_difference(rotations: FloatArray) -> float:
    """Root mean square of the third difference of rotations [F, J, 4], degrees per frame cubed; 0 below four frames.

    The four rotation vectors of a difference are taken about the first of the four poses: about one mean pose, an arm
    that swings a full turn from it would count as a jolt where there is none.
    """
    count = len(rotations) - 3
    if count < 1:
        return 0.0
    start = quaternion.conjugate(rotations[:count])
    steps = [quaternion.log(quaternion.multiply(start, rotations[i : i + count])) for i in (1, 2, 3)]
    difference = 3.0 * steps[0] - 3.0 * steps[1] + steps[2]
    return float(np.degrees(np.sqrt(np.square(difference).mean()))) if difference.size else 0.0


def band_energy(curves: FloatArray, first: int, last: int) -> float:
    """Mean square of bands first to last of curves [F, C], in the curves' unit squared."""
    return float(np.square(decompose(curves, most=last).sum_of(first, last)).mean()) if curves.size else 0.0


def largest_turn(rotations: FloatArray) -> float:
    """Largest turn of any joint from one frame to the next, degrees; rotations [F, J, 4]."""
    turns = quaternion.angle_between(rotations[:-1], rotations[1:])
    return float(np.degrees(turns.max(initial=0.0)))


def foot_slide(clip: Clip, contacts: Sequence[Contact]) -> float | None:
    """Give how far planted points move over the floor.

    Parameters
    ----------
    clip
        A motion.
    contacts
        When which points are to be planted.

    Returns
    -------
    float or None
        Mean over contacts of the largest level distance from the contact's middle place, skeleton units; None without
        contacts.
    """
    if not contacts:
        return None
    pose = pose_skeleton(clip.skeleton, clip.rotations, clip.translations)
    places = [pose.place(contact.effector.joint, np.asarray(contact.effector.offset)) for contact in contacts]
    parts = zip(places, contacts, strict=True)
    return float(np.mean([_slide(whole[each.first : each.last + 1], clip.skeleton.up) for whole, each in parts]))


def _slide(places: FloatArray, up: FloatArray) -> float:
    away = places - np.median(places, axis=0)
    level = away - (away @ up)[:, None] * up
    return float(np.linalg.norm(level, axis=1).max())
