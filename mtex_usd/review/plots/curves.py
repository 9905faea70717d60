"""Curves of the channels: the sketch, every variant, its path before and after joining, and the takes."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from mtex_usd.motion.channels import Channel
from mtex_usd.review.plots.quantized import pack_rows
from mtex_usd.review.plots.retrace import Retraced
from mtex_usd.texture.pyramid import band_limit, peak_frequency

__all__ = ["describe_channels", "describe_curves", "short_names"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

# Whole numbers that a character's curves may fill in the page, two bytes each; what moves most comes first.
_MOST_CURVES = 600_000
_MOST_JOINS = 750_000
_MOST_TAKES = 200_000


def describe_channels(told: Retraced) -> list[dict[str, object]]:
    """Give what each column is and what it is for.

    Parameters
    ----------
    told
        The result with its steps.

    Returns
    -------
    list
        One per column: ``token``, ``label``, ``unit``, ``roles`` (of match, break, texture, synthesize, contact),
        ``form`` (vector, angle or offset) and the bands it is matched on and that are replaced, None where they are
        not.
    """
    names = short_names(told.character.sketch.joints)
    copied = len(told.ground.space.channels)
    whole = 3 * len(told.space.whole)
    return [
        _describe_channel(told, channel, names[channel.joint], copied=column < copied, vector=column < whole)
        for column, channel in enumerate(told.space.channels)
    ]


def _describe_channel(told: Retraced, channel: Channel, name: str, *, copied: bool, vector: bool) -> dict[str, object]:
    roles = _find_roles(told, channel, copied=copied, vector=vector)
    spans = told.ground.roles.spans
    texture = next((list(span.texture_bands) for span in spans if channel in span.texture), None)
    filled = any(channel in span.synthesize for span in spans)
    return {
        "token": channel.name(told.character.sketch.joints),
        "label": f"{name}.{channel.kind}",
        "unit": "°" if channel.is_rotation else "units",
        "form": "vector" if vector else "angle" if channel.is_rotation else "offset",
        "roles": roles,
        "matchBand": spans[0].match_band if {"match", "break"} & set(roles) else None,
        "textureBands": texture,
        "synthesisBand": told.ground.roles.synthesis_band if filled else None,
    }


def _find_roles(told: Retraced, channel: Channel, *, copied: bool, vector: bool) -> list[str]:
    """Roles of a column; a joint that is matched and copied whole has its angles in columns of their own."""
    spans = told.ground.roles.spans
    member = {
        "match": not vector and any(channel in span.match for span in spans),
        "break": not vector and any(channel == span.break_channel for span in spans),
        "texture": copied and any(channel in span.texture for span in spans),
        "synthesize": copied and any(channel in span.synthesize for span in spans),
    }
    return [role for role, has in member.items() if has] or ["contact"]


def describe_curves(told: Retraced) -> dict[str, object]:
    """Give the curves of all columns, packed column by column.

    Parameters
    ----------
    told
        The result with its steps.

    Returns
    -------
    dict
        ``columns``, those in the page; ``sketch`` [C, F] and ``finished`` [C, V, F]. ``joins`` has the paths of some
        columns: ``captured`` [C, V, F + Q - 1], ``skewed`` and ``joined`` [C, V, F]. ``takes`` has the takes' frames
        end to end, ``values`` [C, N]. Each says how many columns are ``left_out`` for the size of the page.
    """
    frames, variants = told.character.sketch.frame_count, len(told.character.variants)
    order = _by_movement(told)
    columns = _within(order, frames * (1 + variants), _MOST_CURVES)
    joined = _within(order, 3 * frames * variants, _MOST_JOINS)
    taken = _within(order, sum(take.clip.frame_count for take in told.ground.takes), _MOST_TAKES)
    return {
        "columns": columns.tolist(),
        "left_out": len(order) - len(columns),
        "sketch": pack_rows(told.sketch_curves.T[columns]),
        "finished": pack_rows(_rows(list(told.finished_curves), columns)),
        "joins": _describe_joins(told, joined, len(order)),
        "takes": _describe_take_curves(told, taken, len(order)),
        "bands": _describe_bands(told),
    }


def _by_movement(told: Retraced) -> IntArray:
    """Columns in the order they stay in the page: what is matched, then what moves most."""
    matched = np.array(["match" in c["roles"] for c in describe_channels(told)])  # type: ignore[operator]
    movement = np.ptp(np.concatenate([told.sketch_curves, *told.finished_curves]), axis=0)
    return np.lexsort((-movement, ~matched))


def _within(order: IntArray, values: int, most: int) -> IntArray:
    """The first of the columns that fit in so many values, at least one, in their own order."""
    return np.sort(order[: max(1, most // max(values, 1))])


def _rows(curves: Sequence[FloatArray], columns: IntArray) -> FloatArray:
    """V curves [F, C] as rows [C', V, F]."""
    return np.stack([curve.T[columns] for curve in curves], axis=1)


def _describe_joins(told: Retraced, columns: IntArray, count: int) -> dict[str, object]:
    joinings = told.joinings
    return {
        "columns": columns.tolist(),
        "left_out": count - len(columns),
        "captured": pack_rows(_rows([joining.captured for joining in joinings], columns)),
        "skewed": pack_rows(_rows([joining.skewed for joining in joinings], columns)),
        "joined": pack_rows(_rows([joining.joined for joining in joinings], columns)),
    }


def _describe_take_curves(told: Retraced, columns: IntArray, count: int) -> dict[str, object]:
    takes = [told.read_take_curves(take)[:, columns] for take in range(len(told.ground.takes))]
    return {
        "columns": columns.tolist(),
        "left_out": count - len(columns),
        "starts": np.cumsum([0, *map(len, takes[:-1])]).tolist(),
        "values": pack_rows(np.concatenate(takes).T),
    }


def _describe_bands(told: Retraced) -> list[dict[str, object]]:
    """The bands a sketch of this length has, with what they peak at."""
    sketch = told.character.sketch
    numbers = range(1, band_limit(sketch.frame_count) + 1)
    return [{"number": number, "hz": round(peak_frequency(number, sketch.rate), 3)} for number in numbers]


def short_names(joints: Sequence[str]) -> list[str]:
    """Give last names of joints, and full paths where those are not unique.

    Parameters
    ----------
    joints
        Joint paths.
    """
    last = [joint.rpartition("/")[2] for joint in joints]
    return [name if last.count(name) == 1 else joint for name, joint in zip(last, joints, strict=True)]
