"""Pipes where a file is asked for: refused at once, where reading them would wait for ever."""

import os
import signal
from functools import partial

import pytest

from mtex_usd.cli._table import check_json_target
from mtex_usd.editorial.files import check_timeline_target
from mtex_usd.errors import InputError
from mtex_usd.reviewing import check_report_target, check_sheet_target


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
@pytest.mark.parametrize(
    ("check", "name"),
    [
        (partial(check_json_target, others=()), "f.json"),
        (check_report_target, "f.html"),
        (check_sheet_target, "f.png"),
        (check_timeline_target, "f.otio"),
    ],
)
def test_a_pipe_is_left_alone(tmp_path, check, name):
    pipe = tmp_path / name
    os.mkfifo(pipe)
    usual = signal.signal(signal.SIGALRM, _fail)
    signal.alarm(5)
    try:
        with pytest.raises(InputError, match=r"was not written by usdmtex; it is left alone"):
            check(pipe)
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, usual)


def _fail(*_: object) -> None:
    raise AssertionError("it waits for the pipe")
