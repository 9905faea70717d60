"""What rigs call the joints of limbs and head, by convention.

A name is matched by its last words without side, prefix and noise, run together in lower case: ``mixamorig:LeftUpLeg``
and ``up_leg.L`` are both ``upleg``. What one convention calls the clavicle is the upper arm in another, so each is
tried whole. Clavicles, spine and the hips' pelvis follow from the hierarchy and stand in no table.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["CONVENTIONS", "FINGER_WORDS", "HIPS_KEYS", "METACARPAL_WORDS", "NECK_WORDS", "Convention"]

HIPS_KEYS = ("hips", "hip", "pelvis")
NECK_WORDS = ("neck", "neklo", "nekhi")


@dataclass(frozen=True)
class Convention:
    """The names of one family of rigs.

    Parameters
    ----------
    name
        What :attr:`~mtex_usd.motion.anatomy.Anatomy.convention` reports.
    limbs
        Names by part of arm and leg; of several the first that the skeleton has.
    head
        Names of the head.
    mark
        Regular expression that some joint's name, in lower case, has to contain; empty where any will do. It tells
        families apart that use the same names.
    """

    name: str
    limbs: Mapping[str, tuple[str, ...]]
    head: tuple[str, ...] = ("head",)
    mark: str = field(default="", kw_only=True)


def _limbs(arm: str, leg: str) -> dict[str, tuple[str, ...]]:
    """Read ``"upperarm forearm wrist|hand"``: parts from the body outwards, alternatives behind bars."""
    names = [*arm.split(), *leg.split()]
    parts = ("upperArm", "foreArm", "hand", "thigh", "shin", "foot", "toes")
    return {part: tuple(alternatives.split("|")) for part, alternatives in zip(parts, names, strict=True)}


_HUMAN_IK = _limbs("arm forearm hand", "upleg leg foot toebase|toes|toe|forefoot")
_VRM = _limbs("upperarm lowerarm hand", "upperleg lowerleg foot toes|toe|toebase")
_BIPED = _limbs("upperarm forearm hand", "thigh calf foot toe0|toebase|toe")

# Of equal finds the first wins: what asks for a mark stands before what does not.
CONVENTIONS = (
    Convention("CMU", _limbs("humerus radius wrist|hand", "femur tibia foot toes")),
    Convention("Mixamo", _HUMAN_IK, mark=r"mixamorig"),
    Convention("Apple", _HUMAN_IK, mark=r"shoulder_1_joint"),
    Convention("Perception Neuron", _HUMAN_IK, mark=r"^(?!character\d*_).*inhand"),
    Convention("HumanIK", _HUMAN_IK, mark=r"^character\d*_"),
    Convention("MotionBuilder", _HUMAN_IK),
    Convention("Unreal", _limbs("upperarm lowerarm hand", "thigh calf foot ball")),
    Convention("VRM", _VRM),
    Convention("Xsens", _limbs("upperarm forearm hand", "upperleg lowerleg foot toe|toes")),
    Convention("Biovision", _limbs("uparm lowarm hand|wrist", "upleg lowleg foot|ankle toe|toes")),
    Convention("Biovision", _limbs("shoulder elbow wrist|hand", "hip knee ankle|foot toe|toes")),
    Convention("Valve", _BIPED, ("head1",), mark=r"valvebiped"),
    Convention("Character Creator", _BIPED, mark=r"cc_base"),
    Convention("3ds Max Biped", _BIPED),
    Convention("Blender", _limbs("upperarm forearm hand", "thigh shin foot toe"), ("spine006", "head")),
    Convention("SMPL", _limbs("shoulder elbow wrist", "hip knee ankle foot")),
    Convention("Daz", _limbs("shldr|shldrbend forearm|forearmbend hand", "thigh|thighbend shin foot toe")),
    Convention("MakeHuman", _limbs("upperarm01 lowerarm01 wrist", "upperleg01 lowerleg01 foot toe11")),
    Convention(
        "mixed",
        _limbs(
            "upperarm|uparm|humerus|arm|shldr|shoulder forearm|lowerarm|lowarm|radius|elbow wrist|hand",
            "thigh|upperleg|upleg|femur|hip|leg shin|calf|lowerleg|lowleg|tibia|knee|leg ankle|foot"
            " toes|toe|toebase|toe0|ball|foot",
        ),
    ),
)

# Parts of a name within the hand; the first that fits.
FINGER_WORDS = {
    "thumb": "thumb",
    "index": "index",
    "pointer": "index",
    "mid": "middle",
    "ring": "ring",
    "pink": "pinky",
    "little": "pinky",
}
METACARPAL_WORDS = frozenset({"metacarpal", "carpal", "palm", "inhand"})
