"""Which joint of a take drives which joint of a character, found by names and shape or said by the user."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

from mtex_usd.constraints.retargeting.body import measure_body, measure_scale
from mtex_usd.constraints.retargeting.sections import Section, find_sections
from mtex_usd.constraints.retargeting.transfer import Share, Stance, find_shares
from mtex_usd.errors import InputError
from mtex_usd.motion.anatomy import Anatomy, find_anatomy
from mtex_usd.motion.arguments import refuse
from mtex_usd.motion.correspondence import corresponding_joints
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["JointMap", "Pair", "as_pairs", "map_joints"]

_NO_HUMANOID = "pairs"  # the convention of skeletons that are known by what the user names alone


@dataclass(frozen=True)
class Pair:
    """A pair of joints the user names.

    Parameters
    ----------
    joint
        Of the character, full path or last name where that is unique.
    source
        Of the take; empty where the joint is to be left at rest.
    """

    joint: str
    source: str


@dataclass(frozen=True, eq=False, kw_only=True)
class JointMap:
    """What maps to what.

    Parameters
    ----------
    stance
        The two skeletons and how their rest poses are laid on each other.
    anatomies
        The parts of the take's skeleton and of the character's, as mapped.
    sections
        Where both have joints.
    """

    stance: Stance
    anatomies: tuple[Anatomy, Anatomy]
    sections: tuple[Section, ...]

    @property
    def shares(self) -> tuple[Share, ...]:
        """What turns each mapped joint, in the character's order."""
        shares = [share for section in self.sections for share in find_shares(section, self.stance)]
        return tuple(sorted(shares, key=lambda share: share.joint))

    @property
    def scale(self) -> float:
        """Length of the character's legs in those of the take's."""
        found, wanted = self.anatomies
        return measure_scale(self.stance.source, found, self.stance.target, wanted)

    @property
    def mapped(self) -> dict[str, dict[str, float]]:
        """Joints of the take, with the weight of each, by joint of the character; full paths."""
        own, others = self.stance.target.joints, self.stance.source.joints
        return {own[s.joint]: {others[joint]: weight for joint, weight in s.sources} for s in self.shares}

    @property
    def unmapped(self) -> tuple[str, ...]:
        """Joints of the character that stay at rest."""
        mapped = self.mapped
        return tuple(joint for joint in self.stance.target.joints if joint not in mapped)

    @property
    def unused(self) -> tuple[str, ...]:
        """Joints of the take that drive nothing."""
        used = {joint for sources in self.mapped.values() for joint in sources}
        return tuple(joint for joint in self.stance.source.joints if joint not in used)


def as_pairs(values: object) -> tuple[Pair, ...]:
    """Take pairs of joints as people give them.

    Parameters
    ----------
    values
        Several, each a Pair or two names.

    Raises
    ------
    InputError
        Where they are anything else, such as names one after the other.
    """
    expected = "a list of pairs (joint of the character, joint of the motion)"
    if not isinstance(values, Iterable) or isinstance(values, str | bytes | Mapping):
        raise refuse(values, "pairs", expected)
    return tuple(_as_pair(value, expected) for value in values)


def _as_pair(value: object, expected: str) -> Pair:
    if isinstance(value, Pair):
        names: list[object] = [value.joint, value.source]
    else:
        names = list(value) if isinstance(value, Sequence) and not isinstance(value, str | bytes) else []
    texts = [name for name in names if isinstance(name, str)]
    if len(texts) != 2 or len(names) != 2:
        raise refuse(value, "pair of joints", expected)
    return Pair(*texts)


def map_joints(source: Skeleton, target: Skeleton, pairs: Sequence[Pair] = ()) -> JointMap:
    """Map a take's joints to a character's.

    Parameters
    ----------
    source, target
        The take's skeleton and the character's.
    pairs
        What the user says; stronger than what is recognised.

    Returns
    -------
    JointMap
        Parts are recognised by the names of the common conventions, else by the shape of the skeleton.

    Raises
    ------
    InputError
        Where a pair names a joint that is not there or one that another names, or one of the skeletons is no humanoid.
    """
    said = _resolve_pairs(pairs, source, target)
    pairs_said = {joint: other for joint, other in said.items() if other is not None}
    found, wanted = (
        _recognise(source, "take", said=pairs_said.values()),
        _recognise(target, "character", said=pairs_said),
    )
    left_out = said.keys() - pairs_said.keys()
    if found.convention == _NO_HUMANOID:
        # What moves a character as a whole is not guessed at where it is not said.
        left_out |= {wanted.parts["hips"]} - pairs_said.keys()
    found = _apply_pairs(found, wanted, pairs_said)
    stance = Stance(source=source, target=target, bodies=(measure_body(source, found), measure_body(target, wanted)))
    named = corresponding_joints(source.joints, target.joints)
    # A character that is no humanoid has no hips to turn as such: all of it is as the pairs say.
    known = wanted if wanted.convention != _NO_HUMANOID else Anatomy(_NO_HUMANOID, {})
    sections = find_sections(source, found, target, known, pairs=pairs_said, named=named, left_out=left_out)
    return JointMap(stance=stance, anatomies=(found, wanted), sections=tuple(sections))


def _resolve_pairs(pairs: Sequence[Pair], source: Skeleton, target: Skeleton) -> dict[int, int | None]:
    """Give the take's joint by the character's, None for those to be left at rest."""
    said: dict[int, int | None] = {}
    for pair in pairs:
        joint = _find_joint(pair.joint, target)
        if joint in said:
            names = ", ".join(repr(other.joint) for other in pairs if _find_joint(other.joint, target) == joint)
            raise InputError("a joint is paired twice", expected="each of the character's joints once", found=names)
        said[joint] = _find_joint(pair.source, source) if pair.source else None
    return said


def _recognise(skeleton: Skeleton, whose: str, *, said: Collection[int]) -> Anatomy:
    """Find the parts; a skeleton that is no humanoid begins at the topmost joint the user names."""
    anatomy = find_anatomy(skeleton)
    if anatomy is not None:
        return anatomy
    if not said:
        raise InputError(
            f"the {whose}'s skeleton cannot be retargeted",
            expected="a humanoid (hips, two legs with thigh and shin), or pairs of joints from MtexRetargetAPI",
            found=", ".join(joint.rpartition("/")[2] for joint in skeleton.joints),
        )
    return Anatomy(_NO_HUMANOID, {"hips": min(said, key=lambda joint: len(skeleton.chain(joint)))})


def _find_joint(name: str, skeleton: Skeleton) -> int:
    if name in skeleton.joints:
        return skeleton.joints.index(name)
    names = [joint.rpartition("/")[2] for joint in skeleton.joints]
    if names.count(name) == 1:
        return names.index(name)
    several = name in names
    raise InputError(
        f"{name!r} {'names several joints' if several else 'names no joint'} to retarget",
        expected="the full joint path" if several else f"one of the joints {', '.join(names)}",
        found=", ".join(joint for joint in skeleton.joints if joint.endswith(f"/{name}")) if several else name,
    )


def _apply_pairs(found: Anatomy, wanted: Anatomy, pairs: Mapping[int, int]) -> Anatomy:
    """Give the take's parts as the user has them."""
    said = {part: pairs[joint] for part, joint in wanted.parts.items() if joint in pairs}
    return Anatomy(found.convention, {**found.parts, **said})
