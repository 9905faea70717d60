"""The centre of mass and what it may stand on."""

from collections.abc import Sequence

import numpy as np

from mtex_usd.constraints.spacetime.character import find_root
from mtex_usd.constraints.spacetime.samples import Handle
from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import FloatArray

__all__ = ["find_support_sides", "mass_handle"]

_IN_LINE = 1e-9  # of the area's width squared


def mass_handle(clip: Clip, masses: Sequence[float] | None, number: int) -> Handle:
    """Give the centre of mass as a weighted sum of joints.

    Parameters
    ----------
    clip
        The character.
    masses
        What each joint counts, length J; None to give each bone a mass as its mean length, half at either end.
    number
        Which character it is.

    Raises
    ------
    InputError
        Where the masses are not one per joint, negative, or all zero.
    """
    weights = bone_masses(clip) if masses is None else np.asarray(masses, dtype=np.float64)
    if weights.shape != (len(clip.joints),) or not (weights >= 0.0).all() or not weights.sum() > 0.0:
        raise InputError(
            f"bad masses for clip {clip.name}",
            expected=f"{len(clip.joints)} numbers, none negative, not all zero",
            found=str(weights.shape),
        )
    joints = np.flatnonzero(weights)
    shares = weights[joints] / weights.sum()
    return Handle(number, tuple(joints.tolist()), tuple(shares.tolist()), ((0.0, 0.0, 0.0),) * len(joints))


def bone_masses(clip: Clip) -> FloatArray:
    """Mass of each joint when every bone weighs as its mean length over time, half at either end, [J]."""
    lengths = np.sqrt(np.einsum("fji,fji->fj", clip.translations, clip.translations)).mean(axis=0)
    out, root = np.zeros(len(clip.joints)), find_root(clip)
    for joint, parent in enumerate(clip.parents):
        if parent >= 0 and joint != root:
            out[[joint, parent]] += 0.5 * lengths[joint]
    return out


def find_support_sides(corners: FloatArray, up: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """Find the sides of the horizontal hull of corners.

    Parameters
    ----------
    corners
        [V, 3].
    up
        Unit vector, [3].

    Returns
    -------
    tuple of FloatArray or None
        Outward unit normals [M, 3] and the coordinate of each side along its own, [M]; None where there is no area.
    """
    if corners.ndim != 2 or corners.shape[1] != 3 or len(corners) < 3:
        return None
    first = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    first /= np.sqrt(first @ first)
    plane = np.stack([first, np.cross(up, first)])
    hull = _hull(corners @ plane.T)
    if len(hull) < 3:
        return None
    along = np.roll(hull, -1, axis=0) - hull
    outward = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(along[:, 0], along[:, 1])[:, None]
    return outward @ plane, np.einsum("mi,mi->m", outward, hull)


def _hull(points: FloatArray) -> FloatArray:
    """Corners of the convex hull of points [V, 2], counter-clockwise (Andrew's monotone chain)."""
    ordered = points[np.lexsort((points[:, 1], points[:, 0]))]
    least = _IN_LINE * float(np.ptp(points, axis=0).max()) ** 2
    return np.array(_half_hull(ordered, least)[:-1] + _half_hull(ordered[::-1], least)[:-1])


def _half_hull(ordered: FloatArray, least: float) -> list[FloatArray]:
    chain: list[FloatArray] = []
    for point in ordered:
        while len(chain) > 1 and _area(chain[-2], chain[-1], point) <= least:
            chain.pop()
        chain.append(point)
    return chain


def _area(a: FloatArray, b: FloatArray, c: FloatArray) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
