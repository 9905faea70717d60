"""``usdmtex-import`` as people type it."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import pytest
from pxr import Usd, UsdGeom

from mtex_usd import api
from mtex_usd.cli._run import EXIT_BUG, EXIT_INTERRUPTED, EXIT_PIPE, run_command
from mtex_usd.cli.usdmtex_import import main
from tests.acclaim import write_take
from tests.gltf_files import build_arm

TAKE = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 4 Yposition Zrotation Yrotation Xrotation
}
MOTION
Frames: 3
Frame Time: 0.0333333
0 0 0 0
1 1 1 1
2 2 2 2
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Give a working folder with two good files and a cut one."""
    (tmp_path / "07_01.bvh").write_text(TAKE)
    (tmp_path / "walk.bvh").write_text(TAKE + "\n")
    (tmp_path / "cut.bvh").write_text(TAKE[: TAKE.index("2 2 2 2")])
    monkeypatch.chdir(tmp_path)
    return tmp_path


COLUMNS = ("TAKE", "FRAMES", "RATE", "SECONDS", "JOINTS", "SKELETON", "STYLE", "SOURCE", "SHA256", "LICENCE")
CUT = "cut.bvh:11: truncated: 3 frames declared, 2 found"


def test_writes_takes_and_lists_them(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["07_01.bvh", "walk.bvh", "-o", "takes.usd"]) == 0
    captured = capsys.readouterr()
    assert captured.out.splitlines() == [
        "/Takes/take_07_01\t3 frames\t30/s\t07_01.bvh",
        "/Takes/walk\t3 frames\t30/s\twalk.bvh",
    ]
    assert captured.err == ""
    stage = Usd.Stage.Open("takes.usd")
    assert stage.GetPrimAtPath("/Takes/take_07_01")


def test_every_option_arrives(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--meters-per-unit", "0.05", "--up-axis", "z", "--skip-frames", "1", "--style", "sad", "-v"]
    assert main(["walk.bvh", "-o", "takes.usda", *options]) == 0
    assert capsys.readouterr().out == "/Takes/walk\t2 frames\t30/s\twalk.bvh\t/Takes/Skeleton\n"
    stage = Usd.Stage.Open("takes.usda")
    assert (UsdGeom.GetStageMetersPerUnit(stage), UsdGeom.GetStageUpAxis(stage)) == (0.05, "Z")
    prim = stage.GetPrimAtPath("/Takes/walk")
    assert prim.GetAttribute("mtex:take:style").Get() == "sad"
    assert prim.GetAttribute("translations").Get(0)[0][1] == 1.0


def test_quiet_is_silent(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["walk.bvh", "-o", "takes.usd", "-q"]) == 0
    assert capfd.readouterr() == ("", "")


def test_progress_on_a_terminal_keeps_stdout_clean(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert main(["walk.bvh", "-o", "takes.usd"]) == 0
    assert capsys.readouterr().out == "/Takes/walk\t3 frames\t30/s\twalk.bvh\n"


def test_progress_counts_the_files(folder: Path) -> None:
    calls: list[tuple[int, int, str]] = []
    api.import_takes(
        ["cut.bvh", "walk.bvh"], out="takes.usd", progress=lambda done, total, what: calls.append((done, total, what))
    )
    assert calls == [(0, 2, "cut.bvh"), (1, 2, "walk.bvh"), (2, 2, "")]


def test_the_good_files_are_written_and_the_bad_listed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["cut.bvh", "walk.bvh", "gone.bvh", "-o", "takes.usd"]) == 2
    captured = capsys.readouterr()
    assert captured.out == "/Takes/walk\t3 frames\t30/s\twalk.bvh\n"
    assert captured.err.splitlines() == [
        f"usdmtex-import: error: {CUT}",
        "usdmtex-import: error: gone.bvh: cannot be read: No such file or directory",
    ]
    stage = Usd.Stage.Open("takes.usd")
    assert stage.GetPrimAtPath("/Takes/walk")


@pytest.mark.parametrize(
    ("arguments", "why"), [(["cut.bvh", "walk.bvh", "--strict"], "--strict"), (["cut.bvh"], "no file could be read")]
)
def test_nothing_is_written_when_strict_or_none_good(
    folder: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], why: str
) -> None:
    before = sorted(folder.iterdir())
    assert main([*arguments, "-o", "takes.usd"]) == 2
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("", f"usdmtex-import: error: nothing written ({why}):\n  {CUT}\n")
    assert sorted(folder.iterdir()) == before


def test_a_file_of_somebody_else_is_left_alone(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "shot.usda").write_text("#usda 1.0\n")
    assert main(["walk.bvh", "-o", "shot.usda"]) == 2
    assert "shot.usda exists and was not written by usdmtex" in capsys.readouterr().err
    assert (folder / "shot.usda").read_text() == "#usda 1.0\n"


def list_takes(name: str) -> list[str]:
    stage = Usd.Stage.Open(name)
    return [prim.GetName() for prim in stage.GetDefaultPrim().GetChildren()]


def test_a_library_is_added_to_and_nothing_comes_twice(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["walk.bvh", "-o", "takes.usd", "-q"]) == 0
    (folder / "07_01.bvh").write_text(TAKE.replace("2 2 2 2", "3 3 3 3"))
    assert main(["07_01.bvh", "walk.bvh", "-o", "takes.usd"]) == 0
    captured = capsys.readouterr()
    assert captured.out == "/Takes/take_07_01\t3 frames\t30/s\t07_01.bvh\n"
    assert captured.err == "usdmtex-import: note: walk.bvh: is in the library already as /Takes/walk; left out\n"
    assert list_takes("takes.usd") == ["Skeleton", "walk", "take_07_01"]


