"""Stages in every situation a sketch is found in: 21 base ones and those that bend time, names or instancing.

Each builder writes layers into a folder and tells what should come of them. All use one character: six joints walking,
a sketch that lacks the arm, and a recipe with two short takes, so that the whole tool can run on them too.
Imports nothing from the package under test.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, UsdUtils, Vt

FloatArray = npt.NDArray[np.float64]

JOINTS = (
    "Hips",
    "Hips/Spine",
    "Hips/Spine/LeftArm",
    "Hips/LeftLeg",
    "Hips/LeftLeg/LeftFoot",
    "Hips/RightLeg",
)
SKETCH_JOINTS = ("Hips", "Hips/LeftLeg", "Hips/LeftLeg/LeftFoot", "Hips/RightLeg", "Hips/Spine")
ADDED_JOINT = "Hips/Spine/LeftArm"
OFFSETS = {
    "Hips": (0.0, 90.0, 0.0),
    "Hips/Spine": (0.0, 20.0, 0.0),
    "Hips/Spine/LeftArm": (20.0, 20.0, 0.0),
    "Hips/LeftLeg": (10.0, 0.0, 0.0),
    "Hips/LeftLeg/LeftFoot": (0.0, -80.0, 5.0),
    "Hips/RightLeg": (-10.0, 0.0, 0.0),
}
SWING = {
    "Hips": (4.0, 0.3),
    "Hips/Spine": (6.0, 1.1),
    "Hips/Spine/LeftArm": (30.0, np.pi),
    "Hips/LeftLeg": (28.0, 0.0),
    "Hips/LeftLeg/LeftFoot": (15.0, 0.9),
    "Hips/RightLeg": (28.0, np.pi),
}
START, END, STEP = 1, 61, 6


@dataclass(frozen=True, kw_only=True)
class Expected:
    """What one character of a situation should look like to the tool; all are prim paths."""

    animation: str
    skeletons: tuple[str, ...]
    model: str
    variant_set: str = "mtex"
    output: str


@dataclass(frozen=True, kw_only=True)
class Situation:
    """A stage on disk: the file to open, the sketches on it, and one entry per character and sketch."""

    shot: Path
    animations: tuple[str, ...]
    expected: tuple[Expected, ...]

    @property
    def source_files(self) -> tuple[Path, ...]:
        """Every file that was there before the tool ran."""
        return tuple(sorted(p for p in self.shot.parent.iterdir() if ".mtex." not in p.name))


# --- pieces of a character ---


def _new_stage(file_path: Path, **metadata: float) -> Usd.Stage:
    stage = Usd.Stage.CreateNew(str(file_path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    for key, value in ({"timeCodesPerSecond": 24, "startTimeCode": START, "endTimeCode": END} | metadata).items():
        stage.SetMetadata(key, value)
    return stage


def _swing_arrays(joints: Sequence[str], second: float, *, style: float = 1.0) -> tuple[Vt.QuatfArray, Vt.Vec3fArray]:
    phase = 2.0 * np.pi * 0.9 * second * style
    rotations, translations = [], []
    for joint in joints:
        angle, shift = SWING[joint]
        degrees = style * angle * (np.sin(phase + shift) + 0.15 * np.sin(3.0 * phase + shift))
        q = Gf.Rotation(Gf.Vec3d(1, 0.1, 0).GetNormalized(), float(degrees)).GetQuat()
        rotations.append(Gf.Quatf(q))
        translations.append(Gf.Vec3f(*OFFSETS[joint]))
    translations[0] += Gf.Vec3f(0.0, float(3.0 * np.cos(2.0 * phase)), float(100.0 * second))
    return Vt.QuatfArray(rotations), Vt.Vec3fArray(translations)


def _rest_matrix(joint: str) -> Gf.Matrix4d:
    return Gf.Matrix4d().SetTranslate(Gf.Vec3d(*OFFSETS[joint]))


def _add_skeleton(stage: Usd.Stage, prim_path: str) -> Usd.Prim:
    skeleton = UsdSkel.Skeleton.Define(stage, prim_path)
    skeleton.CreateJointsAttr(Vt.TokenArray(JOINTS))
    rest = {joint: _rest_matrix(joint) for joint in JOINTS}
    bind = dict(rest)
    for joint in JOINTS:
        parent = joint.rpartition("/")[0]
        if parent:
            bind[joint] = rest[joint] * bind[parent]
    skeleton.CreateRestTransformsAttr(Vt.Matrix4dArray([rest[joint] for joint in JOINTS]))
    skeleton.CreateBindTransformsAttr(Vt.Matrix4dArray([bind[joint] for joint in JOINTS]))
    return skeleton.GetPrim()


def _add_animation(
    stage: Usd.Stage,
    prim_path: str,
    joints: Sequence[str],
    times: Sequence[float],
    *,
    rate: float = 24.0,
    style: float = 1.0,
) -> Usd.Prim:
    """Author a walk at the given time codes; no time codes means default values only."""
    animation = UsdSkel.Animation.Define(stage, prim_path)
    animation.CreateJointsAttr(Vt.TokenArray(list(joints)))
    animation.CreateScalesAttr(Vt.Vec3hArray([Gf.Vec3h(1, 1, 1)] * len(joints)))
    rotations, translations = animation.CreateRotationsAttr(), animation.CreateTranslationsAttr()
    for time_code in times or (Usd.TimeCode.Default(),):
        second = 0.4 if time_code == Usd.TimeCode.Default() else (time_code - START) / rate
        q, t = _swing_arrays(joints, second, style=style)
        rotations.Set(q, time_code)
        translations.Set(t, time_code)
    return animation.GetPrim()


def _set_uniform(prim: Usd.Prim, name: str, value_type: Sdf.ValueTypeName, value: object) -> None:
    prim.CreateAttribute(name, value_type, custom=False, variability=Sdf.VariabilityUniform).Set(value)


def _add_recipe(animation: Usd.Prim, takes: str) -> None:
    """Mark an animation as a sketch whose takes are below a prim; by metadata, so the schema need not be registered."""
    animation.AddAppliedSchema("MtexSketchAPI")
    animation.AddAppliedSchema("MtexSegmentAPI:late")
    animation.CreateRelationship("mtex:takes", custom=False).SetTargets([takes])
    tokens = Sdf.ValueTypeNames.TokenArray
    _set_uniform(animation, "mtex:match", tokens, Vt.TokenArray(["LeftLeg.rx", "LeftFoot.rx"]))
    _set_uniform(animation, "mtex:synthesize", tokens, Vt.TokenArray(["LeftArm"]))
    _set_uniform(animation, "mtex:paths", Sdf.ValueTypeNames.Int, 3)
    _set_uniform(animation, "mtex:segment:late:start", Sdf.ValueTypeNames.TimeCode, Sdf.TimeCode(40))
    _set_uniform(animation, "mtex:segment:late:end", Sdf.ValueTypeNames.TimeCode, Sdf.TimeCode(END))


def _add_takes(stage: Usd.Stage, prim_path: str, skeleton: str, *, rate: float = 24.0) -> None:
    """Author two short walks at every time code, each pointing at the skeleton it moves."""
    UsdGeom.Scope.Define(stage, prim_path)
    for name, style in (("walk_1", 1.1), ("walk_2", 0.9)):
        times = [float(t) for t in range(START, START + 96)]
        take = _add_animation(stage, f"{prim_path}/{name}", JOINTS, times, rate=rate, style=style)
        take.AddAppliedSchema("MtexTakeAPI")
        take.CreateRelationship("mtex:take:skeleton", custom=False).SetTargets([skeleton])


def _bind(prim: Usd.Prim, animation: str) -> None:
    UsdSkel.BindingAPI.Apply(prim).CreateAnimationSourceRel().SetTargets([animation])


def _key_times() -> list[float]:
    return [float(t) for t in range(START, END + 1, STEP)]


def _add_model(stage: Usd.Stage, prim_path: str, kind: str = "component") -> None:
    model = UsdGeom.Xform.Define(stage, prim_path)
    Usd.ModelAPI(model).SetKind(kind)


def _add_rig(stage: Usd.Stage, model: str) -> None:
    """Author the SkelRoot, the Skeleton and the takes of a character; no animation yet."""
    UsdSkel.Root.Define(stage, f"{model}/Rig")
    _add_skeleton(stage, f"{model}/Rig/Skel")
    _add_takes(stage, f"{model}/Takes", f"{model}/Rig/Skel")


def _add_sketch(stage: Usd.Stage, prim_path: str, takes: str, times: Sequence[float] | None = None) -> None:
    times = _key_times() if times is None else times
    _add_recipe(_add_animation(stage, prim_path, SKETCH_JOINTS, times), takes)


def _binding_prim(stage: Usd.Stage, model: str, on: str) -> Usd.Prim:
    return stage.GetPrimAtPath(f"{model}/Rig/Skel" if on == "Skeleton" else f"{model}/Rig")


def _add_character(stage: Usd.Stage, model: str, on: str, times: Sequence[float] | None = None) -> None:
    """Author a whole character whose sketch is a child of the model, bound on its Skeleton or its SkelRoot."""
    _add_model(stage, model)
    _add_rig(stage, model)
    _add_sketch(stage, f"{model}/Anim", f"{model}/Takes", times)
    _bind(_binding_prim(stage, model, on), f"{model}/Anim")


def _add_world(stage: Usd.Stage) -> None:
    _add_model(stage, "/World", "assembly")
    stage.SetDefaultPrim(stage.GetPrimAtPath("/World"))


def _write_asset(folder: Path, on: str) -> None:
    asset = _new_stage(folder / "asset.usda")
    _add_character(asset, "/Char", on)
    asset.SetDefaultPrim(asset.GetPrimAtPath("/Char"))
    asset.Save()


def _one(
    shot: Path, *, model: str = "/World/Char", animation: str | None = None, skeletons: Sequence[str] = ()
) -> Situation:
    animation = animation or f"{model}/Anim"
    expected = Expected(
        animation=animation,
        skeletons=tuple(skeletons) or (f"{model}/Rig/Skel",),
        model=model,
        output=f"{model}/{Sdf.Path(animation).name}_mtex",
    )
    return Situation(shot=shot, animations=(animation,), expected=(expected,))


# --- the 16: eight ways to bring a character in, each bound on its Skeleton and on its SkelRoot ---


def build_local(folder: Path, on: str) -> Situation:
    """Everything in the shot's own root layer."""
    stage = _new_stage(folder / "shot.usda")
    _add_world(stage)
    _add_character(stage, "/World/Char", on)
    stage.Save()
    return _one(folder / "shot.usda")


