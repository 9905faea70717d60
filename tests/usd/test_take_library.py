"""Take libraries as other USD tools see them, and against the slow BVH reader."""

import hashlib
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, UsdValidation

from mtex_usd.api import import_takes, list_takes, read_clip, write_clip
from mtex_usd.errors import InputError
from mtex_usd.formats.recording import ChannelLimit, FormatError, Recording
from mtex_usd.usd.take_entries import TakeEntry
from mtex_usd.usd.take_library import TakeLibrary, WrittenTake
from tests.acclaim import write_take
from tests.oracle import bvh as oracle

BVH = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 4 Yposition Zrotation Yrotation Xrotation
}
MOTION
Frames: 3
Frame Time: 0.0333333
0 0 0 0
1 1 1 1
2 2 2 2
"""
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


def describe_layer(file_path: Path) -> dict[str, object]:
    """Everything a take and its skeleton hold, bit for bit, by path."""
    layer = Sdf.Layer.OpenAsAnonymous(str(file_path))
    found: dict[str, object] = {}

    def visit(path: Sdf.Path) -> None:
        if path.IsPropertyPath() and layer.GetAttributeAtPath(path):
            times = layer.ListTimeSamplesForPath(path)
            values = [bytes(memoryview(layer.QueryTimeSample(path, time))) for time in times]
            found[str(path)] = (times, values, str(layer.GetAttributeAtPath(path).default))
        elif path.IsPrimPath() and path != Sdf.Path("/Takes"):
            found[str(path)] = str(layer.GetPrimAtPath(path).customData)

    layer.Traverse(Sdf.Path.absoluteRootPath, visit)
    return found


@pytest.mark.parametrize("suffix", [".usd", ".usda"])
def test_a_library_grows_and_keeps_what_it_has(tmp_path: Path, suffix: str) -> None:
    out = tmp_path / f"takes{suffix}"
    library = TakeLibrary(meters_per_unit=0.01)
    library.add(make_recording("a", frames=9))
    library.write(out)
    before = describe_layer(out)
    grown = TakeLibrary.open(out)
    same, other = make_recording("b", rate=60.0, frames=4), make_recording("c", names=("Hips", "Chest"), frames=2)
    added = [grown.add(recording) for recording in (same, other)]
    grown.write(out)
    after = describe_layer(out)
    assert {path: after[path] for path in before} == before
    assert [(take.prim_path, take.skeleton_path) for take in added] == [
        ("/Takes/b", "/Takes/Skeleton"),
        ("/Takes/c", "/Takes/Skeleton_2"),
    ]
    layer = Sdf.Layer.OpenAsAnonymous(str(out))
    assert (layer.timeCodesPerSecond, layer.endTimeCode) == (30.0, 8.0)
    assert layer.ListTimeSamplesForPath("/Takes/b.rotations") == [0.0, 0.5, 1.0, 1.5]


def test_growing_takes_the_longest(tmp_path: Path) -> None:
    library = TakeLibrary(meters_per_unit=0.01)
    library.add(make_recording("a", frames=3))
    library.write(tmp_path / "takes.usda")
    grown = TakeLibrary.open(tmp_path / "takes.usda")
    grown.add(make_recording("b", frames=7))
    grown.write(tmp_path / "takes.usda")
    assert Sdf.Layer.OpenAsAnonymous(str(tmp_path / "takes.usda")).endTimeCode == 6.0


def test_skeletons_that_differ_in_rest_place_or_limits_are_two(tmp_path: Path) -> None:
    plain = make_recording("a")
    turned = plain.rest_transforms.copy()
    turned[1, :2, :2] = [[0.0, 1.0], [-1.0, 0.0]]
    place = np.eye(4)
    place[3, 0] = 5.0
    limit = ChannelLimit(joint=1, channel="rx", lower=-10.0, upper=20.0)
    variants = [
        plain,
        replace(plain, rest=turned),
        replace(plain, placement=place),
        replace(plain, limits=(limit,), dof_axes=np.tile([1.0, 0.0, 0.0, 0.0], (2, 1))),
        replace(plain, meters_per_unit=0.02),
        replace(plain, up_axis="Z"),
    ]
    library = TakeLibrary(meters_per_unit=0.01)
    found = [library.add(recording).skeleton_path for recording in variants]
    assert len(set(found)) == len(variants)
    library.write(tmp_path / "takes.usd")
    again = TakeLibrary.open(tmp_path / "takes.usd")
    assert [again.add(recording).skeleton_path for recording in variants] == found


def test_a_capture_is_imported_once(tmp_path: Path) -> None:
    first, copy = tmp_path / "walk.bvh", tmp_path / "copy.bvh"
    for file_path in (first, copy):
        file_path.write_text(BVH)
    out = tmp_path / "takes.usd"
    result = import_takes([first, copy], out=out)
    assert [take.prim_path for take in result.takes] == ["/Takes/walk"]
    assert result.notes == (f"{copy}: is in the library already as /Takes/walk; left out",)
    bytes_before = out.read_bytes()
    assert import_takes([first], out=out, licence="other").takes == ()
    assert out.read_bytes() == bytes_before
    for options in ({"skip_frames": 1}, {"style": "sad"}, {"meters_per_unit": 0.02}, {"up_axis": "Z"}):
        assert len(import_takes([first], out=out, **options).takes) == 1, options  # type: ignore[arg-type]
        assert len(import_takes([first], out=out, **options).takes) == 0, options  # type: ignore[arg-type]
    assert len(import_takes([first], out=out, rate=10.0).takes) == 0  # BVH files say their rate
    first.write_text(BVH.replace("2 2 2 2", "2 2 2 3"))
    assert len(import_takes([first], out=out).takes) == 1
    assert len(list_takes(out)) == 6


def test_provenance_is_kept(tmp_path: Path) -> None:
    motion = write_take(tmp_path)
    import_takes([motion], out=tmp_path / "takes.usda", style="test", licence="CC BY 4.0", skip_frames=1)
    (entry,) = list_takes(tmp_path / "takes.usda")
    digests = {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in tmp_path.glob("tester*")}
    assert entry == TakeEntry(
        prim_path="/Takes/tester_01",
        skeleton_path="/Takes/Skeleton",
        source="tester_01.amc",
        clip="",
        sha256=digests["tester_01.amc"],
        companions=(f"tester.asf {digests['tester.asf']}",),
        options="metersPerUnit=0.0508 upAxis=Y rate=120 skipFrames=1 style=test",
        licence="CC BY 4.0",
        frame_count=1,
        rate=120.0,
        joint_count=4,
        style="test",
    )


def test_only_a_library_is_added_to(tmp_path: Path) -> None:
    (tmp_path / "walk.bvh").write_text(BVH)
    out = tmp_path / "other.usd"
    write_clip(read_clip(write_library(tmp_path, make_recording()), "/Takes/walk"), out, "/Takes/walk")
    with pytest.raises(InputError, match=r"other\.usd exists and is left alone; expected a take library"):
        import_takes([tmp_path / "walk.bvh"], out=out)
    with pytest.raises(InputError, match=r"other\.usd is no take library of usdmtex; expected .* default prim /Takes"):
        list_takes(out)
    with pytest.raises(InputError, match=r"cannot read .*gone\.usd; found no such file"):
        list_takes(tmp_path / "gone.usd")


def test_a_library_whose_root_was_renamed_is_replaced_only_on_demand(tmp_path: Path) -> None:
    (tmp_path / "walk.bvh").write_text(BVH)
    out = tmp_path / "takes.usda"
    write_library(tmp_path, make_recording())
    out.write_text(out.read_text().replace('"Takes"', '"Motions"').replace("</Takes", "</Motions"))
    with pytest.raises(InputError, match=r"takes\.usda is no take library .*Choose another name with -o, or --replace"):
        import_takes([tmp_path / "walk.bvh"], out=out)
    assert len(import_takes([tmp_path / "walk.bvh"], out=out, replace_library=True).takes) == 1
    assert [entry.prim_path for entry in list_takes(out)] == ["/Takes/walk"]


def test_a_library_without_provenance_is_listed(tmp_path: Path) -> None:
    write_library(tmp_path, make_recording())
    (entry,) = list_takes(tmp_path / "takes.usda")
    assert (entry.source, entry.frame_count, entry.rate, entry.sha256, entry.options) == ("walk.bvh", 3, 30.0, "", "")


def test_files_in_folders_without_motion_are_notes_and_named_ones_failures(tmp_path: Path) -> None:
    folder = tmp_path / "captures"
    folder.mkdir()
    (folder / "walk.bvh").write_text(BVH)
    (folder / "set.usda").write_text('#usda 1.0\ndef Xform "Set" {}\n')
    (folder / "cut.bvh").write_text(BVH[:-10])
    result = import_takes([folder], out=tmp_path / "takes.usd")
    assert [take.prim_path for take in result.takes] == ["/Takes/walk"]
    assert [failure.source.name for failure in result.failures] == ["cut.bvh"]
    assert result.notes == (f"{folder / 'set.usda'}: the stage has no SkelAnimation with joints",)
    result = import_takes([folder / "set.usda", folder / "walk.bvh"], out=tmp_path / "other.usd")
    assert [failure.source.name for failure in result.failures] == ["set.usda"]


def test_a_library_in_the_folder_is_not_imported_into_itself(tmp_path: Path) -> None:
    (tmp_path / "walk.bvh").write_text(BVH)
    for _ in range(2):
        import_takes([tmp_path], out=tmp_path / "takes.usd")
    assert [entry.prim_path for entry in list_takes(tmp_path / "takes.usd")] == ["/Takes/walk"]


def test_skeletons_alone_are_no_motion(tmp_path: Path) -> None:
    write_take(tmp_path)
    with pytest.raises(InputError, match=r"nothing written \(no file holds motion\):\n .*tester\.asf: is a skeleton"):
        import_takes([tmp_path / "tester.asf"], out=tmp_path / "takes.usd")


def test_skipping_every_frame_is_an_error() -> None:
    with pytest.raises(FormatError, match=r"walk\.bvh: nothing is left of its 3 frames after skipping 3"):
        make_recording().without_first(3)


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"meters_per_unit": 0.0}, "bad metres per unit; expected a finite number above 0; found 0"),
        ({"meters_per_unit": float("nan")}, "bad metres per unit"),
        ({"up_axis": "X"}, "bad up axis; expected Y or Z; found 'X'"),
        ({"rate": 0.0}, "bad rate; expected frames per second from 0.001 to 100000; found 0"),
        ({"skip_frames": -1}, "bad number of frames to skip; expected a whole number of at least 0; found -1"),
    ],
)
def test_options_out_of_range_are_errors(tmp_path: Path, options: dict[str, object], reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        import_takes(["walk.bvh"], out=tmp_path / "takes.usd", **options)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="no files to import"):
        import_takes([], out=tmp_path / "takes.usd")
