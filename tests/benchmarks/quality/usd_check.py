"""The same cases through real stages: sketch and takes written to disk, the tool run, the result played by UsdSkel."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

import mtex_usd
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from tests.benchmarks.quality.cases import METERS_PER_UNIT, RATE, Fold

__all__ = ["play_first_variant", "process_fold", "write_fold"]


def write_fold(fold: Fold, folder: Path) -> Path:
    """Write a fold as a shot with its takes in a file of their own; give the shot.

    The sketch holds only the joints that were keyed.
    """
    takes = _new_stage(folder / "takes.usdc", max(take.frame_count for take in fold.takes))
    UsdGeom.Scope.Define(takes, "/Takes")
    takes.SetDefaultPrim(takes.GetPrimAtPath("/Takes"))
    for take in fold.takes:
        _add_character(takes, f"/Takes/take_{take.name}", take, take.joints)
    takes.Save()
    shot = _new_stage(folder / "shot.usda", fold.sketch.frame_count)
    shot.OverridePrim("/Takes").GetReferences().AddReference("./takes.usdc")
    joints = [joint for joint in fold.sketch.joints if joint.rpartition("/")[2] in fold.case.rig.sketched]
    animation = _add_character(shot, "/Dancer", fold.sketch, joints)
    shot.SetDefaultPrim(shot.GetPrimAtPath("/Dancer"))
    Usd.ModelAPI(shot.GetDefaultPrim()).SetKind("component")
    _add_recipe(animation, fold)
    shot.Save()
    return folder / "shot.usda"


def _new_stage(file_path: Path, frames: int) -> Usd.Stage:
    stage = Usd.Stage.CreateNew(str(file_path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, METERS_PER_UNIT)
    stage.SetTimeCodesPerSecond(RATE)
    stage.SetFramesPerSecond(RATE)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(frames - 1)
    return stage


def _add_character(stage: Usd.Stage, prim_path: str, clip: Clip, joints: list[str] | tuple[str, ...]) -> Usd.Prim:
    """A SkelRoot with a Skeleton of all joints and an animation of some, bound."""
    UsdSkel.Root.Define(stage, prim_path)
    skeleton = UsdSkel.Skeleton.Define(stage, f"{prim_path}/Skeleton")
    skeleton.CreateJointsAttr(Vt.TokenArray(clip.joints))
    rest = Vt.Matrix4dArray([Gf.Matrix4d(matrix) for matrix in clip.rest])
    skeleton.CreateRestTransformsAttr(rest)
    positions, _ = clip.skeleton.world_pose(clip.skeleton.rest_rotations, clip.skeleton.rest_translations)
    bind = [Gf.Matrix4d().SetTranslate(Gf.Vec3d(*position)) for position in positions]
    skeleton.CreateBindTransformsAttr(Vt.Matrix4dArray(bind))
    animation = UsdSkel.Animation.Define(stage, f"{prim_path}/Motion")
    animation.CreateJointsAttr(Vt.TokenArray(joints))
    index = [clip.joints.index(joint) for joint in joints]
    for frame in range(clip.frame_count):
        rotations = [Gf.Quatf(*q) for q in clip.rotations[frame, index].tolist()]
        translations = clip.translations[frame, index].astype(np.float32)
        animation.GetRotationsAttr().Set(Vt.QuatfArray(rotations), frame)
        animation.GetTranslationsAttr().Set(Vt.Vec3fArray.FromNumpy(translations), frame)
    animation.CreateScalesAttr(Vt.Vec3hArray(len(joints), Gf.Vec3h(1, 1, 1)))
    binding = UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
    binding.CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    return animation.GetPrim()


def _add_recipe(sketch: Usd.Prim, fold: Fold) -> None:
    """Only what the case says; all else is left to the fallbacks."""
    sketch.AddAppliedSchema("MtexSketchAPI")
    sketch.CreateRelationship("mtex:takes", custom=False).SetTargets([Sdf.Path("/Takes")])
    tokens, uniform = Sdf.ValueTypeNames.TokenArray, Sdf.VariabilityUniform
    sketch.CreateAttribute("mtex:match", tokens, False, uniform).Set(Vt.TokenArray(fold.case.match))
    sketch.CreateAttribute("mtex:synthesize", tokens, False, uniform).Set(Vt.TokenArray(fold.case.rig.synthesized))
    sketch.CreateAttribute("mtex:matchBand", Sdf.ValueTypeNames.Int, False, uniform).Set(fold.case.band)


def process_fold(fold: Fold, folder: Path) -> tuple[mtex_usd.Result, Clip]:
    """Write a fold, run the tool, and play the first variant back onto the truth's skeleton."""
    shot = write_fold(fold, folder)
    (result,) = mtex_usd.process(shot)
    return result, play_first_variant(fold, result.stage)


def play_first_variant(fold: Fold, stage_path: Path) -> Clip:
    """What UsdSkel plays on the character when the thin root is opened."""
    stage = Usd.Stage.Open(str(stage_path))
    query = UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath("/Dancer/Skeleton")))
    joints = [str(joint) for joint in query.GetJointOrder()]
    poses = [query.ComputeJointLocalTransforms(frame) for frame in range(fold.sketch.frame_count)]
    matrices = np.array([np.array(pose) for pose in poses])
    order = [joints.index(joint) for joint in fold.truth.joints]
    rotations = quaternion.from_usd_matrix(matrices[:, order])
    return replace(fold.sketch, rotations=quaternion.unroll(rotations), translations=matrices[:, order, 3, :3])
