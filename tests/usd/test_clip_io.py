"""Clips out of stages and into files."""

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdSkel

from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.usd.clip_io import ClipReader, read_clip, write_clip
from tests.usd.animation_support import JOINTS, author_animation, author_skeleton, new_layer, stage_of


def random_clip(*, rate=24.0, start=1.0, time_codes_per_frame=1.0, up=(0.0, 1.0, 0.0), frames=9, joints=JOINTS):
    rng = np.random.default_rng(7)
    rest = np.tile(np.eye(4), (len(joints), 1, 1))
    rest[:, :3, :3] = np.linalg.qr(rng.standard_normal((len(joints), 3, 3)))[0]
    rest[:, :3, :3] *= np.sign(np.linalg.det(rest[:, :3, :3]))[:, None, None]
    rest[:, 3, :3] = rng.standard_normal((len(joints), 3))
    steps = 0.2 * rng.standard_normal((frames, len(joints), 3))
    return Clip(
        skeleton=Skeleton(joints=tuple(joints), rest=rest, up=np.array(up), meters_per_unit=0.05644),
        rate=rate,
        rotations=quaternion.unroll(quaternion.exp(np.cumsum(steps, axis=0))),
        translations=rng.standard_normal((frames, len(joints), 3)),
        scales=np.ones((frames, len(joints), 3)),
        start=start,
        time_codes_per_frame=time_codes_per_frame,
    )


def assert_same_motion(clip, other):
    assert clip.joints == other.joints
    assert (clip.start, clip.frame_count) == (other.start, other.frame_count)
    assert clip.rate == pytest.approx(other.rate, rel=1e-12)
    assert clip.time_codes_per_frame == pytest.approx(other.time_codes_per_frame, rel=1e-12)
    np.testing.assert_array_equal(clip.rest, other.rest)
    np.testing.assert_allclose(clip.skeleton.up, other.skeleton.up, atol=1e-12)
    assert clip.skeleton.meters_per_unit == pytest.approx(other.skeleton.meters_per_unit)
    assert quaternion.angle_between(clip.rotations, other.rotations).max() < 1e-6
    np.testing.assert_allclose(clip.translations, other.translations, atol=1e-6)
    np.testing.assert_allclose(clip.scales, other.scales, atol=1e-3)


class TestRoundTrip:
    @pytest.mark.parametrize("ending", ["usd", "usda", "usdc"])
    @pytest.mark.parametrize(
        ("rate", "start", "time_codes_per_frame"),
        [(24.0, 1.0, 1.0), (24.0, -7.5, 5.0), (119.88, 0.0, 1.0), (23.976, 101.0, 1.001), (120.0, 1001.0, 0.2)],
    )
    def test_comes_back(self, tmp_path, ending, rate, start, time_codes_per_frame):
        clip = random_clip(rate=rate, start=start, time_codes_per_frame=time_codes_per_frame)
        file = tmp_path / f"clip.{ending}"
        assert write_clip(clip, file, "/Takes/walk") == "/Takes/walk"
        assert_same_motion(read_clip(file, "/Takes/walk"), clip)

    @pytest.mark.parametrize("up", [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.6, 0.0, 0.8)])
    def test_up_comes_back(self, tmp_path, up):
        clip = random_clip(up=up)
        write_clip(clip, tmp_path / "clip.usda", "/walk")
        assert_same_motion(read_clip(str(tmp_path / "clip.usda"), "/walk"), clip)

    def test_a_single_frame_comes_back(self, tmp_path):
        clip = random_clip(frames=1, rate=30.0, start=12.0)
        write_clip(clip, tmp_path / "pose.usda", "/Poses/rest")
        assert_same_motion(read_clip(tmp_path / "pose.usda", "/Poses/rest"), clip)

    def test_real_characters_come_back(self, tmp_path, data_dir):
        clip = read_clip(data_dir / "usd" / "HIK_Export.usda", "/Fight_Dummy_Fight/Fight_Hips/Animation")
        assert (clip.frame_count, len(clip.joints), clip.rate, clip.start) == (101, 70, 24.0, 0.0)
        write_clip(clip, tmp_path / "fight.usdc", "/Takes/fight")
        assert_same_motion(read_clip(tmp_path / "fight.usdc", "/Takes/fight"), clip)


