"""``usdmtex`` as people type it: what it writes and prints, and every option."""

import json
from pathlib import Path

import pytest
from pxr import Sdf, Usd

from mtex_usd import api
from mtex_usd.cli.usdmtex import main
from mtex_usd.plugin_path import plugin_path
from tests.cli.support import MODEL, SKETCH, Capture, contents, failing, read_custom_data, selection, variant_names


def test_default_names_and_what_is_printed(shot_folder: Path, capsys: Capture) -> None:
    sources = contents(shot_folder)
    assert main(["walk.usda", "--paths", "2"]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    lines = captured.out.splitlines()
    assert lines[0] == f"{SKETCH}\t{MODEL}\t{{mtex}}"
    assert [line.split("\t")[0] for line in lines[1:3]] == ["  path_01", "  path_02"]
    assert lines[3:] == ["wrote walk.mtex.usd", "open walk.mtex.stage.usda"]
    after = contents(shot_folder)
    assert after.keys() - sources.keys() == {"walk.mtex.usd", "walk.mtex.stage.usda"}
    assert {name: after[name] for name in sources} == sources


def test_a_name_of_ones_own(shot_folder: Path, capsys: Capture) -> None:
    (shot_folder / "out").mkdir()
    assert main(["walk.usda", "-o", "out/best.usda", "--paths", "1"]) == 0
    assert capsys.readouterr().out.splitlines()[-2:] == ["wrote out/best.usda", "open out/best.stage.usda"]
    assert sorted(file.name for file in (shot_folder / "out").iterdir()) == ["best.stage.usda", "best.usda"]
    assert Usd.Stage.Open("out/best.stage.usda").GetPrimAtPath(f"{SKETCH}_mtex")


def test_beside_the_stage_and_not_where_one_stands(
    shot_folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    (shot_folder / "elsewhere").mkdir()
    monkeypatch.chdir(shot_folder / "elsewhere")
    assert main(["../walk.usda", "--paths", "1", "-q"]) == 0
    assert list((shot_folder / "elsewhere").iterdir()) == []
    assert (shot_folder / "walk.mtex.usd").is_file()


def test_twice_gives_equal_bytes_also_on_the_thin_root(shot_folder: Path, capsys: Capture) -> None:
    assert main(["walk.usda"]) == 0
    first, printed = contents(shot_folder), capsys.readouterr().out
    assert main(["walk.usda"]) == 0
    assert (contents(shot_folder), capsys.readouterr().out) == (first, printed)
    assert main(["walk.mtex.stage.usda"]) == 0
    assert contents(shot_folder) == first


def test_quiet_is_silent(shot_folder: Path, capfd: Capture) -> None:
    assert main(["walk.usda", "-q"]) == 0
    assert capfd.readouterr() == ("", "")


def test_verbose_lists_every_fragment(shot_folder: Path, capsys: Capture) -> None:
    assert main(["walk.usda", "-v", "--paths", "1", "--json", "table.json"]) == 0
    (variant,) = json.loads(Path("table.json").read_text())["results"][0]["variants"]
    lines = [line.split("\t") for line in capsys.readouterr().out.splitlines() if line.startswith("    ")]
    assert len(lines) == len(variant["fragments"])
    first = variant["fragments"][0]
    assert lines[0][0].strip() == f"{first['start']:g} to {first['end']:g}"
    assert lines[0][1:3] == [first["take"], f"{first['takeStart']:g} to {first['takeEnd']:g}"]


@pytest.mark.parametrize("options", [[], ["-v"], ["--json", "table.json"], ["--select", "original"]])
def test_a_dry_run_says_it_all_and_writes_no_layer(shot_folder: Path, capsys: Capture, options: list[str]) -> None:
    before = contents(shot_folder)
    assert main(["walk.usda", "--dry-run", *options]) == 0
    dry = capsys.readouterr().out
    after = contents(shot_folder)
    after.pop("table.json", None)
    assert after == before
    assert main(["walk.usda", *options]) == 0
    assert capsys.readouterr().out == dry + "wrote walk.mtex.usd\nopen walk.mtex.stage.usda\n"


def test_notes_go_to_stderr(shot_folder: Path, capsys: Capture) -> None:
    assert main(["walk.usda", "--band", "40"]) == 0
    captured = capsys.readouterr()
    assert captured.err.startswith(f"usdmtex: note: {SKETCH}: band 40 is too slow")
    assert "note" not in captured.out


def test_the_file_says_what_the_layer_carries(shot_folder: Path, capsys: Capture) -> None:
    assert main(["walk.usda", "--paths", "3", "--json", "table.json"]) == 0
    table = json.loads(Path("table.json").read_text())
    assert table.keys() == {"version", "results"}
    assert table["version"] == 1
    (result,) = table["results"]
    variants = result.pop("variants")
    assert result == {"anim": SKETCH, "model": MODEL, "variantSet": "mtex", "retargets": []}
    assert variants == [read_custom_data("walk.mtex.stage.usda", f"path_0{rank}") for rank in (1, 2, 3)]
    assert [variant["rank"] for variant in variants] == [1, 2, 3]


def test_a_variant_has_the_keys_of_the_contract(shot_folder: Path, capsys: Capture) -> None:
    assert main(["walk.usda", "--paths", "1", "--json", "-"]) == 0
    (variant,) = json.loads(capsys.readouterr().out)["results"][0]["variants"]
    assert variant.keys() == {"rank", "distance", "zeroCostJoins", "rotationOrders", "fragments"}
    keys = {"start", "end", "take", "takeStart", "takeEnd", "distance", "scale"}
    assert all(fragment.keys() == keys for fragment in variant["fragments"])
    starts = [fragment["start"] for fragment in variant["fragments"]]
    assert starts[1:] == [fragment["end"] for fragment in variant["fragments"]][:-1]


def test_standard_output_is_the_table_alone(shot_folder: Path, capsys: Capture) -> None:
    assert main(["walk.usda", "--json", "table.json", "-q"]) == 0
    assert main(["walk.usda", "--json", "-", "-v"]) == 0
    assert capsys.readouterr().out == Path("table.json").read_text()


def test_an_own_table_is_replaced_and_nothing_else_is(shot_folder: Path, capsys: Capture) -> None:
    arguments = ["walk.usda", "--json", "table.json", "-q"]
    assert main([*arguments, "--paths", "1"]) == 0
    assert main([*arguments, "--paths", "2"]) == 0
    assert len(json.loads(Path("table.json").read_text())["results"][0]["variants"]) == 2
    Path("table.json").write_text('{"version": 1}')
    error = failing(capsys, shot_folder, *arguments, code=2)
    assert (
        "table.json exists and was not written by usdmtex; it is left alone. Choose another name for the table."
        in error
    )


@pytest.mark.parametrize(
    ("options", "table"),
    [
        (["-o", "same.usda"], "same.usda"),
        (["-o", "same.usda"], "./same.stage.usda"),
        ([], "walk.mtex.usd"),
        ([], "walk.mtex.stage.usda"),
        (["--report", "walk.html"], "walk.html"),
        (["--timeline", "walk.otio"], "./walk.otio"),
    ],
)
def test_a_layer_and_its_table_are_two_files(
    shot_folder: Path, capsys: Capture, options: list[str], table: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr(api, "finish_job")  # refused before any work
    error = failing(capsys, shot_folder, "walk.usda", *options, "--json", table, code=2)
    assert f"{Path(table)} is another file of this run. Choose another name for the table." in error


def test_a_folder_that_is_not_there(shot_folder: Path, capsys: Capture) -> None:
    error = failing(capsys, shot_folder, "walk.usda", "--json", "no/table.json", code=2)
    assert f"cannot write no/table.json: there is no folder {Path('no').resolve()}. Make it first." in error


@pytest.mark.parametrize("option", ["--paths", "--candidates", "--band"])
@pytest.mark.parametrize("value", ["0", "-1", "2.5", "many", ""])
def test_bad_numbers(shot_folder: Path, capsys: Capture, option: str, value: str) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["walk.usda", f"{option}={value}"])
    assert caught.value.code == 2
    error = capsys.readouterr().err
    assert f"argument {option}: expected a whole number of at least 1, found '{value}'" in error


@pytest.mark.parametrize("count", [1, 3])
def test_paths(shot_folder: Path, capsys: Capture, count: int) -> None:
    assert main(["walk.usda", "--paths", str(count), "-q"]) == 0
    assert variant_names("walk.mtex.usd") == ["original", *(f"path_0{i + 1}" for i in range(count))]


def test_one_candidate_leaves_one_path_and_says_so(shot_folder: Path, capsys: Capture) -> None:
    assert main(["walk.usda", "--candidates", "1", "--paths", "4"]) == 0
    assert f"note: {SKETCH}: 1 of 4 variants" in capsys.readouterr().err
    assert variant_names("walk.mtex.usd") == ["original", "path_01"]


def test_the_band_decides_where_fragments_begin(shot_folder: Path, capsys: Capture) -> None:
    counts = []
    for band in ("2", "5"):
        assert main(["walk.usda", "--band", band, "--paths", "1", "--json", "-"]) == 0
        counts.append(len(json.loads(capsys.readouterr().out)["results"][0]["variants"][0]["fragments"]))
    assert counts[0] > counts[1]


@pytest.fixture
def two(shot_folder: Path) -> Path:
    """Give a shot of two characters, each with a sketch."""
    text = (shot_folder / "walk.usda").read_text()
    (shot_folder / "second.usda").write_text(text.replace('"Humanoid"', '"Second"').replace("/Humanoid/", "/Second/"))
    rates = "framesPerSecond = 24\n timeCodesPerSecond = 24\n metersPerUnit = 0.01\n"
    (shot_folder / "two.usda").write_text(f"#usda 1.0\n(\n {rates} subLayers = [@./walk.usda@, @./second.usda@]\n)\n")
    return shot_folder


def test_all_by_default_and_some_by_name(two: Path, capsys: Capture) -> None:
    assert main(["two.usda", "--json", "-", "--dry-run"]) == 0
    results = json.loads(capsys.readouterr().out)["results"]
    assert {result["anim"] for result in results} == {SKETCH, "/Second/Sketch"}
    assert main(["two.usda", "--json", "-", "--anim", "/Second/Sketch"]) == 0
    (result,) = json.loads(capsys.readouterr().out)["results"]
    assert (result["anim"], result["model"]) == ("/Second/Sketch", "/Second")


def test_a_sketch_nobody_can_play_is_left_out_by_name(two: Path, capsys: Capture) -> None:
    """The good one is done; asked for alone it is all there is."""
    layer = Sdf.Layer.FindOrOpen("second.usda")
    layer.GetPrimAtPath("/Second/Skeleton").relationships["skel:animationSource"].targetPathList.explicitItems = []
    extra = Sdf.PrimSpec(layer.GetPrimAtPath("/Second"), "Extra", Sdf.SpecifierDef, "Skeleton")
    assert extra
    layer.Save()
    assert main(["two.usda", "--paths", "2"]) == 3
    captured = capsys.readouterr()
    assert captured.err.startswith("usdmtex: error: no Skeleton plays /Second/Sketch; expected a bound Skeleton")
    assert captured.out.splitlines()[0] == f"{SKETCH}\t{MODEL}\t{{mtex}}"
    assert len(variant_names("two.mtex.usd")) == 3
    assert api.process("two.usda", paths=1, dry_run=True)[0].left_out == (captured.err.split("error: ")[1].strip(),)
    assert main(["two.usda", "--paths", "2", "--anim", SKETCH]) == 0
    assert capsys.readouterr().err == ""
    error = failing(capsys, two, "two.usda", "--anim", "/Second/Sketch", code=3)
    assert "no Skeleton plays /Second/Sketch" in error


def test_the_others_keep_what_they_had(two: Path, capsys: Capture) -> None:
    assert main(["two.usda", "--paths", "3", "-q"]) == 0
    assert main(["two.usda", "--paths", "1", "-q", "--anim", "/Second/Sketch"]) == 0
    assert len(variant_names("two.mtex.usd", "/Humanoid")) == 4
    assert len(variant_names("two.mtex.usd", "/Second")) == 2


@pytest.mark.parametrize(
    ("prim_path", "found"),
    [("/Nobody", "no such prim"), ("no path", "no such prim"), ("/Humanoid/Skeleton", "Skeleton")],
)
def test_no_sketch_of_that_name(shot_folder: Path, capsys: Capture, prim_path: str, found: str) -> None:
    error = failing(capsys, shot_folder, "walk.usda", "--anim", prim_path, code=2)
    assert f"cannot take {prim_path} as a sketch; expected a SkelAnimation; found {found}." in error
    assert f"The sketches of this stage: {SKETCH}." in error


def test_an_animation_without_a_recipe(shot_folder: Path, capsys: Capture) -> None:
    error = failing(capsys, shot_folder, "walk.usda", "--anim", "/Takes/walk_slow", code=3)
    assert "/Takes/walk_slow" in error


def test_the_best_by_default(shot_folder: Path) -> None:
    assert main(["walk.usda", "-q"]) == 0
    assert selection("walk.mtex.usd") == "path_01"


@pytest.mark.parametrize("variant", ["original", "path_02"])
def test_as_asked_and_kept_from_then_on(shot_folder: Path, variant: str) -> None:
    assert main(["walk.usda", "-q", "--select", variant]) == 0
    assert selection("walk.mtex.usd") == variant
    assert main(["walk.usda", "-q"]) == 0
    assert main(["walk.mtex.stage.usda", "-q"]) == 0
    assert selection("walk.mtex.usd") == variant
    assert main(["walk.usda", "-q", "--select", "path_03"]) == 0
    assert selection("walk.mtex.usd") == "path_03"


def test_a_selection_that_is_gone_falls_back_to_the_best(shot_folder: Path) -> None:
    assert main(["walk.usda", "-q", "--select", "path_05"]) == 0
    assert main(["walk.usda", "-q", "--paths", "2"]) == 0
    assert selection("walk.mtex.usd") == "path_01"


@pytest.mark.parametrize("options", [[], ["--dry-run"]])
@pytest.mark.parametrize("variant", ["path_04", "best", ""])
def test_no_variant_of_that_name(shot_folder: Path, capsys: Capture, variant: str, options: list[str]) -> None:
    error = failing(capsys, shot_folder, "walk.usda", "--paths", "3", "--select", variant, *options, code=2)
    assert f"gets no variant '{variant}'; expected one of original, path_01, path_02, path_03" in error


def test_the_plugin_path_needs_no_stage(capsys: Capture) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["--print-plugin-path"])
    assert caught.value.code == 0
    assert capsys.readouterr().out == f"{plugin_path()}\n"
