"""A few damaged files of every kind, in the ordinary test run; ``python -m tests.fuzz.run`` reads 10,000 of each."""

import subprocess
import sys
from pathlib import Path

import pytest

from mtex_usd.errors import InputError
from tests.conftest import PROJECT
from tests.fuzz import cases, run
from tests.fuzz.cases import Case, DefectError, make_case
from tests.fuzz.containers import pack_glb, pack_usdz, split_glb
from tests.fuzz.corpus import KINDS, USD_KINDS, collect

COUNT = 40
SEED = 3


@pytest.fixture(scope="module", autouse=True)
def end_stage_reader():
    """End the process that reads stages with the tests that use it."""
    yield
    cases.close_stages()


@pytest.mark.parametrize("kind", KINDS)
def test_the_files_to_be_damaged_are_good(kind: str, tmp_path: Path) -> None:
    for i, specimen in enumerate(collect(kind)):
        folder = tmp_path / str(i)
        folder.mkdir()
        assert cases.read_case(Case(kind, 0, 0, specimen, specimen.content), folder), specimen.name


@pytest.mark.parametrize("kind", KINDS)
def test_damaged_files_are_read_or_refused(kind: str, tmp_path: Path) -> None:
    outcomes = []
    for number in range(COUNT):
        folder = tmp_path / str(number)
        folder.mkdir()
        outcomes.append(cases.read_case(make_case(kind, SEED, number), folder))
    assert COUNT // 3 < outcomes.count(False) < COUNT, "nothing is damaged, or nothing comes past the parser"


@pytest.mark.parametrize("kind", sorted(set(KINDS) - set(USD_KINDS)))
def test_the_command_reads_or_refuses_them(kind: str, tmp_path: Path) -> None:
    for number in range(5):
        folder = tmp_path / str(number)
        folder.mkdir()
        cases.import_case(make_case(kind, SEED, number), folder)


@pytest.mark.parametrize("kind", USD_KINDS)
def test_the_command_survives_damaged_stages(kind: str, tmp_path: Path) -> None:
    specimen = collect(kind)[0]
    case = Case(kind, 0, 0, specimen, specimen.content[: len(specimen.content) // 2])
    assert not cases.import_case(case, tmp_path)


def test_a_case_is_told_by_its_seed() -> None:
    for kind in KINDS:
        assert make_case(kind, 1, 5) == make_case(kind, 1, 5)
    assert len({make_case("bvh", 1, number).content for number in range(20)}) > 15


def test_containers_are_put_together_again() -> None:
    for specimen in collect("glb"):
        document, binary = split_glb(specimen.content)
        assert split_glb(pack_glb(document, binary)) == (document, binary)
    usdz = pack_usdz([("a.usda", b"#usda 1.0\n"), ("b.txt", b"x")])
    assert usdz.index(b"#usda") % 64 == 0


BVH = collect("bvh")[0]


def judge(monkeypatch: pytest.MonkeyPatch, folder: Path, reader) -> bool:
    monkeypatch.setitem(cases._READERS, "bvh", reader)
    return cases.read_case(Case("bvh", 0, 0, BVH, BVH.content), folder)


def test_what_no_user_should_see_is_a_defect(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def refuse(message: str):
        def reader(damaged: Path) -> None:
            raise InputError(message)

        return reader

    assert not judge(monkeypatch, tmp_path, refuse("bad"))
    for message in ("", "x" * 5000, "Traceback (most recent call last)"):
        with pytest.raises(DefectError, match="no message for users"):
            judge(monkeypatch, tmp_path, refuse(message))


WORKER = """
import os, signal, sys, time
from tests.fuzz import cases, worker
read, calls = cases._READERS["bvh"], []
def fail(damaged):
    raise ValueError("odd")
def crash(damaged):
    os.kill(os.getpid(), signal.SIGSEGV)
def hang(damaged):
    time.sleep(60)
def grow(damaged):
    return bytearray(1200 << 20) and read(damaged)
readers = {0: [read, fail, grow, read, crash], 5: [read, hang], 7: [read]}
def reader(damaged):
    calls.append(damaged)
    return readers[int(sys.argv[3])][len(calls) - 1](damaged)
cases._READERS["bvh"] = reader
worker.main()
"""


def test_whatever_happens_to_the_process_is_a_finding(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The worker as it is, with readers that do something bad."""
    (tmp_path / "worker.py").write_text(WORKER)
    popen = subprocess.Popen

    def start(command: list[str], **options: object) -> subprocess.Popen[bytes]:
        arguments = command[command.index("tests.fuzz.worker") + 1 :]
        return popen([sys.executable, str(tmp_path / "worker.py"), *arguments], **options)

    monkeypatch.setattr(run.subprocess, "Popen", start)
    monkeypatch.setattr(run, "TIME_LIMIT_S", 6.0)
    monkeypatch.setenv("PYTHONPATH", str(PROJECT))
    tally = run.run_kind("bvh", seed=0, first=0, last=8, import_every=0)
    assert tally.outcomes.total() == 8
    assert tally.outcomes["read"] + tally.outcomes["refused"] == 4
    found = [(number, what.partition(":")[0]) for number, what in tally.findings]
    assert found == [(1, "defect"), (2, "defect"), (4, "crash"), (6, "hang")]
    odd, large, crash, hang = (what for _, what in tally.findings)
    assert "ValueError: odd" in odd
    assert "took 1" in large
    assert "exit -11" in crash
    assert "more than 6 s" in hang


def test_the_command_reproduces_a_case(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    kept = tmp_path / "kept.bvh"
    assert run.main(["--case", f"bvh/{SEED}/7", "--keep", str(kept)]) == 0
    assert kept.read_bytes() == make_case("bvh", SEED, 7).content
    assert capsys.readouterr().out.startswith(f"bvh/{SEED}/7, from ")


def test_the_table_has_a_row_for_each_reader(capsys: pytest.CaptureFixture[str]) -> None:
    assert run.main(["--count", "5", "--format", "asf"]) == 0
    head, row = capsys.readouterr().out.splitlines()
    assert head.split()[:4] == ["reader", "mutations", "refused", "read"]
    assert row.split()[:2] == ["asf", "5"]
