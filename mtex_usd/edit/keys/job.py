"""One key reduction from beginning to end: fitting at frames, looking between them, and writing down the curves."""

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.keys.body import Body, angles_apart, distances
from mtex_usd.edit.keys.curves import KeyCurve, evaluate_together
from mtex_usd.edit.keys.deviation import make_deviation
from mtex_usd.edit.keys.fitting import State, add_keys, drop_keys, start_keys
from mtex_usd.edit.keys.hermite import KeySet, fit_curves
from mtex_usd.edit.keys.sampled import ChannelSamples, sample_channels
from mtex_usd.edit.keys.tolerance import Tolerance
from mtex_usd.motion.channels import Channel
from mtex_usd.motion.clip import Clip

__all__ = ["Job", "Outcome", "Plan", "fit_count", "fit_tolerance"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

_CHECKED = 4  # times a frame the result is looked at, and keys a frame within a jump
_FIRST_BAND = 0.7  # of the tolerance: what a channel may be off by before joints and places are looked at
_MARGIN = 0.97  # of the tolerance: what the first-order model may use
_LEAP = 3.0  # times the tolerance: what is more wrong is a jump, which no cubic follows
_TIGHTER = 0.8
_TIGHTEST = 0.7
_INVOLVED = 0.25  # of the largest angle: joints off by more take part in what is wrong between two frames
_MILD = 1.3  # times the tolerance: what is less wrong between frames goes when the frames are closer
_ALL_INVOLVED = 0.02
_REPAIRS = 12
_PASSES = 5
_HALVINGS = 10


@dataclass(frozen=True, eq=False)
class Plan:
    """Where the keys are.

    Parameters
    ----------
    state
        Keys of the channels that move, and their curves; None where none moves.
    jumps
        From which frames on which of these channels follow the motion within a frame, shape [C, F].
    """

    state: State | None
    jumps: BoolArray


@dataclass(frozen=True, eq=False)
class Outcome:
    """The curves of a plan, and how far they are off four times a frame.

    Parameters
    ----------
    curves
        One per channel.
    values
        Their values four times a frame, shape [C, T].
    body
        The motion they make then.
    degrees, metres
        What joints' rotations and places are off by, shape [J, T].
    """

    curves: tuple[KeyCurve, ...]
    values: FloatArray
    body: Body
    degrees: FloatArray
    metres: FloatArray


@dataclass(frozen=True, eq=False)
class Job:
    """What is to be reduced.

    Parameters
    ----------
    clip
        The clip, without outliers.
    channels
        Which of its channels.
    frames
        Frames that are keys of all of them.
    """

    clip: Clip
    channels: tuple[Channel, ...]
    frames: IntArray

    @cached_property
    def samples(self) -> ChannelSamples:
        """The channels at every frame."""
        return self.fine.at_frames()

    @cached_property
    def moving(self) -> BoolArray:
        """Which channels change, shape [C]; plans are of these alone."""
        return np.asarray(np.ptp(self.samples.values, axis=1) > 0.0)

    @cached_property
    def fine(self) -> ChannelSamples:
        """The channels four times a frame."""
        return sample_channels(self.clip, self.channels, _CHECKED)

    def start(self) -> State:
        """Begin with keys at the frames that have to be."""
        return start_keys(self.samples.values[self.moving], self.frames)

    def carry_out(self, plan: Plan, before: Outcome | None = None) -> Outcome:
        """Write down the curves of a plan and measure how far they are off, where they are not as they were before."""
        start = self._start_outcome() if before is None else before
        curves = self._list_curves(plan)
        values = evaluate_together(curves, _CHECKED, self.fine.values.shape[1])
        body, turned = self.fine.move_by(start.body, values, (values != start.values).any(axis=1))
        moved, wanted = body.list_below(turned), self.fine.body
        degrees, metres = np.array(start.degrees), np.array(start.metres)
        degrees[turned] = angles_apart(body.turns[turned], wanted.turns[turned])
        metres[moved] = distances(body.places[moved], wanted.places[moved]) * self.clip.skeleton.meters_per_unit
        return Outcome(curves, values, body, degrees, metres)

    def _start_outcome(self) -> Outcome:
        """The motion itself, which is off by nothing."""
        degrees, metres = np.zeros((2, *self.fine.body.turns[:, 0].shape))
        return Outcome((), self.fine.values, self.fine.body, degrees, metres)

    def _list_curves(self, plan: Plan) -> tuple[KeyCurve, ...]:
        """Write down the curves of all channels; those that do not change have one key."""
        moving = [] if plan.state is None else _list_moving(self, plan, plan.state)
        numbers = np.cumsum(self.moving) - 1
        return tuple(
            moving[numbers[place]] if self.moving[place] else _hold(self, place) for place in range(len(self.channels))
        )


def _hold(job: Job, place: int) -> KeyCurve:
    return _make_curve(job, job.channels[place], np.zeros(1), [job.samples.values[place, :1], np.zeros(1), np.zeros(1)])


def _make_curve(job: Job, channel: Channel, frames: FloatArray, held: list[FloatArray]) -> KeyCurve:
    """Name a curve; held are values and the slopes before and after, per frame."""
    per_frame = job.clip.time_codes_per_frame
    return KeyCurve(
        joint=job.clip.joints[channel.joint],
        kind=channel.kind,
        frames=frames,
        time_codes=job.clip.start + per_frame * frames,
        values=held[0],
        slopes_before=held[1] / per_frame,
        slopes_after=held[2] / per_frame,
    )


def _list_moving(job: Job, plan: Plan, state: State) -> list[KeyCurve]:
    fit = fit_curves(state.samples, state.keys)
    bounds = np.searchsorted(fit.channels, np.arange(len(state.samples) + 1))
    curves = []
    for number, place in enumerate(np.flatnonzero(job.moving).tolist()):
        own = slice(bounds[number], bounds[number + 1])
        frames = fit.samples[own].astype(np.float64)
        held = [fit.values[own], fit.slopes_before[own], fit.slopes_after[own]]
        for frame in np.flatnonzero(plan.jumps[number]).tolist():
            inside = job.fine.values[place, frame * _CHECKED : (frame + 1) * _CHECKED + 1]
            frames, held = _follow(frames, held, frame, inside)
        curves.append(_make_curve(job, job.channels[place], frames, held))
    return curves


def _follow(
    frames: FloatArray, held: list[FloatArray], frame: int, inside: FloatArray
) -> tuple[FloatArray, list[FloatArray]]:
    """Put keys between a frame and the next, both of them keys, that follow samples there, ends included."""
    place = int(np.searchsorted(frames, frame))
    step = 1.0 / (len(inside) - 1)
    slopes = np.gradient(inside, step, edge_order=2)
    values, before, after = (np.array(column) for column in held)
    after[place], before[place + 1] = slopes[0], slopes[-1]
    between = [frame + step * np.arange(1, len(inside) - 1), inside[1:-1], slopes[1:-1], slopes[1:-1]]
    merged = [
        np.insert(old, place + 1, more) for old, more in zip([frames, values, before, after], between, strict=True)
    ]
    return merged[0], merged[1:]


def fit_tolerance(job: Job, tolerance: Tolerance) -> Outcome:
    """Find few keys with which everything stays within a tolerance.

    Parameters
    ----------
    job
        What is to be reduced.
    tolerance
        What it may be off by.
    """
    if not job.moving.any():
        return job.carry_out(_plan(job, None))
    search = _Search(job, tolerance)
    state = add_keys(job.start(), search.blame_channels)
    plan = _plan(job, drop_keys(add_keys(state, search.blame), search.blame, passes=_PASSES))
    outcome = job.carry_out(plan)
    for _ in range(_REPAIRS):
        excess = Excess(outcome.degrees / tolerance.degrees, outcome.metres / tolerance.metres)
        if (excess.worst <= 1.0).all():
            break
        plan = search.repair(plan, excess)
        outcome = job.carry_out(plan, outcome)
    return outcome


@dataclass(frozen=True, eq=False)
class Excess:
    """How many times the tolerance joints are turned and moved from where they should be, both [J, T]."""

    turned: FloatArray
    moved: FloatArray

    @cached_property
    def worst(self) -> FloatArray:
        """Of all joints, shape [T]."""
        return np.asarray(np.maximum(self.turned.max(axis=0), self.moved.max(axis=0)))


def _plan(job: Job, state: State | None) -> Plan:
    return Plan(state, np.zeros((int(job.moving.sum()), job.clip.frame_count), dtype=np.bool_))


class _Search:
    """What is wrong with a fit, and what to do about it."""

    def __init__(self, job: Job, tolerance: Tolerance) -> None:
        self._job = job
        self._deviation = make_deviation(job.samples, tolerance)
        self._allowed = np.full(job.clip.frame_count, _MARGIN)
        self._involved = 2.0 * _INVOLVED
        self._turning = np.array([channel.is_rotation for channel in job.channels])[job.moving]
        self._limits = _FIRST_BAND * np.where(self._turning, tolerance.degrees, self._deviation.limits[1])[:, None]
        self._joints = np.array([channel.joint for channel in job.channels])[job.moving]

    def blame_channels(self, errors: FloatArray) -> FloatArray:
        """Blame every channel for its own errors alone."""
        return _blame_above(errors, self._limits)

    def blame(self, errors: FloatArray) -> FloatArray:
        """Blame channels for what joints and places are off by."""
        spread = np.zeros((len(self._job.channels), errors.shape[1]))
        spread[self._job.moving] = errors
        return self._deviation.blame(spread, self._allowed)[self._job.moving]

    def repair(self, plan: Plan, excess: Excess) -> Plan:
        """Mend what is outside the tolerance at the times looked at.

        Parameters
        ----------
        plan
            The keys so far.
        excess
            What is outside.
        """
        over = excess.worst
        wrong = np.flatnonzero(over > 1.0)
        # A place may be off by what many joints do a little; in the end all of them follow the motion exactly.
        self._involved = 0.5 * self._involved if self._involved > _ALL_INVOLVED else 0.0
        # What tightening did not mend before is no longer mild.
        is_mild = (over[wrong] < _MILD) & (self._allowed[wrong // _CHECKED] > _TIGHTEST) | (wrong % _CHECKED == 0)
        for nearest in (np.floor, np.ceil):
            self._allowed[nearest(wrong[is_mild] / _CHECKED).astype(np.intp)] *= _TIGHTER
        between = wrong[~is_mild]
        asked, leaping = (self._find_involved(times, excess) for times in (between, between[over[between] > _LEAP]))
        return self._bridge(plan, asked, leaping)

    def _find_involved(self, times: IntArray, excess: Excess) -> BoolArray:
        """Mark channels and frames at or before times where something is wrong, [C, F].

        A joint that is turned too far has itself to blame; for a place, all that turn much or move are.
        """
        marks = np.zeros((len(self._joints), len(self._allowed)), dtype=np.bool_)
        turned, misplaced = excess.turned[:, times], (excess.moved[:, times] > 1.0).any(axis=0)
        involved = (turned >= self._involved * turned.max(axis=0)) & misplaced
        of_channels = np.where(self._turning[:, None], (involved | (turned > 1.0))[self._joints], misplaced)
        np.logical_or.at(marks.T, times // _CHECKED, of_channels.T)
        return marks

    def _bridge(self, plan: Plan, asked: BoolArray, leaping: BoolArray) -> Plan:
        """Tie curves down at both frames around what is wrong; where they are already, follow the motion inside."""
        state = plan.state
        if state is None:
            return plan
        keys = state.keys
        tied = keys.pinned & keys.broken
        both = tied & np.roll(tied, -1, axis=1)
        ends = asked & ~both
        ends[:, 1:] |= ends[:, :-1].copy()
        keys = KeySet(keys.placed | ends, keys.pinned | ends, keys.broken | ends)
        state = add_keys(state.refit(keys, np.flatnonzero(ends.any(axis=1))), self.blame)
        return Plan(state, plan.jumps | leaping | (asked & both))


def _blame_above(errors: FloatArray, limits: FloatArray) -> FloatArray:
    passed = np.abs(errors) / limits
    return np.where(passed > 1.0, np.square(passed), 0.0)


def fit_count(job: Job, key_count: int) -> Outcome:
    """Find the best places for so many keys on every channel.

    Parameters
    ----------
    job
        What is to be reduced.
    key_count
        Most keys a channel may have; no fewer than the job's frames.

    Notes
    -----
    Halves between errors that need too many keys and errors that need too few, every channel by itself.
    """
    if not job.moving.any():
        return job.carry_out(_plan(job, None))
    best = job.start()
    low, high = np.zeros((len(best.samples), 1)), np.abs(best.errors).max(axis=1, keepdims=True)
    for _ in range(_HALVINGS):
        middle = np.maximum(0.5 * (low + high), np.finfo(np.float64).tiny)
        found = add_keys(job.start(), partial(_blame_above, limits=middle))
        fits = found.keys.placed.sum(axis=1, keepdims=True) <= key_count
        low, high = np.where(fits, low, middle), np.where(fits, middle, high)
        better = fits[:, 0] & (np.abs(found.errors).max(axis=1) < np.abs(best.errors).max(axis=1))
        rows = np.flatnonzero(better)
        best = best.refit(best.keys.with_rows(rows, found.keys.rows(rows)), rows)
    return job.carry_out(_plan(job, best))
