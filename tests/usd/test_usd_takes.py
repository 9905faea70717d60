"""USD stages as sources of takes."""

import re
import time
import zipfile
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel

from mtex_usd.api import import_takes, list_takes, read_clip
from mtex_usd.formats.recording import FormatError, NoMotionError
from mtex_usd.usd.usd_takes import read_usd
from tests.usd.character import CHARACTER


@pytest.fixture
def character(tmp_path: Path) -> Path:
    """Give a stage with an oriented, placed rig and an animation of some of its joints."""
    (tmp_path / "hero.usda").write_text(CHARACTER)
    return tmp_path / "hero.usda"


def test_a_take_in_the_library_is_the_clip_of_the_stage(character: Path, tmp_path: Path) -> None:
    (take,) = import_takes([character], out=tmp_path / "takes.usd").takes
    before, after = read_clip(character, "/Hero/Walk"), read_clip(tmp_path / "takes.usd", take.prim_path)
    assert (take.prim_path, take.rate, take.frame_count) == ("/Takes/hero", 24.0, 3)
    assert after.joints == before.joints == ("L", "L/Hand", "R", "R/Hand")
    for name in ("rotations", "translations", "scales", "rest"):
        np.testing.assert_allclose(getattr(after, name), getattr(before, name), atol=1e-7, err_msg=name)
    np.testing.assert_allclose(after.skeleton.up, before.skeleton.up)
    assert after.skeleton.meters_per_unit == pytest.approx(before.skeleton.meters_per_unit)
    assert after.rate == before.rate


def test_the_skeleton_keeps_its_bind_pose_and_place(character: Path, tmp_path: Path) -> None:
    import_takes([character], out=tmp_path / "takes.usd")
    stage = Usd.Stage.Open(str(tmp_path / "takes.usd"))
    assert (UsdGeom.GetStageUpAxis(stage), UsdGeom.GetStageMetersPerUnit(stage)) == ("Z", 0.1)
    skeleton = UsdSkel.Skeleton(stage.GetPrimAtPath("/Takes/Skeleton"))
    assert [m.ExtractTranslation()[0] for m in skeleton.GetBindTransformsAttr().Get()] == [1, 2, 3, 4]
    place = UsdGeom.Imageable(skeleton).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
    assert place.ExtractTranslation() == Gf.Vec3d(0, 7, 0)


def test_units_and_up_axis_of_the_library_are_reached_by_a_transform(character: Path, tmp_path: Path) -> None:
    first = tmp_path / "first.bvh"
    first.write_text(
        "HIERARCHY\nROOT A\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n}\nMOTION\nFrames: 1\n"
        "Frame Time: 0.1\n1 2 3\n"
    )
    import_takes([first, character], out=tmp_path / "takes.usd", meters_per_unit=0.01)
    stage = Usd.Stage.Open(str(tmp_path / "takes.usd"))
    assert (UsdGeom.GetStageUpAxis(stage), UsdGeom.GetStageMetersPerUnit(stage)) == ("Y", 0.01)
    skeleton = UsdGeom.Imageable(stage.GetPrimAtPath("/Takes/Skeleton_2"))
    to_world = skeleton.ComputeLocalToWorldTransform(Usd.TimeCode.Default())
    # Up is Z there and Y here; ten of these units are one of those.
    assert Gf.IsClose(to_world.Transform(Gf.Vec3d(1, 2, 3)), Gf.Vec3d(10, 30, -90), 1e-9)
    clip = read_clip(stage, "/Takes/hero")
    np.testing.assert_allclose(clip.skeleton.up, [0, 0, 1], atol=1e-12)
    assert clip.skeleton.meters_per_unit == pytest.approx(0.1)


def test_each_animation_is_a_take_and_bad_ones_are_reported(character: Path, tmp_path: Path) -> None:
    stage = Usd.Stage.Open(str(character))
    stage.DefinePrim("/Hero/Empty", "SkelAnimation").GetAttribute("joints").Set(["L"])
    stage.DefinePrim("/Hero/Face", "SkelAnimation")
    Sdf.CopySpec(stage.GetRootLayer(), "/Hero/Walk", stage.GetRootLayer(), "/Hero/Run")
    stage.GetRootLayer().Export(str(tmp_path / "many.usda"))
    result = import_takes([tmp_path / "many.usda"], out=tmp_path / "takes.usd")
    assert [take.prim_path for take in result.takes] == ["/Takes/many_Walk", "/Takes/many_Run"]
    assert [entry.clip for entry in list_takes(result.out)] == ["/Hero/Walk", "/Hero/Run"]
    (failure,) = result.failures
    assert failure.source == tmp_path / "many.usda"
    assert failure.reason.startswith("/Hero/Empty holds no animation")


