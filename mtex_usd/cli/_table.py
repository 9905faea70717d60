"""The fragment table as JSON."""

import json
import os
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

from mtex_usd.errors import InputError
from mtex_usd.results import Result

__all__ = ["check_json_target", "write_json", "write_table"]

VERSION = 1
_STANDARD_OUTPUT = Path("-")


def check_json_target(file_path: Path, layers: Sequence[Path]) -> None:
    """Refuse a file that cannot be written, that is not a table of ours, or that is going to be a layer.

    Parameters
    ----------
    file_path
        Where the table is asked for; ``-`` for standard output.
    layers
        The files that the same run is going to write.

    Raises
    ------
    InputError
        Naming the file and what is wrong.
    """
    if file_path == _STANDARD_OUTPUT:
        return
    if not file_path.parent.is_dir():
        raise InputError(f"cannot write {file_path}", expected="an existing folder", found=str(file_path.parent))
    if not os.access(file_path.parent, os.W_OK | os.X_OK):
        raise InputError(f"cannot write {file_path}: folder {file_path.parent} is not writable")
    _check_existing(file_path)
    if file_path.resolve() in [layer.resolve() for layer in layers]:
        raise InputError(f"{file_path} cannot be both a layer and the table", fix="Choose another name for --json.")


def _check_existing(file_path: Path) -> None:
    if file_path.exists() and not _is_table(file_path):
        raise InputError(f"{file_path} exists and is not a table of usdmtex", fix="Choose another name for --json.")


def _is_table(file_path: Path) -> bool:
    try:
        return set(json.loads(file_path.read_text())) == {"version", "results"}
    except (OSError, ValueError, TypeError):
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
    try:
        _replace(file_path, text)
    except OSError as error:
        raise InputError(f"cannot write {file_path}: {error.strerror}") from error


def _describe(result: Result) -> dict[str, object]:
    return {
        "anim": result.anim,
        "model": result.model,
        "variantSet": result.variantSet,
        "retargets": [asdict(retarget) for retarget in result.retargets],
        "variants": [variant.custom_data for variant in result.variants],
    }


def _replace(file_path: Path, text: str) -> None:
    handle, temporary = tempfile.mkstemp(dir=file_path.parent, prefix=f".{file_path.name}.")
    try:
        with os.fdopen(handle, "w") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        Path(temporary).chmod(0o644)
        Path(temporary).replace(file_path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
