"""Running stacks of edits, one edit after the other on a motion."""

from collections.abc import Callable, Mapping, Sequence

from mtex_usd.edit.stack.combining_operations import run_blend, run_displace, run_join
from mtex_usd.edit.stack.edit import ContactFinder, Edit, Outcome
from mtex_usd.edit.stack.key_operations import run_reduce_keys
from mtex_usd.edit.stack.operations import check_edit
from mtex_usd.edit.stack.span import limit_to_span
from mtex_usd.edit.stack.time_operations import run_align, run_scale_time, run_shift_time, run_warp_time
from mtex_usd.edit.stack.value_operations import (
    run_bandpass,
    run_equalize,
    run_highpass,
    run_lowpass,
    run_median,
    run_mirror,
    run_robust_mean,
    run_waveshape,
)
from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip

__all__ = ["run_stack"]

_Runner = Callable[[Clip, Edit, ContactFinder], Outcome]


def _whole(run: Callable[[Clip, Edit], Clip]) -> _Runner:
    """Make an operation of a function that gives a motion."""
    return lambda clip, edit, _: Outcome(clip=run(clip, edit))


def _spanned(run: Callable[[Clip, Edit], Clip]) -> _Runner:
    """Make an operation that acts within its span alone."""
    return lambda clip, edit, _: Outcome(clip=limit_to_span(edit, clip, run(clip, edit)))


def _noted(run: Callable[[Clip, Edit], Outcome]) -> _Runner:
    """Make an operation of a function that has something to say."""
    return lambda clip, edit, _: run(clip, edit)


_RUNNERS: Mapping[str, _Runner] = {
    "lowpass": _spanned(run_lowpass),
    "highpass": _spanned(run_highpass),
    "bandpass": _spanned(run_bandpass),
    "equalize": _spanned(run_equalize),
    "median": _spanned(run_median),
    "robustMean": _spanned(run_robust_mean),
    "waveshape": _spanned(run_waveshape),
    "mirror": _whole(run_mirror),
    "shiftTime": _whole(run_shift_time),
    "scaleTime": _whole(run_scale_time),
    "warpTime": _whole(run_warp_time),
    "align": _whole(run_align),
    "blend": _noted(run_blend),
    "join": _noted(run_join),
    "displace": _whole(run_displace),
    "reduceKeys": run_reduce_keys,
}


def run_stack(clip: Clip, edits: Sequence[Edit], *, find_contacts: ContactFinder | None = None) -> Outcome:
    """Run edits on a motion, one after the other.

    Parameters
    ----------
    clip
        The motion.
    edits
        In order; times of each are on the motion as those before have left it.
    find_contacts
        Asked for the frames where contacts begin and end, which stay keys; None where nobody knows any.

    Returns
    -------
    Outcome
        The very clip where there is no edit; keys where the last edit reduced them.

    Raises
    ------
    InputError
        For an edit that is not right, named.
    """
    for edit in edits:
        check_edit(edit)
    notes: list[str] = []
    outcome = Outcome(clip=clip)
    for edit in edits:
        outcome = _run(outcome.clip, edit, find_contacts or _find_none)
        notes += [f"{edit.name}: {note}" for note in outcome.notes]
    return Outcome(clip=outcome.clip, keys=outcome.keys, notes=tuple(notes))


def _run(clip: Clip, edit: Edit, find_contacts: ContactFinder) -> Outcome:
    try:
        return _RUNNERS[edit.op](clip, edit, find_contacts)
    except InputError as error:
        if error.message.startswith(f"edit {edit.name} "):
            raise
        raise edit.fail(error.message, expected=error.expected, found=error.found, fix=error.fix) from error


def _find_none(clip: Clip, contacts: str) -> tuple[int, ...]:  # noqa: ARG001
    """Know of no contacts."""
    return ()
