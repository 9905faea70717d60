"""``usdmtex-edit``: edits of motions that were not textured, into an override layer."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from mtex_usd.cli._run import hold_interrupts, run_command

__all__ = ["main"]

_NAME = "usdmtex-edit"


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
    arguments = _build_parser().parse_args(argv)
    return run_command(_NAME, lambda: int(arguments.run(arguments)))


def _build_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=_NAME,
        description="Edit animations of a shot without changing what exists.",
        epilog="Exit codes: 0 done; 2 bad usage or input; 3 the stage: no such animation, blocked by a stronger "
        "opinion; 4 contacts that cannot be held together; 5 the written result did not validate; 70 a bug.",
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    _add_constrain(commands)
    _add_contacts(commands)
    return parser


def _add_stage(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("stage", type=Path, metavar="STAGE", help="the shot, or the .stage.usda of an earlier run")
    parser.add_argument(
        "--anim", action="append", default=[], metavar="PRIM", help="work on this animation only; may be repeated"
    )
    parser.add_argument("-q", "--quiet", action="store_true", help="print errors only")


def _add_constrain(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser(
        "constrain",
        help="make animations keep their contacts",
        description="Make animations keep the contacts that MtexContactAPI declares on them, exactly and with the "
        "least change, as a variant beside the original.",
    )
    _add_stage(parser)
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="LAYER",
        help="override layer to write (default: STAGE's name with .edit.usd)",
    )
    parser.add_argument("--detect", action="store_true", help="hold the feet that are found on the floor as well")
    parser.add_argument("--select", metavar="VARIANT", help="variant to select: constrained or original")
    parser.add_argument("--dry-run", action="store_true", help="do everything but write")
    parser.set_defaults(run=_constrain)


def _add_contacts(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser(
        "contacts",
        help="find contacts and write them for editing",
        description="Find when the feet of animations stand on the floor, and write it as MtexContactAPI into a layer "
        "to be put among the shot's sublayers and edited.",
    )
    _add_stage(parser)
    parser.add_argument("-o", "--output", type=Path, metavar="LAYER", required=True, help="layer to write")
    parser.set_defaults(run=_find_contacts)


def _constrain(arguments: argparse.Namespace) -> int:
    # Imported here: USD, numpy and scipy take far longer to load than --help or a usage error should.
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
    if not arguments.dry_run:
        print(f"wrote {results[0].layer}")
        print(f"open {results[0].stage}")
    return 0


def _find_contacts(arguments: argparse.Namespace) -> int:
    with hold_interrupts():
        from mtex_usd.api import find_contacts  # noqa: PLC0415

    found = find_contacts(arguments.stage, out=arguments.output, anim=arguments.anim)
    if not arguments.quiet:
        for path in found:
            print(path)
        print(f"wrote {arguments.output}", file=sys.stdout)
    return 0
