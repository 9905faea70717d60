"""Steps, which are contacts of one limb together, moved in time and space while all else stays where it is.

What an animator drags is a footstep, not the heel of it: points of one limb that are held at the same time move as
one. The rest of the motion is solved for again only near what changed (Gleicher 2000, section 1.7.2).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.kinematics import place_points
from mtex_usd.constraints.planting.holding import hold_motion
from mtex_usd.constraints.planting.limits import JointRange
from mtex_usd.constraints.planting.plan import Hold, find_limb, to_constraints
from mtex_usd.constraints.spacetime import Solution, resolve_near
from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["MovedStep", "Step", "StepMover", "group_steps", "prepare_steps"]

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class Step:
    """Points of one limb that are held together.

    Parameters
    ----------
    holds
        Each with its places, as the motion has them.
    """

    holds: tuple[Hold, ...]

    @property
    def name(self) -> str:
        """The points it is made of, as they are called."""
        return ", ".join(dict.fromkeys(hold.name.rpartition(" ")[0] or hold.name for hold in self.holds))

    @property
    def first(self) -> int:
        """First frame at which any point is held."""
        return min(hold.first for hold in self.holds)

    @property
    def last(self) -> int:
        """Last frame at which any point is held."""
        return max(hold.last for hold in self.holds)

    @property
    def place(self) -> FloatArray:
        """Mean place of its points, skeleton space, shape [3]."""
        places = [np.mean(hold.places, axis=0) for hold in self.holds if hold.places is not None]
        return np.asarray(np.mean(places, axis=0))


@dataclass(frozen=True, eq=False, kw_only=True)
class MovedStep:
    """A motion with one of its steps moved.

    Parameters
    ----------
    clip
        The motion.
    holds
        What is held in it, the moved step's where they are now.
    """

    clip: Clip
    holds: tuple[Hold, ...]


def group_steps(holds: Sequence[Hold], clip: Clip) -> tuple[Step, ...]:
    """Put holds of one limb that overlap in time together.

    Parameters
    ----------
    holds
        What is held.
    clip
        The motion that holds it, or nearly; gives the places.

    Returns
    -------
    tuple of Step
        By first frame.
    """
    groups: list[tuple[int, list[Hold]]] = []
    for hold in sorted(holds, key=lambda hold: hold.first):
        limb = _limb_of(hold, clip.skeleton)
        near = [group for top, group in groups if top == limb and hold.first <= max(each.last for each in group)]
        if near:
            near[-1].append(_place(hold, clip))
        else:
            groups.append((limb, [_place(hold, clip)]))
    return tuple(Step(holds=tuple(group)) for _, group in groups)


def _limb_of(hold: Hold, skeleton: Skeleton) -> int:
    return next(iter(find_limb(skeleton, hold.joint)), hold.joint)


def _place(hold: Hold, clip: Clip) -> Hold:
    """Say where a hold's point is at every frame, in place of how it is held."""
    places = _track(hold, clip, hold.frames)
    return replace(hold, places=places, still=False, height=None, keeps_height=False, carried=None)


def _track(hold: Hold, clip: Clip, frames: npt.NDArray[np.intp]) -> FloatArray:
    """Where a motion has the point of a hold, skeleton space, shape [N, 3]."""
    offset = np.asarray(hold.offset)[None]
    return place_points(clip.skeleton, [hold.joint], offset, clip.rotations[frames], clip.translations[frames])[:, 0]


