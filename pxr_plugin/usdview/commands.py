"""The commands of the menu; each takes usdview's API, as usdview calls it.

They act on the selected characters and on no others. What they show goes into the session layer, as what usdview's own
variant menus set does.
"""

from typing import Any

from mtex_usd.usd.contact_edits import read_motions
from mtex_usd.usd.session import find_animations
from mtex_usd.usd.variants import PathSet, choose_sets, select_path, step_path
from mtex_usd.usd.variants import list_paths as list_variants

from .accept_window import AcceptWindow
from .contact_window import ContactWindow
from .fragments_window import FragmentsWindow
from .paths_window import PathsWindow
from .process_job import ProcessJob, check_idle
from .window import close_window, find_selected, guard, keep_window

__all__ = [
    "accept_path",
    "edit_contact",
    "list_paths",
    "next_path",
    "previous_path",
    "process_animation",
    "show_fragments",
    "show_original",
]


def next_path(api: Any) -> None:
    """Show the next path of the selected characters."""
    guard(api, _step)(api, 1)


def previous_path(api: Any) -> None:
    """Show the path before of the selected characters."""
    guard(api, _step)(api, -1)


def show_original(api: Any) -> None:
    """Show what the animator made of the selected characters."""
    guard(api, _show_original)(api)


def list_paths(api: Any) -> None:
    """List the paths of the selected characters."""
    guard(api, lambda: keep_window(api, "paths", PathsWindow(api, _find_sets(api))))()


def show_fragments(api: Any) -> None:
    """List which times of the selected characters come from which take."""
    guard(api, lambda: keep_window(api, "fragments", FragmentsWindow(api, _find_sets(api))))()


def process_animation(api: Any) -> None:
    """Make paths for the animations of the selected characters, in a process of its own."""
    guard(api, _process)(api)


def edit_contact(api: Any) -> None:
    """Move contacts of the selected characters in time and space."""
    guard(api, _edit)(api)


def accept_path(api: Any) -> None:
    """Write what is shown of the selected characters into a layer that is asked for."""
    guard(api, lambda: keep_window(api, "accept", AcceptWindow(api, _find_sets(api))))()


def _find_sets(api: Any) -> tuple[PathSet, ...]:
    return choose_sets(api.stage, find_selected(api))


def _step(api: Any, steps: int) -> None:
    shown = step_path(api.stage, _find_sets(api), steps)
    _say(api, shown)


def _show_original(api: Any) -> None:
    sets = _find_sets(api)
    for found in sets:
        select_path(api.stage, found, "original")
    _say(api, dict.fromkeys(sets, "original"))


def _say(api: Any, shown: dict[PathSet, str]) -> None:
    said = []
    for found, variant in shown.items():
        paths = list_variants(api.stage, found)
        place = f" ({paths.index(variant) + 1} of {len(paths)})" if variant in paths else ""
        said.append(f"{found.label}: {variant}{place}")
    api.PrintStatus("; ".join(said))
    api.UpdateViewport()


def _process(api: Any) -> None:
    check_idle()
    ProcessJob(api, find_animations(api.stage, find_selected(api))).start()


def _edit(api: Any) -> None:
    # An open window is closed first, which takes back what it shows and nobody kept.
    close_window("contact")
    keep_window(api, "contact", ContactWindow(api, read_motions(api.stage, find_selected(api))))
