"""Retargeting: motion of one humanoid on the skeleton of another."""

from mtex_usd.constraints.retargeting.fitting import FittedTake, fit_take
from mtex_usd.constraints.retargeting.joint_map import JointMap, Pair, as_pairs, map_joints
from mtex_usd.constraints.retargeting.retarget import retarget, retarget_mapped

__all__ = ["FittedTake", "JointMap", "Pair", "as_pairs", "fit_take", "map_joints", "retarget", "retarget_mapped"]
