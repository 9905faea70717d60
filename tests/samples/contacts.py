"""Feet on the ground: where the soles are, where the root must be, and legs that reach planted feet.

Rounded mean angles of different studies do not add up to feet that stand still. So the root first follows the feet, its
path is smoothed to how a pelvis really travels, and the legs then reach for feet that are held where they stood.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tests.samples import humanoid
from tests.samples.rotations import about, align, compose, inverse, rotate

__all__ = ["FINE_RATE", "SIDES", "Motion", "cycle_window", "plant", "reach_feet", "smooth", "sole_points"]

FloatArray = npt.NDArray[np.float64]

# Samples per second of the fine grid everything is computed on.
FINE_RATE = 96
# Phase shift of each side in strides, and the sign of outward along x.
SIDES = {"Left": (0.0, 1.0), "Right": (0.5, -1.0)}
# When a foot carries: start, stop and ramp in strides from its own heel strike; and the swing below which one stands.
STANCE = (0.02, 0.58, 0.05)
STANDING_GAIN = 0.15
# How softly the points of the soles share the contact, and the least height of a swinging foot.
CONTACT_SOFTNESS_CM = 0.5
CLEARANCE_CM = 1.2
# A pelvis travels at nearly even speed: half widths of the averages over its path along the ground and its height.
TRAVEL_SMOOTHING_S = 0.3
HEIGHT_SMOOTHING_S = 0.15
# A knee that stands is bent at least so much where the root can be lowered for it, and never less than the last.
STANDING_KNEE_DEG = 4.0
LEAST_KNEE_DEG = 2.0
LOWERING_S = 0.08


@dataclass(frozen=True, kw_only=True)
class Motion:
    """A motion of the sample character: rotations [F, J, 4] and root positions [F, 3] in centimetres."""

    rotations: FloatArray
    root: FloatArray


def cycle_window(stride: FloatArray, start: float, stop: float, ramp: float) -> FloatArray:
    """Weigh phases by a window over the cycle: 1 between start and stop, smooth ramps outside, phases in strides."""
    middle, reach = (start + stop) / 2.0, (stop - start) / 2.0
    away = np.abs((stride - middle + 0.5) % 1.0 - 0.5) - reach
    x = np.clip(1.0 - away / ramp, 0.0, 1.0)
    return x * x * (3.0 - 2.0 * x)


def sole_points(rotations: FloatArray, root: FloatArray) -> FloatArray:
    """Positions of heel, ball and toe tip of the left, then the right foot, shape [F, 6, 3]."""
    positions, world = humanoid.forward(rotations, root)
    points = []
    for side in SIDES:
        for name, offset in humanoid.SOLE_POINTS:
            joint = humanoid.index_of(side + name)
            points.append(positions[:, joint] + rotate(world[:, joint], offset))
    return np.stack(points, axis=1)


def smooth(values: FloatArray, half_width_s: float) -> FloatArray:
    """Average columns [N, C] over a raised-cosine window of the fine grid; the ends continue by point reflection."""
    reach = round(half_width_s * FINE_RATE)
    window = 1.0 + np.cos(np.pi * np.arange(-reach + 1, reach) / reach)
    before = 2.0 * values[0] - values[reach - 1 : 0 : -1]
    after = 2.0 * values[-1] - values[-2 : -reach - 1 : -1]
    padded = np.concatenate([before, values, after])
    return np.stack([np.convolve(column, window / window.sum(), mode="valid") for column in padded.T], axis=1)


def _lowest(height: FloatArray) -> FloatArray:
    """Share the contact softly among the lowest points; heights [N, P] to weights [N, P]."""
    low = np.exp(-(height - height.min(axis=1, keepdims=True)) / CONTACT_SOFTNESS_CM)
    return low / low.sum(axis=1, keepdims=True)


def _stances(stride: FloatArray, gain: FloatArray) -> FloatArray:
    """How much each foot is in stance, shape [N, 2]; who no longer swings the legs stands on both."""
    walking = np.minimum(gain / STANDING_GAIN, 1.0)
    swings = [walking * (1.0 - cycle_window(stride + shift, *STANCE)) for shift, _ in SIDES.values()]
    return 1.0 - np.stack(swings, axis=1)


def _follow_feet(points: FloatArray, stance: FloatArray) -> FloatArray:
    """Find the root path that keeps the points that carry where they are; points as for a root at the origin."""
    share = (stance + 1e-6) / np.sum(stance + 1e-6, axis=1, keepdims=True)
    weights = np.concatenate([share[:, [i]] * _lowest(points[:, 3 * i : 3 * i + 3, 1]) for i in range(2)], axis=1)
    between = (weights[1:] + weights[:-1])[:, :, None] / 2.0
    steps = -np.sum(between * np.diff(points, axis=0), axis=1)
    root = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    root[:, 1] = -np.sum(weights * points[:, :, 1], axis=1)
    return root


def _travel(root: FloatArray) -> FloatArray:
    ground = smooth(root[:, [0, 2]], TRAVEL_SMOOTHING_S)
    height = smooth(root[:, 1:2], HEIGHT_SMOOTHING_S)
    return np.stack([ground[:, 0], height[:, 0], ground[:, 1]], axis=1)


def _slip(points: FloatArray, stance: FloatArray) -> FloatArray:
    """Sum over time how far the sole of one foot [N, 3, 3] slips along the ground while it carries; [N, 3]."""
    weights = _lowest(points[:, :, 1]) * stance[:, None]
    between = (weights[1:] + weights[:-1])[:, :, None] / 2.0
    steps = np.sum(between * np.diff(points, axis=0), axis=1) * np.array([1.0, 0.0, 1.0])
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])


def _let_go(slip: FloatArray, stride: FloatArray) -> FloatArray:
    """Take back slip [N, 3] while the foot swings, so that on average it stands where the angles put it; [N, 3]."""
    middle = (STANCE[0] + STANCE[1]) / 2.0
    first, last = int(np.floor(stride[0] - middle)), int(np.ceil(stride[-1] - middle))
    steps = np.arange(first, last + 1)
    at = np.stack([np.interp(steps + middle, stride, column) for column in slip.T], axis=1)
    x = np.clip((stride[:, None] - steps[:-1] - STANCE[1]) / (1.0 + STANCE[0] - STANCE[1]), 0.0, 1.0)
    return at[0] + (x * x * (3.0 - 2.0 * x)) @ np.diff(at, axis=0)


def _hold_foot(points: FloatArray, stride: FloatArray, stance: FloatArray) -> FloatArray:
    """Shift one foot so that it stands still on the ground in stance and clears it in swing; [N, 3, 3] to [N, 3]."""
    slip = _slip(points, stance)
    shift = _let_go(slip, stride) - slip
    low = np.sum(_lowest(points[:, :, 1]) * points[:, :, 1], axis=1)
    lift = np.maximum(CLEARANCE_CM - points[:, :, 1].min(axis=1), 0.0)
    shift[:, 1] = -stance * low + (1.0 - stance) ** 2 * lift
    return shift


def _reach_of(knee_deg: float) -> float:
    """Distance from hip to ankle at a knee flexion."""
    leg = humanoid.OFFSETS[humanoid.index_of("LeftLeg")] + rotate(
        about("x", knee_deg), humanoid.OFFSETS[humanoid.index_of("LeftFoot")]
    )
    return float(np.linalg.norm(leg))


def _lower_root(rotations: FloatArray, root: FloatArray, ankles: FloatArray, stance: FloatArray) -> FloatArray:
    """Lower the root, smoothly, where a standing foot would be out of reach; root [N, 3]."""
    positions, _ = humanoid.forward(rotations, root)
    hips = np.stack([positions[:, humanoid.index_of(side + "UpLeg")] for side in SIDES], axis=1)
    aside = np.sum((hips - ankles)[:, :, [0, 2]] ** 2, axis=2)
    highest = ankles[:, :, 1] + np.sqrt(_reach_of(STANDING_KNEE_DEG) ** 2 - aside)
    excess = np.max(np.maximum(hips[:, :, 1] - highest, 0.0) * stance, axis=1)
    reach = round(LOWERING_S * FINE_RATE)
    around = np.lib.stride_tricks.sliding_window_view(np.pad(excess, reach, mode="edge"), 2 * reach + 1)
    drop = smooth(around.max(axis=1)[:, None], LOWERING_S)
    return root - drop * np.array([0.0, 1.0, 0.0])


def _knee(distance: FloatArray) -> FloatArray:
    """Knee flexion in degrees that brings the ankle so near the hip, shape [N]."""
    thigh, shank = (float(-humanoid.OFFSETS[humanoid.index_of(name), 1]) for name in ("LeftLeg", "LeftFoot"))
    cosine = (distance**2 - thigh**2 - shank**2) / (2.0 * thigh * shank)
    return np.degrees(np.arccos(np.clip(cosine, -1.0, np.cos(np.radians(LEAST_KNEE_DEG)))))


def _reach_foot(rotations: FloatArray, root: FloatArray, side: str, ankle: FloatArray) -> None:
    """Bend one leg so that its ankle comes to a point [N, 3]; the foot keeps its direction. Changes rotations."""
    upper, lower, foot = (humanoid.index_of(side + name) for name in ("UpLeg", "Leg", "Foot"))
    positions, world = humanoid.forward(rotations, root)
    target = ankle - positions[:, upper]
    bend = about("x", _knee(np.linalg.norm(target, axis=1)))
    leg = humanoid.OFFSETS[lower] + rotate(bend, humanoid.OFFSETS[foot])
    thigh = compose(align(rotate(world[:, upper], leg), target), world[:, upper])
    rotations[:, upper] = compose(inverse(world[:, 0]), thigh)
    rotations[:, lower] = bend
    rotations[:, foot] = compose(inverse(compose(thigh, bend)), world[:, foot])


def reach_feet(rotations: FloatArray, root: FloatArray, ankles: FloatArray) -> Motion:
    """Bend both legs so that the ankles come to points [N, 2, 3]; feet keep their directions, the root its place."""
    out = rotations.copy()
    for number, side in enumerate(SIDES):
        _reach_foot(out, root, side, ankles[:, number])
    return Motion(rotations=out, root=root)


def plant(rotations: FloatArray, stride: FloatArray, gain: FloatArray) -> Motion:
    """Give a walk in place its root and stand its feet still on the ground.

    Parameters
    ----------
    rotations
        The walk on the fine grid, shape [N, J, 4].
    stride
        Phase in strides, shape [N]; left heel strikes at whole numbers.
    gain
        How far the legs swing, from 0 (standing) to 1, shape [N].
    """
    stance = _stances(stride, gain)
    root = _follow_feet(sole_points(rotations, np.zeros((len(rotations), 3))), stance)
    points = sole_points(rotations, root)
    positions, _ = humanoid.forward(rotations, root)
    ankles = np.stack(
        [
            positions[:, humanoid.index_of(side + "Foot")]
            + _hold_foot(points[:, 3 * i : 3 * i + 3], stride + shift, stance[:, i])
            for i, (side, (shift, _)) in enumerate(SIDES.items())
        ],
        axis=1,
    )
    return reach_feet(rotations, _lower_root(rotations, _travel(root), ankles, stance), ankles)