def build_referenced(folder: Path, on: str) -> Situation:
    """The character is an asset, referenced."""
    _write_asset(folder, on)
    stage = _new_stage(folder / "shot.usda")
    _add_world(stage)
    stage.DefinePrim("/World/Char").GetReferences().AddReference("./asset.usda")
    stage.Save()
    return _one(folder / "shot.usda")


def build_payloaded(folder: Path, on: str) -> Situation:
    """The character is an asset, brought in by a payload."""
    _write_asset(folder, on)
    stage = _new_stage(folder / "shot.usda")
    _add_world(stage)
    stage.DefinePrim("/World/Char").GetPayloads().AddPayload("./asset.usda")
    stage.Save()
    return _one(folder / "shot.usda")


def build_instanceable(folder: Path, on: str) -> Situation:
    """The character is an instance: nothing below it can be edited."""
    _write_asset(folder, on)
    stage = _new_stage(folder / "shot.usda")
    _add_world(stage)
    prim = stage.DefinePrim("/World/Char")
    prim.GetReferences().AddReference("./asset.usda")
    prim.SetInstanceable(True)
    stage.Save()
    return _one(folder / "shot.usda")


def _author_in_variants(stage: Usd.Stage, model: str, on: str) -> None:
    variants = stage.GetPrimAtPath(model).GetVariantSets().AddVariantSet("action")
    for name in ("walk", "stand"):
        variants.AddVariant(name)
        variants.SetVariantSelection(name)
        with variants.GetVariantEditContext():
            _add_sketch(stage, f"{model}/Anim", f"{model}/Takes", None if name == "walk" else [1.0])
            _bind(_binding_prim(stage, model, on), f"{model}/Anim")
    variants.SetVariantSelection("walk")


