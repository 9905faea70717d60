"""What the page is told: positions, numbers, the recipe's text, packed arrays and the bundle."""

import base64
import hashlib
import json
import re
from dataclasses import replace
from importlib import resources

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pxr import Gf, Usd, UsdSkel, Vt

from mtex_usd.constraints.contacts import Contact, Effector
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.review.body import describe_body, find_bones
from mtex_usd.review.bundle import read_scripts, read_styles
from mtex_usd.review.numbers import Measure, band_energy, foot_slide, largest_turn, third_difference
from mtex_usd.review.packing import pack_array, pack_places
from mtex_usd.review.page import build_page
from mtex_usd.review.places import place_joints
from mtex_usd.review.recipe_text import recipe_to_usda
from mtex_usd.review.sheet import SKETCH_COLOUR, VARIANT_COLOURS
from mtex_usd.texture.recipe import Recipe, Segment
from mtex_usd.usd.schema import read_recipe
from tests.review.support import COMMAND, copy_samples, make_review
from tests.synthetic import HIPS, LEFT_ARM, LEFT_KNEE, RIGHT_KNEE, make_skeleton

RATE = 24.0


@pytest.fixture(scope="module")
def review(tmp_path_factory):
    return make_review(copy_samples(tmp_path_factory.mktemp("samples")) / "walk.usda", contacts="detect", paths=2)


def make_clip(rng, frames=7, *, scaled=False, oriented=3):
    skeleton = make_skeleton(oriented=oriented)
    shape = (frames, len(skeleton.joints))
    turns = quaternion.exp(0.4 * rng.standard_normal((*shape, 3)))
    return Clip(
        skeleton=skeleton,
        rate=RATE,
        rotations=quaternion.multiply(skeleton.rest_rotations, turns),
        translations=skeleton.rest_translations + rng.standard_normal((*shape, 3)),
        scales=rng.choice([0.5, 1.25, 2.0], (*shape, 3)) if scaled else np.ones((*shape, 3)),
    )


def turning(degrees_per_frame, frames=12):
    """One joint that turns evenly about one axis, rotations [F, 1, 4]."""
    angles = np.radians(degrees_per_frame) * np.arange(frames)
    return quaternion.exp(angles[:, None, None] * np.array([0.0, 0.0, 1.0]))


def unpack(packed):
    values = np.frombuffer(base64.b64decode(packed["data"]), dtype="<f4")
    return values.reshape(packed["shape"])


def unpack_places(packed):
    steps = np.frombuffer(base64.b64decode(packed["data"]), dtype="<u2").reshape(packed["shape"])
    return unpack(packed["middle"])[:, None] + np.array(packed["low"]) + steps * np.array(packed["step"])


def play_clip(clip):
    """Joint positions of a clip as UsdSkel computes them, shape [F, J, 3]."""
    stage = Usd.Stage.CreateInMemory()
    UsdSkel.Root.Define(stage, "/Body")
    skeleton, animation = UsdSkel.Skeleton.Define(stage, "/Body/Rig"), UsdSkel.Animation.Define(stage, "/Body/Anim")
    rest = Vt.Matrix4dArray([Gf.Matrix4d(*matrix.ravel()) for matrix in clip.rest])
    for create in (skeleton.CreateJointsAttr, animation.CreateJointsAttr):
        create(list(clip.joints))
    skeleton.CreateRestTransformsAttr(rest)
    skeleton.CreateBindTransformsAttr(rest)
    for frame, time in enumerate(clip.time_codes):
        quaternions = [Gf.Quatf(*map(float, rotation)) for rotation in clip.rotations[frame]]
        animation.CreateRotationsAttr().Set(Vt.QuatfArray(quaternions), time)
        animation.CreateTranslationsAttr().Set(Vt.Vec3fArray.FromNumpy(clip.translations[frame].astype("f4")), time)
        animation.CreateScalesAttr().Set(Vt.Vec3hArray.FromNumpy(clip.scales[frame].astype("f2")), time)
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets(["/Body/Anim"])
    query = UsdSkel.Cache().GetSkelQuery(skeleton)
    return np.array([np.array(query.ComputeJointSkelTransforms(time))[:, 3, :3] for time in clip.time_codes])


@pytest.mark.parametrize("scaled", [False, True])
def test_joints_are_placed_as_usdskel_places_them(scaled):
    clip = make_clip(np.random.default_rng(5), scaled=scaled)
    places = place_joints(clip)
    np.testing.assert_allclose(places, play_clip(clip), atol=1e-6 * np.abs(places).max())


