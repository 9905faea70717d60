"""From finished sketches to what a director looks at: the review page and the contact sheet."""

from collections.abc import Sequence
from pathlib import Path

from mtex_usd.review.files import check_file, write_file
from mtex_usd.review.page import GENERATOR, build_page
from mtex_usd.review.sheet import build_sheet
from mtex_usd.review.sheet_drawing import MAKER
from mtex_usd.review.shot import Review, ReviewedCharacter, ReviewedVariant
from mtex_usd.usd.finished import Finished, describe_variants
from mtex_usd.usd.override import variant_names

__all__ = ["build_review", "check_report_target", "check_sheet_target", "write_report", "write_sheet"]

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
            ReviewedVariant(name=name, motion=variant, custom_data=custom_data, holds=holds)
            for name, variant, custom_data, holds in parts
        ),
        notes=motion.notes,
    )


def check_report_target(file_path: Path) -> None:
    """Refuse a file that a page cannot be written to, before any work is done for it.

    Parameters
    ----------
    file_path
        Where the page is asked for.

    Raises
    ------
    InputError
        Where the name does not end in .html, the folder is missing or not writable, or the file there is not a review
        page of ours.
    """
    check_file(file_path, ending=".html", is_ours=_is_page, option="--report")


def _is_page(file_path: Path) -> bool:
    with file_path.open("rb") as file:
        return GENERATOR.encode() in file.read(_HEAD_BYTES)


def write_report(review: Review, file_path: Path) -> None:
    """Write the review page, one file that opens from disk without network.

    Parameters
    ----------
    review
        What is shown.
    file_path
        Replaced whole or not at all.

    Raises
    ------
    InputError
        As :func:`check_report_target`, and where the file system refuses.
    """
    check_report_target(file_path)
    write_file(file_path, build_page(review).encode())


def check_sheet_target(file_path: Path) -> None:
    """Refuse a file that a contact sheet cannot be written to, before any work is done for it.

    Parameters
    ----------
    file_path
        Where the picture is asked for.

    Raises
    ------
    InputError
        Where the name does not end in .png, the folder is missing or not writable, or the file there is not a contact
        sheet of ours.
    """
    check_file(file_path, ending=".png", is_ours=_is_sheet, option="--sheet")


def _is_sheet(file_path: Path) -> bool:
    with file_path.open("rb") as file:
        return MAKER.encode() in file.read(_HEAD_BYTES)


def write_sheet(review: Review, file_path: Path) -> None:
    """Write the contact sheet: strobed figures, a row for the sketch and one for every variant.

    Parameters
    ----------
    review
        What is shown.
    file_path
        Replaced whole or not at all.

    Raises
    ------
    InputError
        As :func:`check_sheet_target`, and where the file system refuses.
    """
    check_sheet_target(file_path)
    write_file(file_path, build_sheet(review))
