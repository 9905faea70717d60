"""Fingers by name: which finger a joint belongs to is told by the first joint that says so, the order by the tree."""

from collections.abc import Mapping
from itertools import pairwise

from mtex_usd.motion.anatomy.conventions import FINGER_WORDS, METACARPAL_WORDS
from mtex_usd.motion.anatomy.parts import FINGERS, SIDES
from mtex_usd.motion.anatomy.tree import Tree
from mtex_usd.motion.anatomy.words import is_noise, split_words

__all__ = ["find_fingers"]

_COUNTED = "finger"
_ENDS = frozenset({"end", "nub", "site"})
_JOINTS = 3


def find_fingers(tree: Tree, limbs: Mapping[str, int]) -> dict[str, int]:
    """Find the finger joints below the hands.

    Parameters
    ----------
    tree
        The skeleton's hierarchy.
    limbs
        Joint by part; the hands are looked below.

    Returns
    -------
    dict of str to int
        Joint by part, such as ``"left.index1"``; at most three joints a finger.
    """
    first_number = _first_number(tree)
    parts: dict[str, int] = {}
    for side in SIDES:
        hand = limbs.get(f"{side}.hand")
        fingers = {} if hand is None else _find_chains(tree, hand, first_number)
        for finger, chain in fingers.items():
            joints = _without_metacarpal(tree, chain, finger)[:_JOINTS]
            parts |= {f"{side}.{finger}{number}": joint for number, joint in enumerate(joints, start=1)}
    return parts


def _first_number(tree: Tree) -> int:
    """Give the number of the thumb where fingers are counted: 0, or 1 where there is a fifth and none with 0."""
    numbers = {number for name in tree.names if (number := _finger_number(split_words(name))) is not None}
    return 1 if 5 in numbers and 0 not in numbers else 0


def _finger_number(words: list[str]) -> int | None:
    """Read the first digit behind ``finger``: Finger21 is the second joint of finger 2."""
    behind = words[words.index(_COUNTED) + 1 :][:1] if _COUNTED in words else []
    return int(behind[0][0]) if behind and behind[0].isdigit() else None


def _find_chains(tree: Tree, hand: int, first_number: int) -> dict[str, list[int]]:
    """Give the joints of each finger; it begins with the first joint on the way from the hand that names it."""
    chains: dict[str, list[int]] = {}
    waiting = list(tree.children[hand])
    while waiting:
        joint = waiting.pop(0)
        finger = _name_finger(tree.names[joint], first_number)
        chain = [joint] if finger is None else _follow(tree, joint, first_number)
        waiting += [child for along in chain for child in tree.children[along] if child not in chain]
        if finger is not None and len(chain) > len(chains.get(finger, ())):
            chains[finger] = chain
    return chains


def _name_finger(name: str, first_number: int) -> str | None:
    words = split_words(name)
    # Names in capitals have no humps: there a finger is found within a word.
    named = [finger for word in words for key, finger in FINGER_WORDS.items() if key in word]
    number = _finger_number(words)
    counted = [] if number is None else list(FINGERS)[number - first_number :][:1]
    return next(iter([*named, *counted]), None)


def _follow(tree: Tree, start: int, first_number: int) -> list[int]:
    finger, joints = _name_finger(tree.names[start], first_number), [start]
    while further := [child for child in tree.children[joints[-1]] if not _is_end(tree, child)]:
        # A name that tells another finger is believed only beside one that tells this: the second joint may be "Mid".
        same = [child for child in further if _name_finger(tree.names[child], first_number) == finger]
        joints.append(max(same or further, key=lambda child: tree.sizes[child]))
    return joints


def _is_end(tree: Tree, joint: int) -> bool:
    return not _ENDS.isdisjoint(split_words(tree.names[joint]))


def _without_metacarpal(tree: Tree, joints: list[int], finger: str) -> list[int]:
    """Drop the bone inside the palm: called so, or without number before the one with number 1."""
    if len(joints) == 1:
        return joints
    words = split_words(tree.names[joints[0]])
    is_called = finger != "thumb" and any(word in METACARPAL_WORDS for word in [*words, *_pairs(words)])
    numbers = [_number(tree.names[joint]) for joint in joints[:2]]
    is_before_first = numbers == [None, 1] and len(joints) > _JOINTS
    return joints[1:] if is_called or is_before_first else joints


def _number(name: str) -> int | None:
    """Give the first number of a name that no copy put there."""
    return next((int(word) for word in split_words(name) if word.isdigit() and not is_noise(word)), None)


def _pairs(words: list[str]) -> list[str]:
    return [a + b for a, b in pairwise(words)]
