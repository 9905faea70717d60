"""Motions that were not textured made to keep their contacts, and contacts found for an animator to edit."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mtex_usd.constraints.contacts import detect_contacts
from mtex_usd.constraints.planting import Held, Hold, describe_holds, hold_motion, merge_holds, plan_contacts
from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip
from mtex_usd.results import EditResult
from mtex_usd.usd.arguments import FilePath, PrimPath, as_file_path, as_prim_paths
from mtex_usd.usd.atomic import check_target
from mtex_usd.usd.contact_layer import write_contacts
from mtex_usd.usd.edited import ContactJob, find_contacted, find_played, read_contact_jobs
from mtex_usd.usd.outputs import find_output, write_outputs
from mtex_usd.usd.override import CharacterResult
from mtex_usd.usd.source_stage import open_source
from mtex_usd.usd.thin_root import thin_root_path
from mtex_usd.usd.variant_samples import build_variant

__all__ = ["constrain", "find_contacts"]

_VARIANT = "constrained"
_MAKER = "usdmtex-edit constrain"


@dataclass(frozen=True, eq=False, kw_only=True)
class _Done:
    job: ContactJob
    holds: tuple[Hold, ...]
    held: Held


def constrain(
    stage_path: FilePath,
    *,
    out: FilePath | None = None,
    anim: PrimPath | Sequence[PrimPath] = (),
    contacts: str = "declared",
    select: str | None = None,
    dry_run: bool = False,
) -> tuple[EditResult, ...]:
    """Make animations of a shot keep their contacts, in an override layer with ``original`` and ``constrained``.

    Parameters
    ----------
    stage_path
        The shot, or the thin root of an earlier run. It and all it is made of stay as they are.
    out
        The override layer; by default ``<shot>.constrain.usd`` beside the shot.
    anim
        Prim path or paths of the animations; by default all with MtexContactAPI.
    contacts
        ``declared``, what MtexContactAPI says; ``detect``, the feet that are found on the floor as well.
    select
        The variant to select; by default the user's earlier choice, else ``constrained``.
    dry_run
        Do everything but write.

    Returns
    -------
    tuple of EditResult
        One per animation and character.

    Raises
    ------
    InputError
        Options or contacts that are not right.
    StageError
        No such animation, nothing that plays it, or a stronger opinion in the way.
    NoSolutionError
        Where contacts cannot be held together; nothing is written.
    ResultError
        What was written does not read back as computed.
    """
    if contacts not in ("declared", "detect"):
        raise InputError("cannot constrain so", expected='contacts "declared" or "detect"', found=repr(contacts))
    source = open_source(as_file_path(stage_path, "stage"))
    target = find_output(source, out, word="constrain", maker=_MAKER)
    animations = find_contacted(source.stage, only=as_prim_paths(anim, "anim"))
    done = [_hold(job, contacts) for job in read_contact_jobs(source.stage, animations, contacts, previous=target)]
    built = [_build(each) for each in done]
    write_outputs(source.stage, built, target, maker=_MAKER, select=select, dry_run=dry_run)
    return tuple(_describe(each, target) for each in done)


def _hold(job: ContactJob, contacts: str) -> _Done:
    found = _detect(job.played.clip) if contacts == "detect" else ()
    holds = merge_holds(job.holds, found)
    path = job.character.animation
    if not holds:
        raise InputError(f"{path}: no contact was found", expected="feet that stand on the floor for a moment")
    held = hold_motion(job.played.clip, holds, frequency=job.frequency, limits=job.limits)
    return _Done(job=job, holds=holds, held=held)


def _build(done: _Done) -> CharacterResult:
    played = done.job.played
    variant = build_variant(played.samples, played.clip, done.held.clip, _custom_data(done))
    return CharacterResult(character=done.job.character, names=(_VARIANT,), variants=(variant,))


def _detect(clip: Clip) -> tuple[Hold, ...]:
    return plan_contacts(detect_contacts(clip), clip)


def _custom_data(done: _Done) -> dict[str, object]:
    """The variant's ``customData["mtex"]``."""
    return {"edit": _VARIANT, "contacts": describe_holds(done.holds, done.job.played.clip)}


def _describe(done: _Done, target: Path) -> EditResult:
    character, solution = done.job.character, done.held.solution
    residuals = {} if solution is None else dict(solution.residuals)
    return EditResult(
        anim=str(character.animation),
        model=str(character.model),
        variantSet=character.variant_set,
        variant=_VARIANT,
        clip=done.held.clip,
        custom_data=_custom_data(done),
        residuals=residuals,
        layer=target,
        stage=thin_root_path(target),
    )


def find_contacts(stage_path: FilePath, *, out: FilePath, anim: PrimPath | Sequence[PrimPath] = ()) -> tuple[str, ...]:
    """Find the contacts of feet and write them as MtexContactAPI into a layer for an animator to edit.

    Parameters
    ----------
    stage_path
        The shot.
    out
        The layer to write, overs only; put it among the shot's sublayers, edit it, and constrain.
    anim
        Prim path or paths of the animations; by default all that Skeletons play.

    Returns
    -------
    tuple of str
        Paths of the animations contacts were written for.

    Raises
    ------
    InputError
        Where no contact is found on any, or the file cannot be written.
    StageError
        No such animation, or nothing that plays it.
    """
    source = open_source(as_file_path(stage_path, "stage"))
    target = as_file_path(out, "out")
    check_target(target, "contacts")
    animations = find_played(source.stage, only=as_prim_paths(anim, "anim"))
    jobs = read_contact_jobs(source.stage, animations, "detect", previous=target)
    found = {job.character.animation: (job.played.clip, _detect(job.played.clip)) for job in jobs}
    found = {path: both for path, both in found.items() if both[1]}
    if not found:
        raise InputError("no contact was found", expected="feet that stand on the floor for a moment")
    write_contacts(source.stage, found, target)
    return tuple(str(path) for path in found)
