"""How every command ends: errors as messages with their exit codes, bugs with how to report them."""

import os
import sys
import traceback
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version

from mtex_usd.errors import MtexError

__all__ = ["EXIT_BUG", "EXIT_INTERRUPTED", "EXIT_PIPE", "report_error", "run_command"]

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
    try:
        code = body()
        sys.stdout.flush()
    except MtexError as error:
        report_error(name, str(error))
        return error.exit_code
    except KeyboardInterrupt:
        report_error(name, "interrupted")
        return EXIT_INTERRUPTED
    except BrokenPipeError:
        _silence_stdout()
        return EXIT_PIPE
    except Exception as error:
        _report_bug(name, error)
        return EXIT_BUG
    return code


def report_error(name: str, message: str) -> None:
    """Print an error on stderr as ``name: error: message``."""
    print(f"{name}: error: {message}", file=sys.stderr)


def _report_bug(name: str, error: Exception) -> None:
    report_error(name, f"{type(error).__name__}: {error}")
    traceback.print_exception(error)
    print(
        f"{name}: this is a bug; report it to the project with the command you ran, the lines above, "
        f"usdmtex {_own_version()} and Python {sys.version.split()[0]}.",
        file=sys.stderr,
    )


def _own_version() -> str:
    try:
        return version("usdmtex")
    except PackageNotFoundError:
        return "(not installed)"


def _silence_stdout() -> None:
    # Python flushes stdout once more at exit, which would fail again, with a message.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
