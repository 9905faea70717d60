"""Rotations, against known turns."""

import numpy as np
import pytest

from mtex_usd.motion import quaternion

HALF = np.sqrt(0.5)
IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


def test_the_second_factor_acts_first():
    about_x, about_y = np.array([HALF, HALF, 0.0, 0.0]), np.array([HALF, 0.0, HALF, 0.0])
    both = quaternion.multiply(about_x, about_y)
    np.testing.assert_allclose(quaternion.rotate(both, np.array([0.0, 0.0, 1.0])), [1.0, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(quaternion.rotate(both, np.array([1.0, 0.0, 0.0])), [0.0, 1.0, 0.0], atol=1e-15)


def test_a_quarter_turn_about_z():
    turn = quaternion.exp(np.array([0.0, 0.0, 0.5 * np.pi]))
    np.testing.assert_allclose(turn, [HALF, 0.0, 0.0, HALF])
    np.testing.assert_allclose(quaternion.rotate(turn, np.array([1.0, 0.0, 0.0])), [0.0, 1.0, 0.0], atol=1e-15)


def test_small_angles_keep_their_digits():
    tiny = np.array([3e-9, -2e-9, 1e-9])
    np.testing.assert_allclose(quaternion.log(quaternion.exp(tiny)), tiny, rtol=1e-9)
    assert quaternion.angle_between(IDENTITY, quaternion.exp(tiny)) == pytest.approx(np.linalg.norm(tiny), rel=1e-9)


def test_shapes_broadcast():
    assert quaternion.multiply(IDENTITY, np.tile(IDENTITY, (3, 2, 1))).shape == (3, 2, 4)
    assert quaternion.log(np.tile(IDENTITY, (3, 2, 1))).shape == (3, 2, 3)
    assert quaternion.to_euler(np.tile(IDENTITY, (3, 2, 1)), "ZYX").shape == (3, 2, 3)
    assert quaternion.exp(np.zeros((0, 5, 3))).shape == (0, 5, 4)


def test_euler_columns_are_x_y_z_whatever_the_order():
    turn = quaternion.exp(np.radians([0.0, 0.0, 40.0]))
    for order in ("XYZ", "ZYX", "YZX"):
        np.testing.assert_allclose(quaternion.to_euler(turn, order), [0.0, 0.0, 40.0], atol=1e-12)


def test_unrolling_no_frame_and_one_frame():
    assert quaternion.unroll(np.empty((0, 4))).shape == (0, 4)
    np.testing.assert_array_equal(quaternion.unroll(-IDENTITY[None]), -IDENTITY[None])


def usd_matrix(rows, translation=(1.0, 2.0, 3.0)):
    matrix = np.eye(4)
    matrix[:3, :3] = rows
    matrix[3, :3] = translation
    return matrix


QUARTER_ABOUT_Z = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]


def test_a_usd_matrix_has_the_turned_axes_as_rows():
    np.testing.assert_allclose(quaternion.from_usd_matrix(usd_matrix(QUARTER_ABOUT_Z)), [HALF, 0.0, 0.0, HALF])


def test_scale_and_mirroring_are_left_out():
    scaled = np.array(QUARTER_ABOUT_Z) * [[2.0], [3.0], [0.5]]
    np.testing.assert_allclose(quaternion.from_usd_matrix(usd_matrix(scaled)), [HALF, 0.0, 0.0, HALF])
    np.testing.assert_allclose(
        quaternion.from_usd_matrix(usd_matrix(-np.array(QUARTER_ABOUT_Z))), [HALF, 0.0, 0.0, HALF]
    )


def test_mean_of_no_joints():
    assert quaternion.mean(np.empty((5, 0, 4))).shape == (0, 4)


def test_the_mean_does_not_see_signs():
    turns = quaternion.exp(np.radians([[[10.0, 0.0, 0.0]], [[20.0, 0.0, 0.0]], [[30.0, 0.0, 0.0]]]))
    signs = np.array([1.0, -1.0, 1.0])[:, None, None]
    assert quaternion.angle_between(quaternion.mean(signs * turns), turns[1]).max() < 1e-7


def test_midpoint_goes_the_short_way():
    a, b = quaternion.exp(np.radians([[170.0, 0.0, 0.0], [-170.0, 0.0, 0.0]]))
    np.testing.assert_allclose(np.abs(quaternion.midpoint(a, b)), [0.0, 1.0, 0.0, 0.0], atol=1e-12)


def test_rotation_vectors_under_half_a_turn_apart_stay_as_they_are():
    vectors = np.random.default_rng(0).standard_normal((10, 2, 3)) * 0.3
    assert quaternion.unroll_vectors(vectors) is vectors


@pytest.mark.parametrize("per_frame", [30.0, 45.0, -60.0])
def test_a_spin_goes_on_through_the_rest_pose(per_frame):
    """At whole turns the rotation is none and its axis is lost; the count of turns must not be."""
    degrees = per_frame * np.arange(50)
    spin = np.radians(degrees)[:, None, None] * np.array([0.0, 1.0, 0.0])
    unrolled = quaternion.unroll_vectors(quaternion.log(quaternion.exp(spin)))
    np.testing.assert_allclose(np.degrees(unrolled[:, 0, 1]), degrees, atol=1e-6)
