"""Edits before and after texturing: of the takes, and of every version."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd

import mtex_usd
from mtex_usd import edit
from tests.synthetic import make_skeleton, walk
from tests.usd import edit_support as support
from tests.usd.edit_support import ANIMATION, BEFORE, FEW, FRAMES, HALF, MODEL, OTHER, play, play_clip, write_shot
from tests.usd.playback import select_variant

SKETCH = """
    rel mtex:takes = </Takes/Other>
    uniform token[] mtex:match = ["LeftUpLeg.rx"]
    uniform token[] mtex:texture = ["LeftUpLeg.rx"]
    uniform token[] mtex:synthesize = ["LeftArm", "RightArm"]
"""
AFTER = """
    uniform token[] mtex:edits:after = ["slow", "calm"]
    uniform token mtex:edit:slow:op = "scaleTime"
    uniform double mtex:edit:slow:factor = 1.5
    uniform token mtex:edit:calm:op = "lowpass"
    uniform double[] mtex:edit:calm:frequencies = [2]
"""


def write_sketch(folder: Path, body: str, edits: tuple[str, ...], *, more: str = "", name: str = "shot.usda") -> Path:
    if not (folder / "base.usda").exists():
        support.write_base(folder, take_frames=240)
    return write_shot(folder, body, edits, more=more, name=name, schemas=("MtexSketchAPI",))


def assert_same_variants(one: Any, two: Any) -> None:
    for mine, theirs in zip(one.variants, two.variants, strict=True):
        for fragment, other in zip(mine.fragments, theirs.fragments, strict=True):
            assert {**fragment, "distance": pytest.approx(fragment.distance)} == dict(other)
        np.testing.assert_allclose(mine.clip.rotations, theirs.clip.rotations, atol=1e-5)
        np.testing.assert_allclose(mine.clip.translations, theirs.clip.translations, atol=1e-3)


def test_edits_after_are_made_of_every_version(tmp_path: Path) -> None:
    (plain,) = mtex_usd.process(write_sketch(tmp_path, SKETCH, (), name="plain.usda"), paths=2)
    (result,) = mtex_usd.process(write_sketch(tmp_path, SKETCH + AFTER, ("slow", "calm")), paths=2)
    for before, after in zip(plain.variants, result.variants, strict=True):
        expected = edit.lowpass(edit.scale_time(before.clip, factor=1.5), frequency=2.0)
        assert after.clip.rotations.tobytes() == expected.rotations.tobytes()
        assert after.clip.frame_count == 89
        played = play(result.stage, after.clip.time_codes.tolist(), after.name)
        np.testing.assert_allclose(played, play_clip(expected), atol=2e-4)
    assert Usd.Stage.Open(str(result.stage)).GetEndTimeCode() == 88.0


def test_keys_after_texturing(tmp_path: Path) -> None:
    body = SKETCH + AFTER.replace('"slow", "calm"', '"few"') + FEW.split('"lowpass"')[1].split("frequencies = [3]")[1]
    (result,) = mtex_usd.process(write_sketch(tmp_path, body, ("slow", "calm", "few")), paths=2)
    stage = Usd.Stage.Open(str(result.stage))
    for variant in result.variants:
        select_variant(stage, MODEL, "mtex", variant.name)
        times = stage.GetPrimAtPath(f"{ANIMATION}_mtex").GetAttribute("rotations").GetTimeSamples()
        assert {0.0, 17.0, 43.0, 59.0} <= set(times)
        assert len(times) < FRAMES


@pytest.mark.parametrize("on", ["take", "sketch"])
def test_edits_before_are_made_of_takes(tmp_path: Path, on: str) -> None:
    """As if the takes had been edited by hand and written."""
    if on == "take":
        shot = write_sketch(tmp_path, SKETCH, (), more=support.declare(OTHER, BEFORE_LONG, ["quick"]))
    else:
        shot = write_sketch(tmp_path, SKETCH + BEFORE_LONG, ("quick",))
    (result,) = mtex_usd.process(shot, paths=2)
    by_hand = tmp_path / "by_hand"
    by_hand.mkdir()
    support.write_base(by_hand, take_frames=240)
    stage = Usd.Stage.Open(str(by_hand / "base.usda"))
    stage.RemovePrim(OTHER)
    support.write_animation(stage, OTHER, edit.scale_time(walk(240, seed=2), factor=0.5))
    stage.Save()
    (expected,) = mtex_usd.process(write_sketch(by_hand, SKETCH, ()), paths=2)
    assert_same_variants(result, expected)
    (untouched,) = mtex_usd.process(write_sketch(tmp_path, SKETCH, (), name="plain.usda"), paths=2)
    assert np.abs(untouched.variants[0].clip.rotations - result.variants[0].clip.rotations).max() > 0.01


BEFORE_LONG = BEFORE.split("    uniform timecode", maxsplit=1)[0]


def test_edits_before_with_another_motion_on_takes_of_another_skeleton(tmp_path: Path) -> None:
    """The sketch's edits bring a motion on its joints; its takes may have others."""
    support.write_base(tmp_path, take_frames=240)
    stage = Usd.Stage.Open(str(tmp_path / "base.usda"))
    foreign = walk(240, seed=9, skeleton=make_skeleton(oriented=5))
    support.write_animation(stage, "/Takes/Foreign", foreign)
    support.write_skeleton(stage, "/Takes/ForeignRig", foreign.skeleton, "/Takes/Foreign")
    stage.Save()
    body = SKETCH.replace("</Takes/Other>", "[</Takes/Other>, </Takes/Foreign>]") + HALF.replace(
        "edits =", "edits:before ="
    )
    shot = write_sketch(tmp_path, body % (OTHER, 0.5), ("half",))
    (result,) = mtex_usd.process(shot, paths=2)
    assert len(result.variants) == 2
