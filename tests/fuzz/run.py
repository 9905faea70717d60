"""Damaged files by the thousands: ``python -m tests.fuzz.run [--count 10000] [--seed S] [--format F]``.

Every file is read in a process of its own kind with bounds on its memory and time, so that a reader which crashes or
hangs is a finding like any other. Prints a table; the exit code is 1 where there are findings. A finding is told by its
format, seed and number: ``--case usdc/0/1234`` runs that one alone, and ``--keep FILE`` writes what it is about.
"""

import argparse
import json
import select
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

from tests.conftest import PROJECT
from tests.fuzz.cases import make_case
from tests.fuzz.corpus import KINDS, USD_KINDS
from tests.fuzz.worker import MEMORY_LIMIT

__all__ = ["Tally", "main", "run_kind"]

TIME_LIMIT_S = 60.0
"""A file that takes longer, read alone and by the command on a busy machine, counts as hanging."""

_START_LIMIT_S = 120.0
_PEAK_LIMIT = 1 << 30  # bytes above what the process held before; USD takes what its process may have
_SHOWN = 10


@dataclass
class Tally:
    """What became of the damaged files of a kind."""

    kind: str
    outcomes: Counter[str] = field(default_factory=Counter)
    imports: int = 0
    slowest: tuple[float, int] = (0.0, -1)
    largest: tuple[int, int] = (0, -1)
    findings: list[tuple[int, str]] = field(default_factory=list)

    def add(self, result: dict[str, Any]) -> None:
        """Count one case."""
        number, outcome = result["number"], result["outcome"]
        if result.get("memory", 0) > (MEMORY_LIMIT if self.kind in USD_KINDS else _PEAK_LIMIT):
            outcome, result["what"] = "defect", f"took {result['memory'] >> 20} MiB"
        self.outcomes[outcome] += 1
        self.imports += bool(result.get("imported"))
        self.slowest = max(self.slowest, (result.get("seconds", 0.0), number))
        self.largest = max(self.largest, (result.get("memory", 0), number))
        if outcome not in {"read", "refused"}:
            self.findings.append((number, f"{outcome}: {result.get('what', '')}"))


def run_kind(kind: str, *, seed: int, first: int, last: int, import_every: int, bare: bool = False) -> Tally:
    """Run a range of cases of a kind; a worker that dies is replaced.

    Parameters
    ----------
    kind
        One of `KINDS`.
    seed, first, last
        Which cases, `last` left out.
    import_every
        Every so many go through the whole command as well; none where 0.
    bare
        Whether stages are read in the worker itself.
    """
    tally = Tally(kind)
    while first < last:
        for result in _watch(kind, seed, first, last, import_every, bare):
            tally.add(result)
            first = result["number"] + 1
    return tally


def _watch(kind: str, *numbers: int) -> Iterator[dict[str, Any]]:
    """Give the results of one worker, the last of which may be its end."""
    arguments = [kind, *(str(int(number)) for number in numbers)]
    command = [sys.executable, "-W", "error", "-m", "tests.fuzz.worker", *arguments]
    with (
        tempfile.TemporaryFile() as errors,
        subprocess.Popen(command, cwd=PROJECT, stdout=subprocess.PIPE, stderr=errors, bufsize=0) as worker,
    ):
        assert worker.stdout is not None
        try:
            yield from _follow(worker, worker.stdout, errors, numbers[1])
        finally:
            worker.kill()


def _follow(
    worker: subprocess.Popen[bytes], lines: IO[bytes], errors: IO[bytes], first: int
) -> Iterator[dict[str, Any]]:
    number, patience, started = first, _START_LIMIT_S, False
    while True:
        if not select.select([lines], [], [], patience)[0]:
            yield {"number": number, "outcome": "hang", "what": f"more than {patience:g} s"}
            return
        line = lines.readline()
        if not line.endswith(b"\n"):
            break
        result = json.loads(line)
        number, patience, started = result["number"], TIME_LIMIT_S, "outcome" not in result
        if not started:
            yield result
    if started:
        yield {"number": number, "outcome": "crash", "what": f"exit {worker.wait()}; {_last_words(errors)}"}
    elif worker.wait() != 0:
        raise RuntimeError(f"the worker failed between cases: {_last_words(errors)}")


def _last_words(errors: IO[bytes]) -> str:
    errors.seek(0)
    return errors.read()[-600:].decode(errors="replace").strip()


_COLUMNS = ("reader", "mutations", "refused", "read", "imported", "crash", "hang", "defect", "worst s", "peak MiB")


def _row(tally: Tally) -> tuple[str, ...]:
    outcomes = tally.outcomes
    counts = [outcomes.total(), outcomes["refused"], outcomes["read"], tally.imports]
    counts += [outcomes[name] for name in ("crash", "hang", "defect")]
    return (tally.kind, *map(str, counts), f"{tally.slowest[0]:.2f}", f"{tally.largest[0] / 2**20:.0f}")


def _print_row(cells: Sequence[str]) -> None:
    print("  ".join(cell.rjust(9) for cell in cells), flush=True)


def _parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Read damaged files by the thousands.")
    parser.add_argument("--count", type=int, default=10_000, help="damaged files for each reader (default: 10000)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--format", choices=KINDS, action="append", help="only this one; may be given several times")
    parser.add_argument(
        "--import-every", type=int, default=100, help="one in so many through the command (default: 100)"
    )
    parser.add_argument(
        "--bare", action="store_true", help="read stages without the child process, to see what USD does alone"
    )
    parser.add_argument("--case", metavar="FORMAT/SEED/NUMBER", help="one case alone")
    parser.add_argument("--keep", type=Path, metavar="FILE", help="with --case: write the damaged file")
    return parser.parse_args(arguments)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the cases, print and judge."""
    options = _parse(arguments)
    if options.case:
        return _run_one(options.case, options.keep)
    _print_row(_COLUMNS)
    tallies = []
    for kind in options.format or KINDS:
        every = 0 if options.bare else options.import_every
        found = run_kind(kind, seed=options.seed, first=0, last=options.count, import_every=every, bare=options.bare)
        tallies.append(found)
        _print_row(_row(tallies[-1]))
    return _report(tallies, options.seed)


def _run_one(name: str, keep: Path | None) -> int:
    kind, seed, number = name.split("/")
    case = make_case(kind, int(seed), int(number))
    if keep is not None:
        keep.write_bytes(case.content)
    tally = run_kind(kind, seed=case.seed, first=case.number, last=case.number + 1, import_every=1)
    print(f"{name}, from {case.specimen.name}, {len(case.content)} bytes: {dict(tally.outcomes)}")
    return _report([tally], case.seed)


def _report(tallies: Sequence[Tally], seed: int) -> int:
    for tally in tallies:
        for number, what in tally.findings[:_SHOWN]:
            print(f"\n--case {tally.kind}/{seed}/{number}\n{what}")
        if len(tally.findings) > _SHOWN:
            print(f"\n{tally.kind}: {len(tally.findings) - _SHOWN} more")
    return int(any(tally.findings for tally in tallies))


if __name__ == "__main__":
    sys.exit(main())
