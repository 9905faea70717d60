"""MtexSketchAPI and MtexSegmentAPI: what a sketch is to become."""

import itertools
import math

from pxr import Usd

from mtex_usd.errors import InputError
from mtex_usd.texture.recipe import CONTACTS, PATH_COSTS, Recipe, Segment
from mtex_usd.usd.schema.applied import api_instances
from mtex_usd.usd.schema.edit import EDITS_PROPERTY
from mtex_usd.usd.schema.properties import (
    BOOL,
    DOUBLE,
    FINITE,
    INT,
    INT2,
    TIME_CODE,
    TOKEN,
    TOKENS,
    Property,
    Rule,
    check_names,
    read_properties,
)

__all__ = ["SEGMENT_API", "SKETCH_API", "TAKES_PROPERTY", "read_recipe"]

SKETCH_API = "MtexSketchAPI"
SEGMENT_API = "MtexSegmentAPI"
TAKES_PROPERTY = "mtex:takes"

_BAND = Rule(lambda value: value >= 0, "a band from 1, the highest frequency, or 0 for the paper's")
_BANDS = Rule(
    lambda value: min(value) >= 0 and (0 in value or value[0] <= value[1]),
    "the first and last band, first not above last, or 0 for the paper's",
)
_WEIGHT = Rule(lambda value: math.isfinite(value) and value >= 0.0, "a finite number, at least 0")
_STRETCH = Rule(lambda value: math.isfinite(value) and value >= 1.0, "a finite number, at least 1")
_DURATION = Rule(lambda value: math.isfinite(value) and value > 0.0, "seconds above 0")
_ANGLE = Rule(lambda value: 0.0 <= value <= 180.0, "degrees from 0 to 180")
_PATHS = Rule(lambda value: value >= 1, "at least 1")
_CANDIDATES = Rule(lambda value: value >= 0, "at least 1, or 0 for a tenth of all take fragments")
_CONTACTS = Rule(lambda value: value in CONTACTS, " or ".join(f'"{choice}"' for choice in CONTACTS))
_PATH_COST = Rule(lambda value: value in PATH_COSTS, " or ".join(f'"{cost}"' for cost in PATH_COSTS))

_SKETCH_PROPERTIES = (
    Property("match", "match", TOKENS),
    Property("texture", "texture", TOKENS),
    Property("synthesize", "synthesize", TOKENS),
    Property("break_channel", "break", TOKEN),
    Property("match_band", "matchBand", INT, _BAND),
    Property("match_lower", "matchLower", BOOL),
    Property("path_cost", "pathCost", TOKEN, _PATH_COST),
    Property("path_weight", "pathWeight", DOUBLE, _WEIGHT),
    Property("diversity", "diversity", DOUBLE, _ANGLE),
    Property("texture_bands", "textureBands", INT2, _BANDS),
    Property("synthesis_band", "synthesisBand", INT, _BAND),
    Property("derivative_weight", "derivativeWeight", DOUBLE, _WEIGHT),
    Property("candidates", "candidates", INT, _CANDIDATES),
    Property("paths", "paths", INT, _PATHS),
    Property("max_stretch", "maxStretch", DOUBLE, _STRETCH),
    Property("scale", "scale", BOOL),
    Property("join_time", "joinTime", DOUBLE, _DURATION),
    Property("contacts", "contacts", TOKEN, _CONTACTS),
)
_SEGMENT_PROPERTIES = (
    Property("start", "start", TIME_CODE, FINITE),
    Property("end", "end", TIME_CODE, FINITE),
    *(
        rule
        for rule in _SKETCH_PROPERTIES
        if rule.name in {"match", "break", "matchBand", "texture", "synthesize", "textureBands", "scale"}
    ),
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
    others = [name.removeprefix("mtex:") for name in (TAKES_PROPERTY, EDITS_PROPERTY)]
    check_names(prim, "mtex:", [*others, *(known.name for known in _SKETCH_PROPERTIES)])
    fields = read_properties(prim, "mtex:", _SKETCH_PROPERTIES)
    return Recipe(**fields, segments=_read_segments(prim))


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
    check_names(prim, prefix, [known.name for known in _SEGMENT_PROPERTIES])
    fields = read_properties(prim, prefix, _SEGMENT_PROPERTIES)
    for name in ("start", "end"):
        if name not in fields:
            raise InputError(f"{prim.GetPath()}: segment {instance} has no {name}", expected=f"timecode {prefix}{name}")
    segment = Segment(name=instance, **fields)
    if not segment.start < segment.end:
        raise InputError(
            f"{prim.GetPath()}: segment {instance} is empty", expected="start before end", found=_span(segment)
        )
    return segment
