"""Which stretches of a motion one slerp can follow, and the cheapest way through a motion by such stretches.

A stretch between two keys plays as one slerp of every joint, so it is possible only where every joint has a slerp near
it, whatever its ends are. Through possible stretches the shortest path with a price for every key gives few keys; the
price of a stretch says how little is left of the tolerance, for neighbours have to meet at the keys. Those that then do
not fit after all are made dearer, and the path is sought again.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from mtex_usd.motion import quaternion

__all__ = ["Stretches", "measure_stretches"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

_EVERY_LENGTH = 16  # frames; longer stretches are tried in steps of a sixth
_LOOKED_AT = 17  # frames of long stretches
_ROUNDS = 12
_EASY = 0.5  # of the tolerance: not looked at more closely
_STEEPNESS = 6
_RAISE = 0.5
_RAISE_MORE = 3.0  # the farther it is off


@dataclass(frozen=True, eq=False)
class Stretches:
    """Stretches from every frame on.

    Parameters
    ----------
    lengths
        Lengths that are tried, frames, shape [N].
    prices
        What a stretch of each length costs that begins at each frame, infinite where it is not possible, shape [N, F].
    """

    lengths: IntArray
    prices: FloatArray

    def find_path(self, key_price: float) -> IntArray:
        """Find the cheapest keys from the first frame to the last, shape [K].

        Parameters
        ----------
        key_price
            What every key costs.
        """
        frames = self.prices.shape[1]
        arriving = np.full((frames, len(self.lengths)), np.inf)
        for number, length in enumerate(self.lengths.tolist()):
            arriving[length:, number] = self.prices[number, : frames - length] + key_price
        total, chosen = np.zeros(frames), np.zeros(frames, dtype=np.intp)
        for frame in range(1, frames):
            usable = int(np.searchsorted(self.lengths, frame, side="right"))
            cost = total[frame - self.lengths[:usable]] + arriving[frame, :usable]
            chosen[frame] = np.argmin(cost)
            total[frame] = cost[chosen[frame]]
        path = [frames - 1]
        while path[-1] > 0:
            path.append(path[-1] - int(self.lengths[chosen[path[-1]]]))
        return np.array(path[::-1], dtype=np.intp)

    def raise_prices(self, path: IntArray, passed: FloatArray) -> None:
        """Make those stretches of a path dearer that do not fit, in place.

        Parameters
        ----------
        path
            The keys.
        passed
            How many times the tolerance is passed at every frame, shape [F].
        """
        for start, end in pairwise(path.tolist()):
            worst = float(passed[start : end + 1].max())
            if worst > 1.0 and end - start > 1:
                number = int(np.searchsorted(self.lengths, end - start))
                self.prices[number, start] += _RAISE + _RAISE_MORE * (worst - 1.0)


def measure_stretches(rotations: FloatArray, radians: float, fixed: Sequence[int]) -> Stretches:
    """Price the stretches of a motion.

    Parameters
    ----------
    rotations
        Of the joints that count, shape [F, J, 4].
    radians
        Largest angle that is allowed.
    fixed
        Frames that are keys.
    """
    frames, unrolled = len(rotations), _sort_joints(quaternion.unroll(rotations))
    is_fixed = np.zeros(frames, dtype=np.intp)
    is_fixed[list(fixed)] = 1
    before = np.cumsum(is_fixed)
    lengths, prices = [1], [np.where(np.arange(frames) < frames - 1, 0.0, np.inf)]
    starts = np.arange(frames)
    while starts.size and lengths[-1] < frames - 1:
        length = min(lengths[-1] + max(1, (lengths[-1] + 2) // 6 if lengths[-1] >= _EVERY_LENGTH else 1), frames - 1)
        starts = starts[starts + length < frames]
        starts = starts[before[starts + length - 1] == before[starts]]
        starts, costs = _price(unrolled, starts, length, radians)
        lengths.append(length)
        prices.append(np.full(frames, np.inf))
        prices[-1][starts] = costs
    return Stretches(np.array(lengths, dtype=np.intp), np.array(prices))


def _sort_joints(rotations: FloatArray) -> FloatArray:
    """Put the joints first that shake most: they decide soonest. Gives [J, F, 4], less what does not move."""
    if len(rotations) < 3:
        return np.empty((0, *rotations.shape[::2]))
    shaking = np.abs(np.diff(rotations, n=2, axis=0)).sum(axis=(0, 2))
    order = np.argsort(-shaking, kind="stable")
    return np.ascontiguousarray(np.swapaxes(rotations[:, order[shaking[order] > 0.0]], 0, 1))


def _price(rotations: FloatArray, starts: IntArray, length: int, radians: float) -> tuple[IntArray, FloatArray]:
    """Price stretches of one length; gives those that are possible, and their prices."""
    offsets = np.unique(np.round(np.linspace(0, length, min(length + 1, _LOOKED_AT))).astype(np.intp))
    costs = np.zeros(len(starts))
    for joint in rotations:
        if not starts.size:
            break
        ratios = _fit_stretches(joint[starts[:, None] + offsets], offsets / length, radians)
        possible = ratios <= 1.0
        starts, costs = starts[possible], costs[possible] + ratios[possible] ** _STEEPNESS
    return starts, costs


def _fit_stretches(rotations: FloatArray, parts: FloatArray, radians: float) -> FloatArray:
    """How many times the allowed angle the best slerps are off stretches [N, L, 4] at parts [L], shape [N]."""
    weights = np.ones(rotations.shape[:2])
    best, least = _weighted_errors(rotations, weights, parts, radians)
    errors, open_ones = best, np.arange(len(rotations))
    best = best.max(axis=1)
    for _ in range(_ROUNDS):
        # No slerp is nearer than the least weighted mean: what is above the tolerance there stays above.
        going = (errors.max(axis=1) > _EASY) & (least <= 1.0)
        if len(parts) < 3 or not going.any():
            break
        open_ones, errors = open_ones[going], errors[going]
        weights[open_ones] *= errors
        errors, least = _weighted_errors(rotations[open_ones], weights[open_ones], parts, radians)
        best[open_ones] = np.minimum(best[open_ones], errors.max(axis=1))
    return np.asarray(best)


def _weighted_errors(
    rotations: FloatArray, weights: FloatArray, parts: FloatArray, radians: float
) -> tuple[FloatArray, FloatArray]:
    """Errors of weighted least-squares slerps, in parts of the angle allowed, [N, L], and their weighted means, [N]."""
    shares = weights / weights.sum(axis=1, keepdims=True)
    centres = shares @ parts
    offsets = parts - centres[:, None]
    means = np.einsum("nl,nli->ni", shares, rotations)
    spread = np.maximum(np.einsum("nl,nl->n", shares, np.square(offsets)), np.finfo(np.float64).tiny)
    slopes = np.einsum("nl,nli->ni", shares * offsets, rotations) / spread[:, None]
    way = rotations - means[:, None] - offsets[..., None] * slopes[:, None]
    # A line of quaternions leaves the sphere, which a slerp does not: only what is off along the sphere counts.
    outward = np.einsum("nli,nli->nl", way, rotations)
    squares = np.maximum(np.einsum("nli,nli->nl", way, way) - np.square(outward), 0.0) * (2.0 / radians) ** 2
    return np.sqrt(squares), np.sqrt(np.einsum("nl,nl->n", shares, squares))
