"""A clip as channels to be reduced, sampled at frames and, where it bends sharply, between them.

Between frames the motion is what UsdSkel plays: the shortest slerp, translations on a line.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.curve_space import choose_order
from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import (
    Channel,
    to_skeleton_rotations,
    to_skeleton_translations,
    unrolled_angles,
)
from mtex_usd.motion.clip import Clip

__all__ = ["ChannelSamples", "angles_to_turns", "play_between", "sample_channels", "slerp"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

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
        All three unrolled angles of these joints, degrees, shape [T, 3] each.
    values
        The channels' curves, degrees and stage units, shape [C, T].
    """

    source: Clip
    clip: Clip
    per_frame: int
    channels: tuple[Channel, ...]
    orders: Mapping[int, str]
    angles: Mapping[int, FloatArray]
    values: FloatArray

    def at_frames(self) -> "ChannelSamples":
        """Give the samples at whole frames alone."""
        step = self.per_frame
        angles = {joint: angles[::step] for joint, angles in self.angles.items()}
        values = np.ascontiguousarray(self.values[:, ::step])
        return replace(self, clip=self.source, per_frame=1, angles=angles, values=values)

    def take(self, times: IntArray) -> "ChannelSamples":
        """Give some of the samples alone; the clip's time codes then say nothing."""
        clip = replace(
            self.clip,
            rotations=self.clip.rotations[times],
            translations=self.clip.translations[times],
            scales=self.clip.scales[times],
        )
        angles = {joint: angles[times] for joint, angles in self.angles.items()}
        return replace(self, clip=clip, angles=angles, values=self.values[:, times])


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
    turned = to_skeleton_rotations(played.rotations, clip.skeleton)
    offsets = to_skeleton_translations(played.translations, clip.skeleton)
    joints = sorted({channel.joint for channel in channels if channel.is_rotation})
    if orders is None:
        orders = {joint: choose_order(clip, joint, turned[:, joint]) for joint in joints}
    angles = {joint: unrolled_angles(turned[:, joint], orders[joint]) for joint in joints}
    values = [
        angles[channel.joint][:, channel.axis] if channel.is_rotation else offsets[:, channel.joint, channel.axis]
        for channel in channels
    ]
    stacked = np.stack(values) if values else np.empty((0, played.frame_count))
    return ChannelSamples(clip, played, per_frame, channels, orders, angles, stacked)


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
        About x, y and z in degrees, shape [T, 3].
    order
        Intrinsic order, such as ``ZYX``.
    """
    half = np.radians(0.5 * angles)
    result = np.zeros((len(angles), 4))
    result[:, 0] = 1.0
    for axis in ("XYZ".index(letter) for letter in order):
        cosine, sine = np.cos(half[:, axis]), np.sin(half[:, axis])
        w, along = result[:, 0].copy(), result[:, 1 + axis].copy()
        b, c = 1 + (axis + 1) % 3, 1 + (axis + 2) % 3
        second, third = result[:, b].copy(), result[:, c].copy()
        result[:, 0], result[:, 1 + axis] = w * cosine - along * sine, along * cosine + w * sine
        result[:, b], result[:, c] = second * cosine + third * sine, third * cosine - second * sine
    return result
