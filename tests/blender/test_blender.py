"""Blender plays the written stages as UsdSkel does."""

import json
import os
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from pxr import Sdf, Usd, UsdGeom

import mtex_usd
from tests.usd.playback import skeleton_query

FloatArray = npt.NDArray[np.float64]

PROJECT = Path(__file__).resolve().parents[2]
READ_BONES = Path(__file__).with_name("read_bones.py")
SHOTS = ("walk", "phrase")
VARIANTS = ("path_01", "path_02", "path_03")
FRAMES = 10
SKELETON = "/Humanoid/Skeleton"
TOLERANCE = 1e-4  # of the height


@dataclass(frozen=True)
class Played:
    """Joint positions in Blender's world, [F, J, 3] in metres: as UsdSkel says, and as Blender shows."""

    expected: FloatArray
    shown: FloatArray
    height: float


def write_selection(thin_root: Path, variant: str) -> Path:
    """Stack a layer that selects a variant over a thin root: Blender's importer cannot choose."""
    below = Sdf.Layer.FindOrOpen(str(thin_root))
    layer = Sdf.Layer.CreateNew(str(thin_root.with_name(f"{thin_root.stem}.{variant}.usda")))
    for key in below.pseudoRoot.ListInfoKeys():
        if key not in ("subLayers", "subLayerOffsets", "customLayerData"):
            layer.pseudoRoot.SetInfo(key, below.pseudoRoot.GetInfo(key))
    layer.subLayerPaths.append(f"./{thin_root.name}")
    Sdf.CreatePrimInLayer(layer, "/Humanoid").variantSelections["mtex"] = variant
    layer.Save()
    return Path(layer.realPath)


def choose_frames(thin_root: Path) -> list[int]:
    stage = Usd.Stage.Open(str(thin_root))
    return np.linspace(stage.GetStartTimeCode(), stage.GetEndTimeCode(), FRAMES).round().astype(int).tolist()


def play_usd(stage_path: Path, frames: list[int]) -> tuple[FloatArray, list[str], float]:
    """Ask UsdSkel: positions in Blender's world [F, J, 3], the joints' last names, and the height in metres."""
    stage = Usd.Stage.Open(str(stage_path))
    query = skeleton_query(stage, SKELETON)
    unit = UsdGeom.GetStageMetersPerUnit(stage)
    assert UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.y
    prim = UsdGeom.Imageable(stage.GetPrimAtPath(SKELETON))
    poses = []
    for frame in frames:
        to_world = np.array(prim.ComputeLocalToWorldTransform(frame))
        poses.append([np.array(joint) @ to_world for joint in query.ComputeJointSkelTransforms(frame)])
    positions = unit * np.array(poses)[:, :, 3, :3]
    heights = np.array(query.GetJointWorldBindTransforms())[:, 3, 1] * unit
    names = [joint.rpartition("/")[2] for joint in query.GetJointOrder()]
    return to_blender(positions), names, float(np.ptp(heights))


def to_blender(positions: FloatArray) -> FloatArray:
    """Turn Y up into Z up."""
    x, y, z = np.moveaxis(positions, -1, 0)
    return np.stack([x, -z, y], axis=-1)


@pytest.fixture(scope="module")
def blender() -> str:
    interpreter = os.environ.get("MTEX_BLENDER_PYTHON", "")
    if not interpreter:
        pytest.skip("MTEX_BLENDER_PYTHON is not set; it names a Python that has bpy")
    return interpreter


@pytest.fixture(scope="module")
def played(blender: str, tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, str], Played]:
    """Process the shots and play every variant in one Blender process per shot."""
    found = {}
    for shot in SHOTS:
        folder = tmp_path_factory.mktemp(shot)
        (result,) = mtex_usd.process(PROJECT / "sample_stages" / f"{shot}.usda", out=folder / f"{shot}.mtex.usd")
        stages = {variant: write_selection(result.stage, variant) for variant in VARIANTS}
        frames = choose_frames(result.stage)
        bones = run_blender(blender, frames, list(stages.values()))
        for variant, stage_path in stages.items():
            expected, names, height = play_usd(stage_path, frames)
            poses = bones[str(stage_path)]["Humanoid"]
            shown = np.array([[poses[str(frame)][name] for name in names] for frame in frames])
            found[shot, variant] = Played(expected, shown, height)
    return found


def run_blender(
    interpreter: str, frames: list[int], stages: list[Path]
) -> dict[str, dict[str, dict[str, dict[str, list[float]]]]]:
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "PXR_"))}
    out = stages[0].with_name("bones.json")
    command = [interpreter, str(READ_BONES), str(out), ",".join(map(str, frames)), *map(str, stages)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment, timeout=300)
    assert done.returncode == 0, done.stderr
    return json.loads(out.read_text())


@pytest.mark.parametrize("shot", SHOTS)
@pytest.mark.parametrize("variant", VARIANTS)
def test_bones_are_where_usdskel_puts_them(played: dict[tuple[str, str], Played], shot: str, variant: str) -> None:
    found = played[shot, variant]
    assert found.expected.shape == found.shown.shape
    assert len(found.expected) == FRAMES
    distance = np.linalg.norm(found.shown - found.expected, axis=-1)
    assert distance.max() < TOLERANCE * found.height


@pytest.mark.parametrize("shot", SHOTS)
def test_blender_shows_the_selected_variant(played: dict[tuple[str, str], Played], shot: str) -> None:
    """Or three times the same would have passed above."""
    one, two, three = (played[shot, variant] for variant in VARIANTS)
    for other in (two, three):
        assert np.abs(one.shown - other.shown).max() > 100.0 * TOLERANCE * one.height


@pytest.mark.parametrize("shot", SHOTS)
def test_the_character_moves(played: dict[tuple[str, str], Played], shot: str) -> None:
    found = played[shot, "path_01"]
    assert np.ptp(found.shown - found.shown[:, :1], axis=0).max() > 0.1 * found.height
