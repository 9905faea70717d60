"""Edits by name: every operation of a stack is the plain function, with times turned into frames and seconds."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mtex_usd import edit
from mtex_usd.edit.stack.operations import OPERATIONS, check_edit
from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip
from tests.synthetic import walk

FRAMES = 60
ARMS = ("LeftArm", "RightArm")
# Start and time codes per frame of the clips; what is said in time codes must say the same in all.
TIMINGS = ((0.0, 1.0), (101.0, 1.0), (-7.5, 0.25), (1000.0, 5.0))


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


TIMES = ("start", "end", "from", "to", "keys")
Case = tuple[str, dict[str, Any], Callable[[Clip, Clip], Clip], bool]


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


def test_every_operation_has_a_case() -> None:
    assert {op for op, _, _, _ in CASES.values()} == set(OPERATIONS)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(("start", "step"), TIMINGS)
def test_operations_are_the_plain_functions(case: str, start: float, step: float) -> None:
    op, settings, plain, takes_other = CASES[case]
    clip, other = make_clips(start, step)
    said = in_time_codes(settings, start, step)
    done = edit.run_stack(clip, [make_edit(op, *((other,) if takes_other else ()), **said)])
    expected = plain(clip, other)
    assert_same_bits(done.clip, expected)
    assert done.clip.frame_count == expected.frame_count
    assert_differs(done.clip, clip)


def assert_differs(one: Clip, two: Clip) -> None:
    assert one.frame_count != two.frame_count or (one.rotations != two.rotations).any()


IDENTITIES: dict[str, tuple[str, dict[str, Any], bool]] = {
    "lowpass": ("lowpass", {"frequencies": (12.0,)}, False),
    "highpass": ("highpass", {"frequencies": (0.0,)}, False),
    "bandpass": ("bandpass", {"frequencies": (0.0, 12.0)}, False),
    "equalize": ("equalize", {"gains": (0.0, 0.0, 0.0)}, False),
    "median": ("median", {"window": 0.01}, False),
    "robustMean": ("robustMean", {"window": 0.01}, False),
    "waveshape": ("waveshape", {"points": ((-200.0, -200.0), (200.0, 200.0)), "channels": ("*",)}, False),
    "shiftTime": ("shiftTime", {"from": (5.0,), "to": (5.0,)}, False),
    "scaleTime": ("scaleTime", {}, False),
    "scaleTime to its end": ("scaleTime", {"factor": 1.0, "end": float(FRAMES - 1)}, False),
    "warpTime": ("warpTime", {"from": (0.0, 30.0, 59.0), "to": (0.0, 30.0, 59.0)}, False),
    "blend": ("blend", {"weights": (0.0,)}, True),
    "blend keys": ("blend", {"weights": (0.0, 0.0), "keys": (10.0, 20.0)}, True),
    "displace": ("displace", {"keys": (20.0,), "channels": ("LeftArm",), "rotations": ((0.0, 0.0, 0.0),)}, False),
}


@pytest.mark.parametrize("case", IDENTITIES)
@pytest.mark.parametrize("span", [{}, {"start": 10.0, "end": 20.0}])
def test_identities_give_the_input_bit_for_bit(case: str, span: dict[str, float]) -> None:
    op, settings, takes_other = IDENTITIES[case]
    if span and "ramp" not in OPERATIONS[op].settings:
        pytest.skip(f"{op} acts at all times")
    clip, other = make_clips()
    done = run(clip, op, *((other,) if takes_other else ()), **{**settings, **span})
    assert_same_bits(done, clip)


def test_no_edit_gives_the_very_clip() -> None:
    clip, _ = make_clips()
    outcome = edit.run_stack(clip, [])
    assert outcome.clip is clip
    assert (outcome.keys, outcome.notes) == (None, ())


def test_edits_are_made_in_order() -> None:
    clip, _ = make_clips()
    slow, calm = make_edit("scaleTime", name="slow", factor=1.5), make_edit("lowpass", name="calm", frequencies=(1.0,))
    assert_same_bits(
        edit.run_stack(clip, [slow, calm]).clip, edit.lowpass(edit.scale_time(clip, factor=1.5), frequency=1.0)
    )
    assert_same_bits(
        edit.run_stack(clip, [calm, slow]).clip, edit.scale_time(edit.lowpass(clip, frequency=1.0), factor=1.5)
    )


def test_times_are_those_the_edits_before_have_left() -> None:
    """Frame 80 is there once the motion is half as fast."""
    clip, _ = make_clips()
    late = make_edit("displace", keys=(80.0,), channels=("LeftArm",), rotations=((0.0, 0.0, 40.0),), scope=(0.2, 0.2))
    slow = make_edit("scaleTime", factor=2.0)
    done = edit.run_stack(clip, [slow, late]).clip
    changed = np.flatnonzero((done.rotations != edit.scale_time(clip, factor=2.0).rotations).any(axis=(1, 2)))
    assert 80 in changed
    assert 74 < changed.min() <= changed.max() < 86


def test_loop_closes_what_the_edits_before_have_left() -> None:
    clip, _ = make_clips()
    calm = edit.lowpass(clip, frequency=1.0)
    done = edit.run_stack(clip, [make_edit("lowpass", frequencies=(1.0,)), make_edit("join")])
    assert_same_bits(done.clip, edit.join(calm, calm).clip)


def test_keys_are_those_of_the_last_edit() -> None:
    clip, _ = make_clips()
    reduce, calm = make_edit("reduceKeys", name="few", form="poses"), make_edit("lowpass", frequencies=(1.0,))
    last, first = edit.run_stack(clip, [calm, reduce]), edit.run_stack(clip, [reduce, calm])
    assert isinstance(last.keys, edit.ReducedPoses)
    assert last.notes == (
        f"few: {len(last.keys.frames)} poses for {FRAMES} frames, within "
        f"{last.keys.max_degrees:.2g} degrees and {last.keys.max_metres * 1000:.2g} mm",
    )
    assert first.keys is None
    assert len(first.notes) == 1


@pytest.mark.parametrize("form", ["curves", "poses"])
@pytest.mark.parametrize(("contacts", "asked"), [("declared", True), ("detect", True), ("off", False), (None, True)])
def test_contact_frames_stay_keys(form: str, contacts: str | None, asked: bool) -> None:
    clip, _ = make_clips()
    calls = []

    def find(found: Clip, which: str) -> tuple[int, ...]:
        calls.append((found is clip, which))
        return (13, 41)

    said = {} if contacts is None else {"contacts": contacts}
    keys = edit.run_stack(clip, [make_edit("reduceKeys", form=form, keys=(29.0,), **said)], find_contacts=find).keys
    assert calls == ([(True, contacts or "declared")] if asked else [])
    wanted = {29, 13, 41} if asked else {29}
    if isinstance(keys, edit.ReducedPoses):
        assert wanted <= set(keys.frames.tolist())
    else:
        assert isinstance(keys, edit.ReducedKeys)
        moving = [curve for curve in keys.curves if len(curve.values) > 1]
        assert moving
        assert all(wanted <= set(curve.time_codes.tolist()) for curve in moving)


def test_a_count_of_keys_goes_before_tolerances() -> None:
    clip, _ = make_clips()
    counted, both = ({"keyCount": 9}, {"keyCount": 9, "tolerance": 0.01, "distance": 0.0001})
    assert_same_bits(run(clip, "reduceKeys", form="poses", **both), run(clip, "reduceKeys", form="poses", **counted))


# --- blends time code by time code ---


def test_others_are_taken_at_the_same_time_codes() -> None:
    clip, _ = make_clips(start=10.0)
    long = walk(FRAMES + 30, seed=2, start=-5.0)
    same = replace(
        long,
        rotations=long.rotations[15 : 15 + FRAMES],
        translations=long.translations[15 : 15 + FRAMES],
        scales=long.scales[15 : 15 + FRAMES],
        start=10.0,
    )
    assert_same_bits(run(clip, "blend", long, weights=(0.5,)), run(clip, "blend", same, weights=(0.5,)))


def test_others_need_to_be_there_only_where_they_count() -> None:
    clip, _ = make_clips()
    short = walk(30, seed=2)
    done = run(clip, "blend", short, weights=(0.0, 1.0, 1.0, 0.0), keys=(5.0, 10.0, 20.0, 29.0))
    assert done.frame_count == FRAMES
    done = run(clip, "blend", short, weights=(1.0,), end=15.0)
    assert done.rotations[40:, 1:].tobytes() == clip.rotations[40:, 1:].tobytes()
    with pytest.raises(
        InputError,
        match=r"edit it \(blend\): /Take is not there for all of the motion; expected time "
        r"codes 0 to 59; found 0 to 29.*Set align",
    ):
        run(clip, "blend", short, weights=(0.5,))


def test_two_others_with_keys_are_rows_of_weights() -> None:
    clip, other = make_clips()
    third = walk(FRAMES, seed=3)
    done = run(clip, "blend", other, third, weights=(0.0, 0.0, 0.5, 0.25), keys=(0.0, 59.0))
    ramp = np.arange(FRAMES)[:, None] / 59.0
    assert_same_bits(done, edit.blend(clip, [other, third], weights=ramp * (0.5, 0.25), place="first").clip)


# --- spans ---

SPANNED = {op for op, operation in OPERATIONS.items() if "ramp" in operation.settings}


@pytest.mark.parametrize("case", [case for case, (op, _, _, _) in CASES.items() if op in SPANNED - {"blend"}])
@pytest.mark.parametrize(("start", "step"), TIMINGS[:3])
def test_spans_keep_what_is_outside(case: str, start: float, step: float) -> None:
    """Outside the bits of the motion, inside those of the whole edit, between one after the other."""
    op, settings, plain, _ = CASES[case]
    clip, other = make_clips(start, step)
    said = in_time_codes({**settings, "start": 20.0, "end": 39.0, "ramp": 8 / 24}, start, step)
    done, whole = run(clip, op, **said), plain(clip, other)
    outside = np.r_[0:16, 44:FRAMES]
    assert done.rotations[outside].tobytes() == clip.rotations[outside].tobytes()
    assert done.translations[outside].tobytes() == clip.translations[outside].tobytes()
    assert done.rotations[24:36].tobytes() == whole.rotations[24:36].tobytes()
    np.testing.assert_array_equal(done.translations[24:36], whole.translations[24:36])
    assert (done.rotations[24:36] != clip.rotations[24:36]).any()


def test_fades_go_one_way() -> None:
    clip, _ = make_clips()
    shifted = {"points": ((-400.0, -390.0), (400.0, 410.0)), "about": "rest", "channels": ("LeftArm.rx",)}
    done = run(clip, "waveshape", **shifted, start=20.0, end=39.0, ramp=8 / 24)
    joint = clip.joints.index("Hips/Spine/LeftArm")
    apart = 2.0 * np.degrees(np.arccos(np.clip(np.abs((done.rotations * clip.rotations).sum(-1)[:, joint]), 0.0, 1.0)))
    assert apart[29] == pytest.approx(10.0, abs=0.5)
    rising, falling = np.diff(apart[12:29]), np.diff(apart[30:47])
    assert (rising > -1e-5).all()
    assert (falling < 1e-5).all()
    assert (rising > 0.1).sum() >= 6


@pytest.mark.parametrize("ends", [{"start": 30.0}, {"end": 29.0}])
def test_spans_may_be_open(ends: dict[str, float]) -> None:
    clip, _ = make_clips()
    done, whole = run(clip, "lowpass", frequencies=(1.0,), ramp=0.0, **ends), edit.lowpass(clip, frequency=1.0)
    after = np.arange(FRAMES) >= 30
    inside = after if "start" in ends else ~after
    assert done.rotations[inside].tobytes() == whole.rotations[inside].tobytes()
    assert done.rotations[~inside].tobytes() == clip.rotations[~inside].tobytes()


def test_blend_within_a_span() -> None:
    clip, other = make_clips()
    done = run(clip, "blend", other, weights=(1.0,), start=20.0, end=39.0, ramp=0.0)
    whole = run(clip, "blend", other, weights=(1.0,))
    assert done.rotations[:20].tobytes() == clip.rotations[:20].tobytes()
    np.testing.assert_allclose(done.rotations[20:40, 1:], whole.rotations[20:40, 1:], atol=1e-12)
    assert done.rotations[40:, 1:].tobytes() == clip.rotations[40:, 1:].tobytes()


# --- refusals ---


BAD: list[tuple[str, dict[str, Any], int, str]] = [
    ("smooth", {}, 0, r"there is no such operation; expected one of lowpass, .*, reduceKeys; found 'smooth'"),
    ("lowpass", {}, 0, r"frequencies is not said; expected frequencies"),
    ("warpTime", {"from": (1.0,)}, 0, r"to is not said; expected from, to"),
    ("lowpass", {"frequencies": (1.0,), "factor": 2.0}, 0, r"it takes no factor; expected only frequencies, channels"),
    ("mirror", {"start": 2.0}, 0, r"it takes no start; expected only plane"),
    ("mirror", {}, 1, r"with does not fit; expected 0 other motions; found 1"),
    ("blend", {"weights": (1.0,)}, 0, r"with does not fit; expected 1 or more other motions; found 0"),
    ("align", {}, 2, r"with does not fit; expected 1 other motions; found 2"),
    ("join", {}, 2, r"with does not fit; expected 0 to 1 other motions; found 2"),
    ("lowpass", {"frequencies": (1.0, 2.0)}, 0, r"frequencies do not fit; expected one frequency, Hz; found \[1.0, 2"),
    ("bandpass", {"frequencies": (1.0,)}, 0, r"frequencies do not fit; expected the lower and the upper frequency"),
    ("lowpass", {"frequencies": (-1.0,)}, 0, r"bad frequency of the filter; expected above 0 Hz; found -1 Hz"),
    ("lowpass", {"frequencies": (1.0,), "channels": ("Tail",)}, 0, r"Tail"),
    (
        "lowpass",
        {"frequencies": (1.0,), "start": 70.0},
        0,
        r"there is no frame in its span; .*0 to 59; found 70 to inf",
    ),
    ("median", {"window": 0.2, "start": 30.0, "end": 20.0}, 0, r"there is no frame in its span; .*found 30 to 20"),
    ("waveshape", {"channels": ("LeftArm",)}, 0, r"no curve or two; expected either points or limits"),
    (
        "waveshape",
        {"channels": ("LeftArm",), "points": POINTS, "limits": (0.0, 1.0)},
        0,
        r"no curve or two; expected either points or limits",
    ),
    (
        "waveshape",
        {"channels": ("LeftArm",), "points": POINTS, "softness": 2.0},
        0,
        r"softness says nothing beside points",
    ),
    (
        "waveshape",
        {"channels": ("LeftArm",), "limits": (0.0, 90.0), "about": "rest"},
        0,
        r"about says nothing beside limits",
    ),
    ("shiftTime", {"from": (1.0, 2.0), "to": (1.0,)}, 0, r"from and to do not fit; .*; found 2 and 1 time codes"),
    (
        "scaleTime",
        {"end": 10.5},
        0,
        r"end is not at a frame of the motion; expected time codes from 0, 1 apart; found 10.5",
    ),
    ("scaleTime", {"end": -1.0}, 0, r"end is not at a frame of the motion; .*found -1"),
    ("scaleTime", {"ends": "loop"}, 0, r"nothing follows the motion, for there is no end\. Give end"),
    ("warpTime", {"from": (1.0, 2.0), "to": (1.0,)}, 0, r"from and to do not fit; .*in pairs; found 2 and 1"),
    ("warpTime", {"from": (), "to": ()}, 0, r"from and to do not fit"),
    ("warpTime", {"from": (0.0, 30.0), "to": (0.0, -1.0)}, 0, r"pairs of a time warp cross or coincide"),
    (
        "blend",
        {"weights": (1.0, 2.0)},
        1,
        r"weights do not fit; expected one for each of 1 other motions; found 2 weights",
    ),
    ("blend", {"weights": (1.0,), "keys": (1.0, 5.0)}, 1, r"weights do not fit; .*at each of 2 keys; found 1 weights"),
    ("blend", {"weights": (1.0, 0.0), "keys": (5.0, 5.0)}, 1, r"keys are not in order; expected time codes that rise"),
    (
        "join",
        {"from": (40.5,)},
        1,
        r"from is not at a frame of the motion; expected time codes from 0 to 59, 1 apart; found 40.5",
    ),
    ("join", {"to": (60.0,)}, 1, r"to is not at a frame of the motion; .*found 60"),
    ("join", {"from": (1.0, 2.0)}, 1, r"from and to do not fit; expected at most one time code each"),
    ("join", {"from": (40.0,), "start": 2.0}, 1, r"start and end say where to look, and from says it already"),
    (
        "displace",
        {"keys": (5.0,), "channels": ("LeftArm",)},
        0,
        r"no change, or two; expected either with, or rotations",
    ),
    (
        "displace",
        {"keys": (5.0,), "rotations": ((0.0, 0.0, 9.0),)},
        0,
        r"no joint is named; expected joints in channels",
    ),
    (
        "displace",
        {"keys": (5.0,), "channels": ARMS, "rotations": ((0.0, 0.0, 9.0),)},
        0,
        r"rotations do not fit; expected 2 for each of 1 keys, those of the first key first; found 1",
    ),
    ("displace", {"keys": (5.0,), "rotations": ((0.0, 0.0, 9.0),)}, 1, r"no change, or two"),
    (
        "displace",
        {"keys": (5.0,), "channels": ("LeftArm", "LeftArm"), "rotations": RAISED[:2]},
        0,
        r"a joint is named twice; expected every joint of channels once; found LeftArm, LeftArm",
    ),
    ("displace", {"keys": (5.0,), "channels": ("Tail",), "rotations": RAISED[:1]}, 0, r"Tail"),
    (
        "displace",
        {"keys": (5.0,), "channels": ("LeftArm",), "rotations": ((0.0, 0.0, 1e300),)},
        0,
        r"bad change of LeftArm at frame 5; expected three finite numbers, none beyond 1e\+09; found .*1e\+300",
    ),
    (
        "lowpass",
        {"frequencies": (1.0,), "end": 30.0, "ramp": 1e300},
        0,
        r"the fade is longer than the motion can fill; expected at most 5 s, twice the length of the motion; found 1e",
    ),
    ("displace", {"keys": (5.5,)}, 1, r"keys is not at a frame of the motion; .*found 5.5"),
    ("displace", {"keys": (), "channels": ARMS, "rotations": ()}, 0, r"no key; expected time codes in keys"),
    ("reduceKeys", {"keys": (5.5,)}, 0, r"keys is not at a frame of the motion; .*found 5.5"),
    ("reduceKeys", {"keys": (60.0,)}, 0, r"keys is not at a frame of the motion; .*found 60"),
]


@pytest.mark.parametrize(("op", "settings", "others", "message"), BAD)
def test_refusals_name_the_edit(op: str, settings: dict[str, Any], others: int, message: str) -> None:
    clip, *_ = make_clips()
    motions = [walk(FRAMES, seed=seed) for seed in range(2, 2 + others)]
    with pytest.raises(InputError, match=message) as caught:
        run(clip, op, *motions, **settings)
    assert str(caught.value).startswith(f"edit it ({op}): ")
    assert str(caught.value).count("edit it") == 1


def test_the_whole_stack_is_checked_before_anything_is_done() -> None:
    clip, _ = make_clips()
    edits = [make_edit("reduceKeys", name="few"), make_edit("lowpass", name="calm")]
    asked: list[tuple[object, ...]] = []

    def find(*said: object) -> tuple[int, ...]:
        asked.append(said)
        return ()

    with pytest.raises(InputError, match=r"edit calm \(lowpass\): frequencies is not said"):
        edit.run_stack(clip, edits, find_contacts=find)
    assert not asked


@pytest.mark.parametrize("op", OPERATIONS)
def test_every_setting_needed_is_missed(op: str) -> None:
    others = (make_clips()[1],) if OPERATIONS[op].others[0] else ()
    complete = dict.fromkeys(OPERATIONS[op].needs, ())
    check_edit(edit.Edit(name="e", op=op, settings=complete, others=others))
    for missing in complete:
        said = {name: value for name, value in complete.items() if name != missing}
        with pytest.raises(InputError, match=rf"edit e \({op}\): {missing} is not said"):
            check_edit(edit.Edit(name="e", op=op, settings=said, others=others))
