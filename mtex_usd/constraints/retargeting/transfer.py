"""The arithmetic of retargeting: a take's pose, section by section, on the joints of another skeleton.

Both rest poses are laid on each other as bodies. A joint then turns in space as the take's joint at the same place of
its section does, and where the section is aimed its bone is laid along the take's. A spine of three joints is read at
the heights of the five it drives, so that it bends as the take's does.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.retargeting.body import Body, shortest_turn
from mtex_usd.constraints.retargeting.sections import Chain, Section
from mtex_usd.motion import quaternion
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["Share", "Stance", "bone_leans", "find_shares", "rest_lean", "turn_section"]

FloatArray = npt.NDArray[np.float64]

_NO_LENGTH = 1e-6  # of the extent
_LEAST_SHARE = 1e-3
_ALONG_FRONT = 0.9  # cosine


@dataclass(frozen=True, eq=False, kw_only=True)
class Stance:
    """How two skeletons are laid on each other.

    Parameters
    ----------
    source, target
        The take's skeleton and the character's.
    bodies
        Their rest poses as bodies, in the same order.
    """

    source: Skeleton
    target: Skeleton
    bodies: tuple[Body, Body]

    @property
    def turn(self) -> FloatArray:
        """Rotation from the take's space to the character's, real first, shape [4]."""
        source, target = self.bodies
        return quaternion.multiply(target.standing, quaternion.conjugate(source.standing))

    @property
    def rest_turn(self) -> FloatArray:
        """Rotation that lays the character's rest pose on the take's, in the take's space, shape [4]."""
        source, target = self.bodies
        return quaternion.multiply(source.frame, quaternion.conjugate(target.frame))

    def half_turn_axis(self, bone: FloatArray) -> FloatArray:
        """Tell about what a bone that rests the other way round is turned.

        Parameters
        ----------
        bone
            Direction of the character's bone at rest, shape [3].

        Returns
        -------
        FloatArray
            The way the character's rest pose faces, about which arms that hang are raised; its up for bones along that.
        """
        _, up, front = quaternion.rotate(self.bodies[1].frame, np.eye(3))
        return np.asarray(front if abs(front @ bone) < _ALONG_FRONT else up)


@dataclass(frozen=True)
class Share:
    """Where on a take's section a joint of the character reads.

    Parameters
    ----------
    joint
        The character's joint.
    sources
        The take's joints that turn it, each with its weight; weights sum to 1.
    """

    joint: int
    sources: tuple[tuple[int, float], ...]


def find_shares(section: Section, stance: Stance) -> list[Share]:
    """Tell which joints of the take turn each joint of a section.

    Parameters
    ----------
    section
        Where both have joints.
    stance
        The skeletons.

    Returns
    -------
    list of Share
        One per joint of the character. A bone reads the take's between the two bones whose middles it lies between,
        along the rest pose.
    """
    middles = _middles(_stations(section.source, stance.source))
    wanted = _middles(_stations(section.target, stance.target))
    shares = []
    for at, joint in enumerate(section.target.joints):
        if at == 0 and section.keeps_first:
            shares.append(Share(joint, ((section.source.joints[0], 1.0),)))
            continue
        weights = [float(np.interp(wanted[at], middles, row)) for row in np.eye(len(middles))]
        used = zip(section.source.joints, weights, strict=True)
        shares.append(Share(joint, tuple((other, weight) for other, weight in used if weight > _LEAST_SHARE)))
    return shares


def turn_section(
    section: Section, stance: Stance, turns: FloatArray, positions: FloatArray, *, lean: FloatArray
) -> FloatArray:
    """Turn the joints of a section as a take does.

    Parameters
    ----------
    section, stance
        Where, and how the skeletons lie on each other.
    turns
        Rotations of the take's joints in its own space since rest, shape [F, J, 4].
    positions
        Places of the take's joints, shape [F, J, 3].
    lean
        How joints that are not aimed are turned in rest, in the take's space, shape [4]: as the bone above them is, so
        that a hand goes on where the forearm points.

    Returns
    -------
    FloatArray
        Rotations of the section's joints in the character's space, shape [F, N, 4].
    """
    orientations = stance.target.rest_orientations
    rotations = []
    for at, share in enumerate(find_shares(section, stance)):
        turn = _blend(turns, share)
        if section.is_aimed(at):
            placed = quaternion.multiply(turn, stance.rest_turn)
            placed = quaternion.multiply(_find_lean(section, stance, at, placed, positions), placed)
        else:
            placed = quaternion.multiply(turn, quaternion.multiply(lean, stance.rest_turn))
        rotations.append(quaternion.multiply(quaternion.multiply(stance.turn, placed), orientations[share.joint]))
    return np.stack(rotations, axis=1)


