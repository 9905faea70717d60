"""Suggested recipes as layers: overs alone, stronger than the sketch below, and nothing where they would be in vain."""

from pathlib import Path

import pytest
from pxr import Sdf, Usd

from mtex_usd.errors import InputError, StageError
from mtex_usd.usd.atomic import layer_kind
from mtex_usd.usd.recipe_layer import MatchRecipe, check_overridable, write_recipes
from mtex_usd.usd.schema import read_recipe

SAMPLES = Path(__file__).resolve().parents[2] / "sample_stages"
SKETCH = Sdf.Path("/Humanoid/Sketch")
RECIPE = MatchRecipe(match=("Hips.ty", "LeftLeg.rx"), break_channel="LeftLeg.rx", band=5)


def test_the_layer_holds_overs_and_wins_over_the_sketch(tmp_path: Path) -> None:
    stage = Usd.Stage.Open(str(SAMPLES / "walk.usda"))
    target = tmp_path / "recipe.usda"
    write_recipes(stage, {SKETCH: RECIPE}, target)
    layer = Sdf.Layer.FindOrOpen(str(target))
    assert layer_kind(layer) == "recipe"
    assert layer.timeCodesPerSecond == stage.GetTimeCodesPerSecond()
    assert layer.GetPrimAtPath("/Humanoid").specifier == Sdf.SpecifierOver
    assert layer.GetPrimAtPath(SKETCH).specifier == Sdf.SpecifierOver
    assert set(layer.GetPrimAtPath(SKETCH).properties.keys()) == {"mtex:match", "mtex:break", "mtex:matchBand"}
    shot = Sdf.Layer.CreateNew(str(tmp_path / "shot.usda"))
    shot.subLayerPaths = ["recipe.usda", str(SAMPLES / "walk.usda")]
    stacked = Usd.Stage.Open(shot)
    recipe = read_recipe(stacked.GetPrimAtPath(SKETCH))
    assert (recipe.match, recipe.break_channel, recipe.match_band) == (RECIPE.match, "LeftLeg.rx", 5)
    assert recipe.synthesize == read_recipe(stage.GetPrimAtPath(SKETCH)).synthesize


def test_the_lines_to_paste_say_the_same(tmp_path: Path) -> None:
    body = "\n".join(RECIPE.lines)
    text = f'#usda 1.0\ndef SkelAnimation "A" (prepend apiSchemas = ["MtexSketchAPI"]) {{\n{body}\n}}\n'
    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().ImportFromString(text)
    recipe = read_recipe(stage.GetPrimAtPath("/A"))
    assert (recipe.match, recipe.break_channel, recipe.match_band) == (RECIPE.match, "LeftLeg.rx", 5)


def test_only_layers_of_its_own_are_replaced(tmp_path: Path) -> None:
    stage = Usd.Stage.Open(str(SAMPLES / "walk.usda"))
    target = tmp_path / "recipe.usda"
    write_recipes(stage, {SKETCH: RECIPE}, target)
    before = target.read_bytes()
    write_recipes(stage, {SKETCH: RECIPE}, target)
    assert target.read_bytes() == before
    target.write_text("#usda 1.0\n", encoding="utf-8")
    with pytest.raises(InputError, match="was not written by usdmtex"):
        write_recipes(stage, {SKETCH: RECIPE}, target)


def test_sketches_inside_instances_are_refused(tmp_path: Path) -> None:
    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().ImportFromString(
        '#usda 1.0\ndef "Asset"\n{\ndef SkelAnimation "Sketch" {}\n}\n'
        'def "Hero" (instanceable = true\nprepend references = </Asset>) {}\n'
    )
    check_overridable(stage, [Sdf.Path("/Asset/Sketch")])
    with pytest.raises(StageError, match="/Hero/Sketch is inside an instance"):
        check_overridable(stage, [Sdf.Path("/Asset/Sketch"), Sdf.Path("/Hero/Sketch")])
