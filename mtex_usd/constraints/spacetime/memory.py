"""What is kept of a solve for solving a part again."""

from collections.abc import Mapping
from dataclasses import dataclass

from mtex_usd.constraints.spacetime.kinds import Constraint
from mtex_usd.constraints.spacetime.knots import Knots
from mtex_usd.constraints.spacetime.problem import Cast, Settings
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import FloatArray, IntArray

__all__ = ["Memory"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Memory:
    """What a later solve of a part goes on from.

    Parameters
    ----------
    clips
        The motion before.
    constraints
        All of them, by name.
    spans
        First and last frame each is about, by name.
    cast, settings
        Who may move and what that costs.
    knots
        The spline.
    coefficients
        Its coefficients, [K, C].
    places
        Where the points that keep still do so, by the constraint's name, metres, [3].
    pulls
        Frames and multipliers of each constraint's rows, by its name.
    """

    clips: tuple[Clip, ...]
    constraints: Mapping[str, Constraint]
    spans: Mapping[str, tuple[int, int]]
    cast: Cast
    settings: Settings
    knots: Knots
    coefficients: FloatArray
    places: Mapping[str, FloatArray]
    pulls: Mapping[str, tuple[IntArray, FloatArray]]
