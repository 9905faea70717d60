"""The method from end to end on walks made of sines: the laws of texture and synthesis, and what stays as it is."""

import itertools
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import to_skeleton_rotations, unrolled_angles
from mtex_usd.texture.engine import animated_channels, texture_motion
from mtex_usd.texture.pyramid import nearest_band
from mtex_usd.texture.recipe import Recipe, Segment
from tests.oracle import texturing as twin
from tests.synthetic import (
    HEAD,
    HIPS,
    JOINTS,
    LEFT_ARM,
    LEFT_FOREARM,
    LEFT_KNEE,
    LEFT_LEG,
    POSITIONS,
    RIGHT_ARM,
    RIGHT_KNEE,
    RIGHT_LEG,
    SPINE,
    UP,
    block,
    make_skeleton,
    on_joints,
    turned,
    walk,
)

RECIPE = Recipe(match=("LeftUpLeg.rx", "RightUpLeg.rx"), texture=("*Leg",), synthesize=("Spine", "*Arm"), paths=3)
BOTH_HIPS = ("LeftUpLeg.rx", "RightUpLeg.rx")
TOLERANCE_DEGREES = np.degrees(1e-5)


@lru_cache
def takes(count=3, *, rate=24.0, oriented=None, heading=0.0, step=1.0):
    skeleton = make_skeleton(oriented=oriented)
    return tuple(
        walk(150, seed=i, rate=rate, skeleton=skeleton, heading=heading, name=f"/Takes/t{i}", step=step)
        for i in range(count)
    )


@lru_cache
def sketch(frames=100, *, rate=24.0, oriented=None, start=0.0, step=1.0):
    own = walk(
        frames, seed=77, rate=rate, detail=0.0, skeleton=make_skeleton(oriented=oriented), start=start, step=step
    )
    return block(own)


def column(result, name):
    return result.channels.index(name)


def in_skeleton_axes(clip, joint):
    return to_skeleton_rotations(clip.rotations, clip.skeleton)[:, clip.joints.index(joint)]


def rx(clip, joint):
    return unrolled_angles(in_skeleton_axes(clip, joint), "ZYX")[:, 0]


def angles_apart(one, other, joints=JOINTS):
    index = [one.joints.index(joint) for joint in joints]
    return np.degrees(quaternion.angle_between(one.rotations[:, index], other.rotations[:, index]))


# What holds for every result


def test_the_same_input_gives_the_same_result():
    one, other = (texture_motion(sketch(), takes(), RECIPE) for _ in range(2))
    assert [v.fragments for v in one.variants] == [v.fragments for v in other.variants]
    for a, b in zip(one.variants, other.variants, strict=True):
        np.testing.assert_array_equal(a.clip.rotations, b.clip.rotations)
        np.testing.assert_array_equal(a.clip.translations, b.clip.translations)
        np.testing.assert_array_equal(a.joined, b.joined)


def test_variants_are_ranked_and_their_fragments_tile_the_sketch():
    result = texture_motion(sketch(start=101.0), takes(), RECIPE)
    assert [variant.rank for variant in result.variants] == [1, 2, 3]
    assert result.notes == ()
    for variant in result.variants:
        uses = variant.fragments
        assert (uses[0].start, uses[-1].end) == (101.0, 200.0)
        assert [use.end for use in uses[:-1]] == [use.start for use in uses[1:]]
        assert [use.start - 101.0 for use in uses] == result.breaks[:-1].tolist()
        assert all(use.take in {"/Takes/t0", "/Takes/t1", "/Takes/t2"} for use in uses)
        assert all(0.0 <= use.take_start < use.take_end <= 149.0 for use in uses)
        assert variant.distance == pytest.approx(sum(use.distance for use in uses))
        follows = [a.take == b.take and a.take_end == b.take_start for a, b in itertools.pairwise(uses)]
        assert variant.zero_cost_joins == sum(follows)


def test_take_times_are_the_takes_own():
    moved = [replace(take, start=1000.0, time_codes_per_frame=5.0) for take in takes()]
    plain, result = (texture_motion(sketch(), pool, RECIPE) for pool in (takes(), moved))
    use, expected = result.variants[0].fragments[1], plain.variants[0].fragments[1]
    assert (use.take_start, use.take_end) == (1000.0 + 5.0 * expected.take_start, 1000.0 + 5.0 * expected.take_end)
    assert (use.start, use.end) == (expected.start, expected.end)


