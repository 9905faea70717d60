"""How long work tells its caller how far it is."""

from collections.abc import Callable

__all__ = ["ProgressCallback", "report_progress"]

ProgressCallback = Callable[[int, int, str], None]
"""Called with how many are done, how many there are, and what is next."""


def report_progress(progress: ProgressCallback | None, done: int, total: int, what: str) -> None:
    """Tell a caller who wants to know how far a job is.

    Parameters
    ----------
    progress
        The caller's; None where nobody wants to know.
    done, total
        How many are done, of how many.
    what
        What is next; empty at the end.
    """
    if progress is not None:
        progress(done, total, what)
