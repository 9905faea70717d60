"""A clip as channels to be reduced, sampled at frames and, where it bends sharply, between them.

Between frames the motion is what UsdSkel plays: the shortest slerp, translations on a line.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.curve_space import choose_order
from mtex_usd.edit.keys.body import Body, read_body
from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import Channel, choose_euler_order, to_skeleton_translations, unrolled_angles
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.facing import find_root

__all__ = ["ChannelSamples", "angles_to_turns", "play_between", "sample_channels", "slerp", "turns_to_angles"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

_LEAPING = 90.0  # degrees from one sample to the next: the angles have to be unrolled
_NO_ANGLE = 1e-7  # radians: slerp is a line


@dataclass(frozen=True, eq=False)
class ChannelSamples:
    """The channels that are reduced, and the motion they are of.

    Parameters
    ----------
    source
        The clip.
    clip
        The clip at all samples, its rate that of the samples.
    per_frame
        Samples from one frame to the next.
    channels
        The channels, length C.
    orders
        Euler order by joint with rotation channels.
    angles
        All three unrolled angles of these K joints, by their index, degrees, shape [K, 3, T].
    values
        The channels' curves, degrees and stage units, shape [C, T].
    body
        The joints' turns and places.
    """

    source: Clip
    clip: Clip
    per_frame: int
    channels: tuple[Channel, ...]
    orders: Mapping[int, str]
    angles: FloatArray
    values: FloatArray
    body: Body

    def at_frames(self) -> "ChannelSamples":
        """Give the samples at whole frames alone."""
        frames = np.arange(0, self.values.shape[1], self.per_frame)
        values, angles = (np.ascontiguousarray(part[..., frames]) for part in (self.values, self.angles))
        body = self.body.take(frames)
        return replace(self, clip=self.source, per_frame=1, angles=angles, values=values, body=body)

    @cached_property
    def joints(self) -> list[int]:
        """The joints with rotation channels, length K."""
        return sorted(self.orders)

    @cached_property
    def by_order(self) -> dict[str, list[int]]:
        """Which of these joints, counted from 0 to K - 1, have which Euler order."""
        found: dict[str, list[int]] = {}
        for number, joint in enumerate(self.joints):
            found.setdefault(self.orders[joint], []).append(number)
        return found

    def turn_by(self, values: FloatArray, numbers: IntArray) -> FloatArray:
        """Give the turns of N of the K joints with rotation channels for other values of these.

        Parameters
        ----------
        values
            Of all channels, shape [C, T].
        numbers
            Which of the joints, from 0 to K - 1, shape [N].

        Returns
        -------
        FloatArray
            Shape [N, 4, T].
        """
        turns = np.empty((len(numbers), 4, values.shape[1]))
        for place, number in enumerate(numbers.tolist()):
            angles = np.array(self.angles[number])
            rows, axes = self._rotations_of[self.joints[number]]
            angles[axes] = values[rows]
            turns[place] = angles_to_turns(angles, self.orders[self.joints[number]])
        return turns

    @cached_property
    def _rotations_of(self) -> dict[int, tuple[list[int], list[int]]]:
        """Rows of each joint's rotation channels, and their axes."""
        found: dict[int, tuple[list[int], list[int]]] = {joint: ([], []) for joint in self.joints}
        for row, channel in enumerate(self.channels):
            if channel.is_rotation:
                found[channel.joint][0].append(row)
                found[channel.joint][1].append(channel.axis)
        return found

    def move_by(self, before: Body, values: FloatArray, changed: BoolArray) -> tuple[Body, BoolArray]:
        """Give the motion for other values of the channels.

        Parameters
        ----------
        before
            The motion it is to be changed from.
        values
            Of all channels, shape [C, T].
        changed
            Which of them are others than before, shape [C].

        Returns
        -------
        tuple of Body and BoolArray
            The motion, and which joints have changed channels, shape [J].
        """
        joints = np.zeros(len(before.parents), dtype=np.bool_)
        joints[[self.channels[row].joint for row in np.flatnonzero(changed).tolist()]] = True
        turns, arms = np.array(before.turns), np.array(before.arms)
        numbers = np.flatnonzero(joints[self.joints])
        turns[np.array(self.joints, dtype=np.intp)[numbers]] = self.turn_by(values, numbers)
        for row, channel in enumerate(self.channels):
            if changed[row] and not channel.is_rotation:
                moved = values[row] - self.values[row]
                arms[channel.joint, channel.axis] = self.body.arms[channel.joint, channel.axis] + moved
        return before.change(joints, turns, arms), joints


def sample_channels(
    clip: Clip, channels: tuple[Channel, ...], per_frame: int, *, orders: Mapping[int, str] | None = None
) -> ChannelSamples:
    """Read channels of a clip.

    Parameters
    ----------
    clip
        The clip.
    channels
        The channels, rotations as Euler angles in skeleton axes, translations from rest on.
    per_frame
        Samples from one frame to the next, 1 or more.
    orders
        Euler order by joint; None chooses those that stay clear of gimbal lock.
    """
    played = play_between(clip, per_frame)
    body = read_body(played)
    joints = sorted({channel.joint for channel in channels if channel.is_rotation})
    turns = body.turns[joints]
    if orders is None:
        orders = _choose_orders(clip, joints, turns[..., ::per_frame])
    angles = _read_angles(turns, [orders[joint] for joint in joints])
    offsets = to_skeleton_translations(played.translations, clip.skeleton)
    values = np.empty((len(channels), played.frame_count))
    for number, channel in enumerate(channels):
        turning = channel.is_rotation
        values[number] = (
            angles[joints.index(channel.joint), channel.axis] if turning else offsets[:, channel.joint, channel.axis]
        )
    return ChannelSamples(clip, played, per_frame, channels, orders, angles, values, body)


