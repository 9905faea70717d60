"""Constraints on motion: retargeting onto other characters, contacts, inverse kinematics, spacetime.

The public functions are loaded when they are first used.
"""

from typing import TYPE_CHECKING

from mtex_usd.lazy import load_lazily

if TYPE_CHECKING:
    from mtex_usd.constraints.contacts import detect_contacts
    from mtex_usd.constraints.ik import solve_ik
    from mtex_usd.constraints.planting import retarget_with_contacts
    from mtex_usd.constraints.retargeting import retarget
    from mtex_usd.constraints.spacetime import solve_spacetime

__all__ = ["detect_contacts", "retarget", "retarget_with_contacts", "solve_ik", "solve_spacetime"]

__getattr__, __dir__ = load_lazily(
    __name__,
    {
        "contacts": ("detect_contacts",),
        "ik": ("solve_ik",),
        "planting": ("retarget_with_contacts",),
        "retargeting": ("retarget",),
        "spacetime": ("solve_spacetime",),
    },
)
