"""A recipe as the lines of a .usda file that would author it."""

import json
from collections.abc import Callable
from dataclasses import fields

from mtex_usd.texture.recipe import Recipe, Segment

__all__ = ["recipe_to_usda"]

_DEFAULTS = Recipe()


def _tokens(value: tuple[str, ...]) -> str:
    return f"[{', '.join(map(json.dumps, value))}]"


def _pair(value: tuple[int, int]) -> str:
    return f"({value[0]}, {value[1]})"


def _truth(value: object) -> str:
    return "true" if value else "false"


def _number(value: float) -> str:
    return f"{value:.12g}"


_TYPES: dict[str, tuple[str, str, Callable[..., str]]] = {
    "match": ("token[]", "match", _tokens),
    "texture": ("token[]", "texture", _tokens),
    "synthesize": ("token[]", "synthesize", _tokens),
    "break_channel": ("token", "break", json.dumps),
    "match_band": ("int", "matchBand", str),
    "match_lower": ("bool", "matchLower", _truth),
    "path_cost": ("token", "pathCost", json.dumps),
    "path_weight": ("double", "pathWeight", _number),
    "diversity": ("double", "diversity", _number),
    "texture_bands": ("int2", "textureBands", _pair),
    "synthesis_band": ("int", "synthesisBand", str),
    "derivative_weight": ("double", "derivativeWeight", _number),
    "candidates": ("int", "candidates", str),
    "paths": ("int", "paths", str),
    "max_stretch": ("double", "maxStretch", _number),
    "scale": ("bool", "scale", _truth),
    "join_time": ("double", "joinTime", _number),
    "contacts": ("token", "contacts", json.dumps),
    "start": ("timecode", "start", _number),
    "end": ("timecode", "end", _number),
}


def recipe_to_usda(recipe: Recipe) -> str:
    """Give the lines that author a recipe on a sketch, leaving out what is as the schema has it.

    Parameters
    ----------
    recipe
        Its segments follow, each with the properties it sets.

    Returns
    -------
    str
        ``uniform`` property lines of a .usda file, one per line; the takes are a relationship and not among them.
    """
    changed = [
        _line(field.name, "mtex:", getattr(recipe, field.name))
        for field in fields(recipe)
        if field.name in _TYPES and getattr(recipe, field.name) != getattr(_DEFAULTS, field.name)
    ]
    return "\n".join([*changed, *(_segment_lines(segment) for segment in recipe.segments)])


def _segment_lines(segment: Segment) -> str:
    prefix = f"mtex:segment:{segment.name}:"
    names = [field.name for field in fields(segment) if field.name in _TYPES]
    return "\n".join(
        _line(name, prefix, getattr(segment, name)) for name in names if getattr(segment, name) is not None
    )


def _line(field: str, prefix: str, value: object) -> str:
    kind, name, write = _TYPES[field]
    return f"uniform {kind} {prefix}{name} = {write(value)}"
