"""Samples of SkelAnimations put onto skeletons."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdSkel, Vt

from mtex_usd.errors import InputError
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.usd.animation import sample_sketch
from mtex_usd.usd.sampled_clip import fill_missing, to_clip
from tests.usd.animation_support import (
    JOINTS,
    author_animation,
    bits,
    define,
    new_layer,
    one_animation,
    set_samples,
    stage_of,
    to_quatf,
)


def skeleton_of(joints, *, seed=5):
    rest = np.tile(np.eye(4), (len(joints), 1, 1))
    rest[:, 3, :3] = np.random.default_rng(seed).standard_normal((len(joints), 3))
    return Skeleton(joints=tuple(joints), rest=rest)


class TestMissingAttributes:
    def test_only_rotations(self):
        stage, prim, rotations, _ = one_animation([1, 2], scales=False, translations=False)
        samples = sample_sketch(stage, prim)
        assert samples.missing == ("translations", "scales")
        assert np.isnan(samples.translations).all()
        skeleton = skeleton_of(JOINTS)
        filled = fill_missing(samples, skeleton)
        assert filled.missing == ("translations", "scales")
        np.testing.assert_array_equal(filled.translations[1], skeleton.rest_translations.astype(np.float32))
        np.testing.assert_array_equal(filled.scales, np.ones((2, 3, 3)))
        np.testing.assert_array_equal(bits(filled.rotations), bits(rotations))

    def test_only_translations_on_a_turned_and_scaled_rest(self):
        layer = new_layer()
        spec = define(layer, "/Anim", "SkelAnimation")
        kinds = Sdf.ValueTypeNames
        Sdf.AttributeSpec(spec, "joints", kinds.TokenArray, Sdf.VariabilityUniform).default = ["Tail", "Hips"]
        set_samples(spec, "translations", kinds.Float3Array, [1, 2], [Vt.Vec3fArray(2)] * 2)
        stage = stage_of(layer)
        turn = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(1, 0, 0), 90))
        matrix = Gf.Matrix4d().SetScale(Gf.Vec3d(2, 2, 2)) * turn
        skeleton = Skeleton(joints=("Hips",), rest=np.array(matrix)[None])
        filled = fill_missing(sample_sketch(stage, stage.GetPrimAtPath("/Anim")), skeleton)
        half = np.sqrt(0.5)
        np.testing.assert_allclose(filled.rotations[0], [[1, 0, 0, 0], [half, half, 0, 0]], atol=1e-7)
        np.testing.assert_allclose(filled.scales[1], [[1, 1, 1], [2, 2, 2]], atol=1e-7)

    def test_a_mirrored_rest_decomposes_as_in_usd(self):
        matrix = Gf.Matrix4d().SetScale(Gf.Vec3d(-2, 2, 2)) * Gf.Matrix4d().SetRotate(
            Gf.Rotation(Gf.Vec3d(1, 2, 3), 40)
        )
        _, rotations, scales = UsdSkel.DecomposeTransforms(Vt.Matrix4dArray([matrix]))
        stage, prim, _, _ = one_animation([1], joints=("Hips",), scales=False)
        prim.RemoveProperty("rotations")
        samples = fill_missing(sample_sketch(stage, prim), Skeleton(joints=("Hips",), rest=np.array(matrix)[None]))
        expected = np.array([rotations[0].real, *rotations[0].imaginary])
        assert abs(float(samples.rotations[0, 0] @ expected)) == pytest.approx(1.0, abs=1e-6)
        np.testing.assert_allclose(samples.scales[0, 0], np.array(scales[0], dtype=float), atol=1e-3)


class TestToClip:
    def test_permuted_subset_lands_on_its_joints(self):
        joints = ("Hips/Spine", "Hips")
        stage, prim, rotations, translations = one_animation([1, 2, 3], joints=joints)
        skeleton = skeleton_of(JOINTS)
        clip = to_clip(sample_sketch(stage, prim), skeleton)
        assert clip.joints == JOINTS
        np.testing.assert_array_equal(clip.translations[:, [2, 0]], translations.astype(np.float64))
        np.testing.assert_array_equal(clip.translations[:, 1], np.tile(skeleton.rest_translations[1], (3, 1)))
        np.testing.assert_array_equal(clip.rotations[:, 1], np.tile([1.0, 0.0, 0.0, 0.0], (3, 1)))
        dots = np.abs(np.sum(clip.rotations[:, [2, 0]] * rotations, axis=-1))
        np.testing.assert_allclose(dots, 1.0, atol=1e-6)
        assert (clip.rate, clip.start, clip.time_codes_per_frame, clip.name) == (24.0, 1.0, 1.0, "/Anim")

    def test_joints_the_skeleton_lacks_are_left_out(self):
        stage, prim, _, translations = one_animation([1, 2], joints=("Hat", *JOINTS))
        clip = to_clip(sample_sketch(stage, prim), skeleton_of(JOINTS))
        np.testing.assert_array_equal(clip.translations, translations[:, 1:].astype(np.float64))

    def test_no_common_joint_is_refused(self):
        stage, prim, _, _ = one_animation([1, 2], joints=("mixamorig_Hips", "mixamorig_Hips/Leg"))
        with pytest.raises(InputError, match=r"no joint in common; expected joints such as Hips; found mixamorig_Hips"):
            to_clip(sample_sketch(stage, prim), skeleton_of(JOINTS))

    def test_quaternions_get_unit_length_and_continuous_signs(self):
        layer = new_layer()
        author_animation(layer, "/Anim", [])
        angles = np.radians(np.arange(8) * 20.0) / 2.0
        poses = [3.0 * (-1.0) ** i * np.array([[np.cos(a), np.sin(a), 0, 0]] * 3) for i, a in enumerate(angles)]
        for i, pose in enumerate(poses):
            layer.SetTimeSample("/Anim.rotations", i, to_quatf(pose))
        stage = stage_of(layer)
        clip = to_clip(sample_sketch(stage, stage.GetPrimAtPath("/Anim")), skeleton_of(JOINTS))
        np.testing.assert_allclose(np.linalg.norm(clip.rotations, axis=-1), 1.0, atol=1e-12)
        assert (np.sum(clip.rotations[1:] * clip.rotations[:-1], axis=-1) > 0.98).all()
        assert clip.rotations.dtype == np.float64

    def test_sign_flips_of_a_real_export(self, data_dir):
        """HIK_Export has 48 of them."""
        stage = Usd.Stage.Open(str(data_dir / "usd" / "HIK_Export.usda"))
        samples = sample_sketch(stage, stage.GetPrimAtPath("/Fight_Dummy_Fight/Fight_Hips/Animation"))
        flips = np.sum(samples.rotations[1:] * samples.rotations[:-1], axis=-1) < 0.0
        assert flips.sum() == 48
        clip = to_clip(samples, skeleton_of(samples.joints))
        assert (np.sum(clip.rotations[1:] * clip.rotations[:-1], axis=-1) > 0.0).all()
        np.testing.assert_allclose(np.abs(np.sum(clip.rotations * samples.rotations, axis=-1)), 1.0, atol=1e-6)

    def test_a_subset_of_a_real_skeleton(self, data_dir):
        stage = Usd.Stage.Open(str(data_dir / "usd_pixar_tests" / "arm.usda"))
        skeleton = UsdSkel.Skeleton(stage.GetPrimAtPath("/Model/Skel"))
        prim = stage.GetPrimAtPath("/Model/Skel/Anim1")
        joints = tuple(skeleton.GetJointsAttr().Get())
        samples = sample_sketch(stage, prim)
        assert set(samples.joints) < set(joints)
        rest = np.array(skeleton.GetRestTransformsAttr().Get())
        clip = to_clip(samples, Skeleton(joints=joints, rest=rest))
        still = [i for i, joint in enumerate(joints) if joint not in samples.joints]
        np.testing.assert_array_equal(clip.translations[3, still], rest[still, 3, :3])

    def test_a_rotation_without_length_is_named(self):
        stage, prim, rotations, _ = one_animation([1, 2, 3])
        prim.GetAttribute("rotations").Set(to_quatf([rotations[1, 0], np.zeros(4), rotations[1, 2]]), 2)
        pattern = r"/Anim: a rotation has no length; found joint Hips/LeftLeg at time code 2"
        with pytest.raises(InputError, match=pattern):
            to_clip(sample_sketch(stage, prim), skeleton_of(JOINTS))

    @pytest.mark.parametrize("value", [np.nan, np.inf])
    @pytest.mark.parametrize("name", ["rotations", "translations"])
    def test_numbers_that_are_none_are_named(self, name, value):
        stage, prim, rotations, translations = one_animation([1, 2, 3])
        if name == "rotations":
            rotations[2, 2, 1] = value
            prim.GetAttribute(name).Set(to_quatf(rotations[2]), 3)
        else:
            translations[2, 2, 1] = value
            prim.GetAttribute(name).Set(Vt.Vec3fArray.FromNumpy(translations[2]), 3)
        with pytest.raises(InputError, match=rf"/Anim: {name} are not finite; found joint Hips/Spine at time code 3"):
            to_clip(sample_sketch(stage, prim), skeleton_of(JOINTS))

    def test_bad_numbers_on_joints_left_out_do_not_matter(self):
        stage, prim, rotations, _ = one_animation([1, 2], joints=("Hat", *JOINTS))
        rotations[1, 0] = 0.0
        prim.GetAttribute("rotations").Set(to_quatf(rotations[1]), 2)
        assert to_clip(sample_sketch(stage, prim), skeleton_of(JOINTS)).frame_count == 2
