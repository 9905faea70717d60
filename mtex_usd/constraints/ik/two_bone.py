"""Limbs of two bones, solved in one step: legs and arms.

Two lengths and a distance make a triangle, so the bend of the knee follows from how far the foot is to be from the hip;
the leg is then turned the shortest way to the goal, which keeps the swivel of the given pose. The knee's plane is the
given one where it is bent; a leg that is all but straight shows none but noise, and bends where it does elsewhere.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.ik.goals import Goal, check_goals, goal_errors
from mtex_usd.constraints.ik.result import IkResult, make_result
from mtex_usd.constraints.ik.turns import shortest_turn
from mtex_usd.constraints.kinematics import Pose, pose_skeleton
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["solve_two_bone"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

_TYPICAL = 0.2  # what a radian of change of the bend counts for the typical plane, beside the sine of the bend itself
_STRAIGHT = 1e-4  # sine of a bend that shows no plane
_NOTHING = 1e-12  # of a limb's length


@dataclass(frozen=True, eq=False, kw_only=True)
class _Limb:
    """A limb at all frames, in skeleton space from its upper joint; directions [F, 3], lengths [F]."""

    bone: FloatArray
    first: FloatArray
    shank: FloatArray
    second: FloatArray
    goal: FloatArray

    @property
    def end(self) -> FloatArray:
        """Where the limb ends."""
        return self.first[:, None] * self.bone + self.second[:, None] * self.shank

    @property
    def across(self) -> FloatArray:
        """The part of the second bone's direction across the first, as long as the sine of the bend."""
        return self.shank - _dot(self.shank, self.bone)[:, None] * self.bone


def solve_two_bone(  # noqa: PLR0913  (a limb, a goal and how to treat them)
    clip: Clip,
    *,
    upper: int,
    middle: int,
    end: int,
    place: FloatArray,
    orientation: FloatArray | None = None,
    offset: FloatArray | None = None,
    active: BoolArray | None = None,
    pole: FloatArray | None = None,
    easing: float = 0.005,
    tolerance_m: float = 1e-4,
    tolerance_deg: float = 0.01,
) -> IkResult:
    """Bend and turn a limb so that its end comes to places.

    Parameters
    ----------
    clip
        The given poses.
    upper, middle, end
        Joints such as hip, knee and ankle, each below the one before; joints between them, as for twist, are kept.
    place
        Where the end's point is to be, skeleton space, skeleton units, shape [F, 3].
    orientation
        How the end is to be turned, skeleton space, real part first, shape [F, 4]; where None it keeps its rotation
        relative to its parent.
    offset
        The point in the end's space, skeleton units, shape [3]; the end itself where None.
    active
        At which frames the goal holds, shape [F]; all where None.
    pole
        Where the middle goes when the limb bends, a direction in skeleton space at the rest pose, shape [3]; where None
        where it is at the frames at which the limb is bent, else at rest.
    easing
        Part of the limb's length before its limit in which it straightens gradually, so that it does not snap: up to
        1 - `easing` of its length, or as far as the given pose reaches, goals are met exactly.
    tolerance_m, tolerance_deg
        Goals this near count as met, metres and degrees; such frames are left alone.

    Returns
    -------
    IkResult
        Only the three joints differ, and the end only where an orientation is given. A goal out of reach leaves the
        limb all but straight and pointing to it.

    Raises
    ------
    InputError
        Where the joints are no chain, arrays do not fit the clip, or a limb that is straight at every frame and at
        rest has no pole.
    """
    goal = Goal(joint=end, place=place, offset=offset, orientation=orientation, active=active)
    check_goals(clip, [goal])
    _check_chain(clip.skeleton, upper, middle, end)
    if not 0.0 < easing < 1.0:
        raise InputError("two-bone: bad easing", expected="above 0 and below 1", found=f"{easing:g}")
    pose = pose_skeleton(clip.skeleton, clip.rotations, clip.translations)
    frames = _unmet(clip, goal, pose, tolerance_m, tolerance_deg)
    if not frames.size:
        return make_result(clip, [goal], tolerance_m, tolerance_deg)
    typical = _typical_plane(clip, pose, (upper, middle, end), pole, frames)
    limb = _measure(pose, goal, (upper, middle), frames)
    bend, turn = _solve(limb, quaternion.rotate(pose.orientations[frames, upper], typical), easing)
    rotations = np.array(clip.rotations)
    parents = clip.parents
    rotations[frames, upper] = _turn_joint(pose, clip, frames, upper, turn)
    rotations[frames, middle] = _turn_joint(pose, clip, frames, middle, bend)
    if orientation is not None:
        above = quaternion.multiply(quaternion.multiply(turn, bend), pose.orientations[frames, parents[end]])
        rotations[frames, end] = _same_side(
            quaternion.multiply(quaternion.conjugate(above), orientation[frames]), clip.rotations[frames, end]
        )
    return make_result(replace(clip, rotations=rotations), [goal], tolerance_m, tolerance_deg)


def _check_chain(skeleton: Skeleton, upper: int, middle: int, end: int) -> None:
    for above, below in ((upper, middle), (middle, end)):
        if above == below or above not in skeleton.chain(below):
            names = [skeleton.joints[joint].rpartition("/")[2] for joint in (above, below)]
            raise InputError("two-bone: no chain", expected=f"{names[0]} above {names[1]}", found="it is not")


def _unmet(clip: Clip, goal: Goal, pose: Pose, tolerance_m: float, tolerance_deg: float) -> IntArray:
    distances, angles = goal_errors([goal], pose)
    far = distances[:, 0] * clip.skeleton.meters_per_unit > tolerance_m
    return np.flatnonzero(far | (np.degrees(angles[:, 0]) > tolerance_deg))