@pytest.mark.parametrize("flip", [False, True])
def test_joints_without_a_role_keep_every_bit(flip):
    own = sketch(oriented=4)
    if flip:  # one rotation has two quaternions; a file may hold either at every frame
        signs = np.random.default_rng(0).choice([-1.0, 1.0], size=(100, len(JOINTS), 1))
        own = replace(own, rotations=own.rotations * signs)
    result = texture_motion(own, takes(oriented=4), RECIPE)
    untouched = [JOINTS.index(joint) for joint in (HIPS, HEAD)]
    for variant in result.variants:
        np.testing.assert_array_equal(variant.clip.rotations[:, untouched], own.rotations[:, untouched])
        np.testing.assert_array_equal(variant.clip.translations, own.translations)
        np.testing.assert_array_equal(variant.clip.scales, own.scales)


def test_the_sketch_and_the_takes_are_not_changed():
    own, pool = sketch(), takes()
    before = [np.array(clip.rotations) for clip in (own, *pool)]
    texture_motion(own, pool, replace(RECIPE, scale=True, synthesize=("Hips.r", "Hips.t", "Spine", "*Arm")))
    for clip, rotations in zip((own, *pool), before, strict=True):
        np.testing.assert_array_equal(clip.rotations, rotations)


# The laws of texture and synthesis


@pytest.mark.parametrize("oriented", [None, 8])
@pytest.mark.parametrize("bands", [(0, 0), (1, 2), (2, 4)])
def test_texture_replaces_the_bands_and_nothing_else(bands, oriented):
    """The law: y - x + sum B(x) = sum B(m), on the columns and on the clip itself."""
    recipe = replace(RECIPE, texture_bands=bands)
    result = texture_motion(sketch(oriented=oriented), takes(oriented=oriented), recipe)
    first, last = (given or usual for given, usual in zip(bands, (2, 3), strict=True))
    for variant in result.variants:
        for name in (f"{LEFT_LEG}.rx", f"{LEFT_KNEE}.rx", f"{RIGHT_LEG}.rz"):
            at = column(result, name)
            expected = twin.texture(result.sketch_curves[:, at].tolist(), variant.joined[:, at].tolist(), first, last)
            np.testing.assert_allclose(variant.curves[:, at], expected, atol=TOLERANCE_DEGREES)


def test_synthesis_is_the_joined_path_without_its_highest_band():
    result = texture_motion(sketch(), takes(), RECIPE)
    for variant in result.variants:
        for name in (f"{LEFT_ARM}.rx", f"{SPINE}.ry", f"{LEFT_FOREARM}.rz"):
            at = column(result, name)
            expected = twin.synthesize(variant.joined[:, at].tolist(), 2)
            np.testing.assert_allclose(variant.curves[:, at], expected, atol=TOLERANCE_DEGREES)


@pytest.mark.parametrize("oriented", [None, 8])
def test_the_clip_is_what_the_curves_say(oriented):
    """Columns of a joint copied whole are a rotation vector about its mean, in skeleton axes, in degrees."""
    result = texture_motion(sketch(oriented=oriented), takes(oriented=oriented), RECIPE)
    clips = [(result.sketch, result.sketch_curves), *((v.clip, v.curves) for v in result.variants)]
    for clip, curves in clips:
        for joint in (LEFT_LEG, RIGHT_ARM):
            columns = [column(result, f"{joint}.{kind}") for kind in ("rx", "ry", "rz")]
            turns = quaternion.exp(np.radians(curves[:, columns]))
            expected = quaternion.multiply(result.mean_rotations[joint], turns)
            apart = quaternion.angle_between(in_skeleton_axes(clip, joint), expected)
            assert np.degrees(apart).max() < TOLERANCE_DEGREES


