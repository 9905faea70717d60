"""Joining the fragments of a path into one motion (Pullen & Bregler 2002, section 3.4).

Neighbouring fragments share a frame. They are made to meet half way, each fragment being moved by a displacement that
runs evenly from one end to the other; where they were not consecutive in their take, a quadratic fitted to both sides
is blended in around the join.

Equation 1 is printed as (cos(pi t / 2N) + 1)^2, which is 4 at the join; the text calls it a sine squared. The weight
used is f(t) = cos^2(pi t / 2N): 1 at the join, 0 at distance N, flat at both.

Rotations are not moved as numbers but composed: the displacement is a rotation vector that turns the fragment's own
pose, and the quadratic is fitted in the tangent space of the join's pose. A turn then never gets faster than the
fragment's own plus half the gaps spread over its frames, which a sum of angles could not promise far from the mean
pose.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from mtex_usd.motion import quaternion

__all__ = ["TURN_LIMIT", "blend_weights", "join_curves", "join_rotations"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

# Near a join no joint turns faster than this times what the fragments and their gaps account for.
TURN_LIMIT = 1.2
_LEAST_REACH = 3
_BLEND_STEPS = (1.0, 0.75, 0.5, 0.25)


def blend_weights(reach: int) -> FloatArray:
    """Weight of the quadratic at t = -N..N, shape [2N + 1] (equation 1, misprint mended)."""
    return np.asarray(np.cos(np.pi * np.arange(-reach, reach + 1) / (2 * reach)) ** 2)


def _reach(left: FloatArray, right: FloatArray, join_frames: int) -> int:
    """Frames on either side that the blend changes: as asked, but no more than half the shorter fragment."""
    return min(join_frames, (min(len(left), len(right)) - 1) // 2)


def _fit_quadratic(curves: FloatArray) -> FloatArray:
    """Fit a quadratic to the frames with 2 <= |t| <= N and give it at t = -N..N; curves [..., 2N + 1, C]."""
    return _quadratic_fit(curves.shape[-2] // 2) @ curves


@lru_cache(maxsize=64)
def _quadratic_fit(reach: int) -> FloatArray:
    """The fit as a matrix, shape [2N + 1, 2N + 1]: it is the same for all joins of a reach."""
    t = np.arange(-reach, reach + 1, dtype=np.float64)
    powers = np.vander(t, 3)
    used = np.abs(t) >= 2.0
    fit = np.zeros((len(t), len(t)))
    fit[:, used] = powers @ np.linalg.pinv(powers[used])
    return fit


def join_curves(
    fragments: Sequence[FloatArray], continued: BoolArray, join_frames: int, *, turning: BoolArray, sliding: BoolArray
) -> FloatArray:
    """Join fragments of plain curves.

    Parameters
    ----------
    fragments
        Q arrays of shape [n_q, C]; the last frame of one and the first of the next are the same frame.
    continued
        Whether the two fragments at a join were consecutive in their take, shape [Q - 1].
    join_frames
        N, frames on either side of a join that may change.
    turning
        Columns in degrees that are brought to the nearest turn first, shape [C].
    sliding
        Columns that carry on from where the fragment before ended, whatever their value was (root travel), shape [C].

    Returns
    -------
    FloatArray
        Shape [F, C].
    """
    placed = _place(fragments, turning, sliding)
    meeting = [0.5 * (a[-1] + b[0]) for a, b in itertools.pairwise(placed)]
    firsts, lasts = [placed[0][0], *meeting], [*meeting, placed[-1][-1]]
    moved = [_skew(f, first, last) for f, first, last in zip(placed, firsts, lasts, strict=True)]
    joined = _concatenate(moved)
    join = 0
    for left, right, follows in zip(moved[:-1], moved[1:], continued, strict=True):
        join += len(left) - 1
        reach = _reach(left, right, join_frames)
        if reach >= _LEAST_REACH and not follows:
            window = joined[join - reach : join + reach + 1]
            window += blend_weights(reach)[:, None] * (_fit_quadratic(window) - window)
    return joined


def _place(fragments: Sequence[FloatArray], turning: BoolArray, sliding: BoolArray) -> list[FloatArray]:
    """Shift whole fragments to the nearest turn, or to where the one before ended."""
    placed = [fragments[0]]
    for fragment in fragments[1:]:
        gap = placed[-1][-1] - fragment[0]
        shift = np.where(turning, 360.0 * np.round(gap / 360.0), np.where(sliding, gap, 0.0))
        placed.append(fragment + shift)
    return placed


def _skew(fragment: FloatArray, first: FloatArray, last: FloatArray) -> FloatArray:
    """Subtract the line through the old end points and add the line through the new ones."""
    along = np.linspace(0.0, 1.0, len(fragment))[:, None]
    return np.asarray(fragment + (1.0 - along) * (first - fragment[0]) + along * (last - fragment[-1]))


def _concatenate(fragments: Sequence[FloatArray]) -> FloatArray:
    """Put fragments end to end, shared frames once."""
    return np.concatenate([fragments[0], *(fragment[1:] for fragment in fragments[1:])])


def join_rotations(fragments: Sequence[FloatArray], continued: BoolArray, join_frames: int) -> FloatArray:
    """Join fragments of rotations.

    Parameters
    ----------
    fragments
        Q arrays of quaternions, shape [n_q, J, 4]; neighbours share a frame.
    continued
        Whether the two fragments at a join were consecutive in their take, shape [Q - 1].
    join_frames
        N, frames on either side of a join that may change.

    Returns
    -------
    FloatArray
        Shape [F, J, 4].

    Notes
    -----
    The quadratic is let in only as far as no joint turns faster, within N of the join, than `TURN_LIMIT` times the
    fastest turn of its stretched fragment plus half the gaps at the fragment's two joins spread over its frames.
    """
    strip = _Strip.of_fragments(fragments)
    joined = quaternion.unroll(strip.once(strip.moved))
    pairs = zip(fragments[:-1], fragments[1:], continued, strict=True)
    reaches = np.array([0 if follows else _reach(left, right, join_frames) for left, right, follows in pairs])
    _smooth_joins(joined, strip.lasts[:-1] - np.arange(len(reaches)), reaches, strip.turn_limits())
    return joined


@dataclass(frozen=True, eq=False)
class _Strip:
    """Fragments of rotations end to end, N frames with the shared ones twice, so that all are worked on at once.

    Parameters
    ----------
    frames
        Shape [N, J, 4].
    firsts, lasts
        Where in the strip each fragment begins and ends, shape [Q].
    displacements
        Rotation vectors that take each fragment's first and last frame to where it meets its neighbours,
        shape [2, Q, J, 3].
    """

    frames: FloatArray
    firsts: IntArray
    lasts: IntArray
    displacements: FloatArray

    @classmethod
    def of_fragments(cls, fragments: Sequence[FloatArray]) -> "_Strip":
        frames = np.concatenate(fragments)
        lasts = np.cumsum([len(fragment) for fragment in fragments]) - 1
        firsts = np.concatenate([[0], lasts[:-1] + 1])
        meeting = quaternion.midpoint(frames[lasts[:-1]], frames[firsts[1:]])
        old = np.stack([frames[firsts], frames[lasts]])
        new = np.stack([np.concatenate([frames[:1], meeting]), np.concatenate([meeting, frames[-1:]])])
        return cls(frames, firsts, lasts, quaternion.log(quaternion.multiply(quaternion.conjugate(old), new)))

    @property
    def moved(self) -> FloatArray:
        """Every frame turned by the displacement, running evenly from its fragment's first to its last, [N, J, 4]."""
        lengths = self.lasts - self.firsts
        owner = np.repeat(np.arange(len(lengths)), lengths + 1)
        along = ((np.arange(len(self.frames)) - self.firsts[owner]) / lengths[owner])[:, None, None]
        turns = (1.0 - along) * self.displacements[0, owner] + along * self.displacements[1, owner]
        return quaternion.multiply(self.frames, quaternion.exp(turns))

    def turn_limits(self) -> FloatArray:
        """Fastest turn allowed in each fragment per joint, radians per frame, shape [Q, J]."""
        speeds = quaternion.angle_between(self.frames[:-1], self.frames[1:])
        speeds[self.lasts[:-1]] = 0.0  # from one fragment to the next
        fastest = np.maximum.reduceat(speeds, self.firsts, axis=0)
        half_gaps = np.linalg.norm(self.displacements, axis=-1).sum(axis=0)
        return np.asarray(TURN_LIMIT * (fastest + half_gaps / (self.lasts - self.firsts)[:, None]))

    def once(self, frames: FloatArray) -> FloatArray:
        """Drop the second of each two frames that are shared, [N, ...] to [F, ...]."""
        return np.delete(frames, self.firsts[1:], axis=0)


