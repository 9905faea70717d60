"""``usdmtex-conform``: the tracks of an edited timeline made into variants of a shot."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from mtex_usd.cli._options import add_anim, add_dry_run, add_output, add_quiet, add_stage
from mtex_usd.cli._run import hold_interrupts, report_note, run_command

if TYPE_CHECKING:
    from mtex_usd.results import Result

__all__ = ["main"]

_NAME = "usdmtex-conform"


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    argv
        Arguments without the command's name; those of the process where None.

    Returns
    -------
    int
        The exit code: 0 done, 2 usage, timeline or other input, 3 the stage, 4 contacts that cannot be held together, 5
        the written result did not validate, 70 a bug.
    """
    arguments = _build_parser().parse_args(argv)
    return run_command(_NAME, lambda: _conform(arguments))


def _build_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=_NAME,
        description="Read an OpenTimelineIO timeline that usdmtex --timeline wrote and somebody edited, and make each "
        "of its tracks into a variant: every clip is a part of a take, stretched into its place on the sketch, joined "
        "and textured as usdmtex does. Nothing that exists is changed.",
        epilog="Exit codes: 0 done; 2 bad usage or input, such as an unknown take, a gap or a wrong length; 3 the "
        "stage: no recipe, no animation, blocked by a stronger opinion; 4 contacts that cannot be held together; 5 the "
        "written result did not validate; 70 a bug.",
    )
    parser.add_argument("timeline", type=Path, metavar="EDIT", help="the edited timeline (.otio)")
    add_stage(parser)
    add_output(parser, "the shot's name with .conform.usd")
    add_anim(parser, "tracks of this sketch only")
    parser.add_argument("--track", action="append", default=[], metavar="NAME", help="this track only; may be repeated")
    parser.add_argument("--select", metavar="VARIANT", help="variant to select: the name of a track, or original")
    add_dry_run(parser)
    add_quiet(parser)
    return parser


def _conform(arguments: argparse.Namespace) -> int:
    # Imported here: USD, numpy and scipy take far longer to load than --help or a usage error should.
    with hold_interrupts():
        from mtex_usd.conforming import conform  # noqa: PLC0415

    results = conform(
        arguments.timeline,
        arguments.stage,
        out=arguments.output,
        anim=arguments.anim,
        tracks=arguments.track,
        select=arguments.select,
        dry_run=arguments.dry_run,
    )
    if not arguments.quiet:
        _report(results)
        if not arguments.dry_run:
            print(f"wrote {results[0].layer}")
            print(f"open {results[0].stage}")
    return 0


def _report(results: "Sequence[Result]") -> None:
    """Print notes on stderr, and on stdout what was made."""
    for result in results:
        for note in result.notes:
            report_note(_NAME, f"{result.anim}: {note}")
    for result in results:
        print(f"{result.anim}\t{result.model}\t{{{result.variantSet}}}")
        for variant in result.variants:
            count = len(variant.fragments)
            fragments = f"{count} fragment{'' if count == 1 else 's'}"
            print(f"  {variant.name}\t{fragments}\tdistance {variant.distance:.6g}")
