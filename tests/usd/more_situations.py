"""Situations beyond the base: those that bend time, names or instancing, and two odd files."""

from collections.abc import Sequence
from pathlib import Path

from pxr import Sdf, UsdSkel, UsdUtils

from tests.usd.stage_parts import (
    SKETCH_JOINTS,
    Expected,
    Situation,
    add_animation,
    add_character,
    add_model,
    add_recipe,
    add_rig,
    add_skeleton,
    add_sketch,
    add_takes,
    add_world,
    author_clips,
    bind,
    binding_prim,
    expect_character,
    expect_one,
    new_stage,
    write_asset,
)


def build_value_clips_on_model(folder: Path) -> Situation:
    """Value clips on the model bring the samples of the animation below it."""
    stage = new_stage(folder / "shot.usda")
    add_world(stage)
    add_character(stage, "/World/Char", "Skeleton")
    author_clips(stage, "/World/Char", "/Char", "/World/Char/Anim", folder)
    stage.Save()
    return expect_one(folder / "shot.usda")


def build_value_clips_elsewhere(folder: Path) -> Situation:
    """Value clips on a prim that is above the animation and not above the character."""
    stage = new_stage(folder / "shot.usda")
    add_world(stage)
    add_model(stage, "/World/Char")
    add_rig(stage, "/World/Char")
    add_sketch(stage, "/World/Anims/Walk", "/World/Char/Takes")
    bind(binding_prim(stage, "/World/Char", "Skeleton"), "/World/Anims/Walk")
    author_clips(stage, "/World/Anims", "/Anims", "/World/Anims/Walk", folder)
    stage.Save()
    return expect_one(folder / "shot.usda", animation="/World/Anims/Walk")


def build_offset_sublayer(folder: Path) -> Situation:
    """The character's layer is stacked with an offset and a scale."""
    layer = new_stage(folder / "anim.usda")
    add_world(layer)
    add_character(layer, "/World/Char", "Skeleton")
    layer.Save()
    stage = new_stage(folder / "shot.usda", startTimeCode=101, endTimeCode=161)
    root = stage.GetRootLayer()
    root.subLayerPaths = ["./anim.usda"]
    root.subLayerOffsets[0] = Sdf.LayerOffset(100)
    root.defaultPrim = "World"
    stage.Save()
    return expect_one(folder / "shot.usda")


def build_scaled_reference(folder: Path) -> Situation:
    """The asset is referenced at half speed and later."""
    write_asset(folder, "Skeleton")
    stage = new_stage(folder / "shot.usda", startTimeCode=12, endTimeCode=132)
    add_world(stage)
    char = stage.DefinePrim("/World/Char")
    char.GetReferences().AddReference("./asset.usda", layerOffset=Sdf.LayerOffset(10, 2))
    stage.Save()
    return expect_one(folder / "shot.usda")


def build_other_rates(folder: Path) -> Situation:
    """The asset runs at 120 time codes a second, the shot at 48 with 24 frames a second."""
    asset = new_stage(folder / "asset.usda", timeCodesPerSecond=120, endTimeCode=301)
    add_model(asset, "/Char")
    UsdSkel.Root.Define(asset, "/Char/Rig")
    add_skeleton(asset, "/Char/Rig/Skel")
    add_takes(asset, "/Char/Takes", "/Char/Rig/Skel", rate=120.0)
    times = [float(t) for t in range(1, 302, 30)]
    add_recipe(add_animation(asset, "/Char/Anim", SKETCH_JOINTS, times, rate=120.0), "/Char/Takes")
    bind(binding_prim(asset, "/Char", "Skeleton"), "/Char/Anim")
    asset.SetDefaultPrim(asset.GetPrimAtPath("/Char"))
    asset.Save()
    stage = new_stage(folder / "shot.usda", timeCodesPerSecond=48, framesPerSecond=24, startTimeCode=0, endTimeCode=121)
    add_world(stage)
    stage.DefinePrim("/World/Char").GetReferences().AddReference("./asset.usda")
    stage.Save()
    return expect_one(folder / "shot.usda")


def build_two_characters(folder: Path) -> Situation:
    """Two characters share one model, so each keeps its set on its own SkelRoot; both play one animation."""
    stage = new_stage(folder / "shot.usda")
    add_world(stage)
    add_model(stage, "/World/Pair")
    for name in ("A", "B"):
        UsdSkel.Root.Define(stage, f"/World/Pair/{name}")
        bind(add_skeleton(stage, f"/World/Pair/{name}/Skel"), "/World/Pair/Anim")
    add_takes(stage, "/World/Pair/Takes", "/World/Pair/A/Skel")
    add_sketch(stage, "/World/Pair/Anim", "/World/Pair/Takes")
    stage.Save()
    expected = tuple(
        expect_character(f"/World/Pair/{n}", "/World/Pair/Anim", f"/World/Pair/{n}/Skel") for n in ("A", "B")
    )
    return Situation(shot=folder / "shot.usda", animations=("/World/Pair/Anim",), expected=expected)


