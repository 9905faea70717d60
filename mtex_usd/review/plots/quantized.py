"""Curves as 16-bit whole numbers: half of single precision, and finer than a pixel."""

import base64

import numpy as np
import numpy.typing as npt

from mtex_usd.review.packing import PackedArray, pack_array

__all__ = ["LEVELS", "pack_rows"]

# Whole numbers from -32767 to 32767 divide the range of a row into so many steps.
LEVELS = 65534


def pack_rows(rows: npt.ArrayLike) -> PackedArray:
    """Give rows of numbers as base64 of 16-bit, little-endian whole numbers.

    Parameters
    ----------
    rows
        Shape [R, ...], a value at least in each; every row has a range of its own.

    Returns
    -------
    dict
        ``dtype`` (always ``"int16"``), ``shape``, ``data``, and packed ``middle`` and ``step``, shape [R]: a value is
        ``middle + step * number``, off by half a step at the most. ``unpackRow`` of ``static/plots_data.js`` reads it.
    """
    values = np.asarray(rows, dtype=np.float64)
    flat = values.reshape(len(values), -1)
    low, high = flat.min(axis=1), flat.max(axis=1)
    middle = (0.5 * low + 0.5 * high).astype(np.float32).astype(np.float64)
    # Single precision may round the middle: the step covers what is then the longer half, and is never rounded down.
    step = (np.maximum(high - middle, middle - low) * 2.0 / LEVELS).astype(np.float32)
    step = np.where(step > 0.0, np.nextafter(step, np.float32(np.inf)), step).astype(np.float64)
    numbers = np.divide(flat - middle[:, None], step[:, None], out=np.zeros_like(flat), where=step[:, None] > 0.0)
    return {
        "dtype": "int16",
        "shape": list(values.shape),
        "middle": pack_array(middle),
        "step": pack_array(step),
        "data": base64.b64encode(np.round(numbers).astype("<i2").tobytes()).decode("ascii"),
    }
