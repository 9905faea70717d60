"""Planting: what is made of a motion keeps the contacts it has to keep."""

from mtex_usd.constraints.planting.carried_over import retarget_with_contacts
from mtex_usd.constraints.planting.holding import Held, hold_motion, restore_feet
from mtex_usd.constraints.planting.limits import JointRange, to_ranges
from mtex_usd.constraints.planting.plan import (
    Hold,
    describe_holds,
    find_limb,
    held_back,
    merge_holds,
    plan_contacts,
    to_constraints,
)

__all__ = [
    "Held",
    "Hold",
    "JointRange",
    "describe_holds",
    "find_limb",
    "held_back",
    "hold_motion",
    "merge_holds",
    "plan_contacts",
    "restore_feet",
    "retarget_with_contacts",
    "to_constraints",
    "to_ranges",
]
