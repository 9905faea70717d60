"""The fragment table as JSON."""

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

from mtex_usd.files import check_distinct, check_ours, check_place, replace_file
from mtex_usd.results import Result

__all__ = ["check_json_target", "write_json", "write_table"]

VERSION = 1
_WHAT = "table"
_STANDARD_OUTPUT = Path("-")


def check_json_target(file_path: Path, others: Sequence[Path]) -> None:
    """Refuse a file that cannot be written, is not a table of ours, or is something else to the same run.

    Parameters
    ----------
    file_path
        Where the table is asked for; ``-`` for standard output.
    others
        The other files that the same run is going to write.

    Raises
    ------
    InputError
        Naming the file and what is wrong.
    """
    if file_path == _STANDARD_OUTPUT:
        return
    check_place(file_path, what=_WHAT)
    check_ours(file_path, what=_WHAT, is_ours=_is_table)
    check_distinct(file_path, others, what=_WHAT)


def _is_table(file_path: Path) -> bool:
    try:
        return set(json.loads(file_path.read_text())) == {"version", "results"}
    except (ValueError, TypeError, RecursionError):
        return False


def write_json(file_path: Path, results: Sequence[Result]) -> None:
    """Write ``{version, results: [{anim, model, variantSet, retargets, variants: [customData of each]}]}``.

    Parameters
    ----------
    file_path
        Replaced whole or not at all; ``-`` for standard output.
    results
        What :func:`mtex_usd.process` gave.
    """
    write_table(file_path, [_describe(result) for result in results])


def write_table(file_path: Path, rows: Sequence[Mapping[str, object]]) -> None:
    """Write ``{version, results: [...]}``.

    Parameters
    ----------
    file_path
        Replaced whole or not at all; ``-`` for standard output.
    rows
        One per result.
    """
    text = json.dumps({"version": VERSION, "results": list(rows)}, indent=2) + "\n"
    if file_path == _STANDARD_OUTPUT:
        sys.stdout.write(text)
        return
    replace_file(file_path, text.encode())


def _describe(result: Result) -> dict[str, object]:
    return {
        "anim": result.anim,
        "model": result.model,
        "variantSet": result.variantSet,
        "retargets": [asdict(retarget) for retarget in result.retargets],
        "variants": [variant.custom_data for variant in result.variants],
    }
