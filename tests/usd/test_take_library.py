"""Take libraries as other USD tools see them, and against the slow BVH reader."""

import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, UsdValidation

from mtex_usd.api import import_takes
from mtex_usd.errors import InputError
from mtex_usd.formats.recording import FormatError, Recording
from mtex_usd.usd.take_library import TakeLibrary, WrittenTake
from tests.oracle import bvh as oracle

CMU_SUBSET = ("01/01_01", "05/05_05", "07/07_01", "09/09_01", "91_from_amc/91_13")


def make_recording(
    name: str = "walk",
    *,
    names: Sequence[str] = ("Hips", "Spine"),
    rate: float = 30.0,
    frames: int = 3,
    length: float = 2.0,
) -> Recording:
    """A chain of joints that sways as a whole."""
    count = len(names)
    angles = np.linspace(0.0, 1.0, frames)[:, None] * np.ones(count) / 2.0
    rotations = np.zeros((frames, count, 4))
    rotations[..., 0], rotations[..., 2] = np.cos(angles), np.sin(angles)
    offsets = np.zeros((count, 3))
    offsets[1:, 1] = length
    return Recording(
        source=Path(f"{name}.bvh"),
        names=tuple(names),
        parents=tuple(range(-1, count - 1)),
        offsets=offsets,
        rate=rate,
        rotations=rotations,
        translations=np.broadcast_to(offsets, (frames, count, 3)).copy(),
    )


def write_library(folder: Path, *recordings: Recording, style: str = "") -> Usd.Stage:
    library = TakeLibrary(meters_per_unit=0.01)
    for recording in recordings:
        library.add(recording, style=style)
    library.write(folder / "takes.usda")
    return Usd.Stage.Open(str(folder / "takes.usda"))


def bind(stage: Usd.Stage, take: WrittenTake) -> UsdSkel.SkeletonQuery:
    """Play a take on its skeleton, in the session layer only."""
    stage.SetEditTarget(stage.GetSessionLayer())
    skeleton = stage.GetPrimAtPath(take.skeleton_path)
    UsdSkel.BindingAPI.Apply(skeleton).CreateAnimationSourceRel().SetTargets([Sdf.Path(take.prim_path)])
    cache = UsdSkel.Cache()
    assert cache.Populate(UsdSkel.Root(stage.GetDefaultPrim()), Usd.PrimDefaultPredicate)
    return cache.GetSkelQuery(UsdSkel.Skeleton(skeleton))


def check_kinematics(stage: Usd.Stage, take: WrittenTake, *, frame_step: int) -> None:
    motion = oracle.read(take.source)
    tolerance = 1e-4 * oracle.rest_size(motion)
    query = bind(stage, take)
    assert take.frame_count == len(motion.frames)
    assert take.rate == pytest.approx(1.0 / motion.frame_time, rel=2e-4)
    time_codes = np.linspace(take.start, take.end, take.frame_count)
    for frame in sorted({*range(0, take.frame_count, frame_step), take.frame_count - 1}):
        found = np.array(query.ComputeJointSkelTransforms(time_codes[frame]))
        expected = oracle.world_transforms(motion, frame)
        np.testing.assert_allclose(found[:, 3, :3], expected[:, :3, 3], atol=tolerance, rtol=0)
        np.testing.assert_allclose(found[:, :3, :3], np.swapaxes(expected[:, :3, :3], 1, 2), atol=1e-4)
    rest = np.array(query.ComputeJointSkelTransforms(0.0, atRest=True))[:, 3, :3]
    np.testing.assert_allclose(rest, oracle.rest_positions(motion.root), atol=tolerance)


def check_files(files: list[Path], out: Path, *, frame_step: int) -> None:
    result = import_takes(files, out=out)
    assert (len(result.takes), result.failures) == (len(files), ())
    stage = Usd.Stage.Open(str(out))
    for take in result.takes:
        check_kinematics(stage, take, frame_step=frame_step)


def test_all_dialects_move_as_the_slow_reader_says(data_dir: Path, tmp_path: Path) -> None:
    files = sorted((data_dir / "bvh_dialects").glob("*.bvh"))
    assert len(files) == 12
    check_files(files, tmp_path / "takes.usd", frame_step=7)


def test_mocap_moves_as_the_slow_reader_says(data_dir: Path, tmp_path: Path) -> None:
    files = [data_dir / "cmu_bvh" / f"{name}.bvh" for name in CMU_SUBSET]
    check_files(files, tmp_path / "takes.usd", frame_step=101)


