"""The character that all situations use, in pieces: six joints walking, a sketch that lacks the arm, a recipe, takes.

Imports nothing from the package under test.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

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


def new_stage(file_path: Path, **metadata: float) -> Usd.Stage:
    """Make a stage file, Y up in centimetres, at 24 time codes a second unless told otherwise."""
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


def add_skeleton(stage: Usd.Stage, prim_path: str) -> Usd.Prim:
    """Author a Skeleton with all the joints."""
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


def add_animation(
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


def add_recipe(animation: Usd.Prim, takes: str) -> None:
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


def add_takes(stage: Usd.Stage, prim_path: str, skeleton: str, *, rate: float = 24.0) -> None:
    """Author two short walks at every time code, each pointing at the skeleton it moves."""
    UsdGeom.Scope.Define(stage, prim_path)
    for name, style in (("walk_1", 1.1), ("walk_2", 0.9)):
        times = [float(t) for t in range(START, START + 96)]
        take = add_animation(stage, f"{prim_path}/{name}", JOINTS, times, rate=rate, style=style)
        take.AddAppliedSchema("MtexTakeAPI")
        take.CreateRelationship("mtex:take:skeleton", custom=False).SetTargets([skeleton])


def bind(prim: Usd.Prim, animation: str) -> None:
    """Bind a prim, and what is below it, to an animation."""
    UsdSkel.BindingAPI.Apply(prim).CreateAnimationSourceRel().SetTargets([animation])


def key_times() -> list[float]:
    """Give the time codes of the sketch's keys."""
    return [float(t) for t in range(START, END + 1, STEP)]


def add_model(stage: Usd.Stage, prim_path: str, kind: str = "component") -> None:
    """Author a prim with a model kind."""
    model = UsdGeom.Xform.Define(stage, prim_path)
    Usd.ModelAPI(model).SetKind(kind)


def add_rig(stage: Usd.Stage, model: str) -> None:
    """Author the SkelRoot, the Skeleton and the takes of a character; no animation yet."""
    UsdSkel.Root.Define(stage, f"{model}/Rig")
    add_skeleton(stage, f"{model}/Rig/Skel")
    add_takes(stage, f"{model}/Takes", f"{model}/Rig/Skel")


def add_sketch(stage: Usd.Stage, prim_path: str, takes: str, times: Sequence[float] | None = None) -> None:
    """Author a sketch with its recipe, at the keys unless other time codes are given."""
    times = key_times() if times is None else times
    add_recipe(add_animation(stage, prim_path, SKETCH_JOINTS, times), takes)


def binding_prim(stage: Usd.Stage, model: str, on: str) -> Usd.Prim:
    """Give the prim that carries the binding: ``"Skeleton"`` or ``"SkelRoot"``."""
    return stage.GetPrimAtPath(f"{model}/Rig/Skel" if on == "Skeleton" else f"{model}/Rig")


def add_character(stage: Usd.Stage, model: str, on: str, times: Sequence[float] | None = None) -> None:
    """Author a whole character whose sketch is a child of the model, bound on its Skeleton or its SkelRoot."""
    add_model(stage, model)
    add_rig(stage, model)
    add_sketch(stage, f"{model}/Anim", f"{model}/Takes", times)
    bind(binding_prim(stage, model, on), f"{model}/Anim")


def add_world(stage: Usd.Stage) -> None:
    """Author the root prim and make it the default."""
    add_model(stage, "/World", "assembly")
    stage.SetDefaultPrim(stage.GetPrimAtPath("/World"))


def write_asset(folder: Path, on: str) -> None:
    """Write ``asset.usda`` with one character."""
    asset = new_stage(folder / "asset.usda")
    add_character(asset, "/Char", on)
    asset.SetDefaultPrim(asset.GetPrimAtPath("/Char"))
    asset.Save()


def expect_one(
    shot: Path, *, model: str = "/World/Char", animation: str | None = None, skeletons: Sequence[str] = ()
) -> Situation:
    """Tell of a stage with one sketch on one character."""
    animation = animation or f"{model}/Anim"
    expected = Expected(
        animation=animation,
        skeletons=tuple(skeletons) or (f"{model}/Rig/Skel",),
        model=model,
        output=f"{model}/{Sdf.Path(animation).name}_mtex",
    )
    return Situation(shot=shot, animations=(animation,), expected=(expected,))


def author_clips(stage: Usd.Stage, prim_path: str, clip_prim: str, animation: str, folder: Path) -> None:
    """Move an animation's samples into two clip files that a prim's clips bring back."""
    times = key_times()
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


def expect_character(model: str, animation: str, skeleton: str, variant_set: str = "mtex") -> Expected:
    """Tell of one character that is where it usually is."""
    output = f"{model}/{Sdf.Path(animation).name}_mtex"
    return Expected(animation=animation, skeletons=(skeleton,), model=model, variant_set=variant_set, output=output)
