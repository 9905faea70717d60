"""Sampling SkelAnimations through the composed stage."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdSkel, Vt

from mtex_usd.errors import InputError, StageError
from mtex_usd.usd.animation import sample_sketch, sample_take
from mtex_usd.usd.schema import TakeSettings
from tests.usd.animation_support import (
    JOINTS,
    author_animation,
    bits,
    define,
    new_layer,
    one_animation,
    read_directly,
    stage_of,
    to_quatf,
)

NO_SETTINGS = TakeSettings()


def assert_as_usd_plays(samples, prim):
    """What was sampled is what Attribute.Get gives, to the bit."""
    for frame, time_code in enumerate(samples.time_codes):
        for name in ("rotations", "translations", "scales"):
            if name not in samples.missing:
                sampled = getattr(samples, name)[frame]
                np.testing.assert_array_equal(bits(sampled), bits(read_directly(prim, name, time_code)))


class TestSampleSketch:
    def test_gives_the_authored_bits(self):
        stage, prim, rotations, translations = one_animation([1, 2, 3, 4, 5])
        samples = sample_sketch(stage, prim)
        np.testing.assert_array_equal(samples.time_codes, [1, 2, 3, 4, 5])
        np.testing.assert_array_equal(samples.sample_times, [1, 2, 3, 4, 5])
        np.testing.assert_array_equal(bits(samples.rotations), bits(rotations))
        np.testing.assert_array_equal(bits(samples.translations), bits(translations))
        np.testing.assert_array_equal(samples.scales, np.ones((5, 3, 3)))
        assert samples.joints == JOINTS
        assert (samples.name, samples.missing) == ("/Anim", ())
        assert samples.rotations.dtype == samples.scales.dtype == np.float32

    def test_fills_the_frames_between_keys_as_usd_does(self):
        stage, prim, _, _ = one_animation([1, 7, 12])
        samples = sample_sketch(stage, prim)
        assert len(samples.time_codes) == 12
        assert_as_usd_plays(samples, prim)

    def test_the_grid_starts_at_the_first_sample_of_any_attribute(self):
        layer = new_layer()
        author_animation(layer, "/Anim", [3, 8])
        layer.SetTimeSample("/Anim.scales", 2.5, Vt.Vec3hArray([Gf.Vec3h(1.5)] * 3))
        layer.SetTimeSample("/Anim.scales", 9.75, Vt.Vec3hArray([Gf.Vec3h(0.3)] * 3))
        stage = stage_of(layer)
        samples = sample_sketch(stage, stage.GetPrimAtPath("/Anim"))
        np.testing.assert_array_equal(samples.time_codes, np.arange(2.5, 9.75))
        assert samples.scales[0, 0, 0] == 1.5
        assert samples.scales.dtype == np.float32
        assert_as_usd_plays(samples, stage.GetPrimAtPath("/Anim"))

    def test_half_float_scales_keep_their_value(self):
        layer = new_layer()
        author_animation(layer, "/Anim", [1])
        layer.SetTimeSample("/Anim.scales", 1, Vt.Vec3hArray([Gf.Vec3h(0.1, 1.0, 2.0)] * 3))
        stage = stage_of(layer)
        scales = sample_sketch(stage, stage.GetPrimAtPath("/Anim")).scales
        np.testing.assert_array_equal(scales[0, 2], np.float16([0.1, 1.0, 2.0]).astype(np.float32))

    def test_frames_are_those_of_the_authored_frame_rate(self):
        metadata = {"timeCodesPerSecond": 120.0, "framesPerSecond": 24.0}
        stage, prim, rotations, _ = one_animation(range(21), metadata=metadata)
        samples = sample_sketch(stage, prim)
        np.testing.assert_array_equal(samples.time_codes, [0, 5, 10, 15, 20])
        np.testing.assert_array_equal(bits(samples.rotations), bits(rotations[::5]))
        assert (samples.rate, samples.time_codes_per_frame) == (24.0, 5.0)

    def test_without_an_authored_frame_rate_every_time_code_is_a_frame(self):
        stage, prim, _, _ = one_animation(range(21), metadata={"timeCodesPerSecond": 120.0})
        assert len(sample_sketch(stage, prim).time_codes) == 21

    def test_rounding_of_the_grid_does_not_interpolate(self):
        """A tenth of a time code per frame: 0.1 * 3 is not the 0.3 that is authored."""
        times = [round(0.1 * i, 1) for i in range(40)]
        stage, prim, rotations, _ = one_animation(times, metadata={"timeCodesPerSecond": 2.4, "framesPerSecond": 24.0})
        np.testing.assert_array_equal(bits(sample_sketch(stage, prim).rotations), bits(rotations))

    def test_default_only_takes_the_range_of_the_stage(self):
        layer = new_layer(startTimeCode=11.0, endTimeCode=15.0)
        author_default_pose(layer, "/Anim")
        stage = stage_of(layer)
        samples = sample_sketch(stage, stage.GetPrimAtPath("/Anim"))
        np.testing.assert_array_equal(samples.time_codes, [11, 12, 13, 14, 15])
        assert samples.sample_times.shape == (0,)
        assert_as_usd_plays(samples, stage.GetPrimAtPath("/Anim"))

    def test_default_only_without_a_range_is_refused(self):
        layer = new_layer()
        author_default_pose(layer, "/Anim")
        stage = stage_of(layer)
        with pytest.raises(StageError, match=r"/Anim has only default values and the stage has no time range"):
            sample_sketch(stage, stage.GetPrimAtPath("/Anim"))

    def test_the_animation_of_a_real_character(self, data_dir):
        stage = Usd.Stage.Open(str(data_dir / "usd" / "HIK_Export.usda"))
        prim = stage.GetPrimAtPath("/Fight_Dummy_Fight/Fight_Hips/Animation")
        samples = sample_sketch(stage, prim)
        assert samples.rotations.shape == (101, 70, 4)
        assert_as_usd_plays(samples, prim)

    def test_rotation_and_translation_keys_at_different_times(self, data_dir):
        stage = Usd.Stage.Open(str(data_dir / "usd_pixar_tests" / "test_dqs.usda"))
        prim = stage.GetPrimAtPath("/Root/Skeleton/Animation")
        assert prim.GetAttribute("rotations").GetTimeSamples() != prim.GetAttribute("translations").GetTimeSamples()
        samples = sample_sketch(stage, prim)
        union = set(prim.GetAttribute("rotations").GetTimeSamples()) | set(
            prim.GetAttribute("translations").GetTimeSamples()
        )
        assert (samples.time_codes[0], samples.time_codes[-1]) == (min(union), max(union))
        assert_as_usd_plays(samples, prim)


def author_default_pose(layer, prim_path):
    spec = define(layer, prim_path, "SkelAnimation")
    kinds = Sdf.ValueTypeNames
    Sdf.AttributeSpec(spec, "joints", kinds.TokenArray, Sdf.VariabilityUniform).default = list(JOINTS)
    Sdf.AttributeSpec(spec, "rotations", kinds.QuatfArray).default = to_quatf(np.eye(4)[:3])
    Sdf.AttributeSpec(spec, "translations", kinds.Float3Array).default = Vt.Vec3fArray([Gf.Vec3f(1, 2, 3)] * 3)
    Sdf.AttributeSpec(spec, "scales", kinds.Half3Array).default = Vt.Vec3hArray([Gf.Vec3h(1)] * 3)


class TestComposition:
    """Where the samples are is where the composed stage puts them."""

    def test_sublayer_with_offset_and_scale(self):
        library, root = new_layer(), new_layer()
        rotations, _ = author_animation(library, "/Anim", [1, 2, 3])
        root.subLayerPaths.append(library.identifier)
        root.subLayerOffsets[0] = Sdf.LayerOffset(100.0, 2.0)
        stage = stage_of(root)
        samples = sample_sketch(stage, stage.GetPrimAtPath("/Anim"))
        np.testing.assert_array_equal(samples.time_codes, [102, 103, 104, 105, 106])
        np.testing.assert_array_equal(bits(samples.rotations[::2]), bits(rotations))
        assert_as_usd_plays(samples, stage.GetPrimAtPath("/Anim"))

    @pytest.mark.parametrize("arc", ["reference", "payload"])
    def test_reference_scaled_in_time(self, arc):
        library, root = new_layer(), new_layer()
        rotations, _ = author_animation(library, "/Anim", [0, 2, 4])
        stage = stage_of(root)
        prim = stage.DefinePrim("/Shot/Anim", "SkelAnimation")
        arcs = prim.GetReferences().AddReference if arc == "reference" else prim.GetPayloads().AddPayload
        arcs(library.identifier, "/Anim", Sdf.LayerOffset(10.0, 0.5))
        samples = sample_sketch(stage, prim)
        np.testing.assert_array_equal(samples.time_codes, [10, 11, 12])
        np.testing.assert_array_equal(bits(samples.rotations), bits(rotations))

    def test_variants(self):
        layer = new_layer()
        author_animation(layer, "/Anim", [1, 2])
        stage = stage_of(layer)
        prim = stage.GetPrimAtPath("/Anim")
        prim.GetAttribute("rotations").Clear()
        variants = prim.GetVariantSets().AddVariantSet("version")
        poses = {"calm": to_quatf(np.eye(4)[[0, 0, 0]]), "wild": to_quatf(np.eye(4)[[1, 2, 3]])}
        for name, pose in poses.items():
            variants.AddVariant(name)
            variants.SetVariantSelection(name)
            with variants.GetVariantEditContext():
                prim.GetAttribute("rotations").Set(pose, 1)
        np.testing.assert_array_equal(sample_sketch(stage, prim).rotations[0], np.eye(4)[[1, 2, 3]])
        variants.SetVariantSelection("calm")
        np.testing.assert_array_equal(sample_sketch(stage, prim).rotations[0], np.eye(4)[[0, 0, 0]])

    def test_value_clips(self):
        first, second = new_layer("a.usda"), new_layer("b.usda")
        one, _ = author_animation(first, "/Anim", [0, 1, 2], seed=1)
        two, _ = author_animation(second, "/Anim", [0, 1, 2], seed=2)
        manifest, topology = new_layer("m.usda"), new_layer("t.usda")
        for layer in (manifest, topology):
            spec = define(layer, "/Anim", "SkelAnimation")
            Sdf.AttributeSpec(spec, "rotations", Sdf.ValueTypeNames.QuatfArray)
            Sdf.AttributeSpec(spec, "translations", Sdf.ValueTypeNames.Float3Array)
        joints = Sdf.AttributeSpec(
            topology.GetPrimAtPath("/Anim"), "joints", Sdf.ValueTypeNames.TokenArray, Sdf.VariabilityUniform
        )
        joints.default = list(JOINTS)
        stage = stage_of(topology)
        clips = Usd.ClipsAPI(stage.GetPrimAtPath("/Anim"))
        clips.SetClipAssetPaths([Sdf.AssetPath(first.identifier), Sdf.AssetPath(second.identifier)])
        clips.SetClipManifestAssetPath(Sdf.AssetPath(manifest.identifier))
        clips.SetClipPrimPath("/Anim")
        clips.SetClipActive([(10, 0), (13, 1)])
        clips.SetClipTimes([(10, 0), (12, 2), (13, 0), (15, 2)])
        prim = stage.GetPrimAtPath("/Anim")
        samples = sample_sketch(stage, prim)
        np.testing.assert_array_equal(samples.time_codes, np.arange(10, 16))
        np.testing.assert_array_equal(bits(samples.rotations), bits(np.concatenate([one, two])))
        assert samples.missing == ("scales",)
        assert sample_take(stage, prim, NO_SETTINGS).rate == 24.0

    def test_instance_proxies(self):
        library, root = new_layer(), new_layer()
        rotations, _ = author_animation(library, "/Char/Anim", [1, 2, 3])
        stage = stage_of(root)
        for name in ("A", "B"):
            prim = stage.DefinePrim(f"/{name}")
            prim.GetReferences().AddReference(library.identifier, "/Char")
            prim.SetInstanceable(True)
        prim = stage.GetPrimAtPath("/B/Anim")
        assert prim.IsInstanceProxy()
        samples = sample_sketch(stage, prim)
        assert samples.name == "/B/Anim"
        np.testing.assert_array_equal(bits(samples.rotations), bits(rotations))


class TestSampleTake:
    @pytest.mark.parametrize("recorded", [120.0, 119.88, 30.0, 23.976])
    def test_keeps_the_rate_of_the_library_it_is_referenced_from(self, recorded):
        """120 time codes per second in a stage of 24: USD puts the samples a fifth of a time code apart."""
        library, root = new_layer(timeCodesPerSecond=recorded), new_layer(timeCodesPerSecond=24.0)
        rotations, _ = author_animation(library, "/Takes/walk", range(101))
        root.subLayerPaths.append(library.identifier)
        stage = stage_of(root)
        for prim_path in ("/Takes/walk", "/Shot/walk"):
            if prim_path.startswith("/Shot"):
                stage.DefinePrim(prim_path).GetReferences().AddReference(library.identifier, "/Takes/walk")
            prim = stage.GetPrimAtPath(prim_path)
            samples = sample_take(stage, prim, NO_SETTINGS)
            assert samples.rate == pytest.approx(recorded, rel=1e-12)
            assert samples.time_codes_per_frame == pytest.approx(24.0 / recorded, rel=1e-12)
            np.testing.assert_allclose(samples.time_codes, 24.0 / recorded * np.arange(101), atol=1e-9)
            np.testing.assert_allclose(samples.rotations, rotations, atol=1e-6)
            assert_as_usd_plays(samples, prim)

    @pytest.mark.parametrize("rate", [120.0, 119.88, 60.0, 30.0, 23.976, 24.0])
    def test_own_rate(self, rate):
        stage, prim, rotations, _ = one_animation(range(30), metadata={"timeCodesPerSecond": rate})
        samples = sample_take(stage, prim, NO_SETTINGS)
        assert samples.rate == rate
        np.testing.assert_array_equal(bits(samples.rotations), bits(rotations))

    def test_own_rate_is_not_that_of_the_frames(self):
        """Recorded at 120 with a stage that plays 24 frames/s."""
        metadata = {"timeCodesPerSecond": 120.0, "framesPerSecond": 24.0}
        stage, prim, _, _ = one_animation(range(30), metadata=metadata)
        samples = sample_take(stage, prim, NO_SETTINGS)
        assert (samples.rate, samples.time_codes_per_frame, len(samples.time_codes)) == (120.0, 1.0, 30)

    def test_drifting_time_codes(self):
        stage, prim, _, _ = one_animation([0, 1.0001, 2.0003, 3.0003, 4.0005])
        samples = sample_take(stage, prim, NO_SETTINGS)
        assert samples.rate == 24.0
        np.testing.assert_array_equal(samples.time_codes, [0, 1, 2, 3, 4])
        assert_as_usd_plays(samples, prim)

    def test_rounded_time_codes(self):
        times = [round(i / 120.0, 3) for i in range(200)]
        stage, prim, _, _ = one_animation(times, metadata={"timeCodesPerSecond": 1.0, "framesPerSecond": 24.0})
        samples = sample_take(stage, prim, NO_SETTINGS)
        assert samples.rate == pytest.approx(120.0, rel=1e-12)
        np.testing.assert_allclose(samples.time_codes, np.arange(200) / 120.0, atol=1e-9)

    def test_fractional_start(self):
        stage, prim, rotations, _ = one_animation([100.25 + i for i in range(10)])
        samples = sample_take(stage, prim, NO_SETTINGS)
        assert samples.time_codes[0] == 100.25
        np.testing.assert_array_equal(bits(samples.rotations), bits(rotations))

    @pytest.mark.parametrize("times", [[1, 13, 25, 37], [1, 2, 4.5, 8, 9, 13, 37]])
    def test_hand_set_keys_are_read_at_the_rate_of_the_stage(self, times):
        stage, prim, _, _ = one_animation(times)
        samples = sample_take(stage, prim, NO_SETTINGS)
        assert samples.rate == 24.0
        np.testing.assert_array_equal(samples.time_codes, np.arange(1.0, 38.0))
        assert_as_usd_plays(samples, prim)

    def test_usable_range(self):
        stage, prim, rotations, _ = one_animation(range(50))
        samples = sample_take(stage, prim, TakeSettings(start=3.0, end=40.0))
        np.testing.assert_array_equal(samples.time_codes, np.arange(3, 41))
        np.testing.assert_array_equal(bits(samples.rotations), bits(rotations[3:41]))

    def test_usable_range_wider_than_the_samples(self):
        stage, prim, _, _ = one_animation(range(5, 9))
        samples = sample_take(stage, prim, TakeSettings(start=-100.0, end=100.0))
        np.testing.assert_array_equal(samples.time_codes, [5, 6, 7, 8])

    def test_usable_range_between_samples(self):
        stage, prim, _, _ = one_animation(range(20))
        samples = sample_take(stage, prim, TakeSettings(start=3.5, end=10.4))
        np.testing.assert_array_equal(samples.time_codes, np.arange(4, 11))

    @pytest.mark.parametrize("settings", [TakeSettings(start=20.0), TakeSettings(end=-1.0)])
    def test_nothing_in_the_usable_range(self, settings):
        stage, prim, _, _ = one_animation(range(20))
        with pytest.raises(InputError, match=r"/Anim: the take has no samples in its usable range.*mtex:take:start"):
            sample_take(stage, prim, settings)

    def test_one_sample_and_defaults_are_one_frame(self):
        stage, prim, rotations, _ = one_animation([7])
        samples = sample_take(stage, prim, NO_SETTINGS)
        np.testing.assert_array_equal(samples.time_codes, [7])
        np.testing.assert_array_equal(samples.rotations, rotations)
        layer = new_layer(startTimeCode=5.0, endTimeCode=9.0)
        author_default_pose(layer, "/Pose")
        stage = stage_of(layer)
        np.testing.assert_array_equal(sample_take(stage, stage.GetPrimAtPath("/Pose"), NO_SETTINGS).time_codes, [5])

    @pytest.mark.parametrize("offset", [1e-7, 0.01, 0.3])
    def test_attributes_sampled_at_times_of_their_own(self, offset):
        """The rotations set the rate; what is off their grid by a hair must not make millions of frames."""
        stage, prim, rotations, translations = one_animation(range(20))
        prim.GetAttribute("translations").Clear()
        for frame in range(19):
            prim.GetAttribute("translations").Set(Vt.Vec3fArray.FromNumpy(translations[frame]), frame + offset)
        samples = sample_take(stage, prim, NO_SETTINGS)
        assert samples.rate == 24.0
        np.testing.assert_array_equal(bits(samples.rotations), bits(rotations))

    def test_the_grid_of_the_rotations_reaches_as_far_as_the_translations(self):
        stage, prim, _, translations = one_animation(range(20))
        prim.GetAttribute("translations").Clear()
        for time in (-4.5, 25.0):
            prim.GetAttribute("translations").Set(Vt.Vec3fArray.FromNumpy(translations[0]), time)
        np.testing.assert_array_equal(sample_take(stage, prim, NO_SETTINGS).time_codes, np.arange(-4, 26))

    def test_times_that_differ_by_rounding_are_no_recording(self):
        stage, prim, _, _ = one_animation([0, 1e-7, 10, 10 + 1e-7])
        samples = sample_take(stage, prim, NO_SETTINGS)
        assert samples.rate == 24.0
        assert len(samples.time_codes) == 11


class TestRefusedAnimations:
    def test_not_an_animation(self):
        stage = Usd.Stage.CreateInMemory()
        with pytest.raises(InputError, match=r"/Ball is no animation; expected a SkelAnimation; found Sphere"):
            sample_sketch(stage, stage.DefinePrim("/Ball", "Sphere"))

    def test_no_values(self):
        stage = Usd.Stage.CreateInMemory()
        prim = UsdSkel.Animation.Define(stage, "/Anim").GetPrim()
        with pytest.raises(StageError, match=r"/Anim holds no animation; expected rotations, translations or scales"):
            sample_take(stage, prim, NO_SETTINGS)

    def test_no_joints(self):
        stage, prim, _, _ = one_animation([1, 2])
        prim.GetAttribute("joints").Clear()
        with pytest.raises(StageError, match=r"/Anim names no joints"):
            sample_sketch(stage, prim)

    @pytest.mark.parametrize("name", ["rotations", "scales"])
    @pytest.mark.parametrize("count", [1, 2, 4])
    def test_array_of_another_length(self, name, count):
        stage, prim, _, _ = one_animation([1, 2, 3])
        value = to_quatf(np.eye(4)[:count]) if name == "rotations" else Vt.Vec3hArray([Gf.Vec3h(1)] * count)
        if name == "rotations":
            prim.GetAttribute(name).Set(value, 2)
        else:
            prim.GetAttribute(name).Set(value)
        time = 2 if name == "rotations" else 1
        pattern = rf"/Anim.{name} does not fit the joints at time code {time}; expected 3 elements.*; found {count}"
        with pytest.raises(StageError, match=pattern):
            sample_sketch(stage, prim)

    def test_blocked_sample(self):
        stage, prim, _, _ = one_animation([1, 2, 3])
        prim.GetAttribute("rotations").Set(Sdf.ValueBlock(), 2)
        with pytest.raises(StageError, match=r"/Anim.rotations does not fit the joints at time code 2.*found no value"):
            sample_sketch(stage, prim)
