"""The process in which damaged files are read: ``python -m tests.fuzz.worker KIND SEED FIRST LAST IMPORT_EVERY BARE``.

Prints a line of JSON before each case, with its number alone, and one after it. It may not survive; run.py looks on.
"""

import json
import resource
import sys
import tempfile
import traceback
from pathlib import Path

from tests.fuzz.cases import import_case, make_case, measure, read_case, read_usd_here

__all__ = ["MEMORY_LIMIT", "main"]

MEMORY_LIMIT = 4 << 30
"""Address space of the process in bytes, of which USD and its threads take one GiB before anything is read."""

_SHOWN = 4000


def _run(kind: str, seed: int, number: int, *, imports: bool) -> dict[str, object]:
    case = make_case(kind, seed, number)
    with tempfile.TemporaryDirectory() as folder:
        try:
            found, seconds, memory = measure(read_case, case, Path(folder))
        except Exception:  # whatever it is, it is a finding
            return {"outcome": "defect", "what": traceback.format_exc()[-_SHOWN:]}
    with tempfile.TemporaryDirectory() as folder:
        try:
            if imports:
                import_case(case, Path(folder))
        except Exception:
            return {"outcome": "defect", "what": traceback.format_exc()[-_SHOWN:]}
    return {"outcome": "read" if found else "refused", "seconds": seconds, "memory": memory, "imported": imports}


def main() -> None:
    """Run the cases that the arguments name."""
    kind, (seed, first, last, import_every, bare) = sys.argv[1], map(int, sys.argv[2:])
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_LIMIT, MEMORY_LIMIT))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if bare:
        read_usd_here()
    results = sys.stdout
    for number in range(first, last):
        print(json.dumps({"number": number}), file=results, flush=True)
        found = _run(kind, seed, number, imports=bool(import_every) and number % import_every == 0)
        print(json.dumps({"number": number} | found), file=results, flush=True)


if __name__ == "__main__":
    main()