def test_an_animation_in_instances_is_one_take(character: Path, tmp_path: Path) -> None:
    stage = Usd.Stage.CreateNew(str(tmp_path / "crowd.usda"))
    for name in ("A", "B"):
        prim = stage.DefinePrim(f"/{name}")
        prim.GetReferences().AddReference("./hero.usda", "/Hero")
        prim.SetInstanceable(True)
    stage.GetRootLayer().Save()
    takes = read_usd(tmp_path / "crowd.usda")
    (recording,) = takes.recordings
    assert recording.companions == (character,)
    assert recording.joint_paths == ("L", "L/Hand", "R", "R/Hand")


def test_a_change_in_a_layer_below_is_another_capture(character: Path, tmp_path: Path) -> None:
    stage = Usd.Stage.CreateNew(str(tmp_path / "shot.usda"))
    stage.GetRootLayer().subLayerPaths = ["./hero.usda"]
    stage.GetRootLayer().Save()
    del stage
    library = tmp_path / "takes.usd"
    assert len(import_takes([tmp_path / "shot.usda"], out=library).takes) == 1
    assert len(import_takes([tmp_path / "shot.usda"], out=library).takes) == 0
    layer = Sdf.Layer.FindOrOpen(str(character))
    layer.GetAttributeAtPath("/Hero/Walk.translations").default = [(1, 1, 1), (2, 2, 2)]
    layer.Save()
    assert len(import_takes([tmp_path / "shot.usda"], out=library).takes) == 1


def test_what_moves_beside_the_joints_is_said(character: Path, tmp_path: Path) -> None:
    stage = Usd.Stage.Open(str(character))
    move = UsdGeom.Xformable(stage.GetPrimAtPath("/Hero")).AddTranslateOp()
    move.Set((0, 0, 0), 1)
    move.Set((0, 0, 9), 2)
    stage.GetRootLayer().Export(str(tmp_path / "moving.usda"))
    result = import_takes([tmp_path / "moving.usda"], out=tmp_path / "takes.usd")
    (note,) = result.notes
    assert note.endswith("/Hero/Walk: the transform of /Hero moves too, which a take does not carry")


def test_the_style_of_a_take_goes_along(character: Path, tmp_path: Path) -> None:
    first, second = tmp_path / "first.usd", tmp_path / "second.usd"
    import_takes([character], out=first, style="sad")
    import_takes([first], out=second)
    assert [entry.style for entry in list_takes(second)] == ["sad"]


def test_the_format_is_told_by_content(character: Path, tmp_path: Path) -> None:
    expected = read_usd(character).recordings[0]
    for suffix in (".usda", ".usdc"):
        Usd.Stage.Open(str(character)).Export(str(tmp_path / f"x{suffix}"))
        (tmp_path / f"x{suffix}").rename(tmp_path / f"x{suffix}.dat")
        (recording,) = read_usd(tmp_path / f"x{suffix}.dat").recordings
        np.testing.assert_array_equal(recording.rotations, expected.rotations)
        assert recording.source == tmp_path / f"x{suffix}.dat"


def test_a_stage_without_its_name_that_needs_others_is_refused(character: Path, tmp_path: Path) -> None:
    (tmp_path / "shot.dat").write_text("#usda 1.0\n(\n    subLayers = [@./hero.usda@]\n)\n")
    with pytest.raises(FormatError, match=r"refers to other files and has no USD name; rename it to shot\.usda"):
        read_usd(tmp_path / "shot.dat")


