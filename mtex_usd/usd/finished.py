"""A sketch that was worked on, and what its variants will say in the override layer."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mtex_usd.constraints.planting import Hold, describe_holds
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.recipe import Recipe
from mtex_usd.texture.result import TexturedMotion, Variant
from mtex_usd.usd.animation import AnimationSamples
from mtex_usd.usd.override import CharacterResult, VariantSamples, variant_names
from mtex_usd.usd.sampled_clip import add_joints
from mtex_usd.usd.shot import Job
from mtex_usd.usd.variant_samples import Keys, build_variant

__all__ = ["Finished", "build_result", "describe_variants"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Finished:
    """A sketch that was worked on.

    Parameters
    ----------
    job
        What was read.
    recipe
        What was done: the job's, or one with options in place of properties.
    motion
        What was made; its clips are edited and keep the contacts.
    holds
        What is held, per variant.
    keys
        The variants by few keys, where the last edit reduced them.
    held_joints
        Indices of joints that were changed to hold it, beside the recipe's channels.
    """

    job: Job
    recipe: Recipe
    motion: TexturedMotion
    holds: tuple[tuple[Hold, ...], ...]
    keys: tuple[Keys | None, ...]
    held_joints: tuple[int, ...]


def build_result(finished: Finished) -> CharacterResult:
    """Give what each variant will say: the sketch's own arrays, bit for bit where nothing was copied, edited or held.

    Parameters
    ----------
    finished
        What was made.
    """
    job, motion = finished.job, finished.motion
    names = variant_names(len(motion.variants))
    if job.after:
        parts = zip(motion.variants, describe_variants(finished), finished.keys, strict=True)
        edited = tuple(build_variant(job.samples, job.sketch, each.clip, data, keys=keys) for each, data, keys in parts)
        return CharacterResult(character=job.character, names=names, variants=edited)
    held = dict.fromkeys(job.sketch.joints[joint] for joint in finished.held_joints)
    rotations, translations = {**_touched(motion, "r"), **held}, {**_touched(motion, "t"), **held}
    added = tuple(
        joint
        for joint in job.sketch.joints
        if joint in {**rotations, **translations} and joint not in job.samples.joints
    )
    base = add_joints(job.samples, added, job.sketch.skeleton)
    variants = tuple(
        _build_samples(base, variant.clip, rotations, translations, custom_data)
        for variant, custom_data in zip(motion.variants, describe_variants(finished), strict=True)
    )
    return CharacterResult(character=job.character, names=names, variants=variants)


def _touched(motion: TexturedMotion, kind: str) -> dict[str, None]:
    """Joint paths with a copied channel of a kind, ``r`` or ``t``."""
    return dict.fromkeys(name.rpartition(".")[0] for name in motion.channels if name.rpartition(".")[2][0] == kind)


def _build_samples(
    base: AnimationSamples,
    clip: Clip,
    turned: Collection[str],
    moved: Collection[str],
    custom_data: Mapping[str, object],
) -> VariantSamples:
    """Give one variant's samples: those of joints `turned` and `moved` from its clip."""
    rotations, translations = np.array(base.rotations), np.array(base.translations)
    for target, source, touched in ((rotations, clip.rotations, turned), (translations, clip.translations, moved)):
        for joint in touched:
            target[:, base.joints.index(joint)] = source[:, clip.joints.index(joint)]
    return VariantSamples(
        joints=base.joints,
        time_codes=base.time_codes,
        rotations=rotations,
        translations=translations,
        scales=base.scales,
        custom_data=custom_data,
    )


def describe_variants(finished: Finished) -> tuple[dict[str, object], ...]:
    """Give the ``customData["mtex"]`` of every variant; with its contacts where there are any.

    Parameters
    ----------
    finished
        What was made.
    """
    pairs = zip(finished.motion.variants, finished.holds, strict=True)
    return tuple(_describe(variant, finished.motion, holds) for variant, holds in pairs)


def _describe(variant: Variant, motion: TexturedMotion, holds: Sequence[Hold]) -> dict[str, object]:
    contacts = {"contacts": describe_holds(holds, variant.clip)} if holds else {}
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
        **contacts,
    }
