"""Real captures in two formats each, compared as the library gives them to other USD tools."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdSkel

from mtex_usd.api import import_takes, read_clip
from mtex_usd.motion.clip import Clip
from tests.oracle import asf_amc
from tests.oracle import gltf as gltf_oracle

LEGS = {
    "Hips": "root",
    "LHipJoint": "lhipjoint",
    "LeftUpLeg": "lfemur",
    "LeftLeg": "ltibia",
    "LeftFoot": "lfoot",
    "LeftToeBase": "ltoes",
    "RHipJoint": "rhipjoint",
    "RightUpLeg": "rfemur",
    "RightLeg": "rtibia",
    "RightFoot": "rfoot",
    "RightToeBase": "rtoes",
}


def place_joints(clip: Clip) -> dict[str, np.ndarray]:
    """Joint positions over time by last name, shape [F, 3] each."""
    positions, _ = clip.skeleton.world_pose(clip.rotations, clip.translations)
    return {joint.rpartition("/")[2]: positions[:, i] for i, joint in enumerate(clip.joints)}


def import_clips(out: Path, *file_paths: Path) -> list[Clip]:
    result = import_takes(file_paths, out=out)
    assert result.failures == ()
    stage = Usd.Stage.Open(str(out))
    return [read_clip(stage, take.prim_path) for take in result.takes]


def test_01_01_is_the_same_on_hips_and_legs(data_dir: Path, tmp_path: Path) -> None:
    """The release of the BVH added a T-pose in front and dropped the thorax: its arms sit 11.6 cm low."""
    files = (data_dir / "cmu_asfamc" / "01" / "01_01.amc", data_dir / "cmu_bvh" / "01" / "01_01.bvh")
    amc, bvh = import_clips(tmp_path / "takes.usd", *files)
    assert bvh.frame_count == amc.frame_count + 1
    found, expected = place_joints(bvh), place_joints(amc)
    for ours, theirs in LEGS.items():
        np.testing.assert_allclose(found[ours][1:], expected[theirs], atol=1e-4 * amc.skeleton.height, err_msg=ours)
    gap = np.linalg.norm(found["LeftArm"][1:] - expected["lhumerus"], axis=-1) * amc.skeleton.meters_per_unit
    np.testing.assert_allclose(gap, 0.1165, atol=0.001)


@pytest.mark.parametrize("name", ["91_01", "91_02", "91_13"])
def test_91_is_the_same_from_amc_and_from_bvh(data_dir: Path, tmp_path: Path, name: str) -> None:
    files = (data_dir / "cmu_asfamc" / "91" / f"{name}.amc", data_dir / "cmu_bvh" / "91_from_amc" / f"{name}.bvh")
    amc, bvh = import_clips(tmp_path / "takes.usd", *files)
    assert (amc.rate, bvh.rate) == (120.0, 120.0)
    found, expected = place_joints(amc), place_joints(bvh)
    assert found.keys() == expected.keys()
    for joint, positions in expected.items():
        np.testing.assert_allclose(found[joint], positions, atol=1e-4 * amc.skeleton.height, err_msg=joint)


def test_amc_moves_as_the_slow_reader_says(data_dir: Path, tmp_path: Path) -> None:
    folder = data_dir / "cmu_asfamc" / "01"
    (clip,) = import_clips(tmp_path / "takes.usd", folder / "01_01.amc")
    bones, frames = asf_amc.read_skeleton(folder / "01.asf"), asf_amc.read_frames(folder / "01_01.amc")
    found = place_joints(clip)
    assert clip.frame_count == len(frames)
    for frame in range(0, len(frames), 307):
        for joint, expected in asf_amc.world_positions(bones, frames[frame]).items():
            np.testing.assert_allclose(found[joint][frame], expected, atol=1e-4)


def test_limits_are_on_the_skeleton(data_dir: Path, tmp_path: Path) -> None:
    import_takes([data_dir / "cmu_asfamc" / "91" / "91_02.amc"], out=tmp_path / "takes.usd")
    stage = Usd.Stage.Open(str(tmp_path / "takes.usd"))
    skeleton = stage.GetPrimAtPath("/Takes/Skeleton")
    attribute = skeleton.GetAttribute("mtex:limits:lfemur:rx")
    assert (attribute.GetTypeName(), tuple(attribute.Get())) == (Sdf.ValueTypeNames.Double2, (-160.0, 20.0))
    assert attribute.GetVariability() == Sdf.VariabilityUniform
    assert not skeleton.GetAttribute("mtex:limits:ltibia:ry")
    axes = skeleton.GetCustomDataByKey("mtex:limitAxes")
    assert len(axes) == len(skeleton.GetAttribute("joints").Get())
    assert axes[2].GetReal() == pytest.approx(np.cos(np.radians(10.0)))


def test_cesium_man_is_the_same_from_gltf_and_from_usd(data_dir: Path, tmp_path: Path) -> None:
    files = (data_dir / "gltf" / "CesiumMan.glb", data_dir / "usd" / "CesiumMan.usdz")
    result = import_takes(files, out=tmp_path / "takes.usd")
    stage = Usd.Stage.Open(str(tmp_path / "takes.usd"))
    played = [play_in_world(stage, take.prim_path, take.skeleton_path, 48) for take in result.takes]
    assert played[0].keys() == played[1].keys()
    assert len(played[0]) == 19
    for joint, positions in played[0].items():
        np.testing.assert_allclose(positions, played[1][joint], atol=1e-5, err_msg=joint)


def play_in_world(stage: Usd.Stage, take: str, skeleton_path: str, frames: int) -> dict[str, np.ndarray]:
    """World positions over time by last name, as UsdSkel computes them."""
    stage.SetEditTarget(stage.GetSessionLayer())
    skeleton = stage.GetPrimAtPath(skeleton_path)
    UsdSkel.BindingAPI.Apply(skeleton).CreateAnimationSourceRel().SetTargets([take])
    cache = UsdSkel.Cache()
    assert cache.Populate(UsdSkel.Root(stage.GetDefaultPrim()), Usd.PrimDefaultPredicate)
    query = cache.GetSkelQuery(UsdSkel.Skeleton(skeleton))
    to_world = np.array(UsdGeom.Imageable(skeleton).ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
    worlds = np.array([np.array(query.ComputeJointSkelTransforms(float(frame))) @ to_world for frame in range(frames)])
    names = [joint.rpartition("/")[2] for joint in skeleton.GetAttribute("joints").Get()]
    return {name: worlds[:, i, 3, :3] for i, name in enumerate(names)}


@pytest.mark.parametrize("name", ["CesiumMan.glb", "simple_skin.gltf", "03_skinned_cylinder.gltf"])
def test_gltf_moves_as_the_slow_reader_says(data_dir: Path, tmp_path: Path, name: str) -> None:
    file_path = data_dir / "gltf" / name
    (take,) = import_takes([file_path], out=tmp_path / "takes.usd").takes
    stage = Usd.Stage.Open(str(tmp_path / "takes.usd"))
    found = play_in_world(stage, take.prim_path, take.skeleton_path, take.frame_count)
    document = gltf_oracle.Document(file_path)
    nodes = {described.get("name", f"node_{i}"): i for i, described in enumerate(document.json["nodes"])}
    sampler = document.json["animations"][0]["samplers"][0]
    start = document.elements(sampler["input"])[0][0]
    for frame in range(0, take.frame_count, 9):
        for joint, positions in found.items():
            expected = document.world_matrix(0, nodes[joint.replace("Joint.", "Joint_")], start + frame / take.rate)
            np.testing.assert_allclose(positions[frame], expected[:3, 3], atol=1e-5, err_msg=joint)
