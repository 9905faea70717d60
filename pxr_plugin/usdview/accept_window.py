"""Accept Path: what is shown of the selected characters, written into a layer that the user names."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mtex_usd.errors import InputError
from mtex_usd.usd.accepting import accept_paths
from mtex_usd.usd.variants import PathSet, selected_path

from .window import guard, load_qt

__all__ = ["AcceptWindow"]

_FILTER = "USD layers (*.usda *.usd *.usdc)"
_STACKED = "Stack this shot below it, so that the layer can be opened by itself"


class AcceptWindow:
    """Asks for the layer, says what will be in it, and writes it.

    Parameters
    ----------
    api
        The API of usdview.
    sets
        Of the characters that were selected.
    """

    def __init__(self, api: Any, sets: Sequence[PathSet]) -> None:
        self.api, self.sets = api, tuple(sets)
        self.qt = load_qt()
        widgets = self.qt.widgets
        self.dialog = widgets.QDialog(api.qMainWindow)
        self.dialog.setWindowTitle("Accept Path")
        self.dialog.setMinimumWidth(560)
        layout = widgets.QVBoxLayout(self.dialog)
        layout.addWidget(widgets.QLabel("Accept what is shown:"))
        for path_set in self.sets:
            shown = widgets.QLabel(f"    {path_set.label}: <b>{selected_path(api.stage, path_set)}</b>")
            layout.addWidget(shown)
        layout.addSpacing(8)
        layout.addLayout(self._make_row())
        self.stacked = widgets.QCheckBox(_STACKED)
        self.stacked.setChecked(True)
        layout.addWidget(self.stacked)
        layout.addSpacing(8)
        layout.addWidget(self._make_buttons())

    def _make_row(self) -> Any:
        widgets = self.qt.widgets
        row = widgets.QHBoxLayout()
        label = widgets.QLabel("&Layer")
        self.field = widgets.QLineEdit(_suggest(self.api.stage.GetRootLayer().realPath))
        label.setBuddy(self.field)
        browse = widgets.QPushButton("&Browse...")
        browse.clicked.connect(guard(self.api, lambda *_: self._browse()))
        for widget in (label, self.field, browse):
            row.addWidget(widget)
        return row

    def _make_buttons(self) -> Any:
        buttons = self.qt.widgets.QDialogButtonBox
        row = buttons(buttons.Ok | buttons.Cancel)
        row.button(buttons.Ok).setText("&Accept")
        row.accepted.connect(guard(self.api, self._accept))
        row.rejected.connect(self.dialog.reject)
        return row

    def _browse(self) -> None:
        dialog = self.qt.widgets.QFileDialog
        name, _ = dialog.getSaveFileName(
            self.dialog, "Accept into", self.field.text(), _FILTER, options=dialog.DontConfirmOverwrite
        )
        if name:
            self.field.setText(name)

    def _accept(self) -> None:
        name = self.field.text().strip()
        if not name:
            raise InputError("no layer is named", expected="a name such as shot.accepted.usda")
        accepted = accept_paths(self.api.stage, self.sets, Path(name), stacked=self.stacked.isChecked())
        beside = f", with {accepted.result.name} beside it" if accepted.result else ""
        self.api.PrintStatus(f"Accepted into {accepted.layer}{beside}")
        self.dialog.accept()


def _suggest(root: str) -> str:
    if not root:
        return ""
    stem = Path(root).stem.removesuffix(".stage").removesuffix(".mtex")
    return str(Path(root).with_name(f"{stem}.accepted.usda"))
