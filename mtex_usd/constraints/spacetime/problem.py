"""Building the problem: which joints may move, what a change of each costs, and all constraints as rows by frame."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mtex_usd.constraints.spacetime.character import Character, Posing, find_root, measure_reach
from mtex_usd.constraints.spacetime.kinds import Constraint
from mtex_usd.constraints.spacetime.rows import RowInfo, Table, concatenate, no_rows, reorder
from mtex_usd.constraints.spacetime.samples import Handle, Observer, State, Watch
from mtex_usd.constraints.spacetime.scene import Scene, find_joint
from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import FloatArray, IntArray

__all__ = ["Cast", "Evaluation", "Problem", "Settings", "choose_cast", "compile_problem"]

_CARRIES_MASS = 0.03  # a joint that carries less of the whole is not bent to move the centre of mass


@dataclass(frozen=True, kw_only=True)
class Settings:
    """What a solve may be told.

    Parameters
    ----------
    frequency
        Highest frequency the displacement shall have, Hz.
    joint_weights
        What a change of a joint counts, by path or unique last name; 1 where not named, infinite for a joint to be
        kept.
    translation_weight
        What a change of the root's translation by the character's reach counts beside a turn by a radian.
    smoothness
        Weight of the change's second derivative; at 1 a change at `frequency` counts twice, one at half of it 1 1/16
        times.
    highpass
        Weight of the change's fourth derivative, a steeper filter: at 1 and half of `frequency` it is 1 1/256 times.
    fixed
        Numbers of the characters that do not move.
    """

    frequency: float
    joint_weights: Mapping[str, float]
    translation_weight: float
    smoothness: float
    highpass: float
    fixed: frozenset[int]


@dataclass(frozen=True, eq=False, kw_only=True)
class Cast:
    """The characters, with what their channels cost.

    Parameters
    ----------
    characters
        In the order of the clips.
    weights
        Of every channel, [C].
    reach
        Length that counts as much as a radian, metres.
    """

    characters: tuple[Character, ...]
    weights: FloatArray
    reach: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Problem:
    """All constraints, for a cast, at the frames they are about.

    Parameters
    ----------
    cast
        The characters.
    constraints
        As they were given.
    frames
        The frames that any is about, increasing, [U].
    observer
        What is watched at those frames.
    tables
        The rows by kind.
    order
        From rows behind one another to rows sorted by frame, [R].
    info
        What the rows are, sorted by frame.
    scale
        What one metre or radian of each row counts as, [R].
    place_frames, place_owners
        First and last frame of each free place, [Q, 2], and the constraint it is of, [Q].
    """

    cast: Cast
    constraints: tuple[Constraint, ...]
    frames: IntArray
    observer: Observer
    tables: tuple[Table, ...]
    order: IntArray
    info: RowInfo
    scale: FloatArray
    place_frames: IntArray
    place_owners: IntArray

    @cached_property
    def row_tolerance(self) -> FloatArray:
        """Tolerance of each row in the scaled units, [R]."""
        return np.asarray(self.info.tolerance * self.scale)

    def evaluate(self, changes: FloatArray, places: FloatArray) -> "Evaluation":
        """Displace by channels at the problem's frames [U, C]; free places [Q, 3] in metres."""
        return Evaluation(problem=self, state=self.observer.observe(changes, places))

    def find_places(self, changes: FloatArray) -> FloatArray:
        """Give every free place the mean of what shall be there, metres, [Q, 3]."""
        count = len(self.place_owners)
        at_zero = self.evaluate(changes, np.zeros((count, 3)))
        held = self.info.place >= 0
        places = np.zeros((count, 3))
        moved = at_zero.metric[held, None] * self.info.normal[held]
        np.add.at(places, self.info.place[held], moved)
        rows = np.bincount(self.info.place[held], minlength=count) / 3.0
        return np.asarray(places / np.maximum(rows, 1.0)[:, None])

    def spans(self) -> dict[str, tuple[int, int]]:
        """First and last frame each constraint is about, by name; left out where it is about none here."""
        count = len(self.constraints)
        first, last = np.full(count, np.iinfo(np.intp).max), np.full(count, -1)
        np.minimum.at(first, self.info.owner, self.info.frame)
        np.maximum.at(last, self.info.owner, self.info.frame)
        ends = zip(self.constraints, first.tolist(), last.tolist(), strict=True)
        return {constraint.name: (begin, end) for constraint, begin, end in ends if end >= 0}

    def name_places(self, places: FloatArray) -> dict[str, FloatArray]:
        """Give places [Q, 3] by the name of the constraint each is of."""
        return {self.constraints[owner].name: place for owner, place in zip(self.place_owners, places, strict=True)}

    def name_violations(self, evaluation: "Evaluation") -> dict[str, float]:
        """Give the largest violation of each constraint, metres or radians, by its name."""
        worst = evaluation.worst().tolist()
        return {constraint.name: value for constraint, value in zip(self.constraints, worst, strict=True)}

    def name_pulls(self, multipliers: FloatArray) -> dict[str, tuple[IntArray, FloatArray]]:
        """Give the frames and multipliers of each constraint's rows by its name."""
        out = {}
        for number, rows in enumerate(self._rows_by_owner):
            out[self.constraints[number].name] = (self.info.frame[rows], multipliers[rows])
        return out

    def find_pulls(self, pulls: Mapping[str, tuple[IntArray, FloatArray]]) -> FloatArray:
        """Give rows the multipliers they had by name and frame, 0 where there were others, [R]."""
        out = np.zeros(len(self.info.frame))
        for number, rows in enumerate(self._rows_by_owner):
            frames, multipliers = pulls.get(self.constraints[number].name, (self.info.frame[:0], out[:0]))
            if rows.size:
                begin, end = np.searchsorted(frames, [self.info.frame[rows[0]], self.info.frame[rows[-1]] + 1])
                if end - begin == rows.size:
                    out[rows] = multipliers[begin:end]
        return out

    @cached_property
    def _rows_by_owner(self) -> list[IntArray]:
        order = np.argsort(self.info.owner, kind="stable")
        borders = np.searchsorted(self.info.owner[order], np.arange(1, len(self.constraints)))
        return np.split(order, borders) if self.constraints else []


