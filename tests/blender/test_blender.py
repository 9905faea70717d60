"""Blender plays the written stages as UsdSkel does."""

import json
import os
import subprocess
from collections.abc import Sequence
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
        for variant, shown in play_variants(blender, result.stage, VARIANTS).items():
            found[shot, variant] = shown
    return found


@pytest.fixture(scope="module")
def edited(blender: str, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Played]:
    """Run the stacks of edits of a shot, one of them five edits long, and play what they make."""
    out = tmp_path_factory.mktemp("edits") / "edits.edit.usd"
    results = mtex_usd.apply_edits(PROJECT / "sample_stages" / "edits.usda", out=out)
    lengths = {result.variant: len(result.custom_data["edits"]) for result in results}
    assert lengths == {"edited": 5, "endless": 2, "keyed": 1, "livelier": 1}
    return play_variants(blender, results[0].stage, ("original", *lengths))


def play_variants(interpreter: str, thin_root: Path, variants: Sequence[str]) -> dict[str, Played]:
    """Play variants in one Blender process and through UsdSkel."""
    stages = {variant: write_selection(thin_root, variant) for variant in variants}
    frames = choose_frames(thin_root)
    bones = run_blender(interpreter, frames, list(stages.values()))
    found = {}
    for variant, stage_path in stages.items():
        expected, names, height = play_usd(stage_path, frames)
        poses = bones[str(stage_path)]["Humanoid"]
        shown = np.array([[poses[str(frame)][name] for name in names] for frame in frames])
        found[variant] = Played(expected, shown, height)
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


@pytest.mark.parametrize("variant", ["original", "edited", "endless", "keyed", "livelier"])
def test_edited_bones_are_where_usdskel_puts_them(edited: dict[str, Played], variant: str) -> None:
    found = edited[variant]
    assert found.expected.shape == found.shown.shape
    assert len(found.expected) == FRAMES
    distance = np.linalg.norm(found.shown - found.expected, axis=-1)
    assert distance.max() < TOLERANCE * found.height


def test_blender_shows_the_edits(edited: dict[str, Played]) -> None:
    """Every version is another motion than the one that was edited; the one of few keys is within 5 mm of it."""
    original = edited["original"]
    for variant in ("edited", "endless", "livelier"):
        assert np.abs(edited[variant].shown - original.shown).max() > 0.05
    reduced = np.linalg.norm(edited["keyed"].shown - original.shown, axis=-1)
    assert 1e-4 < reduced[:8].max() < 0.005
