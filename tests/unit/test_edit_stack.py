"""Edits by name: every operation of a stack is the plain function, with times turned into frames and seconds."""

from typing import Any

import numpy as np
import pytest

from mtex_usd import edit
from mtex_usd.edit.stack.operations import OPERATIONS
from mtex_usd.motion.clip import Clip
from tests.edit_stack_cases import CASES, FRAMES, TIMINGS, assert_same_bits, in_time_codes, make_clips, make_edit, run


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


SPANNED = [case for case, (op, _, _) in IDENTITIES.items() if "ramp" in OPERATIONS[op].settings]
SPAN = {"start": 10.0, "end": 20.0}


@pytest.mark.parametrize(("case", "span"), [*((case, {}) for case in IDENTITIES), *((case, SPAN) for case in SPANNED)])
def test_identities_give_the_input_bit_for_bit(case: str, span: dict[str, float]) -> None:
    op, settings, takes_other = IDENTITIES[case]
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