@given(arrays(np.float64, (4, 5, 3), elements=st.floats(-1e3, 1e3)), st.floats(-1e6, 1e6))
def test_packed_places_are_within_half_a_step(places, far):
    moved = places + far * np.arange(4)[:, None, None]
    error = np.abs(unpack_places(pack_places(moved)) - moved)
    middle = moved.mean(axis=1, keepdims=True)
    extent = np.ptp(moved - middle.astype(np.float32), axis=(0, 1))
    single = np.abs(moved).max() * 2.0**-22
    assert (error <= extent / 131070.0 * 1.01 + single + 1e-9).all()


def test_places_far_from_the_origin_stay_exact_to_a_thousandth_of_the_height():
    body = np.random.default_rng(0).uniform(0.0, 170.0, (480, 31, 3))
    body[..., 0] += np.linspace(0.0, 20_000.0, 480)[:, None]
    assert np.abs(unpack_places(pack_places(body)) - body).max() < 0.01


@given(arrays(np.float32, (3, 4), elements=st.floats(-1e6, 1e6, width=32)))
def test_arrays_are_packed_bit_for_bit(values):
    packed = pack_array(values)
    assert packed["dtype"] == "float32"
    np.testing.assert_array_equal(unpack(packed), values)


def test_bones_without_length_or_from_a_far_origin_are_not_drawn():
    skeleton = make_skeleton()
    pose = np.array(skeleton.rest_positions)
    assert len(find_bones(skeleton, pose)) == len(skeleton.joints) - 1
    knee = skeleton.joints.index(LEFT_KNEE)
    pose[knee] = pose[skeleton.parents[knee]]
    arm = skeleton.joints.index(LEFT_ARM)
    pose[arm] += [900.0, 0.0, 0.0]
    drawn = {joint for _, joint in find_bones(skeleton, pose)}
    assert knee not in drawn
    assert arm not in drawn


def test_a_body_is_seen_from_where_it_goes_and_has_two_sides():
    skeleton = make_skeleton()
    places = np.repeat(skeleton.rest_positions[None], 30, axis=0)
    still = describe_body(skeleton, places)
    np.testing.assert_allclose(still.front, [0.0, 0.0, 1.0], atol=1e-6)
    assert still.sides[skeleton.joints.index(LEFT_KNEE)] == "left"
    assert still.sides[skeleton.joints.index(RIGHT_KNEE)] == "right"
    assert still.sides[skeleton.joints.index(HIPS)] == "middle"
    assert still.height == pytest.approx(120.0)
    walking = places + np.linspace(0.0, 400.0, 30)[:, None, None] * np.array([1.0, 0.0, 0.0])
    np.testing.assert_allclose(describe_body(skeleton, walking).front, [1.0, 0.0, 0.0], atol=1e-6)


def test_a_skeleton_with_z_up_has_its_floor_below_its_feet():
    skeleton = make_skeleton()
    turned = np.array(skeleton.rest_positions)[:, [2, 0, 1]]
    upright = Skeleton(joints=skeleton.joints, rest=skeleton.rest, up=np.array([0.0, 0.0, 1.0]))
    body = describe_body(upright, np.repeat(turned[None] + [0.0, 0.0, 500.0], 5, axis=0))
    assert body.floor == pytest.approx(545.0)
    assert abs(body.front[2]) < 1e-9


def test_an_even_turn_has_no_jerk_and_its_step_is_its_largest_turn():
    assert third_difference(turning(5.0)) < 1e-9
    assert largest_turn(turning(5.0)) == pytest.approx(5.0)


def test_jerk_is_the_third_difference_of_the_angle():
    frames = np.arange(10)
    angles = np.radians(0.01) * frames**3
    rotations = quaternion.exp(angles[:, None, None] * np.array([1.0, 0.0, 0.0]))
    # 0.01 * 3! on one of three axes
    assert third_difference(rotations) == pytest.approx(0.06 / np.sqrt(3.0))


def test_energy_is_found_in_the_band_it_is_in():
    wave = 3.0 * np.sin(2.0 * np.pi * 3.4 / RATE * np.arange(480))[:, None]
    inside, below = band_energy(wave, 2, 3), band_energy(wave, 4, 5)
    # the bands overlap: band 1 takes a third of the amplitude
    assert inside > 0.4 * np.square(wave).mean()
    assert below < 0.05 * inside
    assert band_energy(2.0 * wave, 2, 3) == pytest.approx(4.0 * inside)


def test_feet_slide_as_far_as_they_are_moved_over_the_floor():
    skeleton = make_skeleton(oriented=3)
    still = make_clip(np.random.default_rng(0), frames=9)
    clip = replace(
        still,
        rotations=np.repeat(skeleton.rest_rotations[None], 9, axis=0),
        translations=np.repeat(skeleton.rest_translations[None], 9, axis=0),
        skeleton=skeleton,
    )
    foot = Effector(name="left.heel", joint=skeleton.joints.index(LEFT_KNEE), offset=np.zeros(3))
    contact = Contact(effector=foot, first=2, last=6, point=np.zeros(3))
    assert foot_slide(clip, [contact]) == pytest.approx(0.0, abs=1e-9)
    moved = np.array(clip.translations)
    moved[:, 0] += np.arange(9)[:, None] * np.array([1.5, 7.0, 0.0])
    # Three centimetres either way from the middle frame; what is along up does not count.
    assert foot_slide(replace(clip, translations=moved), [contact]) == pytest.approx(3.0)
    assert foot_slide(clip, []) is None


