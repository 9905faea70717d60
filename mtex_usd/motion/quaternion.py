"""Unit quaternions as arrays [..., 4], real part first, in double precision.

Products, the logarithm and the mean are written out; Euler angles, matrices and exponentials are scipy's. A quaternion
q acts on column vectors: ``rotate(multiply(a, b), v)`` is ``rotate(a, rotate(b, v))``.
"""

import warnings

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

__all__ = [
    "angle_between",
    "conjugate",
    "exp",
    "from_euler",
    "from_usd_matrix",
    "log",
    "mean",
    "midpoint",
    "multiply",
    "normalize",
    "rotate",
    "to_euler",
    "twist",
    "unroll",
    "unroll_vectors",
]

FloatArray = npt.NDArray[np.float64]

_NO_TURN = 1e-150  # shorter, and squares vanish

# Rotations of less, in radians, have no axis to speak of.
_NO_AXIS = 1e-6


def _rotation(q: FloatArray) -> Rotation:
    return Rotation.from_quat(np.reshape(q, (-1, 4)), scalar_first=True)


def multiply(a: FloatArray, b: FloatArray) -> FloatArray:
    """Compose rotations, b first; shapes [..., 4] broadcast."""
    aw, ax, ay, az = _components(a)
    bw, bx, by, bz = _components(b)
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    out[..., 0] = aw * bw - ax * bx - ay * by - az * bz
    out[..., 1] = aw * bx + ax * bw + ay * bz - az * by
    out[..., 2] = aw * by - ax * bz + ay * bw + az * bx
    out[..., 3] = aw * bz + ax * by - ay * bx + az * bw
    return out


def _components(a: FloatArray) -> list[FloatArray]:
    return [a[..., i] for i in range(a.shape[-1])]


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    # numpy's own handles vectors of any kind on any axis, which takes it several times as long.
    ax, ay, az = _components(a)
    bx, by, bz = _components(b)
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    out[..., 0] = ay * bz - az * by
    out[..., 1] = az * bx - ax * bz
    out[..., 2] = ax * by - ay * bx
    return out


def conjugate(q: FloatArray) -> FloatArray:
    """Invert unit quaternions."""
    return np.asarray(q * np.array([1.0, -1.0, -1.0, -1.0]))


def normalize(q: FloatArray) -> FloatArray:
    """Scale to unit length."""
    return np.asarray(q / _length(q))


def _length(v: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.einsum("...i,...i->...", v, v)))[..., None]


def rotate(q: FloatArray, v: FloatArray) -> FloatArray:
    """Rotate vectors [..., 3] by quaternions [..., 4]."""
    real, axis = q[..., :1], q[..., 1:]
    t = 2.0 * _cross(axis, v)
    return np.asarray(v + real * t + _cross(axis, t))


def from_usd_matrix(m: FloatArray) -> FloatArray:
    """Take the rotations out of USD transforms [..., 4, 4] (row vectors), less scale and mirroring, as UsdSkel does."""
    upper = np.asarray(m, dtype=np.float64)[..., :3, :3]
    mirrored = np.where(np.linalg.det(upper) < 0.0, -1.0, 1.0)[..., None, None]
    rows = mirrored * upper / np.linalg.norm(upper, axis=-1, keepdims=True)
    columns = np.swapaxes(rows, -1, -2).reshape(-1, 3, 3)
    return np.asarray(Rotation.from_matrix(columns).as_quat(scalar_first=True)).reshape(*m.shape[:-2], 4)


def log(q: FloatArray) -> FloatArray:
    """Rotation vectors [..., 3] in radians, at most pi long."""
    # Not scipy's, which takes nine times as long; the half angle's tangent is exact near both ends of its range.
    real, axis = q[..., :1], q[..., 1:]
    sine = _length(axis)
    angle = 2.0 * np.arctan2(sine, np.abs(real))
    factor = np.divide(angle, sine, out=np.full_like(sine, 2.0), where=sine > _NO_TURN)
    return np.asarray(axis * np.where(real < 0.0, -factor, factor))


