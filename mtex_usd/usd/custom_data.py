"""Plain Python values as USD metadata and back.

USD's dictionaries hold no lists of dictionaries (neither crate nor text can store one), so such a list becomes a
dictionary whose keys are its indices, zero-padded so that they sort: ``{"00": {…}, "01": {…}}``.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from pxr import Vt

__all__ = ["from_metadata", "to_metadata"]


def to_metadata(value: object) -> object:
    """Turn a plain value into one that a USD dictionary can hold.

    Parameters
    ----------
    value
        A string, number or bool (numpy's too), a sequence of strings, of integers or of numbers, a sequence of
        mappings, or a mapping of names to any of these.

    Returns
    -------
    object
        What ``customData`` takes; :func:`from_metadata` gives the plain value back.

    Raises
    ------
    TypeError
        For anything else.
    """
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, str | bool | int | float):
        return value
    if isinstance(value, Mapping):
        return {str(key): to_metadata(item) for key, item in value.items()}
    if isinstance(value, Sequence | np.ndarray):
        return _list_to_metadata(list(value))
    raise TypeError(f"USD metadata cannot hold a {type(value).__name__}")


def _list_to_metadata(items: list[object]) -> object:
    if items and all(isinstance(item, Mapping) for item in items):
        width = max(2, len(str(len(items) - 1)))
        return {f"{i:0{width}d}": to_metadata(item) for i, item in enumerate(items)}
    if all(isinstance(item, str) for item in items):
        return Vt.StringArray([str(item) for item in items])
    if all(isinstance(item, int | np.integer) for item in items):
        return Vt.Int64Array([int(item) for item in items])  # type: ignore[call-overload]
    return Vt.DoubleArray([float(item) for item in items])  # type: ignore[arg-type]


def from_metadata(value: object) -> object:
    """Give back what :func:`to_metadata` was given, sequences as lists.

    Parameters
    ----------
    value
        A value read from ``customData``.
    """
    if isinstance(value, Mapping):
        items = {str(key): from_metadata(item) for key, item in value.items()}
        return list(items.values()) if items and all(key.isdecimal() for key in items) else items
    if isinstance(value, str | bool | int | float):
        return value
    return list(value)  # type: ignore[call-overload]
