"""``usdmtex-suggest``: the table, the lines to paste, the layer to stack, and what is refused."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from pxr import Sdf, Usd

import mtex_usd
from mtex_usd.cli.usdmtex_suggest import main
from mtex_usd.suggesting import suggest
from mtex_usd.usd.schema import read_recipe
from tests.cli.support import SKETCH, Capture, contents


def write_shot(*takes: str, over: str = "", layers: tuple[str, ...] = ()) -> str:
    """Write a shot over the walk with some of its takes; gives its name."""
    targets = ", ".join(f"</Takes/{take}>" for take in takes)
    stacked = ", ".join(f"@./{layer}@" for layer in (*layers, "walk.usda"))
    text = f"""#usda 1.0
(
    framesPerSecond = 24
    timeCodesPerSecond = 24
    subLayers = [{stacked}]
)
over "Humanoid"
{{
over "Sketch"
{{
    rel mtex:takes = [{targets}]
    {over}
}}
}}
"""
    Path("shot.usda").write_text(text, encoding="utf-8")
    return "shot.usda"


@pytest.fixture
def shot(shot_folder: Path) -> str:
    """A shot with two takes, which is quick."""
    return write_shot("walk_slow", "walk_natural")


def test_table_lines_and_json_agree(shot: str, capsys: Capture) -> None:
    before = contents(Path())
    assert main([shot, "--top", "3", "--json", "table.json"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    lines = printed.out.splitlines()
    assert lines[0] == f"{SKETCH}\t2 takes held out, each in turn"
    assert lines[1].split()[:4] == ["rank", "band", "error", "cm"]
    (found,) = json.loads(Path("table.json").read_text())["results"]
    assert found["anim"] == SKETCH
    assert found["heldOut"] == ["/Takes/walk_slow", "/Takes/walk_natural"]
    best = found["suggestions"][0]
    assert best["rank"] == 1
    assert lines[2].split()[:3] == ["1", str(best["matchBand"]), f"{100 * best['error']:.2f}"]
    assert best["relativeError"] == pytest.approx(best["error"] / 1.52, rel=0.05)  # heights at rest
    assert ", ".join(best["match"]) in lines[2]
    assert f"    uniform int mtex:matchBand = {best['matchBand']}" in lines
    own = [each for each in found["suggestions"] if each["isOwn"]]
    assert [each["match"] for each in own] == [["LeftUpLeg.rx", "LeftLeg.rx"]]
    assert {name for name in contents(Path()) if name not in before} == {"table.json"}
    assert {name: data for name, data in contents(Path()).items() if name in before} == before


def test_the_applied_layer_makes_process_use_it(shot: str, capsys: Capture) -> None:
    assert main([shot, "--apply", "recipe.usda", "--top", "1"]) == 0
    printed = capsys.readouterr().out
    assert printed.endswith("wrote recipe.usda; put it first among the shot's sublayers\n")
    pasted = [line.strip() for line in printed.splitlines() if line.startswith("    uniform")]
    assert len(pasted) == 3
    (plain,) = mtex_usd.process(shot, paths=2)
    by_hand = write_shot("walk_slow", "walk_natural", over="\n".join(pasted))
    (expected,) = mtex_usd.process(by_hand, paths=2)
    # The shot's own opinion on the takes stays; those on what matches come from the layer.
    root = Sdf.Layer.CreateNew("stacked.usda")
    root.subLayerPaths = ["recipe.usda", write_shot("walk_slow", "walk_natural")]
    root.framesPerSecond = root.timeCodesPerSecond = 24.0
    root.Save()
    (made,) = mtex_usd.process("stacked.usda", paths=2)
    assert [variant.fragments for variant in made.variants] == [variant.fragments for variant in expected.variants]
    assert [variant.fragments for variant in made.variants] != [variant.fragments for variant in plain.variants]
    stage = Usd.Stage.Open("stacked.usda")
    recipe = read_recipe(stage.GetPrimAtPath(SKETCH))
    assert pasted[2] == f"uniform int mtex:matchBand = {recipe.match_band}"


def test_the_same_shot_gives_the_same_files(shot: str, capsys: Capture) -> None:
    files = []
    for _ in range(2):
        assert main([shot, "-q", "--top", "2", "--json", "table.json", "--apply", "recipe.usda"]) == 0
        files.append((Path("table.json").read_bytes(), Path("recipe.usda").read_bytes()))
    assert files[0] == files[1]
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("", "")


def test_json_on_standard_output_is_alone_there(shot: str, capsys: Capture) -> None:
    assert main([shot, "--top", "1", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["results"][0]["suggestions"][0]["rank"] == 1


def test_python_gives_the_same(shot: str) -> None:
    told: list[str] = []
    (found,) = suggest(shot, anim=SKETCH, top=1, progress=lambda *each: told.append(each[2]))
    assert found.suggestions[0].rank == 1
    assert found.suggestions[0].recipe.break_channel in found.suggestions[0].recipe.match
    assert all(what.startswith(f"{SKETCH}: ") for what in told)
    assert found.left_out == ()


def test_segments_that_match_by_themselves_are_named(shot_folder: Path, capsys: Capture) -> None:
    over = """uniform timecode mtex:segment:stop:start = 60
    uniform timecode mtex:segment:stop:end = 90
    uniform int mtex:segment:stop:matchBand = 3"""
    name = write_shot("walk_slow", "walk_natural", over=over)
    applied = 'over "Sketch" (prepend apiSchemas = ["MtexSegmentAPI:stop"])'
    Path(name).write_text(Path(name).read_text().replace('over "Sketch"', applied), encoding="utf-8")
    assert main([name, "--top", "1"]) == 0
    assert "segment stop has match channels, break channel or band of its own and keeps them" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["nothing.usda"], 2, "nothing.usda"),
        (["shot.usda", "--anim", "/Nobody"], 2, "cannot take /Nobody as a sketch"),
        (["takes.usda"], 3, "has no recipe"),
        (["shot.usda", "--apply", "walk.usda"], 2, "walk.usda exists and was not written by usdmtex"),
        (["shot.usda", "--apply", "recipe.txt"], 2, "recipe.txt is no layer name"),
        (["shot.usda", "--apply", "a.usda", "--json", "a.usda"], 2, "a.usda is another file of this run"),
        (["shot.usda", "--json", "nowhere/table.json"], 2, "cannot write nowhere/table.json"),
    ],
)
def test_refusals(shot: str, capsys: Capture, arguments: list[str], code: int, message: str) -> None:
    before = contents(Path())
    assert main(arguments) == code
    captured = capsys.readouterr()
    assert message in captured.err
    assert captured.err.startswith("usdmtex-suggest: error: ")
    assert captured.out == ""
    assert contents(Path()) == before


def test_one_take_is_too_few(shot_folder: Path, capsys: Capture) -> None:
    assert main([write_shot("walk_slow")]) == 2
    assert "expected at least two takes that have all joints with a role; found 1" in capsys.readouterr().err


def test_a_sketch_without_channels_is_refused(shot_folder: Path, capsys: Capture) -> None:
    """All that the sketch moves is synthesized."""
    name = write_shot(
        "walk_slow",
        "walk_natural",
        over='uniform token[] mtex:synthesize = ["*", "*.t"]\nuniform token[] mtex:texture = []',
    )
    assert main([name]) == 2
    assert "there is no channel to choose from" in capsys.readouterr().err


def test_a_bad_count_is_usage(shot: str, capsys: Capture) -> None:
    with pytest.raises(SystemExit) as ended:
        main([shot, "--top", "0"])
    assert ended.value.code == 2
    assert "expected a whole number of at least 1, found '0'" in capsys.readouterr().err


def test_help_does_not_load_usd() -> None:
    code = (
        "import sys; from mtex_usd.cli.usdmtex_suggest import main\n"
        "try: main(['--help'])\nexcept SystemExit: pass\nprint('numpy' in sys.modules, 'pxr' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "--apply LAYER" in done.stdout
    assert done.stdout.endswith("False False\n")
