"""From finished sketches to what a director looks at: the review page and the contact sheet."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from mtex_usd.edit.sampling import sample_clip
from mtex_usd.files import check_ours, check_place
from mtex_usd.motion.clip import Clip
from mtex_usd.review.page import PAGE_MARK, build_page
from mtex_usd.review.sheet import build_sheet
from mtex_usd.review.sheet_drawing import SHEET_MARK
from mtex_usd.review.shot import Review, ReviewedCharacter, ReviewedVariant
from mtex_usd.texture.result import Variant
from mtex_usd.usd.finished import Finished, describe_variants
from mtex_usd.usd.override import variant_names

__all__ = ["build_report", "build_review", "build_sheet", "check_report_target", "check_sheet_target"]

_HEAD_BYTES = 512


def build_review(finished: Sequence[Finished], *, title: str, command: str) -> Review:
    """Gather what is shown of a shot.

    Parameters
    ----------
    finished
        The sketches that were worked on, in stage order.
    title
        What the shot is called, usually the stage's file name.
    command
        The exact command, as a shell takes it.
    """
    return Review(title=title, command=command, characters=tuple(_gather(each) for each in finished))


def _gather(finished: Finished) -> ReviewedCharacter:
    job, motion = finished.job, finished.motion
    names = variant_names(len(motion.variants))
    parts = zip(names, motion.variants, describe_variants(finished), finished.holds, strict=True)
    return ReviewedCharacter(
        anim=str(job.character.animation),
        model=str(job.character.model),
        variant_set=job.character.variant_set,
        texturing=motion,
        recipe=finished.recipe,
        takes=tuple(take.clip for take in job.takes),
        key_times=job.samples.sample_times,
        variants=tuple(
            ReviewedVariant(
                name=name, motion=_at_frames_of(motion.sketch, variant), custom_data=custom_data, holds=holds
            )
            for name, variant, custom_data, holds in parts
        ),
        notes=(*motion.notes, *_note_frames(motion.sketch, motion.variants)),
    )


def _at_frames_of(sketch: Clip, variant: Variant) -> Variant:
    """Give what plays at the sketch's frames, which edits made after texturing need not have left as they were."""
    clip = variant.clip
    if np.array_equal(clip.time_codes, sketch.time_codes):
        return variant
    played = sample_clip(clip, (sketch.time_codes - clip.start) / clip.time_codes_per_frame)
    step = sketch.time_codes_per_frame
    shown = replace(played, start=sketch.start, rate=sketch.rate, time_codes_per_frame=step)
    return replace(variant, clip=shown)


def _note_frames(sketch: Clip, variants: Sequence[Variant]) -> list[str]:
    """Say where a variant has other frames than are shown."""
    first, last = sketch.time_codes[[0, -1]]
    spans = dict.fromkeys(tuple(variant.clip.time_codes[[0, -1]]) for variant in variants)
    return [
        f"edits after texturing make it {begin:g} to {end:g} long; shown is {first:g} to {last:g}, the sketch's frames"
        for begin, end in spans
        if (begin, end) != (first, last)
    ]


def check_report_target(file_path: Path) -> None:
    """Refuse a file that a page cannot be written to, before any work is done for it.

    Parameters
    ----------
    file_path
        Where the page is asked for.

    Raises
    ------
    InputError
        Where the name does not end in .html or is a folder's, the folder is missing or not writable, or the file there
        is not a review page of ours.
    """
    _check(file_path, what="review page", ending=".html", mark=PAGE_MARK)


def _check(file_path: Path, *, what: str, ending: str, mark: str) -> None:
    check_place(file_path, what=what, endings=(ending,))
    check_ours(file_path, what=what, is_ours=lambda path: _is_marked(path, mark))


def _is_marked(file_path: Path, mark: str) -> bool:
    with file_path.open("rb") as file:
        return mark.encode() in file.read(_HEAD_BYTES)


def build_report(review: Review) -> bytes:
    """Build the review page, one file that opens from disk without network.

    Parameters
    ----------
    review
        What is shown.
    """
    return build_page(review).encode()


def check_sheet_target(file_path: Path) -> None:
    """Refuse a file that a contact sheet cannot be written to, before any work is done for it.

    Parameters
    ----------
    file_path
        Where the picture is asked for.

    Raises
    ------
    InputError
        Where the name does not end in .png or is a folder's, the folder is missing or not writable, or the file there
        is not a contact sheet of ours.
    """
    _check(file_path, what="contact sheet", ending=".png", mark=SHEET_MARK)
