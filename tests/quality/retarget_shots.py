"""Shots of real characters with leg sketches, and takes of another skeleton for them."""

from pathlib import Path

import numpy as np
from pxr import Sdf, Usd, UsdSkel, Vt
from scipy.interpolate import CubicSpline

from mtex_usd.constraints.retargeting import retarget
from mtex_usd.motion import quaternion
from mtex_usd.usd.clip_io import ClipReader

SKETCH = "/Char/Sketch"
KEY_EVERY = 6  # frames


def read_character(asset: Path):
    """The first Skeleton of an asset: its prim path, the skeleton, and the stage."""
    stage = Usd.Stage.Open(str(asset))
    prim = next(prim for prim in stage.Traverse() if prim.GetTypeName() == "Skeleton")
    return stage, prim.GetPath(), ClipReader(stage).read_skeleton(prim)


def block_keys(clip, *, every=KEY_EVERY):
    """Keep a key every so many frames and go smoothly from one to the next, as an animator's splines do."""
    frames = np.arange(clip.frame_count)
    keys = np.unique([*frames[::every], frames[-1]])
    rotations = quaternion.normalize(CubicSpline(keys, clip.rotations[keys])(frames))
    return rotations, CubicSpline(keys, clip.translations[keys])(frames)


def write_leg_sketch(shot: Path, asset: Path, walk, takes: Path, joints, recipe):
    """Write a shot that references a character and takes, with a sketch on some of the character's joints.

    `walk` is a motion of any humanoid, of which the sketch has a key now and then; `recipe` gives channels by property.
    """
    source, skeleton_path, skeleton = read_character(asset)
    moved = retarget(walk, skeleton)
    top = skeleton_path.GetPrefixes()[0]
    stage = _new_shot(shot, source, moved.frame_count, moved.rate)
    model = stage.DefinePrim("/Char")
    model.GetReferences().AddReference(str(asset), top)
    Usd.ModelAPI(model).SetKind("component")
    stage.SetDefaultPrim(model)
    index = [j for j, joint in enumerate(skeleton.joints) if joint.rpartition("/")[2] in joints]
    author_animation(stage, SKETCH, [skeleton.joints[j] for j in index], *(a[:, index] for a in block_keys(moved)))
    player = stage.GetPrimAtPath(skeleton_path.ReplacePrefix(top, "/Char"))
    UsdSkel.BindingAPI.Apply(player).CreateAnimationSourceRel().SetTargets([SKETCH])
    author_recipe(stage, SKETCH, takes, recipe)
    stage.Save()


def _new_shot(shot, source, frames, rate):
    stage = Usd.Stage.CreateNew(str(shot))
    for key in ("upAxis", "metersPerUnit"):
        stage.SetMetadata(key, source.GetMetadata(key))
    stage.SetTimeCodesPerSecond(rate)
    stage.SetFramesPerSecond(rate)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(frames - 1)
    return stage


def author_animation(stage, prim_path, joints, rotations, translations):
    """Author a SkelAnimation with a sample at every frame; real part first."""
    animation = UsdSkel.Animation.Define(stage, prim_path)
    animation.CreateJointsAttr(Vt.TokenArray(list(joints)))
    animation.CreateScalesAttr(Vt.Vec3hArray.FromNumpy(np.ones((len(joints), 3), dtype=np.float16)))
    turns, places = animation.CreateRotationsAttr(), animation.CreateTranslationsAttr()
    for frame, (turn, place) in enumerate(zip(rotations, translations, strict=True)):
        turns.Set(Vt.QuatfArray.FromNumpy(np.ascontiguousarray(turn[:, [1, 2, 3, 0]], dtype=np.float32)), frame)
        places.Set(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(place, dtype=np.float32)), frame)


def author_recipe(stage, prim_path, takes, recipe):
    """Make an animation a sketch whose takes are those of a library."""
    stage.DefinePrim("/Takes").GetReferences().AddReference(str(takes), "/Takes")
    prim = stage.GetPrimAtPath(prim_path)
    prim.AddAppliedSchema("MtexSketchAPI")
    prim.CreateRelationship("mtex:takes").SetTargets(["/Takes"])
    for name, tokens in recipe.items():
        attribute = prim.CreateAttribute(f"mtex:{name}", Sdf.ValueTypeNames.TokenArray, False, Sdf.VariabilityUniform)
        attribute.Set(Vt.TokenArray(tokens))
