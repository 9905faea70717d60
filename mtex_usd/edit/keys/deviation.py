"""How far a motion is off when its channels are: angles of joints and places of joints, to first order.

A channel turns its joint about an axis, or moves it along one, and everything below with it. The axes are those of the
original motion, so for the small errors that key reduction allows a sum of cross products tells them, and the same
sums run backward tell which channels are to blame.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.keys.body import cross, rotate
from mtex_usd.edit.keys.sampled import ChannelSamples
from mtex_usd.edit.keys.tolerance import Tolerance
from mtex_usd.edit.keys.tree import add_up, find_carried
from mtex_usd.motion.channels import KINDS

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["Deviation", "make_deviation"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

_PRECISION = np.float32  # for speed: limits are passed by more than its last digits
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
        Joint positions in skeleton axes, from the first joint on, shape [J, 3, T].
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
    def _carried(self) -> "csr_array":
        return find_carried(self.samples.body.parents, _PRECISION)

    @cached_property
    def _of_kind(self) -> list[tuple[IntArray, IntArray, FloatArray]]:
        """The channels of each kind, their joints and axes: no joint is twice in one."""
        groups = []
        for kind in KINDS:
            members = [number for number, channel in enumerate(self.samples.channels) if channel.kind == kind]
            groups.append((np.array(members, dtype=np.intp), self._joints[members], self.axes[members]))
        return groups

    def _sum_up(self, errors: FloatArray, kinds: slice) -> FloatArray:
        """Sum up what the errors of some kinds of channels do to their own joints, [C, T] to [J, 3, T]."""
        sums = np.zeros(self.places.shape, dtype=errors.dtype)
        for members, joints, axes in self._of_kind[kinds]:
            if len(joints) == len(sums):
                sums += axes * errors[members, None]
            elif len(joints):
                sums[joints] += axes * errors[members, None]
        return sums

    def propagate(self, errors: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give what errors of channels [C, T] do: each joint's own turn and its way off, both [J, 3, T]."""
        errors = errors.astype(self.axes.dtype)
        turns, moves = self._sum_up(errors, slice(0, 3)), self._sum_up(errors, slice(3, 6))
        # A turn about one place is the same turn about the origin and a move: both simply add up.
        totals, moves = add_up(self._carried, turns, moves - cross(turns, self.places))
        return turns, moves + cross(totals, self.places)

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
        errors = errors.astype(turns.dtype)
        blame = np.zeros_like(errors)
        self._blame_turns(blame, errors, _passed(turns, self.limits[0] * allowed), turns)
        passed = _passed(shifts, self.limits[1] * allowed)
        frames = np.flatnonzero(passed.any(axis=0))
        if frames.size:
            self._blame_places(blame, errors, passed[:, frames], shifts[..., frames], frames)
        return blame

    @cached_property
    def _turning_of(self) -> IntArray:
        """The channels that turn each joint, one of them again where there are fewer than three, -1 without, [J, 3]."""
        table = np.full((len(self.places), 3), -1, dtype=np.intp)
        # The first one everywhere, then each in its own column.
        for number in np.flatnonzero(self._turning)[::-1].tolist():
            table[self._joints[number]] = number
        for number in np.flatnonzero(self._turning).tolist():
            table[self._joints[number], self.samples.channels[number].axis] = number
        return table

    def _blame_turns(self, blame: FloatArray, errors: FloatArray, passed: FloatArray, turns: FloatArray) -> None:
        joints, frames = np.nonzero(passed)
        members = self._turning_of[joints]
        ways = np.einsum("pci,pi->pc", self.axes[members, :, frames[:, None]], turns[joints, :, frames])
        shares = errors[members, frames[:, None]] * ways
        guilty = shares >= _BLAMED * shares.max(axis=1, keepdims=True, initial=0.0)
        cases, numbers = np.nonzero(guilty)
        blame[members[cases, numbers], frames[cases]] = passed[joints, frames][cases]

    def _blame_places(
        self, blame: FloatArray, errors: FloatArray, passed: FloatArray, shifts: FloatArray, frames: IntArray
    ) -> None:
        """Let every joint that is too far off pull; who moves along with the pull is to blame."""
        places, pulls = self.places[..., frames], shifts * np.sqrt(passed)[:, None]
        force, torque = add_up(self._carried.T, pulls, cross(places, pulls))
        torque -= cross(places, force)
        pull = np.where(self._turning[:, None, None], torque[self._joints], force[self._joints])
        shares = errors[:, frames] * np.einsum("cit,cit->ct", self.axes[..., frames], pull)
        largest = shares.max(axis=0)
        guilty = (shares >= _BLAMED * largest) & (largest > 0.0)
        blame[:, frames] = np.maximum(blame[:, frames], guilty * passed.max(axis=0))


