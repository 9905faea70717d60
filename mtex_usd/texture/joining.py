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

import numpy as np
import numpy.typing as npt

from mtex_usd.motion import quaternion

__all__ = ["TURN_LIMIT", "blend_weights", "join_curves", "join_rotations"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

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


def _fit_quadratic(curves: FloatArray, reach: int) -> FloatArray:
    """Fit a quadratic to the frames with 2 <= |t| <= N and give it at t = -N..N; curves [2N + 1, C]."""
    t = np.arange(-reach, reach + 1, dtype=np.float64)
    powers = np.vander(t, 3)
    used = np.abs(t) >= 2.0
    return np.asarray(powers @ np.linalg.lstsq(powers[used], curves[used], rcond=None)[0])


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
            window += blend_weights(reach)[:, None] * (_fit_quadratic(window, reach) - window)
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
    meeting = [quaternion.midpoint(a[-1], b[0]) for a, b in itertools.pairwise(fragments)]
    firsts, lasts = [fragments[0][0], *meeting], [*meeting, fragments[-1][-1]]
    displacements = [_end_turns(f, a, b) for f, a, b in zip(fragments, firsts, lasts, strict=True)]
    moved = [_turn_ends(f, d) for f, d in zip(fragments, displacements, strict=True)]
    limits = [_turn_limit(f, d) for f, d in zip(fragments, displacements, strict=True)]
    joined = quaternion.unroll(_concatenate(moved))
    join = 0
    for number, follows in enumerate(continued):
        left, right = moved[number], moved[number + 1]
        join += len(left) - 1
        reach = _reach(left, right, join_frames)
        if reach >= _LEAST_REACH and not follows:
            window = slice(join - reach, join + reach + 1)
            joined[window] = _smooth_join(joined[window], reach, limits[number], limits[number + 1])
    return joined


def _end_turns(fragment: FloatArray, first: FloatArray, last: FloatArray) -> FloatArray:
    """Rotation vectors that take the fragment's ends to the new ones, shape [2, J, 3]."""
    old = fragment[[0, -1]]
    return quaternion.log(quaternion.multiply(quaternion.conjugate(old), np.stack([first, last])))


def _turn_ends(fragment: FloatArray, displacement: FloatArray) -> FloatArray:
    """Turn every frame by the displacement, running evenly from the first end's to the last end's."""
    if not displacement.any():
        return fragment
    along = np.linspace(0.0, 1.0, len(fragment))[:, None, None]
    turns = (1.0 - along) * displacement[0] + along * displacement[1]
    return quaternion.multiply(fragment, quaternion.exp(turns))


def _turn_limit(fragment: FloatArray, displacement: FloatArray) -> FloatArray:
    """Fastest turn allowed per joint, radians per frame, shape [J]."""
    fastest = quaternion.angle_between(fragment[:-1], fragment[1:]).max(axis=0)
    half_gaps = np.linalg.norm(displacement, axis=-1).sum(axis=0)
    return np.asarray(TURN_LIMIT * (fastest + half_gaps / (len(fragment) - 1)))


def _smooth_join(window: FloatArray, reach: int, left_limit: FloatArray, right_limit: FloatArray) -> FloatArray:
    """Blend the quadratic into the frames around a join; window [2N + 1, J, 4]."""
    centre = window[reach]
    curves = quaternion.log(quaternion.multiply(quaternion.conjugate(centre), window))
    fitted = _fit_quadratic(curves.reshape(len(window), -1), reach).reshape(curves.shape)
    change = blend_weights(reach)[:, None, None] * (fitted - curves)
    limit = np.concatenate([np.tile(left_limit, (reach, 1)), np.tile(right_limit, (reach, 1))])
    result, open_joints = np.array(window), np.arange(window.shape[1])
    for part in _BLEND_STEPS:
        turns = quaternion.exp(curves[:, open_joints] + part * change[:, open_joints])
        smooth = quaternion.multiply(centre[open_joints], turns)
        speeds = quaternion.angle_between(smooth[:-1], smooth[1:])
        fits = (speeds <= limit[:, open_joints]).all(axis=0)
        result[:, open_joints[fits]] = smooth[:, fits]
        open_joints = open_joints[~fits]
        if open_joints.size == 0:
            break
    return result
