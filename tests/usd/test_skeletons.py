"""Skeleton prims as plain skeletons, and whose an animation is."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

from mtex_usd.errors import InputError, StageError
from mtex_usd.usd.animation import sample_take
from mtex_usd.usd.schema import TakeSettings
from mtex_usd.usd.skeletons import find_bindings, find_take_skeleton, make_bare_skeleton, read_skeleton
from tests.usd.animation_support import JOINTS, author_animation, author_skeleton, new_layer, stage_of

NO_SETTINGS = TakeSettings()


def in_memory():
    return Usd.Stage.CreateInMemory()


def bind(skeleton, animation_path):
    UsdSkel.BindingAPI.Apply(skeleton).CreateAnimationSourceRel().SetTargets([animation_path])


class TestReadSkeleton:
    def test_joints_rest_and_unit(self):
        stage = in_memory()
        UsdGeom.SetStageMetersPerUnit(stage, 0.05644)
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
        skeleton = read_skeleton(author_skeleton(stage, "/Skel"))
        assert skeleton.joints == JOINTS
        np.testing.assert_array_equal(skeleton.rest_translations, [[0, 1, 0], [0, 2, 0], [0, 3, 0]])
        np.testing.assert_array_equal(skeleton.up, [0, 1, 0])
        assert skeleton.meters_per_unit == pytest.approx(0.05644)

    @pytest.mark.parametrize("broken", ["missing", "short", "zero", "nan"])
    def test_rest_comes_from_bind_where_it_is_unusable(self, broken):
        stage = in_memory()
        prim = author_skeleton(stage, "/Skel")
        skeleton = UsdSkel.Skeleton(prim)
        local = [Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(i, 2, 3), 30.0 * i)) for i in (1, 2, 3)]
        for matrix, height in zip(local, (1, 2, 3), strict=True):
            matrix.SetTranslateOnly(Gf.Vec3d(0.5, height, 0))
        skeleton.CreateBindTransformsAttr([local[0], local[1] * local[0], local[2] * local[0]])
        attribute = skeleton.GetRestTransformsAttr()
        values = {"short": local[:2], "zero": [Gf.Matrix4d(0)] * 3, "nan": [Gf.Matrix4d(np.nan)] * 3}
        attribute.Clear() if broken == "missing" else attribute.Set(Vt.Matrix4dArray(values[broken]))
        np.testing.assert_allclose(read_skeleton(prim).rest, np.array(local), atol=1e-12)

    def test_up_is_the_stages_up_in_the_skeletons_space(self):
        stage = in_memory()
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
        UsdGeom.SetStageMetersPerUnit(stage, 1.0)
        above = UsdGeom.Xform.Define(stage, "/Char")
        above.AddRotateXOp().Set(90.0)  # Y-up data stood up on a Z-up stage
        above.AddScaleOp().Set(Gf.Vec3f(0.01))
        skeleton = read_skeleton(author_skeleton(stage, "/Char/Skel"))
        np.testing.assert_allclose(skeleton.up, [0, 1, 0], atol=1e-12)
        assert skeleton.meters_per_unit == pytest.approx(0.01)
        assert skeleton.height * skeleton.meters_per_unit == pytest.approx(0.03)

    def test_a_real_character_on_a_z_up_stage(self, data_dir):
        stage = Usd.Stage.Open(str(data_dir / "usd" / "HIK_Export.usda"))
        skeleton = read_skeleton(stage.GetPrimAtPath("/Fight_Dummy_Fight/Fight_Hips"))
        assert UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z
        np.testing.assert_allclose(skeleton.up, [0, 1, 0], atol=1e-12)
        assert len(skeleton.joints) == 70

    def test_every_real_skeleton_stands_as_in_usd(self, data_dir):
        """Forward kinematics of the rest pose against UsdSkel's own, mirrored and scaled joints aside."""
        compared = 0
        for file in sorted([*(data_dir / "usd").glob("*.usd*"), *(data_dir / "usd_pixar_tests").glob("*.usda")]):
            stage = Usd.Stage.Open(str(file))
            for prim in stage.Traverse():
                if not prim.IsA(UsdSkel.Skeleton) or not UsdSkel.Skeleton(prim).GetJointsAttr().Get():
                    continue
                skeleton = read_skeleton(prim)
                query = UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton(prim))
                world = query.ComputeJointSkelTransforms(Usd.TimeCode.Default(), atRest=True) if query else None
                unscaled = np.allclose(np.abs(np.linalg.det(skeleton.rest)), 1.0, atol=1e-4)
                if world is None or not unscaled:
                    continue
                positions, _ = skeleton.world_pose(skeleton.rest_rotations, skeleton.rest_translations)
                np.testing.assert_allclose(positions, np.array(world)[:, 3, :3], atol=1e-4 * max(1, skeleton.height))
                compared += 1
        assert compared >= 10

    def test_not_a_skeleton(self):
        stage = in_memory()
        with pytest.raises(StageError, match=r"/Ball is no Skeleton; found Sphere"):
            read_skeleton(stage.DefinePrim("/Ball", "Sphere"))

    def test_no_joints(self):
        stage = in_memory()
        with pytest.raises(StageError, match=r"/Skel has no joints"):
            read_skeleton(stage.DefinePrim("/Skel", "Skeleton"))

    def test_no_rest_at_all(self):
        stage = in_memory()
        skeleton = UsdSkel.Skeleton.Define(stage, "/Skel")
        skeleton.CreateJointsAttr(JOINTS)
        with pytest.raises(StageError, match=r"/Skel has no usable rest pose; expected 3 invertible restTransforms"):
            read_skeleton(skeleton.GetPrim())

    def test_children_before_parents(self):
        stage = in_memory()
        with pytest.raises(InputError, match=r"a joint comes before its parent; found Hips/Leg"):
            read_skeleton(author_skeleton(stage, "/Skel", joints=("Hips/Leg", "Hips")))

    def test_flattened_by_a_transform_above(self):
        stage = in_memory()
        UsdGeom.Xform.Define(stage, "/Char").AddScaleOp().Set(Gf.Vec3f(1, 0, 1))
        with pytest.raises(StageError, match=r"/Char/Skel: a transform above the Skeleton cannot be inverted"):
            read_skeleton(author_skeleton(stage, "/Char/Skel"))


