"""The curves that edits work on: what of a clip is chosen, read as columns, and how changed columns are put back.

Where all three rotation channels of a joint are chosen it is edited as a rotation: its three columns are the sum of the
successive local turns log(q[i]^-1 q[i+1]), and a change of them turns each frame about its own axes (Lee & Shin 2002,
"General construction of time-domain filters for orientation data"). That does not depend on the frame of reference,
holds for any number of turns, is exact about one axis, and never adds up to a drift, because every frame is changed
from where it is. Other rotation channels are unrolled Euler angles in skeleton axes, as texturing reads them. All
rotation columns are in degrees, translations in stage units along the skeleton's axes.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from mtex_usd.motion import quaternion
from mtex_usd.motion.arguments import as_tokens
from mtex_usd.motion.channels import (
    Channel,
    choose_euler_order,
    resolve_channels,
    to_local_rotations,
    to_local_translations,
    to_skeleton_rotations,
    to_skeleton_translations,
    unrolled_angles,
)
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.facing import find_root

__all__ = ["CurveSpace", "choose_order", "make_curve_space", "put_rotations", "select_channels"]

FloatArray = npt.NDArray[np.float64]


def select_channels(clip: Clip, channels: Sequence[str]) -> tuple[Channel, ...]:
    """Resolve channel tokens on a clip.

    Parameters
    ----------
    clip
        The clip.
    channels
        Tokens as in recipes; none means the rotations of all joints and the translations of those that move.

    Raises
    ------
    InputError
        For unknown joints and channels, or a single string in place of a list.
    """
    tokens = as_tokens(channels)
    if tokens:
        return tuple(sorted(resolve_channels(tokens, clip.joints, source="channels")))
    moving = np.ptp(clip.translations, axis=0).any(axis=-1)
    kinds = [("rx", "ry", "rz", "tx", "ty", "tz") if moves else ("rx", "ry", "rz") for moves in moving]
    return tuple(Channel(joint, kind) for joint, of_joint in enumerate(kinds) for kind in of_joint)


def choose_order(clip: Clip, joint: int, rotations: FloatArray) -> str:
    """Choose a joint's Euler order over its rotations in skeleton axes [F, 4]; the root turns about up last."""
    up = np.abs(clip.skeleton.up)
    is_heading = joint == find_root(clip) and up.max() > 1.0 - 1e-6
    return choose_euler_order(rotations, outermost="XYZ"[int(np.argmax(up))] if is_heading else "")


