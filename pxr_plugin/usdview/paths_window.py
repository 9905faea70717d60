"""Paths: every version of the selected characters with what tells them apart; a click shows one."""

from collections.abc import Sequence
from typing import Any

from mtex_usd.usd.variants import PathSet, describe_path, list_paths, select_path, selected_path

from .window import fit_tree, guard, load_qt, make_foot

__all__ = ["PathsWindow"]

_COLUMNS = ("Path", "Rank", "Distance", "Consecutive joins", "Fragments")
_WIDTHS = (190, 50, 90, 130, 80)
_ORIGINAL = "original"


class PathsWindow:
    """The list; stays open, and follows what the menu's other commands select.

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
        self.dialog = self.qt.widgets.QDialog(api.qMainWindow)
        self.dialog.setWindowTitle("Paths")
        self.tree = self._make_tree()
        for path_set in self.sets:
            self._add_set(path_set)
        layout = self.qt.widgets.QVBoxLayout(self.dialog)
        layout.addWidget(self.tree)
        layout.addLayout(make_foot(self.dialog, "A click shows a path. Lower distance is closer to the sketch."))
        rows = sum(len(list_paths(api.stage, each)) + 2 for each in self.sets)
        self.dialog.resize(600, fit_tree(self.tree, rows))
        self.tree.itemClicked.connect(guard(api, lambda item, _: self._choose(item)))
        self.tree.itemActivated.connect(guard(api, lambda item, _: self._choose(item)))
        api.dataModel.signalPrimsChanged.connect(self._follow)
        self.dialog.finished.connect(lambda *_: api.dataModel.signalPrimsChanged.disconnect(self._follow))
        self._mark()

    def _make_tree(self) -> Any:
        tree = self.qt.widgets.QTreeWidget()
        tree.setHeaderLabels(list(_COLUMNS))
        tree.setRootIsDecorated(False)
        tree.setAlternatingRowColors(True)
        tree.setAccessibleName("Paths of the selected characters")
        for column, width in enumerate(_WIDTHS):
            tree.setColumnWidth(column, width)
            if column:
                tree.headerItem().setTextAlignment(column, self.qt.core.Qt.AlignRight | self.qt.core.Qt.AlignVCenter)
        return tree

    def _add_set(self, path_set: PathSet) -> None:
        head = self.qt.widgets.QTreeWidgetItem(self.tree, [path_set.label])
        head.setFirstColumnSpanned(True)
        head.setFlags(self.qt.core.Qt.ItemIsEnabled)
        for variant in (_ORIGINAL, *list_paths(self.api.stage, path_set)):
            item = self.qt.widgets.QTreeWidgetItem(head, self._describe(path_set, variant))
            item.setData(0, self.qt.core.Qt.UserRole, variant)
            for column in range(1, len(_COLUMNS)):
                item.setTextAlignment(column, self.qt.core.Qt.AlignRight | self.qt.core.Qt.AlignVCenter)
        head.setExpanded(True)

    def _describe(self, path_set: PathSet, variant: str) -> list[str]:
        said = describe_path(self.api.stage, path_set, variant)
        fragments = said.get("fragments")
        if "rank" not in said or not isinstance(fragments, list):
            return [variant, *["\N{EN DASH}"] * (len(_COLUMNS) - 1)]
        joins = f"{said['zeroCostJoins']} of {len(fragments) - 1}"
        return [variant, str(said["rank"]), f"{said['distance']:.1f}", joins, str(len(fragments))]

    def _choose(self, item: Any) -> None:
        variant, head = item.data(0, self.qt.core.Qt.UserRole), item.parent()
        if variant is None or head is None:
            return
        path_set = self.sets[self.tree.indexOfTopLevelItem(head)]
        select_path(self.api.stage, path_set, variant)
        self.api.PrintStatus(f"{path_set.label}: {variant}")
        self.api.UpdateViewport()
        self._mark()

    def _follow(self, *_: object) -> None:
        prims = [self.api.stage.GetPrimAtPath(path_set.model) for path_set in self.sets]
        if all(prim and prim.IsActive() for prim in prims):
            self._mark()
        else:
            self.dialog.reject()

    def _mark(self) -> None:
        """Mark what is shown."""
        for number, path_set in enumerate(self.sets):
            shown, head = selected_path(self.api.stage, path_set), self.tree.topLevelItem(number)
            for row in range(head.childCount()):
                item = head.child(row)
                variant = item.data(0, self.qt.core.Qt.UserRole)
                item.setText(0, f"\N{BLACK RIGHT-POINTING POINTER} {variant}" if variant == shown else f"    {variant}")
                font = item.font(0)
                font.setBold(variant == shown)
                for column in range(len(_COLUMNS)):
                    item.setFont(column, font)
