"""Rotation vectors and matrices against scipy's, at all angles from none to a half turn."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mtex_usd.constraints.spacetime.turning import (
    cross_matrix,
    exp_matrix,
    inverse_right_jacobian,
    log_vector,
    right_jacobian,
    to_matrix,
)

ANGLES = [0.0, 1e-12, 1e-6, 0.9e-3, 1.1e-3, 0.1, 1.0, 3.0, np.pi - 1.1e-3, np.pi - 0.9e-3, np.pi - 1e-6, np.pi - 1e-12]


def vectors(angle):
    axes = np.random.default_rng(0).standard_normal((20, 3))
    return angle * axes / np.linalg.norm(axes, axis=1, keepdims=True)


@pytest.mark.parametrize("angle", ANGLES)
def test_exponential_and_logarithm_are_scipys(angle):
    d = vectors(angle)
    expected = Rotation.from_rotvec(d)
    np.testing.assert_allclose(exp_matrix(d), expected.as_matrix(), atol=1e-14)
    np.testing.assert_allclose(to_matrix(expected.as_quat(scalar_first=True)), expected.as_matrix(), atol=1e-14)
    np.testing.assert_allclose(log_vector(expected.as_matrix()), d, atol=1e-9)


@pytest.mark.parametrize("angle", [*ANGLES, 4.0, 6.0])
def test_the_jacobian_is_how_fast_the_rotation_turns(angle):
    d, change = vectors(angle), 1e-6 * vectors(1.0)[::-1]
    turned = Rotation.from_rotvec(d - change).inv() * Rotation.from_rotvec(d + change)
    found = (right_jacobian(d) @ change[:, :, None])[..., 0]
    np.testing.assert_allclose(found, 0.5 * turned.as_rotvec(), atol=1e-14)
    both = inverse_right_jacobian(d) @ right_jacobian(d)
    np.testing.assert_allclose(both, np.broadcast_to(np.eye(3), both.shape), atol=1e-9)


def test_the_cross_product_is_a_matrix():
    a, b = vectors(2.0), vectors(1.0)[::-1]
    np.testing.assert_allclose((cross_matrix(a) @ b[:, :, None])[..., 0], np.cross(a, b), atol=1e-15)
