"""How every command ends: errors as messages with their exit codes, bugs with how to report them."""

import io
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from mtex_usd.errors import MtexError
from mtex_usd.version import VERSION

__all__ = ["EXIT_BUG", "EXIT_INTERRUPTED", "EXIT_PIPE", "hold_interrupts", "report_error", "report_note", "run_command"]

EXIT_BUG = 70
EXIT_INTERRUPTED = 130
EXIT_PIPE = 141


def run_command(name: str, body: Callable[[], int]) -> int:
    """Run a command's body and turn what it raises into messages on stderr and an exit code.

    Parameters
    ----------
    name
        The command's name, for its messages.
    body
        Does the work and returns the exit code.

    Returns
    -------
    int
        The body's own code; that of an :class:`~mtex_usd.errors.MtexError`; 130 where the user interrupted; 141 where
        the reader of stdout went away; 70 for anything else, with the traceback and how to report it.
    """
    _escape_unprintable()
    try:
        code = body()
        sys.stdout.flush()
    except BrokenPipeError:
        _silence_stdout()
        return EXIT_PIPE
    except (KeyboardInterrupt, Exception) as error:
        return _report_failure(name, error)
    return code


def _report_failure(name: str, error: BaseException) -> int:
    if _was_interrupted(error):
        report_error(name, "interrupted")
        return EXIT_INTERRUPTED
    if isinstance(error, MtexError):
        report_error(name, str(error))
        return error.exit_code
    _report_bug(name, error)
    return EXIT_BUG


def _was_interrupted(error: BaseException | None) -> bool:
    """Tell whether the user's interrupt led to an error: USD, while it is loaded, makes other errors of it."""
    seen: list[BaseException] = []
    while error is not None and error not in seen:
        if isinstance(error, KeyboardInterrupt):
            return True
        seen.append(error)
        error = error.__cause__ or error.__context__
    return False


def _escape_unprintable() -> None:
    """Let names of other scripts through a terminal or pipe that cannot show them, as escapes."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


@contextmanager
def hold_interrupts() -> Iterator[None]:
    """Let an interrupt wait until a block is through.

    For importing USD: what hits its modules while they load is printed as a failure of theirs, in pages of diagnostics,
    and then forgotten.

    Raises
    ------
    KeyboardInterrupt
        At the end, where the user interrupted meanwhile.
    """
    usual = signal.default_int_handler
    if threading.current_thread() is not threading.main_thread() or signal.getsignal(signal.SIGINT) is not usual:
        yield  # somebody else's to handle
        return
    held: list[int] = []
    signal.signal(signal.SIGINT, lambda number, _: held.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, usual)
    if held:
        raise KeyboardInterrupt


def report_error(name: str, message: str) -> None:
    """Print an error on stderr as ``name: error: message``."""
    print(f"{name}: error: {message}", file=sys.stderr)


def report_note(name: str, message: str) -> None:
    """Print what a user should know on stderr, as ``name: note: message``."""
    print(f"{name}: note: {message}", file=sys.stderr)


def _report_bug(name: str, error: BaseException) -> None:
    report_error(name, f"{type(error).__name__}: {error}")
    traceback.print_exception(error)
    print(
        f"{name}: this is a bug; report it to the project with the command you ran, the lines above, "
        f"usdmtex {VERSION} and Python {sys.version.split()[0]}.",
        file=sys.stderr,
    )


def _silence_stdout() -> None:
    # Python flushes stdout once more at exit, which would fail again, with a message.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
