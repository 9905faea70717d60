"""Sections of a body that two skeletons have in common, each with the joints either has there.

A section runs from one part to another down the hierarchy, such as from the elbow to the wrist. The skeletons may have
different numbers of joints in it: three joints in one spine stand for five in another.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import Literal

from mtex_usd.motion.anatomy import SIDES, Anatomy
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["Chain", "Mode", "Section", "find_sections"]

Mode = Literal["aim", "follow", "turn"]
_Bone = tuple[str, str | None, Mode]


@dataclass(frozen=True)
class Chain:
    """Joints of one skeleton in a section.

    Parameters
    ----------
    joints
        From the one it begins with down to the last before its end, at least one.
    end
        The joint it ends at; None where it is a limb's last.
    """

    joints: tuple[int, ...]
    end: int | None

    @property
    def all_joints(self) -> tuple[int, ...]:
        """The joints, with the end where there is one."""
        return self.joints if self.end is None else (*self.joints, self.end)


@dataclass(frozen=True)
class Section:
    """One section in two skeletons.

    Parameters
    ----------
    name
        The parts it lies between.
    source, target
        Its joints in the take's skeleton and in the character's.
    mode
        What bones do beside turning as the source's do since rest: `aim` lays them along the source's; `follow` leans
        them in rest as the bone above was leaned; `turn` is nothing more.
    keeps_first
        Whether the first joint is turned even so: the pelvis carries the legs as well.
    """

    name: str
    source: Chain
    target: Chain
    mode: Mode
    keeps_first: bool = False

    def is_aimed(self, at: int) -> bool:
        """Whether the bone of the target's joint at a place in the section takes the direction of the source's."""
        return self.mode == "aim" and not (at == 0 and self.keeps_first)


# What begins and ends a section, and how it is turned. Feet are not aimed: how far the toes are below the ankle is how
# a foot is built, and a sole that was flat would be no more. Neither are the last joints, which end nowhere.
_MIDDLE: tuple[_Bone, ...] = (("hips", "neck", "aim"), ("neck", "head", "aim"), ("head", None, "turn"))
_LIMBS: tuple[_Bone, ...] = (
    ("hips", "thigh", "turn"),
    ("thigh", "shin", "aim"),
    ("shin", "foot", "aim"),
    ("foot", "toes", "turn"),
    ("toes", None, "turn"),
    ("clavicle", "upperArm", "aim"),
    ("upperArm", "foreArm", "aim"),
    ("foreArm", "hand", "aim"),
    ("hand", None, "follow"),
)
_FINGERS = ("thumb", "index", "middle", "ring", "pinky")
_BONES: tuple[_Bone, ...] = (("1", "2", "aim"), ("2", "3", "aim"), ("3", None, "follow"))
# Where a part is missing in one of the skeletons the section ends at the next that both have.
_STAND_INS = {"neck": ("neck", "head", "chest")}


def find_sections(
    source: Skeleton,
    found: Anatomy,
    target: Skeleton,
    wanted: Anatomy,
    *,
    pairs: Mapping[int, int],
    named: Mapping[int, int],
    left_out: Collection[int],
) -> list[Section]:
    """Find the sections two humanoids have in common.

    Parameters
    ----------
    source, found
        The take's skeleton and its parts.
    target, wanted
        The character's.
    pairs
        Joints that correspond as the user says, source by target, parts among them. One within a section divides it.
    named
        Joints of the same name, source by target; they count where nothing else does, for either of them.
    left_out
        Joints of the target that are in no section.

    Returns
    -------
    list of Section
        A joint of the target is in one of them at most.
    """
    shared = {part: (found.parts[part], joint) for part, joint in wanted.parts.items() if part in found.parts}
    sections = [section for bone in _bones() if (section := _make_section(bone, source, target, shared)) is not None]
    for joint, other in pairs.items():
        sections = [part for section in sections for part in _divide(section, joint, other)]
    said = _take_once(_add_pairs(sections, pairs, source, target), left_out)
    covered = {joint for section in said for joint in section.target.joints} | set(left_out)
    used = {joint for section in said for joint in section.source.joints}
    rest = {joint: other for joint, other in named.items() if joint not in covered and other not in used}
    return [*said, *_pair_sections(rest, source, target)]


def _add_pairs(sections: list[Section], pairs: Mapping[int, int], source: Skeleton, target: Skeleton) -> list[Section]:
    """Add pairs that no section begins with, before the sections where one has the joint, since they are stronger."""
    begun = {section.target.joints[0] for section in sections}
    inside = {joint for section in sections for joint in section.target.joints} - begun
    alone = [
        Section(target.joints[joint], Chain((other,), None), Chain((joint,), None), "turn")
        for joint, other in pairs.items()
        if joint in inside
    ]
    further = {joint: other for joint, other in pairs.items() if joint not in begun | inside}
    return [*alone, *sections, *_pair_sections(further, source, target)]


def _divide(section: Section, joint: int, other: int) -> list[Section]:
    """Cut a section where a pair of joints lies in both of its chains."""
    own, source = section.target, section.source
    if joint not in own.joints[1:] or other not in source.joints[1:]:
        return [section]
    cut, cut_source = own.joints.index(joint), source.joints.index(other)
    upper = replace(section, target=Chain(own.joints[:cut], joint), source=Chain(source.joints[:cut_source], other))
    lower = replace(
        section,
        name=f"{section.name}, below",
        target=Chain(own.joints[cut:], own.end),
        source=Chain(source.joints[cut_source:], source.end),
        keeps_first=False,
    )
    return [upper, lower]


def _bones() -> list[_Bone]:
    """Every section of a body by its parts."""
    limbs = [
        (begin if begin == "hips" else f"{side}.{begin}", end and f"{side}.{end}", mode)
        for side in SIDES
        for begin, end, mode in _LIMBS
    ]
    fingers = [
        (f"{side}.{finger}{begin}", end and f"{side}.{finger}{end}", mode)
        for side in SIDES
        for finger in _FINGERS
        for begin, end, mode in _BONES
    ]
    return [*_MIDDLE, *limbs, *fingers]


def _stand_in(part: str | None, shared: Mapping[str, tuple[int, int]]) -> str | None:
    return next((other for other in _STAND_INS.get(part or "", ()) if other in shared), part)


def _make_section(
    bone: _Bone, source: Skeleton, target: Skeleton, shared: Mapping[str, tuple[int, int]]
) -> Section | None:
    """Give one section, None where the skeletons do not have it in common."""
    begin, end, mode = bone
    if begin not in shared or _is_lone_finger(begin, shared):
        return None
    end = _stand_in(end, shared)
    (first, own_first), (last, own_last) = shared[begin], shared.get(end or "", (None, None))
    chain, own = _chain(source, first, last), _chain(target, own_first, own_last)
    if begin == "hips" and mode == "turn":
        # The pelvis itself belongs to the trunk; what is left are joints between it and the thigh.
        if len(own.joints) == 1:
            return None
        chain, own = Chain(chain.joints[1:] or chain.joints, chain.end), Chain(own.joints[1:], own.end)
    aims = mode == "aim" and chain.end is not None and own.end is not None
    name = f"{begin} to {end}" if end else begin
    return Section(name, chain, own, mode if aims or mode != "aim" else "turn", keeps_first=begin == "hips" and aims)


def _is_lone_finger(part: str, shared: Mapping[str, tuple[int, int]]) -> bool:
    """Whether a finger has one joint alone, as in skeletons whose fingers were never captured."""
    return part[-1] == "1" and part[:-1].endswith(_FINGERS) and f"{part[:-1]}2" not in shared


def _chain(skeleton: Skeleton, begin: int, end: int | None) -> Chain:
    """Joints from one down to another; only the first where the other is not below it."""
    if end is None:
        return Chain((begin,), None)
    way = skeleton.chain(end)
    if begin not in way or begin == end:
        return Chain((begin,), None)
    return Chain(tuple(way[way.index(begin) : -1]), end)


def _pair_sections(pairs: Mapping[int, int], source: Skeleton, target: Skeleton) -> list[Section]:
    """Each further pair down to the next below it, as its own section."""
    sections = []
    for joint, other in pairs.items():
        below = [j for j in pairs if j != joint and joint in target.chain(j) and other in source.chain(pairs[j])[:-1]]
        nearest = min(below, key=lambda j: len(target.chain(j)), default=None)
        chain = _chain(source, other, None if nearest is None else pairs[nearest])
        own = _chain(target, joint, nearest)
        sections.append(Section(target.joints[joint], chain, own, "follow" if nearest is None else "aim"))
    return sections


def _take_once(sections: list[Section], left_out: Collection[int]) -> list[Section]:
    """Leave joints to the first section that has them."""
    taken = set(left_out)
    kept = []
    for section in sections:
        free = tuple(joint for joint in section.target.joints if joint not in taken)
        if free:
            kept.append(_shorten(section, free))
            taken.update(free)
    return kept


def _shorten(section: Section, free: tuple[int, ...]) -> Section:
    """Leave out joints of the target; where the first is among them, the source's first as well."""
    target = Chain(free, section.target.end)
    if free[0] == section.target.joints[0]:
        return replace(section, target=target)
    source = Chain(section.source.joints[1:] or section.source.joints, section.source.end)
    return replace(section, target=target, source=source, keeps_first=False)
