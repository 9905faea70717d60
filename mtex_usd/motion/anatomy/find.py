"""The way from a skeleton to its anatomy: names first, then shape."""

from functools import lru_cache
from types import MappingProxyType

from mtex_usd.motion.anatomy.fingers import find_fingers
from mtex_usd.motion.anatomy.named import find_by_name
from mtex_usd.motion.anatomy.parts import PARTS, Anatomy
from mtex_usd.motion.anatomy.shape import find_by_shape, find_head, is_quadruped
from mtex_usd.motion.anatomy.tree import Tree
from mtex_usd.motion.anatomy.trunk import find_trunk
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["find_anatomy"]


@lru_cache(maxsize=64)
def find_anatomy(skeleton: Skeleton) -> Anatomy | None:
    """Find the parts of a humanoid.

    The convention of :mod:`~mtex_usd.motion.anatomy.conventions` that names most joints in agreement with the hierarchy
    tells limbs and head; where none names two legs, the shape of the hierarchy and the rest pose do. Hips, chest, neck
    and clavicles follow from where the limbs hang.

    Parameters
    ----------
    skeleton
        Any skeleton, whichever way it stands at rest.

    Returns
    -------
    Anatomy or None
        None where it is no humanoid: no two legs by name, and by shape not two legs below two arms.
    """
    tree = Tree(skeleton)
    found = _find_limbs(tree)
    if found is None:
        return None
    convention, limbs = found
    parts = limbs | find_fingers(tree, limbs)
    if "head" not in parts:
        parts |= find_head(tree, limbs)
    parts |= find_trunk(tree, parts)
    ordered = {part: parts[part] for part in PARTS if part in parts}
    return Anatomy(convention=convention, parts=MappingProxyType(ordered))


def _find_limbs(tree: Tree) -> tuple[str, dict[str, int]] | None:
    named = find_by_name(tree)
    if named is None:
        return find_by_shape(tree)
    # Hind legs are often named as a human's; who has arms by name is taken at its word.
    has_arms = any(part.endswith(".upperArm") for part in named[1])
    return named if has_arms or not is_quadruped(tree) else None