def test_a_take_that_is_the_sketch_gives_the_sketch_back():
    own = walk(120, seed=5, name="/Sketch", skeleton=make_skeleton(oriented=3))
    recipe = Recipe(
        match=BOTH_HIPS,
        texture=("*Leg",),
        synthesize=("Hips.r", "Hips.t", "Spine", "*Arm"),
        synthesis_band=1,
        candidates=1,
    )
    best = texture_motion(own, [replace(own, name="/Take"), *takes(2, oriented=3)], recipe).variants[0]
    assert {use.take for use in best.fragments} == {"/Take"}
    assert best.distance == pytest.approx(0.0, abs=1e-9)
    assert best.zero_cost_joins == len(best.fragments) - 1
    assert angles_apart(best.clip, own).max() < 1e-5
    np.testing.assert_allclose(best.clip.translations, own.translations, atol=1e-6)


def test_a_partly_marked_joint_keeps_its_other_angles():
    own = walk(100, seed=77, skeleton=make_skeleton(oriented=6), name="/Sketch")
    recipe = Recipe(match=BOTH_HIPS, synthesize=("LeftArm.rx",), texture=("Spine.rz",))
    result = texture_motion(own, takes(oriented=6), recipe)
    assert set(result.channels) == {f"{LEFT_ARM}.rx", f"{SPINE}.rz"}
    for joint, kept, changed in ((LEFT_ARM, (1, 2), 0), (SPINE, (0, 1), 2)):
        order = result.rotation_orders[joint]
        before = unrolled_angles(in_skeleton_axes(own, joint), order)
        for variant in result.variants:
            after = unrolled_angles(in_skeleton_axes(variant.clip, joint), order)
            np.testing.assert_allclose(np.radians(after[:, kept] - before[:, kept]), 0.0, atol=1e-5)
            assert np.abs(after[:, changed] - before[:, changed]).max() > 0.1
            at = column(result, f"{joint}.{'xyz'[changed].join(['r', ''])}")
            np.testing.assert_allclose(after[:, changed], variant.curves[:, at], atol=TOLERANCE_DEGREES)


def test_arms_that_were_still_swing_against_the_legs():
    result = texture_motion(sketch(), takes(), RECIPE)
    own = result.sketch
    assert np.ptp(rx(own, LEFT_ARM)) < 1e-6
    for variant in result.variants:
        arm, leg = rx(variant.clip, LEFT_ARM), rx(own, LEFT_LEG)
        assert np.ptp(arm) > 25.0
        assert np.corrcoef(arm, leg)[0, 1] < -0.8


def test_on_rigs_with_other_joint_orientations_the_motion_is_the_same():
    """Axes are the skeleton's: takes from a rig whose joints point elsewhere still fit."""
    plain = texture_motion(sketch(), takes(), RECIPE)
    others = texture_motion(sketch(oriented=1), takes(oriented=2), RECIPE)
    for a, b in zip(plain.variants, others.variants, strict=True):
        assert [use.take_start for use in a.fragments] == [use.take_start for use in b.fragments]
        for joint in (LEFT_ARM, RIGHT_KNEE, SPINE):
            apart = quaternion.angle_between(in_skeleton_axes(a.clip, joint), in_skeleton_axes(b.clip, joint))
            assert np.degrees(apart).max() < 1e-4


# The root


ROOT = replace(RECIPE, synthesize=("Hips.r", "Hips.t", "Spine", "*Arm"), match=BOTH_HIPS)


@pytest.mark.parametrize("degrees", [90.0, 180.0, -133.0])
@pytest.mark.parametrize("recipe", [ROOT, replace(ROOT, synthesize=("Spine", "*Arm"), texture=("Hips.r", "Hips.t"))])
def test_takes_that_walk_another_way_give_the_same(recipe, degrees):
    plain = texture_motion(sketch(), takes(), recipe)
    others = texture_motion(sketch(), [turned(take, degrees) for take in takes()], recipe)
    for a, b in zip(plain.variants, others.variants, strict=True):
        assert [use.take_start for use in a.fragments] == [use.take_start for use in b.fragments]
        assert angles_apart(a.clip, b.clip).max() < 1e-5
        np.testing.assert_allclose(a.clip.translations, b.clip.translations, atol=1e-6)


