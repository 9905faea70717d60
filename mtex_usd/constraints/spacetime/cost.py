"""What a change costs: its square over the frames, and the squares of its derivatives, which keep it slow."""

import numpy as np

from mtex_usd.constraints.spacetime.knots import DEGREE, Knots
from mtex_usd.motion.skeleton import FloatArray, IntArray

__all__ = ["cost_diagonals"]

_RIDGE = 1e-8  # of the mean: near the ends more coefficients than frames may act
_GAUSS = (0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0))  # of a span: exact for squares of what is linear in it


def cost_diagonals(knots: Knots, *, cycles_per_frame: float, smoothness: float, highpass: float) -> FloatArray:
    """Give the matrix of one channel's cost over its coefficients.

    Parameters
    ----------
    knots
        The spline.
    cycles_per_frame
        Frequency at which the derivatives count as given.
    smoothness
        Weight of the integral of the second derivative's square, per frame, in turns at that frequency.
    highpass
        Weight of the third derivative's, likewise.

    Returns
    -------
    FloatArray
        Diagonals [4, K]: row `i` holds the entries (k, k + i), zero past the end.
    """
    turn = 2.0 * np.pi * cycles_per_frame
    out = _squares(knots.first, knots.values, knots.count)
    out[0] += _RIDGE * out[0].mean()
    for order, weight in ((2, smoothness), (3, highpass)):
        if weight > 0.0:
            out += weight / turn ** (2 * order) * _derivative_squares(knots, order)
    return out


def _derivative_squares(knots: Knots, order: int) -> FloatArray:
    """Integrals of the products of derivatives, as diagonals [4, K]."""
    spans = np.arange(len(knots.breaks) - 1)
    lengths = np.diff(knots.breaks)
    out = np.zeros((DEGREE + 1, knots.count))
    for share in _GAUSS:
        values = knots.derivatives(knots.breaks[:-1] + share * lengths, spans, order)
        out += _squares(spans, np.sqrt(0.5 * lengths)[:, None] * values, knots.count)
    return out


def _squares(first: IntArray, values: FloatArray, count: int) -> FloatArray:
    """Sum the products of the four basis functions [N, 4], the first numbered [N], as diagonals [4, K]."""
    out = np.zeros((DEGREE + 1, count))
    for row in range(DEGREE + 1):
        for column in range(row, DEGREE + 1):
            products = values[:, row] * values[:, column]
            out[column - row] += np.bincount(first + row, products, minlength=count)
    return out
