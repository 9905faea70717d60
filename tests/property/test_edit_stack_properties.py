"""Laws of edit stacks, for any span, fade and time codes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mtex_usd import edit
from mtex_usd.edit.stack.span import limit_to_span, span_weights
from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip
from tests.synthetic import walk

FRAMES = 40
CLIP = walk(FRAMES, seed=4)
STARTS = st.floats(-1000.0, 1000.0)
STEPS = st.sampled_from([0.2, 0.5, 1.0, 5.0, 1001.0 / 1000.0])
SECONDS = st.floats(0.0, 3.0)
FRAME = st.integers(0, FRAMES - 1)


def make_edit(op: str, **said: object) -> edit.Edit:
    return edit.Edit(name="it", op=op, settings=said)


def moved(start: float, step: float) -> Clip:
    return walk(FRAMES, seed=4, start=start, step=step)


@given(first=FRAME, last=FRAME, ramp=SECONDS, start=STARTS, step=STEPS)
def test_weights_are_a_fade_in_and_a_fade_out(first: int, last: int, ramp: float, start: float, step: float) -> None:
    first, last = min(first, last), max(first, last)
    clip = moved(start, step)
    codes = clip.time_codes
    weights = span_weights(make_edit("median", start=codes[first], end=codes[last], ramp=ramp), clip)
    assert weights is not None
    assert weights.shape == (FRAMES,)
    assert ((weights >= 0.0) & (weights <= 1.0)).all()
    top = int(weights.argmax())
    assert first <= top <= last
    assert (np.diff(weights[: top + 1]) >= 0.0).all()
    assert (np.diff(weights[top:]) <= 0.0).all()
    half = ramp * clip.rate / 2.0 + 1.0
    frames = np.arange(FRAMES)
    assert not weights[(frames < first - half) | (frames > last + half)].any()
    assert (weights[(frames > first + half) & (frames < last - half)] == 1.0).all()


@given(first=FRAME, last=FRAME, ramp=SECONDS)
def test_what_is_limited_lies_between(first: int, last: int, ramp: float) -> None:
    """Bits of the one or the other where the weight is 0 or 1; else no farther from either than they are apart."""
    said = make_edit("lowpass", start=float(min(first, last)), end=float(max(first, last)), ramp=ramp)
    whole = edit.lowpass(CLIP, frequency=1.5)
    done, weights = limit_to_span(said, CLIP, whole), span_weights(said, CLIP)
    assert weights is not None
    for name in ("rotations", "translations"):
        before, after, mixed = (getattr(clip, name) for clip in (CLIP, whole, done))
        assert mixed[weights == 0.0].tobytes() == before[weights == 0.0].tobytes()
        np.testing.assert_array_equal(mixed[weights == 1.0], after[weights == 1.0])
        apart = np.linalg.norm(after - before, axis=-1)
        assert (np.linalg.norm(mixed - before, axis=-1) <= apart + 1e-9).all()
        assert (np.linalg.norm(mixed - after, axis=-1) <= apart + 1e-9).all()


@settings(max_examples=30)
@given(start=STARTS, step=STEPS, frame=st.integers(3, FRAMES - 4), delay=st.integers(-2, 2))
def test_time_codes_mean_the_same_wherever_the_clip_lies(start: float, step: float, frame: int, delay: int) -> None:
    def run(clip: Clip) -> Clip:
        codes = clip.time_codes
        warp = make_edit(
            "warpTime", **{"from": codes[[0, frame, -1]].tolist(), "to": codes[[0, frame + delay, -1]].tolist()}
        )
        raise_arm = make_edit("displace", keys=[codes[frame]], channels=["LeftArm"], rotations=[(0.0, 0.0, 30.0)])
        calm = make_edit("lowpass", frequencies=[1.0], start=codes[frame])
        return edit.run_stack(clip, [warp, raise_arm, calm]).clip

    here, there = run(CLIP), run(moved(start, step))
    np.testing.assert_allclose(there.rotations, here.rotations, atol=1e-8)
    np.testing.assert_allclose(there.translations, here.translations, atol=1e-6)
    assert (there.start, there.time_codes_per_frame) == (start, step)


@settings(max_examples=30)
@given(cut=st.integers(0, 3), frequency=st.floats(0.3, 5.0), factor=st.floats(0.5, 2.0))
def test_a_stack_is_its_parts_one_after_the_other(cut: int, frequency: float, factor: float) -> None:
    edits = [
        make_edit("lowpass", frequencies=[frequency]),
        make_edit("scaleTime", factor=factor),
        make_edit("mirror"),
    ]
    whole = edit.run_stack(CLIP, edits).clip
    parts = edit.run_stack(edit.run_stack(CLIP, edits[:cut]).clip, edits[cut:]).clip
    assert whole.rotations.tobytes() == parts.rotations.tobytes()
    assert whole.translations.tobytes() == parts.translations.tobytes()


@given(frame=st.floats(0.0, FRAMES - 1.0), start=STARTS, step=STEPS)
def test_time_codes_between_frames_are_refused(frame: float, start: float, step: float) -> None:
    clip = moved(start, step)
    code = start + step * frame
    said = make_edit("join", **{"from": [code]})
    off = abs((code - start) / step - round((code - start) / step))
    if off <= 1e-6:
        assert said.whole_frames("from", clip) == [round(frame)]
        return
    with pytest.raises(InputError, match=r"edit it \(join\): from is not at a frame of the motion"):
        said.whole_frames("from", clip)


@given(frame=FRAME, start=STARTS, step=STEPS)
def test_time_codes_of_frames_are_those_frames(frame: int, start: float, step: float) -> None:
    """Whatever rounding the clip's own time codes have."""
    clip = moved(start, step)
    assert make_edit("join", **{"from": [clip.time_codes[frame]]}).whole_frames("from", clip) == [frame]
