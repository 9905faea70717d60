"""The thin root is a place users save into: what they put there outlives every run."""

from pathlib import Path

import pytest
from pxr import Sdf, Usd

from mtex_usd.errors import InputError
from mtex_usd.usd.check import check_override
from mtex_usd.usd.override import write_override
from mtex_usd.usd.source_stage import find_override, open_source
from mtex_usd.usd.thin_root import find_stacked
from tests.usd.base_situations import build_local
from tests.usd.stage_parts import Situation
from tests.usd.synthetic import make_results

MODEL = "/World/Char"


@pytest.fixture
def local(tmp_path: Path) -> Situation:
    """Give the plainest situation."""
    return build_local(tmp_path, "Skeleton")


def _run(situation: Situation, *, given: Path | None = None, select: str | None = None, variants: int = 3) -> Path:
    """Do what a run does, the check included; gives the thin root."""
    source = open_source(given or situation.shot)
    out = find_override(given or situation.shot)
    results = make_results(source.stage, situation, variants=variants, previous=out)
    _, thin_root = write_override(source.stage, results, out, select=select)
    check_override(thin_root, results)
    return thin_root


def _sublayers(thin_root: Path) -> list[str]:
    layer = Sdf.Layer.OpenAsAnonymous(str(thin_root))
    return list(layer.subLayerPaths)


def _stack(thin_root: Path, places: dict[int, str]) -> None:
    """Stack layers of the user's at the places given, the first one slowed down."""
    layer = Sdf.Layer.FindOrOpen(str(thin_root))
    for place, name in places.items():
        mine = Sdf.Layer.CreateNew(str(thin_root.with_name(name)))
        Sdf.CreatePrimInLayer(mine, MODEL).documentation = name
        mine.Save()
        layer.subLayerPaths.insert(place, f"./{name}")
    layer.subLayerOffsets[min(places)] = Sdf.LayerOffset(4, 2)
    layer.Save()


def test_what_was_saved_there_stays(local: Situation) -> None:
    """Prims, layers above, between and below, their offsets, notes: and the second time the bytes are the same."""
    thin_root = _run(local)
    _stack(thin_root, {0: "top.usda", 2: "between.usda"})
    layer = Sdf.Layer.FindOrOpen(str(thin_root))
    camera = Sdf.CreatePrimInLayer(layer, "/Camera")
    camera.specifier, camera.typeName = Sdf.SpecifierDef, "Camera"
    layer.customLayerData = {**layer.customLayerData, "studio": "x"}
    layer.documentation = "dailies"
    layer.Save()
    saved = thin_root.read_bytes()
    for given in (None, thin_root):
        assert _run(local, given=given) == thin_root
        assert thin_root.read_bytes() == saved
    stage = Usd.Stage.Open(str(thin_root))
    assert stage.GetPrimAtPath("/Camera").IsA("Camera")
    assert _sublayers(thin_root) == ["./top.usda", "./shot.mtex.usd", "./between.usda", "./shot.usda"]
    assert Sdf.Layer.FindOrOpen(str(thin_root)).subLayerOffsets[0] == Sdf.LayerOffset(4, 2)


@pytest.mark.parametrize(
    "order", [["./top.usda", "./shot.mtex.usd", "./shot.usda"], ["./shot.usda", "./shot.mtex.usd"]]
)
def test_the_layers_are_told_apart_wherever_they_are(local: Situation, order: list[str]) -> None:
    thin_root = _run(local)
    Sdf.Layer.CreateNew(str(thin_root.with_name("top.usda"))).Save()
    layer = Sdf.Layer.FindOrOpen(str(thin_root))
    layer.subLayerPaths[:] = [f"./{name}" for name in order]
    layer.Save()
    stacked = find_stacked(layer)
    assert (stacked.override, stacked.shot) == (thin_root.with_name("shot.mtex.usd"), local.shot)
    source = open_source(thin_root)
    assert (source.previous_override, source.source_path) == (stacked.override, local.shot)


def test_an_override_layer_that_was_taken_out_goes_back_above_the_shot(local: Situation) -> None:
    thin_root = _run(local)
    _stack(thin_root, {0: "top.usda"})
    layer = Sdf.Layer.FindOrOpen(str(thin_root))
    layer.subLayerPaths.remove("./shot.mtex.usd")
    layer.Save()
    assert find_override(thin_root) == thin_root.with_name("shot.mtex.usd")
    assert _run(local, given=thin_root) == thin_root
    assert _sublayers(thin_root) == ["./top.usda", "./shot.mtex.usd", "./shot.usda"]


