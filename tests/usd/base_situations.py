"""The 21 base situations: how a character is brought in, and where its animation and its binding are."""

from pathlib import Path

from pxr import Usd

from tests.usd.stage_parts import (
    Situation,
    add_character,
    add_model,
    add_rig,
    add_skeleton,
    add_sketch,
    add_world,
    author_clips,
    bind,
    binding_prim,
    expect_one,
    new_stage,
    write_asset,
)

# --- the 16: eight ways to bring a character in, each bound on its Skeleton and on its SkelRoot ---


def build_local(folder: Path, on: str) -> Situation:
    """Everything in the shot's own root layer."""
    stage = new_stage(folder / "shot.usda")
    add_world(stage)
    add_character(stage, "/World/Char", on)
    stage.Save()
    return expect_one(folder / "shot.usda")


def build_referenced(folder: Path, on: str) -> Situation:
    """The character is an asset, referenced."""
    write_asset(folder, on)
    stage = new_stage(folder / "shot.usda")
    add_world(stage)
    stage.DefinePrim("/World/Char").GetReferences().AddReference("./asset.usda")
    stage.Save()
    return expect_one(folder / "shot.usda")


def build_payloaded(folder: Path, on: str) -> Situation:
    """The character is an asset, brought in by a payload."""
    write_asset(folder, on)
    stage = new_stage(folder / "shot.usda")
    add_world(stage)
    stage.DefinePrim("/World/Char").GetPayloads().AddPayload("./asset.usda")
    stage.Save()
    return expect_one(folder / "shot.usda")


def build_instanceable(folder: Path, on: str) -> Situation:
    """The character is an instance: nothing below it can be edited."""
    write_asset(folder, on)
    stage = new_stage(folder / "shot.usda")
    add_world(stage)
    prim = stage.DefinePrim("/World/Char")
    prim.GetReferences().AddReference("./asset.usda")
    prim.SetInstanceable(True)
    stage.Save()
    return expect_one(folder / "shot.usda")


def _author_in_variants(stage: Usd.Stage, model: str, on: str) -> None:
    variants = stage.GetPrimAtPath(model).GetVariantSets().AddVariantSet("action")
    for name in ("walk", "stand"):
        variants.AddVariant(name)
        variants.SetVariantSelection(name)
        with variants.GetVariantEditContext():
            add_sketch(stage, f"{model}/Anim", f"{model}/Takes", None if name == "walk" else [1.0])
            bind(binding_prim(stage, model, on), f"{model}/Anim")
    variants.SetVariantSelection("walk")


def build_asset_variants(folder: Path, on: str) -> Situation:
    """The asset has a variant set of its own that holds the animation and the binding."""
    asset = new_stage(folder / "asset.usda")
    add_model(asset, "/Char")
    add_rig(asset, "/Char")
    _author_in_variants(asset, "/Char", on)
    asset.SetDefaultPrim(asset.GetPrimAtPath("/Char"))
    asset.Save()
    stage = new_stage(folder / "shot.usda")
    add_world(stage)
    stage.DefinePrim("/World/Char").GetReferences().AddReference("./asset.usda")
    stage.Save()
    return expect_one(folder / "shot.usda")


def build_local_variants(folder: Path, on: str) -> Situation:
    """The shot's root layer has a variant set that holds the animation and the binding."""
    stage = new_stage(folder / "shot.usda")
    add_world(stage)
    add_model(stage, "/World/Char")
    add_rig(stage, "/World/Char")
    _author_in_variants(stage, "/World/Char", on)
    stage.Save()
    return expect_one(folder / "shot.usda")


def build_two_skeletons(folder: Path, on: str) -> Situation:
    """Two Skeletons of one SkelRoot play the same animation."""
    stage = new_stage(folder / "shot.usda")
    add_world(stage)
    add_character(stage, "/World/Char", on)
    second = add_skeleton(stage, "/World/Char/Rig/Skel2")
    if on == "Skeleton":
        bind(second, "/World/Char/Anim")
    stage.Save()
    return expect_one(folder / "shot.usda", skeletons=("/World/Char/Rig/Skel", "/World/Char/Rig/Skel2"))


def build_default_only(folder: Path, on: str) -> Situation:
    """The animation holds a pose and no time samples."""
    stage = new_stage(folder / "shot.usda")
    add_world(stage)
    add_character(stage, "/World/Char", on, times=[])
    stage.Save()
    return expect_one(folder / "shot.usda")


# --- the other five of the base 21 ---


def _build_inherited(folder: Path, *, instanceable: bool) -> Situation:
    asset = new_stage(folder / "asset.usda")
    add_model(asset, "/Char")
    add_rig(asset, "/Char")
    asset.SetDefaultPrim(asset.GetPrimAtPath("/Char"))
    asset.Save()
    stage = new_stage(folder / "shot.usda")
    add_world(stage)
    prim = stage.DefinePrim("/World/Char")
    prim.GetReferences().AddReference("./asset.usda")
    prim.SetInstanceable(instanceable)
    add_sketch(stage, "/World/Anims/Walk", "/World/Char/Takes")
    bind(stage.GetPrimAtPath("/World"), "/World/Anims/Walk")
    stage.Save()
    return expect_one(folder / "shot.usda", animation="/World/Anims/Walk")


def build_inherited_binding(folder: Path) -> Situation:
    """The binding is on a prim far above the SkelRoot, the animation beside the model."""
    return _build_inherited(folder, instanceable=False)


def build_inherited_binding_instanceable(folder: Path) -> Situation:
    """The same with the model an instance."""
    return _build_inherited(folder, instanceable=True)


def build_unbound(folder: Path) -> Situation:
    """No Skeleton is bound to the sketch, which lies in the SkelRoot whose Skeleton it is meant for."""
    stage = new_stage(folder / "shot.usda")
    add_world(stage)
    add_model(stage, "/World/Char")
    add_rig(stage, "/World/Char")
    add_sketch(stage, "/World/Char/Rig/Anim", "/World/Char/Takes")
    stage.Save()
    return expect_one(folder / "shot.usda", animation="/World/Char/Rig/Anim")


def build_animation_layer(folder: Path) -> Situation:
    """The animation department's layer is stacked over the layout; it holds animation and binding."""
    layout = new_stage(folder / "layout.usda")
    add_world(layout)
    add_model(layout, "/World/Char")
    add_rig(layout, "/World/Char")
    layout.Save()
    animation = new_stage(folder / "animation.usda")
    animation.OverridePrim("/World/Char")
    add_sketch(animation, "/World/Char/Anim", "/World/Char/Takes")
    bind(animation.OverridePrim("/World/Char/Rig/Skel"), "/World/Char/Anim")
    animation.Save()
    stage = new_stage(folder / "shot.usda")
    stage.GetRootLayer().subLayerPaths = ["./animation.usda", "./layout.usda"]
    stage.GetRootLayer().defaultPrim = "World"
    stage.Save()
    return expect_one(folder / "shot.usda")


def build_value_clips(folder: Path) -> Situation:
    """The animation's samples come from value clips on the animation prim."""
    stage = new_stage(folder / "shot.usda")
    add_world(stage)
    add_character(stage, "/World/Char", "Skeleton")
    author_clips(stage, "/World/Char/Anim", "/Anim", "/World/Char/Anim", folder)
    stage.Save()
    return expect_one(folder / "shot.usda")