def build_asset_variants(folder: Path, on: str) -> Situation:
    """The asset has a variant set of its own that holds the animation and the binding."""
    asset = _new_stage(folder / "asset.usda")
    _add_model(asset, "/Char")
    _add_rig(asset, "/Char")
    _author_in_variants(asset, "/Char", on)
    asset.SetDefaultPrim(asset.GetPrimAtPath("/Char"))
    asset.Save()
    stage = _new_stage(folder / "shot.usda")
    _add_world(stage)
    stage.DefinePrim("/World/Char").GetReferences().AddReference("./asset.usda")
    stage.Save()
    return _one(folder / "shot.usda")


def build_local_variants(folder: Path, on: str) -> Situation:
    """The shot's root layer has a variant set that holds the animation and the binding."""
    stage = _new_stage(folder / "shot.usda")
    _add_world(stage)
    _add_model(stage, "/World/Char")
    _add_rig(stage, "/World/Char")
    _author_in_variants(stage, "/World/Char", on)
    stage.Save()
    return _one(folder / "shot.usda")


def build_two_skeletons(folder: Path, on: str) -> Situation:
    """Two Skeletons of one SkelRoot play the same animation."""
    stage = _new_stage(folder / "shot.usda")
    _add_world(stage)
    _add_character(stage, "/World/Char", on)
    second = _add_skeleton(stage, "/World/Char/Rig/Skel2")
    if on == "Skeleton":
        _bind(second, "/World/Char/Anim")
    stage.Save()
    return _one(folder / "shot.usda", skeletons=("/World/Char/Rig/Skel", "/World/Char/Rig/Skel2"))


