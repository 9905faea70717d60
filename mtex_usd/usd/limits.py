"""Joint limits authored on a Skeleton as ``mtex:limits:<joint>:<channel>``, lower and upper in degrees."""

import numpy as np
from pxr import Gf, Usd

from mtex_usd.constraints.planting import JointRange
from mtex_usd.errors import InputError
from mtex_usd.motion.skeleton import FloatArray, Skeleton
from mtex_usd.usd.schema import authored

__all__ = ["read_limits"]

_PREFIX = "mtex:limits:"
_CHANNELS = ("rx", "ry", "rz")
_REAL_FIRST = [3, 0, 1, 2]  # USD keeps i, j, k, real in memory


def read_limits(prim: Usd.Prim, skeleton: Skeleton) -> tuple[JointRange, ...]:
    """Read how far joints may turn.

    Parameters
    ----------
    prim
        A Skeleton; ``customData["mtex"]["limitAxes"]`` says about which axes, the skeleton's own unless authored.
    skeleton
        As it was read.

    Returns
    -------
    tuple of JointRange
        One per joint that has a limit.

    Raises
    ------
    InputError
        Where a limit is of no joint or channel, of another type, or empty.
    """
    axes = _read_axes(prim, len(skeleton.joints))
    names = [joint.rpartition("/")[2] for joint in skeleton.joints]
    found: dict[int, tuple[FloatArray, FloatArray]] = {}
    for name in map(str, prim.GetAuthoredPropertyNames()):
        if not name.startswith(_PREFIX):
            continue
        joint_name, _, channel = name.removeprefix(_PREFIX).rpartition(":")
        if joint_name not in names or channel not in _CHANNELS:
            expected = f"{_PREFIX}<joint>:<rx, ry or rz>, the joint being one of {', '.join(names)}"
            raise InputError(f"{prim.GetPath()}.{name} limits nothing", expected=expected)
        lower, upper = _read_pair(prim, name)
        ranges = found.setdefault(names.index(joint_name), (np.full(3, -np.inf), np.full(3, np.inf)))
        ranges[0][_CHANNELS.index(channel)], ranges[1][_CHANNELS.index(channel)] = lower, upper
    return tuple(
        JointRange(joint=joint, axes=axes[joint], lower=lower, upper=upper) for joint, (lower, upper) in found.items()
    )


def _read_pair(prim: Usd.Prim, name: str) -> tuple[float, float]:
    value = authored(prim, name)
    if isinstance(value, Gf.Vec2d | Gf.Vec2f):
        lower, upper = np.asarray(value, dtype=np.float64).tolist()
        if lower <= upper:  # no number is above none
            return lower, upper
    raise InputError(f"{prim.GetPath()}.{name} is no range", expected="double2, lower and upper", found=str(value))


def _read_axes(prim: Usd.Prim, joint_count: int) -> FloatArray:
    axes = (prim.GetCustomDataByKey("mtex") or {}).get("limitAxes")
    if axes is None:
        return np.tile([1.0, 0.0, 0.0, 0.0], (joint_count, 1))
    values = np.asarray(axes, dtype=np.float64)
    if values.shape != (joint_count, 4):
        expected = f"{joint_count} rotations, one per joint"
        raise InputError(
            f"{prim.GetPath()}: limitAxes do not fit the joints", expected=expected, found=str(len(values))
        )
    return values[:, _REAL_FIRST]
