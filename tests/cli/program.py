"""Running the commands as people do: the installed script, or its entry point where nothing is installed."""

import os
import pty
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

__all__ = ["Done", "run_on_terminal", "run_program"]

PROJECT = Path(__file__).resolve().parents[2]
_ENTRY = "import sys; from mtex_usd.cli.usdmtex import main; sys.exit(main())"


@dataclass(frozen=True)
class Done:
    """How a program ended."""

    code: int
    out: str
    err: str


def _command(arguments: tuple[str, ...]) -> list[str]:
    script = Path(sys.executable).with_name("usdmtex")
    return [str(script), *arguments] if script.is_file() else [sys.executable, "-c", _ENTRY, *arguments]


def _environment(**variables: str) -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(PROJECT), **variables}


def run_program(*arguments: str, folder: Path, **variables: str) -> Done:
    """Run ``usdmtex`` in a folder and an environment, its output going into pipes."""
    done = subprocess.run(
        _command(arguments), cwd=folder, env=_environment(**variables), capture_output=True, text=True, check=False
    )
    return Done(done.returncode, done.stdout, done.stderr)


def run_on_terminal(*arguments: str, folder: Path) -> Done:
    """Run ``usdmtex`` with a terminal for its errors; standard output still goes into a pipe."""
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        _command(arguments),
        cwd=folder,
        env=_environment(TERM="xterm"),
        stdout=subprocess.PIPE,
        stderr=theirs,
        text=True,
    )
    os.close(theirs)
    shown = _read_all(ours)
    out, _ = process.communicate()
    os.close(ours)
    return Done(process.returncode, out, shown)


def _read_all(descriptor: int) -> str:
    pieces = []
    try:
        while piece := os.read(descriptor, 4096):
            pieces.append(piece)
    except OSError:  # how Linux says that the other end of a terminal is closed
        pass
    return b"".join(pieces).decode()
