"""Collecting the rows of all constraints, in metres and by numbers instead of names."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.spacetime.angles import RangeTable
from mtex_usd.constraints.spacetime.mass import find_support_sides, mass_handle
from mtex_usd.constraints.spacetime.rows import DistanceTable, OrientationTable, PointTable, RowInfo
from mtex_usd.constraints.spacetime.samples import Handle
from mtex_usd.constraints.spacetime.turning import to_matrix
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import FloatArray, IntArray

__all__ = ["Point", "Scene", "find_joint"]

_NOWHERE = -1


@dataclass(frozen=True)
class Point:
    """A point that moves with a joint.

    Parameters
    ----------
    joint
        Joint path, or its last name where that is unique.
    offset
        Where it is in the joint's own space, skeleton units.
    clip
        Number of the character.
    """

    joint: str
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    clip: int = 0


def find_joint(clip: Clip, name: str) -> int:
    """Give the index of a joint by its path, or by its last name where that is unique.

    Raises
    ------
    InputError
        Where there is none, or there are several; lists what there is.
    """
    if name in clip.joints:
        return clip.joints.index(name)
    found = [i for i, joint in enumerate(clip.joints) if joint.rpartition("/")[2] == name]
    if len(found) != 1:
        there = ", ".join(clip.joints[i] for i in found) if found else ", ".join(clip.joints)
        raise InputError(f"no single joint {name} in clip {clip.name}", found=there, fix="Give a full joint path.")
    return found[0]


class Writes(Protocol):
    """What a scene has to know of a constraint."""

    @property
    def name(self) -> str:
        """What messages call it."""

    @property
    def tolerance(self) -> float:
        """How far from met it may be, in metres or radians."""

    def write(self, scene: "Scene") -> None:
        """Add the rows it comes down to."""


@dataclass(eq=False)
class Scene:
    """What constraints write into.

    Parameters
    ----------
    clips
        The characters.
    window
        First and last frame that count; what constraints say of others is left out.
    known_places
        Where the points that keep still do so, by the constraint's name, metres, [3].
    """

    clips: Sequence[Clip]
    window: tuple[int, int]
    known_places: Mapping[str, FloatArray] = field(default_factory=dict)
    points: list[PointTable] = field(default_factory=list)
    distances: list[DistanceTable] = field(default_factory=list)
    orientations: list[OrientationTable] = field(default_factory=list)
    ranges: list[RangeTable] = field(default_factory=list)
    handles: dict[Handle, int] = field(default_factory=dict)
    turns: dict[Handle, int] = field(default_factory=dict)
    place_frames: list[tuple[int, int]] = field(default_factory=list)
    place_owners: list[int] = field(default_factory=list)
    _name: str = ""
    _tolerance: float = 0.0
    _owner: int = 0
    _group_count: int = 0

    def write_all(self, constraints: Sequence["Writes"]) -> None:
        """Collect the rows of all constraints."""
        for number, constraint in enumerate(constraints):
            self._owner, self._name, self._tolerance = number, constraint.name, constraint.tolerance
            constraint.write(self)

    def normal_of(self, clip: int, normal: npt.ArrayLike | None) -> FloatArray:
        """Give a plane's unit normal; None stands for the skeleton's up."""
        given = self.clips[self._clip_number(clip)].skeleton.up if normal is None else np.asarray(normal, dtype=float)
        length = np.sqrt(given @ given) if given.shape == (3,) else 0.0
        if not (np.isfinite(length) and length > 0.0):
            raise self._wrong("bad normal", "three numbers, not all zero", str(given.tolist()))
        return np.asarray(given / length)

    def add_coordinates(
        self,
        point: Point,
        frames: npt.ArrayLike,
        axes: FloatArray,
        places: npt.ArrayLike,
        *,
        other: Point | None = None,
    ) -> None:
        """Ask for a point's coordinates along axes [M, 3] to be those of places [3] or [N, 3], or another point's."""
        given, inside = self._frames(frames)
        where = self._fit(places, len(given), 3)[inside] * self.unit
        sample = self._samples(point, given[inside])
        seen = np.full(len(sample), _NOWHERE) if other is None else self._samples(other, given[inside])
        self._add_points(given[inside], sample, seen, axes, where @ axes.T)

    def add_still(self, point: Point, frames: npt.ArrayLike) -> None:
        """Ask for a point to stay at a place of its own; at the one it had where the window cuts the interval."""
        given, inside = self._frames(frames)
        if not inside.all() and self._name in self.known_places:
            self.add_coordinates(point, given, np.eye(3), self.known_places[self._name] / self.unit)
            return
        if not inside.any():
            return
        kept = given[inside]
        number = len(self.place_frames)
        self.place_frames.append((int(kept.min()), int(kept.max())))
        self.place_owners.append(self._owner)
        sample = self._samples(point, kept)
        nothing = np.full(len(kept), _NOWHERE)
        self._add_points(kept, sample, nothing, np.eye(3), np.zeros((len(kept), 3)), place=number)

    def add_heights(
        self, point: Point, frames: npt.ArrayLike, normal: FloatArray, heights: FloatArray, *, inequality: bool
    ) -> None:
        """Ask for a point's coordinate along a normal to be a height, a number or [N], or not above it."""
        given, inside = self._frames(frames)
        bound = self._fit(heights[..., None], len(given), 1)[inside] * self.unit
        sample = self._samples(point, given[inside])
        nothing = np.full(len(sample), _NOWHERE)
        self._add_points(given[inside], sample, nothing, normal[None], bound, inequality=inequality)

    def add_distances(self, point: Point, other: Point, frames: npt.ArrayLike, distances: FloatArray) -> None:
        """Ask for two points to be distances apart, a number or [N]."""
        given, inside = self._frames(frames)
        kept = given[inside]
        distance = self._fit(distances[..., None], len(given), 1)[inside, 0] * self.unit
        info = self._info(kept, np.zeros((1, 3)), length=True, inequality=False, place=_NOWHERE)
        samples = self._samples(point, kept), self._samples(other, kept)
        self.distances.append(DistanceTable(info=info, sample=samples[0], other=samples[1], distance=distance))

    def add_orientations(self, joint: str, clip: int, frames: npt.ArrayLike, orientations: npt.ArrayLike) -> None:
        """Ask for a joint's orientation in skeleton space to be quaternions [4] or [N, 4]."""
        given, inside = self._frames(frames)
        kept = given[inside]
        target = quaternion.normalize(self._fit(orientations, len(given), 4)[inside])
        handle = Handle(clip, (find_joint(self.clips[self._clip_number(clip)], joint),))
        number = self.turns.setdefault(handle, len(self.turns))
        info = self._info(kept, np.zeros((3, 3)), length=False, inequality=False, place=_NOWHERE)
        sample = number * self.frame_count + kept
        self.orientations.append(OrientationTable(info=info, sample=sample, target=to_matrix(target)))

    def add_range(
        self,
        joint: str,
        clip: int,
        frames: npt.ArrayLike,
        lower: npt.ArrayLike,
        upper: npt.ArrayLike,
        order: str,
        axes: npt.ArrayLike,
    ) -> None:
        """Ask for a joint's angles about axes, turned by a quaternion [4], to be within ends [3] in degrees."""
        given, inside = self._frames(frames)
        low, high = np.radians(self._fit(lower, 1, 3)[0]), np.radians(self._fit(upper, 1, 3)[0])
        if sorted(order) != ["X", "Y", "Z"] or not (low <= high).all():
            found = f"order {order}, {np.degrees(low).tolist()} to {np.degrees(high).tolist()}"
            raise self._wrong("bad range", "an order of X, Y and Z, and lower ends not above upper", found)
        ends = [(axis, 0.0, low[axis]) for axis in range(3) if low[axis] == high[axis]]
        free = [axis for axis in range(3) if low[axis] < high[axis]]
        ends += [(axis, -1.0, low[axis]) for axis in free if np.isfinite(low[axis])]
        ends += [(axis, 1.0, high[axis]) for axis in free if np.isfinite(high[axis])]
        index = find_joint(self.clips[self._clip_number(clip)], joint)
        turned = to_matrix(quaternion.normalize(self._fit(axes, 1, 4)[0]))
        middle = _middles(low, high)
        for locked in (True, False):
            chosen = [end for end in ends if (end[1] == 0.0) == locked]
            if chosen and inside.any():
                self._add_range(clip, index, given[inside], chosen, middle, order, turned, inequality=not locked)

    def _add_range(
        self,
        clip: int,
        joint: int,
        frames: IntArray,
        ends: Sequence[tuple[int, float, float]],
        middle: FloatArray,
        order: str,
        axes: FloatArray,
        *,
        inequality: bool,
    ) -> None:
        count = len(ends)
        info = self._info(frames, np.zeros((count, 3)), length=False, inequality=inequality, place=_NOWHERE, apart=True)
        self.ranges.append(
            RangeTable(
                info=info,
                clip=clip,
                joint=joint,
                at=frames,
                axes=axes,
                order=order,
                middle=middle,
                axis=np.array([end[0] for end in ends]),
                sign=np.array([end[1] or 1.0 for end in ends]),
                bound=np.array([end[2] for end in ends]),
            )
        )

    def add_balance(
        self, corners: npt.ArrayLike, frames: npt.ArrayLike, margin: float, masses: Sequence[float] | None, clip: int
    ) -> None:
        """Ask for the centre of mass to be inside all sides of an area."""
        given, inside = self._frames(frames)
        kept = given[inside]
        character = self.clips[self._clip_number(clip)]
        sides = find_support_sides(np.asarray(corners, dtype=float), character.skeleton.up)
        if sides is None:
            raise self._wrong("no area to stand on", "at least three corners not in line", str(np.shape(corners)))
        normals, bounds = sides
        sample = self._samples_of(mass_handle(character, masses, clip), kept)
        bound = np.broadcast_to((bounds - margin) * self.unit, (len(kept), len(bounds)))
        nothing = np.full(len(kept), _NOWHERE)
        self._add_points(kept, sample, nothing, normals, bound, inequality=True, apart=True)

    @property
    def unit(self) -> float:
        """Metres per skeleton unit."""
        return self.clips[0].skeleton.meters_per_unit

    @property
    def frame_count(self) -> int:
        """Frames of every clip."""
        return self.clips[0].frame_count

    def _wrong(self, message: str, expected: str, found: str) -> InputError:
        return InputError(f"constraint {self._name}: {message}", expected=expected, found=found)

    def _clip_number(self, clip: int) -> int:
        if not 0 <= clip < len(self.clips):
            raise self._wrong("no such character", f"a number below {len(self.clips)}", str(clip))
        return clip

    def _frames(self, frames: npt.ArrayLike) -> tuple[IntArray, npt.NDArray[np.bool_]]:
        """Give the frames and which of them are in the window."""
        given = np.atleast_1d(np.asarray(frames))
        last = self.frame_count - 1
        if given.ndim != 1 or not given.size or given.dtype.kind not in "iu" or given.min() < 0 or given.max() > last:
            found = f"{given.size} of type {given.dtype}" + (f", {given.min()} to {given.max()}" if given.size else "")
            raise self._wrong("bad frames", f"whole numbers from 0 to {last}, at least one", found)
        whole = given.astype(np.intp)
        return whole, (whole >= self.window[0]) & (whole <= self.window[1])

    def _fit(self, values: npt.ArrayLike, count: int, width: int) -> FloatArray:
        """Give values as [count, width]; one row stands for all."""
        array = np.asarray(values, dtype=np.float64)
        if array.shape not in ((width,), (1, width), (count, width)) or np.isnan(array).any():
            raise self._wrong("bad numbers", f"finite, of shape ({width},) or ({count}, {width})", str(array.shape))
        return np.broadcast_to(array, (count, width))

    def _samples(self, point: Point, frames: IntArray) -> IntArray:
        joint = find_joint(self.clips[self._clip_number(point.clip)], point.joint)
        x, y, z = (float(value) * self.unit for value in point.offset)
        return self._samples_of(Handle(point.clip, (joint,), (1.0,), ((x, y, z),)), frames)

    def _samples_of(self, handle: Handle, frames: IntArray) -> IntArray:
        number = self.handles.setdefault(handle, len(self.handles))
        return np.asarray(number * self.frame_count + frames)

    def _add_points(
        self,
        frames: IntArray,
        sample: IntArray,
        other: IntArray,
        axes: FloatArray,
        bounds: FloatArray,
        *,
        inequality: bool = False,
        place: int = _NOWHERE,
        apart: bool = False,
    ) -> None:
        info = self._info(frames, axes, length=True, inequality=inequality, place=place, apart=apart)
        rows = len(axes)
        table = PointTable(
            info=info,
            sample=np.repeat(sample, rows),
            other=np.repeat(other, rows),
            bound=np.ascontiguousarray(bounds).ravel(),
        )
        self.points.append(table)

    def _info(
        self,
        frames: IntArray,
        axes: FloatArray,
        *,
        length: bool,
        inequality: bool,
        place: int,
        apart: bool = False,
    ) -> RowInfo:
        """Describe rows for each frame, one per axis; `apart` where they are no parts of one vector."""
        rows = len(axes)
        count = rows * len(frames)
        groups = np.arange(count) if apart else np.repeat(np.arange(len(frames)), rows)
        first, self._group_count = self._group_count, self._group_count + count
        return RowInfo(
            frame=np.repeat(frames, rows),
            owner=np.full(count, self._owner),
            group=first + groups,
            tolerance=np.full(count, self._tolerance),
            length=np.full(count, length),
            inequality=np.full(count, inequality),
            place=np.full(count, place),
            normal=np.tile(axes, (len(frames), 1)),
        )


def _middles(low: FloatArray, high: FloatArray) -> FloatArray:
    """Angles in the middle of ranges, 0 where a range has no end."""
    bounded = np.isfinite(low) & np.isfinite(high)
    return np.where(bounded, 0.5 * (np.where(bounded, low, 0.0) + np.where(bounded, high, 0.0)), 0.0)