def test_an_override_layer_that_was_deleted_is_made_again(local: Situation) -> None:
    thin_root = _run(local)
    out = thin_root.with_name("shot.mtex.usd")
    before = (out.read_bytes(), thin_root.read_bytes())
    out.unlink()
    assert _run(local, given=thin_root) == thin_root
    assert (out.read_bytes(), thin_root.read_bytes()) == before


def test_of_two_override_layers_the_one_of_that_name_is_written(local: Situation) -> None:
    """Somebody stacked the result of another run on top."""
    thin_root = _run(local)
    stage = open_source(local.shot).stage
    other, _ = write_override(stage, make_results(stage, local), thin_root.with_name("other.usd"))
    layer = Sdf.Layer.FindOrOpen(str(thin_root))
    layer.subLayerPaths.insert(0, "./other.usd")
    layer.Save()
    before = other.read_bytes()
    assert find_override(thin_root) == thin_root.with_name("shot.mtex.usd")
    assert open_source(thin_root).source_path == local.shot
    assert other.read_bytes() == before


def test_another_shot_takes_the_place_of_the_first(local: Situation) -> None:
    """The same output for a shot of another name: only that is stacked."""
    thin_root = _run(local)
    _stack(thin_root, {0: "top.usda"})
    second = local.shot.with_name("second.usda")
    second.write_bytes(local.shot.read_bytes())
    stage = open_source(second).stage
    write_override(stage, make_results(stage, local), thin_root.with_name("shot.mtex.usd"))
    assert _sublayers(thin_root) == ["./top.usda", "./shot.mtex.usd", "./second.usda"]


def test_the_shots_new_range_gets_there(local: Situation) -> None:
    """Root metadata is ours: a shot that has grown plays to its end."""
    thin_root = _run(local)
    stage = Usd.Stage.Open(str(local.shot))
    stage.SetEndTimeCode(200)
    stage.Save()
    _run(local)
    assert Sdf.Layer.OpenAsAnonymous(str(thin_root)).endTimeCode == 200


@pytest.mark.parametrize(
    ("select", "variants", "expected"), [(None, 3, "path_02"), ("path_03", 3, "path_03"), (None, 1, "path_01")]
)
def test_a_selection_saved_there_does_not_stand_in_the_way(
    local: Situation, select: str | None, variants: int, expected: str
) -> None:
    """It is stronger than the override layer's, so it has to follow."""
    thin_root = _run(local)
    layer = Sdf.Layer.FindOrOpen(str(thin_root))
    Sdf.CreatePrimInLayer(layer, MODEL).variantSelections["mtex"] = "path_02"
    layer.Save()
    _run(local, select=select, variants=variants)
    stage = Usd.Stage.Open(str(thin_root))
    assert stage.GetPrimAtPath(MODEL).GetVariantSet("mtex").GetVariantSelection() == expected


def test_what_others_saved_meanwhile_stays_too(local: Situation) -> None:
    """This process holds the thin root as it was."""
    thin_root = _run(local)
    held = Usd.Stage.Open(str(thin_root))
    thin_root.write_text(thin_root.read_text() + '\ndef Camera "Camera"\n{\n}\n')
    assert not held.GetPrimAtPath("/Camera")
    _run(local)
    assert 'def Camera "Camera"' in thin_root.read_text()
    assert held.GetPrimAtPath("/Camera")


def test_a_flattened_thin_root_says_what_it_is(local: Situation) -> None:
    """Flattening keeps the mark and nothing that could be stacked."""
    flat = local.shot.with_name("flat.usda")
    Usd.Stage.Open(str(_run(local))).Flatten().Export(str(flat))
    with pytest.raises(InputError, match=r"flat.usda is marked as a thin root .* found no sublayers, as flattening"):
        open_source(flat)


def test_a_damaged_thin_root_is_left_alone(local: Situation) -> None:
    """It may hold what somebody saved; the metadata alone can still be read."""
    thin_root = _run(local)
    thin_root.write_text(thin_root.read_text() + 'over "A" {')
    before = thin_root.read_bytes()
    with pytest.raises(InputError, match=r"cannot read .*shot.mtex.stage.usda: line \d+: Expected }"):
        _run(local)
    assert thin_root.read_bytes() == before
