"""The mtex schemas as they are read off prims, whether or not USD knows them in this process.

Applied schemas come from composed metadata and values from authored attributes, so a stage reads the same in a process
that never registered the plugin. Defaults are those of :class:`mtex_usd.texture.recipe.Recipe`. By USD's convention a
property counts only where its schema is applied, so that ``delete apiSchemas`` in a stronger layer switches it off.
"""

import difflib
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pxr import Gf, Sdf, Usd, Vt

from mtex_usd.errors import InputError, StageError
from mtex_usd.texture.recipe import PATH_COSTS, Recipe, Segment

__all__ = [
    "SEGMENT_API",
    "SKETCH_API",
    "TAKES_PROPERTY",
    "TAKE_API",
    "TakeSettings",
    "api_instances",
    "authored",
    "has_api",
    "read_recipe",
    "read_take_settings",
]

SKETCH_API = "MtexSketchAPI"
SEGMENT_API = "MtexSegmentAPI"
TAKE_API = "MtexTakeAPI"
TAKES_PROPERTY = "mtex:takes"


@dataclass(frozen=True, kw_only=True)
class TakeSettings:
    """What MtexTakeAPI says about a take.

    Parameters
    ----------
    start, end
        The usable range, both ends included, in time codes of the stage; None means the first or last sample.
    style
        A word for how the take was performed, or nothing.
    skeleton
        The Skeleton the take was recorded on, where it is named.
    """

    start: float | None = None
    end: float | None = None
    style: str = ""
    skeleton: Sdf.Path | None = None


def has_api(prim: Usd.Prim, api_name: str) -> bool:
    """Tell whether an API schema is applied, one that this process does not know included."""
    return api_name in _applied_schemas(prim)


def api_instances(prim: Usd.Prim, api_name: str) -> tuple[str, ...]:
    """Name the instances of a multiple-apply API schema, strongest first, registered or not."""
    prefix = f"{api_name}:"
    return tuple(name.removeprefix(prefix) for name in _applied_schemas(prim) if name.startswith(prefix))


def _applied_schemas(prim: Usd.Prim) -> list[str]:
    # GetAppliedSchemas drops what this process does not know; the type info lacks what other schemas build in.
    composed = prim.GetPrimTypeInfo().GetAppliedAPISchemas()
    return list(dict.fromkeys([*map(str, composed), *map(str, prim.GetAppliedSchemas())]))


def authored(prim: Usd.Prim, name: str) -> Any:
    """Give the authored value of an attribute that holds one for all time.

    Parameters
    ----------
    prim
        The prim that has the attribute.
    name
        The attribute's name.

    Returns
    -------
    object
        The composed value as USD gives it, time codes mapped by layer offsets; None where nothing is authored or the
        value is blocked.

    Raises
    ------
    InputError
        Where the attribute has time samples or a spline and no default value.
    """
    attribute = prim.GetAttribute(name)
    if not attribute or not attribute.HasAuthoredValue():
        return None
    # Get alone would give the schema's fallback in place of samples.
    if attribute.GetResolveInfo(Usd.TimeCode.Default()).GetSource() != Usd.ResolveInfoSourceDefault:
        raise InputError(
            f"{_where(prim, name)} changes over time", expected="one value for all time", fix="Author a default value."
        )
    return attribute.Get()


def _where(prim: Usd.Prim, name: str) -> str:
    return f"{prim.GetPath()}.{name}"


@dataclass(frozen=True)
class _Kind:
    """A value type of the schema: its name in USD, what Python gets, and how to make it plain."""

    type_name: str
    python_types: tuple[type, ...]
    convert: Callable[[Any], Any]

    def read(self, prim: Usd.Prim, name: str) -> Any:
        value = authored(prim, name)
        if value is None:
            return None
        if isinstance(value, bool) != (bool in self.python_types) or not isinstance(value, self.python_types):
            found = f"{Sdf.GetValueTypeNameForValue(value)} {value}"
            raise InputError(f"{_where(prim, name)} has the wrong type", expected=self.type_name, found=found)
        return self.convert(value)


# Widening (string to token, int or float to double) loses nothing and is let through; double for timecode is not, since
# layer offsets would not move it.
_TOKEN = _Kind("token", (str,), str)
_TOKENS = _Kind("token[]", (Vt.TokenArray,), lambda value: tuple(map(str, value)))
_BOOL = _Kind("bool", (bool,), bool)
_INT = _Kind("int", (int,), int)
_INT2 = _Kind("int2", (Gf.Vec2i,), lambda value: (int(value[0]), int(value[1])))
_DOUBLE = _Kind("double", (float, int), float)
_TIME_CODE = _Kind("timecode", (Sdf.TimeCode,), lambda value: float(value.GetValue()))


