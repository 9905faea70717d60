"""Rotation vectors as matrices, and how fast they turn.

Conventions: matrices act on column vectors; a rotation that is displaced reads ``R0 @ exp(d)``, so a change of the
rotation vector `d` turns it, in its own axes, at ``right_jacobian(d) @ change``.
"""

import numpy as np

from mtex_usd.motion.skeleton import FloatArray

__all__ = ["cross_matrix", "exp_matrix", "inverse_right_jacobian", "log_vector", "right_jacobian", "to_matrix"]

_SMALL = 1e-3  # radians: below, the series are exact to rounding and the closed forms are not
_NEARLY_HALF_TURN = 1e-3  # radians short of pi: there the matrix no longer tells the axis by its antisymmetric part


def cross_matrix(v: FloatArray) -> FloatArray:
    """Matrices [..., 3, 3] whose product with a vector is the cross product with `v` [..., 3]."""
    out = np.zeros((*v.shape, 3))
    out[..., 0, 1], out[..., 1, 2], out[..., 2, 0] = -v[..., 2], -v[..., 0], -v[..., 1]
    out[..., 1, 0], out[..., 2, 1], out[..., 0, 2] = v[..., 2], v[..., 0], v[..., 1]
    return out


def to_matrix(q: FloatArray) -> FloatArray:
    """Rotation matrices [..., 3, 3] of unit quaternions [..., 4], real first."""
    w, x, y, z = (q[..., i] for i in range(4))
    out = np.empty((*q.shape[:-1], 3, 3))
    out[..., 0, 0] = 1.0 - 2.0 * (y * y + z * z)
    out[..., 1, 1] = 1.0 - 2.0 * (x * x + z * z)
    out[..., 2, 2] = 1.0 - 2.0 * (x * x + y * y)
    out[..., 0, 1], out[..., 1, 0] = 2.0 * (x * y - w * z), 2.0 * (x * y + w * z)
    out[..., 0, 2], out[..., 2, 0] = 2.0 * (x * z + w * y), 2.0 * (x * z - w * y)
    out[..., 1, 2], out[..., 2, 1] = 2.0 * (y * z - w * x), 2.0 * (y * z + w * x)
    return out


def exp_matrix(d: FloatArray) -> FloatArray:
    """Rotation matrices [..., 3, 3] of rotation vectors [..., 3] in radians."""
    square = _square(d)
    angle = np.sqrt(square)
    one = np.where(angle > _SMALL, np.sin(angle) / _safe(angle), 1.0 - square / 6.0)
    return _polynomial(d, one, _cosine_part(angle, square), square)


def right_jacobian(d: FloatArray) -> FloatArray:
    """Matrices [..., 3, 3] from changes of rotation vectors [..., 3] to turns in the rotated axes."""
    square = _square(d)
    angle = np.sqrt(square)
    cube = _safe(angle) ** 3
    two = np.where(angle > _SMALL, (angle - np.sin(angle)) / cube, 1.0 / 6.0 - square / 120.0)
    return _polynomial(d, -_cosine_part(angle, square), two, square)


def inverse_right_jacobian(d: FloatArray) -> FloatArray:
    """Inverse of :func:`right_jacobian`, for vectors shorter than a whole turn."""
    square = _square(d)
    angle = np.sqrt(square)
    half = _safe(0.5 * angle)
    closed = (1.0 - half * np.cos(half) / np.sin(half)) / _safe(angle) ** 2
    two = np.where(angle > _SMALL, closed, 1.0 / 12.0 + square / 720.0)
    return _polynomial(d, np.full_like(square, 0.5), two, square)


def log_vector(m: FloatArray) -> FloatArray:
    """Rotation vectors [..., 3], at most pi long, of rotation matrices [..., 3, 3]."""
    antisymmetric = 0.5 * np.stack(
        [m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]], axis=-1
    )
    sine = np.sqrt(_square(antisymmetric))
    angle = np.arctan2(sine, 0.5 * (np.trace(m, axis1=-2, axis2=-1) - 1.0))
    factor = np.where(sine > _SMALL**2, angle / _safe(sine), 1.0)
    out = factor[..., None] * antisymmetric
    turned = angle > np.pi - _NEARLY_HALF_TURN
    if turned.any():
        out[turned] = angle[turned][..., None] * _half_turn_axis(m[turned], antisymmetric[turned])
    return np.asarray(out)


def _half_turn_axis(m: FloatArray, antisymmetric: FloatArray) -> FloatArray:
    """Unit axes [N, 3] of turns of about pi, from the symmetric part of matrices [N, 3, 3]."""
    cosine = 0.5 * (np.trace(m, axis1=-2, axis2=-1) - 1.0)
    symmetric = 0.5 * (m + np.swapaxes(m, -1, -2)) - cosine[:, None, None] * np.eye(3)
    longest = np.argmax(np.diagonal(symmetric, axis1=-2, axis2=-1), axis=-1)
    axis = np.take_along_axis(symmetric, longest[:, None, None], axis=-1)[..., 0]
    axis /= np.sqrt(_square(axis))[:, None]
    sign = np.where(np.sum(axis * antisymmetric, axis=-1) < 0.0, -1.0, 1.0)
    return np.asarray(axis * sign[:, None])


def _square(d: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("...i,...i->...", d, d))


def _safe(angle: FloatArray) -> FloatArray:
    return np.maximum(angle, _SMALL**2)


def _cosine_part(angle: FloatArray, square: FloatArray) -> FloatArray:
    """(1 - cos) / angle²; by the half angle, which cancels nothing."""
    return np.where(angle > _SMALL, 2.0 * (np.sin(0.5 * angle) / _safe(angle)) ** 2, 0.5 - square / 24.0)


def _polynomial(d: FloatArray, one: FloatArray, two: FloatArray, square: FloatArray) -> FloatArray:
    """I + one [d] + two [d]², with [d]² = d dᵀ - |d|² I."""
    out = one[..., None, None] * cross_matrix(d)
    out += (two[..., None] * d)[..., :, None] * d[..., None, :]
    diagonal = np.einsum("...ii->...i", out)
    diagonal += (1.0 - two * square)[..., None]
    return np.asarray(out)
