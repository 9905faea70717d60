"""The two files: what they say about the stage, what is selected, and what is never overwritten."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from mtex_usd.errors import InputError
from mtex_usd.usd.check import check_override
from mtex_usd.usd.custom_data import from_metadata, to_metadata
from mtex_usd.usd.override import variant_names, write_override
from mtex_usd.usd.source_stage import open_source
from tests.usd.base_situations import build_animation_layer, build_local
from tests.usd.more_situations import build_nested_instances, build_other_rates, build_package, build_two_sketches
from tests.usd.playback import local_transforms, select_variant
from tests.usd.stage_parts import Situation
from tests.usd.synthetic import make_custom_data, make_result, make_results

MODEL = "/World/Char"


@pytest.fixture
def local(tmp_path: Path) -> Situation:
    """Give the plainest situation."""
    return build_local(tmp_path, "Skeleton")


def _write(situation: Situation, out: Path, *, variants: int = 3, select: str | None = None) -> tuple[Path, Path]:
    stage = open_source(situation.shot).stage
    results = make_results(stage, situation, variants=variants, previous=out)
    return write_override(stage, results, out, select=select)


def _selected(thin_root: Path, variant_set: str = "mtex") -> str:
    stage = Usd.Stage.Open(str(thin_root))
    return str(stage.GetPrimAtPath(MODEL).GetVariantSet(variant_set).GetVariantSelection())


def _select_in(file_path: Path, variant: str) -> None:
    layer = Sdf.Layer.FindOrOpen(str(file_path))
    Sdf.CreatePrimInLayer(layer, MODEL).variantSelections["mtex"] = variant
    layer.Save()


# --- names ---


@pytest.mark.parametrize(("count", "first", "last"), [(1, "path_01", "path_01"), (120, "path_001", "path_120")])
def test_variant_names_sort_as_they_rank(count: int, first: str, last: str) -> None:
    """USD sorts the names of a set."""
    names = variant_names(count)
    assert (names[0], names[-1], len(names)) == (first, last, count)
    assert list(names) == sorted(names)


def test_file_names(local: Situation, tmp_path: Path) -> None:
    """The thin root is named after the override layer, and the formats are crate and text."""
    override, thin_root = _write(local, tmp_path / "finished.usd")
    assert (override.name, thin_root.name) == ("finished.usd", "finished.stage.usda")
    assert override.read_bytes().startswith(b"PXR-USDC")
    assert thin_root.read_text().startswith("#usda")


def test_override_layer_is_overs_and_new_prims_only(local: Situation, tmp_path: Path) -> None:
    """No sublayers, no definitions but the outputs."""
    override, _ = _write(local, tmp_path / "shot.mtex.usd")
    layer = Sdf.Layer.FindOrOpen(str(override))
    assert len(layer.subLayerPaths) == 0
    defined = []

    def collect(path: Sdf.Path) -> None:
        spec = layer.GetObjectAtPath(path)
        if path.IsPrimPath() and spec.specifier == Sdf.SpecifierDef:
            defined.append(path.name)

    layer.Traverse(Sdf.Path.absoluteRootPath, collect)
    assert set(defined) == {"Anim_mtex"}


# --- metadata ---


def test_root_metadata_is_always_authored(tmp_path: Path) -> None:
    """Also where the shot leaves all of it out."""
    shot = build_local(tmp_path, "Skeleton").shot
    stage = Usd.Stage.Open(str(shot))
    for key in ("timeCodesPerSecond", "startTimeCode", "endTimeCode", "upAxis", "metersPerUnit", "defaultPrim"):
        stage.ClearMetadata(key)
    stage.Save()
    stage = open_source(shot).stage
    situation = Situation(shot=shot, animations=("/World/Char/Anim",), expected=())
    results = make_results(stage, situation)
    for file_path in write_override(stage, results, tmp_path / "shot.mtex.usd"):
        layer = Sdf.Layer.FindOrOpen(str(file_path))
        assert (layer.timeCodesPerSecond, layer.framesPerSecond) == (24, 24)
        assert (layer.startTimeCode, layer.endTimeCode) == (0, 0)  # all that a stage without a range has
        assert layer.defaultPrim == "World"
        info = layer.pseudoRoot
        assert (info.GetInfo("upAxis"), info.GetInfo("metersPerUnit")) == (UsdGeom.GetFallbackUpAxis(), 0.01)


@pytest.mark.parametrize(
    ("authored", "expected"),
    [
        ({"framesPerSecond": 30}, (30, 30)),
        ({"timeCodesPerSecond": 120}, (120, 120)),
        ({"timeCodesPerSecond": 48, "framesPerSecond": 24}, (48, 24)),
    ],
)
def test_frame_rates(local: Situation, tmp_path: Path, authored: dict[str, float], expected: tuple[int, int]) -> None:
    """The rates the stage plays at, whichever of the two it authors."""
    stage = Usd.Stage.Open(str(local.shot))
    stage.ClearMetadata("timeCodesPerSecond")
    for key, value in authored.items():
        stage.SetMetadata(key, value)
    stage.Save()
    for file_path in _write(local, tmp_path / "shot.mtex.usd"):
        layer = Sdf.Layer.FindOrOpen(str(file_path))
        assert (layer.timeCodesPerSecond, layer.framesPerSecond) == expected


def test_range_is_the_shots_extended_to_the_result(tmp_path: Path) -> None:
    """The shot runs from 0 to 121 and the result is put from -10 to 100."""
    situation = build_other_rates(tmp_path)
    stage = open_source(situation.shot).stage
    (result,) = make_results(stage, situation)
    moved = [replace(variant, time_codes=np.linspace(-10, 100, 13)) for variant in result.variants]
    result = replace(result, variants=tuple(moved))
    for file_path in write_override(stage, [result], tmp_path / "shot.mtex.usd"):
        layer = Sdf.Layer.FindOrOpen(str(file_path))
        assert (layer.startTimeCode, layer.endTimeCode) == (-10, 121)


def test_thin_root_keeps_what_only_a_root_layer_can_say(local: Situation, tmp_path: Path) -> None:
    """Render settings and expression variables of the shot still count; its comments do not move."""
    stage = Usd.Stage.Open(str(local.shot))
    stage.SetMetadata("renderSettingsPrimPath", "/Render/Final")
    stage.SetMetadata("expressionVariables", {"CAST": "hero"})
    stage.SetMetadata("kilogramsPerUnit", 2.0)
    stage.SetMetadata("comment", "the animator's own")
    stage.SetMetadata("customLayerData", {"studio": "x"})
    stage.Save()
    _, thin_root = _write(local, tmp_path / "shot.mtex.usd")
    stage = Usd.Stage.Open(str(thin_root))
    assert stage.GetMetadata("renderSettingsPrimPath") == "/Render/Final"
    assert stage.GetMetadata("expressionVariables") == {"CAST": "hero"}
    assert stage.GetMetadata("kilogramsPerUnit") == 2.0
    assert not stage.HasAuthoredMetadata("comment")
    assert set(stage.GetMetadata("customLayerData")) == {"mtex"}


# --- where things are ---


@pytest.mark.parametrize("folder", [".", "out", "out/deep er", "../sibling"])
def test_thin_root_refers_relatively_so_the_tree_can_move(tmp_path: Path, folder: str) -> None:
    """Both files in any folder; the whole tree is moved and still opens."""
    project = tmp_path / "project"
    (project / "shots").mkdir(parents=True)
    situation = build_local(project / "shots", "Skeleton")
    out_folder = situation.shot.parent / folder
    out_folder.mkdir(parents=True, exist_ok=True)
    _, thin_root = _write(situation, out_folder / "x.usd")
    root = Sdf.Layer.FindOrOpen(str(thin_root))
    sublayers = list(root.subLayerPaths)
    assert sublayers[0] == "./x.usd"
    assert sublayers[1].startswith("./" if folder == "." else "../")
    moved = tmp_path / "elsewhere"
    shutil.move(project, moved)
    relative = thin_root.resolve().relative_to(project.resolve())
    stage = Usd.Stage.Open(str(moved / relative))
    assert stage.GetPrimAtPath("/World/Char/Rig/Skel")
    assert stage.GetPrimAtPath("/World/Char/Anim_mtex").GetAttribute("rotations").GetNumTimeSamples() == 13


def test_package_stays_closed(tmp_path: Path) -> None:
    """A .usdz is stacked as it is."""
    _, thin_root = _write(build_package(tmp_path), tmp_path / "shot.mtex.usd")
    assert list(Sdf.Layer.FindOrOpen(str(thin_root)).subLayerPaths) == ["./shot.mtex.usd", "./shot.usdz"]


def test_stage_in_memory_is_an_input_error(local: Situation, tmp_path: Path) -> None:
    """A thin root needs a file to stack; nothing is written."""
    source = open_source(local.shot).stage
    results = make_results(source, local)
    memory = Usd.Stage.CreateInMemory()
    memory.GetRootLayer().TransferContent(source.GetRootLayer())
    with pytest.raises(InputError, match=r"no file that a thin root could stack.*Save it first"):
        write_override(memory, results, tmp_path / "shot.mtex.usd")
    assert not list(tmp_path.glob("*.mtex.*"))


@pytest.mark.parametrize("name", ["shot.mtex.usd", "shot.mtex.stage.usda"])
def test_files_of_others_are_left_alone(local: Situation, tmp_path: Path, name: str) -> None:
    """Neither file is written where one of them would replace somebody else's work."""
    theirs = tmp_path / name
    Sdf.Layer.CreateNew(str(theirs)).Save()
    before = theirs.read_bytes()
    with pytest.raises(InputError, match=rf"{name} exists and was not written by usdmtex"):
        _write(local, tmp_path / "shot.mtex.usd")
    assert theirs.read_bytes() == before
    assert [p.name for p in tmp_path.glob("*.mtex.*")] == [name]


