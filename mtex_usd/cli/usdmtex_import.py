"""``usdmtex-import``: recorded motions (BVH) to a USD file of takes."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from mtex_usd.cli._progress import show_progress
from mtex_usd.cli._run import report_error, run_command

if TYPE_CHECKING:
    from mtex_usd.api import ImportResult

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
    arguments = _build_parser().parse_args(argv)
    return run_command(_NAME, lambda: _import(arguments))


def _build_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=_NAME,
        description="Write recorded motions as takes into one USD file: a Skeleton per distinct skeleton and a "
        "SkelAnimation per file, for use as mtex:takes of a sketch.",
        epilog="Exit codes: 0 done; 2 bad usage or input (the good files are still written, unless --strict or there "
        "are none); 70 a bug.",
    )
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE.bvh", help="BVH files")
    parser.add_argument(
        "-o", "--output", required=True, type=Path, metavar="TAKES.usd", help="file to write (.usd, .usdc or .usda)"
    )
    _add_reading_options(parser)
    volume = parser.add_mutually_exclusive_group()
    volume.add_argument("-q", "--quiet", action="store_true", help="print errors only")
    volume.add_argument("-v", "--verbose", action="store_true", help="print the skeleton of each take as well")
    return parser


def _add_reading_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--meters-per-unit", type=float, default=0.01, metavar="X", help="length of a unit in metres (default: 0.01)"
    )
    parser.add_argument("--up-axis", type=str.upper, choices=("Y", "Z"), default="Y", help="up axis (default: Y)")
    parser.add_argument(
        "--skip-frames", type=int, default=0, metavar="N", help="leave out the first N frames, such as a T-pose"
    )
    parser.add_argument("--style", default="", metavar="TOKEN", help="mtex:take:style of the takes")
    parser.add_argument("--strict", action="store_true", help="write nothing unless every file can be read")


def _import(arguments: argparse.Namespace) -> int:
    # Imported here: USD and numpy take far longer to load than --help or a usage error should.
    from mtex_usd.api import import_takes  # noqa: PLC0415

    with show_progress("reading", quiet=arguments.quiet) as progress:
        result = import_takes(
            arguments.files,
            out=arguments.output,
            meters_per_unit=arguments.meters_per_unit,
            up_axis=arguments.up_axis,
            skip_frames=arguments.skip_frames,
            style=arguments.style,
            strict=arguments.strict,
            progress=progress,
        )
    return _report(result, quiet=arguments.quiet, verbose=arguments.verbose)


def _report(result: "ImportResult", *, quiet: bool, verbose: bool) -> int:
    for take in () if quiet else result.takes:
        line = f"{take.prim_path}\t{take.frame_count} frames\t{take.rate:.6g}/s\t{take.source}"
        print(f"{line}\t{take.skeleton_path}" if verbose else line)
    for failure in result.failures:
        report_error(_NAME, str(failure))
    return _EXIT_SOME_FAILED if result.failures else 0
