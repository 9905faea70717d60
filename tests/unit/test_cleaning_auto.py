"""Choosing steps by name, and automatically."""

import numpy as np
import pytest

from mtex_usd.edit.cleaning import CLEANING_STEPS, CleaningResult, check_steps, clean_auto, clean_clip
from mtex_usd.edit.cleaning.report import Finding, list_runs
from mtex_usd.errors import InputError
from tests.cleaning_support import add_noise, flip, make_walk, prepend_rest, turn_joint
from tests.synthetic import LEFT_ARM, LEFT_KNEE, LEFT_LEG, RIGHT_ARM, SPINE


def far_from_rest(frames=240):
    clip = make_walk(frames)
    for joint in (LEFT_ARM, RIGHT_ARM, SPINE):
        clip = turn_joint(clip, joint, 0, frames - 1, 60.0)
    return clip


def test_auto_leaves_a_clean_clip_as_it_is():
    clip = make_walk()
    result = clean_auto(clip)
    assert result.clip is clip
    assert result.changes == ()


def test_auto_counts_frames_in_the_clip_given():
    dirty = prepend_rest(turn_joint(flip(far_from_rest(), LEFT_LEG, 100, 105), LEFT_KNEE, 150, 150, 80.0), 2)
    result = clean_auto(dirty)
    found = [(change.step, change.first, change.last) for change in result.changes]
    assert found == [("leading", 0, 1), ("flips", 102, 107), ("flips", 102, 107), ("spikes", 152, 152)]
    assert result.dropped_frames == 2
    assert result.clip.frame_count == dirty.frame_count - 2


def test_auto_filters_what_is_very_noisy():
    assert {change.step for change in clean_auto(add_noise(make_walk(), 2.0)).changes} == {"noise"}
    assert clean_auto(add_noise(make_walk(), 0.3)).changes == ()


def test_steps_run_in_the_order_given():
    result = clean_clip(prepend_rest(flip(far_from_rest(), LEFT_LEG, 100, 105)), ("flips", "leading"))
    assert [(change.step, change.first) for change in result.changes] == [
        ("flips", 101),
        ("flips", 101),
        ("leading", 0),
    ]


def test_no_steps_change_nothing():
    clip = flip(make_walk(), LEFT_LEG, 100, 105)
    assert clean_clip(clip, ()).clip is clip


@pytest.mark.parametrize("steps", [(), ("auto",), ("leading", "flips"), tuple(CLEANING_STEPS)])
def test_known_steps_pass(steps):
    assert check_steps(steps) is None


def test_unknown_step_lists_what_there_is():
    with pytest.raises(
        InputError, match="unknown step of the clean-up: flip, x; expected auto or any of leading, gaps"
    ):
        clean_clip(make_walk(10), ("flip", "leading", "x"))


def test_auto_stands_alone():
    with pytest.raises(InputError, match=r"auto chooses the steps itself; found auto,flips\. Give auto alone"):
        check_steps(("auto", "flips"))


def test_every_step_takes_the_shortest_clips():
    for frames in (1, 2, 3, 5):
        clip = make_walk(8)
        short = clean_clip(type(clip)(**{**_fields(clip), **_cut(clip, frames)}), ("auto",))
        assert short.clip.frame_count == frames


def _fields(clip):
    return {name: getattr(clip, name) for name in clip.__dataclass_fields__}


def _cut(clip, frames):
    return {name: getattr(clip, name)[:frames] for name in ("rotations", "translations", "scales")}


def test_results_add_up():
    clip = make_walk(10)
    change = Finding(step="a", joint="", first=2, last=3, what="x")
    first = CleaningResult(clip=clip, dropped_frames=4)
    both = first.then(CleaningResult(clip=clip, changes=(change,), notes=(change,), dropped_frames=1))
    assert (both.changes[0].first, both.changes[0].last, both.notes[0].first) == (6, 7, 6)
    assert both.dropped_frames == 5


def test_runs_are_listed():
    assert list_runs(np.array([True, False, True, True])) == [(0, 0), (2, 3)]
    assert list_runs(np.zeros(3, dtype=bool)) == []


def test_finding_reads_as_a_line():
    whole = Finding(step="leading", joint="", first=0, last=0, what="taken off")
    assert str(whole) == "leading: frame 0: taken off"
    assert str(Finding(step="flips", joint="A/B", first=1, last=2, what="turned")) == "flips: B frames 1-2: turned"
