"""Limbs and head by shape, where names do not tell.

Lengths of bones, unlike positions, are the same in every rest pose, so branches are compared by them: two like branches
near the root are the legs, two like ones further up the trunk the arms, and the third branch there carries the head.
Only which side is left is asked of the positions, where no name says it, in directions of the body's own: up is from
the hips to the head, forward from the ankles to the toes.
"""

from collections.abc import Mapping
from itertools import combinations

import numpy as np

from mtex_usd.motion.anatomy.branches import Shape, unit
from mtex_usd.motion.anatomy.parts import ARM, LEG, SIDES
from mtex_usd.motion.anatomy.sides import find_left, order_sides
from mtex_usd.motion.anatomy.tree import Tree
from mtex_usd.motion.skeleton import FloatArray

__all__ = ["find_by_shape", "find_head", "is_quadruped"]

_ALIKE = 0.15  # of a branch's length: how much its bones may differ from its twin's; captured legs differ by 0.03
_LEAST_REACH = 0.25  # of the longest pair of branches: below are fingers, hair and straps
_LEAST_APART = 0.05  # of the bone below: joints nearer their twin are clavicles or pelvis, whatever their length
_LEVEL = 0.5  # cosine: a trunk that stands this level on four limbs is a quadruped's
_HANGING = 0.8  # cosine of forelegs with the hind legs
_SKULL = 1.5  # a skull is so much longer than a bone of the neck

_Pair = tuple[list[int], list[int]]


def find_by_shape(tree: Tree) -> tuple[str, dict[str, int]] | None:
    """Find limbs and head by the hierarchy and the rest pose.

    Parameters
    ----------
    tree
        The skeleton's hierarchy.

    Returns
    -------
    tuple of str and dict, or None
        ``"hierarchy"`` and the joint by part; None where there are not two legs below two arms, or where the trunk lies
        level on four legs.
    """
    shape = Shape(tree)
    found = _find_limbs(shape)
    if found is None or _stands_on_four(shape, *found):
        return None
    legs, arms = found
    left = find_left(shape, legs, up=_root(shape, arms) - _root(shape, legs))
    limbs: dict[str, int] = {}
    for pair, names in ((legs, LEG), (arms, ARM)):
        for side, branch in zip(SIDES, order_sides(shape, pair, left), strict=True):
            limbs |= {f"{side}.{name}": joint for name, joint in zip(names, branch, strict=False)}
    return "hierarchy", limbs


def is_quadruped(tree: Tree) -> bool:
    """Tell whether a level trunk stands on two like pairs of legs at rest.

    Parameters
    ----------
    tree
        The skeleton's hierarchy.
    """
    shape = Shape(tree)
    found = _find_limbs(shape)
    return found is not None and _stands_on_four(shape, *found)


def find_head(tree: Tree, limbs: Mapping[str, int]) -> dict[str, int]:
    """Find the head as what the branch that goes on from the trunk above the arms carries.

    Parameters
    ----------
    tree
        The skeleton's hierarchy.
    limbs
        Joint by part; without both upper arms and both thighs nothing is found.

    Returns
    -------
    dict of str to int
        The joint of the part ``"head"``, if any.
    """
    ends = [limbs.get(f"{side}.{part}") for part in ("upperArm", "thigh") for side in SIDES]
    arms, legs = [joint for joint in ends[:2] if joint is not None], [joint for joint in ends[2:] if joint is not None]
    if len(arms) < 2 or len(legs) < 2:
        return {}
    shape, chest, hips = Shape(tree), tree.meet(*arms), tree.meet(*legs)
    if chest is None or hips is None:
        return {}
    limb_joints = {joint for limb in (*arms, *legs) for joint in tree.chain(limb)}
    starts = [child for child in shape.children[chest] if child not in limb_joints]
    up = shape.positions[chest] - shape.positions[hips]
    start = max(starts, key=lambda child: _height(shape, child, up), default=None)
    return {} if start is None else {"head": _pick_head(shape, start)}


def _height(shape: Shape, start: int, up: FloatArray) -> float:
    """How far up anything of a branch is."""
    heights = [float(shape.positions[start] @ up)]
    return max([*heights, *(_height(shape, child, up) for child in shape.children[start])])


