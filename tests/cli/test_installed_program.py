"""``usdmtex`` as a program of its own: exit codes, streams, and what a terminal sees."""

import json
import shutil
from pathlib import Path

import pytest

from mtex_usd.plugin_path import plugin_path
from tests.cli.program import run_on_terminal, run_program

SAMPLES = Path(__file__).resolve().parents[2] / "sample_stages"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("humanoid.usda", "takes.usda", "walk.usda"):
        shutil.copy(SAMPLES / name, tmp_path)
    return tmp_path


def test_the_whole_job_is_the_same_in_every_process(folder: Path) -> None:
    first = run_program("walk.usda", folder=folder)
    assert (first.code, first.err) == (0, "")
    assert first.out.splitlines()[-2:] == ["wrote walk.mtex.usd", "open walk.mtex.stage.usda"]
    written = {name: (folder / name).read_bytes() for name in ("walk.mtex.usd", "walk.mtex.stage.usda")}
    again = run_program("walk.mtex.stage.usda", folder=folder)
    assert again.out.splitlines()[:-2] == first.out.splitlines()[:-2]
    assert {name: (folder / name).read_bytes() for name in written} == written


def test_json_on_standard_output_can_be_piped(folder: Path) -> None:
    done = run_program("walk.usda", "--json", "-", "--dry-run", "--paths", "1", folder=folder)
    assert (done.code, done.err) == (0, "")
    assert json.loads(done.out)["results"][0]["model"] == "/Humanoid"


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["gone.usda"], 2),
        (["walk.usda", "--paths", "0"], 2),
        (["walk.usda", "-o", "takes.usda"], 2),
        (["takes.usda"], 3),
        ([], 2),
    ],
)
def test_errors_are_messages_with_codes(folder: Path, arguments: list[str], code: int) -> None:
    done = run_program(*arguments, folder=folder)
    assert (done.code, done.out) == (code, "")
    assert "usdmtex: error: " in done.err
    assert "Traceback" not in done.err


def test_names_that_the_output_cannot_show_are_escaped(folder: Path) -> None:
    text = (folder / "walk.usda").read_text(encoding="utf-8")
    (folder / "walk.usda").write_text(
        text.replace('"Humanoid"', '"Hümanoid"').replace("/Humanoid/", "/Hümanoid/"), encoding="utf-8"
    )
    done = run_program("walk.usda", "--paths", "1", folder=folder, PYTHONIOENCODING="ascii")
    assert (done.code, done.err) == (0, "")
    assert done.out.startswith("/H\\xfcmanoid/Sketch\t/H\\xfcmanoid\t{mtex}\n")


def test_help_and_plugin_path(folder: Path) -> None:
    assert "usage: usdmtex" in run_program("--help", folder=folder).out
    assert run_program("--print-plugin-path", folder=folder).out == f"{plugin_path()}\n"


def test_progress_is_for_terminals(folder: Path) -> None:
    arguments = ("walk.usda", "--dry-run", "--paths", "2")
    piped = run_program(*arguments, folder=folder)
    shown = run_on_terminal(*arguments, folder=folder)
    assert (piped.code, shown.code) == (0, 0)
    assert piped.err == ""
    assert "reading the shot" in shown.err
    assert shown.out == piped.out


def test_quiet_is_quiet_on_a_terminal_too(folder: Path) -> None:
    done = run_on_terminal("walk.usda", "-q", "--dry-run", folder=folder)
    assert (done.code, done.out, done.err) == (0, "", "")
