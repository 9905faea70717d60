"""The progress bar the commands share."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mtex_usd.progress import ProgressCallback

__all__ = ["show_progress"]


@contextmanager
def show_progress(first: str, *, quiet: bool) -> "Iterator[ProgressCallback | None]":
    """Draw a bar on stderr where that is a terminal.

    Parameters
    ----------
    first
        What it says before the first report.
    quiet
        Draw nothing.
    """
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console  # noqa: PLC0415
    from rich.progress import Progress  # noqa: PLC0415

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(first, total=None)
        yield lambda done, total, what: bar.update(task, completed=done, total=total, description=what or first)
