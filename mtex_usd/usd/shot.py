"""From a shot to plain clips: what the method reads of a stage."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pxr import Sdf, Usd

from mtex_usd import edit
from mtex_usd.constraints.planting import Hold, JointRange
from mtex_usd.constraints.retargeting import FittedTake
from mtex_usd.edit.stack.edit import ContactFinder, Edit
from mtex_usd.edit.stack.others import put_on_joints
from mtex_usd.errors import StageError
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.correspondence import keep_joints
from mtex_usd.motion.timing import resample_clip
from mtex_usd.texture.recipe import Recipe
from mtex_usd.usd.animation import AnimationSamples
from mtex_usd.usd.characters import Character, find_characters
from mtex_usd.usd.clip_io import ClipReader
from mtex_usd.usd.contacts import declared_frequency, read_holds
from mtex_usd.usd.edit_stacks import EditReader, make_contact_finder
from mtex_usd.usd.fit_takes import fit_takes
from mtex_usd.usd.limits import read_limits
from mtex_usd.usd.played import read_played
from mtex_usd.usd.recipe_targets import find_sketches, find_takes
from mtex_usd.usd.schema import read_recipe, read_stacks
from mtex_usd.usd.skeletons import find_bindings

__all__ = ["Cast", "Job", "find_cast", "read_jobs"]


@dataclass(frozen=True)
class Cast:
    """Who is to be worked on, whose results of an earlier run stay as they are, and which sketches nobody can play."""

    wanted: tuple[Character, ...]
    others: tuple[Character, ...]
    left_out: tuple[str, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class Job:
    """One sketch on one character, read and ready for the method.

    Parameters
    ----------
    character
        Who plays the sketch.
    samples
        The sketch as USD gives it, bit for bit, missing attributes filled from rest.
    sketch
        The sketch on all joints of the character.
    takes
        The takes at the sketch's rate, on the character's joints where their own are others.
    recipe
        What the sketch carries.
    after
        Edits to be made of what comes out, in order.
    find_contacts
        Tells where contacts begin and end, for the edits.
    holds
        Contacts declared on the sketch; none where the recipe is to hold none.
    frequency
        The highest frequency of what is changed to hold contacts, Hz.
    limits
        How far the character's joints may turn for it.
    """

    character: Character
    samples: AnimationSamples
    sketch: Clip
    takes: tuple[FittedTake, ...]
    recipe: Recipe
    after: tuple[Edit, ...]
    find_contacts: ContactFinder
    holds: tuple[Hold, ...]
    frequency: float
    limits: tuple[JointRange, ...]


def find_cast(stage: Usd.Stage, *, only: Sequence[str], previous: Path) -> Cast:
    """Find the characters of the sketches wanted, and those of the others.

    Parameters
    ----------
    stage
        The shot.
    only
        Prim paths of the sketches wanted; empty for all.
    previous
        Where the override layer of an earlier run would be.

    Raises
    ------
    StageError
        Where no Skeleton can play a sketch of `only`, or any of several.
    """
    wanted = [prim.GetPath() for prim in find_sketches(stage, only=only)]
    others = [prim.GetPath() for prim in find_sketches(stage) if prim.GetPath() not in wanted] if only else []
    playable, refused = _find_playable(stage, [] if only else wanted, wanted if only else [], others)
    characters = find_characters(stage, playable, previous=previous)
    return Cast(
        tuple(character for character in characters if character.animation in wanted),
        tuple(character for character in characters if character.animation not in wanted),
        tuple(str(error) for path, error in refused.items() if path in wanted),
    )


def _find_playable(
    stage: Usd.Stage, wanted: Sequence[Sdf.Path], required: Sequence[Sdf.Path], others: Sequence[Sdf.Path]
) -> tuple[list[Sdf.Path], dict[Sdf.Path, StageError]]:
    """Sort sketches into those that can be played side by side, in stage order, and those that cannot, with why.

    What is required comes first; what a Skeleton plays comes before what would have to take a Skeleton over.
    """
    bound = find_bindings(stage)
    accepted, refused = list(required), dict[Sdf.Path, StageError]()
    if required:
        find_characters(stage, accepted)
    for sketch in sorted((*wanted, *others), key=lambda path: path not in bound):
        try:
            find_characters(stage, [*accepted, sketch])
            accepted.append(sketch)
        except StageError as error:
            refused[sketch] = error
    if not accepted:
        raise next(iter(refused.values()))
    order = [prim.GetPath() for prim in find_sketches(stage)]
    return sorted(accepted, key=order.index), refused


def read_jobs(stage: Usd.Stage, characters: Sequence[Character]) -> Iterator[Job]:
    """Read sketches, takes and recipes of characters, one by one; a take is read once for all.

    Raises
    ------
    InputError, StageError
        Whatever is wrong with a recipe, a sketch, a take or a skeleton, naming its prim.
    """
    clips = ClipReader(stage)
    edits = EditReader(stage, clips)
    takes: dict[tuple[Sdf.Path, float], Clip] = {}
    for character in characters:
        played = read_played(stage, clips, character)
        prim, sketch = played.prim, played.clip
        take_prims = find_takes(stage, prim)
        for take in take_prims:
            if (take.GetPath(), sketch.rate) not in takes:
                takes[take.GetPath(), sketch.rate] = resample_clip(edits.read_take(take), sketch.rate)
        recorded = [takes[take.GetPath(), sketch.rate] for take in take_prims]
        recipe = read_recipe(prim)
        stacks = read_stacks(prim)
        fitted = fit_takes(prim, sketch, take_prims, recorded)
        yield Job(
            character=character,
            samples=played.samples,
            sketch=sketch,
            takes=_edit_takes(fitted, edits.read(prim, stacks.before, like=sketch)),
            recipe=recipe,
            after=edits.read(prim, stacks.after, like=sketch),
            find_contacts=make_contact_finder(prim),
            holds=read_holds(prim, played.skeleton_prim, sketch, recipe.contacts),
            frequency=declared_frequency(prim),
            limits=() if recipe.contacts == "off" else read_limits(played.skeleton_prim, sketch.skeleton),
        )


def _edit_takes(takes: tuple[FittedTake, ...], edits: Sequence[Edit]) -> tuple[FittedTake, ...]:
    """Make a sketch's edits of its takes, which are on its joints by now."""
    if not edits:
        return takes
    return tuple(replace(take, clip=_run_on(take.clip, edits)) for take in takes)


def _run_on(take: Clip, edits: Sequence[Edit]) -> Clip:
    """Run edits on a take that may lack joints of the sketch, which those of the other motions are."""
    fitted = [replace(each, others=tuple(_bring_onto(take, other) for other in each.others)) for each in edits]
    return edit.run_stack(take, fitted).clip


def _bring_onto(take: Clip, other: Clip) -> Clip:
    if set(take.joints) < set(other.joints):
        other = keep_joints(other, [other.joints.index(joint) for joint in take.joints])
    return put_on_joints(other, take)
