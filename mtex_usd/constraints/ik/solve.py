"""Inverse kinematics of whole clips, frame by frame (Gleicher 2000, section 1.7.1).

Every frame is solved from its given pose and for the least change from it, so that smooth motions with smooth goals
give smooth results. Where a frame finds another way to bend than the one before it, it is solved again from that one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.ik.continuity import mend_jumps
from mtex_usd.constraints.ik.coordinates import Coordinates
from mtex_usd.constraints.ik.goals import Goal, check_goals, goal_errors
from mtex_usd.constraints.ik.limits import JointLimits
from mtex_usd.constraints.ik.newton import minimize
from mtex_usd.constraints.ik.objective import Objective, limb_length
from mtex_usd.constraints.ik.part import take_part
from mtex_usd.constraints.ik.result import IkResult, make_result
from mtex_usd.constraints.kinematics import pose_skeleton
from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["solve_ik"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

_ROUNDING = 1e-9  # radians


def solve_ik(
    clip: Clip,
    goals: Sequence[Goal],
    *,
    joints: Sequence[int] | None = None,
    limits: JointLimits | None = None,
    costs: FloatArray | None = None,
    tolerance_m: float = 1e-4,
    tolerance_deg: float = 0.01,
    rounds: int = 80,
) -> IkResult:
    """Turn joints so that points of the body come to places, changing the pose as little as possible.

    Parameters
    ----------
    clip
        The given poses. Translations and scales stay; scales are not read.
    goals
        What is wanted.
    joints
        Indices of the joints that may turn; where None those between the goals and the trunk's first branching, so
        that no limb is carried along by another one's goal.
    limits
        How far joints may turn; None for as far as they like. A joint that may turn and is outside its limits is
        brought inside, whether or not a goal needs it, at every frame.
    costs
        What a change of each joint counts beside the others', above 0, shape [J]; 1 each where None.
    tolerance_m, tolerance_deg
        Goals this near count as met, metres and degrees. A frame whose goals are all met already is left alone.
    rounds
        How many steps the solver tries per frame.

    Returns
    -------
    IkResult
        A goal that cannot be reached is come as near to as possible, and `distances_m` says how near.

    Raises
    ------
    InputError
        Where the goals or limits do not fit the clip, or a goal's joint has none above it that may turn.

    Notes
    -----
    Damped least squares (Wampler 1986; Nakamura and Hanafusa 1986), with the curvature of the goals added near the
    solution, and the limits as bounds on the joints' angles. The least change, not the least step, is what is
    searched for: the result does not depend on the way the solver took.
    """
    check_goals(clip, goals)
    moving = _choose_joints(clip.skeleton, goals, joints)
    _check_sizes(clip, limits, costs)
    settings = _Settings(
        limits=limits,
        costs=np.ones(len(clip.joints)) if costs is None else np.asarray(costs, dtype=np.float64),
        distance=tolerance_m / clip.skeleton.meters_per_unit,
        angle=float(np.radians(tolerance_deg)),
        rounds=rounds,
    )
    rotations = np.array(clip.rotations)
    for group, own in _independent_groups(clip.skeleton, goals, moving):
        rotations[:, own] = _solve_group(clip, group, own, settings)
    return make_result(replace(clip, rotations=rotations), goals, tolerance_m, tolerance_deg)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Settings:
    """How to solve; the tolerances in skeleton units and radians, the costs of all joints."""

    limits: JointLimits | None
    costs: FloatArray
    distance: float
    angle: float
    rounds: int


def _independent_groups(
    skeleton: Skeleton, goals: Sequence[Goal], moving: IntArray
) -> list[tuple[list[Goal], IntArray]]:
    """Part the goals by the joints they share: two legs are two small problems rather than one large one."""
    groups: list[tuple[list[Goal], set[int]]] = []
    for goal in goals:
        own = set(skeleton.chain(goal.joint)) & set(moving.tolist())
        joined = [group for group in groups if group[1] & own]
        groups = [group for group in groups if not group[1] & own]
        groups.append(([*(g for group in joined for g in group[0]), goal], own.union(*(group[1] for group in joined))))
    return [(members, np.array(sorted(joints), dtype=np.intp)) for members, joints in groups]


def _solve_group(clip: Clip, goals: Sequence[Goal], moving: IntArray, settings: _Settings) -> FloatArray:
    """Give the rotations of some joints that meet goals which no other of the joints moves, [F, N, 4]."""
    part = take_part(clip, goals, settings.limits)
    coordinates = Coordinates.of(part.clip, part.number(moving), part.limits)
    objective = Objective(
        coordinates=coordinates,
        goals=part.goals,
        reaches=_measure_reaches(clip, goals, moving),
        costs=settings.costs[moving],
    )
    values = np.zeros((clip.frame_count, len(moving), 3))
    frames = _unmet_frames(objective, settings.distance, settings.angle)
    if frames.size:
        values[frames] = minimize(objective, values[frames], frames, rounds=settings.rounds)
        values = mend_jumps(objective, values, frames, rounds=settings.rounds)
    return _turn_joints(coordinates, values)


def _choose_joints(skeleton: Skeleton, goals: Sequence[Goal], joints: Sequence[int] | None) -> IntArray:
    chains = [skeleton.chain(goal.joint) for goal in goals]
    on_chains = {joint for chain in chains for joint in chain}
    allowed = on_chains - set(_trunk(skeleton)) if joints is None else on_chains & set(joints)
    for number, chain in enumerate(chains):
        if not allowed & set(chain):
            raise InputError(
                f"goal {number}: no joint that may turn moves {skeleton.joints[goals[number].joint]}",
                expected="one of " + ", ".join(skeleton.joints[joint].rpartition("/")[2] for joint in chain),
                fix="Give more joints.",
            )
    return np.array(sorted(allowed), dtype=np.intp)


def _trunk(skeleton: Skeleton) -> list[int]:
    """Give the joints from the root to the first that branches, both included."""
    trunk = [0]
    children = np.flatnonzero(skeleton.parents == 0)
    while len(children) == 1 and np.any(skeleton.parents == children[0]):
        trunk.append(int(children[0]))
        children = np.flatnonzero(skeleton.parents == children[0])
    # A single chain never branches: all of it but its root may turn.
    return trunk if len(children) > 1 else trunk[:1]


def _check_sizes(clip: Clip, limits: JointLimits | None, costs: FloatArray | None) -> None:
    count = len(clip.joints)
    if limits is not None and len(limits.axes) != count:
        raise InputError("joint limits do not fit the skeleton", expected=str(count), found=str(len(limits.axes)))
    if costs is not None and (np.shape(costs) != (count,) or not np.all(np.asarray(costs) > 0.0)):
        raise InputError("costs do not fit the skeleton", expected=f"{count} numbers above 0")


def _measure_reaches(clip: Clip, goals: Sequence[Goal], moving: IntArray) -> list[float]:
    reaches = [limb_length(clip.skeleton, clip.translations, goal, moving) for goal in goals]
    # A goal at the very joint that turns: its place cannot move, only its orientation counts.
    return [reach or clip.skeleton.height or 1.0 for reach in reaches]


def _unmet_frames(objective: Objective, distance: float, angle: float) -> IntArray:
    """List the frames where a goal is not met or a limit is broken."""
    coordinates = objective.coordinates
    clip = coordinates.clip
    pose = pose_skeleton(clip.skeleton, clip.rotations, clip.translations)
    distances, angles = goal_errors(objective.goals, pose)
    unmet = ((distances > distance) | (angles > angle)).any(axis=1)
    lower, upper = coordinates.bounds(np.arange(clip.frame_count))
    # Rounding leaves the angles of a pose on its limit a hair outside.
    broken = ((lower > _ROUNDING) | (upper < -_ROUNDING)).any(axis=(1, 2))
    return np.flatnonzero(unmet | broken)


def _turn_joints(coordinates: Coordinates, values: FloatArray) -> FloatArray:
    """Give the joints' rotations, [F, N, 4]; where nothing has changed the given ones bit for bit."""
    given = coordinates.clip.rotations[:, coordinates.joints]
    found = coordinates.rotations(values, np.arange(len(values)))
    found = np.where(np.sum(found * given, axis=-1, keepdims=True) < 0.0, -found, found)
    return np.where((values != 0.0).any(axis=2, keepdims=True), found, given)
