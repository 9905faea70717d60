"""Variants that differ visibly: the ``mtex:diversity`` of the recipe.

It is ours; the paper's best paths often differ nowhere. A path must differ from every better one by a mean angle over
the copied joints, for the whole of at least one fragment.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.texture.finish import Finished, Finisher
from mtex_usd.texture.matching import stretch_linearly
from mtex_usd.texture.paths import Lattice, Path, find_best_path, find_paths
from mtex_usd.texture.recipe import Recipe

__all__ = ["MOST_DIVERSE_PATHS", "find_diverse_paths", "greatest_difference"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

# The search remembers which of the better paths it already differs from: 2 to this power states.
MOST_DIVERSE_PATHS = 12
# Joining draws two paths together a little: ask the raw fragments for more, step by step, until the result has enough.
_MARGIN = 1.1
_TRIES = 12


def find_diverse_paths(
    lattice: Lattice, finisher: Finisher, curves: Sequence[FloatArray], recipe: Recipe
) -> list[tuple[Path, Finished]]:
    """Find the best paths that differ enough from each other, and finish them.

    Parameters
    ----------
    lattice
        Candidates and costs.
    finisher
        Makes a path into motion.
    curves
        Copied channels of every take, [F, C] each.
    recipe
        `diversity` in degrees and `paths`.

    Returns
    -------
    list
        Best first; fewer than asked where no further path differs enough. Difference takes the place of the set of
        zero-cost joins in telling paths apart.
    """
    if recipe.paths > MOST_DIVERSE_PATHS:
        raise InputError(
            "too many paths for a diverse choice",
            expected=f"mtex:paths of at most {MOST_DIVERSE_PATHS} where mtex:diversity is set",
            found=str(recipe.paths),
        )
    best = find_paths(lattice, 1)[0]
    chosen = [(best, finisher.finish(best.choice))]
    angles = _fragment_differences(best, finisher, curves)
    differences = [angles]
    while len(chosen) < recipe.paths:
        found = _next_diverse(lattice, finisher, chosen, differences, recipe.diversity)
        if found is None:
            break
        chosen.append(found)
        differences.append(_fragment_differences(found[0], finisher, curves))
    return chosen


def _next_diverse(
    lattice: Lattice,
    finisher: Finisher,
    chosen: Sequence[tuple[Path, Finished]],
    differences: Sequence[Sequence[FloatArray]],
    diversity: float,
) -> tuple[Path, Finished] | None:
    asked = diversity
    for _ in range(_TRIES):
        differs = [np.stack([path[q] for path in differences]) >= asked for q in range(len(lattice.node_costs))]
        path = find_best_path(lattice, differs)
        if path is None:
            return None
        done = finisher.finish(path.choice)
        if all(greatest_difference(done, better, finisher) >= diversity for _, better in chosen):
            return path, done
        asked *= _MARGIN
    return None


def _fragment_differences(path: Path, finisher: Finisher, curves: Sequence[FloatArray]) -> list[FloatArray]:
    """Mean angle, degrees, of every candidate from the path's own over their fragment; Q arrays of shape [K]."""
    columns = _angle_columns(finisher)
    result = []
    for (first, last), found, own in zip(finisher.fragments, finisher.candidates, path.choice, strict=True):
        pairs = np.stack([found.first, found.last], axis=1)
        pieces = [
            stretch_linearly(curves[take], pair[None], int(last - first) + 1)[0]
            for take, pair in zip(found.take, pairs, strict=True)
        ]
        apart = np.stack(pieces) - pieces[own]
        angles = [np.linalg.norm(apart[..., of_joint], axis=-1) for of_joint in columns.values()]
        result.append(np.mean(angles, axis=(0, 2)) if angles else np.zeros(len(found.take)))
    return result


def _angle_columns(finisher: Finisher) -> dict[int, list[int]]:
    """Columns that hold the rotation of each copied joint, whether a vector or angles."""
    columns: dict[int, list[int]] = {}
    for column, channel in enumerate(finisher.space.channels):
        if channel.is_rotation:
            columns.setdefault(channel.joint, []).append(column)
    return columns


def greatest_difference(a: Finished, b: Finished, finisher: Finisher) -> float:
    """Mean angle between two results over the copied joints, degrees, in the fragment where it is greatest.

    Where nothing is synthesized the joined paths are compared, since texture leaves the motion itself in place.
    """
    joints = list(_angle_columns(finisher))
    if not joints:
        return 0.0
    rotations = [_rotations_to_compare(done, finisher)[:, joints] for done in (a, b)]
    angles = np.degrees(quaternion.angle_between(*rotations)).mean(axis=1)
    return max(float(angles[first : last + 1].mean()) for first, last in finisher.fragments)


def _rotations_to_compare(done: Finished, finisher: Finisher) -> FloatArray:
    if finisher.synthesized.any():
        return done.clip.rotations
    space = finisher.space
    return space.apply(space.from_curves(done.joined), finisher.sketch).rotations
