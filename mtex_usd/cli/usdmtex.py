"""``usdmtex``: texture and synthesize the sketches of a shot into an override layer."""

import argparse
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from mtex_usd.cli._options import add_anim, add_dry_run, add_output, add_quiet, add_stage, positive
from mtex_usd.cli._progress import show_progress
from mtex_usd.cli._run import hold_interrupts, report_error, report_note, run_command

if TYPE_CHECKING:
    from mtex_usd.results import Result, Retarget

__all__ = ["main"]

_NAME = "usdmtex"
_EXIT_SOME_LEFT_OUT = 3


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    argv
        Arguments without the command's name; those of the process where None.

    Returns
    -------
    int
        The exit code: 0 done, 2 usage or input, 3 the stage, 5 the written result did not validate, 70 a bug.
    """
    arguments = _build_parser().parse_args(argv)
    arguments.command = shlex.join([_NAME, *(sys.argv[1:] if argv is None else argv)])
    return run_command(_NAME, lambda: _process(arguments))


class _PrintPluginPath(argparse.Action):
    """Print where the USD plugin is, and end; needs no stage."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        """Print the path; ends the process."""
        from mtex_usd.plugin_path import plugin_path  # noqa: PLC0415

        print(plugin_path())
        parser.exit()


def _build_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=_NAME,
        description="Read the recipe that a shot's sketches carry (MtexSketchAPI), find matching motion in recorded "
        "takes, and write an override layer with one variant per candidate path. Nothing that exists is changed.",
        epilog="Exit codes: 0 done; 2 bad usage or input; 3 the stage: no recipe, no animation, blocked by a stronger "
        "opinion; 4 contacts that cannot be held together; 5 the written result did not validate; 70 a bug.",
    )
    add_stage(parser)
    add_output(parser, "STAGE's name with .mtex.usd")
    _add_recipe_options(parser)
    parser.add_argument(
        "--select",
        metavar="VARIANT",
        help="variant to select, such as path_02 or original (default: as before, else path_01)",
    )
    parser.add_argument("--json", type=Path, metavar="F", help="write the fragment table to F; - for standard output")
    _add_presentation_options(parser)
    add_dry_run(parser)
    parser.add_argument(
        "--print-plugin-path", nargs=0, action=_PrintPluginPath, help="print the path for PXR_PLUGINPATH_NAME"
    )
    volume = parser.add_mutually_exclusive_group()
    add_quiet(volume)
    volume.add_argument("-v", "--verbose", action="store_true", help="print every fragment as well")
    return parser


def _add_recipe_options(parser: argparse.ArgumentParser) -> None:
    add_anim(parser, "work on this sketch only")
    parser.add_argument("--paths", type=positive, metavar="P", help="how many variants, instead of mtex:paths")
    parser.add_argument(
        "--candidates", type=positive, metavar="K", help="matches kept per fragment, instead of mtex:candidates"
    )
    parser.add_argument("--band", type=positive, metavar="B", help="match band, instead of mtex:matchBand")


def _add_presentation_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--timeline", type=Path, metavar="F.otio", help="write the paths as a timeline, for editing and usdmtex-conform"
    )
    parser.add_argument("--report", type=Path, metavar="F.html", help="write a review page: one file, opens offline")
    parser.add_argument("--sheet", type=Path, metavar="F.png", help="write a contact sheet of strobed figures")


def _process(arguments: argparse.Namespace) -> int:
    # Imported here: USD, numpy and scipy take far longer to load than --help or a usage error should.
    with hold_interrupts():
        from mtex_usd.api import find_outputs, process  # noqa: PLC0415
        from mtex_usd.cli._table import check_json_target, write_json  # noqa: PLC0415

    if arguments.json:
        beside = (arguments.timeline, arguments.report, arguments.sheet)
        outputs = find_outputs(arguments.stage, out=arguments.output)
        check_json_target(arguments.json, [*outputs, *(file for file in beside if file is not None)])
    with show_progress("reading the shot", quiet=arguments.quiet) as progress:
        results = process(
            arguments.stage,
            out=arguments.output,
            anim=arguments.anim,
            paths=arguments.paths,
            candidates=arguments.candidates,
            band=arguments.band,
            select=arguments.select,
            timeline=arguments.timeline,
            report=arguments.report,
            sheet=arguments.sheet,
            command=arguments.command,
            dry_run=arguments.dry_run,
            progress=progress,
        )
    if arguments.json:
        write_json(arguments.json, results)
    if not arguments.quiet:
        _report(results, arguments)
    for message in results[0].left_out:
        report_error(_NAME, message)
    return _EXIT_SOME_LEFT_OUT if results[0].left_out else 0


def _report(results: "Sequence[Result]", arguments: argparse.Namespace) -> None:
    """Print notes on stderr, and on stdout what was made, unless the JSON goes there."""
    for result in results:
        for note in result.notes:
            report_note(_NAME, f"{result.anim}: {note}")
        for retarget in result.retargets:
            report_note(_NAME, f"{result.anim}: {retarget}")
            _report_joints(retarget, arguments)
    if arguments.json == Path("-"):
        return
    for result in results:
        print(f"{result.anim}\t{result.model}\t{{{result.variantSet}}}")
        for variant in result.variants:
            print(f"  {variant.name}\tdistance {variant.distance:.6g}\t{_count(variant.zeroCostJoins)}")
            for fragment in variant.fragments if arguments.verbose else ():
                print(
                    "    {start:g} to {end:g}\t{take}\t{takeStart:g} to {takeEnd:g}\tscale {scale:.3g}".format(
                        **fragment
                    )
                )
    if not arguments.dry_run:
        for file in (results[0].layer, arguments.timeline, arguments.report, arguments.sheet):
            if file:
                print(f"wrote {file}")
        print(f"open {results[0].stage}")


def _report_joints(retarget: "Retarget", arguments: argparse.Namespace) -> None:
    """List on stderr what follows what and what follows nothing, where that is asked for."""
    if not arguments.verbose:
        return
    for joint, sources in retarget.mapped.items():
        weighed = {_last_name(name): weight for name, weight in sources.items()}
        followed = " + ".join(name if weight == 1.0 else f"{weight:.2g} {name}" for name, weight in weighed.items())
        print(f"  {_last_name(joint)} follows {followed}", file=sys.stderr)
    print(f"  nothing moves: {', '.join(map(_last_name, retarget.unmapped)) or 'none'}", file=sys.stderr)
    print(f"  of the take unused: {', '.join(map(_last_name, retarget.unused)) or 'none'}", file=sys.stderr)


def _last_name(joint: str) -> str:
    return joint.rpartition("/")[2]


def _count(joins: int) -> str:
    return f"{joins} consecutive join{'' if joins == 1 else 's'}"
