"""The space copied motion is blended in: what is a vector, what an angle, and the way back onto the sketch."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.motion import quaternion
from mtex_usd.texture.reading import read_sketch
from mtex_usd.texture.recipe import Recipe, Segment
from mtex_usd.texture.roles import resolve_roles
from mtex_usd.texture.space import Space, choose_orders
from tests.synthetic import HIPS, JOINTS, LEFT_ARM, SPINE, make_clip, make_skeleton, walk

MATCH = ("LeftUpLeg.rx",)
ARM = JOINTS.index(LEFT_ARM)


def space_of(recipe, clip):
    roles = resolve_roles(recipe, clip, ())
    space = Space.of_roles(roles, 0, {})
    joints = sorted({channel.joint for channel in space.single if channel.is_rotation})
    motion = read_sketch(clip, 0, 4)
    orders = choose_orders(joints, [motion], 0)
    return Space(0, space.whole, space.single, orders, space.means).centred_on([motion]), motion


def names(channels):
    return [channel.name(JOINTS).rpartition("/")[2] for channel in channels]


def test_three_rotations_with_one_role_are_one_vector():
    space, _ = space_of(Recipe(match=MATCH, synthesize=("LeftArm", "Spine.rx", "Hips.t")), walk(40))
    assert space.whole == (ARM,)
    assert names(space.single) == ["Hips.tx", "Hips.ty", "Hips.tz", "Spine.rx"]
    assert space.turning.tolist() == [False, False, False, True]
    assert space.sliding.tolist() == [True, True, True, False]
    assert names(space.channels)[:3] == ["LeftArm.rx", "LeftArm.ry", "LeftArm.rz"]


@pytest.mark.parametrize(
    "recipe",
    [
        Recipe(match=MATCH, synthesize=("LeftArm.rx", "LeftArm.ry"), texture=("LeftArm.rz",)),
        Recipe(
            match=MATCH,
            synthesize=("LeftArm",),
            segments=(Segment(name="a", start=9, end=20, synthesize=("LeftArm.rx",)),),
        ),
    ],
    ids=["two roles", "another role for a while"],
)
def test_rotations_that_do_not_share_their_roles_are_angles(recipe):
    space, _ = space_of(recipe, walk(40))
    assert space.whole == ()
    assert names(space.single) == ["LeftArm.rx", "LeftArm.ry", "LeftArm.rz"]


def test_a_joint_textured_for_a_while_and_then_synthesized_is_still_a_vector():
    segment = Segment(name="a", start=9, end=20, synthesize=(), texture=("LeftArm",))
    space, _ = space_of(Recipe(match=MATCH, synthesize=("LeftArm",), segments=(segment,)), walk(40))
    assert space.whole == (ARM,)


MIXED = Recipe(match=MATCH, synthesize=("LeftArm", "Spine.rx", "Hips.t", "Hips.r"), texture=("*ForeArm.rz",))


@pytest.mark.parametrize("oriented", [None, 2])
def test_there_and_back_onto_the_sketch(oriented):
    clip = walk(60, heading=np.linspace(0.0, 80.0, 60), skeleton=make_skeleton(oriented=oriented))
    space, motion = space_of(MIXED, clip)
    copied = space.from_curves(space.to_curves(space.read(motion)))
    result = space.apply(copied, motion)
    assert quaternion.angle_between(result.rotations, clip.rotations).max() < 1e-7
    np.testing.assert_allclose(result.translations, clip.translations, atol=1e-9)


def test_vectors_are_about_the_mean():
    space, motion = space_of(MIXED, walk(60))
    vectors = space.to_curves(space.read(motion))[:, :3]
    assert np.abs(vectors.mean(axis=0)).max() < 1.0


def test_vectors_count_on_through_whole_turns():
    """A joint that spins in the copied motion has no jump to join over."""
    degrees = np.arange(0.0, 800.0, 20.0)
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (len(degrees), len(JOINTS), 1))
    turns[:, ARM] = quaternion.exp(np.radians(degrees)[:, None] * np.array([0.0, 1.0, 0.0]))
    clip = make_clip(make_skeleton(), 24.0, turns, np.zeros((len(degrees), 3)))
    space, motion = space_of(Recipe(match=MATCH, synthesize=("LeftArm",)), clip)
    vectors = space.to_curves(space.read(motion))[:, :3]
    np.testing.assert_allclose(np.linalg.norm(np.diff(vectors, axis=0), axis=1), 20.0, atol=1e-4)


def test_the_roots_angles_turn_about_up_last():
    clip = walk(40, heading=30.0)
    orders = choose_orders([0, JOINTS.index(SPINE)], [read_sketch(clip, 0, 4)], 0)
    assert orders[0][0] == "Y"
    assert JOINTS[0] == HIPS


def test_columns_that_change_change_only_their_joint():
    clip = walk(40, skeleton=make_skeleton(oriented=5))
    space, motion = space_of(Recipe(match=MATCH, synthesize=("LeftArm",)), clip)
    copied = space.from_curves(space.to_curves(space.read(motion)) + 10.0)
    result = space.apply(copied, motion)
    others = [joint for joint in range(len(JOINTS)) if joint != ARM]
    np.testing.assert_array_equal(result.rotations[:, others], clip.rotations[:, others])
    assert quaternion.angle_between(result.rotations[:, ARM], clip.rotations[:, ARM]).min() > 0.1


def test_the_signs_of_what_is_copied_do_not_matter():
    """Either quaternion of a rotation may come; the result runs on without a jump of sign."""
    clip = walk(40, skeleton=make_skeleton(oriented=5))
    space, motion = space_of(Recipe(match=MATCH, synthesize=("LeftArm",)), clip)
    copied = space.read(motion)
    signs = np.random.default_rng(0).choice([-1.0, 1.0], size=(40, 1, 1))
    result = space.apply(replace(copied, rotations=signs * copied.rotations), motion)
    assert np.all(np.sum(result.rotations[1:] * result.rotations[:-1], axis=-1) > 0.0)
    assert quaternion.angle_between(result.rotations, clip.rotations).max() < 1e-7
