"""Sketches: what an animator blocks, few keys on few joints, smoothly interpolated.

The poses come from the same walks and phrases as the takes, without their noise, at another pace; only every fifth
frame is kept as a key (six keys a stride, the same for left and right) and the frames between are a cubic through the
keys with the slope tools call "smooth": the mean slope to the keys before and after.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tests.samples.contacts import Motion
from tests.samples.rotations import unroll

__all__ = ["KEY_STEP", "SKETCHED", "block"]

FloatArray = npt.NDArray[np.float64]

KEY_STEP = 5
SKETCHED = ("Hips", "LeftUpLeg", "LeftLeg", "LeftFoot", "RightUpLeg", "RightLeg", "RightFoot")


@dataclass(frozen=True, kw_only=True)
class _Keys:
    """Which frames are keys [K], and the weights that turn key values into all frames [F, K]."""

    frames: npt.NDArray[np.intp]
    weights: FloatArray


def _slopes(times: FloatArray) -> FloatArray:
    """Slopes at the keys as weights of the key values, shape [K, K]; straight at both ends."""
    slopes = np.zeros((len(times), len(times)))
    for k in range(1, len(times) - 1):
        span = times[k + 1] - times[k - 1]
        slopes[k, k + 1], slopes[k, k - 1] = 1.0 / span, -1.0 / span
    slopes[0, :2] = np.array([-1.0, 1.0]) / (times[1] - times[0])
    slopes[-1, -2:] = np.array([-1.0, 1.0]) / (times[-1] - times[-2])
    return slopes


def _keys(frames: int) -> _Keys:
    keys = np.unique(np.append(np.arange(0, frames, KEY_STEP), frames - 1))
    at = np.arange(frames, dtype=np.float64)
    left = np.clip(np.searchsorted(keys, at, side="right") - 1, 0, len(keys) - 2)
    width = (keys[left + 1] - keys[left]).astype(np.float64)
    x = ((at - keys[left]) / width)[:, None]
    values, slopes = np.eye(len(keys)), _slopes(keys.astype(np.float64))
    weights = (
        (1.0 + 2.0 * x) * (1.0 - x) ** 2 * values[left]
        + x**2 * (3.0 - 2.0 * x) * values[left + 1]
        + width[:, None] * (x * (1.0 - x) ** 2 * slopes[left] - x**2 * (1.0 - x) * slopes[left + 1])
    )
    return _Keys(frames=keys, weights=weights)


def block(motion: Motion) -> Motion:
    """Keep every fifth frame of a motion as keys and interpolate between them."""
    keys = _keys(len(motion.root))
    rotations = np.einsum("fk,kjc->fjc", keys.weights, unroll(motion.rotations)[keys.frames])
    rotations /= np.linalg.norm(rotations, axis=-1, keepdims=True)
    return Motion(rotations=rotations, root=keys.weights @ motion.root[keys.frames])
