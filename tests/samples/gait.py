"""Walks built from the gait tables: joint angles by phase, the root by the feet that stand.

A walk is a function of its phase, counted in strides. Angles come from the tables, scaled by a style, with variation
from stride to stride and small fast detail; then the feet are planted, which gives the root its path.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tests.samples import humanoid, variation
from tests.samples.contacts import FINE_RATE, SIDES, Motion, cycle_window, plant
from tests.samples.gait_tables import TABLES, evaluate
from tests.samples.rotations import about, compose, half, inverse, unroll

__all__ = ["FRAME_RATE", "Gait", "walk", "walk_to_stop"]

FloatArray = npt.NDArray[np.float64]

FRAME_RATE = 24
OVERSAMPLING = FINE_RATE // FRAME_RATE

# Stride-to-stride spread: stride time 2.5 % (Hausdorff et al. 1995: 2 to 3 %), amplitudes 3 % and offsets 0.6 degrees
# (Winter 1991 finds 1 to 2 degrees from stride to stride in one subject at hip, knee and ankle).
STRIDE_TIME_SPREAD = 0.025
AMPLITUDE_SPREAD = 0.03
OFFSET_SPREAD_DEG = 0.6
# Toe-out of the feet (Murray et al. 1964), and how far the legs lean in, so that the feet are nearer than the hips.
TOE_OUT_DEG = 7.0
STANCE_ADDUCTION_DEG = 2.0
# When a foot lies flat, and when it bends its toes: start, stop and ramp in strides from its own heel strike.
FLAT = (0.10, 0.30, 0.09)
FOREFOOT = (0.35, 0.60, 0.10)
# Hip angles are published against a pelvis that leans forward so much when standing; here that pelvis is at rest.
STANDING_TILT_DEG = 10.0
# Standing: knee, shoulder and elbow flexion in degrees.
STANDING_KNEE_DEG = 4.0
STANDING_ARM_DEG = -2.0
STANDING_ELBOW_DEG = 15.0


@dataclass(frozen=True, kw_only=True)
class Gait:
    """How somebody walks: the tables' amplitudes scaled, and a few postures in degrees."""

    seed: int
    stride_s: float
    hip: float = 1.0
    knee: float = 1.0
    ankle: float = 1.0
    pelvis: float = 1.0
    thorax: float = 1.0
    shoulder: float = 1.0
    elbow: float = 1.0
    lean_deg: float = 2.0
    elbow_deg: float = 0.0
    arm_lag: float = 0.01
    head_deg: float = 0.0
    abduction_deg: float = 9.0
    turn_deg: float = 0.0
    detail_deg: float = 0.45
    toe_bend: float = 1.0
    variation: float = 1.0


@dataclass(frozen=True, kw_only=True)
class _Phases:
    """The fine time grid of a walk: seconds, strides and gain (0 standing, 1 walking), each of shape [N]."""

    time_s: FloatArray
    stride: FloatArray
    gain: FloatArray


@dataclass(frozen=True, kw_only=True)
class _Frame:
    """Where a walker faces and how the pelvis lies: heading and obliquity [N] in degrees, pelvis rotation [N, 4]."""

    heading: FloatArray
    obliquity: FloatArray
    pelvis: FloatArray


