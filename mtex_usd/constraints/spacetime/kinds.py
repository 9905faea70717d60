"""The constraints a problem can have: small objects that say what shall hold, where and when.

Places, offsets, heights and distances are in skeleton units, in skeleton space; tolerances in metres or radians; frames
count from the clip's first. Each object only says which rows it comes down to; a new kind needs nothing else.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.spacetime.scene import Point, Scene
from mtex_usd.errors import InputError

__all__ = [
    "Constraint",
    "DistanceBetween",
    "MassOver",
    "OrientationAt",
    "PathFollow",
    "PlaneAbove",
    "PlaneOn",
    "PointAt",
    "PointStill",
    "RotationRange",
]

LENGTH_TOLERANCE = 1e-4  # metres
ANGLE_TOLERANCE = 1e-3  # radians


@runtime_checkable
class Constraint(Protocol):
    """What every constraint has."""

    @property
    def name(self) -> str:
        """What messages call it; unique in a problem."""

    @property
    def tolerance(self) -> float:
        """How far from met it may be, in metres or radians."""

    def write(self, scene: Scene) -> None:
        """Add the rows it comes down to."""


@dataclass(frozen=True, eq=False)
class PointAt:
    """A point of a joint is at a place.

    Parameters
    ----------
    name
        What messages call it.
    point
        The point.
    frames
        When, whole frames, [N].
    place
        Where, [3] or, one per frame, [N, 3].
    tolerance
        Metres.
    """

    name: str
    point: Point
    frames: npt.ArrayLike
    place: npt.ArrayLike
    tolerance: float = field(default=LENGTH_TOLERANCE, kw_only=True)

    def write(self, scene: Scene) -> None:
        """Add three rows per frame."""
        scene.add_coordinates(self.point, self.frames, np.eye(3), self.place)


@dataclass(frozen=True, eq=False)
class PointStill:
    """A point of a joint does not move during an interval; where it stays is free.

    Parameters
    ----------
    name
        What messages call it.
    point
        The point.
    frames
        When, whole frames, [N].
    tolerance
        How far from its place, metres.
    """

    name: str
    point: Point
    frames: npt.ArrayLike
    tolerance: float = field(default=LENGTH_TOLERANCE, kw_only=True)

    def write(self, scene: Scene) -> None:
        """Add a free place and three rows per frame."""
        scene.add_still(self.point, self.frames)


@dataclass(frozen=True, eq=False)
class PlaneAbove:
    """A point of a joint stays on one side of a plane.

    Parameters
    ----------
    name
        What messages call it.
    point
        The point.
    frames
        When, whole frames, [N].
    height
        Least coordinate along the normal, a number or one per frame, [N].
    normal
        Unit normal of the plane, [3]; None for the skeleton's up.
    tolerance
        How far below it may be, metres.
    """

    name: str
    point: Point
    frames: npt.ArrayLike
    height: npt.ArrayLike
    normal: npt.ArrayLike | None = None
    tolerance: float = field(default=LENGTH_TOLERANCE, kw_only=True)

    def write(self, scene: Scene) -> None:
        """Add one inequality per frame."""
        normal = scene.normal_of(self.point.clip, self.normal)
        scene.add_heights(self.point, self.frames, -normal, -np.asarray(self.height, dtype=float), inequality=True)


@dataclass(frozen=True, eq=False)
class PlaneOn:
    """A point of a joint lies in a plane.

    Parameters
    ----------
    name
        What messages call it.
    point
        The point.
    frames
        When, whole frames, [N].
    height
        Coordinate along the normal, a number or one per frame, [N].
    normal
        Unit normal of the plane, [3]; None for the skeleton's up.
    tolerance
        Metres.
    """

    name: str
    point: Point
    frames: npt.ArrayLike
    height: npt.ArrayLike
    normal: npt.ArrayLike | None = None
    tolerance: float = field(default=LENGTH_TOLERANCE, kw_only=True)

    def write(self, scene: Scene) -> None:
        """Add one row per frame."""
        normal = scene.normal_of(self.point.clip, self.normal)
        scene.add_heights(self.point, self.frames, normal, np.asarray(self.height, dtype=float), inequality=False)


@dataclass(frozen=True, eq=False)
class OrientationAt:
    """A joint has an orientation in skeleton space.

    Parameters
    ----------
    name
        What messages call it.
    joint
        Joint path, or its last name where that is unique.
    frames
        When, whole frames, [N].
    orientation
        Unit quaternion, real first, [4] or, one per frame, [N, 4].
    clip
        Number of the character.
    tolerance
        Radians.
    """

    name: str
    joint: str
    frames: npt.ArrayLike
    orientation: npt.ArrayLike
    clip: int = field(default=0, kw_only=True)
    tolerance: float = field(default=ANGLE_TOLERANCE, kw_only=True)

    def write(self, scene: Scene) -> None:
        """Add three rows per frame."""
        scene.add_orientations(self.joint, self.clip, self.frames, self.orientation)


@dataclass(frozen=True, eq=False)
class RotationRange:
    """A joint's angles relative to rest stay in a range.

    Parameters
    ----------
    name
        What messages call it.
    joint
        Joint path, or its last name where that is unique.
    frames
        When, whole frames, [N].
    lower, upper
        Degrees about x, y and z, [3]; infinite for no limit. Where both are the same the axis is locked.
    order
        Intrinsic order of the three rotations.
    axes
        Orientation, in skeleton space and at rest, of the axes that the angles are about: a unit quaternion, real
        first. The fallback stands for the skeleton's own axes.
    clip
        Number of the character.
    tolerance
        Radians.
    """

    name: str
    joint: str
    frames: npt.ArrayLike
    lower: npt.ArrayLike
    upper: npt.ArrayLike
    order: str = field(default="XYZ", kw_only=True)
    axes: npt.ArrayLike = field(default=(1.0, 0.0, 0.0, 0.0), kw_only=True)
    clip: int = field(default=0, kw_only=True)
    tolerance: float = field(default=ANGLE_TOLERANCE, kw_only=True)

    def write(self, scene: Scene) -> None:
        """Add up to two rows per axis and frame."""
        scene.add_range(self.joint, self.clip, self.frames, self.lower, self.upper, self.order, self.axes)


@dataclass(frozen=True, eq=False)
class DistanceBetween:
    """Two points, of one or of two characters, are a distance apart.

    Parameters
    ----------
    name
        What messages call it.
    point, other
        The points.
    frames
        When, whole frames, [N].
    distance
        How far apart, a number or one per frame, [N]; zero everywhere for points that meet.
    tolerance
        Metres.
    """

    name: str
    point: Point
    other: Point
    frames: npt.ArrayLike
    distance: npt.ArrayLike
    tolerance: float = field(default=LENGTH_TOLERANCE, kw_only=True)

    def write(self, scene: Scene) -> None:
        """Add one row per frame, three for points that meet."""
        distance = np.asarray(self.distance, dtype=float)
        if (distance < 0.0).any() or (distance.any() and not distance.all()):
            raise InputError(
                f"constraint {self.name}: bad distance",
                expected="above 0 at all frames, or 0 at all frames",
                found=f"{distance.min():g} to {distance.max():g}",
            )
        if distance.any():
            scene.add_distances(self.point, self.other, self.frames, distance)
        else:
            scene.add_coordinates(self.point, self.frames, np.eye(3), np.zeros(3), other=self.other)


@dataclass(frozen=True, eq=False)
class PathFollow:
    """A point of a joint follows a path at given times.

    Parameters
    ----------
    name
        What messages call it.
    point
        The point.
    times
        Increasing times in frames, not necessarily whole, at least two, [P].
    places
        Where the point is then, [P, 3]; between them on the natural cubic spline through them.
    tolerance
        Metres.
    """

    name: str
    point: Point
    times: npt.ArrayLike
    places: npt.ArrayLike
    tolerance: float = field(default=LENGTH_TOLERANCE, kw_only=True)

    def write(self, scene: Scene) -> None:
        """Add three rows for every whole frame from the first time to the last."""
        from scipy.interpolate import CubicSpline  # noqa: PLC0415  (slow to import, seldom used)

        times, places = np.asarray(self.times, dtype=float), np.asarray(self.places, dtype=float)
        if times.ndim != 1 or len(times) < 2 or places.shape != (len(times), 3) or (np.diff(times) <= 0.0).any():
            raise InputError(
                f"constraint {self.name}: bad path",
                expected="at least two increasing times and a place for each",
                found=f"times of shape {times.shape}, places of shape {places.shape}",
            )
        frames = np.arange(int(np.ceil(times[0])), int(np.floor(times[-1])) + 1)
        curve = CubicSpline(times, places, bc_type="natural")
        scene.add_coordinates(self.point, frames, np.eye(3), curve(frames))


@dataclass(frozen=True, eq=False)
class MassOver:
    """The centre of mass is over a convex area of support.

    Parameters
    ----------
    name
        What messages call it.
    corners
        At least three points whose horizontal hull is the area, [V, 3].
    frames
        When, whole frames, [N].
    margin
        How far inside the area's border, skeleton units.
    masses
        What each joint counts, any scale; None to give each bone a mass as its length.
    clip
        Number of the character.
    tolerance
        Metres.

    Notes
    -----
    Gleicher 2000, section 1.7.2.1, names missing balance as the cause of a bad result; this is the simplest cure: it
    knows weight, and nothing of momentum, so it is meant for standing and slow motion.
    """

    name: str
    corners: npt.ArrayLike
    frames: npt.ArrayLike
    margin: float = field(default=0.0, kw_only=True)
    masses: Sequence[float] | None = field(default=None, kw_only=True)
    clip: int = field(default=0, kw_only=True)
    tolerance: float = field(default=LENGTH_TOLERANCE, kw_only=True)

    def write(self, scene: Scene) -> None:
        """Add one inequality per side of the area and frame."""
        scene.add_balance(self.corners, self.frames, self.margin, self.masses, self.clip)