def _measure(pose: Pose, goal: Goal, joints: tuple[int, int], frames: IntArray) -> _Limb:
    """Give a limb at some frames; with an orientation to be met, it ends at the end joint, else at the goal's point."""
    upper, middle = joints
    hip, knee = pose.positions[frames, upper], pose.positions[frames, middle]
    if goal.orientation is None:
        tip, target = pose.place(goal.joint, goal.point)[frames], goal.place[frames]
    else:
        tip = pose.positions[frames, goal.joint]
        target = goal.place[frames] - quaternion.rotate(goal.orientation[frames], goal.point)
    bone, first = _unit(knee - hip)
    shank, second = _unit(tip - knee)
    return _Limb(bone=bone, first=first, shank=shank, second=second, goal=target - hip)


def _typical_plane(
    clip: Clip, pose: Pose, joints: tuple[int, int, int], pole: FloatArray | None, frames: IntArray
) -> FloatArray:
    """Give where the middle goes when the limb bends: away from this direction of the upper joint's space, [3]."""
    upper, middle, end = joints
    skeleton = clip.skeleton
    rest = quaternion.conjugate(skeleton.rest_orientations[upper])
    if pole is not None:
        return -quaternion.rotate(rest, np.asarray(pole, dtype=np.float64))
    positions = pose.positions
    seen = _across(positions[:, upper], positions[:, middle], positions[:, end])
    own = quaternion.rotate(quaternion.conjugate(pose.orientations[:, upper]), seen).mean(axis=0)
    if np.linalg.norm(own) > _STRAIGHT:
        return np.asarray(own)
    resting = [skeleton.rest_positions[[joint]] for joint in joints]
    own = quaternion.rotate(rest, _across(*resting)[0])
    if np.linalg.norm(own) > _STRAIGHT:
        return np.asarray(own)
    raise InputError(
        f"two-bone: the limb at {clip.joints[upper]} is straight at every frame and at rest",
        expected="a bend that shows where its middle goes",
        found=f"none, at frame {frames[0]} neither",
        fix="Give a pole.",
    )


def _across(hip: FloatArray, knee: FloatArray, ankle: FloatArray) -> FloatArray:
    bone, first = _unit(knee - hip)
    shank, second = _unit(ankle - knee)
    return _Limb(bone=bone, first=first, shank=shank, second=second, goal=ankle - hip).across


def _solve(limb: _Limb, typical: FloatArray, easing: float) -> tuple[FloatArray, FloatArray]:
    """Give the turns in skeleton space of the second bone about the middle and of the whole about the upper, [F, 4]."""
    cosine = _bend_cosine(limb, _ease(limb, easing))
    side = _bend_side(limb, typical, np.arccos(cosine))
    shank = cosine[:, None] * limb.bone + np.sqrt(1.0 - np.square(cosine))[:, None] * side
    bend = shortest_turn(limb.shank, shank, side)
    end, distance = _unit(limb.first[:, None] * limb.bone + limb.second[:, None] * shank)
    goal, far = _unit(limb.goal)
    # From no distance there is no direction to turn from or to.
    size = _NOTHING * (limb.first + limb.second)
    directed = ((distance > size) & (far > size))[:, None]
    return bend, shortest_turn(end, np.where(directed, goal, end), side)


def _ease(limb: _Limb, easing: float) -> FloatArray:
    """Give how far from the upper joint the limb is to end, [F]: as far as its goal, but never beyond its reach."""
    reach = limb.first + limb.second
    given = np.linalg.norm(limb.end, axis=1)
    wanted = np.linalg.norm(limb.goal, axis=1)
    begin = np.maximum((1.0 - easing) * reach, np.minimum(given, reach))
    room = np.maximum(reach - begin, _NOTHING * reach)
    beyond = np.maximum(wanted - begin, 0.0)
    eased = np.where(beyond > 0.0, begin + room * -np.expm1(-beyond / room), wanted)
    return np.asarray(np.clip(eased, np.abs(limb.first - limb.second), reach))


def _bend_cosine(limb: _Limb, distance: FloatArray) -> FloatArray:
    """Give the cosine of the angle between the bones, by the law of cosines, [F]."""
    squares = np.square(distance) - np.square(limb.first) - np.square(limb.second)
    return np.clip(squares / (2.0 * limb.first * limb.second), -1.0, 1.0)


def _bend_side(limb: _Limb, typical: FloatArray, bend: FloatArray) -> FloatArray:
    """Give the unit direction across the first bone to which the second is bent, [F, 3]."""
    across = limb.across
    before = np.arctan2(np.linalg.norm(across, axis=1), _dot(limb.shank, limb.bone))
    usual, _ = _unit(typical - _dot(typical, limb.bone)[:, None] * limb.bone)
    side, _ = _unit(across + (_TYPICAL * np.abs(bend - before))[:, None] * usual)
    return side


def _turn_joint(pose: Pose, clip: Clip, frames: IntArray, joint: int, turn: FloatArray) -> FloatArray:
    """Give a joint's rotations relative to its parent after a turn in skeleton space, [F, 4]."""
    parent = clip.parents[joint]
    before = clip.rotations[frames, joint]
    if parent < 0:
        return _same_side(quaternion.multiply(turn, before), before)
    above = pose.orientations[frames, parent]
    local = quaternion.multiply(quaternion.multiply(quaternion.conjugate(above), turn), above)
    return _same_side(quaternion.multiply(local, before), before)


def _same_side(q: FloatArray, like: FloatArray) -> FloatArray:
    return np.where(_dot(q, like)[:, None] < 0.0, -q, q)


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("...i,...i->...", a, b))


def _unit(v: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give directions and lengths; of no length, no direction."""
    length = np.linalg.norm(v, axis=-1)
    return np.asarray(v / np.where(length > 0.0, length, 1.0)[..., None]), length
