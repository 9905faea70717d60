"""One sketch from its recipe to finished motion: contacts planned, textured and synthesized, edited, contacts held."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np

from mtex_usd import edit
from mtex_usd.constraints.contacts import detect_contacts, find_effectors
from mtex_usd.constraints.planting import (
    Hold,
    find_limb,
    held_back,
    hold_motion,
    merge_holds,
    plan_contacts,
    restore_feet,
)
from mtex_usd.errors import InputError
from mtex_usd.motion.channels import Channel, resolve_channels
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.engine import texture_motion
from mtex_usd.texture.reading import choose_root
from mtex_usd.texture.recipe import Recipe
from mtex_usd.texture.result import TexturedMotion, Variant
from mtex_usd.texture.space import goes_along_ground
from mtex_usd.usd.finished import Finished
from mtex_usd.usd.shot import Job
from mtex_usd.usd.variant_samples import Keys

__all__ = ["finish_job"]


def finish_job(job: Job, recipe: Recipe, *, texturing: Callable[..., TexturedMotion] = texture_motion) -> Finished:
    """Texture and synthesize one sketch, and hold its contacts where the recipe says so.

    Parameters
    ----------
    job
        As :func:`mtex_usd.usd.shot.read_jobs` gives it.
    recipe
        The job's, or one with options in place of properties.
    texturing
        Takes the arguments of :func:`mtex_usd.texture.engine.texture_motion` and does its work.

    Raises
    ------
    InputError
        As what does the texturing.
    NoSolutionError
        Where contacts cannot be held together; names them.
    """
    holds = _plan(job, recipe)
    ramp_frames = round(recipe.join_time * job.sketch.rate)
    held = held_back(holds, job.sketch.skeleton, frame_count=job.sketch.frame_count, ramp_frames=ramp_frames)
    textured = texturing(job.sketch, [take.clip for take in job.takes], recipe, held=held)
    motion, keys = _edit(job, recipe, textured)
    if recipe.contacts == "off":
        none = ((),) * len(motion.variants)
        return Finished(job=job, recipe=recipe, motion=motion, holds=none, keys=keys, held_joints=())
    changed: set[int] = set()
    variants, kept = [], []
    for variant in motion.variants:
        clip, everything = _hold_variant(variant, job, recipe, holds)
        changed |= _changed_joints(variant.clip, clip)
        variants.append(replace(variant, clip=clip))
        kept.append(everything)
    return Finished(
        job=job,
        recipe=recipe,
        keys=keys,
        motion=replace(motion, variants=tuple(variants)),
        holds=tuple(kept),
        held_joints=tuple(sorted(changed)),
    )


def _edit(job: Job, recipe: Recipe, motion: TexturedMotion) -> tuple[TexturedMotion, tuple[Keys | None, ...]]:
    """Make the edits of every variant that come after texturing; contacts are held after them."""
    if not job.after:
        return motion, (None,) * len(motion.variants)
    done = [edit.run_stack(each.clip, job.after, find_contacts=job.find_contacts) for each in motion.variants]
    if recipe.contacts != "off":
        for outcome in done:
            _check_holdable(job, outcome)
    variants = tuple(replace(each, clip=edited.clip) for each, edited in zip(motion.variants, done, strict=True))
    notes = dict.fromkeys(note for outcome in done for note in outcome.notes)
    return replace(motion, variants=variants, notes=(*motion.notes, *notes)), tuple(each.keys for each in done)


def _check_holdable(job: Job, outcome: edit.Outcome) -> None:
    """Refuse edits after which the sketch's contacts are no longer where and when the sketch has them."""
    if outcome.keys is not None or not np.array_equal(outcome.clip.time_codes, job.sketch.time_codes):
        raise InputError(
            f"{job.sketch.name}: contacts cannot be held after mtex:edits:after",
            expected="edits that keep the frames of the sketch and reduce no keys",
            found=", ".join(f"{each.name} ({each.op})" for each in job.after),
            fix="Set mtex:contacts to off, or take those edits out.",
        )


def _plan(job: Job, recipe: Recipe) -> tuple[Hold, ...]:
    """What is to be held of the sketch's own motion: what is declared, and the feet it sets down."""
    if recipe.contacts == "off":
        return ()
    found = _detect(job.sketch, spare=_synthesized_limbs(job.sketch, recipe)) if recipe.contacts == "detect" else ()
    return merge_holds(job.holds, found)


def _detect(clip: Clip, *, spare: Collection[int]) -> tuple[Hold, ...]:
    """Contacts of the feet, but for those of some joints."""
    effectors = [effector for effector in find_effectors(clip.skeleton, clip=clip) if effector.joint not in spare]
    return plan_contacts(detect_contacts(clip, effectors=effectors), clip) if effectors else ()


def _synthesized_limbs(sketch: Clip, recipe: Recipe) -> set[int]:
    """Joints of limbs that are filled in: where those set their feet down, only the result can tell."""
    filled = _synthesized_channels(sketch, recipe)
    return {joint for channel in filled for joint in find_limb(sketch.skeleton, channel.joint)}


def _synthesized_channels(sketch: Clip, recipe: Recipe) -> tuple[Channel, ...]:
    """Every channel that is filled in at some time."""
    lists = (recipe.synthesize, *(segment.synthesize or () for segment in recipe.segments))
    tokens = {token for tokens in lists for token in tokens}
    return resolve_channels(sorted(tokens), sketch.joints, source="mtex:synthesize")


def _find_carrier(job: Job, recipe: Recipe) -> int | None:
    """Give the root if its way along the ground is filled in at some time."""
    root = choose_root(job.sketch, [take.clip for take in job.takes])
    filled = _synthesized_channels(job.sketch, recipe)
    up = job.sketch.skeleton.up
    return root if any(goes_along_ground(channel, root, up) for channel in filled) else None


def _hold_variant(variant: Variant, job: Job, recipe: Recipe, holds: Sequence[Hold]) -> tuple[Clip, tuple[Hold, ...]]:
    """Hold one variant's contacts; those of limbs that were filled in are found on the variant itself."""
    filled = _synthesized_limbs(job.sketch, recipe)
    restored = restore_feet(variant.clip, job.sketch, holds, kept=filled, carrier=_find_carrier(job, recipe))
    own = _detect(restored, spare=set(range(len(job.sketch.joints))) - filled) if recipe.contacts == "detect" else ()
    everything = (*holds, *own)
    return hold_motion(restored, everything, frequency=job.frequency, limits=job.limits).clip, everything


def _changed_joints(before: Clip, after: Clip) -> set[int]:
    rotations = (before.rotations != after.rotations).any(axis=(0, 2))
    translations = (before.translations != after.translations).any(axis=(0, 2))
    return {int(joint) for joint in np.flatnonzero(rotations | translations)}
