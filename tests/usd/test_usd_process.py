"""Stages are read in a process that may die."""

import sys
from pathlib import Path

import numpy as np
import pytest

from mtex_usd.api import import_takes
from mtex_usd.formats.recording import FormatError, NoMotionError
from mtex_usd.usd import usd_process
from mtex_usd.usd.usd_process import UsdReader, default_memory_limit
from mtex_usd.usd.usd_takes import read_usd
from tests.usd.character import CHARACTER

# Does something bad over files that say so, and reads the others.
SERVE = """
import os, signal, sys, time
sys.path[:] = {path!r}
from mtex_usd.usd import usd_process
read = usd_process.read_usd
def read_badly(file_path):
    text = file_path.read_text()
    if "CRASH" in text:
        os.kill(os.getpid(), signal.SIGSEGV)
    if "ABORT" in text:
        print("terminate called after throwing an instance of 'std::bad_alloc'", file=sys.stderr, flush=True)
        os.abort()
    if "HANG" in text:
        time.sleep(60)
    if "GROW" in text:
        bytearray(1 << 40)
    if "BUG" in text:
        raise KeyError("ours")
    if "SAY" in text:
        print("printed")
        print("Warning: warned", file=sys.stderr)
    return read(file_path)
usd_process.read_usd = read_badly
usd_process.serve({memory_limit!r})
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Give a folder with a good stage and others that the child of these tests takes badly."""
    for name in ("good", "CRASH", "ABORT", "HANG", "GROW", "BUG", "SAY"):
        (tmp_path / f"{name.lower()}.usda").write_text(f"{CHARACTER}\n# {name}\n")
    return tmp_path


def test_the_child_gives_what_the_stage_holds(folder: Path) -> None:
    (expected,) = read_usd(folder / "good.usda").recordings
    with UsdReader() as reader:
        (found,) = reader.read(folder / "good.usda").recordings
        first = reader.process_id
        reader.read(folder / "good.usda")
        assert first is not None
        assert reader.process_id == first
    assert reader.process_id is None
    for name in ("rotations", "translations", "scales", "rest", "bind", "placement"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name), err_msg=name)
    assert (found.names, found.source, found.style) == (expected.names, expected.source, expected.style)


def test_refusals_are_the_same_errors(tmp_path: Path) -> None:
    (tmp_path / "broken.usda").write_text("#usda 1.0\ndef {")
    (tmp_path / "set.usda").write_text('#usda 1.0\ndef Xform "Set" {}\n')
    with UsdReader() as reader:
        with pytest.raises(FormatError, match=r"broken\.usda: cannot be read"):
            reader.read(tmp_path / "broken.usda")
        with pytest.raises(NoMotionError, match=r"set\.usda: the stage has no SkelAnimation with joints"):
            reader.read(tmp_path / "set.usda")


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("crash", r"cannot be read: USD crashed over it \(SIGSEGV\); the file is damaged"),
        ("abort", r"cannot be read: USD ran out of memory over it; the file is damaged or too large"),
        ("grow", r"cannot be read: USD ran out of memory over it; it is damaged or too large"),
        ("hang", r"cannot be read: USD was not through with it after 5 s; the file is damaged or too large"),
    ],
)
def test_a_stage_that_ends_the_child_is_refused_and_the_next_is_read(
    monkeypatch: pytest.MonkeyPatch, folder: Path, name: str, reason: str
) -> None:
    monkeypatch.setattr(usd_process, "_SERVE", SERVE)
    with UsdReader(time_limit_s=5.0 if name == "hang" else 60.0) as reader:
        with pytest.raises(FormatError, match=reason):
            reader.read(folder / f"{name}.usda")
        assert len(reader.read(folder / "good.usda").recordings) == 1


def test_a_bug_in_the_child_is_ours_to_see(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    monkeypatch.setattr(usd_process, "_SERVE", SERVE)
    with UsdReader() as reader, pytest.raises(RuntimeError, match=r"reading .*bug\.usda failed(.|\n)*KeyError: 'ours'"):
        reader.read(folder / "bug.usda")


def test_what_usd_says_is_passed_on(
    monkeypatch: pytest.MonkeyPatch, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(usd_process, "_SERVE", SERVE)
    with UsdReader() as reader:
        reader.read(folder / "good.usda")
        assert capsys.readouterr().err == ""
        reader.read(folder / "say.usda")
        assert capsys.readouterr().err.splitlines() == ["printed", "Warning: warned"]
        reader.read(folder / "good.usda")
        assert capsys.readouterr().err == ""


def test_a_stage_that_crashes_usd_does_not_take_the_others_along(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    monkeypatch.setattr(usd_process, "_SERVE", SERVE)
    sources = [folder / "good.usda", folder / "crash.usda", folder / "say.usda"]
    result = import_takes(sources, out=folder / "takes.usd")
    assert [take.prim_path for take in result.takes] == ["/Takes/good", "/Takes/say"]
    (failure,) = result.failures
    assert failure.source == folder / "crash.usda"
    assert failure.reason == "cannot be read: USD crashed over it (SIGSEGV); the file is damaged"


def test_a_program_without_python_reads_stages_itself(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    for executable in ("/opt/maya/bin/maya", "", None):
        monkeypatch.setattr(sys, "executable", executable)
        with UsdReader() as reader:
            assert len(reader.read(folder / "good.usda").recordings) == 1
            assert reader.process_id is None


def test_a_child_that_does_not_start_says_why(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    monkeypatch.setattr(usd_process, "_SERVE", "raise SystemExit('no USD here')")
    with UsdReader() as reader, pytest.raises(RuntimeError, match="does not start: no USD here"):
        reader.read(folder / "good.usda")


def test_the_memory_limit_is_half_of_the_machine() -> None:
    assert default_memory_limit() >= 4 << 30
