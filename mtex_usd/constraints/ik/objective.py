"""What the solver makes small, per frame: the goals' errors, weighed so heavily that they vanish, and the change.

f(v) = sum of w^2 |error|^2 / (2 e^2) + sum of c |v|^2 / 2, with errors in lengths of the limb or radians and changes v
in radians. The minimum misses a goal that can be reached by about e^2 of the limb's length, some micrometres on a
person.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.ik.coordinates import Coordinates
from mtex_usd.constraints.ik.goals import Goal
from mtex_usd.constraints.ik.turns import inverse_left_jacobian, square_curvature
from mtex_usd.constraints.kinematics import Pose, pose_skeleton, turn_columns
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["Aim", "Model", "Objective", "limb_length"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

_GUIDANCE = 0.3  # what the way from the guide counts beside the change


@dataclass(frozen=True, eq=False, kw_only=True)
class Aim:
    """How hard the goals are pursued at each frame.

    Parameters
    ----------
    softness
        The e of the objective, shape [F].
    shift
        Place, in lengths of the limb, and orientation, radians, that each goal is aimed beyond itself, shape [F, G, 6].
    """

    softness: FloatArray
    shift: FloatArray

    @classmethod
    def straight(cls, softness: FloatArray, goals: int) -> "Aim":
        """Aim at the goals themselves."""
        return cls(softness=softness, shift=np.zeros((len(softness), goals, 6)))

    def harden(self, errors: FloatArray, softness: FloatArray) -> "Aim":
        """Go on with another softness and the same pull; errors [F, G, 6] as :meth:`Objective.errors` gives them."""
        ratio = np.square(softness / self.softness)[:, None, None]
        return Aim(softness=softness, shift=(errors + self.shift) * ratio)


@dataclass(frozen=True, eq=False, kw_only=True)
class Model:
    """The objective near some values: f + g·s + s·H s / 2 over steps s, C = 3 N coordinates.

    Parameters
    ----------
    value
        The objective f there, shape [F].
    gradient
        Its slope g, shape [F, C].
    hessian
        Its bend H with the curvature of the goals' places, shape [F, C, C]; where they are far inside a limb's reach it
        may bend downward.
    """

    value: FloatArray
    gradient: FloatArray
    hessian: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Objective:
    """The objective of some frames of a clip.

    Parameters
    ----------
    coordinates
        What may move.
    goals
        What is wanted.
    reaches
        Length of the limb that each goal is measured by, skeleton units, length G.
    costs
        What the change of each joint costs, shape [N].
    guide
        Values to stay near of, for all frames of the clip, shape [F, N, 3]; None for none.
    """

    coordinates: Coordinates
    goals: Sequence[Goal]
    reaches: Sequence[float]
    costs: FloatArray
    guide: FloatArray | None = None

    def pose(self, values: FloatArray, frames: IntArray) -> Pose:
        """Place the joints at some values [F, N, 3]."""
        clip = self.coordinates.clip
        rotations = np.array(clip.rotations[frames])
        rotations[:, self.coordinates.joints] = self.coordinates.rotations(values, frames)
        return pose_skeleton(clip.skeleton, rotations, clip.translations[frames])

    def errors(self, values: FloatArray, frames: IntArray) -> FloatArray:
        """Give the goals' errors, lengths of the limb and radians, [F, N, 3] to [F, G, 6]; 0 while a goal is idle."""
        return self._errors_of(self.pose(values, frames), frames)

    def value(self, values: FloatArray, frames: IntArray, aim: Aim) -> FloatArray:
        """Give f at some values, [F, N, 3] to [F]."""
        return self._value_of(values, self.errors(values, frames), frames, aim)

    def model(self, values: FloatArray, frames: IntArray, aim: Aim) -> Model:
        """Approximate f near some values [F, N, 3]."""
        pose = self.pose(values, frames)
        errors = self._errors_of(pose, frames)
        axes = self.coordinates.axes(values, frames, pose)
        gradient, hessian = self._change_terms(values, frames)
        shares = _pair_shares(self.coordinates.limited)
        for number, (goal, reach) in enumerate(self._goals_at(frames)):
            stiffness = np.square(goal.weight / aim.softness)
            moves, turns = self._columns(goal, pose, axes)
            slope, bend = _place_terms(errors[:, number, :3] + aim.shift[:, number, :3], turns, moves / reach, shares)
            if goal.orientation is not None:
                turn = _turn_terms(errors[:, number, 3:], aim.shift[:, number, 3:], turns, shares)
                slope, bend = slope + turn[0], bend + turn[1]
            gradient += stiffness[:, None] * slope
            hessian += stiffness[:, None, None] * bend
        return Model(value=self._value_of(values, errors, frames, aim), gradient=gradient, hessian=hessian)

    def _errors_of(self, pose: Pose, frames: IntArray) -> FloatArray:
        goals = self._goals_at(frames)
        errors = [
            np.concatenate([goal.place_error(pose) / reach, goal.turn_error(pose)], axis=1) for goal, reach in goals
        ]
        return np.stack(errors, axis=1)

    def _value_of(self, values: FloatArray, errors: FloatArray, frames: IntArray, aim: Aim) -> FloatArray:
        change = 0.5 * np.einsum("fnk,n->f", np.square(values), self.costs)
        if self.guide is not None:
            change += 0.5 * _GUIDANCE * np.einsum("fnk,n->f", np.square(values - self.guide[frames]), self.costs)
        weights = np.square([goal.weight for goal in self.goals])
        miss = np.einsum("fgk,g->f", np.square(errors + aim.shift), weights)
        return np.asarray(change + 0.5 * miss / np.square(aim.softness))

    def _goals_at(self, frames: IntArray) -> list[tuple[Goal, float]]:
        return [(goal.at_frames(frames), reach) for goal, reach in zip(self.goals, self.reaches, strict=True)]

    def _change_terms(self, values: FloatArray, at: IntArray) -> tuple[FloatArray, FloatArray]:
        """Gradient and Hessian of the change's cost, [F, C] and [F, C, C]."""
        frames, joints, _ = values.shape
        blocks = self.costs[:, None, None] * self.coordinates.curvature(values)
        gradient = self.costs[:, None] * values
        if self.guide is not None:
            change = self.coordinates.change(values)
            away = np.einsum("fnij,fni->fnj", change, values - self.guide[at])
            gradient = gradient + _GUIDANCE * self.costs[:, None] * away
            blocks = blocks + _GUIDANCE * self.costs[:, None, None] * (np.swapaxes(change, -1, -2) @ change)
        hessian = np.zeros((frames, joints, 3, joints, 3))
        each = np.arange(joints)
        hessian[:, each, :, each, :] = np.swapaxes(blocks, 0, 1)
        return gradient.reshape(frames, -1), hessian.reshape(frames, 3 * joints, 3 * joints)

    def _columns(self, goal: Goal, pose: Pose, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give how the goal's point moves and its joint turns per step, both [F, 3, C]; 0 while it is idle."""
        joints = self.coordinates.joints
        above = np.isin(joints, self.coordinates.clip.skeleton.chain(goal.joint))
        held = (goal.is_active()[:, None] & above)[..., None, None]
        turning = np.where(held, axes, 0.0)
        flat = turning.reshape(len(turning), -1, 3)
        pivots = np.repeat(pose.positions[:, joints], 3, axis=1)
        moves = turn_columns(flat, pivots, pose.place(goal.joint, goal.point))
        return moves, np.swapaxes(flat, 1, 2)


def _place_terms(
    error: FloatArray, turns: FloatArray, moves: FloatArray, shares: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """First and second derivative of |error|^2 / 2 of a place."""
    return _times(error, moves), _squares(moves) + _pair_curvature(error, turns, moves, shares)


def _turn_terms(
    error: FloatArray, shift: FloatArray, turns: FloatArray, shares: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """First and second derivative of |error + shift|^2 / 2 of an orientation; the second where the shift is small."""
    pull = np.einsum("fij,fi->fj", inverse_left_jacobian(error), error + shift)
    bend = np.swapaxes(turns, 1, 2) @ square_curvature(error) @ turns
    return _times(pull, turns), bend + _pair_curvature(0.5 * pull, turns, turns, shares)


def _times(error: FloatArray, columns: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("fi,fic->fc", error, columns))


def _squares(columns: FloatArray) -> FloatArray:
    return np.asarray(np.swapaxes(columns, 1, 2) @ columns)


def _pair_curvature(error: FloatArray, turns: FloatArray, moves: FloatArray, shares: FloatArray) -> FloatArray:
    """Second derivative of a place times the error, [F, 3], [F, 3, C] twice to [F, C, C].

    A step about axis b, and then one about axis a above it, moves the point by a x (b x r): times the error that is
    (error x a)·(b x r). Of an orientation it is half of (error x a)·b (Baker, Campbell and Hausdorff).
    """
    pairs = shares * (np.cross(error[:, None], np.swapaxes(turns, 1, 2)) @ moves)
    return np.asarray(pairs + np.swapaxes(pairs, 1, 2))


def _pair_shares(limited: BoolArray) -> FloatArray:
    """Give which of the two orders of each pair of coordinates counts, shape [C, C].

    The order of the chain, except that the three coordinates of a joint without limits have none and share it.
    """
    shares = np.triu(np.ones((3 * len(limited),) * 2)) - 0.5 * np.eye(3 * len(limited))
    for joint in np.flatnonzero(~limited):
        own = slice(3 * joint, 3 * joint + 3)
        shares[own, own] = 0.5
    return np.asarray(shares)


def limb_length(skeleton: Skeleton, translations: FloatArray, goal: Goal, joints: IntArray) -> float:
    """Give the length of the bones between the topmost moving joint and the goal's point, skeleton units."""
    chain = skeleton.chain(goal.joint)
    moving = [place for place, joint in enumerate(chain) if joint in joints]
    if not moving:
        return 0.0
    below = chain[moving[0] + 1 :]
    bones = np.linalg.norm(translations[:, below], axis=-1).sum(axis=1)
    return float(np.median(bones)) + float(np.linalg.norm(goal.point))