def put_rotations(clip: Clip, joints: Sequence[int], rotations: FloatArray) -> Clip:
    """Give joints new local rotations [F, N, 4], with the signs of the old ones; equal rotations keep their bits."""
    old = clip.rotations[:, joints]
    signs = np.where(np.sum(old * rotations, axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    result = np.array(clip.rotations)
    result[:, joints] = signs * rotations
    return replace(clip, rotations=result)


@dataclass(frozen=True, eq=False)
class CurveSpace:
    """The chosen channels of a clip as columns: whole joints first, then single angles, then translations.

    Parameters
    ----------
    clip
        The clip.
    whole
        Joints edited as rotations, length W.
    angles
        Rotation channels edited on their own.
    offsets
        Translation channels.
    """

    clip: Clip
    whole: tuple[int, ...]
    angles: tuple[Channel, ...]
    offsets: tuple[Channel, ...]

    @cached_property
    def curves(self) -> FloatArray:
        """The chosen channels, degrees and stage units, shape [F, 3 W + A + T]."""
        return np.concatenate([self._turns, self._read_angles(), self._read_offsets()], axis=1)

    @cached_property
    def _turns(self) -> FloatArray:
        rotations = quaternion.unroll(self.clip.rotations[:, self.whole])
        steps = quaternion.log(quaternion.multiply(quaternion.conjugate(rotations[:-1]), rotations[1:]))
        start = np.zeros((1, *steps.shape[1:]))
        turns = np.cumsum(np.concatenate([start, steps]), axis=0)
        return np.asarray(np.degrees(turns).reshape(len(rotations), -1))

    @cached_property
    def _euler(self) -> dict[int, tuple[str, FloatArray]]:
        """Order and angles [F, 3] by joint with single rotation channels."""
        joints = sorted({channel.joint for channel in self.angles})
        turned = to_skeleton_rotations(self.clip.rotations, self.clip.skeleton) if joints else self.clip.rotations
        orders = {joint: choose_order(self.clip, joint, turned[:, joint]) for joint in joints}
        return {joint: (order, unrolled_angles(turned[:, joint], order)) for joint, order in orders.items()}

    def _read_angles(self) -> FloatArray:
        columns = [self._euler[channel.joint][1][:, channel.axis] for channel in self.angles]
        return np.stack(columns, axis=1) if columns else np.empty((self.clip.frame_count, 0))

    def _read_offsets(self) -> FloatArray:
        if not self.offsets:
            return np.empty((self.clip.frame_count, 0))
        offsets = to_skeleton_translations(self.clip.translations, self.clip.skeleton)
        return np.asarray(offsets[:, [c.joint for c in self.offsets], [c.axis for c in self.offsets]])

    def add(self, change: FloatArray) -> Clip:
        """Change the curves by so much at every frame, shape as :attr:`curves`; where that is 0 all bits stay."""
        split = 3 * len(self.whole)
        vectors = np.radians(change[:, :split]).reshape(len(change), -1, 3)
        clip = self._turn(quaternion.multiply(self.clip.rotations[:, self.whole], quaternion.exp(vectors)), vectors)
        return self._shift(self._bend(clip, change[:, split:]), change[:, split + len(self.angles) :])

    def replace_by(self, detail: FloatArray) -> Clip:
        """Put the clip's mean pose in place of the chosen channels and add a detail, shape as :attr:`curves`."""
        split = 3 * len(self.whole)
        vectors = np.radians(detail[:, :split]).reshape(len(detail), -1, 3)
        rotations = self.clip.rotations[:, self.whole]
        means = quaternion.mean(rotations) if self.whole else rotations[0]
        clip = self._turn(quaternion.multiply(means, quaternion.exp(vectors)), np.ones_like(vectors))
        single = self.curves[:, split:].mean(axis=0) + detail[:, split:] - self.curves[:, split:]
        return self._shift(self._bend(clip, single), single[:, len(self.angles) :])

    def _turn(self, rotations: FloatArray, changes: FloatArray) -> Clip:
        changed = changes.any(axis=-1, keepdims=True)
        kept = np.where(changed, quaternion.normalize(rotations), self.clip.rotations[:, self.whole])
        return put_rotations(self.clip, self.whole, kept)

    def _bend(self, clip: Clip, change: FloatArray) -> Clip:
        """Change the single angles; a column for each, others may follow."""
        for joint, (order, angles) in self._euler.items():
            moved = np.zeros_like(angles)
            for column, channel in enumerate(self.angles):
                if channel.joint == joint:
                    moved[:, channel.axis] = change[:, column]
            local = to_local_rotations(
                quaternion.from_euler(angles + moved, order)[:, None], self.clip.skeleton, joints=[joint]
            )
            changed = np.asarray(moved.any(axis=-1))[:, None, None]
            clip = put_rotations(clip, [joint], np.where(changed, local, clip.rotations[:, [joint]]))
        return clip

    def _shift(self, clip: Clip, change: FloatArray) -> Clip:
        moved = np.zeros_like(clip.translations)
        moved[:, [c.joint for c in self.offsets], [c.axis for c in self.offsets]] = change
        if not moved.any():
            return clip
        skeleton = self.clip.skeleton
        steps = to_local_translations(moved, skeleton) - skeleton.rest_translations
        changed = moved.any(axis=-1, keepdims=True)
        return replace(clip, translations=np.where(changed, clip.translations + steps, clip.translations))


def make_curve_space(clip: Clip, channels: Sequence[str]) -> CurveSpace:
    """Read the chosen channels of a clip.

    Parameters
    ----------
    clip
        The clip.
    channels
        As :func:`select_channels` takes them.

    Raises
    ------
    InputError
        As :func:`select_channels`.
    """
    chosen = select_channels(clip, channels)
    turning = [channel.joint for channel in chosen if channel.is_rotation]
    whole = tuple(sorted({joint for joint in turning if turning.count(joint) == 3}))
    angles = tuple(channel for channel in chosen if channel.is_rotation and channel.joint not in whole)
    return CurveSpace(clip, whole, angles, tuple(channel for channel in chosen if not channel.is_rotation))
