"""Solving for a whole motion."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager

import numpy as np

from mtex_usd.constraints.spacetime.kinds import Constraint
from mtex_usd.constraints.spacetime.knots import uniform_knots
from mtex_usd.constraints.spacetime.memory import Memory
from mtex_usd.constraints.spacetime.parts import solve_part
from mtex_usd.constraints.spacetime.problem import Problem, Settings, choose_cast, compile_problem
from mtex_usd.constraints.spacetime.refine import Outcome, refine_until_met
from mtex_usd.constraints.spacetime.scene import Scene
from mtex_usd.constraints.spacetime.solution import Solution, make_solution
from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip

__all__ = ["check_names", "one_thread", "solve_spacetime", "solve_with"]

_RESTLESS = 0.3  # share of the frames: with fewer it is cheaper to go on in parts
_MARGIN_S = 0.5  # about as far as a change in a part is felt


def solve_spacetime(
    clips: Clip | Sequence[Clip],
    constraints: Sequence[Constraint],
    *,
    frequency: float = 6.0,
    joint_weights: Mapping[str, float] | None = None,
    translation_weight: float = 1.0,
    smoothness: float = 30.0,
    highpass: float = 0.0,
    fixed: Collection[int] = (),
) -> Solution:
    """Find the least change of a motion that meets constraints.

    Every joint on the way from the root to what a constraint is about is displaced by a rotation vector, the root by a
    translation too, all as cubic splines of time; other joints keep their motion bit for bit. What is minimised is the
    sum over the frames of the squared change: rotation vectors in radians, the root's translation in reaches of the
    character (the longest chain of bones from the root), each times its weight.

    Parameters
    ----------
    clips
        The motion of one character, or of several with the same frames; lengths of bones may change over time.
    constraints
        What shall hold; names must differ.
    frequency
        Highest frequency the change shall have, Hz: knots are half a period of it apart. Where the constraints cannot
        be met so, knots are added, down to one a frame.
    joint_weights
        What a change of a joint counts, by path or unique last name; 1 where not named, infinite for a joint that is
        to be kept.
    translation_weight
        What a change of the root's translation by a reach counts beside a turn by a radian; infinite to keep it.
    smoothness
        Weight of the change's second derivative, scaled to 1 at `frequency`. The fallback keeps the share of the
        change's energy above `frequency` below 1 % on walks at 24/s.
    highpass
        Weight of the change's fourth derivative, scaled likewise: a steeper filter.
    fixed
        Numbers of the characters that do not move.

    Returns
    -------
    Solution
        The motion and what is known of it. Where all constraints are met already, the clips as they were given.

    Raises
    ------
    InputError
        Where the clips do not fit each other, a name is used twice, or a constraint or an option makes no sense.
    NoSolutionError
        Where the constraints cannot be met together, naming those that are violated at the best compromise.

    Notes
    -----
    Gleicher 2000, section 1.7.2.1, with rotations composed instead of angles added, and an objective that also weighs
    the change's second derivative: knot spacing alone leaves 15 % of the energy above the frequency.

    Examples
    --------
    >>> still = PointStill("left toes", Point("LeftToeBase"), np.arange(14, 27))
    >>> solve_spacetime(walk, [still]).residuals  # doctest: +SKIP
    {'left toes': 2.1e-06}
    """
    cast_clips = (clips,) if isinstance(clips, Clip) else tuple(clips)
    settings = Settings(
        frequency=frequency,
        joint_weights=dict(joint_weights or {}),
        translation_weight=translation_weight,
        smoothness=smoothness,
        highpass=highpass,
        fixed=frozenset(fixed),
    )
    _check_clips(cast_clips)
    _check_settings(settings, len(cast_clips))
    check_names(constraints)
    return solve_with(cast_clips, tuple(constraints), settings)


def solve_with(clips: tuple[Clip, ...], constraints: tuple[Constraint, ...], settings: Settings) -> Solution:
    """Solve for clips, constraints and settings that were checked."""
    with one_thread():
        return _solve(clips, constraints, settings)


@contextmanager
def one_thread() -> Iterator[None]:
    """Keep linear algebra to one thread: blocks are small, so that more of them wait for each other.

    On busy cores that took thirteen times as long, and sums in another order are other bits.
    """
    from threadpoolctl import threadpool_limits  # noqa: PLC0415  (looks through all loaded libraries)

    with threadpool_limits(limits=1, user_api="blas"):
        yield


def _solve(clips: tuple[Clip, ...], constraints: tuple[Constraint, ...], settings: Settings) -> Solution:
    scene = Scene(clips=clips, window=(0, clips[0].frame_count - 1))
    scene.write_all(constraints)
    problem = compile_problem(choose_cast(scene, settings), constraints, scene)
    knots = uniform_knots(clips[0].frame_count, clips[0].rate / (2.0 * settings.frequency))
    coefficients = np.zeros((knots.count, len(problem.cast.weights)))
    outcome = refine_until_met(problem, settings, knots, coefficients, restless_share=_RESTLESS)
    memory = _remember(clips, problem, settings, outcome)
    if not outcome.restless.size:
        return make_solution(
            memory, problem.name_violations(outcome.evaluation), iterations=outcome.iterations, step=outcome.step
        )
    return _finish_parts(memory, problem, outcome)


def _remember(clips: tuple[Clip, ...], problem: Problem, settings: Settings, outcome: Outcome) -> Memory:
    return Memory(
        clips=clips,
        constraints={constraint.name: constraint for constraint in problem.constraints},
        spans=problem.spans(),
        cast=problem.cast,
        settings=settings,
        knots=outcome.knots,
        coefficients=outcome.coefficients,
        places=problem.name_places(outcome.places),
        pulls=problem.name_pulls(outcome.multipliers),
    )


def _finish_parts(memory: Memory, problem: Problem, outcome: Outcome) -> Solution:
    """Solve on where the search has not come to rest, which in a long motion is here and there."""
    margin = _MARGIN_S * memory.clips[0].rate
    iterations, step = outcome.iterations, 0.0
    for stretch in np.split(outcome.restless, np.flatnonzero(np.diff(outcome.restless) > 2.0 * margin) + 1):
        part = solve_part(memory, stretch[0], stretch[-1], margin)
        memory, step = part.memory, max(step, part.outcome.step)
        iterations = max(iterations, outcome.iterations + part.outcome.iterations)
    changes = (memory.knots.matrix @ memory.coefficients)[problem.frames]
    places = np.array([memory.places[problem.constraints[owner].name] for owner in problem.place_owners])
    found = problem.evaluate(changes, places.reshape(-1, 3))
    return make_solution(memory, problem.name_violations(found), iterations=iterations, step=step)


def check_names(constraints: Sequence[Constraint]) -> None:
    """Refuse names that are used twice.

    Raises
    ------
    InputError
        Naming them.
    """
    names = [constraint.name for constraint in constraints]
    if len(set(names)) != len(names):
        twice = sorted({name for name in names if names.count(name) > 1})
        raise InputError("constraints share a name", found=", ".join(twice), fix="Give every constraint its own.")


def _check_clips(clips: Sequence[Clip]) -> None:
    if not clips:
        raise InputError("no clip to solve for", expected="at least one")
    facts = [(clip.frame_count, clip.rate, clip.skeleton.meters_per_unit) for clip in clips]
    if len(set(facts)) > 1:
        found = "; ".join(f"{count} frames, {rate:g}/s, {unit:g}" for count, rate, unit in facts)
        raise InputError(
            "clips do not fit each other", expected="the same frames, rate and metres per unit", found=found
        )


def _check_settings(settings: Settings, clip_count: int) -> None:
    numbers = (settings.frequency, settings.translation_weight, settings.smoothness, settings.highpass)
    if not (settings.frequency > 0.0 and settings.translation_weight > 0.0 and min(numbers) >= 0.0):
        raise InputError(
            "bad options of the spacetime solve",
            expected="frequency and translation weight above 0, smoothness and highpass not below",
            found=", ".join(f"{number:g}" for number in numbers),
        )
    strangers = sorted(settings.fixed - set(range(clip_count)))
    if strangers:
        raise InputError("no such character to keep", expected=f"numbers below {clip_count}", found=str(strangers))