def build_default_only(folder: Path, on: str) -> Situation:
    """The animation holds a pose and no time samples."""
    stage = _new_stage(folder / "shot.usda")
    _add_world(stage)
    _add_character(stage, "/World/Char", on, times=[])
    stage.Save()
    return _one(folder / "shot.usda")


# --- the other five of the base 21 ---


def _build_inherited(folder: Path, *, instanceable: bool) -> Situation:
    asset = _new_stage(folder / "asset.usda")
    _add_model(asset, "/Char")
    _add_rig(asset, "/Char")
    asset.SetDefaultPrim(asset.GetPrimAtPath("/Char"))
    asset.Save()
    stage = _new_stage(folder / "shot.usda")
    _add_world(stage)
    prim = stage.DefinePrim("/World/Char")
    prim.GetReferences().AddReference("./asset.usda")
    prim.SetInstanceable(instanceable)
    _add_sketch(stage, "/World/Anims/Walk", "/World/Char/Takes")
    _bind(stage.GetPrimAtPath("/World"), "/World/Anims/Walk")
    stage.Save()
    return _one(folder / "shot.usda", animation="/World/Anims/Walk")


def build_inherited_binding(folder: Path) -> Situation:
    """The binding is on a prim far above the SkelRoot, the animation beside the model."""
    return _build_inherited(folder, instanceable=False)


def build_inherited_binding_instanceable(folder: Path) -> Situation:
    """The same with the model an instance."""
    return _build_inherited(folder, instanceable=True)


def build_unbound(folder: Path) -> Situation:
    """No Skeleton is bound to the sketch, which lies in the SkelRoot whose Skeleton it is meant for."""
    stage = _new_stage(folder / "shot.usda")
    _add_world(stage)
    _add_model(stage, "/World/Char")
    _add_rig(stage, "/World/Char")
    _add_sketch(stage, "/World/Char/Rig/Anim", "/World/Char/Takes")
    stage.Save()
    return _one(folder / "shot.usda", animation="/World/Char/Rig/Anim")


def build_animation_layer(folder: Path) -> Situation:
    """The animation department's layer is stacked over the layout; it holds animation and binding."""
    layout = _new_stage(folder / "layout.usda")
    _add_world(layout)
    _add_model(layout, "/World/Char")
    _add_rig(layout, "/World/Char")
    layout.Save()
    animation = _new_stage(folder / "animation.usda")
    animation.OverridePrim("/World/Char")
    _add_sketch(animation, "/World/Char/Anim", "/World/Char/Takes")
    _bind(animation.OverridePrim("/World/Char/Rig/Skel"), "/World/Char/Anim")
    animation.Save()
    stage = _new_stage(folder / "shot.usda")
    stage.GetRootLayer().subLayerPaths = ["./animation.usda", "./layout.usda"]
    stage.GetRootLayer().defaultPrim = "World"
    stage.Save()
    return _one(folder / "shot.usda")


