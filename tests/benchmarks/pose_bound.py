"""How many poses any method needs: a lower bound on keys of piecewise slerp with free values.

Keys are common to all joints, so between two keys each joint plays one slerp, and every frame from the one key to the
other has to be within the tolerance of it. How far a single slerp can reach from a frame, whatever its ends, is
therefore the longest a stretch between keys can be; going as far as possible each time gives the fewest stretches.
The bound does not ask that stretches meet at the keys, nor that places or the times between frames are right, so the
truth is never below it.

Near a frame in the middle a slerp is a straight line of rotation vectors (to 0.3 % over what a stretch turns, which is
allowed for). That no line comes near enough is shown by weights: with any weights that add up to 1, the least weighted
mean square is no more than the square of the least largest error (Lawson's algorithm finds weights that make it equal).
"""

import numpy as np
import numpy.typing as npt

from mtex_usd.motion import quaternion

__all__ = ["can_be_one_slerp", "count_needed_poses", "find_reach"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]
BoolArray = npt.NDArray[np.bool_]

_ALLOWANCE = 1.003
_ROUNDS = 60
_LEAST_WEIGHT = 1e-9


def can_be_one_slerp(rotations: FloatArray, degrees: float) -> BoolArray:
    """Tell which stretches [N, L, 4] some slerp may follow within so many degrees; false is certain."""
    middle = quaternion.conjugate(rotations[:, rotations.shape[1] // 2, None])
    vectors = np.degrees(quaternion.log(quaternion.multiply(middle, rotations)))
    times = np.linspace(-1.0, 1.0, vectors.shape[1])
    weights = np.full(vectors.shape[:2], 1.0 / vectors.shape[1])
    possible, open_ones = np.ones(len(vectors), dtype=np.bool_), np.arange(len(vectors))
    for _ in range(_ROUNDS):
        errors = _fit_lines(vectors[open_ones], weights[open_ones], times)
        mean = np.sqrt(np.sum(weights[open_ones] * np.square(errors), axis=1))
        possible[open_ones[mean > degrees * _ALLOWANCE]] = False
        fitted = weights[open_ones] * (errors + _LEAST_WEIGHT)
        weights[open_ones] = fitted / fitted.sum(axis=1, keepdims=True)
        open_ones = open_ones[(mean <= degrees * _ALLOWANCE) & (errors.max(axis=1) > degrees)]
        if not open_ones.size:
            break
    return possible


def _fit_lines(vectors: FloatArray, weights: FloatArray, times: FloatArray) -> FloatArray:
    """Distances of vectors [N, L, 3] from their weighted least-squares lines, [N, L]; weights add up to 1."""
    centres = weights @ times
    offsets = times - centres[:, None]
    means = np.einsum("nl,nli->ni", weights, vectors)
    slopes = np.einsum("nl,nli->ni", weights * offsets, vectors)
    slopes /= np.maximum(np.sum(weights * np.square(offsets), axis=1), np.finfo(np.float64).tiny)[:, None]
    way = vectors - means[:, None] - offsets[..., None] * slopes[:, None]
    return np.asarray(np.sqrt(np.einsum("nli,nli->nl", way, way)))


def find_reach(rotations: FloatArray, degrees: float) -> IntArray:
    """How many frames a stretch from each frame on can reach at most, with all joints [F, J, 4], shape [F]."""
    frames, unrolled = len(rotations), quaternion.unroll(rotations)
    reach = np.minimum(1, frames - 1 - np.arange(frames))
    starts = np.arange(frames)
    for length in range(2, frames):
        starts = starts[starts + length < frames]
        for joint in range(rotations.shape[1]):
            stretches = unrolled[starts[:, None] + np.arange(length + 1), joint]
            starts = starts[can_be_one_slerp(stretches, degrees)]
        if not starts.size:
            break
        reach[starts] = length
    return reach


def count_needed_poses(rotations: FloatArray, degrees: float) -> int:
    """The fewest keys with which slerps can be within so many degrees of all joints, [F, J, 4]; never too many."""
    reach, frame, count = find_reach(rotations, degrees), 0, 1
    while frame < len(rotations) - 1:
        frame, count = frame + int(reach[frame]), count + 1
    return count
