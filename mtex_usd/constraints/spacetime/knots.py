"""The spline that carries the displacement: knots over time, the basis at the frames, and where knots are added.

One row of knots serves all channels. Times are in frames from the clip's first. The spacing decides what frequencies a
displacement can have (Gleicher 2000, section 1.7.2.2), which is why knots are only added where the constraints ask.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy import sparse

from mtex_usd.motion.skeleton import FloatArray, IntArray

__all__ = ["DEGREE", "LEAST_SPACING", "Knots", "cut_knots", "split_spans", "uniform_knots"]

DEGREE = 3
LEAST_SPACING = 1.0  # frames: constraints live on frames, finer knots could only add what nothing asks for
_FITS = 1e-9  # frames


@dataclass(frozen=True, eq=False)
class Knots:
    """The knots of a cubic spline, all simple, over a range of frames.

    Parameters
    ----------
    extended
        Increasing times in frames of the clip: the break points with three more at either end, shape [S + 7]. There are
        S + 3 coefficients.
    first_frame
        The range's first frame, not before the first break point.
    frame_count
        How many frames it has, all within the break points, F.
    """

    extended: FloatArray
    first_frame: int
    frame_count: int

    @property
    def count(self) -> int:
        """How many coefficients a channel has (K)."""
        return len(self.extended) - DEGREE - 1

    @property
    def breaks(self) -> FloatArray:
        """Where one cubic passes into the next, and the two ends, [S + 1]."""
        return self.extended[DEGREE:-DEGREE]

    @cached_property
    def frames(self) -> IntArray:
        """The range's frames, [F]."""
        return self.first_frame + np.arange(self.frame_count)

    @cached_property
    def first(self) -> IntArray:
        """First of the four coefficients that act on each frame, shape [F]."""
        return self.span_of(self.frames)

    @cached_property
    def values(self) -> FloatArray:
        """What those four contribute, shape [F, 4]."""
        return _basis(self.extended, self.first + DEGREE, self.frames.astype(np.float64))

    @cached_property
    def matrix(self) -> sparse.csr_array:
        """From coefficients to frames, sparse [F, K]."""
        columns = self.first[:, None] + np.arange(DEGREE + 1)
        starts = np.arange(0, columns.size + 1, DEGREE + 1)
        return sparse.csr_array((self.values.ravel(), columns.ravel(), starts), shape=(self.frame_count, self.count))

    def derivatives(self, times: FloatArray, spans: IntArray, order: int) -> FloatArray:
        """Derivatives of the four basis functions at times [N] in spans [N], per frame to the order, [N, 4]."""
        interval = spans + DEGREE
        out = np.zeros((len(times), DEGREE + 1))
        lower = _basis(self.extended, interval, times, degree=DEGREE - order)
        out[:, order:] = lower
        for degree in range(DEGREE - order + 1, DEGREE + 1):
            out = _differentiate(self.extended, interval, out, degree)
        return out

    def span_of(self, frames: npt.ArrayLike) -> IntArray:
        """Number of the span each time falls in."""
        found = np.searchsorted(self.breaks, np.asarray(frames) + _FITS, side="right") - 1
        return np.clip(found, 0, len(self.breaks) - 2)


def uniform_knots(frame_count: int, spacing: float) -> Knots:
    """Lay knots at an even spacing, in frames, over a clip; one frame apart where less is asked."""
    step = float(max(spacing, LEAST_SPACING))
    spans = max(1, int(np.ceil((frame_count - 1) / step - _FITS)))
    return _extend(step * np.arange(spans + 1, dtype=np.float64), frame_count)


def _extend(breaks: FloatArray, frame_count: int) -> Knots:
    """Add three knots at either end, as far apart as the outermost two."""
    first, last = breaks[1] - breaks[0], breaks[-1] - breaks[-2]
    steps = np.arange(1, DEGREE + 1)
    return Knots(np.concatenate([breaks[0] - first * steps[::-1], breaks, breaks[-1] + last * steps]), 0, frame_count)


def cut_knots(knots: Knots, first_span: int, last_span: int) -> Knots:
    """Give the same spline over some of its spans, the last included."""
    extended = knots.extended[first_span : last_span + 2 * DEGREE + 2]
    begin, end = int(np.ceil(extended[DEGREE] - _FITS)), extended[-DEGREE - 1]
    at_end = last_span == len(knots.breaks) - 2
    after = knots.frame_count if at_end else int(np.ceil(end - _FITS))
    return Knots(extended, begin, after - begin)


def split_spans(knots: Knots, frames: npt.ArrayLike, *, reach: int, kept: tuple[int, int] = (0, 0)) -> Knots:
    """Halve the spans that hold some frames, and as many as `reach` on either side.

    Parameters
    ----------
    knots
        The spline.
    frames
        Frames of the clip, [N].
    reach
        How many spans more.
    kept
        How many coefficients at the beginning and the end shall act as before.

    Returns
    -------
    Knots
        The same object where all those spans are too short to be halved.
    """
    spans = np.unique(knots.span_of(frames)[:, None] + np.arange(-reach, reach + 1))
    spans = spans[(spans >= kept[0]) & (spans < len(knots.breaks) - 1 - kept[1])]
    lengths = np.diff(knots.breaks)[spans]
    spans = spans[lengths >= 2.0 * LEAST_SPACING - _FITS]
    if not spans.size:
        return knots
    middles = 0.5 * (knots.breaks[spans] + knots.breaks[spans + 1])
    return Knots(np.sort(np.concatenate([knots.extended, middles])), knots.first_frame, knots.frame_count)


def _basis(extended: FloatArray, interval: IntArray, times: FloatArray, *, degree: int = DEGREE) -> FloatArray:
    """Evaluate the splines that act in the knot interval of each time [F] (Cox and de Boor), [F, degree + 1]."""
    out = np.zeros((len(times), degree + 1))
    out[:, 0] = 1.0
    for now in range(1, degree + 1):
        saved = np.zeros(len(times))
        for i in range(now):
            right, left = extended[interval + i + 1], extended[interval + i + 1 - now]
            part = out[:, i] / (right - left)
            out[:, i] = saved + (right - times) * part
            saved = (times - left) * part
        out[:, now] = saved
    return out


def _differentiate(extended: FloatArray, interval: IntArray, lower: FloatArray, degree: int) -> FloatArray:
    """From (derivatives of) the splines of one degree less to derivatives of those of a degree, both right-aligned."""
    out = np.zeros_like(lower)
    for i in range(DEGREE - degree, DEGREE + 1):
        # Column i stands for the spline that begins at knot number interval - DEGREE + i.
        start = interval - DEGREE + i
        if i > DEGREE - degree:
            out[:, i] += degree * lower[:, i] / (extended[start + degree] - extended[start])
        if i < DEGREE:
            out[:, i] -= degree * lower[:, i + 1] / (extended[start + degree + 1] - extended[start + 1])
    return out
