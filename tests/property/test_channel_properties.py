"""Laws of reading joints as channels, on rigs with any joint orientations."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import (
    choose_euler_order,
    to_local_rotations,
    to_local_translations,
    to_skeleton_rotations,
    to_skeleton_translations,
    unrolled_angles,
)
from tests.oracle import channels as twin
from tests.synthetic import JOINTS, LEFT_LEG, RIGHT_KNEE, make_skeleton, random_rotations

SEEDS = st.integers(0, 2**32 - 1)
ANGLES = st.floats(-89.0, 89.0)
ORDERS = st.sampled_from(["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"])


def same_rotation(a, b, atol=1e-9):
    np.testing.assert_allclose(np.abs(np.sum(a * b, axis=-1)), 1.0, atol=atol)


@given(SEEDS)
def test_equals_the_matrices_of_the_definition(seed):
    rng = np.random.default_rng(seed)
    skeleton = make_skeleton(oriented=seed)
    local = random_rotations(rng, 1, len(JOINTS))
    found = to_skeleton_rotations(local, skeleton)[0]
    for joint in (0, 4, 10):
        expected = twin.in_skeleton_axes(local[0, joint], joint, skeleton.parents, skeleton.rest_rotations)
        np.testing.assert_allclose(twin.matrix_of(found[joint]), expected, atol=1e-9)


@given(SEEDS, ANGLES, st.sampled_from([0, 1, 2]), st.sampled_from([LEFT_LEG, RIGHT_KNEE, "Hips"]))
def test_turning_a_joint_about_an_axis_of_the_skeleton_is_one_channel(seed, angle, axis, joint):
    """On every rig: the limb is turned in skeleton space, by its world rotation."""
    skeleton = make_skeleton(oriented=seed)
    index = JOINTS.index(joint)
    turn = quaternion.exp(np.radians(angle) * np.eye(3)[axis])
    world = np.array(skeleton.rest_orientations)
    world[index] = quaternion.multiply(turn, world[index])
    local = np.array(skeleton.rest_rotations)
    parent = skeleton.parents[index]
    above = quaternion.conjugate(world[parent]) if parent >= 0 else np.array([1.0, 0.0, 0.0, 0.0])
    local[index] = quaternion.multiply(above, world[index])
    read = quaternion.to_euler(to_skeleton_rotations(local[None], skeleton)[0], "ZYX")
    expected = np.zeros((len(JOINTS), 3))
    expected[index, axis] = angle
    np.testing.assert_allclose(read, expected, atol=1e-5)


@given(SEEDS)
def test_both_ways_round(seed):
    rng = np.random.default_rng(seed)
    skeleton = make_skeleton(oriented=seed)
    rotations = random_rotations(rng, 3, len(JOINTS))
    offsets = rng.standard_normal((3, len(JOINTS), 3))
    same_rotation(to_local_rotations(to_skeleton_rotations(rotations, skeleton), skeleton), rotations)
    back = to_local_translations(to_skeleton_translations(offsets, skeleton), skeleton)
    np.testing.assert_allclose(back, offsets, atol=1e-9)


@given(SEEDS)
def test_rest_reads_as_zero(seed):
    skeleton = make_skeleton(oriented=seed)
    same_rotation(to_skeleton_rotations(skeleton.rest_rotations[None], skeleton), np.array([1.0, 0.0, 0.0, 0.0]))
    np.testing.assert_allclose(to_skeleton_translations(skeleton.rest_translations[None], skeleton), 0.0, atol=1e-9)


@given(SEEDS)
def test_translations_are_read_along_the_skeletons_axes(seed):
    """With everything above it at rest a joint moves in the world as its channels say."""
    rng = np.random.default_rng(seed)
    skeleton = make_skeleton(oriented=seed)
    wanted = np.zeros((1, len(JOINTS), 3))
    wanted[0, 4] = rng.standard_normal(3)
    positions, _ = skeleton.world_pose(skeleton.rest_rotations[None], to_local_translations(wanted, skeleton))
    at_rest, _ = skeleton.world_pose(skeleton.rest_rotations, skeleton.rest_translations)
    np.testing.assert_allclose(positions[0, 4] - at_rest[4], wanted[0, 4], atol=1e-9)


@given(SEEDS, ORDERS, st.floats(0.01, 1.4), st.integers(2, 80))
def test_unrolled_angles_reproduce_the_rotation(seed, order, speed, frames):
    rng = np.random.default_rng(seed)
    turns = quaternion.exp(np.cumsum(speed * rng.standard_normal((frames, 3)), axis=0))
    same_rotation(quaternion.from_euler(unrolled_angles(turns, order), order), turns)


@given(SEEDS, ORDERS, st.integers(2, 120))
def test_unrolled_angles_are_continuous(seed, order, frames):
    """Away from gimbal lock slow motion has slow angles, however many turns it makes."""
    rng = np.random.default_rng(seed)
    outer, inner = (np.cumsum(rng.uniform(-25.0, 25.0, size=frames)) for _ in range(2))
    middle = 60.0 * np.sin(np.cumsum(rng.uniform(0.0, 0.2, size=frames)))
    angles = np.empty((frames, 3))
    for letter, curve in zip(order, (outer, middle, inner), strict=True):
        angles[:, "XYZ".index(letter)] = curve
    unrolled = unrolled_angles(quaternion.from_euler(angles, order), order)
    np.testing.assert_allclose(np.diff(unrolled, axis=0), np.diff(angles, axis=0), atol=1e-6)


@given(SEEDS, st.floats(80.0, 100.0), ORDERS)
def test_passing_through_gimbal_lock_stays_continuous(seed, greatest, order):
    """The middle angle swings past 90 degrees: the other triple of the same rotation would jump by 180."""
    middle = greatest * np.sin(np.linspace(0.0, 6.0, 200))
    angles = np.empty((200, 3))
    phase = np.random.default_rng(seed).uniform(0.0, 6.0)
    curves = (20.0 * np.sin(np.linspace(0.0, 3.0, 200) + phase), middle, np.linspace(0.0, 30.0, 200))
    for letter, curve in zip(order, curves, strict=True):
        angles[:, "XYZ".index(letter)] = curve
    turns = quaternion.from_euler(angles, order)
    unrolled = unrolled_angles(turns, order)
    same_rotation(quaternion.from_euler(unrolled, order), turns, atol=1e-7)
    assert np.abs(np.diff(unrolled, axis=0)).max() < 45.0


@given(SEEDS, ANGLES.filter(lambda angle: abs(angle) > 1.0), st.sampled_from("XYZ"))
def test_the_order_stays_clear_of_gimbal_lock_where_one_can(seed, angle, axis):
    """Motion mostly about one axis, with small angles about the others: no middle angle nears 90."""
    rng = np.random.default_rng(seed)
    small = np.radians(rng.uniform(-10.0, 10.0, size=(50, 3)))
    small[:, "XYZ".index(axis)] = np.radians(np.linspace(-2.0, 2.0, 50) * angle)
    turns = quaternion.exp(small)
    order = choose_euler_order(turns)
    middle = quaternion.to_euler(turns, order)[:, "XYZ".index(order[1])]
    assert np.abs(middle).max() < 75.0


@given(SEEDS, st.sampled_from("XYZ"))
def test_the_outermost_axis_is_as_asked(seed, axis):
    turns = random_rotations(np.random.default_rng(seed), 20)
    order = choose_euler_order(turns, outermost=axis)
    assert order[0] == axis
    assert sorted(order) == ["X", "Y", "Z"]
