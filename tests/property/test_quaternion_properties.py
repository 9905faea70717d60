"""Laws of rotations."""

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from mtex_usd.motion import quaternion
from tests.oracle import channels as twin
from tests.synthetic import random_rotations

SEEDS = st.integers(0, 2**32 - 1)
ORDERS = st.sampled_from(["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"])


def two(seed):
    return random_rotations(np.random.default_rng(seed), 2, 5)


@given(SEEDS)
def test_composing_is_multiplying_matrices(seed):
    a, b = two(seed)
    for one, other, product in zip(a, b, quaternion.multiply(a, b), strict=True):
        expected = twin.product(twin.matrix_of(one), twin.matrix_of(other))
        np.testing.assert_allclose(twin.matrix_of(product), expected, atol=1e-12)


@given(SEEDS)
def test_rotating_is_applying_the_matrix(seed):
    a, _ = two(seed)
    v = np.random.default_rng(seed + 1).standard_normal((5, 3))
    expected = [np.array(twin.matrix_of(q)) @ vector for q, vector in zip(a, v, strict=True)]
    np.testing.assert_allclose(quaternion.rotate(a, v), expected, atol=1e-12)


@given(SEEDS)
def test_conjugate_undoes(seed):
    a, _ = two(seed)
    np.testing.assert_allclose(
        quaternion.multiply(a, quaternion.conjugate(a)), np.tile([1.0, 0.0, 0.0, 0.0], (5, 1)), atol=1e-12
    )


@given(SEEDS)
def test_exp_undoes_log(seed):
    a, _ = two(seed)
    vectors = quaternion.log(a)
    assert np.linalg.norm(vectors, axis=-1).max() <= np.pi + 1e-12
    np.testing.assert_allclose(np.abs(np.sum(quaternion.exp(vectors) * a, axis=-1)), 1.0, atol=1e-12)


@given(SEEDS, ORDERS)
def test_euler_angles_go_round_and_mean_what_the_order_says(seed, order):
    a, _ = two(seed)
    angles = quaternion.to_euler(a, order)
    np.testing.assert_allclose(np.abs(np.sum(quaternion.from_euler(angles, order) * a, axis=-1)), 1.0, atol=1e-9)
    for q, triple in zip(a, angles.tolist(), strict=True):
        np.testing.assert_allclose(twin.matrix_of(q), twin.from_angles(triple, order), atol=1e-9)


@given(SEEDS)
def test_midpoint_is_as_far_from_both(seed):
    a, b = two(seed)
    whole = quaternion.angle_between(a, b)
    assume(whole.max() < np.pi - 1e-6)
    middle = quaternion.midpoint(a, b)
    np.testing.assert_allclose(quaternion.angle_between(a, middle), 0.5 * whole, atol=1e-7)
    np.testing.assert_allclose(quaternion.angle_between(b, middle), 0.5 * whole, atol=1e-7)


@given(SEEDS)
def test_the_angle_between_is_the_least_turn_and_does_not_see_signs(seed):
    a, b = two(seed)
    turn = np.linalg.norm(quaternion.log(quaternion.multiply(quaternion.conjugate(a), b)), axis=-1)
    np.testing.assert_allclose(quaternion.angle_between(a, b), turn, atol=1e-7)
    np.testing.assert_allclose(quaternion.angle_between(a, -b), turn, atol=1e-7)


@given(SEEDS, st.integers(1, 30))
def test_unrolling_chooses_the_nearest_signs_and_keeps_the_rotations(seed, frames):
    rng = np.random.default_rng(seed)
    turns = random_rotations(rng, frames, 3)
    unrolled = quaternion.unroll(turns)
    assert np.all(np.sum(unrolled[1:] * unrolled[:-1], axis=-1) >= 0.0)
    np.testing.assert_array_equal(np.abs(unrolled), np.abs(turns))
    np.testing.assert_array_equal(unrolled[0], turns[0])


@given(SEEDS, st.floats(-1.2, 1.2), st.integers(2, 60))
def test_rotation_vectors_of_a_spin_go_on_through_whole_turns(seed, step, frames):
    axis = np.random.default_rng(seed).standard_normal(3)
    angles = step * np.arange(frames)
    spin = angles[:, None, None] * (axis / np.linalg.norm(axis))
    unrolled = quaternion.unroll_vectors(quaternion.log(quaternion.exp(spin)))
    np.testing.assert_allclose(unrolled, spin, atol=1e-6)


@given(SEEDS, st.integers(1, 40))
def test_the_mean_lies_in_the_middle(seed, frames):
    """Of rotations and their mirror images about a pose the mean is that pose."""
    rng = np.random.default_rng(seed)
    pose, vectors = random_rotations(rng, 2), 0.6 * rng.standard_normal((frames, 2, 3))
    both = np.concatenate([quaternion.exp(vectors), quaternion.exp(-vectors)])
    mean = quaternion.mean(quaternion.multiply(pose, both))
    assume(np.linalg.norm(vectors, axis=-1).max() < 1.5)
    assert quaternion.angle_between(mean, pose).max() < 1e-6


@given(SEEDS, st.floats(-3.1, 3.1))
def test_the_twist_is_the_turn_applied_last(seed, angle):
    rng = np.random.default_rng(seed)
    axis = rng.standard_normal(3)
    axis /= np.linalg.norm(axis)
    across = np.cross(axis, rng.standard_normal(3))
    tilt = quaternion.exp(across * 0.3)
    turned = quaternion.multiply(quaternion.exp(angle * axis), tilt)
    np.testing.assert_allclose(np.sin(quaternion.twist(turned, axis)), np.sin(angle), atol=1e-9)
    np.testing.assert_allclose(np.cos(quaternion.twist(turned, axis)), np.cos(angle), atol=1e-9)