def make_deviation(samples: ChannelSamples, tolerance: Tolerance) -> Deviation:
    """Build the model of a motion.

    Parameters
    ----------
    samples
        The motion and its channels.
    tolerance
        What it may be off by.
    """
    body, parents = samples.body, samples.body.parents
    axes = _own_axes(samples)
    joints = np.array([channel.joint for channel in samples.channels], dtype=np.intp)
    below = np.flatnonzero(parents[joints] >= 0)
    axes[below] = rotate(body.total_turns[parents[joints[below]]], axes[below])
    axes[[channel.is_rotation for channel in samples.channels]] *= np.radians(1.0)
    places = body.places - body.places[:1]
    limits = np.radians(tolerance.degrees), tolerance.metres / samples.clip.skeleton.meters_per_unit
    return Deviation(samples, axes.astype(_PRECISION), places.astype(_PRECISION), limits)


def _own_axes(samples: ChannelSamples) -> FloatArray:
    """Axes of the channels in skeleton axes, as they are where the parents are at rest, [C, 3, T]."""
    turned = np.empty((len(samples.joints), 3, 3, samples.values.shape[1]))
    for order, members in samples.by_order.items():
        turned[members] = _euler_axes(samples.angles[members], order)
    place = {joint: number for number, joint in enumerate(samples.joints)}
    axes = np.empty((len(samples.channels), 3, samples.values.shape[1]))
    for number, channel in enumerate(samples.channels):
        axes[number] = (
            turned[place[channel.joint], channel.axis] if channel.is_rotation else np.eye(3)[channel.axis, :, None]
        )
    return axes


def _euler_axes(angles: FloatArray, order: str) -> FloatArray:
    """Axes x, y and z of joints [K, 3, T] of one Euler order, [K, 3, 3, T]."""
    first, second, third = ("XYZ".index(letter) for letter in order)
    axes = np.zeros((len(angles), 3, *angles.shape[1:]))
    # The outermost axis stands still, the next is turned by the first angle and the last by both.
    axes[:, first, first] = 1.0
    cosine, sine = np.cos(np.radians(angles[:, first])), np.sin(np.radians(angles[:, first]))
    sign = 1.0 if (second - first) % 3 == 1 else -1.0
    axes[:, second, second], axes[:, second, third] = cosine, sign * sine
    tilt, lift = np.cos(np.radians(angles[:, second])), np.sin(np.radians(angles[:, second]))
    axes[:, third, third], axes[:, third, second] = tilt * cosine, -sign * tilt * sine
    axes[:, third, first] = sign * lift
    return axes


def _passed(vectors: FloatArray, limits: FloatArray) -> FloatArray:
    """Squares of how many times limits [T] are passed by vectors [J, 3, T], 0 where they are not, [J, T]."""
    ratios = np.einsum("jit,jit->jt", vectors, vectors)
    ratios /= np.square(limits).astype(ratios.dtype)
    return np.asarray(np.where(ratios > 1.0, ratios, ratios.dtype.type(0.0)))
