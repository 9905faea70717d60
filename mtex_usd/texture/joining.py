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

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

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
        Columns that carry on from where the fragment before ended, whatever their value was (the root's way along the
        ground), shape [C].

    Returns
    -------
    FloatArray
        Shape [F, C].
    """
    strip = _Strip.of_fragments(fragments)
    frames = _place(strip, np.concatenate(fragments), turning, sliding)
    meeting = 0.5 * (frames[strip.lasts[:-1]] + frames[strip.firsts[1:]])
    # Subtract the line through the old end points and add the line through the new ones.
    joined = strip.once(frames + strip.spread(strip.meet(frames, meeting) - strip.ends(frames)))
    for _, windows in strip.smoothed(continued, join_frames):
        rows = joined[windows]
        joined[windows] = rows + blend_weights(windows.shape[1] // 2)[:, None] * (_fit_quadratic(rows) - rows)
    return joined


def _place(strip: "_Strip", frames: FloatArray, turning: BoolArray, sliding: BoolArray) -> FloatArray:
    """Shift whole fragments to the nearest turn, or to where the one before ended."""
    gaps = frames[strip.lasts[:-1]] - frames[strip.firsts[1:]]
    steps = np.where(turning, 360.0 * np.round(gaps / 360.0), np.where(sliding, gaps, 0.0))
    shifts = np.concatenate([np.zeros((1, frames.shape[1])), np.cumsum(steps, axis=0)])
    return np.asarray(frames + shifts[strip.owner])


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
    strip, frames = _Strip.of_fragments(fragments), np.concatenate(fragments)
    meeting = quaternion.midpoint(frames[strip.lasts[:-1]], frames[strip.firsts[1:]])
    old, new = strip.ends(frames), strip.meet(frames, meeting)
    displacements = quaternion.log(quaternion.multiply(quaternion.conjugate(old), new))
    moved = quaternion.multiply(frames, quaternion.exp(strip.spread(displacements)))
    joined = quaternion.unroll(strip.once(moved))
    limits = _turn_limits(strip, frames, displacements)
    for joins, windows in strip.smoothed(continued, join_frames):
        limit = np.stack([limits[joins], limits[joins + 1]], axis=-1)
        rows = np.swapaxes(joined[windows], 1, 2)
        smooth = _blend_quadratic(rows.reshape(-1, *rows.shape[2:]), limit.reshape(-1, 2))
        joined[windows] = np.swapaxes(smooth.reshape(rows.shape), 1, 2)
    return joined


@dataclass(frozen=True, eq=False)
class _Strip:
    """Where fragments lie end to end, N frames with the shared ones twice, so that all are worked on at once.

    Parameters
    ----------
    firsts, lasts
        First and last frame of each fragment, shape [Q].
    """

    firsts: IntArray
    lasts: IntArray

    @classmethod
    def of_fragments(cls, fragments: Sequence[FloatArray]) -> "_Strip":
        lasts = np.cumsum([len(fragment) for fragment in fragments]) - 1
        return cls(np.concatenate([[0], lasts[:-1] + 1]), lasts)

    @cached_property
    def owner(self) -> IntArray:
        """Which fragment each frame is of, shape [N]."""
        return np.repeat(np.arange(len(self.firsts)), self.lasts - self.firsts + 1)

    def ends(self, frames: FloatArray) -> FloatArray:
        """First and last frame of each fragment, [N, ...] to [2, Q, ...]."""
        return np.stack([frames[self.firsts], frames[self.lasts]])

    def meet(self, frames: FloatArray, meeting: FloatArray) -> FloatArray:
        """What the ends become where neighbours meet, [Q - 1, ...]; the strip's own two ends stay, [2, Q, ...]."""
        return np.stack([np.concatenate([frames[:1], meeting]), np.concatenate([meeting, frames[-1:]])])

    def spread(self, ends: FloatArray) -> FloatArray:
        """Run evenly from what each fragment begins with to what it ends with, [2, Q, ...] to [N, ...]."""
        at = np.arange(len(self.owner)) - self.firsts[self.owner]
        along = (at / (self.lasts - self.firsts)[self.owner]).reshape(-1, *[1] * (ends.ndim - 2))
        return np.asarray((1.0 - along) * ends[0, self.owner] + along * ends[1, self.owner])

    def once(self, frames: FloatArray) -> FloatArray:
        """Drop the second of each two frames that are shared, [N, ...] to [F, ...]."""
        return np.delete(frames, self.firsts[1:], axis=0)

    def smoothed(self, continued: BoolArray, join_frames: int) -> Iterator[tuple[IntArray, IntArray]]:
        """Give the joins to smooth [n], those of one reach at a time, with their windows of frames [n, 2N + 1].

        The reach is as asked, but no more than half the shorter fragment.
        """
        lengths = self.lasts - self.firsts
        reaches = np.minimum(np.minimum(lengths[:-1], lengths[1:]) // 2, join_frames)
        reaches = np.where(continued, 0, reaches)
        for reach in np.unique(reaches[reaches >= _LEAST_REACH]):
            joins = np.flatnonzero(reaches == reach)
            yield joins, (self.lasts[joins] - joins)[:, None] + np.arange(-reach, reach + 1)


def _turn_limits(strip: _Strip, frames: FloatArray, displacements: FloatArray) -> FloatArray:
    """Fastest turn allowed in each fragment per joint, radians per frame, shape [Q, J]."""
    speeds = quaternion.angle_between(frames[:-1], frames[1:])
    speeds[strip.lasts[:-1]] = 0.0  # from one fragment to the next
    fastest = np.maximum.reduceat(speeds, strip.firsts, axis=0)
    half_gaps = np.linalg.norm(displacements, axis=-1).sum(axis=0)
    return np.asarray(TURN_LIMIT * (fastest + half_gaps / (strip.lasts - strip.firsts)[:, None]))


def _blend_quadratic(windows: FloatArray, limit: FloatArray) -> FloatArray:
    """Blend the quadratic into the frames around joins as far as turns stay below limits.

    Windows of M joints, shape [M, 2N + 1, 4], and what limits their turns before and after the join, shape [M, 2].
    """
    reach = windows.shape[1] // 2
    limit = np.repeat(limit, reach, axis=1)
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