def rest_lean(section: Section, stance: Stance) -> FloatArray:
    """Tell how the last bone of a section is turned in rest to lie along the take's, in the take's space, shape [4]."""
    last = len(section.target.joints) - 1
    if not section.is_aimed(last):
        return np.array([1.0, 0.0, 0.0, 0.0])
    return np.asarray(_find_lean(section, stance, last, stance.rest_turn[None], stance.source.rest_positions[None])[0])


def bone_leans(section: Section, stance: Stance) -> list[float]:
    """Tell how far apart the bones of a section and the take's rest once the bodies lie on each other, radians."""
    still, places = stance.rest_turn[None], stance.source.rest_positions[None]
    aimed = [at for at in range(len(section.target.joints)) if section.is_aimed(at)]
    leans = [_find_lean(section, stance, at, still, places)[0] for at in aimed]
    return [float(np.linalg.norm(quaternion.log(lean))) for lean in leans]


def _blend(turns: FloatArray, share: Share) -> FloatArray:
    """The rotation between those of the joints that turn one, at most two of them; shape [F, 4]."""
    (first, _), *rest = share.sources
    blended = turns[:, first]
    for joint, weight in rest:
        across = quaternion.log(quaternion.multiply(quaternion.conjugate(blended), turns[:, joint]))
        blended = quaternion.multiply(blended, quaternion.exp(weight * across))
    return blended


def _find_lean(section: Section, stance: Stance, at: int, placed: FloatArray, positions: FloatArray) -> FloatArray:
    """How a bone has to be turned to lie along the take's between the same stations, shape [F, 4]."""
    chain, places = section.target, stance.target.rest_positions
    bone = places[chain.all_joints[at + 1]] - places[chain.joints[at]]
    stations = _stations(chain, stance.target)
    ends = [_read(section.source, stance.source, positions, station) for station in stations[at : at + 2]]
    chord = ends[1] - ends[0]
    length = np.linalg.norm(chord, axis=-1, keepdims=True)
    if np.linalg.norm(bone) <= _least_length(stance.target):
        return np.broadcast_to(np.array([1.0, 0.0, 0.0, 0.0]), placed.shape)
    bone /= np.linalg.norm(bone)
    given = quaternion.rotate(placed, bone)
    is_short = length <= _least_length(stance.source)
    wanted = np.where(is_short, given, chord / np.where(is_short, 1.0, length))
    return shortest_turn(given, wanted, quaternion.rotate(placed, stance.half_turn_axis(bone)))


def _least_length(skeleton: Skeleton) -> float:
    """What is no longer has no direction."""
    return float(_NO_LENGTH * np.ptp(skeleton.rest_positions, axis=0).max())


def _stations(chain: Chain, skeleton: Skeleton) -> FloatArray:
    """Where a chain's joints and its end are along it in rest, 0 to 1, shape [N + 1]."""
    steps = np.linalg.norm(np.diff(skeleton.rest_positions[list(chain.all_joints)], axis=0), axis=-1)
    if chain.end is None:
        steps = np.append(steps, steps.mean() if len(steps) else 1.0)
    total = steps.sum()
    even = np.full(len(steps), 1.0 / len(steps))
    return np.append(0.0, np.cumsum(steps / total if total > 0.0 else even))


def _middles(stations: FloatArray) -> FloatArray:
    return np.asarray((stations[1:] + stations[:-1]) / 2.0)


def _read(chain: Chain, skeleton: Skeleton, positions: FloatArray, station: float) -> FloatArray:
    """Place of a station on the take's section at every frame, shape [F, 3]."""
    stations = _stations(chain, skeleton)
    joints = chain.all_joints
    above = int(np.clip(np.searchsorted(stations, station, side="right"), 1, len(joints) - 1))
    below = above - 1
    span = stations[above] - stations[below]
    part = 0.0 if span <= 0.0 else (station - stations[below]) / span
    return np.asarray((1.0 - part) * positions[:, joints[below]] + part * positions[:, joints[above]])