def _author_clips(stage: Usd.Stage, prim_path: str, clip_prim: str, animation: str, folder: Path) -> None:
    """Move an animation's samples into two clip files that a prim's clips bring back."""
    times = _key_times()
    moved = stage.GetPrimAtPath(animation)
    inside = clip_prim + animation.removeprefix(prim_path)
    for name, part in (("clip_1.usda", times[:6]), ("clip_2.usda", times[5:])):
        clip = Usd.Stage.CreateNew(str(folder / name))
        for attribute in ("rotations", "translations"):
            source = moved.GetAttribute(attribute)
            target = clip.OverridePrim(inside).CreateAttribute(attribute, source.GetTypeName(), custom=False)
            for time_code in part:
                target.Set(source.Get(time_code), time_code)
        clip.Save()
    moved.GetAttribute("rotations").Clear()
    moved.GetAttribute("translations").Clear()
    clips = Usd.ClipsAPI(stage.GetPrimAtPath(prim_path))
    clips.SetClipAssetPaths([Sdf.AssetPath("./clip_1.usda"), Sdf.AssetPath("./clip_2.usda")])
    clips.SetClipPrimPath(clip_prim)
    clips.SetClipActive(Vt.Vec2dArray([Gf.Vec2d(START, 0), Gf.Vec2d(times[5], 1)]))
    clips.SetClipTimes(Vt.Vec2dArray([Gf.Vec2d(START, START), Gf.Vec2d(END, END)]))
    manifest = clips.GenerateClipManifest()
    manifest.Export(str(folder / "manifest.usda"))
    clips.SetClipManifestAssetPath(Sdf.AssetPath("./manifest.usda"))


def build_value_clips(folder: Path) -> Situation:
    """The animation's samples come from value clips on the animation prim."""
    stage = _new_stage(folder / "shot.usda")
    _add_world(stage)
    _add_character(stage, "/World/Char", "Skeleton")
    _author_clips(stage, "/World/Char/Anim", "/Anim", "/World/Char/Anim", folder)
    stage.Save()
    return _one(folder / "shot.usda")


# --- beyond the base ---


def build_value_clips_on_model(folder: Path) -> Situation:
    """Value clips on the model bring the samples of the animation below it."""
    stage = _new_stage(folder / "shot.usda")
    _add_world(stage)
    _add_character(stage, "/World/Char", "Skeleton")
    _author_clips(stage, "/World/Char", "/Char", "/World/Char/Anim", folder)
    stage.Save()
    return _one(folder / "shot.usda")


def build_value_clips_elsewhere(folder: Path) -> Situation:
    """Value clips on a prim that is above the animation and not above the character."""
    stage = _new_stage(folder / "shot.usda")
    _add_world(stage)
    _add_model(stage, "/World/Char")
    _add_rig(stage, "/World/Char")
    _add_sketch(stage, "/World/Anims/Walk", "/World/Char/Takes")
    _bind(_binding_prim(stage, "/World/Char", "Skeleton"), "/World/Anims/Walk")
    _author_clips(stage, "/World/Anims", "/Anims", "/World/Anims/Walk", folder)
    stage.Save()
    return _one(folder / "shot.usda", animation="/World/Anims/Walk")


def build_offset_sublayer(folder: Path) -> Situation:
    """The character's layer is stacked with an offset and a scale."""
    layer = _new_stage(folder / "anim.usda")
    _add_world(layer)
    _add_character(layer, "/World/Char", "Skeleton")
    layer.Save()
    stage = _new_stage(folder / "shot.usda", startTimeCode=101, endTimeCode=161)
    root = stage.GetRootLayer()
    root.subLayerPaths = ["./anim.usda"]
    root.subLayerOffsets[0] = Sdf.LayerOffset(100)
    root.defaultPrim = "World"
    stage.Save()
    return _one(folder / "shot.usda")


def build_scaled_reference(folder: Path) -> Situation:
    """The asset is referenced at half speed and later."""
    _write_asset(folder, "Skeleton")
    stage = _new_stage(folder / "shot.usda", startTimeCode=12, endTimeCode=132)
    _add_world(stage)
    char = stage.DefinePrim("/World/Char")
    char.GetReferences().AddReference("./asset.usda", layerOffset=Sdf.LayerOffset(10, 2))
    stage.Save()
    return _one(folder / "shot.usda")


