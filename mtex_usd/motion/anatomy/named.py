"""Limbs and head by name: every convention is tried whole, the one that explains most joints wins."""

import re
from collections import defaultdict
from collections.abc import Mapping

from mtex_usd.motion.anatomy.conventions import CONVENTIONS, Convention
from mtex_usd.motion.anatomy.parts import ARM, LEG, SIDES
from mtex_usd.motion.anatomy.tree import Tree
from mtex_usd.motion.anatomy.words import read_names

__all__ = ["find_by_name", "find_keyed"]

_Index = Mapping[tuple[str, str], int]


def find_by_name(tree: Tree) -> tuple[str, dict[str, int]] | None:
    """Find limbs and head by the names of the joints.

    Parameters
    ----------
    tree
        The skeleton's hierarchy.

    Returns
    -------
    tuple of str and dict, or None
        The convention and the joint by part, of limbs that agree with the hierarchy; None where no convention tells two
        legs.
    """
    index = _index_readings(tree)
    found = [(convention.name, _apply(convention, tree, index)) for convention in CONVENTIONS]
    walking = [(name, parts) for name, parts in found if {"left.thigh", "right.thigh"} <= parts.keys()]
    return max(walking, key=lambda find: len(find[1]), default=None)


def find_keyed(tree: Tree, keys: tuple[str, ...]) -> set[int]:
    """Give the joints without side that may be known by any of some keys.

    Parameters
    ----------
    tree
        The skeleton's hierarchy.
    keys
        Names as the tables of conventions have them.
    """
    return {
        joint
        for joint, name in enumerate(tree.names)
        if any(not reading.side and reading.key in keys for reading in read_names(name))
    }


def _index_readings(tree: Tree) -> _Index:
    """Give the likeliest joint for every side and key: least left out of its name, most hanging from it."""
    candidates: dict[tuple[str, str], list[tuple[tuple[int, int], int, str, int]]] = defaultdict(list)
    for joint, name in enumerate(tree.names):
        for reading in read_names(name):
            rank = (reading.cost, -tree.sizes[joint], tree.skeleton.joints[joint], joint)
            candidates[reading.side, reading.key].append(rank)
    return {known_by: min(ranks)[-1] for known_by, ranks in candidates.items()}


def _apply(convention: Convention, tree: Tree, index: _Index) -> dict[str, int]:
    if convention.mark and not any(re.search(convention.mark, name.lower()) for name in tree.names):
        return {}
    parts: dict[str, int] = {}
    for limb in (LEG, ARM):
        left, right = (_follow_limb(convention, tree, index, side=side, limb=limb) for side in SIDES)
        if _are_apart(tree, left, right) and not any(
            _is_entangled(tree, parts, joint) for joint in _firsts(left, right)
        ):
            parts |= left | right
    head = _pick(index, "", convention.head)
    return parts if head is None or _is_entangled(tree, parts, head) else {**parts, "head": head}


def _follow_limb(
    convention: Convention, tree: Tree, index: _Index, *, side: str, limb: tuple[str, ...]
) -> dict[str, int]:
    """Collect the joints of a limb from the body outwards as long as each hangs from the one before."""
    found: dict[str, int] = {}
    for part in limb:
        joint = _pick(index, side, convention.limbs[part])
        if joint is None or (found and not tree.is_above(list(found.values())[-1], joint)):
            break
        found[f"{side}.{part}"] = joint
    return found if len(found) > 1 else {}


def _pick(index: _Index, side: str, keys: tuple[str, ...]) -> int | None:
    return next((index[side, key] for key in keys if (side, key) in index), None)


def _firsts(*limbs: Mapping[str, int]) -> list[int]:
    return [next(iter(limb.values())) for limb in limbs if limb]


def _are_apart(tree: Tree, left: Mapping[str, int], right: Mapping[str, int]) -> bool:
    """Tell whether the limbs of both sides hang from one body and none from the other."""
    first = _firsts(left, right)
    return len(first) < 2 or tree.meet(*first) not in {None, *first}


def _is_entangled(tree: Tree, limbs: Mapping[str, int], joint: int) -> bool:
    """Tell whether a joint is one of a limb's, hangs from one or carries one."""
    return any(joint == other or tree.is_above(other, joint) or tree.is_above(joint, other) for other in limbs.values())
