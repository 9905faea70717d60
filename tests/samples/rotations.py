"""Just enough quaternion algebra for the samples: arrays [..., 4], real part first, acting on column vectors.

It stands apart from the package on purpose: the bytes of the samples must not follow changes in the code they test.
"""

import numpy as np
import numpy.typing as npt

__all__ = ["about", "align", "compose", "half", "inverse", "rotate", "unroll"]

FloatArray = npt.NDArray[np.float64]


def about(axis: str, degrees: npt.ArrayLike) -> FloatArray:
    """Turn about an axis, "x", "y" or "z"; angles [...] to quaternions [..., 4]."""
    angle = np.radians(np.asarray(degrees, dtype=np.float64)) / 2.0
    out = np.zeros((*angle.shape, 4))
    out[..., 0] = np.cos(angle)
    out[..., 1 + "xyz".index(axis)] = np.sin(angle)
    return out


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    aw, av, bw, bv = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    real = aw * bw - np.sum(av * bv, axis=-1, keepdims=True)
    return np.concatenate([real, aw * bv + bw * av + np.cross(av, bv)], axis=-1)


def compose(*turns: FloatArray) -> FloatArray:
    """Multiply turns; the last is applied first."""
    out = turns[0]
    for turn in turns[1:]:
        out = _product(out, turn)
    return out


def inverse(q: FloatArray) -> FloatArray:
    """Turn back."""
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def rotate(q: FloatArray, v: npt.ArrayLike) -> FloatArray:
    """Rotate vectors [..., 3]."""
    vector = np.asarray(v, dtype=np.float64)
    t = 2.0 * np.cross(q[..., 1:], vector)
    return vector + q[..., :1] * t + np.cross(q[..., 1:], t)


def half(q: FloatArray) -> FloatArray:
    """Half of a turn of less than 180 degrees."""
    middle = np.where(q[..., :1] < 0.0, -q, q) + np.array([1.0, 0.0, 0.0, 0.0])
    return middle / np.linalg.norm(middle, axis=-1, keepdims=True)


def unroll(q: FloatArray) -> FloatArray:
    """Choose signs so that each frame is nearest the one before it, the first with a positive real part; [F, J, 4]."""
    first = np.where(q[:1, :, :1] < 0.0, -1.0, 1.0)
    steps = np.where(np.sum(q[1:] * q[:-1], axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    return q * np.cumprod(np.concatenate([first, steps]), axis=0)


def align(start: FloatArray, end: FloatArray) -> FloatArray:
    """Turn the directions start [..., 3] onto the directions end the shortest way."""
    a = start / np.linalg.norm(start, axis=-1, keepdims=True)
    b = end / np.linalg.norm(end, axis=-1, keepdims=True)
    q = np.concatenate([1.0 + np.sum(a * b, axis=-1, keepdims=True), np.cross(a, b)], axis=-1)
    return q / np.linalg.norm(q, axis=-1, keepdims=True)