def build_two_instances(folder: Path) -> Situation:
    """Two instances of one asset, each playing the asset's own animation."""
    write_asset(folder, "Skeleton")
    stage = new_stage(folder / "shot.usda")
    add_world(stage)
    for name in ("One", "Two"):
        prim = stage.DefinePrim(f"/World/{name}")
        prim.GetReferences().AddReference("./asset.usda")
        prim.SetInstanceable(True)
    stage.Save()
    models = ("/World/One", "/World/Two")
    expected = tuple(expect_character(model, f"{model}/Anim", f"{model}/Rig/Skel") for model in models)
    return Situation(shot=folder / "shot.usda", animations=tuple(f"{m}/Anim" for m in models), expected=expected)


def build_two_sketches(folder: Path) -> Situation:
    """One character with two Skeletons, each with its own sketch."""
    stage = new_stage(folder / "shot.usda")
    add_world(stage)
    add_character(stage, "/World/Char", "Skeleton")
    add_sketch(stage, "/World/Char/Face", "/World/Char/Takes", [1.0, 21.0, 41.0, 61.0])
    bind(add_skeleton(stage, "/World/Char/Rig/FaceSkel"), "/World/Char/Face")
    stage.Save()
    model = "/World/Char"
    expected = (
        expect_character(model, f"{model}/Anim", f"{model}/Rig/Skel"),
        expect_character(model, f"{model}/Face", f"{model}/Rig/FaceSkel", "mtex_Face"),
    )
    return Situation(shot=folder / "shot.usda", animations=(f"{model}/Anim", f"{model}/Face"), expected=expected)


def build_nested_models(folder: Path) -> Situation:
    """A group of a character and a prop rig: the component that holds the character alone gets the set."""
    stage = new_stage(folder / "shot.usda")
    add_world(stage)
    add_model(stage, "/World/Crew", "group")
    add_character(stage, "/World/Crew/Char", "Skeleton")
    add_model(stage, "/World/Crew/Prop")
    UsdSkel.Root.Define(stage, "/World/Crew/Prop/Rig")
    add_skeleton(stage, "/World/Crew/Prop/Rig/Skel")
    stage.Save()
    return expect_one(folder / "shot.usda", model="/World/Crew/Char")


def _build_nested_instances(folder: Path, inner_names: Sequence[str]) -> tuple[str, ...]:
    write_asset(folder, "Skeleton")
    outer = new_stage(folder / "outer.usda")
    add_model(outer, "/Outer", "group")
    for name in inner_names:
        inner = outer.DefinePrim(f"/Outer/{name}")
        inner.GetReferences().AddReference("./asset.usda")
        inner.SetInstanceable(True)
    outer.SetDefaultPrim(outer.GetPrimAtPath("/Outer"))
    outer.Save()
    stage = new_stage(folder / "shot.usda")
    add_world(stage)
    models = ("/World/One", "/World/Two")
    for model in models:
        prim = stage.DefinePrim(model)
        prim.GetReferences().AddReference("./outer.usda")
        prim.SetInstanceable(True)
    stage.Save()
    return models


def build_nested_instances(folder: Path) -> Situation:
    """An instance inside each of two instances: the sets go on the outer ones."""
    models = _build_nested_instances(folder, ("Char",))
    expected = tuple(expect_character(model, f"{model}/Char/Anim", f"{model}/Char/Rig/Skel") for model in models)
    return Situation(shot=folder / "shot.usda", animations=tuple(e.animation for e in expected), expected=expected)


def build_nested_instance_pair(folder: Path) -> Situation:
    """Two characters inside one instance have to share its prim, though their animations have the same name."""
    models = _build_nested_instances(folder, ("A", "B"))
    expected = tuple(
        Expected(
            animation=f"{model}/{name}/Anim",
            skeletons=(f"{model}/{name}/Rig/Skel",),
            model=model,
            variant_set=variant_set,
            output=f"{model}/{output}",
        )
        for model in models
        for name, variant_set, output in (("A", "mtex", "Anim_mtex"), ("B", "mtex_Anim", "Anim_2_mtex"))
    )
    return Situation(shot=folder / "shot.usda", animations=tuple(e.animation for e in expected), expected=expected)


def build_package(folder: Path) -> Situation:
    """The shot is a .usdz package, which cannot be written into."""
    parts = folder / "parts"
    parts.mkdir()
    stage = new_stage(parts / "inside.usda")
    add_world(stage)
    add_character(stage, "/World/Char", "Skeleton")
    stage.Save()
    UsdUtils.CreateNewUsdzPackage(str(parts / "inside.usda"), str(folder / "shot.usdz"))
    (parts / "inside.usda").unlink()
    parts.rmdir()
    return expect_one(folder / "shot.usdz")


def build_no_model(folder: Path) -> Situation:
    """No prim has a model kind, so the SkelRoot gets the set."""
    stage = new_stage(folder / "shot.usda")
    UsdSkel.Root.Define(stage, "/Rig")
    bind(add_skeleton(stage, "/Rig/Skel"), "/Rig/Anim")
    add_takes(stage, "/Takes", "/Rig/Skel")
    add_sketch(stage, "/Rig/Anim", "/Takes")
    stage.Save()
    return expect_one(folder / "shot.usda", model="/Rig", skeletons=("/Rig/Skel",))