def _pick_head(shape: Shape, start: int) -> int:
    """Give the first joint that carries several, else the last one, or that before a bone as long as a skull."""
    joints = shape.branch(start)
    forks = [joint for joint in joints if len(shape.children[joint]) > 1]
    if forks:
        return forks[0]
    bones = shape.lengths[joints[1:]]
    ends_in_skull = len(bones) > 1 and bones[-1] >= _SKULL * bones[:-1].max()
    return joints[-2] if ends_in_skull else joints[-1]


def _find_limbs(shape: Shape) -> tuple[_Pair, _Pair] | None:
    """Give legs and arms from their first joints on, left and right in any order."""
    found = _find_pairs(shape)
    if found is None:
        return None
    legs, arms = (_cut_limbs(shape, pair) for pair in found)
    return None if legs is None or arms is None else (legs, arms)


def _find_pairs(shape: Shape) -> tuple[_Pair, _Pair] | None:
    """Find the longest two pairs of like branches of which one hangs from between the other."""
    pairs = {joint: pair for joint in range(len(shape.children)) if (pair := _find_twins(shape, joint)) is not None}
    reaches = {joint: min(shape.length(branch) for branch in pair) for joint, pair in pairs.items()}
    least = _LEAST_REACH * max(reaches.values(), default=0.0)
    nested = [
        (lower, upper)
        for lower in pairs
        for upper in pairs
        if _carries(shape, pairs[lower], lower, upper) and min(reaches[lower], reaches[upper]) >= least
    ]
    best = max(nested, key=lambda both: reaches[both[0]] + reaches[both[1]], default=None)
    return None if best is None else (pairs[best[0]], pairs[best[1]])


def _carries(shape: Shape, legs: _Pair, lower: int, upper: int) -> bool:
    trunk = shape.tree.below(lower, upper)
    return bool(trunk) and trunk[0] not in {legs[0][0], legs[1][0]}


def _find_twins(shape: Shape, joint: int) -> _Pair | None:
    """Give the longest two branches of a joint that are alike and have two bones or more."""
    branches = [branch for child in shape.children[joint] if len(branch := shape.branch(child)) > 2]
    twins = [(a, b) for a, b in combinations(branches, 2) if _difference(shape, a, b) <= _ALIKE]
    return max(twins, key=lambda pair: min(shape.length(branch) for branch in pair), default=None)


def _difference(shape: Shape, a: list[int], b: list[int]) -> float:
    """How much the bones of two branches differ, as a share of the longer branch."""
    bones = np.zeros((2, max(len(a), len(b)) - 1))
    for row, branch in zip(bones, (a, b), strict=True):
        row[: len(branch) - 1] = shape.lengths[branch[1:]]
    longer = bones.sum(axis=1).max()
    return float(np.abs(bones[0] - bones[1]).sum() / longer) if longer > 0.0 else 1.0


def _cut_limbs(shape: Shape, pair: _Pair) -> _Pair | None:
    """Begin the branches at the joint above the one where two long bones meet."""
    count = min(map(len, pair))
    bones = shape.lengths[pair[0][:count]] + shape.lengths[pair[1][:count]]
    best, cut = 0.0, None
    for first in range(count - 2):
        upper, lower = bones[first + 1], bones[first + 2]
        apart = shape.apart(pair[0][first], pair[1][first])
        if apart >= _LEAST_APART * upper / 2.0 and min(upper, lower) > best:
            best, cut = min(upper, lower), first
    return None if cut is None else (pair[0][cut:], pair[1][cut:])


def _stands_on_four(shape: Shape, legs: _Pair, arms: _Pair) -> bool:
    trunk = unit(_root(shape, arms) - _root(shape, legs))
    hind, fore = (unit(shape.mean([a[2], b[2]]) - shape.mean([a[0], b[0]])) for a, b in (legs, arms))
    return bool(abs(trunk @ hind) < _LEVEL and fore @ hind > _HANGING)


def _root(shape: Shape, pair: _Pair) -> FloatArray:
    return np.asarray(shape.positions[shape.tree.meet(pair[0][0], pair[1][0])])
