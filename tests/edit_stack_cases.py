"""Every operation of a stack with its settings, and the plain functions that it should be."""

from collections.abc import Callable
from typing import Any

import numpy as np

from mtex_usd import edit
from mtex_usd.motion.clip import Clip
from tests.synthetic import walk

__all__ = [
    "ARMS",
    "CASES",
    "FRAMES",
    "POINTS",
    "RAISED",
    "TIMINGS",
    "assert_same_bits",
    "in_time_codes",
    "make_clips",
    "make_edit",
    "run",
]

FRAMES = 60
ARMS = ("LeftArm", "RightArm")
# Start and time codes per frame of the clips; what is said in time codes must say the same in all.
TIMINGS = ((0.0, 1.0), (101.0, 1.0), (-7.5, 0.25), (1000.0, 5.0))
TIMES = ("start", "end", "from", "to", "keys")
Case = tuple[str, dict[str, Any], Callable[[Clip, Clip], Clip], bool]


def make_clips(start: float = 0.0, step: float = 1.0) -> tuple[Clip, Clip]:
    return tuple(walk(FRAMES, seed=seed, name=f"/Take{seed}", start=start, step=step) for seed in (1, 2))


def make_edit(op: str, *others: Clip, name: str = "it", **settings: Any) -> edit.Edit:
    """Settings whose names are Python's words have an underscore behind them."""
    return edit.Edit(name=name, op=op, settings={k.rstrip("_"): v for k, v in settings.items()}, others=others)


def run(clip: Clip, op: str, *others: Clip, **settings: Any) -> Clip:
    return edit.run_stack(clip, [make_edit(op, *others, **settings)]).clip


def in_time_codes(settings: dict[str, Any], start: float, step: float) -> dict[str, Any]:
    return {
        name: np.add(start, np.multiply(step, value)) if name in TIMES else value for name, value in settings.items()
    }


def assert_same_bits(one: Clip, two: Clip) -> None:
    for name in ("rotations", "translations", "scales"):
        assert getattr(one, name).tobytes() == getattr(two, name).tobytes(), name
    assert (one.start, one.time_codes_per_frame, one.rate) == (two.start, two.time_codes_per_frame, two.rate)
    assert one.joints == two.joints


def pairs(*rows: tuple[float, float]) -> np.ndarray:
    return np.array(rows, dtype=np.float64)


def blended(clip: Clip, other: Clip, **options: Any) -> Clip:
    return edit.blend(clip, other, **options).clip


def brought_into_step(clip: Clip, other: Clip, **options: Any) -> Clip:
    """Warp the other into the time of the clip."""
    return edit.warp_time(other, pairs=edit.align(other, clip, **options).pairs, frame_count=clip.frame_count)


def joined(clip: Clip, other: Clip, **options: Any) -> Clip:
    return edit.join(clip, other, **options).clip


def cut(left: int, entered: int) -> edit.Transition:
    return edit.Transition(frame=left, other_frame=entered, distance=float("nan"))


def to_other(clip: Clip, other: Clip, frames: tuple[int, ...], **options: Any) -> Clip:
    keys = [edit.PoseChange.to_clip(clip, other, frame=f, target_frame=f, **options) for f in frames]
    return edit.displace(clip, edit.Displacement(keys=keys))


def raised(clip: Clip, *, scope: tuple[float, float] | None = None) -> Clip:
    keys = [
        edit.PoseChange(frame=20.0, rotations={"LeftArm": (0, 0, 30), "RightArm": (0, 0, -30)}),
        edit.PoseChange(frame=30.5, rotations={"LeftArm": (10, 0, 0), "RightArm": (20, 0, 0)}),
    ]
    return edit.displace(clip, edit.Displacement(keys=keys, scope=scope))


RAISED = ((0.0, 0.0, 30.0), (0.0, 0.0, -30.0), (10.0, 0.0, 0.0), (20.0, 0.0, 0.0))
POINTS = ((-30.0, -20.0), (0.0, 0.0), (30.0, 45.0))
WEIGHTS = np.interp(np.arange(FRAMES), [10, 30], [0.0, 1.5])[:, None]

