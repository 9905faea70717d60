"""How far two motions are apart, measured joint by joint."""

import numpy as np
import numpy.typing as npt

from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip

__all__ = ["measure_difference"]

FloatArray = npt.NDArray[np.float64]


def measure_difference(a: Clip, b: Clip, places: FloatArray | None = None) -> tuple[FloatArray, FloatArray]:
    """Measure how far the joints of two clips are apart.

    Parameters
    ----------
    a, b
        Clips of one skeleton with as many frames.
    places
        Joint positions of b in skeleton space, [F, J, 3], where they are known.

    Returns
    -------
    tuple of FloatArray
        Angles between the rotations of joints, degrees, and distances of their places in skeleton space, metres, both
        [F, J].
    """
    angles = np.degrees(quaternion.angle_between(a.rotations, b.rotations))
    if places is None:
        places, _ = b.skeleton.world_pose(b.rotations, b.translations)
    apart = a.skeleton.world_pose(a.rotations, a.translations)[0] - places
    distances = np.sqrt(np.einsum("...i,...i->...", apart, apart))
    return np.asarray(angles), np.asarray(distances * a.skeleton.meters_per_unit)