@dataclass(frozen=True, eq=False, kw_only=True)
class Evaluation:
    """The rows for one displacement."""

    problem: Problem
    state: State

    @cached_property
    def metric(self) -> FloatArray:
        """Values in metres or radians, [R]."""
        return _stacked([table.residual(self.state) for table in self.problem.tables])[self.problem.order]

    @cached_property
    def residual(self) -> FloatArray:
        """Scaled values, [R]."""
        return np.asarray(self.metric * self.problem.scale)

    @cached_property
    def jacobian(self) -> FloatArray:
        """Scaled derivatives by the channels at the rows' frames, [R, C]."""
        stacked = np.concatenate([table.jacobian(self.state) for table in self.problem.tables])
        return np.asarray(stacked[self.problem.order] * self.problem.scale[:, None])

    def bend(self, multipliers: FloatArray) -> FloatArray:
        """Second derivatives of all rows by the channels, weighed by multipliers [R], per frame, [U, C, C]."""
        state, pulls = self.state, np.empty(len(multipliers))
        pulls[self.problem.order] = multipliers * self.problem.scale
        parts = np.split(pulls, np.cumsum([len(table.info.frame) for table in self.problem.tables]))[:-1]
        points, turns = np.zeros((len(state.positions), 3)), np.zeros((len(state.orientations), 3))
        for table, part in zip(self.problem.tables, parts, strict=True):
            table.pull_points(state, part, points)
            table.pull_turns(state, part, turns)
        bends = state.bend(points, turns)
        for table, part in zip(self.problem.tables, parts, strict=True):
            table.curve(state, part, bends)
        return bends

    @cached_property
    def violation(self) -> FloatArray:
        """How far each row's vector is from met, in tolerances, [R]."""
        info = self.problem.info
        off = np.where(info.inequality, np.maximum(self.metric, 0.0), self.metric) / info.tolerance
        return np.sqrt(np.bincount(info.group, off * off))[info.group]

    @cached_property
    def worst_ratio(self) -> float:
        """Largest violation in tolerances; 0 where there are no rows."""
        return float(self.violation.max(initial=0.0))

    @property
    def is_met(self) -> bool:
        """Whether no constraint is violated by more than its tolerance."""
        return self.worst_ratio <= 1.0

    def worst(self) -> FloatArray:
        """Largest violation of each constraint, metres or radians."""
        info, out = self.problem.info, np.zeros(len(self.problem.constraints))
        np.maximum.at(out, info.owner, self.violation * info.tolerance)
        return out


def _stacked(parts: Sequence[FloatArray]) -> FloatArray:
    return np.concatenate(parts) if parts else np.zeros(0)


def choose_cast(scene: Scene, settings: Settings) -> Cast:
    """Find the joints that the constraints may move: those on the way from the root to what they are about."""
    characters: list[Character] = []
    weights: list[float] = []
    reach = max(measure_reach(clip) for clip in scene.clips)
    for number, clip in enumerate(scene.clips):
        by_joint = _by_joint(clip, settings.joint_weights)
        moved = set() if number in settings.fixed else _moved_joints(clip, number, scene)
        turning = tuple(joint for joint in sorted(moved) if np.isfinite(by_joint[joint]))
        root = find_root(clip)
        if root not in moved or not np.isfinite(settings.translation_weight):
            root = -1
        character = Character(clip=clip, turning=turning, root=root, first_column=len(weights))
        characters.append(character)
        weights += np.repeat(by_joint[list(turning)], 3).tolist()
        weights += [settings.translation_weight / reach**2] * (character.column_count - 3 * len(turning))
    scaled = np.array(weights)
    # The penalty of a violation stands beside weights of about 1, in whatever unit they are given.
    return Cast(characters=tuple(characters), weights=scaled / _usual(scaled), reach=reach)