class TestBareSkeleton:
    def test_first_frame_without_rotation_parents_first(self):
        layer = new_layer()
        joints = ("Hips/Spine/Neck", "Hips", "Hips/Spine")
        _, translations = author_animation(layer, "/Anim", [1, 2], joints=joints)
        stage = stage_of(layer)
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
        UsdGeom.SetStageMetersPerUnit(stage, 1.0)
        samples = sample_take(stage, stage.GetPrimAtPath("/Anim"), NO_SETTINGS)
        skeleton = make_bare_skeleton(samples, stage)
        assert skeleton.joints == ("Hips", "Hips/Spine", "Hips/Spine/Neck")
        np.testing.assert_array_equal(skeleton.rest[:, 3, :3], translations[0, [1, 2, 0]])
        np.testing.assert_array_equal(skeleton.rest[:, :3, :3], np.tile(np.eye(3), (3, 1, 1)))
        np.testing.assert_array_equal(skeleton.up, [0, 0, 1])
        assert skeleton.meters_per_unit == 1.0

    def test_without_translations(self):
        layer = new_layer()
        author_animation(layer, "/Anim", [1, 2], translations=False)
        stage = stage_of(layer)
        samples = sample_take(stage, stage.GetPrimAtPath("/Anim"), NO_SETTINGS)
        np.testing.assert_array_equal(make_bare_skeleton(samples, stage).rest, np.tile(np.eye(4), (3, 1, 1)))


class TestFindTakeSkeleton:
    def stage(self):
        layer = new_layer()
        author_animation(layer, "/Takes/walk", [1, 2])
        stage = stage_of(layer)
        return stage, stage.GetPrimAtPath("/Takes/walk")

    def test_the_named_one_comes_first(self):
        stage, take = self.stage()
        bound, named = author_skeleton(stage, "/Takes/Bound"), author_skeleton(stage, "/Elsewhere/Named")
        bind(bound, take.GetPath())
        assert find_take_skeleton(take, TakeSettings(skeleton=named.GetPath())) == named
        assert find_take_skeleton(take, NO_SETTINGS) == bound

    def test_a_named_prim_that_is_no_skeleton(self):
        _, take = self.stage()
        with pytest.raises(StageError, match=r"/Takes/walk: mtex:take:skeleton names no Skeleton; found /Takes"):
            find_take_skeleton(take, TakeSettings(skeleton=Sdf.Path("/Takes")))

    def test_a_binding_inherited_from_above(self):
        stage, take = self.stage()
        root = UsdSkel.Root.Define(stage, "/Char").GetPrim()
        skeleton = author_skeleton(stage, "/Char/Rig/Skel")
        bind(root, take.GetPath())
        assert find_take_skeleton(take, NO_SETTINGS) == skeleton
        assert find_bindings(stage) == {take.GetPath(): (skeleton,)}

    def test_bindings_found_once_serve_all_takes(self):
        stage, take = self.stage()
        skeleton = author_skeleton(stage, "/Skel")
        assert find_take_skeleton(take, NO_SETTINGS, bindings={take.GetPath(): (skeleton,)}) == skeleton
        assert find_take_skeleton(take, NO_SETTINGS, bindings={}) is None

    def test_skeletons_inside_instances(self):
        library, root = new_layer(), new_layer()
        author_animation(library, "/Char/Anim", [1, 2])
        asset = stage_of(library)
        bind(author_skeleton(asset, "/Char/Skel"), "/Char/Anim")
        stage = stage_of(root)
        for name in ("A", "B"):
            prim = stage.DefinePrim(f"/{name}")
            prim.GetReferences().AddReference(library.identifier, "/Char")
            prim.SetInstanceable(True)
        found = find_take_skeleton(stage.GetPrimAtPath("/B/Anim"), NO_SETTINGS)
        assert found.GetPath() == "/B/Skel"
        assert read_skeleton(found).joints == JOINTS

    def test_the_only_one_beside_it(self):
        stage, take = self.stage()
        author_skeleton(stage, "/Takes/Small", joints=JOINTS[:2])
        assert find_take_skeleton(take, NO_SETTINGS) is None
        fitting = author_skeleton(stage, "/Takes/Rigs/Full", joints=(*JOINTS, "Hips/Spine/Head"))
        author_skeleton(stage, "/Elsewhere/Full")
        assert find_take_skeleton(take, NO_SETTINGS) == fitting
        author_skeleton(stage, "/Takes/Rigs/Other")
        assert find_take_skeleton(take, NO_SETTINGS) is None

    def test_the_only_one_beneath_the_skel_root(self):
        layer = new_layer()
        author_animation(layer, "/Char/Anims/walk", [1, 2])
        stage = stage_of(layer)
        UsdSkel.Root.Define(stage, "/Char")
        skeleton = author_skeleton(stage, "/Char/Rig/Skel")
        assert find_take_skeleton(stage.GetPrimAtPath("/Char/Anims/walk"), NO_SETTINGS) == skeleton
