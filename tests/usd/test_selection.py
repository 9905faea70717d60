"""Which variant stays selected."""

from pathlib import Path

import pytest
from pxr import Sdf

from mtex_usd.usd.override import ORIGINAL, variant_names, write_override
from mtex_usd.usd.selection import Selections
from mtex_usd.usd.source_stage import open_source
from tests.usd.base_situations import build_local
from tests.usd.more_situations import build_two_characters, build_two_instances
from tests.usd.synthetic import make_result, make_results


def _keep(had: str, names: tuple[str, ...]) -> str:
    layer = Sdf.Layer.CreateAnonymous()
    Sdf.CreatePrimInLayer(layer, "/A").variantSelections["mtex"] = had
    return Selections(layers=(layer,), asked=None).choose(Sdf.Path("/A"), "mtex", names)


@pytest.mark.parametrize(
    ("had", "count", "kept"),
    [
        ("path_02", 100, "path_002"),
        ("path_002", 99, "path_02"),
        ("path_100", 1000, "path_0100"),
        ("path_100", 5, "path_01"),
        ("original", 100, "original"),
        ("look_02", 5, "path_01"),
        ("mine", 5, "path_01"),
        ("path_", 5, "path_01"),
    ],
)
def test_variants_are_the_same_by_number(had: str, count: int, kept: str) -> None:
    assert _keep(had, (*variant_names(count), ORIGINAL)) == kept


def test_a_selected_variant_survives_a_hundred_paths(tmp_path: Path) -> None:
    """There, and back."""
    situation = build_local(tmp_path, "Skeleton")
    out = tmp_path / "shot.mtex.usd"
    stage = open_source(situation.shot).stage
    write_override(stage, make_results(stage, situation), out, select="path_02")
    for count, selected in ((100, "path_002"), (3, "path_02")):
        (result,) = make_results(stage, situation, variants=count, previous=out)
        write_override(stage, [result], out)
        layer = Sdf.Layer.FindOrOpen(str(out))
        assert layer.GetPrimAtPath(result.character.model).variantSelections["mtex"] == selected


def test_a_character_not_worked_on_keeps_its_selection_and_its_range(tmp_path: Path) -> None:
    """The user chose for both in the thin root; only the first is done again, shorter, with another choice."""
    situation = build_two_instances(tmp_path)
    stage = open_source(situation.shot).stage
    stage.SetEndTimeCode(300)
    out = tmp_path / "shot.mtex.usd"
    one, two = make_results(stage, situation)
    stage.SetEndTimeCode(61)
    _, thin_root = write_override(stage, [one, two], out)
    layer = Sdf.Layer.FindOrOpen(str(thin_root))
    for model, variant in (("/World/One", "path_02"), ("/World/Two", "path_03")):
        Sdf.CreatePrimInLayer(layer, model).variantSelections["mtex"] = variant
    layer.Save()
    again = make_result(stage, one.character, 7)
    for file_path in write_override(stage, [again], out, keep=[two.character], select="original"):
        written = Sdf.Layer.FindOrOpen(str(file_path))
        selected = [written.GetPrimAtPath(model).variantSelections["mtex"] for model in ("/World/One", "/World/Two")]
        assert selected == ["original", "path_03"]
        assert (written.startTimeCode, written.endTimeCode) == (1, 300)


def test_nothing_kept_nothing_in_the_way_of_the_range(tmp_path: Path) -> None:
    """Whoever is gone does not hold the range open."""
    situation = build_two_characters(tmp_path)
    stage = open_source(situation.shot).stage
    stage.SetEndTimeCode(300)
    out = tmp_path / "shot.mtex.usd"
    results = make_results(stage, situation)
    stage.SetEndTimeCode(61)
    write_override(stage, results, out)
    write_override(stage, [make_result(stage, results[0].character, 0)], out)
    assert Sdf.Layer.FindOrOpen(str(out)).endTimeCode == 61
