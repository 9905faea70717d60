"""Inverse kinematics: the pose nearest to a given one that puts points of the body where they are wanted."""

from mtex_usd.constraints.ik.goals import Goal
from mtex_usd.constraints.ik.limits import JointLimits, make_joint_limits
from mtex_usd.constraints.ik.result import IkResult
from mtex_usd.constraints.ik.solve import solve_ik
from mtex_usd.constraints.ik.two_bone import solve_two_bone

__all__ = ["Goal", "IkResult", "JointLimits", "make_joint_limits", "solve_ik", "solve_two_bone"]
