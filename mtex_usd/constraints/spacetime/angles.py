"""Ranges of a joint's angles: how far past an end each is, with derivatives."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from mtex_usd.constraints.spacetime.rows import Table
from mtex_usd.constraints.spacetime.samples import State
from mtex_usd.constraints.spacetime.turning import to_matrix
from mtex_usd.motion import quaternion
from mtex_usd.motion.skeleton import FloatArray, IntArray

__all__ = ["RangeTable"]

_LOCK_DAMPING = 1e-6  # keeps the derivative finite at gimbal lock, where two of the axes are one


@dataclass(frozen=True, eq=False, kw_only=True)
class RangeTable(Table):
    """How far angles of one joint are past ends of their ranges; N frames times E ends.

    The angles are those of W · (R_rest⁻¹ · R) · W⁻¹, which turns about the skeleton's axes on every rig (W is the
    joint's orientation at rest), or about other axes where `axes` says so.

    Parameters
    ----------
    info
        The rows, [N E].
    clip, joint
        Which joint of which character.
    at
        Positions of the frames among those evaluated, [N].
    axes
        Orientation of the axes in skeleton space at rest, matrix [3, 3].
    order
        Intrinsic order of the rotations, such as ``"XYZ"``.
    middle
        Angles about x, y and z that are certainly within, radians, [3].
    axis
        Which angle each end is of, [E].
    sign
        1 where the angle shall not be above the end or shall be at it, -1 where not below, [E].
    bound
        The ends, radians, [E].
    """

    clip: int
    joint: int
    at: IntArray
    axes: FloatArray
    order: str
    middle: FloatArray
    axis: IntArray
    sign: FloatArray
    bound: FloatArray

    def residual(self, state: State) -> FloatArray:
        """Values in radians, [N E]."""
        return np.asarray(self.sign * (self._angles(state)[:, self.axis] - self.bound)).ravel()

    def jacobian(self, state: State) -> FloatArray:
        """Derivatives [N E, C]."""
        out = np.zeros((len(self.at), len(self.axis), state.observer.column_count))
        character = state.poses[self.clip].character
        if self.joint in character.turning:
            slot = np.array([character.turning.index(self.joint)])
            by_vector = self._rates(state) @ state.poses[self.clip].jacobians[self.at, slot[0]]
            out[:, :, character.rotation_columns(slot)] = self.sign[:, None] * by_vector[:, self.axis]
        return out.reshape(-1, state.observer.column_count)

    def _axes(self, state: State) -> FloatArray:
        """The joint's orientation at rest, seen in the axes that the angles are about, [3, 3]."""
        return self.axes.T @ to_matrix(state.poses[self.clip].character.clip.skeleton.rest_orientations[self.joint])

    def _turns(self, state: State) -> FloatArray:
        """Rotations from rest in the skeleton's axes, [N, 3, 3]."""
        axes = self._axes(state)
        rest = to_matrix(state.poses[self.clip].character.clip.skeleton.rest_rotations[self.joint])
        return np.asarray(axes @ rest.T @ state.poses[self.clip].local[self.at, self.joint] @ axes.T)

    def _angles(self, state: State) -> FloatArray:
        """Angles about x, y and z, radians, [N, 3]: of the two ways to read a rotation the one nearer the middle."""
        found = quaternion.from_usd_matrix(_as_usd(self._turns(state)))
        angles = np.radians(quaternion.to_euler(found, self.order))
        outer, inner = ["XYZ".index(letter) for letter in self.order[::2]], "XYZ".index(self.order[1])
        other = np.array(angles)
        other[:, outer] += np.pi
        other[:, inner] = np.pi - angles[:, inner]
        one, two = _nearest_turn(angles, self.middle), _nearest_turn(other, self.middle)
        nearer = _square(one - self.middle) <= _square(two - self.middle)
        return np.where(nearer[:, None], one, two)

    def _rates(self, state: State) -> FloatArray:
        """Change of the angles by turns in the joint's own axes, [N, 3, 3]."""
        angles = self._angles(state)
        letters = ["XYZ".index(letter) for letter in self.order]
        second, third = (_about(letter, angles[:, letter]) for letter in letters[1:])
        axes = np.eye(3)[letters]
        turning = np.stack(
            [
                np.swapaxes(second @ third, -1, -2) @ axes[0],
                np.swapaxes(third, -1, -2) @ axes[1],
                np.broadcast_to(axes[2], (len(angles), 3)),
            ],
            axis=-1,
        )
        square = np.swapaxes(turning, -1, -2) @ turning + _LOCK_DAMPING**2 * np.eye(3)
        by_letter = np.linalg.solve(square, np.swapaxes(turning, -1, -2)) @ self._axes(state)
        out = np.empty_like(by_letter)
        out[:, letters] = by_letter
        return out


def _as_usd(matrices: FloatArray) -> FloatArray:
    """Rotation matrices for column vectors [N, 3, 3] as USD's for row vectors, [N, 4, 4]."""
    out = np.tile(np.eye(4), (len(matrices), 1, 1))
    out[:, :3, :3] = np.swapaxes(matrices, -1, -2)
    return out


def _about(axis: int, angles: FloatArray) -> FloatArray:
    vectors = np.zeros((len(angles), 3))
    vectors[:, axis] = angles
    return np.asarray(Rotation.from_rotvec(vectors).as_matrix())


def _nearest_turn(angles: FloatArray, middle: FloatArray) -> FloatArray:
    return np.asarray(angles - 2.0 * np.pi * np.round((angles - middle) / (2.0 * np.pi)))


def _square(v: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("...i,...i->...", v, v))