def test_a_sketch_that_walks_another_way_is_followed():
    plain = texture_motion(sketch(), takes(), ROOT)
    other = texture_motion(turned(sketch(), 70.0), takes(), ROOT)
    for a, b in zip(plain.variants, other.variants, strict=True):
        expected = turned(a.clip, 70.0)
        assert angles_apart(expected, b.clip).max() < 1e-4
        np.testing.assert_allclose(expected.translations[:, 0], b.clip.translations[:, 0], atol=1e-5)


@pytest.mark.parametrize("synthesize", [("Hips.r",), ("Hips.rx", "Hips.ry"), ("Hips.ry",)])
def test_yaw_is_the_sketchs_not_the_takes(synthesize):
    own = block(walk(100, seed=77, heading=40.0 * np.sin(np.linspace(0.0, 3.0, 100)), name="/Sketch"))
    pool = [turned(take, 100.0) for take in takes()]
    recipe = Recipe(match=BOTH_HIPS, synthesize=synthesize, synthesis_band=1)
    for variant in texture_motion(own, pool, recipe).variants:
        before, after = (np.unwrap(quaternion.twist(in_skeleton_axes(c, HIPS), UP)) for c in (own, variant.clip))
        np.testing.assert_allclose(np.degrees(after - before), 0.0, atol=1e-5)


def test_textured_yaw_gets_the_takes_detail_even_where_the_travel_is_synthesized():
    recipe = Recipe(match=BOTH_HIPS, texture=("Hips.r",), synthesize=("Hips.t",))
    result = texture_motion(sketch(), takes(), recipe)
    at = column(result, "Hips.ry")
    for variant in result.variants:
        expected = twin.texture(result.sketch_curves[:, at].tolist(), variant.joined[:, at].tolist(), 2, 3)
        np.testing.assert_allclose(variant.curves[:, at], expected, atol=TOLERANCE_DEGREES)
        assert np.abs(variant.curves[:, at] - result.sketch_curves[:, at]).max() > 0.05


def test_synthesized_travel_goes_where_the_sketch_faces():
    own = turned(sketch(), 30.0)
    recipe = Recipe(match=BOTH_HIPS, synthesize=("Hips.t",))
    for variant in texture_motion(own, [turned(take, -80.0) for take in takes()], recipe).variants:
        gone = variant.clip.translations[-1, 0] - variant.clip.translations[0, 0]
        assert np.degrees(np.arctan2(gone[0], gone[2])) == pytest.approx(30.0, abs=6.0)
        assert np.abs(np.diff(variant.clip.translations[:, 0], axis=0)).max() < 8.0


# Scale


def calming_sketch(frames=200):
    """Legs that swing less and less: 30 degrees, then 9."""
    size = np.interp(np.arange(frames), [0.4 * frames, 0.6 * frames], [30.0, 9.0])
    return block(walk(frames, seed=77, leg=size, detail=0.0))


def swing(clip, joint, frames):
    return np.ptp(rx(clip, joint)[frames])


EARLY, LATE = slice(10, 70), slice(130, 190)


def test_with_scale_the_arms_calm_down_with_the_legs():
    recipe = replace(RECIPE, scale=True, texture=(), match_lower=False)
    for variant in texture_motion(calming_sketch(), takes(), recipe).variants:
        assert swing(variant.clip, LEFT_ARM, LATE) < 0.5 * swing(variant.clip, LEFT_ARM, EARLY)
        scales = [use.scale for use in variant.fragments]
        assert np.median(scales[:3]) > 0.75
        assert np.median(scales[-4:-1]) == pytest.approx(0.3, abs=0.12)


def test_without_scale_they_do_not():
    recipe = replace(RECIPE, texture=(), match_lower=False)
    for variant in texture_motion(calming_sketch(), takes(), recipe).variants:
        assert swing(variant.clip, LEFT_ARM, LATE) > 0.75 * swing(variant.clip, LEFT_ARM, EARLY)
        assert {use.scale for use in variant.fragments} == {1.0}


def test_scaling_is_about_the_residual_not_about_rest():
    """A forearm bent by 20 degrees stays bent when the legs stop; about zero it would stretch out."""
    recipe = replace(RECIPE, scale=True, texture=(), match_lower=False)
    best = texture_motion(calming_sketch(), takes(), recipe).variants[0]
    assert rx(best.clip, LEFT_FOREARM)[LATE].mean() == pytest.approx(-20.0, abs=4.0)