class _Curves:
    """The tables as one walker moves them; every curve has its own noise, all drawn from the walker's seed."""

    def __init__(self, gait: Gait, phases: _Phases) -> None:
        self._gait = gait
        self._phases = phases
        self._drawn = 1000 * gait.seed

    def noise(self) -> FloatArray:
        """Draw the next noise over strides, unit standard deviation."""
        self._drawn += 2
        return self._gait.variation * variation.fractal(self._phases.stride, self._drawn)

    def detail(self, amplitude: float) -> FloatArray:
        """Draw the next fast detail, degrees; it fades with the walk but never quite goes."""
        self._drawn += 2
        calm = 0.3 + 0.7 * self._phases.gain
        return amplitude * self._gait.detail_deg * calm * variation.detail(self._phases.time_s, self._drawn)

    def angle(self, name: str, shift: float, scale: float = 1.0, rest: float = 0.0) -> FloatArray:
        """Evaluate a table as this walker moves it, in degrees.

        Parameters
        ----------
        name
            The table.
        shift
            Phase shift in strides: 0 for the left side, 0.5 for the right.
        scale
            Style: how much wider than the table the curve swings about its mean.
        rest
            Value it has when standing.
        """
        mean = float(np.mean(TABLES[name]))
        spread = 1.0 + AMPLITUDE_SPREAD * self.noise()
        swing = scale * spread * (evaluate(name, self._phases.stride + shift) - mean)
        value = mean + swing + OFFSET_SPREAD_DEG * self.noise() * min(1.0, np.ptp(TABLES[name]) / 20.0)
        return rest + self._phases.gain * (value - rest)


def _leg(curves: _Curves, gait: Gait, phases: _Phases, side: str, frame: _Frame) -> dict[str, FloatArray]:
    shift, out = SIDES[side]
    stride = phases.stride + shift
    flexion = curves.angle("hip", shift, gait.hip, STANDING_TILT_DEG) - STANDING_TILT_DEG + curves.detail(0.4)
    knee = curves.angle("knee", shift, gait.knee, STANDING_KNEE_DEG) + curves.detail(0.4)
    pitch = flexion - knee + curves.angle("ankle", shift, gait.ankle) + curves.detail(0.3)
    # Published ankle angles do not put the sole flat to a degree: from foot flat to heel off it is laid on the ground.
    pitch = pitch * (1.0 - cycle_window(stride, *FLAT)) * np.minimum(1.0, phases.gain * 4.0)
    inward = curves.angle("hip_adduction", shift, gait.pelvis) - out * frame.obliquity + STANCE_ADDUCTION_DEG
    toe_out = about("y", out * TOE_OUT_DEG)
    heading = about("y", frame.heading)
    thigh = compose(heading, about("x", -flexion), about("z", -out * inward), toe_out)
    foot = compose(heading, toe_out, about("x", -pitch))
    bend = gait.toe_bend * np.clip(-pitch, 0.0, 35.0) * cycle_window(stride, *FOREFOOT)
    return {
        f"{side}UpLeg": compose(inverse(frame.pelvis), thigh),
        f"{side}Leg": about("x", knee),
        f"{side}Foot": compose(inverse(compose(thigh, about("x", knee))), foot),
        f"{side}Toe": about("x", -bend),
    }


def _arm(curves: _Curves, gait: Gait, side: str) -> dict[str, FloatArray]:
    shift, out = SIDES[side]
    shift -= gait.arm_lag
    flexion = curves.angle("shoulder", shift, gait.shoulder, STANDING_ARM_DEG) + curves.detail(1.2)
    elbow = curves.angle("elbow", shift, gait.elbow, STANDING_ELBOW_DEG) + gait.elbow_deg + curves.detail(1.5)
    wrist = 0.15 * curves.angle("shoulder", shift - 0.06) + curves.detail(2.0)
    away = 90.0 - gait.abduction_deg + 0.15 * flexion + curves.detail(0.8)
    return {
        f"{side}Shoulder": compose(about("y", -out * 0.12 * flexion), about("z", out * curves.detail(0.4))),
        f"{side}Arm": compose(about("x", -0.88 * flexion), about("z", -out * away)),
        f"{side}ForeArm": about("y", -out * elbow),
        f"{side}Hand": compose(about("y", -out * (wrist + 6.0)), about("z", out * curves.detail(1.5))),
    }


