"""Turns about coordinate axes, as motion files list them."""

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from mtex_usd.motion import quaternion

__all__ = ["compose_fixed", "turn_about"]

FloatArray = npt.NDArray[np.float64]


def turn_about(axis: int, degrees: FloatArray) -> FloatArray:
    """Give quaternions of turns about a coordinate axis.

    Parameters
    ----------
    axis
        0, 1 or 2 for x, y or z.
    degrees
        Angles, shape [...].

    Returns
    -------
    FloatArray
        Real part first, shape [..., 4].
    """
    half = np.radians(degrees) / 2.0
    turn = np.zeros((*half.shape, 4))
    turn[..., 0] = np.cos(half)
    turn[..., 1 + axis] = np.sin(half)
    return turn


def compose_fixed(axes: Iterable[str], degrees: Iterable[FloatArray], *, frame_count: int) -> FloatArray:
    """Compose turns about fixed axes, the first one listed applied first.

    Parameters
    ----------
    axes
        ``"x"``, ``"y"`` or ``"z"`` for each turn.
    degrees
        Angles of each turn, shape [F].
    frame_count
        F.

    Returns
    -------
    FloatArray
        Real part first, shape [F, 4].
    """
    rotation = np.zeros((frame_count, 4))
    rotation[:, 0] = 1.0
    for axis, angles in zip(axes, degrees, strict=True):
        rotation = quaternion.multiply(turn_about("xyz".index(axis), angles), rotation)
    return rotation
