"""The space copied motion is blended in (Gleicher 2000, section 1.2.1).

Where all three rotation channels of a joint share their roles they are one rotation vector about the joint's mean pose;
other channels are single curves: Euler angles in the joint's order, or translations. The root's are read in the facing
frame. All rotation curves are in degrees.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import (
    Channel,
    choose_euler_order,
    to_local_rotations,
    to_local_translations,
    unrolled_angles,
)
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.reading import Motion
from mtex_usd.texture.roles import Roles, Span

__all__ = ["Copied", "Space", "choose_orders", "goes_along_ground"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

# An axis nearer to up than this, as a cosine, is the root's height; all others carry some of its way along the ground.
_UPRIGHT = 0.8


@dataclass(frozen=True, eq=False)
class Copied:
    """The part of a motion that is copied.

    Parameters
    ----------
    rotations
        Of the joints copied whole, shape [F, W, 4].
    curves
        Of the other channels, shape [F, C'].
    """

    rotations: FloatArray
    curves: FloatArray


@dataclass(frozen=True, eq=False)
class Space:
    """Which channels are copied, and how.

    Parameters
    ----------
    root
        Index of the root joint.
    whole
        Joints copied as rotations, length W.
    single
        Channels copied as curves of their own, length C'.
    orders
        Euler order by joint, for every joint that is read in angles.
    means
        Mean rotation of each whole joint, shape [W, 4].
    """

    root: int
    whole: tuple[int, ...]
    single: tuple[Channel, ...]
    orders: Mapping[int, str]
    means: FloatArray

    @classmethod
    def of_roles(cls, roles: Roles, root: int, orders: Mapping[int, str]) -> "Space":
        """Sort the copied channels into whole joints and single curves; the means are still identity."""
        whole = tuple(joint for joint in sorted({c.joint for c in roles.copied}) if _is_whole(joint, roles.spans))
        single = tuple(c for c in roles.copied if not (c.is_rotation and c.joint in whole))
        means = np.tile([1.0, 0.0, 0.0, 0.0], (len(whole), 1))
        return cls(root, whole, single, orders, means)

    def centred_on(self, motions: Sequence[Motion]) -> "Space":
        """Give the same space about the mean rotations of some motions."""
        rotations = np.concatenate([motion.rotations[:, self.whole] for motion in motions])
        return replace(self, means=quaternion.mean(rotations)) if self.whole else self

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """The channel of every column of :meth:`to_curves`, length C = 3 W + C'."""
        vectors = tuple(Channel(joint, kind) for joint in self.whole for kind in ("rx", "ry", "rz"))
        return vectors + self.single

    @cached_property
    def turning(self) -> BoolArray:
        """Which single curves are angles, shape [C']."""
        return np.array([channel.is_rotation for channel in self.single], dtype=np.bool_)

    @cached_property
    def sliding(self) -> BoolArray:
        """Which single curves are the root's travel, shape [C']."""
        return np.array([not c.is_rotation and c.joint == self.root for c in self.single], dtype=np.bool_)

    def read(self, motion: Motion) -> Copied:
        """Take out of a motion what is copied."""
        curves = [self.read_channel(motion, channel) for channel in self.single]
        stacked = np.stack(curves, axis=1) if curves else np.empty((motion.clip.frame_count, 0))
        return Copied(motion.rotations[:, self.whole], stacked)

    def read_channel(self, motion: Motion, channel: Channel) -> FloatArray:
        """One channel's curve, degrees or stage units, shape [F]."""
        if channel.is_rotation:
            angles = unrolled_angles(motion.rotations[:, channel.joint], self.orders[channel.joint])
            return angles[:, channel.axis]
        if channel.joint == self.root:
            return motion.travel[:, channel.axis]
        return motion.offsets[:, channel.joint, channel.axis]

    def to_curves(self, copied: Copied) -> FloatArray:
        """Everything copied as curves about the means, shape [F, C]; see :attr:`channels`."""
        relative = quaternion.multiply(quaternion.conjugate(self.means), copied.rotations)
        vectors = np.degrees(quaternion.unroll_vectors(quaternion.log(relative)))
        return np.concatenate([vectors.reshape(len(vectors), -1), copied.curves], axis=1)

    def from_curves(self, curves: FloatArray) -> Copied:
        """Invert :meth:`to_curves`."""
        split = 3 * len(self.whole)
        vectors = np.radians(curves[:, :split]).reshape(len(curves), -1, 3)
        return Copied(quaternion.multiply(self.means, quaternion.exp(vectors)), curves[:, split:])

    def apply(self, copied: Copied, sketch: Motion) -> Clip:
        """Put copied motion onto the sketch; joints none of whose channels are copied stay as they are."""
        rotations = np.array(sketch.rotations)
        rotations[:, self.whole] = copied.rotations
        for joint in {channel.joint for channel in self.single if channel.is_rotation}:
            rotations[:, joint] = self._with_angles(copied, sketch, joint)
        rotations[:, self.root] = sketch.facing.out_of(rotations[:, self.root])
        touched = sorted({channel.joint for channel in self.channels if channel.is_rotation})
        local = to_local_rotations(rotations[:, touched], sketch.clip.skeleton, joints=touched)
        result = np.array(sketch.clip.rotations)
        # Only these are unrolled: the others keep their bits, signs included.
        result[:, touched] = quaternion.unroll(local)
        return replace(sketch.clip, rotations=result, translations=self._apply_translations(copied, sketch))

    def _with_angles(self, copied: Copied, sketch: Motion, joint: int) -> FloatArray:
        angles = unrolled_angles(sketch.rotations[:, joint], self.orders[joint])
        for column, channel in enumerate(self.single):
            if channel.joint == joint and channel.is_rotation:
                angles[:, channel.axis] = copied.curves[:, column]
        return quaternion.from_euler(angles, self.orders[joint])

    def _apply_translations(self, copied: Copied, sketch: Motion) -> FloatArray:
        offsets = np.array(sketch.offsets)
        travel = np.array(sketch.travel)
        touched = sorted({channel.joint for channel in self.single if not channel.is_rotation})
        for column, channel in enumerate(self.single):
            if not channel.is_rotation:
                target = travel if channel.joint == self.root else offsets[:, channel.joint]
                target[:, channel.axis] = copied.curves[:, column]
        offsets[:, self.root] = sketch.facing.roll_travel(travel)
        result = np.array(sketch.clip.translations)
        result[:, touched] = to_local_translations(offsets[:, touched], sketch.clip.skeleton, joints=touched)
        return result


def goes_along_ground(channel: Channel, root: int, up: FloatArray) -> bool:
    """Tell whether a channel says where the root has got to along the ground.

    Parameters
    ----------
    channel
        Any channel.
    root
        Index of the root joint.
    up
        Up in skeleton space, shape [3].
    """
    return not channel.is_rotation and channel.joint == root and bool(abs(up[channel.axis]) < _UPRIGHT)


def _is_whole(joint: int, spans: Sequence[Span]) -> bool:
    """Whether all three rotation channels of a joint share their role in every span, and have one somewhere."""
    counts = [
        sum(c.joint == joint and c.is_rotation for c in role) for s in spans for role in (s.texture, s.synthesize)
    ]
    return set(counts) <= {0, 3} and any(counts)


def choose_orders(joints: Sequence[int], motions: Sequence[Motion], root: int) -> dict[int, str]:
    """Choose one Euler order per joint over sketch and takes alike.

    The root's turns about up last, so that its other two angles are the same in the facing frame and out of it.
    """
    up = motions[0].clip.skeleton.up
    vertical = "XYZ"[int(np.argmax(np.abs(up)))] if np.abs(up).max() > 1.0 - 1e-6 else ""
    return {
        joint: choose_euler_order(
            np.concatenate([motion.rotations[:, joint] for motion in motions]),
            outermost=vertical if joint == root else "",
        )
        for joint in joints
    }
