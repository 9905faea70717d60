"""Where joints are, as UsdSkel has them: scales count, and a joint's scale moves all below it."""

import numpy as np
import numpy.typing as npt

from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip

__all__ = ["place_joints"]

FloatArray = npt.NDArray[np.float64]


def place_joints(clip: Clip) -> FloatArray:
    """Give the positions of all joints at every frame.

    Parameters
    ----------
    clip
        Any motion.

    Returns
    -------
    FloatArray
        Skeleton space, skeleton units, shape [F, J, 3]: the last rows of UsdSkel's joint transforms.
    """
    if (clip.scales == 1.0).all():
        positions, _ = clip.skeleton.world_pose(clip.rotations, clip.translations)
        return positions
    # Rows are where the joint's axes point, as in USD's matrices: local to the joint first, then through the parent's.
    axes = quaternion.rotate(clip.rotations[..., None, :], np.eye(3)) * clip.scales[..., None]
    positions = np.array(clip.translations)
    for joint, parent in enumerate(clip.parents):
        if parent >= 0:
            positions[:, joint] = positions[:, parent] + _through(positions[:, joint, None], axes[:, parent])[:, 0]
            axes[:, joint] = _through(axes[:, joint], axes[:, parent])
    return positions


def _through(rows: FloatArray, axes: FloatArray) -> FloatArray:
    return np.asarray(rows @ axes)
