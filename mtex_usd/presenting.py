"""What a run writes beside its layers, for those who choose: a timeline, a review page, a contact sheet."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from mtex_usd.files import check_distinct, replace_file
from mtex_usd.usd.finished import Finished
from mtex_usd.usd.source_stage import SourceStage

__all__ = ["Presentation", "check_presentation", "prepare_presentation"]


@dataclass(frozen=True, kw_only=True)
class Presentation:
    """What is asked for.

    Parameters
    ----------
    timeline
        An .otio file; None for none.
    report
        An .html file; None for none.
    sheet
        A .png file; None for none.
    command
        The command as a shell takes it, for the review page.
    """

    timeline: Path | None = None
    report: Path | None = None
    sheet: Path | None = None
    command: str = ""


def check_presentation(asked: Presentation, others: Sequence[Path]) -> None:
    """Make sure that what is asked for may be written, before any work is done for it.

    Parameters
    ----------
    asked
        What is asked for.
    others
        Files that the same run reads or writes.

    Raises
    ------
    InputError
        Naming the file and what is wrong.
    """
    # What is not asked for is not loaded: it would take longer than a short shot.
    if asked.timeline:
        from mtex_usd.editorial.files import check_timeline_target  # noqa: PLC0415

        check_timeline_target(asked.timeline)
    if asked.report:
        from mtex_usd.reviewing import check_report_target  # noqa: PLC0415

        check_report_target(asked.report)
    if asked.sheet:
        from mtex_usd.reviewing import check_sheet_target  # noqa: PLC0415

        check_sheet_target(asked.sheet)
    named = {"timeline": asked.timeline, "review page": asked.report, "contact sheet": asked.sheet}
    taken = list(others)
    for what, file_path in named.items():
        if file_path is not None:
            check_distinct(file_path, taken, what=what)
            taken.append(file_path)


def prepare_presentation(asked: Presentation, source: SourceStage, finished: Sequence[Finished]) -> Callable[[], None]:
    """Build what is asked for, and give what writes it once the layers are there.

    Parameters
    ----------
    asked
        What is asked for.
    source
        The shot.
    finished
        What was made of its sketches, at least one.
    """
    writers: list[Callable[[], None]] = []
    if asked.timeline:
        writers.append(_prepare_timeline(asked.timeline, source, finished))
    if asked.report or asked.sheet:
        writers += _prepare_review(asked, source, finished)

    def write() -> None:
        """Write all of it."""
        for each in writers:
            each()

    return write


def _prepare_timeline(file_path: Path, source: SourceStage, finished: Sequence[Finished]) -> Callable[[], None]:
    from mtex_usd.conforming import describe_timeline  # noqa: PLC0415
    from mtex_usd.editorial.files import write_timeline_text  # noqa: PLC0415

    text = describe_timeline(source, finished)
    return partial(write_timeline_text, file_path, text)


def _prepare_review(asked: Presentation, source: SourceStage, finished: Sequence[Finished]) -> list[Callable[[], None]]:
    from mtex_usd.reviewing import build_report, build_review, build_sheet  # noqa: PLC0415

    review = build_review(finished, title=source.source_path.name, command=asked.command)
    pairs = ((asked.report, build_report), (asked.sheet, build_sheet))
    return [partial(replace_file, file_path, build(review)) for file_path, build in pairs if file_path is not None]
