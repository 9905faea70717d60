"""Spacetime constraints: the least change of a whole motion that meets constraints, solved over all frames at once."""

from mtex_usd.constraints.spacetime.kinds import (
    Constraint,
    DistanceBetween,
    MassOver,
    OrientationAt,
    PathFollow,
    PlaneAbove,
    PlaneOn,
    PointAt,
    PointStill,
    RotationRange,
)
from mtex_usd.constraints.spacetime.near import resolve_near
from mtex_usd.constraints.spacetime.scene import Point
from mtex_usd.constraints.spacetime.solution import Displacement, Solution, measure_energy_above
from mtex_usd.constraints.spacetime.solve import solve_spacetime

__all__ = [
    "Constraint",
    "Displacement",
    "DistanceBetween",
    "MassOver",
    "OrientationAt",
    "PathFollow",
    "PlaneAbove",
    "PlaneOn",
    "Point",
    "PointAt",
    "PointStill",
    "RotationRange",
    "Solution",
    "measure_energy_above",
    "resolve_near",
    "solve_spacetime",
]
