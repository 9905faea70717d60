"""Animations to be edited: found on a stage, read for the work, and what their edited variants will say."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from pxr import Sdf, Usd

from mtex_usd.constraints.planting import Hold, JointRange
from mtex_usd.edit.stack.edit import Edit
from mtex_usd.errors import StageError
from mtex_usd.usd.characters import Character, find_characters
from mtex_usd.usd.clip_io import ClipReader
from mtex_usd.usd.contacts import declared_frequency, read_holds
from mtex_usd.usd.edit_stacks import EditReader
from mtex_usd.usd.limits import read_limits
from mtex_usd.usd.played import Played, read_played
from mtex_usd.usd.recipe_targets import is_own_output
from mtex_usd.usd.schema import CONTACT_API, EDIT_STACK_API, api_instances, read_stacks
from mtex_usd.usd.skeletons import find_bindings

__all__ = [
    "ContactJob",
    "StackJob",
    "find_contacted",
    "find_edited",
    "find_played",
    "read_contact_jobs",
    "read_stack_jobs",
]


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactJob:
    """One animation on one character, whose contacts are to be held.

    Parameters
    ----------
    character
        Who plays it.
    played
        The animation.
    holds
        Contacts declared on it.
    frequency
        The highest frequency of what is changed to hold contacts, Hz.
    limits
        How far the character's joints may turn for it.
    """

    character: Character
    played: Played
    holds: tuple[Hold, ...]
    frequency: float
    limits: tuple[JointRange, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class StackJob:
    """One animation on one character, with the stacks of edits that are declared on it.

    Parameters
    ----------
    character
        Who plays it.
    played
        The animation.
    stacks
        Edits in order, by the name of the variant they make.
    """

    character: Character
    played: Played
    stacks: Mapping[str, tuple[Edit, ...]]


def find_contacted(stage: Usd.Stage, *, only: Sequence[str] = ()) -> tuple[Sdf.Path, ...]:
    """Find the animations that declare contacts.

    Parameters
    ----------
    stage
        The shot.
    only
        Prim paths of the animations wanted, which need declare none; empty for all.

    Raises
    ------
    StageError
        Where there is none, or a path of `only` is no SkelAnimation.
    """
    fix = "Declare contacts, or name an animation with --anim and detect its contacts."
    return _find(stage, only, lambda prim: bool(api_instances(prim, CONTACT_API)), f"{CONTACT_API}:<name>", fix)


def find_played(stage: Usd.Stage, *, only: Sequence[str] = ()) -> tuple[Sdf.Path, ...]:
    """Find the animations that Skeletons play; as :func:`find_contacted`."""
    played = find_bindings(stage)
    return _find(stage, only, lambda prim: prim.GetPath() in played, "a Skeleton that plays it", "")


def find_edited(stage: Usd.Stage, *, only: Sequence[str] = ()) -> tuple[tuple[Sdf.Path, ...], tuple[str, ...]]:
    """Find the animations with stacks of edits that make variants; as :func:`find_contacted`.

    Returns
    -------
    tuple of Sdf.Path, tuple of str
        The animations, and why others are left out: those of `only` are all wanted, of all those that have stacks
        somebody has to play one. Takes of a library may well have stacks that come along with a reference.

    Raises
    ------
    InputError
        For a stack that is not right.
    StageError
        Where there is none, and where one of `only` has none.
    """
    fix = f"Apply {EDIT_STACK_API} and list edits in mtex:edits."
    found = _find(stage, only, lambda prim: bool(read_stacks(prim).variants), EDIT_STACK_API, fix)
    for path in found:
        if not read_stacks(stage.GetPrimAtPath(path)).variants:
            raise StageError(f"{path} has no stack of edits", expected=EDIT_STACK_API, fix=fix)
    return (found, ()) if only else _leave_out_unplayed(stage, found)


def _leave_out_unplayed(
    stage: Usd.Stage, animations: Sequence[Sdf.Path]
) -> tuple[tuple[Sdf.Path, ...], tuple[str, ...]]:
    refused = dict[Sdf.Path, StageError]()
    for path in animations:
        try:
            find_characters(stage, [path])
        except StageError as error:
            refused[path] = error
    if len(refused) == len(animations):
        raise next(iter(refused.values()))
    played = tuple(path for path in animations if path not in refused)
    return played, tuple(f"{path} is left out: {error.message}" for path, error in refused.items())


def _find(
    stage: Usd.Stage, only: Sequence[str], is_wanted: Callable[[Usd.Prim], bool], expected: str, fix: str
) -> tuple[Sdf.Path, ...]:
    for path in only:
        prim = stage.GetPrimAtPath(path) if Sdf.Path.IsValidPathString(path) else None
        if not prim or not prim.IsA("SkelAnimation"):
            raise StageError(f"there is no animation {path}", expected="the path of a SkelAnimation")
    if only:
        return tuple(dict.fromkeys(map(Sdf.Path, only)))
    prims = stage.Traverse(Usd.TraverseInstanceProxies())
    animations = [prim for prim in prims if prim.IsA("SkelAnimation") and not is_own_output(prim)]
    wanted = tuple(prim.GetPath() for prim in animations if is_wanted(prim))
    if not wanted:
        found = ", ".join(str(prim.GetPath()) for prim in animations) or "no animations"
        raise StageError("no animation to edit", expected=f"an animation with {expected}", found=found, fix=fix)
    return wanted


def read_contact_jobs(
    stage: Usd.Stage, animations: Sequence[Sdf.Path], contacts: str, *, previous: Path
) -> tuple[ContactJob, ...]:
    """Read animations on the characters that play them, with their contacts.

    Parameters
    ----------
    stage
        The shot.
    animations
        Paths of SkelAnimations.
    contacts
        ``declared`` or ``detect``.
    previous
        Where the override layer of an earlier run would be.

    Raises
    ------
    InputError, StageError
        Whatever is wrong with an animation, its Skeleton or its contacts, naming the prim.
    """
    reader = ClipReader(stage)
    jobs = []
    for character in find_characters(stage, list(animations), previous=previous):
        played = read_played(stage, reader, character)
        jobs.append(
            ContactJob(
                character=character,
                played=played,
                holds=read_holds(played.prim, played.skeleton_prim, played.clip, contacts),
                frequency=declared_frequency(played.prim),
                limits=read_limits(played.skeleton_prim, played.clip.skeleton),
            )
        )
    return tuple(jobs)


def read_stack_jobs(stage: Usd.Stage, animations: Sequence[Sdf.Path], *, previous: Path) -> tuple[StackJob, ...]:
    """Read animations on the characters that play them, with their stacks of edits.

    Parameters
    ----------
    stage
        The shot.
    animations
        Paths of SkelAnimations.
    previous
        Where the override layer of an earlier run would be.

    Raises
    ------
    InputError, StageError
        Whatever is wrong with an animation, its Skeleton or its edits, naming the prim.
    """
    clips = ClipReader(stage)
    edits = EditReader(stage, clips)
    jobs = []
    for character in find_characters(stage, list(animations), previous=previous):
        played = read_played(stage, clips, character)
        stacks = {
            variant: edits.read(played.prim, names, like=played.clip)
            for variant, names in read_stacks(played.prim).variants.items()
        }
        jobs.append(StackJob(character=character, played=played, stacks=stacks))
    return tuple(jobs)
