"""Making a motion keep its contacts: feet restored under a pelvis that was synthesized, then held exactly.

Pullen & Bregler 2002, section 4.1, synthesize pelvis and upper body first, bring the feet back by inverse kinematics,
and texture the legs only in the air; hard constraints are their open drawback. Here the whole motion is solved for at
once (Gleicher 2000, section 1.7.2).
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.ik import solve_two_bone
from mtex_usd.constraints.kinematics import place_points
from mtex_usd.constraints.planting.limits import JointRange, to_ranges
from mtex_usd.constraints.planting.plan import Hold, find_limb, to_constraints
from mtex_usd.constraints.spacetime import Solution, solve_spacetime
from mtex_usd.errors import NoSolutionError
from mtex_usd.motion import quaternion
from mtex_usd.motion.anatomy import SIDES, find_anatomy
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["Held", "hold_motion", "restore_feet"]

# The root's way is the animator's: a change of it counts three times what a turn that moves the feet as far does.
_ROOT_WEIGHT = 3.0

# At high rates the weight of the second derivative stiffens the problem until the search stalls; a tenth leaves 2 % of
# the change's energy above its frequency instead of 1 %.
_FAST = 40.0
_SMOOTHNESS, _SMOOTHNESS_FAST = 30.0, 3.0

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class Held:
    """A motion that keeps what it was told to hold.

    Parameters
    ----------
    clip
        The motion.
    solution
        What is known of the solve; None where there was nothing to hold.
    """

    clip: Clip
    solution: Solution | None


def hold_motion(
    clip: Clip, holds: Sequence[Hold], *, frequency: float = 6.0, limits: Sequence[JointRange] = ()
) -> Held:
    """Change a motion as little as it takes to hold points.

    Parameters
    ----------
    clip
        The motion.
    holds
        What is to be held.
    frequency
        The highest frequency of the change, Hz.
    limits
        How far joints may turn; where the motion turns them farther itself, as far as that.

    Raises
    ------
    NoSolutionError
        Where the holds cannot be met together; names those that fight.
    """
    if not holds:
        return Held(clip=clip, solution=None)
    try:
        solution = _solve(clip, holds, frequency, limits)
    except NoSolutionError as error:
        message = f"{clip.name}: {error.message}" if clip.name else error.message
        raise NoSolutionError(message, expected=error.expected, found=error.found, fix=error.fix) from error
    return Held(clip=solution.clips[0], solution=solution)


def _solve(clip: Clip, holds: Sequence[Hold], frequency: float, limits: Sequence[JointRange]) -> Solution:
    return solve_spacetime(
        clip,
        [*to_constraints(holds, clip), *to_ranges(clip, limits, _moving(clip.skeleton, holds))],
        frequency=frequency,
        joint_weights=dict.fromkeys(_pelvis_joints(clip.skeleton), np.inf),
        translation_weight=_ROOT_WEIGHT,
        smoothness=_SMOOTHNESS if clip.rate <= _FAST else _SMOOTHNESS_FAST,
    )


def _moving(skeleton: Skeleton, holds: Sequence[Hold]) -> set[int]:
    """Joints that can be turned to hold something."""
    return {joint for hold in holds for joint in skeleton.chain(hold.joint)}


def _pelvis_joints(skeleton: Skeleton) -> list[str]:
    """Paths of the joints between hips and thighs, which are parts of the pelvis and do not move on a body."""
    anatomy = find_anatomy(skeleton)
    parts = {} if anatomy is None else anatomy.parts
    thighs = [parts[f"{side}.thigh"] for side in SIDES if f"{side}.thigh" in parts]
    above = {joint for thigh in thighs for joint in skeleton.chain(thigh)[:-1]}
    return [skeleton.joints[joint] for joint in sorted(above - set(skeleton.chain(parts.get("hips", 0))))]


def restore_feet(
    clip: Clip, sketch: Clip, holds: Sequence[Hold], *, kept: Collection[int] = (), carrier: int | None = None
) -> Clip:
    """Bring the feet back to where the sketch has them, under a pelvis that moves otherwise.

    Parameters
    ----------
    clip
        What was made of the sketch, on the same skeleton.
    sketch
        The sketch.
    holds
        Only legs of which something is held are touched.
    kept
        Joints whose motion was filled in; legs with one of them have no place to be brought back to.
    carrier
        The joint whose way along the ground was filled in: the feet go with it, for they cannot be left behind. None
        where the way is the sketch's.

    Returns
    -------
    Clip
        The sketch's legs come to the sketch's feet by the analytic solution; what was added to the legs comes on top.
    """
    result, way = clip, np.zeros(3) if carrier is None else _level_way(clip, sketch, carrier)
    for upper, middle, end in _held_legs(clip.skeleton, holds):
        limb = find_limb(clip.skeleton, end)
        if not set(limb) & set(kept):
            result = _restore_leg(result, sketch, (upper, middle, end), limb, way)
    return result


def _level_way(clip: Clip, sketch: Clip, carrier: int) -> FloatArray:
    """How far along the ground a joint is from where the sketch has it, skeleton space, shape [F, 3]."""
    origins = np.zeros((1, 3))
    places = [place_points(c.skeleton, [carrier], origins, c.rotations, c.translations)[:, 0] for c in (clip, sketch)]
    way, up = places[0] - places[1], sketch.skeleton.up
    return np.asarray(way - (way @ up)[:, None] * up)


def _held_legs(skeleton: Skeleton, holds: Sequence[Hold]) -> list[tuple[int, int, int]]:
    """Thigh, shin and foot of the legs of which something is held."""
    anatomy = find_anatomy(skeleton)
    parts = anatomy.parts if anatomy is not None else {}
    legs = [[parts.get(f"{side}.{part}") for part in ("thigh", "shin", "foot")] for side in SIDES]
    whole = [(leg[0], leg[1], leg[2]) for leg in legs if None not in leg]
    held = {joint for hold in holds for joint in find_limb(skeleton, hold.joint)}
    return [(a, b, c) for a, b, c in whole if a is not None and b is not None and c is not None and c in held]


def _restore_leg(clip: Clip, sketch: Clip, leg: tuple[int, int, int], limb: Sequence[int], way: FloatArray) -> Clip:
    """Restore one leg; `leg` its thigh, shin and foot, `limb` all its joints, `way` [F, 3] what the feet go along."""
    places, world = sketch.skeleton.world_pose(sketch.rotations, sketch.translations)
    joints = list(limb)
    detail = quaternion.multiply(quaternion.conjugate(sketch.rotations[:, joints]), clip.rotations[:, joints])
    plain = np.array(clip.rotations)
    plain[:, joints] = sketch.rotations[:, joints]
    upper, middle, end = leg
    base = solve_two_bone(
        replace(clip, rotations=plain),
        upper=upper,
        middle=middle,
        end=end,
        place=places[:, end] + way,
        orientation=world[:, end],
    ).clip
    rotations = np.array(base.rotations)
    rotations[:, joints] = quaternion.multiply(rotations[:, joints], detail)
    return replace(clip, rotations=rotations)
