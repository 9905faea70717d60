"""What the parts of a humanoid are called."""

from collections.abc import Mapping
from dataclasses import dataclass

__all__ = ["ARM", "CENTRE", "FINGERS", "LEG", "PARTS", "SIDES", "Anatomy"]

SIDES = ("left", "right")
CENTRE = ("hips", "chest", "neck", "head")
ARM = ("upperArm", "foreArm", "hand")
LEG = ("thigh", "shin", "foot", "toes")
FINGERS = ("thumb", "index", "middle", "ring", "pinky")

_OF_A_SIDE = ("clavicle", *ARM, *LEG, *(f"{finger}{number}" for finger in FINGERS for number in (1, 2, 3)))
PARTS = (*CENTRE, *(f"{side}.{part}" for side in SIDES for part in _OF_A_SIDE))


@dataclass(frozen=True, eq=False)
class Anatomy:
    """Which joint of a skeleton begins which part of the body.

    Parameters
    ----------
    convention
        Whose names the joints follow, such as ``"Mixamo"``; ``"mixed"`` where they are those of several, and
        ``"hierarchy"`` where only the shape told.
    parts
        Joint index by part, one of :data:`PARTS`; only the parts that were found. ``hips`` is the joint that legs and
        trunk hang from, ``chest`` the last joint of the trunk, from which arms and neck part, ``left.foreArm`` the
        elbow, ``left.hand`` the wrist, ``left.foot`` the ankle, ``left.index1`` the finger's first joint.
    """

    convention: str
    parts: Mapping[str, int]