def test_the_shot_itself_is_no_target(local: Situation) -> None:
    """``-o shot.usda`` would destroy the source."""
    before = local.shot.read_bytes()
    with pytest.raises(InputError, match="exists and was not written by usdmtex"):
        _write(local, local.shot)
    assert local.shot.read_bytes() == before


def test_our_own_files_of_another_kind_are_left_alone(local: Situation, tmp_path: Path) -> None:
    """A thin root, or a library of takes, is not an override layer to be replaced."""
    _, thin_root = _write(local, tmp_path / "shot.mtex.usd")
    before = thin_root.read_bytes()
    with pytest.raises(InputError, match="expected an override layer to replace, or no file; found a thin root"):
        _write(local, thin_root)
    assert thin_root.read_bytes() == before


def test_missing_folder_is_an_input_error(local: Situation, tmp_path: Path) -> None:
    """The folder is not made on the user's behalf."""
    with pytest.raises(InputError, match="there is no folder"):
        _write(local, tmp_path / "none" / "x.usd")


# --- selection ---


def test_select_chooses_the_variant(local: Situation, tmp_path: Path) -> None:
    """As asked for, also over what an earlier run selected."""
    _write(local, tmp_path / "shot.mtex.usd")
    _, thin_root = _write(local, tmp_path / "shot.mtex.usd", select="path_03")
    assert _selected(thin_root) == "path_03"