def test_a_library_can_be_begun_anew(folder: Path) -> None:
    assert main(["walk.bvh", "-o", "takes.usd", "-q"]) == 0
    assert main(["07_01.bvh", "-o", "takes.usd", "-q", "--replace"]) == 0
    assert list_takes("takes.usd") == ["Skeleton", "take_07_01"]


def test_a_strict_failure_leaves_the_library_as_it_was(folder: Path) -> None:
    assert main(["walk.bvh", "-o", "takes.usd", "-q"]) == 0
    before = (folder / "takes.usd").read_bytes()
    assert main(["07_01.bvh", "cut.bvh", "-o", "takes.usd", "--strict", "--style", "x"]) == 2
    assert (folder / "takes.usd").read_bytes() == before


def test_folders_and_patterns(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "walk.bvh").rename(folder / "walk.txt")
    assert main([".", "-o", "takes.usd", "--strict", "-q"]) == 2
    assert CUT in capsys.readouterr().err
    (folder / "cut.bvh").unlink()
    assert main(["*.bvh", "w*", "-o", "takes.usd", "-q"]) == 0
    assert list_takes("takes.usd") == ["Skeleton", "take_07_01", "walk"]
    assert main(["no*.bvh", "-o", "other.usd"]) == 2
    assert "no*.bvh: the pattern leads to no BVH, ASF/AMC, glTF or USD file" in capsys.readouterr().err


def test_amc_options(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    motion = write_take(folder)
    (folder / "tester.asf").rename(folder / "renamed.asf")
    (folder / "second.asf").touch()
    assert main([motion.name, "-o", "takes.usd"]) == 2
    assert "none of renamed.asf, second.asf has its name; name one with --skeleton" in capsys.readouterr().err
    assert main([motion.name, "-o", "takes.usd", "--skeleton", "renamed.asf", "--rate", "60"]) == 0
    assert capsys.readouterr().out == "/Takes/tester_01\t2 frames\t60/s\ttester_01.amc\n"


def test_gltf_rate(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    build_arm().write(folder, "arm.glb")
    assert main(["arm.glb", "-o", "takes.usd", "--rate", "25"]) == 0
    assert capsys.readouterr().out == "/Takes/arm\t26 frames\t25/s\tarm.glb\n"


def test_listing_a_library(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["walk.bvh", "-o", "takes.usd", "-q", "--licence", "CC0, see file", "--style", "calm"]) == 0
    sha256 = hashlib.sha256(f"{TAKE}\n".encode()).hexdigest()[:12]
    for arguments in (["--list", "takes.usd"], ["-o", "takes.usd", "--list"]):
        assert main(arguments) == 0
        lines = [line.split() for line in capsys.readouterr().out.splitlines()]
        assert lines[0] == list(COLUMNS)
        assert lines[1:] == [f"/Takes/walk 3 30 0.07 1 Skeleton calm walk.bvh {sha256} CC0, see file".split()]
    assert main(["--list", "walk.bvh"]) == 2
    assert "walk.bvh" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ([], "the following arguments are required: FILE, -o/--output"),
        (["-o", "t.usd"], "the following arguments are required: FILE"),
        (["--list"], "--list needs a library: --list TAKES.usd"),
        (["walk.bvh"], "the following arguments are required: -o/--output"),
        (["walk.bvh", "-o", "t.usd", "--skip-frames", "x"], "argument --skip-frames: invalid int value: 'x'"),
        (["walk.bvh", "-o", "t.usd", "-q", "-v"], "not allowed with argument"),
    ],
)
def test_bad_usage(capsys: pytest.CaptureFixture[str], arguments: list[str], reason: str) -> None:
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2
    assert reason in capsys.readouterr().err


def test_a_bug_says_so(folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def fail(*_: object, **__: object) -> None:
        raise ZeroDivisionError("oh")

    monkeypatch.setattr(api, "import_takes", fail)
    assert main(["walk.bvh", "-o", "takes.usd"]) == EXIT_BUG == 70
    error = capsys.readouterr().err
    assert error.startswith("usdmtex-import: error: ZeroDivisionError: oh\nTraceback")
    assert "this is a bug; report it" in error.splitlines()[-1]


def test_interrupting_is_no_bug(capsys: pytest.CaptureFixture[str]) -> None:
    def interrupt() -> int:
        raise KeyboardInterrupt

    assert run_command("usdmtex", interrupt) == EXIT_INTERRUPTED
    assert capsys.readouterr().err == "usdmtex: error: interrupted\n"


def run_process(*arguments: str, check_after: str = "pass") -> subprocess.Popen[str]:
    script = f"import sys\nfrom mtex_usd.cli.usdmtex_import import main\ntry: sys.exit(main())\nfinally: {check_after}"
    command = [sys.executable, "-c", script, *arguments]
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)


def test_help_loads_nothing_heavy() -> None:
    heavy = "print([name for name in ('pxr', 'numpy', 'scipy', 'rich') if name in sys.modules])"
    process = run_process("--help", check_after=heavy)
    out, _ = process.communicate()
    assert "usage: usdmtex-import" in out
    assert out.endswith("\n[]\n")
    assert process.returncode == 0


def test_a_closed_pipe_is_no_bug(folder: Path) -> None:
    process = run_process("walk.bvh", "-o", "takes.usd")
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    assert (process.stderr.read(), process.wait()) == ("", EXIT_PIPE)
    process.stderr.close()
