"""Constraints on motion: retargeting onto other characters, contacts, inverse kinematics, spacetime.

The public functions are loaded when they are first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mtex_usd.constraints.contacts import detect_contacts
    from mtex_usd.constraints.ik import solve_ik
    from mtex_usd.constraints.planting import retarget_with_contacts
    from mtex_usd.constraints.retargeting import retarget
    from mtex_usd.constraints.spacetime import solve_spacetime

__all__ = ["detect_contacts", "retarget", "retarget_with_contacts", "solve_ik", "solve_spacetime"]

_HOMES = {
    "detect_contacts": "contacts",
    "retarget": "retargeting",
    "retarget_with_contacts": "planting",
    "solve_ik": "ik",
    "solve_spacetime": "spacetime",
}


def __getattr__(name: str) -> object:
    """Load a public function from the package it lives in."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    """List the public names without loading them."""
    return sorted({*globals(), *__all__})