# The operation, its settings with frames for time codes, the plain call, and whether it takes the other motion.
CASES: dict[str, Case] = {
    "lowpass": ("lowpass", {"frequencies": (2.0,)}, lambda c, _: edit.lowpass(c, frequency=2.0), False),
    "lowpass channels": (
        "lowpass",
        {"frequencies": (2.0,), "channels": ARMS, "order": 2},
        lambda c, _: edit.lowpass(c, frequency=2.0, channels=ARMS, order=2),
        False,
    ),
    "highpass": (
        "highpass",
        {"frequencies": (1.0,), "channels": ARMS, "order": 3},
        lambda c, _: edit.highpass(c, frequency=1.0, channels=ARMS, order=3),
        False,
    ),
    "bandpass": (
        "bandpass",
        {"frequencies": (1.0, 3.0), "channels": ARMS, "order": 2},
        lambda c, _: edit.bandpass(c, frequencies=(1.0, 3.0), channels=ARMS, order=2),
        False,
    ),
    "equalize": (
        "equalize",
        {"gains": (0.0, 6.0, -np.inf), "residualGain": 3.0, "channels": ARMS},
        lambda c, _: edit.equalize(c, gains=(0.0, 6.0, -np.inf), residual_gain=3.0, channels=ARMS),
        False,
    ),
    "median": (
        "median",
        {"window": 0.3, "channels": ARMS},
        lambda c, _: edit.median(c, window_s=0.3, channels=ARMS),
        False,
    ),
    "robustMean": (
        "robustMean",
        {"window": 0.3, "discard": 0.2, "channels": ARMS},
        lambda c, _: edit.robust_mean(c, window_s=0.3, discard=0.2, channels=ARMS),
        False,
    ),
    "waveshape points": (
        "waveshape",
        {"points": POINTS, "about": "rest", "channels": ("LeftArm.rx",)},
        lambda c, _: edit.waveshape(c, points=POINTS, about="rest", channels=["LeftArm.rx"]),
        False,
    ),
    "waveshape limits": (
        "waveshape",
        {"limits": (-5.0, np.inf), "softness": 4.0, "channels": ("LeftArm.rx",)},
        lambda c, _: edit.waveshape(
            c, points=edit.make_soft_limits(-5.0, np.inf, softness=4.0), about="rest", channels=["LeftArm.rx"]
        ),
        False,
    ),
    "mirror": ("mirror", {"plane": "facing"}, lambda c, _: edit.mirror(c, plane="facing"), False),
    "shiftTime": (
        "shiftTime",
        {"from": (10.0,), "to": (14.5,), "ends": "extrapolate", "channels": ARMS},
        lambda c, _: edit.shift_time(c, shift_s=4.5 / c.rate, ends="extrapolate", channels=ARMS),
        False,
    ),
    "scaleTime": ("scaleTime", {"factor": 0.8}, lambda c, _: edit.scale_time(c, factor=0.8), False),
    "scaleTime to an end": (
        "scaleTime",
        {"factor": 0.8, "end": 99.0, "ends": "loop"},
        lambda c, _: edit.scale_time(c, factor=0.8, frame_count=100, ends="loop"),
        False,
    ),
    "scaleTime channels": (
        "scaleTime",
        {"factor": 0.8, "channels": ARMS, "ends": "extrapolate"},
        lambda c, _: edit.scale_time(c, factor=0.8, channels=ARMS, ends="extrapolate"),
        False,
    ),
    "warpTime": (
        "warpTime",
        {"from": (0.0, 20.0, 59.0), "to": (0.0, 25.5, 70.0)},
        lambda c, _: edit.warp_time(c, pairs=pairs((0, 0), (20, 25.5), (59, 70))),
        False,
    ),
    "warpTime to an end": (
        "warpTime",
        {"from": (0.0, 20.0, 59.0), "to": (0.0, 25.0, 59.0), "end": 79.0, "ends": "hold"},
        lambda c, _: edit.warp_time(c, pairs=pairs((0, 0), (20, 25), (59, 59)), frame_count=80),
        False,
    ),
    "align": (
        "align",
        {"channels": ("*Leg.rx",), "maxSlope": 2, "band": 0.5, "free": 0.2},
        lambda c, o: edit.warp_time(
            c,
            pairs=edit.align(c, o, channels=["*Leg.rx"], max_slope=2, band_s=0.5, free_s=0.2).pairs,
            frame_count=o.frame_count,
        ),
        True,
    ),
    "blend": (
        "blend",
        {"weights": (1.5,)},
        lambda c, o: blended(c, o, weights=1.5, place="first"),
        True,
    ),
    "blend keys": (
        "blend",
        {"weights": (0.0, 1.5), "keys": (10.0, 30.0), "place": "mean"},
        lambda c, o: blended(c, [o], weights=WEIGHTS, place="mean"),
        True,
    ),
    "blend aligned": (
        "blend",
        {"weights": (0.5,), "align": True, "free": 0.5, "maxSlope": 2, "band": 1.5},
        lambda c, o: blended(
            c, brought_into_step(c, o, free_s=0.5, max_slope=2, band_s=1.5), weights=0.5, place="first"
        ),
        True,
    ),
    "join": (
        "join",
        {"joinTime": 0.5, "method": "blend"},
        lambda c, o: joined(c, o, blend_s=0.5, method="blend"),
        True,
    ),
    "join there": (
        "join",
        {"from": (40.0,), "to": (12.0,), "method": "interpolate"},
        lambda c, o: joined(c, o, transition=cut(40, 12), method="interpolate"),
        True,
    ),
    "join within": (
        "join",
        {"start": 20.0, "end": 40.0},
        lambda c, o: joined(c, o, transition=edit.find_transition(c, o, frames=(20, 40))),
        True,
    ),
    "join into": (
        "join",
        {"to": (15.0,)},
        lambda c, o: joined(c, o, transition=edit.find_transition(c, o, frames=(0, FRAMES - 1), other_frames=(15, 15))),
        True,
    ),
    "loop": ("join", {}, lambda c, _: joined(c, c), False),
    "displace": (
        "displace",
        {"keys": (20.0, 30.5), "channels": ARMS, "rotations": RAISED},
        lambda c, _: raised(c),
        False,
    ),
    "displace scope": (
        "displace",
        {"keys": (20.0, 30.5), "channels": ARMS, "rotations": RAISED, "scope": (0.25, 0.5)},
        lambda c, _: raised(c, scope=(0.25 * c.rate, 0.5 * c.rate)),
        False,
    ),
    "displace to poses": (
        "displace",
        {"keys": (10.0, 40.0), "channels": ARMS},
        lambda c, o: to_other(c, o, (10, 40), channels=ARMS),
        True,
    ),
    "reduceKeys": (
        "reduceKeys",
        {"tolerance": 2.0, "distance": 0.02, "channels": ARMS},
        lambda c, _: edit.reduce_keys(c, tolerance_deg=2.0, tolerance_m=0.02, channels=ARMS).evaluate(),
        False,
    ),
    "reduceKeys poses": (
        "reduceKeys",
        {"form": "poses", "tolerance": 2.0, "distance": 0.02, "keys": (7.0, 33.0), "robust": True},
        lambda c, _: edit.reduce_poses(
            c, tolerance_deg=2.0, tolerance_m=0.02, contact_frames=[7, 33], robust=True
        ).evaluate(),
        False,
    ),
    "reduceKeys count": (
        "reduceKeys",
        {"form": "poses", "keyCount": 9},
        lambda c, _: edit.reduce_poses(c, key_count=9).evaluate(),
        False,
    ),
}