def build_other_rates(folder: Path) -> Situation:
    """The asset runs at 120 time codes a second, the shot at 48 with 24 frames a second."""
    asset = _new_stage(folder / "asset.usda", timeCodesPerSecond=120, endTimeCode=301)
    _add_model(asset, "/Char")
    UsdSkel.Root.Define(asset, "/Char/Rig")
    _add_skeleton(asset, "/Char/Rig/Skel")
    _add_takes(asset, "/Char/Takes", "/Char/Rig/Skel", rate=120.0)
    times = [float(t) for t in range(1, 302, 30)]
    _add_recipe(_add_animation(asset, "/Char/Anim", SKETCH_JOINTS, times, rate=120.0), "/Char/Takes")
    _bind(_binding_prim(asset, "/Char", "Skeleton"), "/Char/Anim")
    asset.SetDefaultPrim(asset.GetPrimAtPath("/Char"))
    asset.Save()
    stage = _new_stage(
        folder / "shot.usda", timeCodesPerSecond=48, framesPerSecond=24, startTimeCode=0, endTimeCode=121
    )
    _add_world(stage)
    stage.DefinePrim("/World/Char").GetReferences().AddReference("./asset.usda")
    stage.Save()
    return _one(folder / "shot.usda")


def _expect(model: str, animation: str, skeleton: str, variant_set: str = "mtex") -> Expected:
    output = f"{model}/{Sdf.Path(animation).name}_mtex"
    return Expected(animation=animation, skeletons=(skeleton,), model=model, variant_set=variant_set, output=output)


def build_two_characters(folder: Path) -> Situation:
    """Two characters share one model, so each keeps its set on its own SkelRoot; both play one animation."""
    stage = _new_stage(folder / "shot.usda")
    _add_world(stage)
    _add_model(stage, "/World/Pair")
    for name in ("A", "B"):
        UsdSkel.Root.Define(stage, f"/World/Pair/{name}")
        _bind(_add_skeleton(stage, f"/World/Pair/{name}/Skel"), "/World/Pair/Anim")
    _add_takes(stage, "/World/Pair/Takes", "/World/Pair/A/Skel")
    _add_sketch(stage, "/World/Pair/Anim", "/World/Pair/Takes")
    stage.Save()
    expected = tuple(_expect(f"/World/Pair/{n}", "/World/Pair/Anim", f"/World/Pair/{n}/Skel") for n in ("A", "B"))
    return Situation(shot=folder / "shot.usda", animations=("/World/Pair/Anim",), expected=expected)


def build_two_instances(folder: Path) -> Situation:
    """Two instances of one asset, each playing the asset's own animation."""
    _write_asset(folder, "Skeleton")
    stage = _new_stage(folder / "shot.usda")
    _add_world(stage)
    for name in ("One", "Two"):
        prim = stage.DefinePrim(f"/World/{name}")
        prim.GetReferences().AddReference("./asset.usda")
        prim.SetInstanceable(True)
    stage.Save()
    models = ("/World/One", "/World/Two")
    expected = tuple(_expect(model, f"{model}/Anim", f"{model}/Rig/Skel") for model in models)
    return Situation(shot=folder / "shot.usda", animations=tuple(f"{m}/Anim" for m in models), expected=expected)


def build_two_sketches(folder: Path) -> Situation:
    """One character with two Skeletons, each with its own sketch."""
    stage = _new_stage(folder / "shot.usda")
    _add_world(stage)
    _add_character(stage, "/World/Char", "Skeleton")
    _add_sketch(stage, "/World/Char/Face", "/World/Char/Takes", [1.0, 21.0, 41.0, 61.0])
    _bind(_add_skeleton(stage, "/World/Char/Rig/FaceSkel"), "/World/Char/Face")
    stage.Save()
    model = "/World/Char"
    expected = (
        _expect(model, f"{model}/Anim", f"{model}/Rig/Skel"),
        _expect(model, f"{model}/Face", f"{model}/Rig/FaceSkel", "mtex_Face"),
    )
    return Situation(shot=folder / "shot.usda", animations=(f"{model}/Anim", f"{model}/Face"), expected=expected)


