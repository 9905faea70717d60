"""Key reduction: motion as few keys (Gleicher 2000, section 1.5), as cubic curves or as sparse poses."""

from mtex_usd.edit.keys.curves import KeyCurve, ReducedKeys
from mtex_usd.edit.keys.poses import ReducedPoses, reduce_poses
from mtex_usd.edit.keys.reduce import reduce_keys
from mtex_usd.edit.keys.tolerance import Tolerance

__all__ = ["KeyCurve", "ReducedKeys", "ReducedPoses", "Tolerance", "reduce_keys", "reduce_poses"]
