"""What lies between the limbs: hips, chest, neck and clavicles follow from where the limbs hang."""

from collections.abc import Mapping

from mtex_usd.motion.anatomy.conventions import HIPS_KEYS, NECK_WORDS
from mtex_usd.motion.anatomy.named import find_keyed
from mtex_usd.motion.anatomy.parts import SIDES
from mtex_usd.motion.anatomy.tree import Tree
from mtex_usd.motion.anatomy.words import split_words

__all__ = ["find_trunk"]


def find_trunk(tree: Tree, limbs: Mapping[str, int]) -> dict[str, int]:
    """Find hips, chest, neck and clavicles.

    Parameters
    ----------
    tree
        The skeleton's hierarchy.
    limbs
        Joint by part of the limbs, legs among them, and of the head where it is known.

    Returns
    -------
    dict of str to int
        Joint by part, only of what there is.
    """
    fork = _meet(tree, limbs, "thigh")
    top = _meet(tree, limbs, "upperArm")
    neck = _find_neck(tree, fork, top, limbs.get("head"))
    chest = top if top is not None and top != neck else _parent(tree, neck)
    hips = _find_hips(tree, fork, chest)
    middle = {"hips": hips, "chest": None if chest == hips else chest, "neck": neck}
    parts = {part: joint for part, joint in middle.items() if joint is not None}
    return parts | _find_clavicles(tree, limbs, top)


def _meet(tree: Tree, limbs: Mapping[str, int], part: str) -> int | None:
    joints = [limbs[f"{side}.{part}"] for side in SIDES if f"{side}.{part}" in limbs]
    return tree.meet(*joints) if len(joints) == 2 else None


def _parent(tree: Tree, joint: int | None) -> int | None:
    return None if joint is None or tree.parents[joint] < 0 else tree.parents[joint]


def _find_neck(tree: Tree, fork: int | None, top: int | None, head: int | None) -> int | None:
    """Give the first joint on the way to the head that is called neck, else the one above which the arms part."""
    if head is None or fork is None:
        return None
    called = [joint for joint in tree.below(fork, head)[:-1] if _is_neck(tree.names[joint])]
    above = tree.below(top, head)[:-1] if top is not None else []
    return next(iter([*called, *above]), None)


def _is_neck(name: str) -> bool:
    return any(neck in word for word in split_words(name) for neck in NECK_WORDS)


def _find_hips(tree: Tree, fork: int | None, chest: int | None) -> int | None:
    """Give the joint legs and trunk hang from; one called hips above it where it is not called so itself."""
    if fork is None:
        return None
    shared = fork if chest is None else tree.meet(fork, chest)
    called = find_keyed(tree, HIPS_KEYS)
    above = [] if shared is None else [joint for joint in tree.chain(shared) if joint in called]
    return above[-1] if above else shared


def _find_clavicles(tree: Tree, limbs: Mapping[str, int], top: int | None) -> dict[str, int]:
    clavicles = {}
    for side in SIDES:
        arm = limbs.get(f"{side}.upperArm")
        between = [] if arm is None or top is None else tree.below(top, arm)[:-1]
        if between:
            clavicles[f"{side}.clavicle"] = between[0]
    return clavicles
