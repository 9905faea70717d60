"""The page's style sheets and scripts in one piece, so that it opens from disk.

A browser loads no ES module from a ``file:`` address. So every module goes into an import map as a ``data:`` address,
and relative imports become names of that map. Nothing is fetched.
"""

import base64
import json
import re
from collections.abc import Iterable
from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable

__all__ = ["read_scripts", "read_styles"]

_VENDORED = {
    "three": ("vendor", "three", "three.module.min.js"),
    "uplot": ("vendor", "uplot", "uplot.min.js"),
}
_VENDORED_STYLES = (("vendor", "uplot", "uplot.min.css"),)
_RELATIVE = re.compile(r"""(?P<lead>\b(?:from|import)\s*\(?\s*)(?P<quote>["'])\./(?P<name>[\w.-]+\.js)(?P=quote)""")
_PREFIX = "mtex/"


def _static() -> Traversable:
    return resources.files("mtex_usd.review") / "static"


@cache
def read_scripts() -> str:
    """Give the import map with all modules of ``static`` and the vendored ones, as the text of its element."""
    imports = {name: _to_address(_read(parts), name) for name, parts in _VENDORED.items()}
    for file in _files(".js"):
        imports[_PREFIX + file.name] = _to_address(file.read_text("utf-8"), _PREFIX + file.name)
    return json.dumps({"imports": imports})


@cache
def read_styles() -> str:
    """Give all style sheets: the vendored ones, the page's own for what it defines, and the others of ``static``."""
    sheets = sorted(_files(".css"), key=lambda file: (file.name != "page.css", file.name))
    own = [sheet.read_text("utf-8") for sheet in sheets]
    return "\n".join([*(_read(parts) for parts in _VENDORED_STYLES), *own])


def _files(suffix: str) -> Iterable[Traversable]:
    return sorted(
        (file for file in _static().iterdir() if file.is_file() and file.name.endswith(suffix)),
        key=lambda file: file.name,
    )


def _read(parts: tuple[str, ...]) -> str:
    return _static().joinpath(*parts).read_text("utf-8")


def _to_address(script: str, name: str) -> str:
    """Give a script as an address; the name is what a browser's messages and debugger call it."""
    named = _RELATIVE.sub(rf"\g<lead>\g<quote>{_PREFIX}\g<name>\g<quote>", script)
    encoded = base64.b64encode(f"{named}\n//# sourceURL={name}\n".encode()).decode("ascii")
    return f"data:text/javascript;base64,{encoded}"