@dataclass(frozen=True, eq=False, kw_only=True)
class StepMover:
    """A motion whose steps can be moved.

    Parameters
    ----------
    steps
        All of them.
    solution
        The motion as it was given, with all steps held where they are.
    """

    steps: tuple[Step, ...]
    solution: Solution

    def move(self, number: int, *, by: npt.ArrayLike = (0.0, 0.0, 0.0), first: int, last: int) -> MovedStep:
        """Move one step, always from where it was given, and solve again near it.

        Parameters
        ----------
        number
            Which of the steps.
        by
            How far, skeleton space and units, shape [3].
        first, last
            Frames at which it is held now; the times of its points scale along.

        Returns
        -------
        MovedStep
            Far from the step with the bits of the motion that was given.

        Raises
        ------
        InputError
            Where the frames are not in order, not of the motion, or another step's of the same limb; where the step
            would go farther than the body is large. The solve would find out too, after a long search.
        NoSolutionError
            Where the step cannot be there together with the others.
        """
        step, clip = self.steps[number], self.solution.memory.clips[0]
        others = [other for i, other in enumerate(self.steps) if i != number]
        _check_time(step, others, clip, (first, last))
        _check_way(step, clip.skeleton, float(np.linalg.norm(by)))
        moved = tuple(_move(hold, clip, step, np.asarray(by, dtype=float), (first, last)) for hold in step.holds)
        solved = resolve_near(self.solution, to_constraints(moved, clip))
        holds = (*moved, *(hold for other in others for hold in other.holds))
        return MovedStep(clip=solved.clips[0], holds=tuple(sorted(holds, key=lambda hold: hold.first)))


def _check_time(step: Step, others: Sequence[Step], clip: Clip, span: tuple[int, int]) -> None:
    """Refuse frames that are none, and those at which the limb stands elsewhere."""
    first, last = span
    found = f"{first} to {last}"
    if not 0 <= first <= last < clip.frame_count:
        expected = f"frames in order from 0 to {clip.frame_count - 1}"
        raise InputError(f"{step.name} cannot be held then", expected=expected, found=found)
    limb = _limb_of(step.holds[0], clip.skeleton)
    taken = [other for other in others if _limb_of(other.holds[0], clip.skeleton) == limb]
    for other in taken:
        if first <= other.last and other.first <= last:
            expected = f"frames apart from {other.first} to {other.last}, when it stands elsewhere"
            raise InputError(f"{step.name} cannot be held then", expected=expected, found=found)


def _check_way(step: Step, skeleton: Skeleton, length: float) -> None:
    """Refuse to look for a motion that takes a step farther than the body at rest is large."""
    size = float(np.linalg.norm(np.ptp(skeleton.rest_positions, axis=0)))
    if length > size:
        raise InputError(
            f"{step.name} cannot be moved so far",
            expected=f"at most {size:.4g}, the size of the body",
            found=f"{length:.4g}",
        )


def _move(hold: Hold, clip: Clip, step: Step, by: FloatArray, span: tuple[int, int]) -> Hold:
    """Give a hold with its place and its share of the step's time changed.

    All points of a step are read at the same moments of the motion: a foot that rolls keeps its shape.
    """
    first, last = span
    stretch = (last - first) / max(step.last - step.first, 1)
    begin = first + round((hold.first - step.first) * stretch)
    end = max(begin, first + round((hold.last - step.first) * stretch))
    moments = (np.arange(begin, end + 1) - first) / stretch if stretch else np.array([(step.last - step.first) / 2.0])
    frames = np.arange(step.first, step.last + 1)
    track = _track(hold, clip, frames)
    places = [np.interp(step.first + moments, frames, track[:, axis]) for axis in range(3)]
    return replace(hold, first=begin, last=end, places=np.stack(places, axis=1) + by)


def prepare_steps(
    clip: Clip, holds: Sequence[Hold], *, frequency: float = 6.0, limits: Sequence[JointRange] = ()
) -> StepMover:
    """Make ready to move steps of a motion.

    Parameters
    ----------
    clip
        The motion.
    holds
        What is held in it.
    frequency
        The highest frequency of the change, Hz.
    limits
        How far joints may turn.

    Raises
    ------
    InputError
        Where nothing is held.
    """
    steps = group_steps(holds, clip)
    everything = tuple(hold for step in steps for hold in step.holds)
    solution = hold_motion(clip, everything, frequency=frequency, limits=limits).solution
    if solution is None:
        raise InputError(f"{clip.name} has no contact to move", expected="a point that is held for some frames")
    return StepMover(steps=steps, solution=solution)