def _choose_orders(clip: Clip, joints: Sequence[int], turns: FloatArray) -> dict[int, str]:
    root = find_root(clip)
    return {
        joint: choose_order(clip, joint, turn.T) if joint == root else choose_euler_order(turn.T)
        for joint, turn in zip(joints, turns, strict=True)
    }


def _read_angles(turns: FloatArray, orders: Sequence[str]) -> FloatArray:
    """Unrolled Euler angles of joints, [K, 4, T] to [K, 3, T]."""
    angles = np.empty((len(turns), 3, turns.shape[-1]))
    for number, (turn, order) in enumerate(zip(turns, orders, strict=True)):
        angles[number] = turns_to_angles(turn, order)
    steps = np.abs(np.diff(angles, axis=-1)).max(axis=(1, 2), initial=0.0)
    for number in np.flatnonzero(steps >= _LEAPING).tolist():
        angles[number] = unrolled_angles(np.ascontiguousarray(turns[number].T), orders[number]).T
    return angles


def turns_to_angles(turns: FloatArray, order: str) -> FloatArray:
    """Turn rotations into Euler angles, the inverse of :func:`angles_to_turns`; not unrolled.

    Parameters
    ----------
    turns
        Rotations, shape [4, T].
    order
        Intrinsic order, such as ``ZYX``.

    Returns
    -------
    FloatArray
        About x, y and z in degrees, shape [3, T].

    Notes
    -----
    By half the sum and half the difference of the outer angles (Bernardes & Viollet 2022), which needs no matrix.
    """
    first, second, third = ("XYZ".index(letter) for letter in order)
    sign = 1.0 if (second - first) % 3 == 1 else -1.0
    w, outer, middle, inner = turns[0], turns[1 + first], turns[1 + second], sign * turns[1 + third]
    sums, differences = (outer + inner, w + middle), (outer - inner, w - middle)
    half_sum, half_difference = np.arctan2(*sums), np.arctan2(*differences)
    angles = np.empty((3, turns.shape[1]))
    angles[first] = half_sum + half_difference
    angles[second] = 2.0 * np.arctan2(np.hypot(*sums), np.hypot(*differences)) - 0.5 * np.pi
    angles[third] = sign * (half_sum - half_difference)
    return np.asarray(np.remainder(np.degrees(angles) + 180.0, 360.0) - 180.0)


def play_between(clip: Clip, per_frame: int) -> Clip:
    """Give a clip at several evenly spaced times a frame, between frames as UsdSkel interpolates it.

    Parameters
    ----------
    clip
        The clip.
    per_frame
        How many times a frame; 1 gives the clip as it is.
    """
    if per_frame == 1:
        return clip
    times = np.arange((clip.frame_count - 1) * per_frame + 1)
    before = times // per_frame
    after = np.minimum(before + 1, clip.frame_count - 1)
    part = (times % per_frame / per_frame)[:, None, None]
    return replace(
        clip,
        rate=clip.rate * per_frame,
        time_codes_per_frame=clip.time_codes_per_frame / per_frame,
        rotations=slerp(clip.rotations[before], clip.rotations[after], part[..., 0]),
        translations=(1.0 - part) * clip.translations[before] + part * clip.translations[after],
        scales=(1.0 - part) * clip.scales[before] + part * clip.scales[after],
    )


def slerp(start: FloatArray, end: FloatArray, part: FloatArray) -> FloatArray:
    """Turn from one rotation to another the shortest way, [..., 4], [..., 4] and parts [...] to [..., 4]."""
    cosine = np.einsum("...i,...i->...", start, end)
    angle = np.arccos(np.clip(np.abs(cosine), 0.0, 1.0))
    sine = np.sin(angle)
    near = sine < _NO_ANGLE
    safe = np.where(near, 1.0, sine)
    first = np.where(near, 1.0 - part, np.sin((1.0 - part) * angle) / safe)
    second = np.where(near, part, np.sin(part * angle) / safe) * np.where(cosine < 0.0, -1.0, 1.0)
    return quaternion.normalize(first[..., None] * start + second[..., None] * end)


def angles_to_turns(angles: FloatArray, order: str) -> FloatArray:
    """Turn Euler angles into rotations, ten times as fast as :func:`mtex_usd.motion.quaternion.from_euler`.

    Parameters
    ----------
    angles
        About x, y and z in degrees, shape [3, T].
    order
        Intrinsic order, such as ``ZYX``.

    Returns
    -------
    FloatArray
        Shape [4, T].
    """
    half = np.radians(0.5 * angles)
    cosines, sines = np.cos(half), np.sin(half)
    first, second, third = ("XYZ".index(letter) for letter in order)
    # The product of the first two turns has four terms, one for each component; the third turn mixes them by pairs.
    product = np.empty((4, angles.shape[1]))
    product[0] = cosines[first] * cosines[second]
    product[1 + first] = sines[first] * cosines[second]
    product[1 + second] = cosines[first] * sines[second]
    product[1 + third] = sines[first] * sines[second]
    if (second - first) % 3 != 1:
        product[1 + third] *= -1.0
    turned, crossed = 1 + (third + 1) % 3, 1 + (third + 2) % 3
    result = cosines[third] * product
    result[0] -= sines[third] * product[1 + third]
    result[1 + third] += sines[third] * product[0]
    result[turned] += sines[third] * product[crossed]
    result[crossed] -= sines[third] * product[turned]
    return np.asarray(result)