def test_a_take_measured_against_itself_is_as_lively_and_as_smooth(review):
    character = review.characters[0]
    take = character.takes[0]
    alone = replace(character, takes=(take,))
    numbers = Measure(alone).measure(take)
    assert numbers.jerk == pytest.approx(1.0)
    assert numbers.detail == pytest.approx(1.0)
    assert Measure(replace(character, takes=())).measure(take).jerk is None


def test_a_recipe_reads_back_from_its_text(tmp_path):
    recipe = Recipe(
        match=("A.rx", 'odd"name'),
        synthesize=("Spine*",),
        texture_bands=(2, 4),
        match_lower=False,
        path_cost="consecutive",
        path_weight=2.25,
        break_channel="A.rx",
        contacts="detect",
        segments=(
            Segment(name="stomp", start=10.0, end=20.5, match=("B.rx",), match_band=3, scale=True),
            Segment(name="run", start=30.0, end=40.0, texture=()),
        ),
    )
    apis = '"MtexSketchAPI", "MtexSegmentAPI:stomp", "MtexSegmentAPI:run"'
    text = recipe_to_usda(recipe)
    (tmp_path / "a.usda").write_text(
        f'#usda 1.0\ndef SkelAnimation "A" (\n    prepend apiSchemas = [{apis}]\n)\n{{\n{text}\n}}\n'
    )
    stage = Usd.Stage.Open(str(tmp_path / "a.usda"))
    assert read_recipe(stage.GetPrimAtPath("/A")) == recipe


def test_a_recipe_of_defaults_has_no_text():
    assert recipe_to_usda(Recipe()) == ""


def test_every_module_is_in_the_import_map_and_asks_only_for_others_in_it():
    imports = json.loads(read_scripts())["imports"]
    asked = set()
    for name, address in imports.items():
        script = base64.b64decode(address.removeprefix("data:text/javascript;base64,")).decode()
        if name.startswith("mtex/"):
            asked |= set(re.findall(r"""^import [^;]*?["']([^"']+)["'];""", script, re.MULTILINE))
    assert "mtex/main.js" in imports
    assert "three" in asked
    assert asked <= set(imports)


def test_what_is_vendored_is_what_the_readme_says():
    vendor = resources.files("mtex_usd.review") / "static" / "vendor"
    text = (vendor / "README.md").read_text("utf-8")
    stated = dict(re.findall(r"sha256 of `([^`]+)`: `([0-9a-f]{64})`", text))
    assert "three/three.module.min.js" in stated
    for name, digest in stated.items():
        assert hashlib.sha256(vendor.joinpath(*name.split("/")).read_bytes()).hexdigest() == digest
    for folder in vendor.iterdir():
        if folder.is_dir():
            assert (folder / "LICENSE").is_file()
            assert f"{folder.name}/LICENSE" in text


def test_the_sheet_has_the_colours_of_the_page():
    light = read_styles().partition("@media")[0]
    for number, colour in enumerate(VARIANT_COLOURS, start=1):
        assert f"--variant-{number}: {colour};" in light
    assert f"--sketch: {SKETCH_COLOUR};" in light


def test_the_page_is_strict_json_in_one_file(review):
    page = build_page(review)
    text = page.split('id="mtex-data">')[1].split("</script>")[0]
    data = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    assert data["command"] == COMMAND
    (character,) = data["characters"]
    assert [variant["name"] for variant in character["variants"]] == ["path_01", "path_02"]
    places = unpack_places(character["variants"][0]["places"])
    np.testing.assert_allclose(places, place_joints(review.characters[0].variants[0].clip), atol=0.02)
    assert not re.search(r"""(?:src|href)=["'](?!data:|#)""", page.partition("<script")[0])


def test_contacts_are_told_with_their_frames_and_places(review):
    page = build_page(review)
    data = json.loads(page.split('id="mtex-data">')[1].split("</script>")[0])
    variant = review.characters[0].variants[0]
    told = data["characters"][0]["variants"][0]["contacts"]
    assert [(each["first"], each["last"]) for each in told] == [(hold.first, hold.last) for hold in variant.holds]
    up = variant.clip.skeleton.up
    for each, hold in zip(told, variant.holds, strict=True):
        places = unpack(each["places"])
        assert len(places) == hold.last - hold.first + 1
        # held still, to its tolerance of half a millimetre, here in centimetres
        assert np.ptp(places @ up) < 0.11