class TestWriteClip:
    def test_usd_plays_it(self, tmp_path):
        """UsdSkel finds the binding and computes the same pose as our forward kinematics."""
        clip = random_clip(time_codes_per_frame=5.0)
        write_clip(clip, tmp_path / "clip.usda", "/Takes/walk")
        stage = Usd.Stage.Open(str(tmp_path / "clip.usda"))
        cache = UsdSkel.Cache()
        cache.Populate(UsdSkel.Root(stage.GetPrimAtPath("/Takes")), Usd.PrimDefaultPredicate)
        query = cache.GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath("/Takes/Skeleton")))
        positions, _ = clip.skeleton.world_pose(clip.rotations, clip.translations)
        for frame, time_code in enumerate(clip.time_codes):
            world = np.array(query.ComputeJointSkelTransforms(time_code))
            np.testing.assert_allclose(world[:, 3, :3], positions[frame], atol=1e-5)

    def test_metadata(self, tmp_path):
        write_clip(random_clip(time_codes_per_frame=5.0), tmp_path / "clip.usda", "/Takes/walk")
        stage = Usd.Stage.Open(str(tmp_path / "clip.usda"))
        layer = stage.GetRootLayer()
        assert (layer.timeCodesPerSecond, layer.framesPerSecond) == (120.0, 24.0)
        assert (layer.startTimeCode, layer.endTimeCode, layer.defaultPrim) == (1.0, 41.0, "Takes")
        assert UsdGeom.GetStageUpAxis(stage) == "Y"
        assert UsdGeom.GetStageMetersPerUnit(stage) == 0.05644

    @pytest.mark.parametrize(
        ("prim_path", "written"),
        [
            ("/Takes/07_01.bvh", "/Takes/take_07_01"),
            ("/Takes/07_01", "/Takes/take_07_01"),
            ("/my takes/slow walk", "/_my_takes/take_slow_walk"),
            ("/Takes/Skeleton", "/Takes/Skeleton"),
            ("/Läufe/schnell", "/Läufe/schnell"),
        ],
    )
    def test_names_are_made_valid(self, tmp_path, prim_path, written):
        clip = random_clip()
        assert write_clip(clip, tmp_path / "clip.usda", prim_path) == written
        assert_same_motion(read_clip(tmp_path / "clip.usda", written), clip)

    @pytest.mark.parametrize("prim_path", ["", "/", "walk", "/Takes//walk", "/Takes/"])
    def test_what_is_no_path_is_refused(self, tmp_path, prim_path):
        with pytest.raises(InputError, match=rf'"{prim_path}" is no path for a clip; expected an absolute path'):
            write_clip(random_clip(), tmp_path / "clip.usda", prim_path)
        assert list(tmp_path.iterdir()) == []

    def test_the_work_of_others_is_left_alone(self, tmp_path):
        file = tmp_path / "shot.usda"
        file.write_text("#usda 1.0\n", encoding="utf-8")
        with pytest.raises(InputError, match=r"shot.usda exists and was not written by usdmtex"):
            write_clip(random_clip(), file, "/walk")
        assert file.read_text(encoding="utf-8") == "#usda 1.0\n"

    def test_our_own_file_is_replaced_with_equal_bytes(self, tmp_path):
        file = tmp_path / "clip.usdc"
        write_clip(random_clip(), file, "/Takes/walk")
        before = file.read_bytes()
        write_clip(random_clip(), file, "/Takes/walk")
        assert file.read_bytes() == before
        assert [entry.name for entry in tmp_path.iterdir()] == ["clip.usdc"]


class TestReadClip:
    def test_rest_is_that_of_the_skeleton_it_drives(self):
        layer = new_layer()
        author_animation(layer, "/Char/Anim", [1, 2], joints=("Hips",))
        stage = stage_of(layer)
        skeleton = author_skeleton(stage, "/Char/Skel")
        UsdSkel.BindingAPI.Apply(skeleton).CreateAnimationSourceRel().SetTargets(["/Char/Anim"])
        clip = read_clip(stage, "/Char/Anim")
        assert clip.joints == JOINTS
        np.testing.assert_array_equal(clip.rest[:, 3, :3], [[0, 1, 0], [0, 2, 0], [0, 3, 0]])
        np.testing.assert_array_equal(clip.translations[0, 1:], [[0, 2, 0], [0, 3, 0]])

    def test_without_a_skeleton(self):
        layer = new_layer()
        _, translations = author_animation(layer, "/Anim", [1, 2])
        clip = read_clip(stage_of(layer), "/Anim")
        np.testing.assert_array_equal(clip.rest[:, 3, :3], translations[0])
        np.testing.assert_array_equal(clip.rest[:, :3, :3], np.tile(np.eye(3), (3, 1, 1)))

    def test_usable_range_and_named_skeleton_of_a_take(self):
        layer = new_layer()
        author_animation(layer, "/Takes/walk", range(10))
        spec = layer.GetPrimAtPath("/Takes/walk")
        spec.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=["MtexTakeAPI"]))
        uniform = Sdf.VariabilityUniform
        start = Sdf.AttributeSpec(spec, "mtex:take:start", Sdf.ValueTypeNames.TimeCode, uniform)
        start.default = Sdf.TimeCode(3.0)
        relationship = Sdf.RelationshipSpec(spec, "mtex:take:skeleton", False, uniform)
        relationship.targetPathList.explicitItems = [Sdf.Path("/Rigs/B")]
        stage = stage_of(layer)
        author_skeleton(stage, "/Rigs/A")
        author_skeleton(stage, "/Rigs/B", heights=(4, 5, 6))
        clip = ClipReader(stage).read_take(stage.GetPrimAtPath("/Takes/walk"))
        np.testing.assert_array_equal(clip.time_codes, np.arange(3, 10))
        np.testing.assert_array_equal(clip.skeleton.rest_translations[:, 1], [4, 5, 6])
        assert clip.name == "/Takes/walk"

    @pytest.mark.parametrize("prim_path", ["/Nowhere", "not a path", ""])
    def test_unknown_path_lists_the_animations(self, prim_path):
        layer = new_layer()
        author_animation(layer, "/Takes/walk", [1, 2])
        with pytest.raises(InputError, match=rf"has no prim {prim_path};.*SkelAnimation. There are: /Takes/walk"):
            read_clip(stage_of(layer), prim_path)

    def test_not_an_animation(self):
        layer = new_layer()
        author_animation(layer, "/Takes/walk", [1, 2])
        with pytest.raises(InputError, match=r"/Takes is no animation; expected a SkelAnimation; found Scope"):
            read_clip(stage_of(layer), "/Takes")

    def test_missing_file(self, tmp_path):
        with pytest.raises(InputError, match=r"cannot open .*none.usda; expected a USD file; found no such file"):
            read_clip(tmp_path / "none.usda", "/walk")

    def test_broken_file(self, tmp_path):
        file = tmp_path / "broken.usda"
        file.write_text("#usda 1.0\ndef {", encoding="utf-8")
        with pytest.raises(InputError, match=r"cannot read .*broken.usda: line 2: parse error at"):
            read_clip(file, "/walk")
