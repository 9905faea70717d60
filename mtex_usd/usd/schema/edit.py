"""MtexEditAPI and MtexEditStackAPI: edits of a motion, and which of them are made in what order."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pxr import Sdf, Usd

from mtex_usd.edit.stack.operations import OPERATIONS
from mtex_usd.errors import InputError, StageError
from mtex_usd.usd.schema.applied import api_instances, authored, has_api, where
from mtex_usd.usd.schema.properties import (
    ANY,
    BOOL,
    DOUBLE,
    DOUBLE2,
    DOUBLE2S,
    DOUBLE3S,
    DOUBLES,
    FINITE,
    INT,
    TIME_CODE,
    TIME_CODES,
    TOKEN,
    TOKENS,
    Kind,
    Property,
    Rule,
    check_names,
    read_properties,
)
from mtex_usd.usd.schema.targets import check_dropped

__all__ = ["EDITS_PROPERTY", "EDIT_API", "EDIT_STACK_API", "EditSettings", "EditStacks", "read_edit", "read_stacks"]

EDIT_API = "MtexEditAPI"
EDIT_STACK_API = "MtexEditStackAPI"
EDITS_PROPERTY = "mtex:edits"

_EDITED = "edited"  # the variant of mtex:edits itself
_RESERVED = ("original", _EDITED, "constrained")
_OF_TEXTURING = re.compile(r"path_\d+")  # layers of several commands share a variant set where they are stacked
_BEFORE, _AFTER = "before", "after"


def _one_of(*choices: str) -> Rule:
    return Rule(lambda value: value in choices, " or ".join(f'"{choice}"' for choice in choices))


def _all_finite(value: Any) -> bool:
    return all(map(_all_finite, value)) if isinstance(value, tuple) else math.isfinite(value)


_POSITIVE = Rule(lambda value: math.isfinite(value) and value > 0.0, "a finite number above 0")
_NOT_NEGATIVE = Rule(lambda value: math.isfinite(value) and value >= 0.0, "a finite number, at least 0")
_NUMBERS = Rule(_all_finite, "finite numbers")
_TIMES = Rule(_all_finite, "finite time codes")
_DURATIONS = Rule(lambda value: _all_finite(value) and min(value) > 0.0, "two numbers of seconds above 0")
_GAINS = Rule(lambda value: all(gain < math.inf for gain in value), "decibels, -inf to mute")
_LEVEL = Rule(lambda value: value < math.inf, "decibels, -inf to mute")
_PART = Rule(lambda value: 0.0 <= value <= 0.5, "a number from 0 to 0.5")
_ORDER = Rule(lambda value: 1 <= value <= 16, "a whole number from 1 to 16")
_WHOLE = Rule(lambda value: value >= 1, "a whole number, at least 1")
_LIMITS = Rule(lambda value: value[0] < value[1], "the lower limit below the upper")


def _setting(name: str, kind: Kind, rule: Rule = ANY) -> Property:
    return Property(name, name, kind, rule)


_PROPERTIES = (
    _setting("op", TOKEN, _one_of(*OPERATIONS)),
    _setting("channels", TOKENS),
    _setting("start", TIME_CODE, FINITE),
    _setting("end", TIME_CODE, FINITE),
    _setting("ramp", DOUBLE, _NOT_NEGATIVE),
    _setting("frequencies", DOUBLES, _NUMBERS),
    _setting("order", INT, _ORDER),
    _setting("gains", DOUBLES, _GAINS),
    _setting("residualGain", DOUBLE, _LEVEL),
    _setting("window", DOUBLE, _POSITIVE),
    _setting("discard", DOUBLE, _PART),
    _setting("points", DOUBLE2S, _NUMBERS),
    _setting("about", TOKEN, _one_of("mean", "rest")),
    _setting("limits", DOUBLE2, _LIMITS),
    _setting("softness", DOUBLE, _POSITIVE),
    _setting("plane", TOKEN, _one_of("rest", "facing")),
    _setting("factor", DOUBLE, _POSITIVE),
    _setting("from", TIME_CODES, _TIMES),
    _setting("to", TIME_CODES, _TIMES),
    _setting("ends", TOKEN, _one_of("hold", "loop", "extrapolate")),
    _setting("weights", DOUBLES, _NUMBERS),
    _setting("keys", TIME_CODES, _TIMES),
    _setting("align", BOOL),
    _setting("place", TOKEN, _one_of("first", "mean")),
    _setting("maxSlope", INT, _WHOLE),
    _setting("band", DOUBLE, _POSITIVE),
    _setting("free", DOUBLE, _NOT_NEGATIVE),
    _setting("joinTime", DOUBLE, _POSITIVE),
    _setting("method", TOKEN, _one_of("auto", "blend", "interpolate")),
    _setting("rotations", DOUBLE3S, _NUMBERS),
    _setting("translations", DOUBLE3S, _NUMBERS),
    _setting("scope", DOUBLE2, _DURATIONS),
    _setting("tolerance", DOUBLE, _POSITIVE),
    _setting("distance", DOUBLE, _POSITIVE),
    _setting("keyCount", INT, _NOT_NEGATIVE),
    _setting("form", TOKEN, _one_of("curves", "poses")),
    _setting("contacts", TOKEN, _one_of("off", "detect", "declared")),
    _setting("robust", BOOL),
)


@dataclass(frozen=True, kw_only=True)
class EditSettings:
    """What one instance of MtexEditAPI says.

    Parameters
    ----------
    name
        The instance's.
    op
        The operation.
    settings
        What else is authored, by the name of the property; time codes are those of the stage.
    others
        Targets of ``with``.
    """

    name: str
    op: str
    settings: Mapping[str, Any]
    others: tuple[Sdf.Path, ...]


@dataclass(frozen=True, kw_only=True)
class EditStacks:
    """What MtexEditStackAPI says: names of edits, in order.

    Parameters
    ----------
    variants
        By the name of the variant they make.
    before, after
        What is done before matching and after texturing.
    """

    variants: Mapping[str, tuple[str, ...]]
    before: tuple[str, ...] = ()
    after: tuple[str, ...] = ()


def read_stacks(prim: Usd.Prim) -> EditStacks:
    """Read and check the stacks of edits on an animation.

    Parameters
    ----------
    prim
        A SkelAnimation.

    Returns
    -------
    EditStacks
        Empty where MtexEditStackAPI is not applied. Empty stacks make no variant.

    Raises
    ------
    InputError
        Where a stack is of the wrong type, names an edit twice or one that is not applied, or has a name that a variant
        cannot have.
    """
    if not has_api(prim, EDIT_STACK_API):
        return EditStacks(variants={})
    stacks = {name: _read_names(prim, name) for name in _stack_properties(prim)}
    before, after = (stacks.pop(f"{EDITS_PROPERTY}:{name}", ()) for name in (_BEFORE, _AFTER))
    return EditStacks(
        variants={_variant_name(prim, name): edits for name, edits in stacks.items() if edits},
        before=before,
        after=after,
    )


def _stack_properties(prim: Usd.Prim) -> list[str]:
    """Names of the properties that list edits, that of the variant ``edited`` first."""
    names = map(str, prim.GetAuthoredPropertyNames())
    return sorted(name for name in names if name == EDITS_PROPERTY or name.startswith(f"{EDITS_PROPERTY}:"))


def _variant_name(prim: Usd.Prim, name: str) -> str:
    if name == EDITS_PROPERTY:
        return _EDITED
    variant = name.removeprefix(f"{EDITS_PROPERTY}:")
    if variant in _RESERVED or _OF_TEXTURING.fullmatch(variant) or ":" in variant:
        raise InputError(
            f"{where(prim, name)} cannot be the name of a stack",
            expected=f"one name, and none of {', '.join(_RESERVED)}, path_01 and on, which other commands make",
            found=variant,
        )
    return variant


def _read_names(prim: Usd.Prim, name: str) -> tuple[str, ...]:
    edits: tuple[str, ...] = TOKENS.read(prim, name) or ()
    known = api_instances(prim, EDIT_API)
    for edit in edits:
        if edit not in known:
            raise InputError(
                f"{where(prim, name)} names an edit that is not there",
                expected=f"instances of {EDIT_API} on this prim: {', '.join(known) or 'there are none'}",
                found=edit,
                fix=f"Apply {EDIT_API}:{edit}, or correct the name.",
            )
        if edits.count(edit) > 1:
            raise InputError(f"{where(prim, name)} names {edit} twice", fix="Apply a second edit with its settings.")
    return edits


def read_edit(prim: Usd.Prim, name: str) -> EditSettings:
    """Read and check one edit on an animation; whether its operation takes what is said is not asked here.

    Parameters
    ----------
    prim
        A SkelAnimation.
    name
        An instance of MtexEditAPI.

    Raises
    ------
    InputError
        Where a property is misspelt, of the wrong type, changes over time or is out of range, or no operation is named.
    StageError
        Where composition dropped a target, or a target is no SkelAnimation.
    """
    prefix = f"mtex:edit:{name}:"
    check_names(prim, prefix, ["with", *(known.name for known in _PROPERTIES)])
    if authored(prim, f"{prefix}op") in (None, ""):
        expected = f"token {prefix}op, one of {', '.join(OPERATIONS)}"
        raise InputError(f"{prim.GetPath()}: edit {name} has no operation", expected=expected)
    settings = read_properties(prim, prefix, _PROPERTIES)
    op = settings.pop("op")
    return EditSettings(name=name, op=op, settings=settings, others=_read_others(prim, f"{prefix}with"))


def _read_others(prim: Usd.Prim, name: str) -> tuple[Sdf.Path, ...]:
    relationship = prim.GetRelationship(name)
    if not relationship:
        return ()
    targets = relationship.GetForwardedTargets()
    check_dropped(relationship, targets)
    for target in targets:
        found = _describe_other(prim.GetStage(), target)
        if found:
            raise StageError(f"{where(prim, name)} names no animation", expected="SkelAnimations", found=found)
    return tuple(targets)


def _describe_other(stage: Usd.Stage, target: Sdf.Path) -> str:
    """Say what a target is that is no animation; nothing where it is one."""
    other = stage.GetPrimAtPath(target)
    if not other:
        return f"{target}, which is not there"
    if not other.IsActive():
        return f"{target}, which is inactive"
    return "" if other.IsA("SkelAnimation") else f"{target}, {other.GetTypeName() or 'a typeless prim'}"