def test_all_mocap_imports_with_one_skeleton_for_each_performer(data_dir: Path, tmp_path: Path) -> None:
    files = sorted((data_dir / "cmu_bvh").glob("*/*.bvh"))
    result = import_takes(files, out=tmp_path / "takes.usd", meters_per_unit=0.05644)
    assert (len(result.takes), result.failures) == (37, ())
    skeletons: dict[str, set[str]] = {}
    for take in result.takes:
        skeletons.setdefault(take.source.parent.name, set()).add(take.skeleton_path)
    assert all(len(paths) == 1 for paths in skeletons.values())
    assert len(set.union(*skeletons.values())) == 5


def test_the_stage_says_all_that_readers_need(tmp_path: Path) -> None:
    stage = write_library(tmp_path, make_recording(rate=24000.0 / 1001.0, frames=5))
    layer = stage.GetRootLayer()
    assert layer.HasTimeCodesPerSecond()
    assert layer.HasFramesPerSecond()
    assert (layer.timeCodesPerSecond, layer.framesPerSecond) == (24000.0 / 1001.0, 24000.0 / 1001.0)
    assert (layer.startTimeCode, layer.endTimeCode) == (0.0, 4.0)
    assert stage.GetDefaultPrim().GetPath() == "/Takes"
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.01


def test_the_stage_validates(tmp_path: Path) -> None:
    stage = write_library(tmp_path, make_recording(), make_recording("run", names=("Pelvis", "Chest"), rate=60.0))
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert [error.GetMessage() for error in errors] == []


def test_the_skeleton_has_rest_and_bind_pose(tmp_path: Path) -> None:
    stage = write_library(tmp_path, make_recording(names=("Hips", "Spine", "Head")))
    skeleton = UsdSkel.Skeleton(stage.GetPrimAtPath("/Takes/Skeleton"))
    assert list(skeleton.GetJointsAttr().Get()) == ["Hips", "Hips/Spine", "Hips/Spine/Head"]
    rest = [matrix.ExtractTranslation() for matrix in skeleton.GetRestTransformsAttr().Get()]
    bind_pose = [matrix.ExtractTranslation() for matrix in skeleton.GetBindTransformsAttr().Get()]
    assert rest == [Gf.Vec3d(0), Gf.Vec3d(0, 2, 0), Gf.Vec3d(0, 2, 0)]
    assert bind_pose == [Gf.Vec3d(0), Gf.Vec3d(0, 2, 0), Gf.Vec3d(0, 4, 0)]


def test_every_take_names_its_range_style_skeleton_and_source(tmp_path: Path) -> None:
    stage = write_library(tmp_path, make_recording(frames=8).without_first(2), style="sad")
    prim = stage.GetPrimAtPath("/Takes/walk")
    assert prim.GetMetadata("apiSchemas").GetAppliedItems() == ["MtexTakeAPI"]
    values = {name: prim.GetAttribute(f"mtex:take:{name}").Get() for name in ("start", "end", "style")}
    assert values == {"start": Sdf.TimeCode(0), "end": Sdf.TimeCode(5), "style": "sad"}
    for name in values:
        attribute = prim.GetAttribute(f"mtex:take:{name}")
        assert (attribute.GetVariability(), attribute.IsCustom()) == (Sdf.VariabilityUniform, False)
    assert prim.GetRelationship("mtex:take:skeleton").GetTargets() == [Sdf.Path("/Takes/Skeleton")]
    assert prim.GetCustomDataByKey("mtex") == {"source": "walk.bvh", "rate": 30.0, "frames": 6, "skippedFrames": 2}
    times = UsdSkel.Animation(prim).GetRotationsAttr().GetTimeSamples()
    assert times == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]


def test_no_style_is_authored_unless_asked_for(tmp_path: Path) -> None:
    stage = write_library(tmp_path, make_recording())
    assert not stage.GetPrimAtPath("/Takes/walk").GetAttribute("mtex:take:style").IsAuthored()


def test_takes_share_one_scale_and_keep_real_time(tmp_path: Path) -> None:
    stage = write_library(tmp_path, make_recording("slow", rate=30.0), make_recording("fast", rate=120.0, frames=9))
    fast = UsdSkel.Animation(stage.GetPrimAtPath("/Takes/fast"))
    seconds = np.array(fast.GetTranslationsAttr().GetTimeSamples()) / stage.GetTimeCodesPerSecond()
    np.testing.assert_allclose(seconds, np.arange(9) / 120.0, atol=1e-12)
    assert fast.GetPrim().GetAttribute("mtex:take:end").Get() == Sdf.TimeCode(2.0)
    assert fast.GetPrim().GetCustomDataByKey("mtex:rate") == 120.0
    assert stage.GetEndTimeCode() == 2.0


