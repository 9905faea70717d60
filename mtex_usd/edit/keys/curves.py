"""Motion as cubic curves: keys with tangents, one curve per channel, as curve editors and USD splines hold them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.curve_space import put_rotations
from mtex_usd.edit.keys.hermite import hermite_basis, spread_parts, sweep_cubics
from mtex_usd.edit.keys.sampled import ChannelSamples, sample_channels
from mtex_usd.edit.keys.tolerance import Tolerance
from mtex_usd.motion.channels import Channel, to_local_rotations, to_local_translations
from mtex_usd.motion.clip import Clip

__all__ = ["KeyCurve", "ReducedKeys", "evaluate_together", "rebuild"]

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class KeyCurve:
    """A channel as a cubic curve; N keys.

    Parameters
    ----------
    joint
        Full path of the joint.
    kind
        ``rx ry rz`` in degrees, or ``tx ty tz`` in stage units; see :mod:`mtex_usd.motion.channels`.
    frames
        Where in the clip the keys are, counted from 0, shape [N]; whole frames, but for jumps within one frame. A curve
        with one key is constant.
    time_codes
        When that is, shape [N].
    values
        Shape [N].
    slopes_before, slopes_after
        Tangents, value per time code, shape [N]; equal but at corners.
    """

    joint: str
    kind: str
    frames: FloatArray
    time_codes: FloatArray
    values: FloatArray
    slopes_before: FloatArray
    slopes_after: FloatArray

    @property
    def widths(self) -> FloatArray:
        """Length of the tangents between each two keys, time codes: a third of the interval, shape [N - 1]."""
        return np.diff(self.time_codes) / 3.0

    def evaluate(self, time_codes: FloatArray) -> FloatArray:
        """Give the curve's values at some times.

        Parameters
        ----------
        time_codes
            The times, any shape; before the first and after the last key the value holds.
        """
        times = np.clip(time_codes, self.time_codes[0], self.time_codes[-1])
        if len(self.values) == 1:
            return np.full(times.shape, self.values[0])
        first = np.clip(np.searchsorted(self.time_codes, times, side="right") - 1, 0, len(self.values) - 2)
        lengths = self.time_codes[first + 1] - self.time_codes[first]
        weights = hermite_basis((times - self.time_codes[first]) / lengths, lengths)
        held = [self.values[first], self.slopes_after[first], self.values[first + 1], self.slopes_before[first + 1]]
        return np.asarray(sum(weight * value for weight, value in zip(weights, held, strict=True)))


def evaluate_together(curves: Sequence[KeyCurve], steps: int, count: int) -> FloatArray:
    """Evaluate curves from the first frame on.

    Parameters
    ----------
    curves
        Curves over the same frames, their keys at steps.
    steps
        From one frame to the next.
    count
        How many steps there are.

    Returns
    -------
    FloatArray
        Shape [C, count].
    """
    values = np.empty((len(curves), count))
    moving = [number for number, curve in enumerate(curves) if len(curve.values) > 1]
    for number in set(range(len(curves))) - set(moving):
        values[number] = curves[number].values[0]
    if moving:
        values[moving] = _sweep([curves[number] for number in moving], steps).reshape(len(moving), count)
    return values


def _sweep(curves: Sequence[KeyCurve], steps: int) -> FloatArray:
    """Evaluate all steps of curves in a row; a last key is a step of its own."""
    counts = np.concatenate([np.append(np.round(steps * np.diff(curve.frames)), 1.0) for curve in curves])
    lengths = np.concatenate([np.append(np.diff(curve.time_codes), 0.0) for curve in curves])
    held = [
        np.concatenate([getattr(curve, name) for curve in curves])
        for name in ("values", "slopes_before", "slopes_after")
    ]
    return sweep_cubics(held[0], held[1], held[2], lengths, spread_parts(counts.astype(np.intp)))


@dataclass(frozen=True, eq=False, kw_only=True)
class ReducedKeys:
    """A motion by the keys of its channels.

    Parameters
    ----------
    base
        The clip that was reduced; what no curve is of comes from it.
    curves
        One curve per channel, joint after joint.
    orders
        Euler order by joint path, where rotations are among the curves; also holds for angles without a curve.
    tolerance
        What was asked for; None where a number of keys was.
    max_degrees, max_metres
        Largest difference from the clip as UsdSkel plays it, of a joint's rotation and of a joint's place, at frames
        and three times between each two.
    discarded
        Joint paths and frames that were taken for outliers; the differences are measured without them.
    """

    base: Clip
    curves: tuple[KeyCurve, ...]
    orders: Mapping[str, str]
    tolerance: Tolerance | None
    max_degrees: float
    max_metres: float
    discarded: tuple[tuple[str, int], ...] = ()

    @property
    def key_count(self) -> int:
        """Keys of all curves together."""
        return sum(len(curve.values) for curve in self.curves)

    def evaluate(self, *, per_frame: int = 1) -> Clip:
        """Give the motion back.

        Parameters
        ----------
        per_frame
            Frames of the result to each frame of the clip that was reduced.

        Returns
        -------
        Clip
            On the frames of the clip; joints without a curve keep their bits there.
        """
        channels = tuple(Channel(self.base.joints.index(curve.joint), curve.kind) for curve in self.curves)
        orders = {self.base.joints.index(joint): order for joint, order in self.orders.items()}
        samples = sample_channels(self.base, channels, per_frame, orders=orders)
        values = [curve.evaluate(samples.clip.time_codes) for curve in self.curves]
        return rebuild(samples, np.array(values).reshape(samples.values.shape))


def rebuild(samples: ChannelSamples, values: FloatArray) -> Clip:
    """Put curves in place of the channels.

    Parameters
    ----------
    samples
        The motion and which of its channels are replaced.
    values
        New values of the channels, shape [C, T].
    """
    clip, joints = samples.clip, samples.joints
    if joints:
        turned = np.moveaxis(samples.turn_by(values, np.arange(len(joints))), -1, 0)
        clip = put_rotations(clip, joints, to_local_rotations(turned, clip.skeleton, joints=joints))
    moved = np.zeros_like(clip.translations)
    for channel, value, before in zip(samples.channels, values, samples.values, strict=True):
        if not channel.is_rotation:
            moved[:, channel.joint, channel.axis] = value - before
    steps = to_local_translations(moved, clip.skeleton) - clip.skeleton.rest_translations
    changed = moved.any(axis=-1, keepdims=True)
    return replace(clip, translations=np.where(changed, clip.translations + steps, clip.translations))