def test_stages_that_cannot_be_read_or_hold_nothing(tmp_path: Path) -> None:
    (tmp_path / "broken.usda").write_text("#usda 1.0\ndef {")
    with pytest.raises(FormatError, match=r"broken\.usda: cannot be read"):
        read_usd(tmp_path / "broken.usda")
    (tmp_path / "cut.usdc").write_bytes(b"PXR-USDC\0\0\0")
    with pytest.raises(FormatError, match=r"cut\.usdc: cannot be read"):
        read_usd(tmp_path / "cut.usdc")
    with zipfile.ZipFile(tmp_path / "other.usdz", "w") as archive:
        archive.writestr("readme.txt", "hello")
    with pytest.raises(FormatError, match=r"other\.usdz"):
        read_usd(tmp_path / "other.usdz")
    (tmp_path / "set.usda").write_text('#usda 1.0\ndef Xform "Set" {}\n')
    with pytest.raises(NoMotionError, match=r"set\.usda: the stage has no SkelAnimation with joints"):
        read_usd(tmp_path / "set.usda")


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        (
            "quatf[] rotations",
            "float4[] rotations",
            r"/Hero/Walk\.rotations has the wrong type; expected quatf\[\]; found float4",
        ),
        (
            "matrix4d[] restTransforms",
            "matrix5d[] restTransforms",
            r"\.restTransforms has the wrong type; expected matrix4d",
        ),
        (
            "14: [",
            "9e12: [",
            "/Hero/Walk is too long to read; expected at most 1000000 frames; found time samples from 10",
        ),
        ("(0.8, 0.6, 0, 0)", "(nan, 0.6, 0, 0)", "/Hero/Walk: rotations are not finite; found joint L at time code 10"),
        ("(4, 0, 0, 1)", "(4e38, 0, 0, 1)", "/Hero/Rig: its restTransforms has a number too large for any scene"),
        ("(0, 7, 0)", "(0, 1e39, 0)", "/Hero/Rig: its place has a number too large for any scene"),
        ("(0, 7, 0)", "(0, nan, 0)", "/Hero/Rig: its place is not finite; Correct|/Hero/Rig: its place is not finite"),
        (
            "((0, 1, 0, 0), (-1, 0, 0, 0)",
            "((1e9, 0, 0, 0), (1e9, 1e-3, 0, 0)",
            "/Hero/Rig: the rest pose of L is flat, so that it has no rotation",
        ),
        ("(1, 1, 1), (1, 2, 1)]", "(1, 1, 1), (1, inf, 1)]", "/Hero/Walk: scales are not finite; found joint L"),
        ("metersPerUnit = 0.1", "metersPerUnit = inf", "bad unit of inf metres"),
        ('["R/Hand", "L"]', '["R/Hand"]', r"rotations does not fit the joints at time code 10; expected 1 elements"),
    ],
)
def test_damaged_animations_are_reported(character: Path, tmp_path: Path, old: str, new: str, reason: str) -> None:
    (tmp_path / "bad.usda").write_text(CHARACTER.replace(old, new))
    (failure,) = read_usd(tmp_path / "bad.usda").failures
    assert re.search(reason, failure.reason), failure.reason


def test_an_up_axis_that_is_none_is_refused(tmp_path: Path) -> None:
    (tmp_path / "bad.usda").write_text(CHARACTER.replace('upAxis = "Z"', 'upAxis = "W"'))
    with pytest.raises(FormatError, match=r"bad\.usda: bad upAxis 'W'; expected Y or Z"):
        read_usd(tmp_path / "bad.usda")


def test_samples_of_another_type_than_their_attribute_are_reported(tmp_path: Path) -> None:
    """Text files cannot hold them; in crate files eight bytes are a sample's type and where it is."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(CHARACTER)
    layer.Export(str(tmp_path / "bad.usdc"))
    crate = (tmp_path / "bad.usdc").read_bytes()
    references = [match.start() for match in re.finditer(rb"(?s)......\x11\x80", crate)]  # to arrays of quatf
    assert references
    inlined_bool = b"\1\0\0\0\0\0\1\x40"
    (tmp_path / "bad.usdc").write_bytes(crate[: references[0]] + inlined_bool + crate[references[0] + 8 :])
    (failure,) = read_usd(tmp_path / "bad.usdc").failures
    assert failure.reason.startswith("/Hero/Walk: its values are of a wrong type")


def test_thousands_of_errors_take_no_longer_than_a_few(tmp_path: Path) -> None:
    """USD's parser makes an error of each bracket, and every one quotes the rest of the file."""
    (tmp_path / "deep.usda").write_text(CHARACTER.replace("metersPerUnit = 0.1", f"metersPerUnit = {'(' * 3000}"))
    start = time.perf_counter()
    with pytest.raises(FormatError, match="cannot be read: Tuple nesting too deep") as caught:
        read_usd(tmp_path / "deep.usda")
    assert time.perf_counter() - start < 10.0
    assert len(str(caught.value)) < 1000


def test_what_we_made_of_a_shot_is_no_recording(tmp_path: Path) -> None:
    mark = 'dictionary mtex = {{ string generator = "usdmtex"\nstring kind = "{}" }}'
    header = "#usda 1.0\n(\n    customLayerData = {{ " + mark + " }}\n)\n"
    for kind in ("override", "stage"):
        (tmp_path / f"{kind}.usda").write_text(header.format(kind))
        with pytest.raises(NoMotionError, match="is what usdmtex made of a shot, no recording"):
            read_usd(tmp_path / f"{kind}.usda")