def test_equal_skeletons_are_one_and_others_are_not(tmp_path: Path) -> None:
    library = TakeLibrary(meters_per_unit=0.01)
    recordings = [
        make_recording("a"),
        make_recording("b", length=2.0 * (1.0 + 1e-6)),
        make_recording("c", length=2.1),
        make_recording("d", names=("Hips", "Chest")),
        make_recording("e", length=2.1),
    ]
    found = [library.add(recording).skeleton_path for recording in recordings]
    assert found == [f"/Takes/Skeleton{suffix}" for suffix in ("", "", "_2", "_3", "_2")]


def test_the_original_joint_names_are_kept(tmp_path: Path) -> None:
    names = ["mixamorig:Hips", "Bone.002", "Bone_002", "Left Arm", "3", "3", "Hüfte", "😀"]
    stage = write_library(tmp_path, make_recording(names=names))
    skeleton = stage.GetPrimAtPath("/Takes/Skeleton")
    joints = list(skeleton.GetAttribute("joints").Get())
    assert joints[-1] == "mixamorig_Hips/Bone_002_2/Bone_002/Left_Arm/_3/_3_2/Hüfte/__"
    assert list(skeleton.GetCustomDataByKey("mtex:jointNames")) == names
    assert list(stage.GetPrimAtPath("/Takes/walk").GetAttribute("joints").Get()) == joints
    assert UsdSkel.Topology(joints).Validate()[0]


def test_files_of_one_name_become_takes_of_their_own(tmp_path: Path) -> None:
    library = TakeLibrary(meters_per_unit=0.01)
    found = [library.add(make_recording(name)).prim_path for name in ("07_01", "x/07_01", "Skeleton", "walk")]
    assert found == ["/Takes/take_07_01", "/Takes/take_07_01_2", "/Takes/Skeleton_2", "/Takes/walk"]


def test_the_same_files_give_the_same_bytes_wherever_they_are(data_dir: Path, tmp_path: Path) -> None:
    source = data_dir / "bvh_dialects" / "rotation_first_root.bvh"
    copy = tmp_path / "elsewhere" / source.name
    copy.parent.mkdir()
    shutil.copyfile(source, copy)
    for suffix in (".usd", ".usda"):
        outs = [tmp_path / f"{name}{suffix}" for name in ("first", "second")]
        for file_path, out in zip((source, copy), outs, strict=True):
            import_takes([file_path], out=out)
        assert outs[0].read_bytes() == outs[1].read_bytes()


def test_a_process_without_the_schema_reads_the_takes(tmp_path: Path) -> None:
    write_library(tmp_path, make_recording())
    script = (
        "import sys; from pxr import Usd\n"
        "stage = Usd.Stage.Open(sys.argv[1]); prim = stage.GetPrimAtPath('/Takes/walk')\n"
        "print(prim.GetMetadata('apiSchemas').GetAppliedItems(), prim.GetAttribute('mtex:take:end').Get())\n"
        "print(prim.GetRelationship('mtex:take:skeleton').GetTargets()[0], 'mtex_usd' in sys.modules)\n"
    )
    command = [sys.executable, "-c", script, str(tmp_path / "takes.usda")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout == "['MtexTakeAPI'] 2\n/Takes/Skeleton False\n"


def test_skipping_every_frame_is_an_error() -> None:
    with pytest.raises(FormatError, match=r"walk\.bvh: nothing is left of its 3 frames after skipping 3"):
        make_recording().without_first(3)


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"meters_per_unit": 0.0}, "bad metres per unit; expected a number above 0; found 0.0"),
        ({"meters_per_unit": float("nan")}, "bad metres per unit"),
        ({"up_axis": "X"}, "bad up axis; expected Y or Z; found 'X'"),
        ({"skip_frames": -1}, "bad number of frames to skip; expected 0 or more; found -1"),
    ],
)
def test_options_out_of_range_are_errors(tmp_path: Path, options: dict[str, object], reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        import_takes(["walk.bvh"], out=tmp_path / "takes.usd", **options)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="no files to import"):
        import_takes([], out=tmp_path / "takes.usd")
