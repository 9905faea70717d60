"""Ctrl-C at any moment: one line, 130, and nothing half written."""

import os
import signal
import threading

import pytest

from mtex_usd.cli._run import EXIT_BUG, EXIT_INTERRUPTED, hold_interrupts, run_command
from mtex_usd.errors import StageError
from tests.cli.support import Capture


def _as_cause() -> int:
    try:
        raise KeyboardInterrupt
    except KeyboardInterrupt as error:
        raise ImportError("error loading pxr.Gf") from error


def _as_context() -> int:
    try:
        _as_cause()
    except ImportError:
        raise TypeError("no converter found")  # noqa: B904 - as USD does
    return 0


def _inside_an_error_of_ours() -> int:
    try:
        _as_context()
    except TypeError as error:
        raise StageError("no recipe") from error
    return 0


def _in_a_circle() -> int:
    one, other = ValueError("one"), ValueError("other")
    one.__context__, other.__context__ = other, one
    raise one


@pytest.mark.parametrize("body", [_as_cause, _as_context, _inside_an_error_of_ours])
def test_an_interrupt_that_became_another_error(body: object, capsys: Capture) -> None:
    assert run_command("usdmtex", body) == EXIT_INTERRUPTED
    assert capsys.readouterr() == ("", "usdmtex: error: interrupted\n")


def test_errors_that_go_in_circles_are_bugs(capsys: Capture) -> None:
    assert run_command("usdmtex", _in_a_circle) == EXIT_BUG
    assert capsys.readouterr().err.startswith("usdmtex: error: ValueError: one\n")


def test_an_interrupt_waits_for_the_imports() -> None:
    done = []
    with pytest.raises(KeyboardInterrupt), hold_interrupts():
        os.kill(os.getpid(), signal.SIGINT)
        done.append("imports")
    assert done == ["imports"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_what_went_wrong_meanwhile_is_told() -> None:
    with pytest.raises(ImportError, match="no module"), hold_interrupts():
        raise ImportError("no module")
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_others_handle_their_own_interrupts(monkeypatch: pytest.MonkeyPatch) -> None:
    """A farm that ignores them, and threads, which have no signals."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with hold_interrupts():
            assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)
    failures: list[BaseException] = []

    def hold() -> None:
        try:
            with hold_interrupts():
                pass
        except BaseException as error:
            failures.append(error)

    thread = threading.Thread(target=hold)
    thread.start()
    thread.join()
    assert failures == []
