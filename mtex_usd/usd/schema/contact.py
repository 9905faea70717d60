"""MtexContactAPI: points of joints that touch something, declared on an animation."""

import math
from dataclasses import dataclass

from pxr import Sdf, Usd

from mtex_usd.errors import InputError, StageError
from mtex_usd.usd.schema.applied import api_instances, where
from mtex_usd.usd.schema.properties import (
    DOUBLE,
    POINT,
    TIME_CODES,
    TOKEN,
    Property,
    Rule,
    check_names,
    read_properties,
)
from mtex_usd.usd.schema.targets import check_dropped

__all__ = ["CONTACT_API", "CONTACT_MODES", "ContactSettings", "read_contacts"]

CONTACT_API = "MtexContactAPI"
CONTACT_MODES = ("plant", "slide", "follow", "touch")

_POSITIVE = Rule(lambda value: math.isfinite(value) and value > 0.0, "a finite number above 0")
_PLACE = Rule(lambda value: all(map(math.isfinite, value)), "finite coordinates")
_MODE = Rule(lambda value: value in CONTACT_MODES, " or ".join(f'"{mode}"' for mode in CONTACT_MODES))
_JOINT = Rule(bool, "the name of a joint")
_INTERVALS = Rule(
    lambda value: (
        len(value) % 2 == 0
        and all(map(math.isfinite, value))
        and all(a <= b for a, b in zip(value[::2], value[1::2], strict=True))
        and all(b < a for b, a in zip(value[1::2], value[2::2], strict=False))
    ),
    "start and end in turn, in order of time and apart",
)
_PROPERTIES = (
    Property("joint", "joint", TOKEN, _JOINT),
    Property("offset", "offset", POINT, _PLACE),
    Property("intervals", "intervals", TIME_CODES, _INTERVALS),
    Property("mode", "mode", TOKEN, _MODE),
    Property("point", "point", POINT, _PLACE),
    Property("tolerance", "tolerance", DOUBLE, _POSITIVE),
    Property("frequency", "frequency", DOUBLE, _POSITIVE),
)


@dataclass(frozen=True, kw_only=True)
class ContactSettings:
    """What one instance of MtexContactAPI says.

    Parameters
    ----------
    name
        The instance's.
    joint
        Path or last name of the joint.
    offset
        The point in the joint's space, skeleton units.
    intervals
        Start and end in turn, time codes of the stage; empty to detect them.
    mode
        One of `CONTACT_MODES`.
    target
        The prim that is touched.
    point
        In the target's space, or the world's.
    tolerance
        Metres.
    frequency
        Of the change, Hz.
    """

    name: str
    joint: str
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    intervals: tuple[float, ...] = ()
    mode: str = "plant"
    target: Sdf.Path | None = None
    point: tuple[float, float, float] | None = None
    tolerance: float = 0.0005
    frequency: float = 6.0


def read_contacts(prim: Usd.Prim) -> tuple[ContactSettings, ...]:
    """Read and check every contact declared on an animation.

    Parameters
    ----------
    prim
        A SkelAnimation.

    Returns
    -------
    tuple of ContactSettings
        By name; none where the schema is not applied.

    Raises
    ------
    InputError
        Where a property is misspelt, of the wrong type, changes over time or is out of range, where no joint is named,
        and where what is followed or touched is not said.
    StageError
        Where composition dropped a target.
    """
    return tuple(_read_contact(prim, name) for name in sorted(api_instances(prim, CONTACT_API)))


def _read_contact(prim: Usd.Prim, name: str) -> ContactSettings:
    prefix = f"mtex:contact:{name}:"
    check_names(prim, prefix, ["target", *(known.name for known in _PROPERTIES)])
    fields = read_properties(prim, prefix, _PROPERTIES)
    if "joint" not in fields:
        raise InputError(f"{prim.GetPath()}: contact {name} names no joint", expected=f"token {prefix}joint")
    contact = ContactSettings(name=name, target=_read_target(prim, f"{prefix}target"), **fields)
    if contact.mode in {"plant", "slide"} and contact.target is not None:
        message = f"{prim.GetPath()}: contact {name} would keep still on a target"
        raise InputError(message, expected='mode "follow" or "touch", or no target', found=f'"{contact.mode}"')
    if contact.mode == "follow" and contact.target is None:
        raise InputError(f"{prim.GetPath()}: contact {name} follows nothing", expected=f"rel {prefix}target")
    if contact.mode == "touch" and contact.target is None and contact.point is None:
        expected = f"rel {prefix}target or point3d {prefix}point"
        raise InputError(f"{prim.GetPath()}: contact {name} touches nothing", expected=expected)
    if contact.mode in {"follow", "touch"} and not contact.intervals:
        expected = f"timecode[] {prefix}intervals"
        raise InputError(f"{prim.GetPath()}: contact {name} has no time; only the floor is found", expected=expected)
    return contact


def _read_target(prim: Usd.Prim, name: str) -> Sdf.Path | None:
    relationship = prim.GetRelationship(name)
    if not relationship:
        return None
    targets = relationship.GetForwardedTargets()
    check_dropped(relationship, targets)
    if len(targets) > 1:
        found = ", ".join(map(str, targets))
        raise InputError(f"{where(prim, name)} is ambiguous", expected="one prim", found=found)
    if targets and not prim.GetStage().GetPrimAtPath(targets[0]):
        raise StageError(f"{where(prim, name)} names a prim that is not there", found=str(targets[0]))
    return targets[0] if targets else None