def test_select_of_an_unknown_variant_lists_them(local: Situation, tmp_path: Path) -> None:
    """Nothing is written."""
    with pytest.raises(InputError, match="no variant 'path_07'; expected one of original, path_01, path_02"):
        _write(local, tmp_path / "shot.mtex.usd", variants=2, select="path_07")
    assert not list(tmp_path.glob("*.mtex.*"))


@pytest.mark.parametrize("edited", ["shot.mtex.usd", "shot.mtex.stage.usda"])
@pytest.mark.parametrize("selected", ["original", "path_02"])
def test_rerun_keeps_the_users_selection(local: Situation, tmp_path: Path, edited: str, selected: str) -> None:
    """Wherever the user saved it."""
    out = tmp_path / "shot.mtex.usd"
    _, thin_root = _write(local, out)
    _select_in(tmp_path / edited, selected)
    _write(local, out)
    assert _selected(thin_root) == selected


def test_rerun_into_another_file_keeps_the_selection(local: Situation, tmp_path: Path) -> None:
    """The thin root given carries it along."""
    _, thin_root = _write(local, tmp_path / "shot.mtex.usd")
    _select_in(thin_root, "path_02")
    stage = open_source(thin_root).stage
    _, other = write_override(stage, make_results(stage, local), tmp_path / "other.usd")
    assert _selected(other) == "path_02"


