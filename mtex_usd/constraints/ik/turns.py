"""Small rotations as vectors: what the solver needs of the calculus of rotations."""

import numpy as np
import numpy.typing as npt

from mtex_usd.motion import quaternion

__all__ = ["inverse_left_jacobian", "shortest_turn", "square_curvature", "turn_about"]

FloatArray = npt.NDArray[np.float64]

_SMALL = 1e-4  # radians: below, series are more exact than the closed form
_OPPOSITE = 1e-8  # of 1 + cosine: nearer to opposite, the shortest turn's axis is lost


def inverse_left_jacobian(v: FloatArray) -> FloatArray:
    """Give how a rotation vector changes per small turn applied after it.

    Parameters
    ----------
    v
        Rotation vectors, radians, at most half a turn long, shape [..., 3].

    Returns
    -------
    FloatArray
        Shape [..., 3, 3]: log(exp(w) exp(v)) is v + this @ w, to first order in w.
    """
    across, along = _half_angle_terms(v)
    outer = v[..., :, None] * v[..., None, :]
    return np.asarray(across * np.eye(3) + along * outer - 0.5 * _cross_matrix(v))


def square_curvature(v: FloatArray) -> FloatArray:
    """Give the second derivative of half the squared angle of a rotation, by small turns applied after it.

    Parameters
    ----------
    v
        Rotation vectors, radians, at most half a turn long, shape [..., 3].

    Returns
    -------
    FloatArray
        Shape [..., 3, 3]; the first derivative is the vector itself. Along the axis it is 1, across it x cot x with x
        half the angle.
    """
    across, along = _half_angle_terms(v)
    return np.asarray(across * np.eye(3) + along * v[..., :, None] * v[..., None, :])


def _half_angle_terms(v: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give x cot x and (1 - x cot x) / 4 x^2 with x half the length, both [..., 1, 1]."""
    angle = np.linalg.norm(v, axis=-1)[..., None, None]
    half = 0.5 * np.maximum(angle, _SMALL)
    across = half / np.tan(half)
    along = (1.0 - across) / np.square(2.0 * half)
    return np.where(angle < _SMALL, 1.0, across), np.where(angle < _SMALL, 1.0 / 12.0, along)


def _cross_matrix(v: FloatArray) -> FloatArray:
    """Give the matrices [..., 3, 3] that multiply like the cross product with vectors [..., 3]."""
    out = np.zeros((*v.shape, 3))
    out[..., 2, 1], out[..., 0, 2], out[..., 1, 0] = v[..., 0], v[..., 1], v[..., 2]
    return out - np.swapaxes(out, -1, -2)


def turn_about(axes: FloatArray, angles: FloatArray) -> FloatArray:
    """Give quaternions [..., 4] of turns about unit axes [..., 3] by angles [...] in radians."""
    half = 0.5 * angles[..., None]
    return np.concatenate([np.cos(half), np.sin(half) * axes], axis=-1)


def shortest_turn(a: FloatArray, b: FloatArray, across: FloatArray) -> FloatArray:
    """Give the shortest turns that take directions to directions.

    Parameters
    ----------
    a, b
        Unit vectors, shape [..., 3].
    across
        Unit vectors roughly across `a`, shape [..., 3]: what to turn about where `b` is opposite to `a`.

    Returns
    -------
    FloatArray
        Quaternions [..., 4] q with rotate(q, a) = b; exactly none where a equals b.
    """
    cosines = 1.0 + np.sum(a * b, axis=-1, keepdims=True)
    turns = np.concatenate([cosines, np.cross(a, b)], axis=-1)
    axes = across - np.sum(across * a, axis=-1, keepdims=True) * a
    half_turns = np.concatenate([np.zeros_like(cosines), axes], axis=-1)
    return quaternion.normalize(np.where(cosines < _OPPOSITE, half_turns, turns))
