"""How far a motion is off when its channels are: angles of joints and places of joints, to first order.

A channel turns its joint about an axis, or moves it along one, and everything below with it. The axes are those of the
original motion, so for the small errors that key reduction allows a sum of cross products tells them, and the same
sums run backward tell which channels are to blame.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.keys.sampled import ChannelSamples
from mtex_usd.edit.keys.tolerance import Tolerance
from mtex_usd.edit.keys.tree import list_levels
from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import KINDS, Channel

__all__ = ["Deviation", "make_deviation"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

_BLAMED = 0.5  # of the largest share


@dataclass(frozen=True, eq=False)
class Deviation:
    """The first-order model of one motion; arrays have the samples last, for speed.

    Parameters
    ----------
    samples
        The motion and its channels.
    axes
        What a degree or a stage unit of each channel turns its joint by, radians, or moves it by, in skeleton space,
        shape [C, 3, T].
    places
        Joint positions in skeleton space, shape [J, 3, T].
    limits
        Largest angle in radians and largest distance in skeleton units.
    """

    samples: ChannelSamples
    axes: FloatArray
    places: FloatArray
    limits: tuple[float, float]

    @cached_property
    def _joints(self) -> IntArray:
        """The joint of every channel, shape [C]."""
        return np.array([channel.joint for channel in self.samples.channels], dtype=np.intp)

    @cached_property
    def _turning(self) -> BoolArray:
        """Which channels turn their joint, shape [C]."""
        return np.array([channel.is_rotation for channel in self.samples.channels], dtype=np.bool_)

    @cached_property
    def _levels(self) -> list[tuple[IntArray, IntArray]]:
        return list_levels(self.samples.clip.parents)

    @cached_property
    def _arms(self) -> FloatArray:
        """From each joint's parent to the joint, shape [J, 3, T]."""
        return np.asarray(self.places - self.places[self.samples.clip.parents])

    @cached_property
    def _of_kind(self) -> list[tuple[IntArray, IntArray]]:
        """The channels of each kind and their joints: no joint is twice in one."""
        groups = []
        for kind in KINDS:
            members = [number for number, channel in enumerate(self.samples.channels) if channel.kind == kind]
            groups.append((np.array(members, dtype=np.intp), self._joints[members]))
        return groups

    def _sum_up(self, errors: FloatArray, kinds: slice) -> FloatArray:
        """Sum up what the errors of some kinds of channels do to their own joints, [C, T] to [J, 3, T]."""
        sums = np.zeros_like(self.places)
        for members, joints in self._of_kind[kinds]:
            sums[joints] += self.axes[members] * errors[members, None]
        return sums

    def propagate(self, errors: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give what errors of channels [C, T] do: each joint's own turn and its way off, both [J, 3, T]."""
        turns, shifts = self._sum_up(errors, slice(0, 3)), self._sum_up(errors, slice(3, 6))
        totals = np.array(turns)
        for joints, parents in self._levels:
            shifts[joints] += shifts[parents] + _cross(totals[parents], self._arms[joints])
            totals[joints] += totals[parents]
        return turns, shifts

    def blame(self, errors: FloatArray, allowed: FloatArray) -> FloatArray:
        """Tell which channels put the motion outside the limits, and how badly.

        Parameters
        ----------
        errors
            Of the channels, shape [C, T].
        allowed
            Part of the limits that may be used at each sample, shape [T].

        Returns
        -------
        FloatArray
            0 where a channel is not to blame, else the square of how many times the limit is passed, shape [C, T].
        """
        turns, shifts = self.propagate(errors)
        angles, ways = _length(turns) / (self.limits[0] * allowed), _length(shifts) / (self.limits[1] * allowed)
        blame = np.zeros_like(errors)
        if (angles > 1.0).any():
            self._blame_turns(blame, errors, np.where(angles > 1.0, angles, 0.0), turns)
        if (ways > 1.0).any():
            self._blame_places(blame, errors, np.where(ways > 1.0, ways, 0.0), shifts)
        return blame

    def _blame_turns(self, blame: FloatArray, errors: FloatArray, passed: FloatArray, turns: FloatArray) -> None:
        for joint in np.flatnonzero(passed.any(axis=1)).tolist():
            members = np.flatnonzero(self._turning & (self._joints == joint))
            shares = errors[members] * np.einsum("cit,it->ct", self.axes[members], turns[joint])
            guilty = shares >= _BLAMED * shares.max(axis=0)
            blame[members] = np.maximum(blame[members], guilty * np.square(passed[joint]))

    def _blame_places(self, blame: FloatArray, errors: FloatArray, passed: FloatArray, shifts: FloatArray) -> None:
        """Let every joint that is too far off pull; who moves along with the pull is to blame."""
        frames = np.flatnonzero(passed.any(axis=0))
        force, torque = self._pull(shifts[..., frames] * passed[:, None, frames], frames)
        pull = np.where(self._turning[:, None, None], torque[self._joints], force[self._joints])
        shares = errors[:, frames] * np.einsum("cit,cit->ct", self.axes[..., frames], pull)
        largest = shares.max(axis=0)
        guilty = (shares >= _BLAMED * largest) & (largest > 0.0)
        blame[:, frames] = np.maximum(blame[:, frames], guilty * np.square(passed[:, frames].max(axis=0)))

    def _pull(self, forces: FloatArray, frames: IntArray) -> tuple[FloatArray, FloatArray]:
        """Sum up forces at joints over everything below each joint: force and torque about it, both [J, 3, N]."""
        force, torque = np.array(forces), np.zeros_like(forces)
        for joints, parents in reversed(self._levels):
            np.add.at(force, parents, force[joints])
            np.add.at(torque, parents, torque[joints] + _cross(self._arms[joints][..., frames], force[joints]))
        return force, torque


def make_deviation(samples: ChannelSamples, tolerance: Tolerance) -> Deviation:
    """Build the model of a motion.

    Parameters
    ----------
    samples
        The motion and its channels.
    tolerance
        What it may be off by.
    """
    skeleton = samples.clip.skeleton
    places, world = skeleton.world_pose(samples.clip.rotations, samples.clip.translations)
    since_rest = quaternion.multiply(world, quaternion.conjugate(skeleton.rest_orientations))
    axes = np.empty((len(samples.channels), 3, samples.clip.frame_count))
    for number, channel in enumerate(samples.channels):
        own = _own_axis(samples, channel)
        parent = int(skeleton.parents[channel.joint])
        turned = own if parent < 0 else quaternion.rotate(since_rest[:, parent], own)
        axes[number] = np.radians(turned.T) if channel.is_rotation else turned.T
    limits = np.radians(tolerance.degrees), tolerance.metres / skeleton.meters_per_unit
    return Deviation(samples, axes, np.ascontiguousarray(np.moveaxis(places, 0, 2)), limits)


def _own_axis(samples: ChannelSamples, channel: Channel) -> FloatArray:
    """Axis of a channel in skeleton axes, as it is where the parent is at rest, [T, 3]."""
    unit = np.broadcast_to(np.eye(3)[channel.axis], (samples.clip.frame_count, 3))
    if not channel.is_rotation:
        return unit
    order = ["XYZ".index(axis) for axis in samples.orders[channel.joint]]
    depth = order.index(channel.axis)
    # The outermost axis stands still; each of the others is turned by those before it.
    for outer in reversed(order[:depth]):
        half = np.radians(0.5 * samples.angles[channel.joint][:, outer])
        turn = np.zeros((len(half), 4))
        turn[:, 0], turn[:, 1 + outer] = np.cos(half), np.sin(half)
        unit = quaternion.rotate(turn, unit)
    return unit


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Cross products along the middle axis, [N, 3, T]."""
    out = np.empty_like(a)
    for first, second, third in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.multiply(a[:, second], b[:, third], out=out[:, first])
        out[:, first] -= a[:, third] * b[:, second]
    return out


def _length(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.einsum("jit,jit->jt", vectors, vectors)))