def test_selection_of_a_variant_that_is_gone_falls_back_to_the_best(local: Situation, tmp_path: Path) -> None:
    """Five variants before, two now."""
    _write(local, tmp_path / "shot.mtex.usd", variants=5, select="path_05")
    _, thin_root = _write(local, tmp_path / "shot.mtex.usd", variants=2)
    assert _selected(thin_root) == "path_01"


# --- content ---


def test_custom_data_survives_crate_and_text(local: Situation, tmp_path: Path) -> None:
    """On every path variant and not on the original, with the types the contract names."""
    for name in ("crate.usd", "text.usda"):
        override, _ = _write(local, tmp_path / name)
        layer = Sdf.Layer.FindOrOpen(str(override))
        outputs = [layer.GetPrimAtPath(f"{MODEL}{{mtex={v}}}Anim_mtex") for v in ("original", "path_02")]
        assert not outputs[0].HasInfo("customData")
        data = outputs[1].customData["mtex"]
        assert from_metadata(data) == make_custom_data(10)
        assert (type(data["rank"]), type(data["distance"]), type(data["zeroCostJoins"])) == (int, float, int)
        assert list(data["fragments"]) == ["00", "01"]


@pytest.mark.parametrize(
    "value",
    [
        {"names": ["a", "b"], "counts": [1, 2], "numbers": [0.5, 2.0], "nested": {"deep": {"on": True}}},
        {"many": [{"i": i} for i in range(101)]},
    ],
)
def test_plain_values_survive_as_metadata(value: dict[str, object]) -> None:
    """What goes in comes out, in order."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    Sdf.CreatePrimInLayer(layer, "/A").SetInfo("customData", to_metadata(value))
    again = Sdf.Layer.CreateAnonymous(".usda")
    again.ImportFromString(layer.ExportToString())
    assert from_metadata(again.GetPrimAtPath("/A").GetInfo("customData")) == value


def test_values_without_a_usd_type_are_refused() -> None:
    """Rather than dropped."""
    with pytest.raises(TypeError, match="cannot hold a complex"):
        to_metadata({"a": 1j})


def test_constant_values_beat_animated_ones_of_the_source(local: Situation, tmp_path: Path) -> None:
    """The sketch animates scales; the variants' constant scales are one default and still win."""
    stage = Usd.Stage.Open(str(local.shot))
    scales = stage.GetPrimAtPath("/World/Char/Anim").GetAttribute("scales")
    for time_code, value in ((1, 1.0), (61, 3.0)):
        scales.Set(Vt.Vec3hArray([Gf.Vec3h(value)] * 5), time_code)
    stage.Save()
    _, thin_root = _write(local, tmp_path / "shot.mtex.usd")
    played = local_transforms(Usd.Stage.Open(str(thin_root)), "/World/Char/Rig/Skel", 61)
    assert np.linalg.norm(played["Hips"][0, :3]) == pytest.approx(1.0, abs=1e-3)


def test_keep_takes_over_the_sets_not_made_this_time(tmp_path: Path) -> None:
    """Only the body is done again; the face's variants stay, byte for byte what they were."""
    situation = build_two_sketches(tmp_path)
    out = tmp_path / "shot.mtex.usd"
    stage = open_source(situation.shot).stage
    body, face = make_results(stage, situation)
    write_override(stage, [body, face], out, select="path_02")
    again = make_result(stage, body.character, 7, variants=2)
    _, thin_root = write_override(stage, [again], out, keep=[face.character])
    assert (_selected(thin_root), _selected(thin_root, "mtex_Face")) == ("path_02", "path_02")
    check_override(thin_root, [again, face])
    write_override(stage, [again], out)
    alone = Usd.Stage.Open(str(thin_root))
    assert alone.GetPrimAtPath(MODEL).GetVariantSets().GetNames() == ["mtex"]


