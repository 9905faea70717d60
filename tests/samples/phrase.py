"""Free-form phrases on planted feet: crouch, sway, lunge and turn, with an upper body that follows, leads and balances.

A phrase is a list of gestures, each a minimum-jerk move out, a hold and a minimum-jerk move back (Flash & Hogan 1985,
J. Neurosci. 5:1688-1703). All that the lower body does follows from four curves; the upper body follows the same
curves some tenths of a second earlier or later, so that it can be found again from the legs. Amounts are choices of
this project.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tests.samples import humanoid, variation
from tests.samples.contacts import SIDES, Motion, reach_feet
from tests.samples.rotations import about, compose, half, inverse, unroll

__all__ = ["Gesture", "perform"]

FloatArray = npt.NDArray[np.float64]

# Where the feet stand: half their distance and how far they turn out.
FOOT_ASIDE_CM = 15.0
FOOT_OUT_DEG = 12.0
# Slow swaying of quiet standing below 0.5 Hz, root mean square (Winter 1995, Gait & Posture 3:193-214: about half a
# centimetre), and the spread of what a gesture repeats.
QUIET_SWAY_CM = 0.5
GESTURE_SPREAD = 0.06
DETAIL_DEG = 0.5


@dataclass(frozen=True, kw_only=True)
class Gesture:
    """One move: what ("crouch", "sway", "lunge" in cm, "turn" in degrees), how much, and when, in seconds."""

    what: str
    amount: float
    start_s: float
    out_s: float
    hold_s: float
    back_s: float


def _minimum_jerk(x: FloatArray) -> FloatArray:
    x = np.clip(x, 0.0, 1.0)
    return x**3 * (x * (x * 6.0 - 15.0) + 10.0)


class _Phrase:
    """The four curves of a phrase, to be asked for at any time, with seeded noise."""

    def __init__(self, gestures: tuple[Gesture, ...], seed: int, noise: float) -> None:
        self._gestures = gestures
        self._noise = noise
        self._spread = 1.0 + noise * GESTURE_SPREAD * (2.0 * variation.uniforms(5000 + seed, len(gestures)) - 1.0)
        self._drawn = 1000 * seed

    def curve(self, what: str, time_s: FloatArray) -> FloatArray:
        """Add up the gestures of one kind at times [F]."""
        total = np.zeros_like(time_s)
        for gesture, spread in zip(self._gestures, self._spread, strict=True):
            if gesture.what == what:
                back = gesture.start_s + gesture.out_s + gesture.hold_s
                out = _minimum_jerk((time_s - gesture.start_s) / gesture.out_s)
                total += spread * gesture.amount * (out - _minimum_jerk((time_s - back) / gesture.back_s))
        return total

    def sway(self, time_s: FloatArray, amplitude: float) -> FloatArray:
        """Draw the next slow noise below 0.5 Hz."""
        self._drawn += 2
        return (
            self._noise
            * amplitude
            * variation.cosine_sum(time_s, np.arange(1.0, 11.0) / 21.0, slope=0.5, seed=self._drawn)
        )

    def detail(self, time_s: FloatArray, amplitude: float) -> FloatArray:
        """Draw the next fast detail in degrees."""
        self._drawn += 2
        return self._noise * amplitude * DETAIL_DEG * variation.detail(time_s, self._drawn)


@dataclass(frozen=True, kw_only=True)
class _Lower:
    """The pelvis: place [F, 3] and rotation [F, 4]."""

    root: FloatArray
    pelvis: FloatArray


def _lower(phrase: _Phrase, time_s: FloatArray) -> _Lower:
    crouch = phrase.curve("crouch", time_s)
    sway = phrase.curve("sway", time_s)
    lunge = phrase.curve("lunge", time_s)
    turn = phrase.curve("turn", time_s)
    root = np.stack(
        [
            sway + phrase.sway(time_s, QUIET_SWAY_CM),
            humanoid.OFFSETS[0, 1] - 2.0 - crouch - 0.035 * sway**2 - 0.02 * lunge**2,
            lunge - 0.45 * crouch + phrase.sway(time_s, QUIET_SWAY_CM),
        ],
        axis=1,
    )
    tilt = 0.7 * crouch + 0.5 * lunge + phrase.detail(time_s, 0.5)
    pelvis = compose(about("y", turn + phrase.detail(time_s, 0.6)), about("x", tilt), about("z", -0.45 * sway))
    return _Lower(root=root, pelvis=pelvis)


def _trunk(phrase: _Phrase, time_s: FloatArray, lower: _Lower) -> dict[str, FloatArray]:
    # The chest leads a turn by 0.15 s and goes further; it leans into a crouch and away from a sway, a little later.
    turn = 1.6 * phrase.curve("turn", time_s + 0.15) + 0.7 * phrase.curve("sway", time_s)
    lean = 1.0 * phrase.curve("crouch", time_s - 0.05) + 0.4 * phrase.curve("lunge", time_s - 0.1)
    side = 0.9 * phrase.curve("sway", time_s - 0.15)
    chest = compose(
        about("y", turn + phrase.detail(time_s, 0.8)),
        about("x", lean + phrase.sway(time_s, 0.8) + phrase.detail(time_s, 0.6)),
        about("z", side + phrase.detail(time_s, 0.6)),
    )
    # The eyes go first: the head leads the chest by another 0.15 s and lifts while the body sinks.
    look = 1.9 * phrase.curve("turn", time_s + 0.3) + 1.2 * phrase.curve("sway", time_s + 0.1)
    nod = 0.35 * phrase.curve("crouch", time_s) + phrase.detail(time_s, 0.8)
    head = compose(about("y", look + phrase.sway(time_s, 1.0)), about("x", nod), about("z", 0.3 * side))
    bend, neck = half(compose(inverse(lower.pelvis), chest)), half(compose(inverse(chest), head))
    return {"Spine": bend, "Spine1": bend, "Neck": neck, "Head": neck}


def _arm(phrase: _Phrase, time_s: FloatArray, side: str) -> dict[str, FloatArray]:
    out = SIDES[side][1]
    # Arms counterweigh: forward in a crouch, up on the side swayed to, swept along by a turn 0.15 s late.
    crouch = phrase.curve("crouch", time_s - 0.1)
    sway = out * phrase.curve("sway", time_s - 0.05)
    turn = out * phrase.curve("turn", time_s - 0.15)
    lunge = phrase.curve("lunge", time_s + 0.05)
    forward = 2.4 * crouch + (2.2 if side == "Right" else -0.8) * lunge - 0.7 * turn + phrase.detail(time_s, 1.2)
    raised = 12.0 + 0.5 * crouch + 7.5 * np.maximum(sway, 0.0) ** 2 / (np.abs(sway) + 3.0) + 0.4 * np.abs(turn)
    elbow = 18.0 + 0.6 * np.maximum(forward, 0.0) + 0.7 * np.abs(turn) + phrase.sway(time_s, 2.0)
    hand = 8.0 + 0.2 * phrase.curve("crouch", time_s - 0.25) + phrase.detail(time_s, 2.0)
    return {
        f"{side}Shoulder": compose(about("y", -out * 0.12 * forward), about("z", out * 0.15 * (raised - 12.0))),
        f"{side}Arm": compose(
            about("x", -0.88 * forward), about("z", -out * (90.0 - 0.85 * raised + phrase.detail(time_s, 1.0)))
        ),
        f"{side}ForeArm": about("y", -out * (elbow + phrase.detail(time_s, 1.5))),
        f"{side}Hand": about("y", -out * hand),
    }


def _legs(lower: _Lower) -> dict[str, FloatArray]:
    level = np.zeros(len(lower.root))
    parts = {}
    for side, (_, out) in SIDES.items():
        foot = about("y", level + out * FOOT_OUT_DEG)
        # A bent leg to start from, its knee over the foot; the reach for the ankle does the rest.
        thigh, knee = compose(foot, about("x", level - 15.0)), about("x", level + 30.0)
        parts[f"{side}UpLeg"] = compose(inverse(lower.pelvis), thigh)
        parts[f"{side}Leg"] = knee
        parts[f"{side}Foot"] = compose(inverse(compose(thigh, knee)), foot)
        parts[f"{side}Toe"] = about("x", level)
    return parts


def perform(gestures: tuple[Gesture, ...], frames: int, rate: float, seed: int, *, noise: float = 1.0) -> Motion:
    """Perform a phrase at the origin, facing +Z, feet planted; noise scales all that is drawn from the seed."""
    time_s = np.arange(frames) / rate
    phrase = _Phrase(gestures, seed, noise)
    lower = _lower(phrase, time_s)
    parts = {"Hips": lower.pelvis} | _legs(lower) | _trunk(phrase, time_s, lower)
    for side in SIDES:
        parts |= _arm(phrase, time_s, side)
    rotations = np.stack([parts[name] for name in humanoid.NAMES], axis=1)
    height = float(-sum(humanoid.OFFSETS[humanoid.index_of(name), 1] for name in ("LeftUpLeg", "LeftLeg", "LeftFoot")))
    ankle = np.array([FOOT_ASIDE_CM, humanoid.OFFSETS[0, 1] - height, 0.0])
    ankles = np.stack([ankle * np.array([out, 1.0, 1.0]) for _, out in SIDES.values()])
    motion = reach_feet(rotations, lower.root, np.broadcast_to(ankles, (frames, 2, 3)))
    return Motion(rotations=unroll(motion.rotations), root=motion.root)