@dataclass(frozen=True)
class _Rule:
    """What values are allowed, in code and in words."""

    allows: Callable[[Any], bool]
    expected: str


_ANY = _Rule(lambda _: True, "")
_FINITE = _Rule(math.isfinite, "a finite time code")
_BAND = _Rule(lambda value: value >= 0, "a band from 1, the highest frequency, or 0 for the paper's")
_BANDS = _Rule(
    lambda value: min(value) >= 0 and (0 in value or value[0] <= value[1]),
    "the first and last band, first not above last, or 0 for the paper's",
)
_WEIGHT = _Rule(lambda value: math.isfinite(value) and value >= 0.0, "a finite number, at least 0")
_STRETCH = _Rule(lambda value: math.isfinite(value) and value >= 1.0, "a finite number, at least 1")
_DURATION = _Rule(lambda value: math.isfinite(value) and value > 0.0, "seconds above 0")
_ANGLE = _Rule(lambda value: 0.0 <= value <= 180.0, "degrees from 0 to 180")
_PATHS = _Rule(lambda value: value >= 1, "at least 1")
_CANDIDATES = _Rule(lambda value: value >= 0, "at least 1, or 0 for a tenth of all take fragments")
_PATH_COST = _Rule(lambda value: value in PATH_COSTS, " or ".join(f'"{cost}"' for cost in PATH_COSTS))


@dataclass(frozen=True)
class _Property:
    """One schema property: the field it fills, its name below the schema's prefix, type and allowed values."""

    field: str
    name: str
    kind: _Kind
    rule: _Rule = _ANY


_SKETCH_PROPERTIES = (
    _Property("match", "match", _TOKENS),
    _Property("texture", "texture", _TOKENS),
    _Property("synthesize", "synthesize", _TOKENS),
    _Property("break_channel", "break", _TOKEN),
    _Property("match_band", "matchBand", _INT, _BAND),
    _Property("match_lower", "matchLower", _BOOL),
    _Property("path_cost", "pathCost", _TOKEN, _PATH_COST),
    _Property("path_weight", "pathWeight", _DOUBLE, _WEIGHT),
    _Property("diversity", "diversity", _DOUBLE, _ANGLE),
    _Property("texture_bands", "textureBands", _INT2, _BANDS),
    _Property("synthesis_band", "synthesisBand", _INT, _BAND),
    _Property("derivative_weight", "derivativeWeight", _DOUBLE, _WEIGHT),
    _Property("candidates", "candidates", _INT, _CANDIDATES),
    _Property("paths", "paths", _INT, _PATHS),
    _Property("max_stretch", "maxStretch", _DOUBLE, _STRETCH),
    _Property("scale", "scale", _BOOL),
    _Property("join_time", "joinTime", _DOUBLE, _DURATION),
    _Property("contacts", "contacts", _TOKEN),
)
_SEGMENT_PROPERTIES = (
    _Property("start", "start", _TIME_CODE, _FINITE),
    _Property("end", "end", _TIME_CODE, _FINITE),
    *(
        rule
        for rule in _SKETCH_PROPERTIES
        if rule.name in {"match", "break", "matchBand", "texture", "synthesize", "textureBands", "scale"}
    ),
)
_TAKE_PROPERTIES = (
    _Property("start", "start", _TIME_CODE, _FINITE),
    _Property("end", "end", _TIME_CODE, _FINITE),
    _Property("style", "style", _TOKEN),
)


def _read_properties(prim: Usd.Prim, prefix: str, properties: tuple[_Property, ...]) -> dict[str, Any]:
    """Read what is authored, by field name; each value is checked against its type and rule."""
    fields = {}
    for schema_property in properties:
        name = prefix + schema_property.name
        value = schema_property.kind.read(prim, name)
        if value is None:
            continue
        if not schema_property.rule.allows(value):
            raise InputError(
                f"{_where(prim, name)} is not allowed", expected=schema_property.rule.expected, found=str(value)
            )
        fields[schema_property.field] = value
    return fields


def _check_names(prim: Usd.Prim, prefix: str, known: list[str]) -> None:
    """Refuse misspelt properties, which would change the result in silence."""
    for name in map(str, prim.GetAuthoredPropertyNames()):
        base = name.removeprefix(prefix)
        if not name.startswith(prefix) or ":" in base or base in known:
            continue
        close = difflib.get_close_matches(base, known, n=1)
        raise InputError(
            f"{_where(prim, name)} is not a property of the mtex schemas",
            expected=f"one of {', '.join(prefix + base for base in sorted(known))}",
            fix=f"Did you mean {prefix}{close[0]}?" if close else "Remove it or give it another namespace.",
        )