@pytest.mark.parametrize("synthesize", [("LeftForeArm",), ("LeftForeArm.rx",)])
def test_each_take_keeps_its_own_mean_pose_when_scaled(synthesize):
    """Arms that bend by 60 degrees on average keep doing so on legs that hardly move."""
    pool = [walk(150, seed=i, arm=60.0, detail=0.0, name=f"/T{i}") for i in range(2)]
    own = block(walk(100, seed=77, leg=3.0, detail=0.0))
    recipe = Recipe(match=BOTH_HIPS, synthesize=synthesize, scale=True, match_lower=False)
    best = texture_motion(own, pool, recipe).variants[0]
    assert np.median([use.scale for use in best.fragments]) < 0.2
    forearm = rx(best.clip, LEFT_FOREARM)
    assert forearm.mean() == pytest.approx(-60.0, abs=12.0)
    assert np.ptp(forearm) < 40.0


# Time segments


SEGMENT = Segment(name="stomp", start=130.0, end=160.0, match=("LeftUpLeg.rx", "LeftLeg.rx"), synthesize=("LeftArm",))


def segmented():
    recipe = Recipe(match=BOTH_HIPS, texture=("RightLeg",), segments=(SEGMENT,), paths=2)
    return texture_motion(sketch(start=101.0), takes(), recipe)


def test_segment_borders_are_breaks():
    assert {29, 59} <= set(segmented().breaks.tolist())


def test_roles_ramp_over_the_join_time_at_segment_borders():
    result = segmented()
    weight = result.synthesized[:, column(result, f"{LEFT_ARM}.rx")]
    assert np.all(weight[:22] == 0.0)
    assert np.all(weight[67:] == 0.0)
    np.testing.assert_array_equal(weight[37:52], 1.0)
    assert np.all(np.diff(weight[:45]) >= 0.0)
    assert np.all(np.diff(weight[45:]) <= 0.0)
    assert np.abs(np.diff(weight)).max() < 0.25
    np.testing.assert_array_equal(result.textured[:, column(result, f"{RIGHT_KNEE}.rx")], 1.0)


def test_the_join_time_is_in_seconds():
    """At 60 frames/s the ramp takes as long as at 24."""
    widths = []
    for rate in (24.0, 60.0):
        segment = Segment(
            name="a", start=float(round(1.2 * rate)), end=float(round(3.0 * rate)), synthesize=("LeftArm",)
        )
        recipe = Recipe(match=BOTH_HIPS, texture=("RightLeg",), segments=(segment,), join_time=0.6)
        result = texture_motion(sketch(int(4.0 * rate), rate=rate), takes(rate=rate), recipe)
        weight = result.synthesized[: int(2.0 * rate), column(result, f"{LEFT_ARM}.rx")]
        widths.append(np.sum((weight > 0.0) & (weight < 1.0)) / rate)
    np.testing.assert_allclose(widths, 0.6, atol=0.1)


def test_away_from_its_segment_a_joint_stays_as_it_was():
    result = segmented()
    arm = JOINTS.index(LEFT_ARM)
    away = np.r_[0:20, 70:100]
    for variant in result.variants:
        apart = quaternion.angle_between(variant.clip.rotations[away, arm], result.sketch.rotations[away, arm])
        assert apart.max() < 1e-5
        inside = np.ptp(rx(variant.clip, LEFT_ARM)[37:52])
        assert inside > 5.0


def test_segments_are_in_time_codes_whatever_a_frame_is():
    segment = replace(SEGMENT, start=1000.0 + 5 * 29, end=1000.0 + 5 * 59)
    recipe = Recipe(match=BOTH_HIPS, texture=("RightLeg",), segments=(segment,), paths=2)
    result = texture_motion(sketch(start=1000.0, step=5.0), takes(), recipe)
    assert result.breaks.tolist() == segmented().breaks.tolist()
    np.testing.assert_array_equal(result.synthesized, segmented().synthesized)


