"""What the samples show: the takes of the library and the motions behind the sketches, each with its numbers."""

from dataclasses import dataclass

from tests.samples.contacts import Motion
from tests.samples.gait import FRAME_RATE, Gait, walk, walk_to_stop
from tests.samples.phrase import Gesture, perform
from tests.samples.sketch import block

__all__ = ["GAITS", "PHRASES", "SKETCH_GAIT", "STOP_FRAME", "Take", "sketch_motions", "takes"]

TAKE_FRAMES = 240
WALK_FRAMES = 171
STOP_FRAMES = 191
STOP_FRAME = 96
PHRASE_FRAMES = 146
BRAKE_S = 2.6

# Cadences 87, 105 and 123 steps a minute: slow, natural and fast of Winter 1991. Amplitudes with speed after Murray,
# Mollinger, Gardner & Sepic 1984 (J. Orthop. Res. 2:272-280); arms after Murray, Sepic & Barnard 1967.
GAITS = {
    "walk_slow": Gait(
        seed=11, stride_s=1.38, hip=0.86, knee=0.93, ankle=0.9, pelvis=0.85, thorax=0.8, shoulder=0.65, elbow=0.6,
        lean_deg=4.0, head_deg=6.0, elbow_deg=-3.0,
    ),
    "walk_natural": Gait(seed=12, stride_s=1.14, turn_deg=20.0),
    "walk_brisk": Gait(
        seed=13, stride_s=0.975, hip=1.1, knee=1.02, ankle=1.0, pelvis=1.15, thorax=1.3, shoulder=1.35, elbow=1.2,
        lean_deg=3.5, elbow_deg=8.0, head_deg=-2.0, arm_lag=0.02,
    ),
}  # fmt: skip
# The animator's walker: between slow and natural, and without any variation.
SKETCH_GAIT = Gait(
    seed=21, stride_s=1.25, hip=0.94, knee=1.0, ankle=0.7, pelvis=0.6, variation=0.0, detail_deg=0.0, toe_bend=0.0
)


def _gesture(what: str, amount: float, start_s: float, out_s: float, hold_s: float, back_s: float) -> Gesture:
    return Gesture(what=what, amount=amount, start_s=start_s, out_s=out_s, hold_s=hold_s, back_s=back_s)


PHRASES = {
    "phrase_reach": (
        _gesture("sway", 9.0, 0.3, 1.0, 0.1, 1.0),
        _gesture("sway", -9.0, 1.9, 1.1, 0.2, 1.1),
        _gesture("crouch", 18.0, 3.9, 1.1, 0.2, 1.2),
        _gesture("lunge", 7.0, 5.2, 1.0, 0.3, 1.1),
        _gesture("turn", 24.0, 6.7, 0.9, 0.1, 1.0),
        _gesture("crouch", 10.0, 7.9, 0.8, 0.1, 0.9),
        _gesture("sway", 6.0, 8.3, 0.7, 0.0, 0.7),
    ),
    "phrase_turn": (
        _gesture("turn", 26.0, 0.2, 1.0, 0.2, 1.0),
        _gesture("turn", -26.0, 1.8, 1.2, 0.1, 1.1),
        _gesture("crouch", 14.0, 2.6, 1.0, 0.1, 1.0),
        _gesture("sway", -8.0, 4.4, 0.9, 0.2, 1.0),
        _gesture("crouch", 22.0, 5.6, 1.3, 0.1, 1.2),
        _gesture("turn", -18.0, 6.3, 1.0, 0.2, 1.1),
        _gesture("sway", 8.0, 7.6, 0.9, 0.1, 0.9),
    ),
}
_SKETCHED_PHRASE = (
    _gesture("sway", -7.5, 0.2, 1.1, 0.1, 1.1),
    _gesture("crouch", 16.0, 1.8, 1.2, 0.1, 1.1),
    _gesture("turn", 20.0, 3.0, 1.0, 0.1, 1.1),
    _gesture("sway", 7.5, 4.2, 0.8, 0.0, 0.8),
)


@dataclass(frozen=True, kw_only=True)
class Take:
    """A take of the library: its prim name, style and motion."""

    name: str
    style: str
    motion: Motion


def takes() -> tuple[Take, ...]:
    """Make the takes of the library."""
    walks = [Take(name=name, style="walk", motion=walk(gait, TAKE_FRAMES)) for name, gait in GAITS.items()]
    phrases = [
        Take(name=name, style="phrase", motion=perform(gestures, TAKE_FRAMES, FRAME_RATE, 31 + number))
        for number, (name, gestures) in enumerate(PHRASES.items())
    ]
    return (*walks, *phrases)


def sketch_motions() -> dict[str, Motion]:
    """Make the motion of every sketch, by the name of its stage."""
    strides = STOP_FRAME / FRAME_RATE / SKETCH_GAIT.stride_s
    stop = walk_to_stop(SKETCH_GAIT, STOP_FRAMES, strides=strides, brake_s=BRAKE_S)
    return {
        "walk": block(walk(SKETCH_GAIT, WALK_FRAMES)),
        "walk_to_stop": block(stop),
        "phrase": block(perform(_SKETCHED_PHRASE, PHRASE_FRAMES, FRAME_RATE, 41, noise=0.0)),
    }
