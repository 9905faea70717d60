"""``usdmtex-edit``: edits of motions that were not textured, into an override layer."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from mtex_usd.cli._options import add_anim, add_dry_run, add_output, add_quiet, add_stage
from mtex_usd.cli._run import hold_interrupts, report_note, run_command

if TYPE_CHECKING:
    from mtex_usd.results import EditResult

__all__ = ["main"]

_NAME = "usdmtex-edit"
_EXIT_CODES = (
    "Exit codes: 0 done; 2 bad usage or input; 3 the stage: no such animation, nothing to do, blocked by a stronger "
    "opinion; 4 contacts that cannot be held together; 5 the written result did not validate; 70 a bug."
)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    argv
        Arguments without the command's name; those of the process where None.

    Returns
    -------
    int
        The exit code: 0 done, 2 usage or input, 3 the stage, 4 no solution, 5 the written result did not validate, 70 a
        bug.
    """
    given = sys.argv[1:] if argv is None else list(argv)
    build, run = _COMMANDS.get(given[0], (_build_parser, _apply_edits)) if given else (_build_parser, _apply_edits)
    arguments = build().parse_args(given[1:] if build is not _build_parser else given)
    return run_command(_NAME, lambda: run(arguments))


def _build_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=_NAME,
        usage="%(prog)s [-h] STAGE [-o LAYER] [--anim PRIM]... [--select VARIANT] [--dry-run] [-q]\n"
        "       %(prog)s constrain|contacts ...",
        description="Run the edits that animations of a shot declare (MtexEditStackAPI) and write an override layer "
        "with one variant per stack. Nothing that exists is changed. Two commands do other work: "
        "`constrain` makes animations keep their contacts, `contacts` finds contacts and writes them for editing; "
        "see `%(prog)s constrain --help`.",
        epilog=_EXIT_CODES,
    )
    _add_common(parser)
    add_output(parser, "STAGE's name with .edit.usd")
    parser.add_argument(
        "--select", metavar="VARIANT", help="variant to select: a stack's name, edited or original (default: as before)"
    )
    add_dry_run(parser)
    return parser


def _add_common(parser: argparse.ArgumentParser) -> None:
    add_stage(parser)
    add_anim(parser, "work on this animation only")
    add_quiet(parser)


def _build_constrain_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=f"{_NAME} constrain",
        description="Make animations keep the contacts that MtexContactAPI declares on them, exactly and with the "
        "least change, as a variant beside the original.",
        epilog=_EXIT_CODES,
    )
    _add_common(parser)
    add_output(parser, "STAGE's name with .constrain.usd")
    parser.add_argument("--detect", action="store_true", help="hold the feet that are found on the floor as well")
    parser.add_argument("--select", metavar="VARIANT", help="variant to select: constrained or original")
    add_dry_run(parser)
    return parser


def _build_contacts_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=f"{_NAME} contacts",
        description="Find when the feet of animations stand on the floor, and write it as MtexContactAPI into a layer "
        "to be put among the shot's sublayers and edited.",
        epilog=_EXIT_CODES,
    )
    _add_common(parser)
    parser.add_argument("-o", "--output", type=Path, metavar="LAYER", required=True, help="layer to write")
    return parser


def _apply_edits(arguments: argparse.Namespace) -> int:
    # Imported here: USD, numpy and scipy take far longer to load than --help or a usage error should.
    with hold_interrupts():
        from mtex_usd.api import apply_edits  # noqa: PLC0415

    results = apply_edits(
        arguments.stage,
        out=arguments.output,
        anim=arguments.anim,
        select=arguments.select,
        dry_run=arguments.dry_run,
    )
    if arguments.quiet:
        return 0
    for result in results:
        for note in result.notes:
            report_note(_NAME, f"{result.anim}: {result.variant}: {note}")
        times = result.clip.time_codes
        span = f"{times[0]:g} to {times[-1]:g}"
        print(f"{result.anim}\t{result.model}\t{{{result.variantSet}}}\t{result.variant}\t{span}")
    _report_files(results, arguments)
    return 0


def _report_files(results: "Sequence[EditResult]", arguments: argparse.Namespace) -> None:
    if not arguments.dry_run:
        print(f"wrote {results[0].layer}")
        print(f"open {results[0].stage}")


def _constrain(arguments: argparse.Namespace) -> int:
    with hold_interrupts():
        from mtex_usd.api import constrain  # noqa: PLC0415

    results = constrain(
        arguments.stage,
        out=arguments.output,
        anim=arguments.anim,
        contacts="detect" if arguments.detect else "declared",
        select=arguments.select,
        dry_run=arguments.dry_run,
    )
    if arguments.quiet:
        return 0
    for result in results:
        print(f"{result.anim}\t{result.model}\t{{{result.variantSet}}}\t{result.variant}")
        worst = max(result.residuals.values(), default=0.0)
        print(f"  {len(result.residuals)} constraints, met within {worst:.2g}")
    _report_files(results, arguments)
    return 0


def _find_contacts(arguments: argparse.Namespace) -> int:
    with hold_interrupts():
        from mtex_usd.api import find_contacts  # noqa: PLC0415

    found = find_contacts(arguments.stage, out=arguments.output, anim=arguments.anim)
    if not arguments.quiet:
        for path in found:
            print(path)
        print(f"wrote {arguments.output}")
    return 0


_COMMANDS = {
    "constrain": (_build_constrain_parser, _constrain),
    "contacts": (_build_contacts_parser, _find_contacts),
}
