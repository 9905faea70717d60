"""Animations to be edited: found on a stage, read for the work, and what their edited variant will say."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd

from mtex_usd.constraints.planting import Hold, JointRange
from mtex_usd.errors import StageError
from mtex_usd.motion.clip import Clip
from mtex_usd.usd.animation import AnimationSamples, sample_sketch
from mtex_usd.usd.characters import Character, find_characters
from mtex_usd.usd.clip_io import ClipReader
from mtex_usd.usd.contacts import declared_frequency, read_holds
from mtex_usd.usd.limits import read_limits
from mtex_usd.usd.override import CharacterResult, VariantSamples
from mtex_usd.usd.recipe_targets import is_own_output
from mtex_usd.usd.sampled_clip import add_joints, fill_missing, to_clip
from mtex_usd.usd.schema import CONTACT_API, api_instances
from mtex_usd.usd.skeletons import find_bindings

__all__ = ["EditJob", "build_edit", "find_contacted", "read_edit_jobs"]


@dataclass(frozen=True, eq=False, kw_only=True)
class EditJob:
    """One animation on one character, read for editing.

    Parameters
    ----------
    character
        Who plays it.
    samples
        The animation as USD gives it, bit for bit, missing attributes filled from rest.
    clip
        The animation on all joints of the character.
    holds
        Contacts declared on it.
    frequency
        The highest frequency of what is changed to hold contacts, Hz.
    limits
        How far the character's joints may turn for it.
    """

    character: Character
    samples: AnimationSamples
    clip: Clip
    holds: tuple[Hold, ...]
    frequency: float
    limits: tuple[JointRange, ...]


def find_contacted(stage: Usd.Stage, *, only: Sequence[str] = (), all_played: bool = False) -> tuple[Sdf.Path, ...]:
    """Find the animations that are to be constrained.

    Parameters
    ----------
    stage
        The shot.
    only
        Prim paths of the animations wanted; empty for all.
    all_played
        Whether all means every animation that a Skeleton plays, and not those with contacts declared.

    Raises
    ------
    StageError
        Where there is none, or a path of `only` is no SkelAnimation.
    """
    for path in only:
        prim = stage.GetPrimAtPath(path)
        if not prim or not prim.IsA("SkelAnimation"):
            raise StageError(f"there is no animation {path}", expected="the path of a SkelAnimation")
    if only:
        return tuple(map(Sdf.Path, only))
    played = find_bindings(stage)
    animations = [
        prim.GetPath()
        for prim in stage.Traverse(Usd.TraverseInstanceProxies())
        if prim.IsA("SkelAnimation") and not is_own_output(prim)
    ]
    wanted = [
        path for path in animations if (path in played if all_played else _has_contacts(stage.GetPrimAtPath(path)))
    ]
    if not wanted:
        raise StageError(
            "no animation to constrain",
            expected="an animation that a Skeleton plays" if all_played else f"{CONTACT_API}:<name> on an animation",
            found=", ".join(map(str, animations)) or "no animations",
            fix="" if all_played else "Declare contacts, or name an animation with --anim and detect its contacts.",
        )
    return tuple(wanted)


def _has_contacts(prim: Usd.Prim) -> bool:
    return bool(api_instances(prim, CONTACT_API))


def read_edit_jobs(
    stage: Usd.Stage, animations: Sequence[Sdf.Path], contacts: str, *, previous: Path
) -> tuple[EditJob, ...]:
    """Read animations on the characters that play them.

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
        prim, skeleton_prim = (stage.GetPrimAtPath(path) for path in (character.animation, character.skeletons[0]))
        skeleton = reader.read_skeleton(skeleton_prim)
        samples = fill_missing(sample_sketch(stage, prim), skeleton)
        if len(samples.time_codes) < 2:
            raise StageError(f"{prim.GetPath()} is a single pose", expected="an animation of at least two frames")
        clip = to_clip(samples, skeleton)
        holds = read_holds(prim, skeleton_prim, clip, contacts)
        jobs.append(
            EditJob(
                character=character,
                samples=samples,
                clip=clip,
                holds=holds,
                frequency=declared_frequency(prim),
                limits=read_limits(skeleton_prim, skeleton),
            )
        )
    return tuple(jobs)


def build_edit(job: EditJob, clip: Clip, name: str, custom_data: Mapping[str, object]) -> CharacterResult:
    """Give what the edited variant will say: the animation's own arrays, bit for bit where nothing changed.

    Parameters
    ----------
    job
        What was read.
    clip
        What was made of its clip, with the same frames.
    name
        Of the variant.
    custom_data
        Its ``customData["mtex"]``.
    """
    samples = job.samples
    changed = [
        j
        for j in range(len(clip.joints))
        if (clip.rotations[:, j] != job.clip.rotations[:, j]).any()
        or (clip.translations[:, j] != job.clip.translations[:, j]).any()
    ]
    added = tuple(clip.joints[j] for j in changed if clip.joints[j] not in samples.joints)
    samples = add_joints(samples, added, clip.skeleton)
    rotations, translations = np.array(samples.rotations), np.array(samples.translations)
    for j in changed:
        column = samples.joints.index(clip.joints[j])
        rotations[:, column], translations[:, column] = clip.rotations[:, j], clip.translations[:, j]
    variant = VariantSamples(
        joints=samples.joints,
        time_codes=samples.time_codes,
        rotations=rotations,
        translations=translations,
        scales=samples.scales,
        custom_data=custom_data,
    )
    return CharacterResult(character=job.character, names=(name,), variants=(variant,))
