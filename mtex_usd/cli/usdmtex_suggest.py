"""``usdmtex-suggest``: which match channels and band to choose, tried out on the takes."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from mtex_usd.cli._options import add_anim, add_quiet, add_stage, positive
from mtex_usd.cli._progress import show_progress
from mtex_usd.cli._run import hold_interrupts, report_error, report_note, run_command

if TYPE_CHECKING:
    from mtex_usd.suggesting import Suggestion, Suggestions

__all__ = ["main"]

_NAME = "usdmtex-suggest"
_EXIT_SOME_LEFT_OUT = 3
_DEFAULT_TOP = 10


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    argv
        Arguments without the command's name; those of the process where None.

    Returns
    -------
    int
        The exit code: 0 done, 2 usage or input, 3 the stage, 70 a bug.
    """
    arguments = _build_parser().parse_args(argv)
    return run_command(_NAME, lambda: _suggest(arguments))


def _build_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=_NAME,
        description="Suggest match channels and a band for the sketches of a shot: every take is held out in turn, "
        "sketched, and found again from the others, and what finds them best comes first.",
        epilog="Exit codes: 0 done; 2 bad usage or input, as fewer than two takes; 3 the stage: no recipe, no "
        "animation; 70 a bug.",
    )
    add_stage(parser)
    add_anim(parser, "work on this sketch only")
    parser.add_argument(
        "--top",
        type=positive,
        default=_DEFAULT_TOP,
        metavar="N",
        help=f"how many suggestions to print (default: {_DEFAULT_TOP})",
    )
    parser.add_argument("--json", type=Path, metavar="F", help="write the table to F; - for standard output")
    parser.add_argument(
        "--apply",
        type=Path,
        metavar="LAYER",
        help="write the first suggestion into a layer, to be put first among the shot's sublayers",
    )
    add_quiet(parser)
    return parser


def _suggest(arguments: argparse.Namespace) -> int:
    # Imported here: USD, numpy and scipy take far longer to load than --help or a usage error should.
    with hold_interrupts():
        from mtex_usd.cli._table import check_json_target, write_table  # noqa: PLC0415
        from mtex_usd.suggesting import suggest  # noqa: PLC0415

    if arguments.json:
        check_json_target(arguments.json, [arguments.apply] if arguments.apply else [])
    with show_progress("reading the shot", quiet=arguments.quiet) as progress:
        found = suggest(
            arguments.stage, anim=arguments.anim, top=arguments.top, apply=arguments.apply, progress=progress
        )
    if arguments.json:
        write_table(arguments.json, [_describe(each) for each in found])
    if not arguments.quiet:
        _report(found, arguments)
    for message in found[0].left_out:
        report_error(_NAME, message)
    return _EXIT_SOME_LEFT_OUT if found[0].left_out else 0


def _describe(found: "Suggestions") -> dict[str, object]:
    return {
        "anim": found.anim,
        "heldOut": list(found.held_out),
        "suggestions": [
            {
                "rank": each.rank,
                "match": list(each.recipe.match),
                "break": each.recipe.break_channel,
                "matchBand": each.recipe.band,
                "error": each.error,
                "relativeError": each.relative_error,
                "smoothness": each.smoothness,
                "isOwn": each.is_own,
            }
            for each in found.suggestions
        ],
    }


def _report(found: "Sequence[Suggestions]", arguments: argparse.Namespace) -> None:
    """Print notes on stderr, and on stdout the table and the lines to paste, unless the JSON goes there."""
    for each in found:
        for note in each.notes:
            report_note(_NAME, f"{each.anim}: {note}")
    if arguments.json == Path("-"):
        return
    for each in found:
        print(f"{each.anim}\t{len(each.held_out)} takes held out, each in turn")
        print("\n".join(_table(each.suggestions)))
        print("\n".join(f"    {line}" for line in each.suggestions[0].recipe.lines))
    if arguments.apply:
        print(f"wrote {arguments.apply}; put it first among the shot's sublayers")


def _table(suggestions: "Sequence[Suggestion]") -> list[str]:
    """Lay rows out in columns; numbers to the right."""
    rows = [("rank", "band", "error cm", "% of height", "smoothness", "match channels, the first cuts")]
    rows += [_row(each) for each in suggestions]
    widths = [max(len(row[column]) for row in rows) for column in range(5)]
    return ["  " + "  ".join([*map(str.rjust, row[:5], widths), row[5]]) for row in rows]


def _row(suggestion: "Suggestion") -> tuple[str, str, str, str, str, str]:
    recipe = suggestion.recipe
    channels = ", ".join(recipe.match)
    cut = "" if recipe.break_channel == recipe.match[0] else f" (cut by {recipe.break_channel})"
    return (
        str(suggestion.rank),
        str(recipe.band),
        f"{100.0 * suggestion.error:.2f}",
        f"{100.0 * suggestion.relative_error:.2f}",
        f"{suggestion.smoothness:.2f}",
        channels + cut + (" (as the sketch has it)" if suggestion.is_own else ""),
    )