def _trunk(curves: _Curves, gait: Gait, frame: _Frame) -> dict[str, FloatArray]:
    twist = curves.angle("thorax_rotation", 0.0, gait.thorax) + curves.detail(0.7)
    lean = curves.angle("thorax_tilt", 0.0) + gait.lean_deg + curves.detail(0.6)
    side = curves.angle("thorax_lean", 0.0, gait.thorax) + curves.detail(0.6)
    chest = compose(about("y", frame.heading - twist), about("x", lean), about("z", -side))
    # The head keeps to the way ahead: a third of the trunk's turns, and the pitch that holds the gaze.
    nod = curves.angle("head_pitch", 0.0) + gait.head_deg + curves.detail(0.7)
    look = frame.heading - 0.3 * twist + curves.noise() + curves.detail(0.7)
    head = compose(about("y", look), about("x", nod), about("z", -0.4 * side))
    bend, neck = half(compose(inverse(frame.pelvis), chest)), half(compose(inverse(chest), head))
    return {"Spine": bend, "Spine1": bend, "Neck": neck, "Head": neck}


def _frame(curves: _Curves, gait: Gait, phases: _Phases) -> _Frame:
    progress = (phases.time_s - phases.time_s[0]) / np.ptp(phases.time_s)
    heading = gait.turn_deg * progress * progress * (3.0 - 2.0 * progress) + 0.6 * curves.noise()
    rotation = curves.angle("pelvis_rotation", 0.0, gait.pelvis) + curves.detail(0.4)
    tilt = curves.angle("pelvis_tilt", 0.0, gait.pelvis) + curves.detail(0.4)
    obliquity = curves.angle("pelvis_obliquity", 0.0, gait.pelvis) + curves.detail(0.3)
    pelvis = compose(about("y", heading - rotation), about("x", tilt), about("z", obliquity))
    return _Frame(heading=heading, obliquity=obliquity, pelvis=pelvis)


def _pose(gait: Gait, phases: _Phases) -> FloatArray:
    curves = _Curves(gait, phases)
    frame = _frame(curves, gait, phases)
    parts = {"Hips": frame.pelvis} | _trunk(curves, gait, frame)
    for side in SIDES:
        parts |= _leg(curves, gait, phases, side, frame) | _arm(curves, gait, side)
    return np.stack([parts[name] for name in humanoid.NAMES], axis=1)


def _steady(gait: Gait, frames: int) -> _Phases:
    """Lay strides of varying duration on an even time grid."""
    time_s = np.arange(OVERSAMPLING * (frames - 1) + 1) / (FRAME_RATE * OVERSAMPLING)
    fine = np.arange(0.0, time_s[-1] / gait.stride_s * 1.3 + 2.0, 1.0 / 512.0)
    pace = gait.stride_s * (1.0 + STRIDE_TIME_SPREAD * gait.variation * variation.fractal(fine, 1000 * gait.seed))
    elapsed = np.concatenate([[0.0], np.cumsum((pace[1:] + pace[:-1]) / 2.0 / 512.0)])
    return _Phases(time_s=time_s, stride=np.interp(time_s, elapsed, fine), gain=np.ones_like(time_s))


def _move(gait: Gait, phases: _Phases) -> Motion:
    motion = plant(_pose(gait, phases), phases.stride, phases.gain)
    return Motion(rotations=unroll(motion.rotations[::OVERSAMPLING]), root=motion.root[::OVERSAMPLING])


def walk(gait: Gait, frames: int) -> Motion:
    """Walk on, from the left heel strike at the origin; facing +Z at the start."""
    return _move(gait, _steady(gait, frames))


def walk_to_stop(gait: Gait, frames: int, *, strides: float, brake_s: float) -> Motion:
    """Walk some strides, then let pace and swing fade over some seconds until both feet stand."""
    steady = _steady(gait, frames)
    reach = np.interp(strides, steady.stride, steady.time_s)
    late = np.clip((steady.time_s - reach) / brake_s, 0.0, 1.0)
    # The pace falls from 1 to 0 as a cosine, so the phase gains half of what it would have without the brake.
    faded = late - np.sin(np.pi * late) / np.pi
    free = np.minimum(steady.time_s, reach + brake_s) - brake_s * faded / 2.0
    stride = np.interp(free, steady.time_s, steady.stride)
    swing = 1.0 - late**3 * (late * (late * 6.0 - 15.0) + 10.0)
    return _move(gait, _Phases(time_s=steady.time_s, stride=stride, gain=swing))
