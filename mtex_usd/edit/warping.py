"""Time warped so that events happen when they should (Gleicher 2000, section 1.6.2.2).

The two times of every pair are interpolated over their sum, both by PCHIP, which is monotone where the data are. So
neither is the function of the other: the pairs exchanged give exactly the inverse warp. Beyond the first and last pair
time runs as fast as recorded.

What it does to contacts: the whole pose moves in time together, so a planted foot stays planted at the same place, for
longer or shorter. The root's way is the same; only its speed changes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.interpolate import PchipInterpolator

from mtex_usd.edit.channel_part import take_channels
from mtex_usd.edit.continuation import Ends, check_ends
from mtex_usd.edit.sampling import sample_clip
from mtex_usd.edit.timing import choose_frame_count
from mtex_usd.errors import InputError
from mtex_usd.motion.arguments import as_clip, as_numbers, as_tokens
from mtex_usd.motion.clip import Clip

__all__ = ["TimeWarp", "warp_time"]

FloatArray = npt.NDArray[np.float64]

_FARTHEST = 1e9  # frames
_LEAST_APART = 1e-6  # frames: nearer ones coincide
_HALVINGS = 60  # of the interval that holds a time: to the last bit


@dataclass(frozen=True, eq=False)
class TimeWarp:
    """A monotone map between the times of a clip and those of a warped clip, both in frames.

    Parameters
    ----------
    pairs
        Frame of the clip, frame of the warped clip; both increasing, shape [N, 2].

    Raises
    ------
    InputError
        Where there is no pair, a number is not finite, or pairs cross.
    """

    pairs: FloatArray

    def __post_init__(self) -> None:
        """Check that the pairs make a map."""
        pairs = as_numbers(
            self.pairs, "pairs of a time warp", expected="pairs (frame of the clip, frame of the result)"
        )
        if pairs.ndim != 2 or pairs.shape[1:] != (2,) or not len(pairs):
            raise InputError(
                "bad pairs of a time warp",
                expected="at least one pair (frame of the clip, frame of the result)",
                found=f"shape {pairs.shape}",
            )
        far = pairs[~(np.abs(pairs) <= _FARTHEST)]
        if far.size:
            raise InputError(
                "bad pairs of a time warp", expected=f"finite frames, none beyond {_FARTHEST:g}", found=f"{far[0]:g}"
            )
        crossing = np.flatnonzero((np.diff(pairs, axis=0) < _LEAST_APART).any(axis=1))
        if crossing.size:
            before, after = (tuple(map(float, pairs[crossing[0] + k])) for k in (0, 1))
            raise InputError(
                "pairs of a time warp cross or coincide",
                expected="frames of the clip and of the result that both increase",
                found=f"{before} before {after}",
            )
        object.__setattr__(self, "pairs", pairs)

    @property
    def inverse(self) -> "TimeWarp":
        """The warp back."""
        return TimeWarp(self.pairs[:, ::-1])

    @property
    def is_identity(self) -> bool:
        """Whether every frame stays where it is."""
        return bool((self.pairs[:, 0] == self.pairs[:, 1]).all())

    @cached_property
    def _knots(self) -> FloatArray:
        """The pairs, and two on either side along lines of recorded speed, shape [N + 4, 2]."""
        reach = 1.0 + float(np.ptp(self.pairs, axis=0).max()) / max(len(self.pairs) - 1, 1)
        beyond = reach * np.array([[1.0], [2.0]])
        return np.concatenate([self.pairs[:1] - beyond[::-1], self.pairs, self.pairs[-1:] + beyond])

    @cached_property
    def _curves(self) -> PchipInterpolator:
        """Both times over the sum of the knots' times."""
        return PchipInterpolator(self._knots.sum(axis=1), self._knots)

    def source_times(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give the times of the clip that are seen at times of the warped clip.

        Parameters
        ----------
        times
            In frames of the warped clip, shape [N].

        Returns
        -------
        tuple of FloatArray
            Times in frames of the clip, and how many of those pass per frame there, both shape [N].
        """
        knots = self._knots
        inside = np.clip(times, knots[1, 1], knots[-2, 1])
        values, slopes = (self._curves(self._find(inside), nu) for nu in (0, 1))
        return values[:, 0] + (times - inside), slopes[:, 0] / slopes[:, 1]

    def _find(self, times: FloatArray) -> FloatArray:
        """Where on the curves the warped time is so much, by halving the interval between two knots."""
        knots, sums = self._knots[:, 1], self._knots.sum(axis=1)
        index = np.clip(np.searchsorted(knots, times, side="right") - 1, 0, len(knots) - 2)
        low, high = sums[index], sums[index + 1]
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            late = self._curves(middle)[:, 1] > times
            low, high = np.where(late, low, middle), np.where(late, middle, high)
        return np.asarray(np.where(times >= knots[index + 1], high, low))


def warp_time(
    clip: Clip,
    *,
    pairs: Sequence[tuple[float, float]] | FloatArray,
    ends: Ends = "hold",
    frame_count: int | None = None,
    channels: Sequence[str] = (),
) -> Clip:
    """Move events in time; between them time runs smoothly and never backwards.

    Parameters
    ----------
    clip
        The clip.
    pairs
        Correspondences (frame of the clip, frame of the result), both increasing and counted from 0; parts of a frame
        count. One pair alone shifts. Those of :func:`~mtex_usd.edit.align` fit.
    ends
        What is seen before the clip's first and after its last frame, as for :func:`~mtex_usd.edit.shift_time`.
    frame_count
        Frames of the result; None up to where the clip's last frame goes, at least 2.
    channels
        Channel tokens as in recipes: warp only these, within the clip's own frames; empty for the whole motion.

    Returns
    -------
    Clip
        At the same rate, from the same first time code. With pairs that leave everything where it is, the clip as it
        is. Where time runs faster than recorded what the frames cannot carry at that speed is removed first.

    Raises
    ------
    InputError
        Pairs that cross, coincide or are not finite, none at all, fewer than 2 frames or more than 200,000 in the
        result, an unknown channel.

    Notes
    -----
    Contacts: as still as before, earlier or later; footfalls that are given as pairs come exactly there.

    Examples
    --------
    >>> marching = warp_time(clip, pairs=[(20, 25), (40, 39), (60, 63), (80, 84)])  # doctest: +SKIP
    """
    as_clip(clip)
    check_ends(ends)
    channels = as_tokens(channels)
    warp = TimeWarp(pairs)  # type: ignore[arg-type]
    fitting = max(float(warp.inverse.source_times(np.array([clip.frame_count - 1.0]))[0][0]), 1.0)
    count = choose_frame_count(frame_count, last=clip.frame_count - 1 if channels else fitting)
    if warp.is_identity and count == clip.frame_count:
        return take_channels(clip, clip, channels)
    times, speeds = warp.source_times(np.arange(count, dtype=np.float64))
    return take_channels(clip, sample_clip(clip, times, speeds=speeds, ends=ends), channels)
