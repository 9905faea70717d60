"""Motion capture assisted animation on UsdSkel.

The public functions are loaded when they are first used, so that importing this package, and the commands' ``--help``,
stay quick. Importing it makes the mtex schemas known to USD, whether USD is loaded before or after; only stages opened
before are too early.
"""

import sys
from contextlib import suppress
from importlib import import_module
from typing import TYPE_CHECKING

from mtex_usd.errors import InputError, MtexError, NoSolutionError, ResultError, StageError
from mtex_usd.lazy import load_lazily
from mtex_usd.plugin_path import announce_plugin as _announce_plugin
from mtex_usd.version import VERSION

if TYPE_CHECKING:
    from mtex_usd.api import (
        FailedFile,
        ImportResult,
        apply_edits,
        constrain,
        find_contacts,
        import_takes,
        list_takes,
        process,
        read_clip,
        write_clip,
    )
    from mtex_usd.conforming import conform
    from mtex_usd.motion.clip import Clip
    from mtex_usd.motion.skeleton import Skeleton
    from mtex_usd.results import EditResult, Fragment, PathVariant, Result, Retarget
    from mtex_usd.suggesting import Suggestion, Suggestions, suggest

__version__ = VERSION

__all__ = [
    "Clip",
    "EditResult",
    "FailedFile",
    "Fragment",
    "ImportResult",
    "InputError",
    "MtexError",
    "NoSolutionError",
    "PathVariant",
    "Result",
    "ResultError",
    "Retarget",
    "Skeleton",
    "StageError",
    "Suggestion",
    "Suggestions",
    "apply_edits",
    "conform",
    "constrain",
    "find_contacts",
    "import_takes",
    "list_takes",
    "process",
    "read_clip",
    "suggest",
    "write_clip",
]


def _register_schemas() -> None:
    if "pxr" in sys.modules:
        import_module("mtex_usd.usd")
    else:
        _announce_plugin()


# An incomplete installation is said when USD is used; the locator and --help work without.
with suppress(InputError):
    _register_schemas()


__getattr__, __dir__ = load_lazily(
    __name__,
    {
        "api": (
            *("FailedFile", "ImportResult", "apply_edits", "constrain", "find_contacts", "import_takes"),
            *("list_takes", "process", "read_clip", "write_clip"),
        ),
        "conforming": ("conform",),
        "motion.clip": ("Clip",),
        "motion.skeleton": ("Skeleton",),
        "results": ("EditResult", "Fragment", "PathVariant", "Result", "Retarget"),
        "suggesting": ("Suggestion", "Suggestions", "suggest"),
    },
    packages=("constraints", "edit"),
)
