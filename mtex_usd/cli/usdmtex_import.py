"""``usdmtex-import``: recorded motions of any known format into a take library."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from mtex_usd.cli._options import add_quiet
from mtex_usd.cli._progress import show_progress
from mtex_usd.cli._run import hold_interrupts, report_error, report_note, run_command

if TYPE_CHECKING:
    from mtex_usd.importing import CleanedTake, ImportResult
    from mtex_usd.usd.take_entries import TakeEntry

__all__ = ["main"]

_NAME = "usdmtex-import"
_EXIT_SOME_FAILED = 2


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    argv
        Arguments without the command's name; those of the process where None.

    Returns
    -------
    int
        The exit code: 0 done, 2 bad usage or input, also where only some files failed, 70 a bug.
    """
    parser = _build_parser()
    arguments = parser.parse_args(argv)
    _check_usage(parser, arguments)
    return run_command(_NAME, lambda: _list(arguments) if arguments.list else _import(arguments))


def _build_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=_NAME,
        description="Add recorded motions (BVH, ASF/AMC, glTF, USD; told by content, not by name) as takes to a USD "
        "file: a Skeleton per distinct skeleton and a SkelAnimation per motion, for use as mtex:takes of a sketch.",
        epilog="Exit codes: 0 done; 2 bad usage or input (the good files are still written, unless --strict or there "
        "are none); 70 a bug.",
    )
    parser.add_argument(
        "files", nargs="*", type=Path, metavar="FILE", help="motion files, folders of them, or patterns in quotes"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="TAKES.usd",
        help="take library (.usd, .usdc or .usda); one that is there gets the takes added, and none twice",
    )
    parser.add_argument("--list", action="store_true", help="show what is in a library instead of importing")
    _add_reading_options(parser)
    _add_take_options(parser)
    volume = parser.add_mutually_exclusive_group()
    add_quiet(volume)
    volume.add_argument("-v", "--verbose", action="store_true", help="print the skeleton of each take as well")
    return parser


def _add_reading_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--meters-per-unit",
        type=float,
        default=0.01,
        metavar="X",
        help="length in metres of a unit of BVH files; other files say it (default: 0.01)",
    )
    parser.add_argument(
        "--up-axis", type=str.upper, choices=("Y", "Z"), default="Y", help="up axis of BVH and ASF files (default: Y)"
    )
    parser.add_argument(
        "--rate",
        type=float,
        metavar="FPS",
        help="frames/s of AMC files that do not say (default: 120), and to sample glTF at (default: that of its keys, "
        "30 where they are uneven)",
    )
    parser.add_argument(
        "--skeleton", type=Path, metavar="F.asf", help="skeleton of AMC files (default: the .asf file beside each)"
    )
    parser.add_argument(
        "--skip-frames", type=int, default=0, metavar="N", help="leave out the first N frames, such as a T-pose"
    )
    parser.add_argument(
        "--clean",
        default="",
        metavar="STEPS",
        help="clean the takes: auto, or steps in their order, such as leading,flips (all: leading, gaps, flips, "
        "spikes, jumps, noise, floor)",
    )


def _add_take_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--style", default="", metavar="TOKEN", help="mtex:take:style of the takes")
    parser.add_argument("--licence", default="", metavar="TEXT", help="note on the terms, kept with every take")
    parser.add_argument("--replace", action="store_true", help="begin the library anew instead of adding to it")
    parser.add_argument("--strict", action="store_true", help="write nothing unless every file can be read")


def _check_usage(parser: argparse.ArgumentParser, arguments: argparse.Namespace) -> None:
    if arguments.list:
        if not arguments.files and arguments.output is None:
            parser.error("--list needs a library: --list TAKES.usd")
        return
    missing = [name for name, given in (("FILE", arguments.files), ("-o/--output", arguments.output)) if not given]
    if missing:
        parser.error(f"the following arguments are required: {', '.join(missing)}")


def _import(arguments: argparse.Namespace) -> int:
    # Imported here: USD and numpy take far longer to load than --help or a usage error should.
    with hold_interrupts():
        from mtex_usd.api import import_takes  # noqa: PLC0415

    with show_progress("reading", quiet=arguments.quiet) as progress:
        result = import_takes(
            arguments.files,
            out=arguments.output,
            meters_per_unit=arguments.meters_per_unit,
            up_axis=arguments.up_axis,
            rate=arguments.rate,
            skeleton=arguments.skeleton,
            skip_frames=arguments.skip_frames,
            clean=[step.strip() for step in arguments.clean.split(",") if step.strip()],
            style=arguments.style,
            licence=arguments.licence,
            replace_library=arguments.replace,
            strict=arguments.strict,
            progress=progress,
        )
    return _report(result, quiet=arguments.quiet, verbose=arguments.verbose)


def _report(result: "ImportResult", *, quiet: bool, verbose: bool) -> int:
    for take in () if quiet else result.takes:
        line = f"{take.prim_path}\t{take.frame_count} frames\t{take.rate:.6g}/s\t{take.source}"
        print(f"{line}\t{take.skeleton_path}" if verbose else line)
    for cleaned in () if quiet else result.cleaned:
        _report_cleaning(cleaned)
    for note in () if quiet else result.notes:
        report_note(_NAME, note)
    for failure in result.failures:
        report_error(_NAME, str(failure))
    return _EXIT_SOME_FAILED if result.failures else 0


def _report_cleaning(cleaned: "CleanedTake") -> None:
    """Print a line for each change and each thing left, frames counted from 0 in the file."""
    for change in cleaned.changes:
        print(f"{cleaned.prim_path}\tcleaned\t{change}")
    if not cleaned.changes:
        print(f"{cleaned.prim_path}\tcleaned\tnothing to change")
    for note in cleaned.notes:
        print(f"{cleaned.prim_path}\tleft\t{note}")


def _list(arguments: argparse.Namespace) -> int:
    with hold_interrupts():
        from mtex_usd.api import list_takes  # noqa: PLC0415

    for file_path in arguments.files or [arguments.output]:
        entries = list_takes(file_path)
        if len(arguments.files) > 1:
            print(f"{file_path}:")
        _print_table([_COLUMNS, *(_describe_entry(entry) for entry in entries)])
    return 0


_COLUMNS = ("TAKE", "FRAMES", "RATE", "SECONDS", "JOINTS", "SKELETON", "STYLE", "SOURCE", "SHA256", "LICENCE")


def _describe_entry(entry: "TakeEntry") -> tuple[str, ...]:
    source = f"{entry.source} ({entry.clip})" if entry.clip else entry.source
    return (
        entry.prim_path,
        str(entry.frame_count),
        f"{entry.rate:.6g}",
        f"{max(entry.frame_count - 1, 0) / entry.rate:.2f}" if entry.rate > 0.0 else "",
        str(entry.joint_count),
        entry.skeleton_path.rpartition("/")[2],
        entry.style,
        source,
        entry.sha256[:12],
        entry.licence,
    )


def _print_table(rows: Sequence[Sequence[str]]) -> None:
    """Print rows in columns as wide as they need; what is empty is a dash, so that every row has all columns."""
    filled = [[cell or "-" for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*filled, strict=True)]
    for row in filled:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())
