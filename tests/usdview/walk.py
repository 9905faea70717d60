"""The sample walk as it is edited: where its parts are, and what is read off it."""

import shutil
from pathlib import Path

import numpy as np
from pxr import UsdSkel

import mtex_usd
from mtex_usd.usd.contact_edits import read_motions

SAMPLES = Path(__file__).resolve().parents[2] / "sample_stages"
SKELETON, MESH, OUTPUT = "/Humanoid/Skeleton", "/Humanoid/Body", "/Humanoid/Sketch_mtex"
STEP = 3  # of path_01: the right foot's second


def copy_walk(folder):
    """Copy the shot with what it refers to, and give it."""
    for name in ("walk.usda", "humanoid.usda", "takes.usda"):
        shutil.copy(SAMPLES / name, folder / name)
    return folder / "walk.usda"


def process_walk(folder):
    """Make two paths of it, and give the thin root."""
    return mtex_usd.process(copy_walk(folder), paths=2)[0].stage


def read_one(stage, *paths):
    (motion,) = read_motions(stage, [stage.GetPrimAtPath(path) for path in paths])
    return motion


def joint_places(stage, joint, times):
    """Where UsdSkel has a joint, in the world."""
    query = UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath(SKELETON)))
    number = [name.rpartition("/")[2] for name in query.GetJointOrder()].index(joint)
    return np.array([np.array(query.ComputeJointSkelTransforms(time)[number])[3, :3] for time in times])


def rotations(stage):
    attribute = stage.GetPrimAtPath(OUTPUT).GetAttribute("rotations")
    return np.array([np.asarray(attribute.Get(time)) for time in attribute.GetTimeSamples()])
