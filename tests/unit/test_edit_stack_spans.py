"""Edits within a span of time, and blends time code by time code."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd import edit
from mtex_usd.edit.stack.operations import OPERATIONS
from mtex_usd.errors import InputError
from tests.edit_stack_cases import CASES, FRAMES, TIMINGS, assert_same_bits, in_time_codes, make_clips, run
from tests.synthetic import walk


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
