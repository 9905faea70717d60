"""The shots that are opened in usdview: two characters, one of them with two Skeletons and two sketches."""

from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom, UsdSkel

import mtex_usd
from tests.usd.playback import local_transforms
from tests.usd.stage_parts import add_character, add_skeleton, add_sketch, add_world, bind, new_stage

CHAR, OTHER = "/World/Char", "/World/Other"
TIMES = (1.0, 17.0, 30.0, 49.0)


def write_shot(folder: Path, **metadata: float) -> Path:
    """Write the shot; ``/World/Char`` plays Anim and Face, ``/World/Other`` plays its own Anim."""
    stage = new_stage(folder / "shot.usda", **metadata)
    add_world(stage)
    for model in (CHAR, OTHER):
        add_character(stage, model, "Skeleton")
        _add_mesh(stage, f"{model}/Rig/Body", f"{model}/Rig/Skel")
    add_sketch(stage, f"{CHAR}/Face", f"{CHAR}/Takes", [1.0, 21.0, 41.0, 61.0])
    bind(add_skeleton(stage, f"{CHAR}/Rig/FaceSkel"), f"{CHAR}/Face")
    _add_mesh(stage, f"{CHAR}/Rig/FaceMesh", f"{CHAR}/Rig/FaceSkel")
    UsdGeom.Cube.Define(stage, "/World/Box")
    stage.Save()
    return folder / "shot.usda"


def _add_mesh(stage: Usd.Stage, prim_path: str, skeleton: str) -> None:
    mesh = UsdGeom.Mesh.Define(stage, prim_path)
    UsdSkel.BindingAPI.Apply(mesh.GetPrim()).CreateSkeletonRel().SetTargets([skeleton])


def write_processed(folder: Path, **metadata: float) -> Path:
    """Process the shot, and give its thin root."""
    return mtex_usd.process(write_shot(folder, **metadata))[0].stage


def shown(stage: Usd.Stage, skeleton: str) -> np.ndarray:
    """Give what a Skeleton plays, as UsdSkel poses it, at a few times."""
    poses = [local_transforms(stage, skeleton, time) for time in TIMES]
    return np.array([[pose[joint] for joint in sorted(pose)] for pose in poses])