def test_a_textured_segment_leaves_the_sketch_alone_outside():
    """Legs textured in flight only."""
    segment = Segment(name="flight", start=30.0, end=60.0, texture=("*Leg",))
    result = texture_motion(sketch(), takes(), Recipe(match=BOTH_HIPS, segments=(segment,)))
    for variant in result.variants:
        apart = angles_apart(variant.clip, result.sketch, (LEFT_LEG, RIGHT_KNEE))
        assert np.delete(apart, np.s_[20:71], axis=0).max() < TOLERANCE_DEGREES
        assert apart[35:55].max() > 0.2


def test_a_segment_that_turns_far_does_not_go_round_while_it_ramps():
    """Sketch near 175 degrees, takes near -175: ten degrees apart, not 350."""
    still = quaternion.exp(np.radians([175.0, 0.0, 0.0]))
    other = quaternion.exp(np.radians([-175.0, 0.0, 0.0]))
    arm = JOINTS.index(LEFT_ARM)

    def set_arm(clip, turn):
        rotations = np.array(clip.rotations)
        rotations[:, arm] = turn
        return replace(clip, rotations=rotations)

    own, pool = set_arm(sketch(), still), [set_arm(take, other) for take in takes()]
    segment = Segment(name="a", start=30.0, end=60.0, synthesize=("LeftArm.rx",))
    result = texture_motion(own, pool, Recipe(match=BOTH_HIPS, segments=(segment,), texture=("RightLeg",)))
    for variant in result.variants:
        apart = angles_apart(variant.clip, own, (LEFT_ARM,))
        assert apart.max() == pytest.approx(10.0, abs=1e-6)


# What takes may be like


def test_a_joint_no_take_has_is_named():
    without = [on_joints(take, [j for j in JOINTS if j != LEFT_FOREARM]) for take in takes()]
    with pytest.raises(InputError, match=f"no take has all joints with a role; expected joints named {LEFT_FOREARM}"):
        texture_motion(sketch(), without, RECIPE)


def test_a_take_that_lacks_a_joint_is_left_out_with_a_note():
    lame = on_joints(takes()[0], [j for j in JOINTS if j not in (LEFT_FOREARM, LEFT_ARM)])
    result = texture_motion(sketch(), [lame, *takes()[1:]], RECIPE)
    expected = texture_motion(sketch(), takes()[1:], RECIPE)
    assert result.notes == (f"take /Takes/t0 is left out: it has no {LEFT_ARM}, {LEFT_FOREARM}",)
    np.testing.assert_array_equal(result.variants[0].clip.rotations, expected.variants[0].clip.rotations)


def test_joints_without_a_role_may_be_missing_and_the_others_in_any_order():
    order = [
        HIPS,
        RIGHT_LEG,
        LEFT_LEG,
        SPINE,
        RIGHT_KNEE,
        LEFT_KNEE,
        RIGHT_ARM,
        LEFT_ARM,
        f"{RIGHT_ARM}/RightForeArm",
        LEFT_FOREARM,
    ]
    shuffled = [on_joints(take, order) for take in takes()]
    result, expected = (texture_motion(sketch(), pool, RECIPE) for pool in (shuffled, takes()))
    for a, b in zip(result.variants, expected.variants, strict=True):
        assert angles_apart(a.clip, b.clip).max() < 1e-5
        assert [use.take_start for use in a.fragments] == [use.take_start for use in b.fragments]


def test_joints_correspond_by_last_name_under_another_root():
    positions = {joint.replace(HIPS, "Rig/Pelvis"): at for joint, at in POSITIONS.items()}
    skeleton = make_skeleton(("Rig", *positions), positions={"Rig": (0.0, 0.0, 0.0), **positions})

    def rename(clip):
        padded = [np.concatenate([array[:, :1], array], axis=1) for array in (clip.rotations, clip.scales)]
        padded[0][:, 0] = [1.0, 0.0, 0.0, 0.0]
        translations = np.concatenate([np.zeros((clip.frame_count, 1, 3)), clip.translations], axis=1)
        return replace(clip, skeleton=skeleton, rotations=padded[0], translations=translations, scales=padded[1])

    result = texture_motion(sketch(), [rename(take) for take in takes()], RECIPE)
    expected = texture_motion(sketch(), takes(), RECIPE)
    assert angles_apart(result.variants[0].clip, expected.variants[0].clip).max() < 1e-5


