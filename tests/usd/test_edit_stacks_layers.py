"""Stacks of edits that come through layers: in sublayers and references moved in time, and with assets."""

from pathlib import Path

import numpy as np
import pytest

import mtex_usd
from tests.usd.edit_support import HEADER, MODEL, NAMES, STACKS, by_variant, play, play_clip, write_shot

TIMED = """
    uniform token[] mtex:edits = ["warp", "raise", "calm"]
    uniform token[] mtex:edits:looped = ["loop"]
    uniform token mtex:edit:warp:op = "warpTime"
    uniform timecode[] mtex:edit:warp:from = [0, 20, 59]
    uniform timecode[] mtex:edit:warp:to = [0, 24.5, 59]
    uniform timecode mtex:edit:warp:end = 49
    uniform token mtex:edit:raise:op = "displace"
    uniform timecode[] mtex:edit:raise:keys = [10, 30]
    rel mtex:edit:raise:with = </Takes/Other>
    uniform token mtex:edit:calm:op = "blend"
    rel mtex:edit:calm:with = </Takes/Other>
    uniform double[] mtex:edit:calm:weights = [0, 1, 0.5]
    uniform timecode[] mtex:edit:calm:keys = [5, 20, 30]
    uniform timecode mtex:edit:calm:start = 12
    uniform timecode mtex:edit:calm:end = 40
    uniform double mtex:edit:calm:ramp = 0
    uniform token mtex:edit:loop:op = "join"
    uniform timecode mtex:edit:loop:start = 30
    uniform timecode mtex:edit:loop:end = 59
"""
RETARGETED = "".join(f"rel mtex:edit:{name}:with = </Takes/Other>\n" for name in ("raise", "calm"))


def write_timed(folder: Path) -> None:
    """Write ``edits.usda``, with edits that name times."""
    write_shot(folder, TIMED, ("warp", "raise", "calm", "loop"), name="edits.usda")


def write_moved(folder: Path, *, how: str, offset: float, rate: float) -> Path:
    """Write a shot that has the animation and its edits in a sublayer or by references that are moved in time."""
    moved = f"(offset = {offset})"
    header = HEADER.format(rate=rate)
    shot = folder / f"{how}.usda"
    if how == "sublayer":
        shot.write_text(f"{header} subLayers = [@./edits.usda@ {moved}]\n)\n", encoding="utf-8")
        return shot
    # A reference to /Hero alone drops the targets outside it, so they are named again.
    bodies = {"Hero": f'over "Walk"\n{{\n{RETARGETED}}}', "Takes": ""}
    prims = [
        f'def "{name}" (\n prepend references = @./edits.usda@</{name}> {moved}\n)\n{{\n{body}\n}}\n'
        for name, body in bodies.items()
    ]
    shot.write_text(f"{header})\n{''.join(prims)}", encoding="utf-8")
    return shot


@pytest.mark.parametrize("how", ["sublayer", "reference"])
@pytest.mark.parametrize(("offset", "rate"), [(100.0, 24.0), (-37.0, 24.0), (-37.5, 24.0), (10.0, 48.0), (3.0, 120.0)])
def test_edits_move_with_the_animation(tmp_path: Path, how: str, offset: float, rate: float) -> None:
    """What is done to which pose stays the same, wherever in time a layer puts the motion.

    USD scales by the rates of layer and stage by itself.
    """
    scale = rate / 24.0
    write_timed(tmp_path)
    plain = by_variant(mtex_usd.apply_edits(tmp_path / "edits.usda"))
    shot = write_moved(tmp_path, how=how, offset=offset, rate=rate)
    moved = by_variant(mtex_usd.apply_edits(shot))
    assert set(moved) == {"edited", "looped"}
    for name, result in plain.items():
        times = result.clip.time_codes
        np.testing.assert_allclose(moved[name].clip.time_codes[[0, -1]], offset + scale * times[[0, -1]], atol=1e-9)
        played = play(moved[name].stage, (offset + scale * times).tolist(), name)
        np.testing.assert_allclose(played, play(result.stage, times.tolist(), name), atol=5e-4)


@pytest.mark.parametrize("how", ["references", "payload", "instances"])
def test_edits_that_come_with_an_asset(tmp_path: Path, how: str) -> None:
    write_shot(
        tmp_path, STACKS.replace('mtex:edits:other = ["half"]', "mtex:edits:other = []"), NAMES, name="asset.usda"
    )
    arc = "payload" if how == "payload" else "references"
    meta = f"(prepend {arc} = @./asset.usda@</Hero>\n{'instanceable = true' if how == 'instances' else ''})"
    text = HEADER.format(rate=24.0) + ")\n" + "".join(f'def "{name}" {meta}\n{{\n}}\n' for name in ("Hero", "Twin"))
    (tmp_path / "shot.usda").write_text(text, encoding="utf-8")
    found = [result for result in mtex_usd.apply_edits(tmp_path / "shot.usda") if result.model == MODEL]
    assert [result.variant for result in found] == ["edited", "slower"]
    for result in found:
        times = result.clip.time_codes.tolist()
        np.testing.assert_allclose(play(result.stage, times, result.variant), play_clip(result.clip), atol=2e-4)
