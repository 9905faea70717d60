"""Stacks of edits that are declared on animations, run into an override layer."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from mtex_usd import edit
from mtex_usd.errors import InputError
from mtex_usd.results import EditResult
from mtex_usd.usd.arguments import FilePath, PrimPath, as_file_path, as_prim_paths
from mtex_usd.usd.edit_stacks import make_contact_finder
from mtex_usd.usd.edited import StackJob, find_edited, read_stack_jobs
from mtex_usd.usd.outputs import find_output, write_outputs
from mtex_usd.usd.override import CharacterResult
from mtex_usd.usd.source_stage import open_source
from mtex_usd.usd.thin_root import thin_root_path
from mtex_usd.usd.variant_samples import build_variant

__all__ = ["apply_edits"]

_MAKER = "usdmtex-edit"
_OF_TIME = ("shiftTime", "scaleTime", "warpTime", "align", "join")


@dataclass(frozen=True, eq=False, kw_only=True)
class _Done:
    job: StackJob
    outcomes: dict[str, edit.Outcome]


def apply_edits(
    stage_path: FilePath,
    *,
    out: FilePath | None = None,
    anim: PrimPath | Sequence[PrimPath] = (),
    select: str | None = None,
    dry_run: bool = False,
) -> tuple[EditResult, ...]:
    """Run the stacks of edits of a shot into an override layer, with ``original`` and one variant for each stack.

    Parameters
    ----------
    stage_path
        The shot, or the thin root of an earlier run. It and all it is made of stay as they are.
    out
        The override layer; by default ``<shot>.edit.usd`` beside the shot.
    anim
        Prim path or paths of the animations; by default all with stacks in MtexEditStackAPI.
    select
        The variant to select; by default the user's earlier choice, else the first, ``edited`` where there is one.
    dry_run
        Do everything but write.

    Returns
    -------
    tuple of EditResult
        One per animation, character and stack.

    Raises
    ------
    InputError
        Options, stacks or edits that are not right.
    StageError
        No stack, nothing that plays the animation, or a stronger opinion in the way.
    ResultError
        What was written does not read back as computed.

    Examples
    --------
    >>> apply_edits("shot.usda")[0].clip.frame_count  # doctest: +SKIP
    """
    source = open_source(as_file_path(stage_path, "stage"))
    target = find_output(source, out, word="edit", maker=_MAKER)
    animations, left_out = find_edited(source.stage, only=as_prim_paths(anim, "anim"))
    done = [_run(job) for job in read_stack_jobs(source.stage, animations, previous=target)]
    built = [_build(each) for each in done]
    write_outputs(source.stage, built, target, maker=_MAKER, select=select, dry_run=dry_run)
    results = [_describe(each, name, target) for each in done for name in each.outcomes]
    # To be said once, and so with the first.
    return (replace(results[0], notes=(*left_out, *results[0].notes)), *results[1:])


def _run(job: StackJob) -> _Done:
    played = job.played
    find_contacts = make_contact_finder(played.prim)
    outcomes = {}
    for name, edits in job.stacks.items():
        try:
            outcome = edit.run_stack(played.clip, edits, find_contacts=find_contacts)
        except InputError as error:
            message = f"{job.character.animation}: {error.message}"
            raise InputError(message, expected=error.expected, found=error.found, fix=error.fix) from error
        outcomes[name] = replace(outcome, notes=(*outcome.notes, *_find_left_behind(job, name)))
    return _Done(job=job, outcomes=outcomes)


def _find_left_behind(job: StackJob, name: str) -> tuple[str, ...]:
    """What else the animation moves, which edits of time do not take along."""
    weights = job.played.prim.GetAttribute("blendShapeWeights")
    moved = [each.name for each in job.stacks[name] if each.op in _OF_TIME]
    if not (moved and weights and weights.ValueMightBeTimeVarying()):
        return ()
    return (f"blend shapes keep their times: {', '.join(moved)} moves joints alone",)


def _build(done: _Done) -> CharacterResult:
    played = done.job.played
    variants = tuple(
        build_variant(played.samples, played.clip, outcome.clip, _custom_data(done, name), keys=outcome.keys)
        for name, outcome in done.outcomes.items()
    )
    return CharacterResult(character=done.job.character, names=tuple(done.outcomes), variants=variants)


def _custom_data(done: _Done, name: str) -> dict[str, object]:
    """The variant's ``customData["mtex"]``."""
    edits = [{"name": each.name, "op": each.op} for each in done.job.stacks[name]]
    return {"edit": name, "edits": edits, "notes": list(done.outcomes[name].notes)}


def _describe(done: _Done, name: str, target: Path) -> EditResult:
    character, outcome = done.job.character, done.outcomes[name]
    return EditResult(
        anim=str(character.animation),
        model=str(character.model),
        variantSet=character.variant_set,
        variant=name,
        clip=outcome.clip,
        custom_data=_custom_data(done, name),
        residuals={},
        layer=target,
        stage=thin_root_path(target),
        notes=outcome.notes,
        keys=outcome.keys,
    )
