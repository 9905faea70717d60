"""Two motions brought into step by dynamic time warping (Gleicher 2000, 1.6.2.2, 1.6.4; Bruderlin & Williams 1995)."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.ndimage import uniform_filter1d

from mtex_usd.edit.curve_space import choose_order, select_channels
from mtex_usd.edit.dynamic_warping import WarpingPath, find_path
from mtex_usd.edit.pose_features import check_pair, common_joints, pose_positions
from mtex_usd.edit.warping import TimeWarp
from mtex_usd.errors import InputError
from mtex_usd.motion.arguments import as_number, as_tokens, as_whole_number
from mtex_usd.motion.channels import to_skeleton_rotations, to_skeleton_translations, unrolled_angles
from mtex_usd.motion.clip import Clip

__all__ = ["Alignment", "align"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

_KNOT_S = 0.1  # from one pair of the warp to the next: a path of whole frames is a staircase that no motion may follow
_STEEPEST = 100
_LEAST_STEP = 0.05  # frames that both times advance at least from pair to pair


@dataclass(frozen=True, eq=False, kw_only=True)
class Alignment:
    """Which frames of two motions correspond.

    Parameters
    ----------
    pairs
        Frame of the clip, frame of the reference, both increasing, about ten a second, shape [N, 2]: what
        :func:`~mtex_usd.edit.warp_time` takes.
    path
        The cheapest path through whole frames, both never falling, shape [P, 2].
    cost
        Weighted mean distance along the path: metres of an average adult (root mean square over the joints), or
        degrees and stage units where channels were compared.
    """

    pairs: FloatArray
    path: IntArray
    cost: float

    @property
    def inverse(self) -> "Alignment":
        """The same correspondence the other way round."""
        return Alignment(pairs=self.pairs[:, ::-1], path=self.path[:, ::-1], cost=self.cost)


def align(
    clip: Clip,
    reference: Clip,
    *,
    channels: Sequence[str] = (),
    max_slope: int = 3,
    band_s: float = 1.0,
    free_s: float = 0.0,
) -> Alignment:
    """Find the time warp that brings a motion into step with another.

    Parameters
    ----------
    clip
        The motion to be warped.
    reference
        The motion that keeps its time, at the same rate; skeletons may differ where their joints have the same names.
    channels
        Compare these channels of both (tokens as in recipes); empty compares joint positions from the root, in the
        facing frame, so that neither place nor direction nor size counts.
    max_slope
        Time may run at most so many times as fast as recorded, or as slowly; at least 1.
    band_s
        How far, seconds, the correspondence may be off the straight line between the ends.
    free_s
        How much, seconds, may stay unmatched at each end of either motion: where steps do not begin together.

    Returns
    -------
    Alignment
        With the pairs for :func:`~mtex_usd.edit.warp_time`.

    Raises
    ------
    InputError
        Different rates, no joints in common, an unknown channel, numbers out of range, or lengths so different that no
        path keeps to the slopes.

    Notes
    -----
    Contacts: nothing is changed; warped by the pairs, footfalls of both come together. From end to end both should
    have as many strides: walks of 5.8 and 8.2 strides are aligned by running through some at 3.6 times the speed.

    Examples
    --------
    >>> in_step = warp_time(clip, pairs=align(clip, reference).pairs)  # doctest: +SKIP
    """
    check_pair(clip, reference)
    _check_numbers(max_slope, band_s, free_s, min(clip.frame_count, reference.frame_count) / clip.rate)
    channels = as_tokens(channels)
    rows, columns = _read_channels(clip, reference, channels) if channels else _read_positions(clip, reference)
    path = find_path(
        _measure_between(rows, columns),
        (len(rows), len(columns)),
        # A band wider than the table holds nothing more.
        band=max(1, round(min(band_s * clip.rate, max(len(rows), len(columns))))),
        steepest=max_slope,
        free=round(free_s * clip.rate),
    )
    if path is None:
        raise InputError(
            f"{clip.name or 'the clip'} cannot be aligned with {reference.name or 'the reference'}",
            expected=f"lengths that differ at most {max_slope} times",
            found=f"{len(rows)} and {len(columns)} frames",
            fix="Raise max_slope, band_s or free_s.",
        )
    return Alignment(pairs=_smooth(path, clip.rate), path=path.cells, cost=path.cost)


def _check_numbers(max_slope: int, band_s: float, free_s: float, shortest_s: float) -> None:
    as_whole_number(max_slope, "max_slope", least=1, most=_STEEPEST)
    as_number(band_s, "band_s", expected="seconds above 0")
    as_number(
        free_s,
        "free_s",
        expected=f"seconds from 0 to below the shorter motion's {shortest_s:g}",
        least=0.0,
        most=math.nextafter(shortest_s, 0.0),
    )


def _read_positions(clip: Clip, reference: Clip) -> tuple[FloatArray, FloatArray]:
    """Features whose distance is the root mean square distance of the joints, [F, D] and [G, D]."""
    joints = common_joints(clip, reference)
    size = np.sqrt(len(joints.of_clip))
    both = pose_positions(clip, joints.of_clip), pose_positions(reference, joints.of_other)
    rows, columns = (np.asarray(positions.reshape(len(positions), -1) / size) for positions in both)
    return rows, columns


def _read_channels(clip: Clip, reference: Clip, channels: Sequence[str]) -> tuple[FloatArray, FloatArray]:
    """The curves of the channels, the nearest turns of both, degrees and stage units, [F, C] and [G, C]."""
    columns: tuple[list[FloatArray], list[FloatArray]] = ([], [])
    chosen = [select_channels(each, channels) for each in (clip, reference)]
    _check_same_channels(clip, reference, chosen)
    turns = [to_skeleton_rotations(each.rotations, each.skeleton) for each in (clip, reference)]
    offsets = [to_skeleton_translations(each.translations, each.skeleton) for each in (clip, reference)]
    for one, other in zip(*chosen, strict=True):
        if not one.is_rotation:
            curves = [offsets[k][:, channel.joint, channel.axis] for k, channel in enumerate((one, other))]
        else:
            rotations = [turns[k][:, channel.joint] for k, channel in enumerate((one, other))]
            order = choose_order(clip, one.joint, np.concatenate(rotations))
            curves = [unrolled_angles(each, order)[:, one.axis] for each in rotations]
            curves[1] = curves[1] + 360.0 * np.round((curves[0].mean() - curves[1].mean()) / 360.0)
        columns[0].append(curves[0])
        columns[1].append(curves[1])
    return np.stack(columns[0], axis=1), np.stack(columns[1], axis=1)


def _check_same_channels(clip: Clip, reference: Clip, chosen: Sequence[Sequence[object]]) -> None:
    if len(chosen[0]) != len(chosen[1]):
        raise InputError(
            "the channels are not the same on both motions",
            expected=f"{len(chosen[0])} channels as on {clip.name or 'the clip'}",
            found=f"{len(chosen[1])} on {reference.name or 'the reference'}",
        )


def _measure_between(rows: FloatArray, columns: FloatArray) -> Callable[[int, int, int], FloatArray]:
    def distances(row: int, begin: int, end: int) -> FloatArray:
        apart = columns[begin:end] - rows[row]
        return np.asarray(np.sqrt(np.einsum("ij,ij->i", apart, apart)))

    return distances


def _smooth(path: WarpingPath, rate: float) -> FloatArray:
    """Give pairs along the path, averaged over a knot's length, its ends kept; shape [N, 2]."""
    cells = path.cells.astype(np.float64)
    # A path is even in the sum of its times: there every step counts by what it covers.
    sums = cells.sum(axis=1)
    even = np.arange(sums[0], sums[-1] + 1.0)
    apart = np.interp(even, sums, cells[:, 1] - cells[:, 0])
    window = 2 * max(1, round(_KNOT_S * rate)) + 1
    apart = _average(apart, min(window, 2 * ((len(even) - 1) // 2) + 1))
    count = max(2, round((even[-1] - even[0]) / (2.0 * _KNOT_S * rate)) + 1)
    knots = np.unique(np.round(np.linspace(0, len(even) - 1, count)).astype(np.intp))
    return _separate(np.stack([even[knots] - apart[knots], even[knots] + apart[knots]], axis=1) / 2.0)


def _average(values: FloatArray, window: int) -> FloatArray:
    """Running mean, continued by point reflection, which keeps the ends."""
    half = window // 2
    padded = np.pad(values, half, mode="reflect", reflect_type="odd")
    return np.asarray(uniform_filter1d(padded, window)[half : half + len(values)])


def _separate(pairs: FloatArray) -> FloatArray:
    """Drop pairs that do not advance both times; the last stays."""
    kept = [pairs[0]]
    for pair in pairs[1:-1]:
        if (pair - kept[-1] >= _LEAST_STEP).all() and (pairs[-1] - pair >= _LEAST_STEP).all():
            kept.append(pair)
    if len(pairs) > 1 and (pairs[-1] - kept[-1] > 0.0).all():
        kept.append(pairs[-1])
    return TimeWarp(np.array(kept)).pairs
