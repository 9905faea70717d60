"""What a property of the schemas may hold, and reading properties with every check a user needs."""

import difflib
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pxr import Gf, Sdf, Usd, Vt

from mtex_usd.errors import InputError
from mtex_usd.usd.schema.applied import authored, where

__all__ = [
    "ANY",
    "BOOL",
    "DOUBLE",
    "DOUBLE2",
    "DOUBLE2S",
    "DOUBLE3S",
    "DOUBLES",
    "FINITE",
    "INT",
    "INT2",
    "POINT",
    "TIME_CODE",
    "TIME_CODES",
    "TOKEN",
    "TOKENS",
    "Kind",
    "Property",
    "Rule",
    "check_names",
    "read_properties",
]


@dataclass(frozen=True)
class Kind:
    """A value type of the schema: its name in USD, what Python gets, and how to make it plain."""

    type_name: str
    python_types: tuple[type, ...]
    convert: Callable[[Any], Any]

    def read(self, prim: Usd.Prim, name: str) -> Any:
        """Read an attribute, None where nothing is authored; InputError where it has another type."""
        value = authored(prim, name)
        if value is None:
            return None
        if isinstance(value, bool) != (bool in self.python_types) or not isinstance(value, self.python_types):
            found = f"{Sdf.GetValueTypeNameForValue(value)} {value}"
            raise InputError(f"{where(prim, name)} has the wrong type", expected=self.type_name, found=found)
        return self.convert(value)


# Widening (string to token, int or float to double) loses nothing and is let through; double for timecode is not, since
# layer offsets would not move it.
TOKEN = Kind("token", (str,), str)
TOKENS = Kind("token[]", (Vt.TokenArray,), lambda value: tuple(map(str, value)))
BOOL = Kind("bool", (bool,), bool)
INT = Kind("int", (int,), int)
INT2 = Kind("int2", (Gf.Vec2i,), lambda value: (int(value[0]), int(value[1])))
DOUBLE = Kind("double", (float, int), float)
POINT = Kind("point3d", (Gf.Vec3d, Gf.Vec3f), lambda value: (float(value[0]), float(value[1]), float(value[2])))
DOUBLES = Kind("double[]", (Vt.DoubleArray,), lambda value: tuple(map(float, value)))
DOUBLE2 = Kind("double2", (Gf.Vec2d,), lambda value: tuple(map(float, value)))
DOUBLE2S = Kind("double2[]", (Vt.Vec2dArray,), lambda value: tuple(tuple(map(float, row)) for row in value))
DOUBLE3S = Kind("double3[]", (Vt.Vec3dArray,), lambda value: tuple(tuple(map(float, row)) for row in value))
TIME_CODES = Kind("timecode[]", (Sdf.TimeCodeArray,), lambda value: tuple(float(code.GetValue()) for code in value))
TIME_CODE = Kind("timecode", (Sdf.TimeCode,), lambda value: float(value.GetValue()))


@dataclass(frozen=True)
class Rule:
    """What values are allowed, in code and in words."""

    allows: Callable[[Any], bool]
    expected: str


ANY = Rule(lambda _: True, "")
FINITE = Rule(math.isfinite, "a finite time code")


@dataclass(frozen=True)
class Property:
    """One schema property: the field it fills, its name below the schema's prefix, type and allowed values."""

    field: str
    name: str
    kind: Kind
    rule: Rule = ANY


def read_properties(prim: Usd.Prim, prefix: str, properties: tuple[Property, ...]) -> dict[str, Any]:
    """Read what is authored, by field name; each value is checked against its type and rule."""
    fields = {}
    for schema_property in properties:
        name = prefix + schema_property.name
        value = schema_property.kind.read(prim, name)
        if value is None:
            continue
        if not schema_property.rule.allows(value):
            raise InputError(
                f"{where(prim, name)} is not allowed", expected=schema_property.rule.expected, found=str(value)
            )
        fields[schema_property.field] = value
    return fields


def check_names(prim: Usd.Prim, prefix: str, known: list[str]) -> None:
    """Refuse misspelt properties, which would change the result in silence."""
    for name in map(str, prim.GetAuthoredPropertyNames()):
        base = name.removeprefix(prefix)
        if not name.startswith(prefix) or ":" in base or base in known:
            continue
        close = difflib.get_close_matches(base, known, n=1)
        raise InputError(
            f"{where(prim, name)} is not a property of the mtex schemas",
            expected=f"one of {', '.join(prefix + base for base in sorted(known))}",
            fix=f"Did you mean {prefix}{close[0]}?" if close else "Remove it or give it another namespace.",
        )
