"""The speed benchmark measures what it says; the times themselves are for ``python -m tests.benchmarks.speed``."""

from pathlib import Path

import pytest
from pxr import Usd

import mtex_usd
from tests.benchmarks.speed import HELP_LIMIT, PATHS, compare, compare_help, copy_bare, count_samples
from tests.benchmarks.speed_shot import FRAMES, JOINTS, SKETCH, TAKE_COUNT, write_shot


@pytest.mark.parametrize(("take_rate", "frames"), [(24.0, FRAMES), (120.0, 2196)])
def test_the_shot_is_as_large_as_agreed(tmp_path: Path, take_rate: float, frames: int) -> None:
    stage = Usd.Stage.Open(str(write_shot(tmp_path, take_rate=take_rate)))
    animations = [prim for prim in stage.Traverse() if prim.IsA("SkelAnimation")]
    assert len(animations) == 1 + TAKE_COUNT == 13
    assert len(JOINTS) == 31
    for prim in animations:
        expected = FRAMES if str(prim.GetPath()) == SKETCH else frames
        assert prim.GetAttribute("rotations").GetNumTimeSamples() == expected
        assert len(prim.GetAttribute("joints").Get()) == 31


def test_the_yardstick_writes_as_many_samples(tmp_path: Path) -> None:
    shot = write_shot(tmp_path, take_rate=24.0)
    (result,) = mtex_usd.process(shot, out=tmp_path / "out.usd", paths=PATHS)
    assert len(result.variants) == PATHS
    counts = count_samples(result.layer)
    assert counts["rotations"] == PATHS * FRAMES
    copy_bare(shot, tmp_path / "bare.usd", counts)
    assert count_samples(tmp_path / "bare.usd") == counts


def test_comparing_takes_turns_and_medians() -> None:
    calls = []
    found = compare(lambda: calls.append("measured"), lambda: calls.append("yardstick"), runs=3)
    assert calls == ["measured", "yardstick"] * 4
    assert found.ratio == found.measured / found.yardstick


def test_help_is_quicker_than_loading_usd() -> None:
    assert compare_help(runs=3).ratio < HELP_LIMIT