def _usual(weights: FloatArray) -> float:
    return float(np.median(weights)) if weights.size else 1.0


def _by_joint(clip: Clip, joint_weights: Mapping[str, float]) -> FloatArray:
    out = np.ones(len(clip.joints))
    for name, weight in joint_weights.items():
        if not weight > 0.0:
            raise InputError(f"bad weight of joint {name}", expected="above 0", found=f"{weight:g}")
        out[find_joint(clip, name)] = weight
    return out


def _moved_joints(clip: Clip, number: int, scene: Scene) -> set[int]:
    """Joints above what is watched, and those with ranges."""
    moved = {table.joint for table in scene.ranges if table.clip == number}
    for handle in (*scene.handles, *scene.turns):
        if handle.clip == number:
            moved |= _carrying(clip, handle)
    return moved


def _carrying(clip: Clip, handle: Handle) -> set[int]:
    carried = np.zeros(len(clip.joints))
    for joint, weight in zip(handle.joints, handle.weights, strict=True):
        carried[clip.skeleton.chain(joint)] += weight
    return set(np.flatnonzero(carried > _CARRIES_MASS).tolist())


def compile_problem(cast: Cast, constraints: Sequence[Constraint], scene: Scene) -> Problem:
    """Number the samples and sort the rows of all constraints by frame."""
    frames = _frames_of(scene)
    tables, points, turns = _tables(scene, frames)
    info = concatenate([table.info for table in tables]) if tables else no_rows()
    order = np.argsort(info.frame, kind="stable")
    return Problem(
        cast=cast,
        constraints=tuple(constraints),
        frames=frames,
        observer=Observer(
            posings=tuple(Posing(character, frames) for character in cast.characters),
            points=points,
            turns=turns,
            frames=frames,
            column_count=len(cast.weights),
        ),
        tables=tables,
        order=order,
        info=reorder(info, order),
        scale=np.where(info.length, 1.0 / cast.reach, 1.0)[order],
        place_frames=np.array(scene.place_frames, dtype=np.intp).reshape(-1, 2),
        place_owners=np.array(scene.place_owners, dtype=np.intp),
    )


def _frames_of(scene: Scene) -> IntArray:
    pieces = [*scene.points, *scene.distances, *scene.orientations, *scene.ranges]
    found = [piece.info.frame for piece in pieces]
    return np.unique(np.concatenate([np.zeros(0, dtype=np.intp), *found]))


def _tables(scene: Scene, frames: IntArray) -> tuple[tuple[Table, ...], tuple[Watch, ...], tuple[Watch, ...]]:
    """Join the pieces of each kind, and give what they watch: points, then orientations."""
    points = concatenate(scene.points) if scene.points else None
    distances = concatenate(scene.distances) if scene.distances else None
    turned = concatenate(scene.orientations) if scene.orientations else None
    keys = [key for table in (points, distances) if table for key in (table.sample, table.other)]
    numbers, watched = _watch(scene.handles, keys, frames, scene.frame_count)
    tables: list[Table] = []
    if points:
        other = np.where(points.other < 0, -1, np.searchsorted(numbers, points.other))
        tables.append(replace(points, sample=np.searchsorted(numbers, points.sample), other=other))
    if distances:
        samples = np.searchsorted(numbers, distances.sample), np.searchsorted(numbers, distances.other)
        tables.append(replace(distances, sample=samples[0], other=samples[1]))
    numbers, turns = _watch(scene.turns, [turned.sample] if turned else [], frames, scene.frame_count)
    if turned:
        tables.append(replace(turned, sample=np.searchsorted(numbers, turned.sample)))
    tables += [replace(table, at=np.searchsorted(frames, table.at)) for table in scene.ranges]
    return tuple(tables), watched, turns


def _watch(
    handles: Mapping[Handle, int], keys: Sequence[IntArray], frames: IntArray, frame_count: int
) -> tuple[IntArray, tuple[Watch, ...]]:
    """Find all samples, each a handle's number times the frames of the clip plus a frame, increasing."""
    numbers = np.unique(np.concatenate([np.zeros(0, dtype=np.intp), *keys]))
    numbers = numbers[numbers >= 0]
    borders = np.searchsorted(numbers, frame_count * np.arange(len(handles) + 1))
    at = np.searchsorted(frames, numbers % frame_count)
    return numbers, tuple(Watch(handle, at[borders[i] : borders[i + 1]]) for handle, i in handles.items())