def test_takes_too_short_for_a_fragment_are_skipped_by_name():
    result = texture_motion(sketch(), [walk(16, name="/Takes/short"), *takes()], RECIPE)
    assert result.notes == ("take /Takes/short is skipped: too short for one fragment",)
    assert {use.take for variant in result.variants for use in variant.fragments} <= {take.name for take in takes()}


def test_only_takes_too_short():
    with pytest.raises(
        InputError,
        match=r"every take is too short for one fragment; expected 17 frames .* band 4; found 16 at the most",
    ):
        texture_motion(sketch(), [walk(16), walk(9)], RECIPE)


def test_a_take_of_one_frame_is_too_short_for_anything():
    with pytest.raises(InputError, match="every take is too short for one fragment; expected 2 frames"):
        texture_motion(sketch(2), [walk(1)], RECIPE)


def test_no_takes():
    with pytest.raises(InputError, match=r"no take has all joints with a role; expected .*; found no takes"):
        texture_motion(sketch(), [], RECIPE)


def test_a_limit_that_had_to_be_lifted_is_reported():
    result = texture_motion(sketch(), takes(), replace(RECIPE, max_stretch=0.1))
    assert any("no take fragment is within 0.1 lengths of 0 to" in note for note in result.notes)


# What a sketch may be like


@pytest.mark.parametrize("frames", [2, 3, 5, 9])
def test_short_sketches(frames):
    result = texture_motion(sketch(frames), takes(), RECIPE)
    assert (result.breaks[0], result.breaks[-1]) == (0, frames - 1)
    for variant in result.variants:
        assert variant.clip.frame_count == frames
        assert np.isfinite(variant.clip.rotations).all()
        np.testing.assert_allclose(np.linalg.norm(variant.clip.rotations, axis=-1), 1.0, atol=1e-9)


def test_a_sketch_whose_match_channels_are_still():
    """One fragment; the nearest take fragments still come."""
    own = sketch()
    result = texture_motion(own, takes(), replace(RECIPE, match=("Head.rx",)))
    assert result.breaks.tolist() == [0, 99]
    assert result.variants


def test_an_empty_match_list_means_every_animated_channel_that_is_not_synthesized():
    recipe = replace(RECIPE, match=(), synthesize=("Hips.r", "Spine", "*Arm"))
    own = sketch()
    animated = [channel for channel in animated_channels(own, 0) if channel.joint != 0 or not channel.is_rotation]
    names = tuple(channel.name(own.joints) for channel in animated)
    moving = {"Hips.tx", "Hips.ty", "Hips.tz", *(f"{j}.rx" for j in (LEFT_LEG, RIGHT_LEG, LEFT_KNEE, RIGHT_KNEE))}
    assert set(names) == moving
    result, expected = (texture_motion(own, takes(), r) for r in (recipe, replace(recipe, match=names)))
    np.testing.assert_array_equal(result.variants[0].clip.rotations, expected.variants[0].clip.rotations)


def test_a_still_sketch_with_an_empty_match_list():
    own = sketch()
    still = replace(
        own, rotations=np.tile(own.rotations[:1], (100, 1, 1)), translations=np.tile(own.translations[:1], (100, 1, 1))
    )
    with pytest.raises(InputError, match="nothing to match; expected an animated channel, not synthesized; found none"):
        texture_motion(still, takes(), replace(RECIPE, match=()))


@pytest.mark.parametrize("rate", [30.0, 60.0])
def test_other_frame_rates_cut_at_the_same_times(rate):
    frames = int(4.0 * rate)
    result = texture_motion(sketch(frames, rate=rate), takes(rate=rate), RECIPE)
    band = nearest_band(0.8, rate)
    assert nearest_band(3.4, rate) == band - 2
    expected = texture_motion(sketch(96), takes(), RECIPE)
    inner, wanted = result.breaks[2:-2] / rate, expected.breaks[2:-2] / 24.0
    assert len(inner) == len(wanted)
    np.testing.assert_allclose(inner, wanted, atol=0.1)
    for variant in result.variants:
        arm, leg = rx(variant.clip, LEFT_ARM), rx(result.sketch, LEFT_LEG)
        assert np.corrcoef(arm, leg)[0, 1] < -0.8
