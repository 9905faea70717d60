"""Constraints on motion: retargeting onto other characters, contacts, inverse kinematics, spacetime."""

from mtex_usd.constraints.retargeting import retarget

__all__ = ["retarget"]
