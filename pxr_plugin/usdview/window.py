"""What all commands share: Qt as usdview has it, what is selected, messages, and windows that stay open."""

import sys
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Any

from mtex_usd.errors import MtexError, StageError

__all__ = [
    "Qt",
    "close_window",
    "find_selected",
    "fit_tree",
    "guard",
    "keep_window",
    "load_qt",
    "make_foot",
    "open_window",
    "seek",
    "show_error",
]

_TITLE = "Motion Texture"

# Windows of commands that go on, by command; Qt deletes what nobody holds.
_open: dict[str, Any] = {}


@dataclass(frozen=True)
class Qt:
    """The modules of the Qt binding that usdview runs with."""

    core: Any
    gui: Any
    widgets: Any


def load_qt() -> Qt:
    """Give Qt as usdview imported it, be it PySide6 or an older one."""
    from pxr.Usdviewq.qt import QtCore, QtGui, QtWidgets  # type: ignore[attr-defined]  # noqa: PLC0415

    return Qt(QtCore, QtGui, QtWidgets)


def guard(api: Any, action: Callable[..., object]) -> Callable[..., None]:
    """Make something that tells its errors in a message box of it.

    Parameters
    ----------
    api
        The API of usdview.
    action
        A command's body, or what a button or an item of a window does.
    """

    @wraps(action)
    def run(*arguments: Any) -> None:  # numpydoc ignore=GL08
        try:
            action(*arguments)
        except MtexError as error:
            show_error(api, str(error))
        except Exception as error:  # a bug: usdview would print it where nobody looks
            traceback.print_exception(error, file=sys.stderr)
            show_error(api, f"This is a bug in usdmtex: {type(error).__name__}: {error}. The terminal has the details.")

    return run


def show_error(api: Any, text: str) -> None:
    """Show a message box.

    Parameters
    ----------
    api
        The API of usdview.
    text
        What is wrong.
    """
    load_qt().widgets.QMessageBox.warning(api.qMainWindow, _TITLE, text)


def find_selected(api: Any) -> list[Any]:
    """Give the prims that are selected; usdview selects the stage's root where nothing is.

    Parameters
    ----------
    api
        The API of usdview.

    Raises
    ------
    StageError
        Where nothing is selected.
    """
    prims = [prim for prim in api.selectedPrims if prim and not prim.IsPseudoRoot()]
    if not prims:
        raise StageError(
            "nothing is selected", expected="a character", fix="Select a mesh, a Skeleton, an animation or a model."
        )
    return prims


def seek(api: Any, time_code: float) -> None:
    """Show a frame.

    Parameters
    ----------
    api
        The API of usdview.
    time_code
        Of the stage.
    """
    from pxr import Usd  # noqa: PLC0415

    api.dataModel.currentFrame = Usd.TimeCode(time_code)
    # The data model moves the picture alone; the timeline follows what is typed into its field.
    field = api.qMainWindow.findChild(load_qt().widgets.QLineEdit, "frameField")
    if field is not None:
        field.setText(f"{time_code:g}")
        field.editingFinished.emit()
    api.UpdateGUI()
    api.UpdateViewport()


def keep_window(api: Any, name: str, window: Any) -> None:
    """Show a window that stays open beside usdview's, in place of an earlier one of the same command.

    Parameters
    ----------
    api
        The API of usdview.
    name
        Of the command.
    window
        With a ``dialog``; closed when another stage is opened.
    """
    close_window(name)
    _open[name] = window
    api.dataModel.signalStageReplaced.connect(window.dialog.reject)
    window.dialog.finished.connect(lambda *_: _forget(name, window))
    window.dialog.show()
    window.dialog.raise_()


def _forget(name: str, window: Any) -> None:
    if _open.get(name) is window:
        del _open[name]
    window.dialog.deleteLater()


def fit_tree(tree: Any, rows: int) -> int:
    """Give how high a window with a tree has to be to show it whole, within what screens have.

    Parameters
    ----------
    tree
        The tree, with at least one row.
    rows
        How many it shows.
    """
    row_height = int(tree.sizeHintForRow(0))
    return min(90 + (rows + 2) * max(row_height, 16), 700)


def make_foot(dialog: Any, text: str) -> Any:
    """Make the lowest row of a window: what it is for, and Close.

    Parameters
    ----------
    dialog
        The window.
    text
        What it is for.

    Returns
    -------
    QHBoxLayout
        To be added to the window's layout.
    """
    widgets = load_qt().widgets
    foot = widgets.QHBoxLayout()
    foot.addWidget(widgets.QLabel(text))
    foot.addStretch(1)
    close = widgets.QPushButton("Close")
    close.clicked.connect(dialog.reject)
    foot.addWidget(close)
    return foot


def open_window(name: str) -> Any:
    """Give the window of a command; None where it is not open.

    Parameters
    ----------
    name
        Of the command.
    """
    return _open.get(name)


def close_window(name: str) -> None:
    """Close the window of a command, as its Close or Cancel does.

    Parameters
    ----------
    name
        Of the command.
    """
    if name in _open:
        _open[name].dialog.reject()
