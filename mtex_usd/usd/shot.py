"""From a shot to plain clips and back: what the method reads of a stage, and what a character's variants will say."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd

from mtex_usd.constraints.retargeting import FittedTake
from mtex_usd.errors import StageError
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.motion.timing import resample_clip
from mtex_usd.texture.recipe import Recipe
from mtex_usd.texture.result import TexturedMotion, Variant
from mtex_usd.usd.animation import AnimationSamples, fill_missing, sample_sketch, to_clip
from mtex_usd.usd.characters import Character, find_characters
from mtex_usd.usd.clip_io import ClipReader
from mtex_usd.usd.fit_takes import fit_takes
from mtex_usd.usd.override import CharacterResult, VariantSamples, variant_names
from mtex_usd.usd.recipe_targets import find_sketches, find_takes
from mtex_usd.usd.schema import read_recipe
from mtex_usd.usd.skeletons import find_bindings

__all__ = ["Cast", "Job", "build_result", "describe_variant", "find_cast", "read_jobs"]


@dataclass(frozen=True)
class Cast:
    """Who is to be worked on, whose results of an earlier run stay as they are, and which sketches nobody can play."""

    wanted: tuple[Character, ...]
    others: tuple[Character, ...]
    left_out: tuple[str, ...]


@dataclass(frozen=True, eq=False)
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
    """

    character: Character
    samples: AnimationSamples
    sketch: Clip
    takes: tuple[FittedTake, ...]
    recipe: Recipe


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
    reader = ClipReader(stage)
    takes: dict[tuple[Sdf.Path, float], Clip] = {}
    for character in characters:
        prim = stage.GetPrimAtPath(character.animation)
        skeleton = reader.read_skeleton(stage.GetPrimAtPath(character.skeletons[0]))
        samples = fill_missing(sample_sketch(stage, prim), skeleton)
        if len(samples.time_codes) < 2:
            raise StageError(f"{prim.GetPath()} is a single pose", expected="a sketch of at least two frames")
        take_prims = find_takes(stage, prim)
        for take in take_prims:
            if (take.GetPath(), samples.rate) not in takes:
                takes[take.GetPath(), samples.rate] = resample_clip(reader.read_take(take), samples.rate)
        recorded = [takes[take.GetPath(), samples.rate] for take in take_prims]
        sketch = to_clip(samples, skeleton)
        recipe = read_recipe(prim)
        yield Job(character, samples, sketch, fit_takes(prim, sketch, take_prims, recorded), recipe)


def build_result(job: Job, motion: TexturedMotion) -> CharacterResult:
    """Give what each variant will say: the sketch's own arrays, bit for bit where nothing was copied."""
    added = _added_joints(job, motion)
    variants = tuple(_build_samples(job, motion, variant, added) for variant in motion.variants)
    return CharacterResult(character=job.character, names=variant_names(len(variants)), variants=variants)


def _touched(motion: TexturedMotion, kind: str) -> dict[str, None]:
    """Joint paths with a copied channel of a kind, ``r`` or ``t``."""
    return dict.fromkeys(name.rpartition(".")[0] for name in motion.channels if name.rpartition(".")[2][0] == kind)


def _added_joints(job: Job, motion: TexturedMotion) -> tuple[str, ...]:
    """Joints that are filled in and that the sketch does not have, in the skeleton's order."""
    copied = {**_touched(motion, "r"), **_touched(motion, "t")}
    return tuple(joint for joint in job.sketch.joints if joint in copied and joint not in job.samples.joints)


def _build_samples(job: Job, motion: TexturedMotion, variant: Variant, added: tuple[str, ...]) -> VariantSamples:
    samples = _with_joints(job.samples, added, job.sketch.skeleton)
    rotations, translations = np.array(samples.rotations), np.array(samples.translations)
    for target, source, kind in (
        (rotations, variant.clip.rotations, "r"),
        (translations, variant.clip.translations, "t"),
    ):
        for joint in _touched(motion, kind):
            target[:, samples.joints.index(joint)] = source[:, job.sketch.joints.index(joint)]
    return VariantSamples(
        joints=samples.joints,
        time_codes=samples.time_codes,
        rotations=rotations,
        translations=translations,
        scales=samples.scales,
        custom_data=describe_variant(variant, motion),
    )


def _with_joints(samples: AnimationSamples, added: tuple[str, ...], skeleton: Skeleton) -> AnimationSamples:
    """Append joints at rest."""
    if not added:
        return samples
    alone = replace(samples, joints=added, missing=("rotations", "translations", "scales"))
    rest = fill_missing(alone, skeleton)
    arrays = {
        name: np.concatenate([getattr(samples, name), getattr(rest, name)], axis=1)
        for name in ("rotations", "translations", "scales")
    }
    return replace(samples, joints=samples.joints + added, **arrays)  # type: ignore[arg-type]


def describe_variant(variant: Variant, motion: TexturedMotion) -> dict[str, object]:
    """Give a variant's ``customData["mtex"]``."""
    return {
        "rank": variant.rank,
        "distance": variant.distance,
        "zeroCostJoins": variant.zero_cost_joins,
        "rotationOrders": dict(motion.rotation_orders),
        "fragments": [
            {
                "start": use.start,
                "end": use.end,
                "take": use.take,
                "takeStart": use.take_start,
                "takeEnd": use.take_end,
                "distance": use.distance,
                "scale": use.scale,
            }
            for use in variant.fragments
        ],
    }
