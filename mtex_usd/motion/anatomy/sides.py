"""Which of two like limbs is the left one: what names say, else where the toes point."""

import numpy as np

from mtex_usd.motion.anatomy.branches import Shape, unit
from mtex_usd.motion.anatomy.words import side_of
from mtex_usd.motion.skeleton import FloatArray

__all__ = ["find_left", "order_sides"]

_LEAST_FORWARD = 0.2  # of a bone's length
_ANKLE, _TOES = 2, 3


def find_left(shape: Shape, legs: tuple[list[int], list[int]], *, up: FloatArray) -> FloatArray | None:
    """Give the body's direction to the left.

    Parameters
    ----------
    shape
        The rest pose.
    legs
        The joints of both legs from the hips' outwards.
    up
        From the hips to the chest, any length, shape [3].

    Returns
    -------
    FloatArray or None
        Shape [3]; None where the feet have no toes or they do not point forward.
    """
    if min(map(len, legs)) <= _TOES:
        return None
    upright = unit(up)
    feet = [unit(shape.positions[leg[_TOES]] - shape.positions[leg[_ANKLE]]) for leg in legs]
    forward = np.mean([foot - (foot @ upright) * upright for foot in feet], axis=0)
    return np.cross(upright, forward) if np.linalg.norm(forward) >= _LEAST_FORWARD else None


def order_sides(
    shape: Shape, pair: tuple[list[int], list[int]], left: FloatArray | None
) -> tuple[list[int], list[int]]:
    """Put the left one of two limbs first.

    Parameters
    ----------
    shape
        The rest pose.
    pair
        The joints of both limbs.
    left
        What :func:`find_left` found. None takes the axis on which they are farthest apart to grow to the left, as it
        does on characters that face +Z with Y up or -Y with Z up.
    """
    told = [{side for joint in branch if (side := side_of(shape.tree.names[joint]))} for branch in pair]
    if told in ([{"left"}, {"right"}], [{"right"}, {"left"}]):
        return pair if told[0] == {"left"} else pair[::-1]
    apart = shape.positions[pair[0][0]] - shape.positions[pair[1][0]]
    direction = apart[np.argmax(np.abs(apart))] if left is None else apart @ left
    return pair if direction >= 0.0 else pair[::-1]
