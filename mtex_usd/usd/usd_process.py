"""Reading strangers' stages in a process of their own, which may die without taking the import along.

USD's crate reader trusts what it reads. Of 2,800 crate files of 3 to 12 kB with one to sixteen bits flipped, three
ended the process by SIGSEGV or SIGABRT, and memory is bounded only by the machine's (usd-core 26.11). The child is
started for the first stage, serves all, and is started anew after one that it did not survive. It sees files as they
are on the disk, and plugins and resolvers that the environment names.
"""

import os
import pickle
import re
import signal
import subprocess
import sys
import tempfile
import threading
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import IO

from mtex_usd.formats.recording import FormatError
from mtex_usd.usd.usd_takes import UsdTakes, read_usd

__all__ = ["DEFAULT_TIME_LIMIT_S", "UsdReader", "default_memory_limit", "serve"]

DEFAULT_TIME_LIMIT_S = 600.0
"""How long USD may take for one stage with all that it refers to."""

_LEAST_MEMORY = 4 << 30
_START_LIMIT_S = 120.0
_PYTHON = re.compile(r"py|ython")  # python, pypy, mayapy, hython; not maya or houdini, which would open their windows
_SERVE = (
    "import signal, sys; signal.signal(signal.SIGINT, signal.SIG_IGN); sys.path[:] = {path!r}; "
    "from mtex_usd.usd.usd_process import serve; serve({memory_limit!r})"
)


def default_memory_limit() -> int:
    """Give half of the machine's memory in bytes, at least 4 GiB: the address space that reading may take."""
    try:
        machine = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):  # Windows, where nothing enforces a limit either
        machine = 0
    return max(_LEAST_MEMORY, machine // 2)


class UsdReader:
    """Reads stages as :func:`mtex_usd.usd.usd_takes.read_usd` does, in a child process; a context manager.

    In a program whose ``sys.executable`` is no Python there is no child to start, and stages are read in the program
    itself.

    Parameters
    ----------
    time_limit_s
        Seconds that one stage may take.
    memory_limit
        Bytes of address space of the child, where the system enforces such limits; half of the machine's where None.
    """

    def __init__(self, *, time_limit_s: float = DEFAULT_TIME_LIMIT_S, memory_limit: int | None = None) -> None:
        self._time_limit_s = time_limit_s
        self._memory_limit = memory_limit or default_memory_limit()
        self._child: _Child | None = None

    def __enter__(self) -> "UsdReader":
        """Give itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the child."""
        self.close()

    @property
    def process_id(self) -> int | None:
        """Of the child; None while there is none."""
        return self._child.process.pid if self._child else None

    def close(self) -> None:
        """End the child; the next stage starts another one."""
        if self._child is not None:
            self._child.end()
        self._child = None

    def read(self, file_path: Path) -> UsdTakes:
        """Read every SkelAnimation of a stage.

        Parameters
        ----------
        file_path
            As :func:`mtex_usd.usd.usd_takes.read_usd` takes it.

        Raises
        ------
        FormatError
            As there; and where USD crashed, ran out of memory or was not through in time.
        """
        if not _PYTHON.search(Path(sys.executable or "").stem.lower()):
            return read_usd(file_path)
        if self._child is None:
            self._child = _Child(self._memory_limit)
        try:
            answer = self._child.ask(file_path, self._time_limit_s)
        except BaseException:
            self.close()
            raise
        if isinstance(answer, UsdTakes):
            return answer
        if isinstance(answer, FormatError):
            raise answer
        raise RuntimeError(f"reading {file_path} failed in the process that reads stages\n{answer}")


class _Child:
    """A process that reads stages one after the other."""

    def __init__(self, memory_limit: int) -> None:
        self.folder = tempfile.TemporaryDirectory()
        log = Path(self.folder.name) / "log"
        code = _SERVE.format(path=sys.path, memory_limit=memory_limit)
        command = [sys.executable, *(f"-W{option}" for option in sys.warnoptions), "-c", code]
        with log.open("wb") as errors:
            self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors)
        self.errors = log.open("rb")  # apart, since the two would share their place in the file
        if self._receive(_START_LIMIT_S) is not None:
            said = self._new_words()
            self.end()
            raise RuntimeError(f"the process that reads stages does not start: {said[-2000:]}")

    def ask(self, file_path: Path, time_limit_s: float) -> object:
        """Give what the child makes of a stage, and pass on what USD says meanwhile."""
        assert self.process.stdin is not None
        with suppress(BrokenPipeError):  # a child that is gone is told by its answer
            pickle.dump(file_path, self.process.stdin)
            self.process.stdin.flush()
        answer = self._receive(time_limit_s)
        said = self._new_words()
        if isinstance(answer, _Death):
            raise FormatError(file_path, None, f"cannot be read: {answer.describe(said)}")
        sys.stderr.write(said)
        return answer

    def _receive(self, time_limit_s: float) -> object:
        assert self.process.stdout is not None
        timer = threading.Timer(time_limit_s, self.process.kill)
        timer.start()
        try:
            return pickle.load(self.process.stdout)
        except (EOFError, pickle.UnpicklingError):  # cut off at any place
            return _Death(self.process.wait(), time_limit_s)
        finally:
            timer.cancel()

    def _new_words(self) -> str:
        return self.errors.read().decode(errors="replace")

    def end(self) -> None:
        self.process.kill()
        with self.folder, self.errors, self.process:
            pass


class _Death:
    """How a child ended."""

    def __init__(self, code: int, time_limit_s: float) -> None:
        self.code = code
        self.time_limit_s = time_limit_s

    def describe(self, said: str) -> str:
        if "bad_alloc" in said:
            return "USD ran out of memory over it; the file is damaged or too large"
        if self.code == -signal.SIGKILL:
            return f"USD was not through with it after {self.time_limit_s:g} s; the file is damaged or too large"
        return f"USD crashed over it ({_name_end(self.code)}); the file is damaged"


def _name_end(code: int) -> str:
    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"exit code {code}"


def serve(memory_limit: int) -> None:
    """Be the child: answer file paths on stdin with takes or errors on stdout, both pickled, until stdin ends.

    Parameters
    ----------
    memory_limit
        Bytes of address space this process may take.
    """
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what anything prints must not come between the answers
    _limit_memory(memory_limit)
    _send(answers, None)
    with suppress(EOFError):
        while True:
            _send(answers, _answer(pickle.load(sys.stdin.buffer)))


def _send(answers: IO[bytes], answer: object) -> None:
    pickle.dump(answer, answers, protocol=pickle.HIGHEST_PROTOCOL)
    answers.flush()


def _answer(file_path: Path) -> object:
    try:
        return read_usd(file_path)
    except FormatError as error:
        return error
    except MemoryError:
        return FormatError(file_path, None, "cannot be read: USD ran out of memory over it; it is damaged or too large")
    except Exception:  # a bug, for the parent to report
        import traceback  # noqa: PLC0415

        return traceback.format_exc()


def _limit_memory(memory_limit: int) -> None:
    try:
        import resource  # noqa: PLC0415 - not on Windows
    except ImportError:
        return
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    within = memory_limit if hard == resource.RLIM_INFINITY else min(memory_limit, hard)
    with suppress(ValueError, OSError):  # macOS has the name and refuses the limit
        resource.setrlimit(resource.RLIMIT_AS, (within, hard))