def build_nested_models(folder: Path) -> Situation:
    """A group of a character and a prop rig: the component that holds the character alone gets the set."""
    stage = _new_stage(folder / "shot.usda")
    _add_world(stage)
    _add_model(stage, "/World/Crew", "group")
    _add_character(stage, "/World/Crew/Char", "Skeleton")
    _add_model(stage, "/World/Crew/Prop")
    UsdSkel.Root.Define(stage, "/World/Crew/Prop/Rig")
    _add_skeleton(stage, "/World/Crew/Prop/Rig/Skel")
    stage.Save()
    return _one(folder / "shot.usda", model="/World/Crew/Char")


def _build_nested_instances(folder: Path, inner_names: Sequence[str]) -> tuple[str, ...]:
    _write_asset(folder, "Skeleton")
    outer = _new_stage(folder / "outer.usda")
    _add_model(outer, "/Outer", "group")
    for name in inner_names:
        inner = outer.DefinePrim(f"/Outer/{name}")
        inner.GetReferences().AddReference("./asset.usda")
        inner.SetInstanceable(True)
    outer.SetDefaultPrim(outer.GetPrimAtPath("/Outer"))
    outer.Save()
    stage = _new_stage(folder / "shot.usda")
    _add_world(stage)
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
    expected = tuple(_expect(model, f"{model}/Char/Anim", f"{model}/Char/Rig/Skel") for model in models)
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
    stage = _new_stage(parts / "inside.usda")
    _add_world(stage)
    _add_character(stage, "/World/Char", "Skeleton")
    stage.Save()
    UsdUtils.CreateNewUsdzPackage(str(parts / "inside.usda"), str(folder / "shot.usdz"))
    (parts / "inside.usda").unlink()
    parts.rmdir()
    return _one(folder / "shot.usdz")


def build_no_model(folder: Path) -> Situation:
    """No prim has a model kind, so the SkelRoot gets the set."""
    stage = _new_stage(folder / "shot.usda")
    UsdSkel.Root.Define(stage, "/Rig")
    _bind(_add_skeleton(stage, "/Rig/Skel"), "/Rig/Anim")
    _add_takes(stage, "/Takes", "/Rig/Skel")
    _add_sketch(stage, "/Rig/Anim", "/Takes")
    stage.Save()
    return _one(folder / "shot.usda", model="/Rig", skeletons=("/Rig/Skel",))


Builder = Callable[[Path], Situation]

_TWICE: dict[str, Callable[[Path, str], Situation]] = {
    "local": build_local,
    "referenced": build_referenced,
    "payloaded": build_payloaded,
    "instanceable": build_instanceable,
    "asset_variants": build_asset_variants,
    "local_variants": build_local_variants,
    "two_skeletons": build_two_skeletons,
    "default_only": build_default_only,
}


def _on(builder: Callable[[Path, str], Situation], on: str) -> Builder:
    return lambda folder: builder(folder, on)


BASE_SITUATIONS: dict[str, Builder] = {
    **{f"{name}-{on}": _on(builder, on) for name, builder in _TWICE.items() for on in ("Skeleton", "SkelRoot")},
    "inherited_binding": build_inherited_binding,
    "inherited_binding_instanceable": build_inherited_binding_instanceable,
    "unbound": build_unbound,
    "animation_layer": build_animation_layer,
    "value_clips": build_value_clips,
}
MORE_SITUATIONS: dict[str, Builder] = {
    "offset_sublayer": build_offset_sublayer,
    "scaled_reference": build_scaled_reference,
    "other_rates": build_other_rates,
    "two_characters": build_two_characters,
    "two_instances": build_two_instances,
    "two_sketches": build_two_sketches,
    "nested_models": build_nested_models,
    "nested_instances": build_nested_instances,
    "nested_instance_pair": build_nested_instance_pair,
    "value_clips_on_model": build_value_clips_on_model,
    "value_clips_elsewhere": build_value_clips_elsewhere,
    "package": build_package,
    "no_model": build_no_model,
}
SITUATIONS: dict[str, Builder] = BASE_SITUATIONS | MORE_SITUATIONS