def read_recipe(prim: Usd.Prim) -> Recipe:
    """Read and check everything MtexSketchAPI and MtexSegmentAPI say on a sketch, except where the takes are.

    Parameters
    ----------
    prim
        The sketch, a SkelAnimation with MtexSketchAPI.

    Returns
    -------
    Recipe
        Defaults where nothing is authored; segments in order of time, in time codes of the stage.

    Raises
    ------
    InputError
        Where a property is misspelt, of the wrong type, changes over time or is out of range, and where segments lack
        an end, are empty or overlap; names the prim, the property and its value.
    """
    _check_names(prim, "mtex:", [TAKES_PROPERTY.removeprefix("mtex:"), *(known.name for known in _SKETCH_PROPERTIES)])
    fields = _read_properties(prim, "mtex:", _SKETCH_PROPERTIES)
    _check_contacts(prim, fields.get("contacts", "off"))
    return Recipe(**fields, segments=_read_segments(prim))


def _check_contacts(prim: Usd.Prim, contacts: str) -> None:
    if contacts != "off":
        where = _where(prim, "mtex:contacts")
        raise InputError(f'{where}: contacts "{contacts}" is not supported by this version', expected='"off"')


def _read_segments(prim: Usd.Prim) -> tuple[Segment, ...]:
    """Read all segments in order of time and refuse overlaps; sharing an end point is none."""
    segments = [_read_segment(prim, instance) for instance in api_instances(prim, SEGMENT_API)]
    segments.sort(key=lambda segment: (segment.start, segment.end))
    for earlier, later in itertools.pairwise(segments):
        if later.start < earlier.end:
            raise InputError(
                f"{prim.GetPath()}: segments {earlier.name} and {later.name} overlap",
                expected="segments that share at most an end point",
                found=f"{_span(earlier)} and {_span(later)}",
            )
    return tuple(segments)


def _span(segment: Segment) -> str:
    return f"{segment.start:g} to {segment.end:g}"


def _read_segment(prim: Usd.Prim, instance: str) -> Segment:
    prefix = f"mtex:segment:{instance}:"
    _check_names(prim, prefix, [known.name for known in _SEGMENT_PROPERTIES])
    fields = _read_properties(prim, prefix, _SEGMENT_PROPERTIES)
    for name in ("start", "end"):
        if name not in fields:
            raise InputError(f"{prim.GetPath()}: segment {instance} has no {name}", expected=f"timecode {prefix}{name}")
    segment = Segment(name=instance, **fields)
    if not segment.start < segment.end:
        raise InputError(
            f"{prim.GetPath()}: segment {instance} is empty", expected="start before end", found=_span(segment)
        )
    return segment


def read_take_settings(prim: Usd.Prim) -> TakeSettings:
    """Read and check what MtexTakeAPI says on a take; defaults where it is not applied.

    Parameters
    ----------
    prim
        The take, a SkelAnimation.

    Returns
    -------
    TakeSettings
        Times in time codes of the stage.

    Raises
    ------
    InputError
        Where a property is misspelt, of the wrong type or not finite, the end comes before the start, or more than one
        skeleton is named.
    StageError
        Where composition dropped the skeleton.
    """
    if not has_api(prim, TAKE_API):
        return TakeSettings()
    prefix = "mtex:take:"
    _check_names(prim, prefix, ["skeleton", *(known.name for known in _TAKE_PROPERTIES)])
    settings = TakeSettings(
        **_read_properties(prim, prefix, _TAKE_PROPERTIES), skeleton=_read_skeleton(prim, f"{prefix}skeleton")
    )
    if settings.start is not None and settings.end is not None and settings.end < settings.start:
        found = f"{settings.start:g} to {settings.end:g}"
        raise InputError(f"{prim.GetPath()}: the take ends before it starts", expected="start before end", found=found)
    return settings


def _read_skeleton(prim: Usd.Prim, name: str) -> Sdf.Path | None:
    relationship = prim.GetRelationship(name)
    if not relationship:
        return None
    targets = relationship.GetForwardedTargets()
    if len(targets) > 1:
        found = ", ".join(map(str, targets))
        raise InputError(f"{_where(prim, name)} is ambiguous", expected="one Skeleton", found=found)
    _check_dropped(relationship, targets)
    return targets[0] if targets else None


def _check_dropped(relationship: Usd.Relationship, targets: list[Sdf.Path]) -> None:
    """Refuse to go on without a target that a layer names but composition could not carry over."""
    if targets:
        return
    specs = [spec for spec in relationship.GetPropertyStack() if isinstance(spec, Sdf.RelationshipSpec)]
    for spec in specs:
        lost = spec.targetPathList.GetAppliedItems()
        if lost:
            raise StageError(
                f"{relationship.GetPath()}: composition dropped the target {lost[0]}",
                found=f"the target in layer {spec.layer.identifier}, outside what is referenced from there",
                fix="Move the target below the referenced prim, or author the relationship in the referencing layer.",
            )
        if spec.targetPathList.isExplicit:
            return
