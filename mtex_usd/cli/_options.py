"""Options that several commands have, in the same words."""

import argparse
from pathlib import Path

__all__ = ["add_anim", "add_dry_run", "add_output", "add_quiet", "add_stage", "positive"]


def add_stage(parser: argparse.ArgumentParser) -> None:
    """Add the shot as an operand."""
    parser.add_argument("stage", type=Path, metavar="STAGE", help="the shot, or the .stage.usda of an earlier run")


def add_output(parser: argparse.ArgumentParser, default: str) -> None:
    """Add ``-o`` for the override layer; `default` says where it goes otherwise."""
    parser.add_argument(
        "-o", "--output", type=Path, metavar="LAYER", help=f"override layer to write (default: {default})"
    )


def add_anim(parser: argparse.ArgumentParser, use: str) -> None:
    """Add ``--anim``; `use` says what is done with one, such as ``work on this sketch only``."""
    parser.add_argument("--anim", action="append", default=[], metavar="PRIM", help=f"{use}; may be repeated")


def add_dry_run(parser: argparse.ArgumentParser) -> None:
    """Add ``--dry-run``."""
    parser.add_argument("--dry-run", action="store_true", help="do everything but write files; --json still tells")


def add_quiet(parser: "argparse._ActionsContainer") -> None:
    """Add ``-q``, to a command or to a group of options."""
    parser.add_argument("-q", "--quiet", action="store_true", help="print errors only")


def positive(text: str) -> int:
    """Take a whole number of at least 1, as the type of an option.

    Raises
    ------
    argparse.ArgumentTypeError
        Where it is anything else.
    """
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number of at least 1, found {text!r}")
    return int(text)