def _smooth_joins(joined: FloatArray, frames: IntArray, reaches: IntArray, limits: FloatArray) -> None:
    """Smooth in place around the joins at some frames, those of one reach at once; limits per fragment, [Q, J]."""
    for reach in np.unique(reaches[reaches >= _LEAST_REACH]):
        which = np.flatnonzero(reaches == reach)
        windows = frames[which, None] + np.arange(-reach, reach + 1)
        limit = np.repeat(np.stack([limits[which], limits[which + 1]], axis=-1), reach, axis=-1)
        rows = np.swapaxes(joined[windows], 1, 2)
        smooth = _blend_quadratic(rows.reshape(-1, *rows.shape[2:]), limit.reshape(-1, 2 * reach))
        joined[windows] = np.swapaxes(smooth.reshape(rows.shape), 1, 2)


def _blend_quadratic(windows: FloatArray, limit: FloatArray) -> FloatArray:
    """Blend the quadratic into the frames around joins as far as turns stay below limits; [M, 2N + 1, 4], [M, 2N]."""
    reach = windows.shape[1] // 2
    centre = windows[:, reach : reach + 1]
    curves = quaternion.log(quaternion.multiply(quaternion.conjugate(centre), windows))
    change = blend_weights(reach)[:, None] * (_fit_quadratic(curves) - curves)
    result, left = np.array(windows), np.arange(len(windows))
    for part in _BLEND_STEPS:
        smooth = quaternion.multiply(centre[left], quaternion.exp(curves[left] + part * change[left]))
        fits = (quaternion.angle_between(smooth[:, :-1], smooth[:, 1:]) <= limit[left]).all(axis=1)
        result[left[fits]] = smooth[fits]
        left = left[~fits]
        if left.size == 0:
            break
    return result
