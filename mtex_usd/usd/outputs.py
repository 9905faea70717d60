"""What a command leaves of a shot: which override layer it writes, and that written and checked."""

from collections.abc import Sequence
from pathlib import Path

from pxr import Usd

from mtex_usd.usd.arguments import FilePath, as_file_path
from mtex_usd.usd.characters import Character
from mtex_usd.usd.check import check_override
from mtex_usd.usd.override import ORIGINAL, CharacterResult, check_outputs, write_override
from mtex_usd.usd.selection import check_selection
from mtex_usd.usd.source_stage import SourceStage

__all__ = ["find_output", "write_outputs"]


def find_output(source: SourceStage, out: FilePath | None, *, word: str, maker: str) -> Path:
    """Give the override layer that a command is to write, which can be written.

    Parameters
    ----------
    source
        The shot.
    out
        What the caller asks for; None for ``<shot>.<word>.usd`` beside the shot.
    word
        What the command does.
    maker
        The command.

    Raises
    ------
    InputError
        Where `out` is no path of a file, and as :func:`mtex_usd.usd.override.check_outputs`.
    """
    shot = source.source_path
    target = shot.with_name(f"{shot.stem}.{word}.usd") if out is None else as_file_path(out, "out")
    check_outputs(target, maker=maker)
    return target


def write_outputs(
    stage: Usd.Stage,
    results: Sequence[CharacterResult],
    out: Path,
    *,
    maker: str,
    select: str | None,
    keep: Sequence[Character] = (),
    dry_run: bool,
) -> None:
    """Write the override layer and the thin root, and check that they read back as computed.

    Parameters
    ----------
    stage, results, out, maker, select, keep
        As for :func:`mtex_usd.usd.override.write_override`.
    dry_run
        Only check that each of `results` has the variant to select.

    Raises
    ------
    InputError, StageError, ResultError
        As :func:`mtex_usd.usd.override.write_override` and :func:`mtex_usd.usd.check.check_override`.
    """
    for each in results:
        check_selection(select, (ORIGINAL, *each.names), each.character.animation)
    if not dry_run:
        _, root = write_override(stage, results, out, maker=maker, select=select, keep=keep)
        check_override(root, results)