def test_keep_of_a_set_never_written_is_nothing(tmp_path: Path) -> None:
    """On the first run there is nothing to take over."""
    situation = build_two_sketches(tmp_path)
    stage = open_source(situation.shot).stage
    body, face = make_results(stage, situation)
    _, thin_root = write_override(stage, [body], tmp_path / "shot.mtex.usd", keep=[face.character])
    check_override(thin_root, [body])


def test_only_what_must_be_is_taken_out_of_instancing(tmp_path: Path) -> None:
    """The outer instances stay instances; the inner one is opened in the path variants and not in the original."""
    situation = build_nested_instances(tmp_path)
    _, thin_root = _write(situation, tmp_path / "shot.mtex.usd")
    stage = Usd.Stage.Open(str(thin_root))
    for name, inner in (("path_01", False), ("original", True)):
        select_variant(stage, "/World/One", "mtex", name)
        assert stage.GetPrimAtPath("/World/One").IsInstance()
        assert stage.GetPrimAtPath("/World/One/Char").IsInstance() is inner
        assert stage.GetPrimAtPath("/World/Two").IsInstance()


# --- opening ---


def test_override_inside_the_shots_own_stack_is_not_read(tmp_path: Path) -> None:
    """A pipeline put the layer into the shot: a rerun reads the animator's work and replaces the layer."""
    situation = build_animation_layer(tmp_path)
    out = tmp_path / "shot.mtex.usd"
    _write(situation, out)
    before = out.read_bytes()
    shot = Sdf.Layer.FindOrOpen(str(situation.shot))
    shot.subLayerPaths.insert(0, "./shot.mtex.usd")
    shot.Save()
    source = open_source(situation.shot)
    assert source.previous_override == out
    assert not source.stage.GetPrimAtPath("/World/Char/Anim_mtex")
    results = make_results(source.stage, situation)
    _, thin_root = write_override(source.stage, results, out)
    check_override(thin_root, results)
    assert out.read_bytes() == before


def test_thin_root_leads_to_the_shot(local: Situation, tmp_path: Path) -> None:
    """And tells which override layer it stacked."""
    override, thin_root = _write(local, tmp_path / "shot.mtex.usd")
    source = open_source(thin_root)
    assert (source.source_path, source.previous_override) == (local.shot, override)
    assert source.stage.GetRootLayer().realPath == str(local.shot)
    assert open_source(local.shot).previous_override is None


def test_override_layer_is_no_shot(local: Situation, tmp_path: Path) -> None:
    """The message says what to give instead."""
    override, _ = _write(local, tmp_path / "shot.mtex.usd")
    with pytest.raises(InputError, match=r"is an override layer.*Give the shot or the thin root"):
        open_source(override)


def test_thin_root_without_its_shot(local: Situation, tmp_path: Path) -> None:
    """The shot was moved away, or taken out of the thin root."""
    _, thin_root = _write(local, tmp_path / "shot.mtex.usd")
    local.shot.rename(tmp_path / "moved.usda")
    with pytest.raises(InputError, match=r"cannot open .*shot\.usda; expected a USD file; found no such file"):
        open_source(thin_root)
    layer = Sdf.Layer.FindOrOpen(str(thin_root))
    del layer.subLayerPaths[1]
    layer.Save()
    with pytest.raises(InputError, match=r"stacks no shot.*found \./shot\.mtex\.usd"):
        open_source(thin_root)


@pytest.mark.parametrize("name", ["broken.usda", "broken.usdc", "broken.txt"])
def test_unreadable_files_are_input_errors(tmp_path: Path, name: str) -> None:
    """Not USD, whatever the name says."""
    (tmp_path / name).write_text("no USD at all")
    with pytest.raises(InputError, match=f"cannot read .*{name}"):
        open_source(tmp_path / name)
