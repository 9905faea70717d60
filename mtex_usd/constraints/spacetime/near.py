"""Solving the neighbourhood in time of what changed, as when an animator drags a footstep."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from mtex_usd.constraints.spacetime.kinds import Constraint
from mtex_usd.constraints.spacetime.memory import Memory
from mtex_usd.constraints.spacetime.parts import Part, solve_part
from mtex_usd.constraints.spacetime.problem import Cast, choose_cast, compile_problem
from mtex_usd.constraints.spacetime.scene import Scene
from mtex_usd.constraints.spacetime.solution import Solution, make_solution
from mtex_usd.constraints.spacetime.solve import check_names, one_thread, solve_with
from mtex_usd.errors import InputError

__all__ = ["resolve_near"]


def resolve_near(solution: Solution, changed: Constraint | Sequence[Constraint], *, margin_s: float = 0.25) -> Solution:
    """Solve again where constraints changed, and keep the rest of the motion bit for bit.

    Points that keep still across the border of the neighbourhood keep the places they have.

    Parameters
    ----------
    solution
        What :func:`solve_spacetime` or this function gave.
    changed
        Constraints that replace those of the same name, or are new.
    margin_s
        How far the neighbourhood reaches beyond the frames the constraints are about, or were about, seconds. Where the
        constraints cannot be met in it, it is made twice as wide, if need be up to the whole motion.

    Returns
    -------
    Solution
        With the steps of the search in the neighbourhood, and the residuals of all constraints.

    Raises
    ------
    InputError
        Where a constraint makes no sense, or the margin is not above 0.
    NoSolutionError
        Where the constraints cannot be met together in the whole motion.

    Notes
    -----
    The result is the optimum of the neighbourhood with the rest held. As a change dies away within a few knots, that is
    close to the optimum of the whole; a constraint on joints that none moved before is solved over the whole motion.
    """
    given = (changed,) if isinstance(changed, Constraint) else tuple(changed)
    check_names(given)
    if not margin_s > 0.0:
        raise InputError("bad margin of a neighbourhood", expected="seconds above 0", found=f"{margin_s:g}")
    memory = solution.memory
    constraints = {**memory.constraints, **{constraint.name: constraint for constraint in given}}
    if not given:
        return solution
    spans, cast = _look_at(memory, given)
    if not _covers(memory.cast, cast):
        return solve_with(memory.clips, tuple(constraints.values()), memory.settings)
    spans = {**memory.spans, **spans}
    touched = [memory.spans.get(constraint.name, spans[constraint.name]) for constraint in given]
    touched += [spans[constraint.name] for constraint in given]
    fresh = replace(memory, constraints=constraints, spans=spans)
    first, last = min(first for first, _ in touched), max(last for _, last in touched)
    with one_thread():
        part = solve_part(fresh, first, last, max(1.0, margin_s * memory.clips[0].rate))
    residuals = _residuals(solution, part)
    return make_solution(part.memory, residuals, iterations=part.outcome.iterations, step=part.outcome.step)


def _look_at(memory: Memory, given: Sequence[Constraint]) -> tuple[dict[str, tuple[int, int]], Cast]:
    """Find which frames constraints are about and which joints they move."""
    scene = Scene(clips=memory.clips, window=(0, memory.clips[0].frame_count - 1))
    scene.write_all(given)
    cast = choose_cast(scene, memory.settings)
    return compile_problem(cast, given, scene).spans(), cast


def _covers(cast: Cast, other: Cast) -> bool:
    pairs = zip(cast.characters, other.characters, strict=True)
    return all(set(b.turning) <= set(a.turning) and b.root in (a.root, -1) for a, b in pairs)


def _residuals(solution: Solution, part: Part) -> Mapping[str, float]:
    """Take the violations inside, and those from before outside; where a constraint is on both sides, the larger."""
    out = {**solution.residuals, **part.violations}
    for name, (first, last) in solution.memory.spans.items():
        if name in part.violations and (first < part.window[0] or last > part.window[1]):
            out[name] = max(part.violations[name], solution.residuals[name])
    return out
