"""Arrays as text that a page's script reads back without parsing numbers."""

import base64

import numpy as np
import numpy.typing as npt

__all__ = ["PackedArray", "pack_array", "pack_places"]

PackedArray = dict[str, object]

_STEPS = 65535


def pack_array(array: npt.ArrayLike) -> PackedArray:
    """Give an array as base64 of single-precision, little-endian values.

    Parameters
    ----------
    array
        Numbers of any shape; not-a-number is kept.

    Returns
    -------
    dict
        ``dtype`` (always ``"float32"``), ``shape`` and ``data``; ``unpack`` of ``static/packing.js`` reads it.
    """
    values = np.ascontiguousarray(array, dtype="<f4")
    return {"dtype": "float32", "shape": list(values.shape), "data": _encode(values)}


def pack_places(places: npt.NDArray[np.float64]) -> PackedArray:
    """Give positions at half the size: 16 bits each about their middle, which goes along in single precision.

    Parameters
    ----------
    places
        Finite positions of a body at every frame, shape [F, J, 3].

    Returns
    -------
    dict
        ``middle`` (a packed array [F, 3]), ``low`` and ``step`` [3], ``shape`` and ``data``; ``unpackPlaces`` of
        ``static/packing.js`` reads it. The error is at most half a step: the body's extent / 131070, however far it
        travels.
    """
    middle = places.mean(axis=1).astype("<f4")
    about = places - middle[:, None].astype(np.float64)
    low, high = about.min(axis=(0, 1)), about.max(axis=(0, 1))
    step = (high - low) / _STEPS
    step[step == 0.0] = 1.0
    steps = np.clip(np.round((about - low) / step), 0.0, _STEPS).astype("<u2")
    return {
        "middle": pack_array(middle),
        "low": low.tolist(),
        "step": step.tolist(),
        "shape": list(places.shape),
        "data": _encode(steps),
    }


def _encode(values: npt.NDArray[np.generic]) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")