def exp(v: FloatArray) -> FloatArray:
    """Quaternions [..., 4] of rotation vectors [..., 3] in radians."""
    flat = Rotation.from_rotvec(np.reshape(v, (-1, 3))).as_quat(scalar_first=True)
    return np.asarray(flat).reshape(*v.shape[:-1], 4)


def to_euler(q: FloatArray, order: str) -> FloatArray:
    """Angles [..., 3] in degrees, about the axes x, y, z in that column order, for an intrinsic order such as "ZYX"."""
    with warnings.catch_warnings():
        # At gimbal lock one of the outer angles is scipy's choice, which is as good as any: the rotation is the same.
        warnings.filterwarnings("ignore", message="Gimbal lock")
        angles = np.asarray(_rotation(q).as_euler(order, degrees=True)).reshape(*q.shape[:-1], 3)
    columns = np.empty_like(angles)
    for position, axis in enumerate(order):
        columns[..., "XYZ".index(axis)] = angles[..., position]
    return columns


def from_euler(angles: FloatArray, order: str) -> FloatArray:
    """Quaternions [..., 4] of angles [..., 3] as :func:`to_euler` gives them."""
    ordered = np.stack([angles[..., "XYZ".index(axis)] for axis in order], axis=-1)
    flat = Rotation.from_euler(order, ordered.reshape(-1, 3), degrees=True).as_quat(scalar_first=True)
    return np.asarray(flat).reshape(*angles.shape[:-1], 4)


def unroll(q: FloatArray) -> FloatArray:
    """Choose signs so that consecutive quaternions along the first axis are nearest; shape [F, ..., 4]."""
    if len(q) < 2:
        return q
    dots = np.einsum("...i,...i->...", q[1:], q[:-1])
    if (dots >= 0.0).all():
        return q
    signs = np.cumprod(np.where(dots < 0.0, -1.0, 1.0), axis=0)
    return np.concatenate([q[:1], q[1:] * signs[..., None]], axis=0)


def unroll_vectors(v: FloatArray) -> FloatArray:
    """Choose turns so that consecutive rotation vectors along the first axis are nearest; shape [F, ..., 3]."""
    if _length(np.diff(v, axis=0)).max(initial=0.0) < np.pi:
        return v
    out = np.array(v, dtype=np.float64)
    for i in range(1, len(out)):
        # Near no rotation the axis is lost: a spin goes on about the one it had.
        axis = np.where(_length(v[i]) > _NO_AXIS, _unit(v[i]), _unit(out[i - 1]))
        along = np.sum((out[i - 1] - out[i]) * axis, axis=-1, keepdims=True)
        out[i] += np.round(along / (2.0 * np.pi)) * 2.0 * np.pi * axis
    return out


def _unit(v: FloatArray) -> FloatArray:
    length = _length(v)
    return np.divide(v, length, out=np.zeros_like(v), where=length > _NO_AXIS)


def mean(q: FloatArray) -> FloatArray:
    """Mean rotation over the first axis (chordal L2 mean), real part not negative; shape [F, J, 4] to [J, 4]."""
    joints = np.swapaxes(q, 0, 1)
    _, vectors = np.linalg.eigh(np.swapaxes(joints, 1, 2) @ joints)
    means = vectors[..., -1]
    # Which of the two signs an eigenvector has is up to rounding, and would show in what is written.
    return np.where(means[:, :1] < 0.0, -means, means)


def midpoint(a: FloatArray, b: FloatArray) -> FloatArray:
    """Rotations half way between, the short way round; shapes [..., 4]."""
    nearest = np.where(np.sum(a * b, axis=-1, keepdims=True) < 0.0, -b, b)
    return normalize(a + nearest)


def angle_between(a: FloatArray, b: FloatArray) -> FloatArray:
    """Angle in radians from one rotation to the other; shapes [..., 4] broadcast to [...]."""
    relative = multiply(conjugate(a), b)
    return np.asarray(2.0 * np.arctan2(_length(relative[..., 1:])[..., 0], np.abs(relative[..., 0])))


def twist(q: FloatArray, axis: FloatArray) -> FloatArray:
    """Angle in radians of the part of q that turns about a unit axis, the rest applied first; [..., 4] to [...]."""
    return np.asarray(2.0 * np.arctan2(q[..., 1:] @ axis, q[..., 0]))
