"""One sketch from its recipe to finished motion: contacts planned, textured and synthesized, contacts held."""

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from mtex_usd.constraints.contacts import detect_contacts, find_effectors
from mtex_usd.constraints.planting import Hold, find_limb, held_back, hold_motion, plan_contacts, restore_feet
from mtex_usd.motion.channels import resolve_channels
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.engine import texture_motion
from mtex_usd.texture.recipe import Recipe
from mtex_usd.texture.result import Variant
from mtex_usd.usd.finished import Finished
from mtex_usd.usd.shot import Job

__all__ = ["finish_job"]


def finish_job(job: Job, recipe: Recipe) -> Finished:
    """Texture and synthesize one sketch, and hold its contacts where the recipe says so.

    Parameters
    ----------
    job
        As :func:`mtex_usd.usd.shot.read_jobs` gives it.
    recipe
        The job's, or one with options in place of properties.

    Raises
    ------
    InputError
        As :func:`mtex_usd.texture.engine.texture_motion`.
    NoSolutionError
        Where contacts cannot be held together; names them.
    """
    holds = _plan(job, recipe)
    ramp_frames = round(recipe.join_time * job.sketch.rate)
    held = held_back(holds, job.sketch.skeleton, frame_count=job.sketch.frame_count, ramp_frames=ramp_frames)
    motion = texture_motion(job.sketch, [take.clip for take in job.takes], recipe, held=held)
    if recipe.contacts == "off":
        return Finished(job=job, motion=motion, holds=((),) * len(motion.variants), held_joints=())
    changed: set[int] = set()
    variants, kept = [], []
    for variant in motion.variants:
        clip, everything = _hold_variant(variant, job, recipe, holds)
        changed |= _changed_joints(variant.clip, clip)
        variants.append(replace(variant, clip=clip))
        kept.append(everything)
    return Finished(
        job=job,
        motion=replace(motion, variants=tuple(variants)),
        holds=tuple(kept),
        held_joints=tuple(sorted(changed)),
    )


def _plan(job: Job, recipe: Recipe) -> tuple[Hold, ...]:
    """What is to be held of the sketch's own motion: what is declared, and the feet it sets down."""
    if recipe.contacts == "off":
        return ()
    found = _detect(job.sketch, spare=_synthesized_limbs(job.sketch, recipe)) if recipe.contacts == "detect" else ()
    said = {hold.joint for hold in job.holds}
    return (*job.holds, *(hold for hold in found if hold.joint not in said))


def _detect(clip: Clip, *, spare: Collection[int]) -> tuple[Hold, ...]:
    """Contacts of the feet, but for those of some joints."""
    effectors = [effector for effector in find_effectors(clip.skeleton, clip=clip) if effector.joint not in spare]
    return plan_contacts(detect_contacts(clip, effectors=effectors), clip) if effectors else ()


def _synthesized_limbs(sketch: Clip, recipe: Recipe) -> set[int]:
    """Joints of limbs that are filled in: where those set their feet down, only the result can tell."""
    lists = (recipe.synthesize, *(segment.synthesize or () for segment in recipe.segments))
    tokens = {token for tokens in lists for token in tokens}
    channels = resolve_channels(sorted(tokens), sketch.joints, source="mtex:synthesize")
    return {joint for channel in channels for joint in find_limb(sketch.skeleton, channel.joint)}


def _hold_variant(variant: Variant, job: Job, recipe: Recipe, holds: Sequence[Hold]) -> tuple[Clip, tuple[Hold, ...]]:
    """Hold one variant's contacts; those of limbs that were filled in are found on the variant itself."""
    filled = _synthesized_limbs(job.sketch, recipe)
    restored = restore_feet(variant.clip, job.sketch, holds, kept=filled)
    own = _detect(restored, spare=set(range(len(job.sketch.joints))) - filled) if recipe.contacts == "detect" else ()
    everything = (*holds, *own)
    return hold_motion(restored, everything, frequency=job.frequency, limits=job.limits).clip, everything


def _changed_joints(before: Clip, after: Clip) -> set[int]:
    rotations = (before.rotations != after.rotations).any(axis=(0, 2))
    translations = (before.translations != after.translations).any(axis=(0, 2))
    return {int(joint) for joint in np.flatnonzero(rotations | translations)}
