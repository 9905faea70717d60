"""Show Fragments: which times of a path come from which take; a click shows the frame."""

from collections.abc import Mapping, Sequence
from typing import Any

from mtex_usd.errors import StageError
from mtex_usd.usd.variants import PathSet, describe_path, selected_path

from .window import fit_tree, guard, load_qt, make_foot, seek

__all__ = ["FragmentsWindow"]

_COLUMNS = ("Time", "Take", "Time in take", "Stretch", "Distance", "Scale", "Join")
_WIDTHS = (100, 160, 110, 65, 75, 60, 100)
_NUMBERS = (0, 2, 3, 4, 5)

# Okabe and Ito's, told apart by people who do not see all colours; black and yellow left out.
_COLOURS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00")
_STRIP_HEIGHT = 22

Fragment = Mapping[str, Any]


class FragmentsWindow:
    """The table and a strip coloured by take.

    Parameters
    ----------
    api
        The API of usdview.
    sets
        Of the characters that were selected; of each what is shown at the moment.

    Raises
    ------
    StageError
        Where none shows a path made of fragments.
    """

    def __init__(self, api: Any, sets: Sequence[PathSet]) -> None:
        self.api = api
        self.qt = load_qt()
        shown = {f"{each.label}, {selected_path(api.stage, each)}": self._read(each) for each in sets}
        shown = {label: fragments for label, fragments in shown.items() if fragments}
        if not shown:
            raise StageError(
                "what is shown is made of no fragments",
                expected="a path of a character",
                found=", ".join(f"{each.label}: {selected_path(api.stage, each)}" for each in sets),
                fix="Show a path first, with Next Path.",
            )
        takes = dict.fromkeys(fragment["take"] for fragments in shown.values() for fragment in fragments)
        self.colours = {take: _COLOURS[number % len(_COLOURS)] for number, take in enumerate(takes)}
        self.dialog = self.qt.widgets.QDialog(api.qMainWindow)
        self.dialog.setWindowTitle("Fragments")
        self._fill(shown)

    def _read(self, path_set: PathSet) -> list[Fragment]:
        said = describe_path(self.api.stage, path_set, selected_path(self.api.stage, path_set))
        fragments = said.get("fragments")
        return fragments if isinstance(fragments, list) else []

    def _fill(self, shown: Mapping[str, list[Fragment]]) -> None:
        layout = self.qt.widgets.QVBoxLayout(self.dialog)
        self.tree = self._make_tree()
        for label, fragments in shown.items():
            head = self.qt.widgets.QTreeWidgetItem(self.tree, [label])
            head.setFirstColumnSpanned(True)
            head.setFlags(self.qt.core.Qt.ItemIsEnabled)
            self._add_strip(head, fragments)
            self._add_rows(head, fragments)
            head.setExpanded(True)
        layout.addWidget(self.tree)
        layout.addLayout(make_foot(self.dialog, "A click shows the first frame of a fragment."))
        rows = sum(len(fragments) + 2 for fragments in shown.values())
        self.dialog.resize(740, fit_tree(self.tree, rows))

    def _make_tree(self) -> Any:
        tree = self.qt.widgets.QTreeWidget()
        tree.setHeaderLabels(list(_COLUMNS))
        tree.setRootIsDecorated(False)
        tree.setAccessibleName("Fragments of the paths that are shown")
        for column, width in enumerate(_WIDTHS):
            tree.setColumnWidth(column, width)
        for column in _NUMBERS:
            tree.headerItem().setTextAlignment(column, self.qt.core.Qt.AlignRight | self.qt.core.Qt.AlignVCenter)
        tree.itemClicked.connect(guard(self.api, lambda item, _: self._seek(item)))
        tree.itemActivated.connect(guard(self.api, lambda item, _: self._seek(item)))
        return tree

    def _add_strip(self, head: Any, fragments: Sequence[Fragment]) -> None:
        item = self.qt.widgets.QTreeWidgetItem(head)
        item.setFirstColumnSpanned(True)
        item.setFlags(self.qt.core.Qt.ItemIsEnabled)
        strip = self.qt.widgets.QLabel()
        strip.setPixmap(self._paint_strip(fragments))
        strip.setToolTip("The path, coloured by take; dark lines are joins that were not consecutive")
        self.tree.setItemWidget(item, 0, strip)

    def _paint_strip(self, fragments: Sequence[Fragment]) -> Any:
        gui = self.qt.gui
        width = sum(_WIDTHS)
        pixmap = gui.QPixmap(width, _STRIP_HEIGHT)
        pixmap.fill(gui.QColor(0, 0, 0, 0))
        painter = gui.QPainter(pixmap)
        begin, end = fragments[0]["start"], fragments[-1]["end"]
        scale = width / max(end - begin, 1.0)
        for number, fragment in enumerate(fragments):
            left, right = ((fragment[key] - begin) * scale for key in ("start", "end"))
            painter.fillRect(round(left), 2, round(right) - round(left), 18, gui.QColor(self.colours[fragment["take"]]))
            if number and not _is_consecutive(fragments[number - 1], fragment):
                painter.fillRect(round(left) - 1, 0, 3, _STRIP_HEIGHT, gui.QColor("#202020"))
        painter.end()
        return pixmap

    def _add_rows(self, head: Any, fragments: Sequence[Fragment]) -> None:
        for number, fragment in enumerate(fragments):
            before = fragments[number - 1] if number else None
            item = self.qt.widgets.QTreeWidgetItem(head, _describe(fragment, before))
            item.setData(0, self.qt.core.Qt.UserRole, fragment["start"])
            item.setIcon(1, self._make_icon(self.colours[fragment["take"]]))
            item.setToolTip(1, fragment["take"])
            for column in _NUMBERS:
                item.setTextAlignment(column, self.qt.core.Qt.AlignRight | self.qt.core.Qt.AlignVCenter)

    def _make_icon(self, colour: str) -> Any:
        pixmap = self.qt.gui.QPixmap(12, 12)
        pixmap.fill(self.qt.gui.QColor(colour))
        return self.qt.gui.QIcon(pixmap)

    def _seek(self, item: Any) -> None:
        time_code = item.data(0, self.qt.core.Qt.UserRole)
        if time_code is not None:
            seek(self.api, float(time_code))


def _is_consecutive(before: Fragment, fragment: Fragment) -> bool:
    return bool(before["take"] == fragment["take"] and before["takeEnd"] == fragment["takeStart"])


def _describe(fragment: Fragment, before: Fragment | None) -> list[str]:
    length = max(fragment["takeEnd"] - fragment["takeStart"], 1e-9)
    return [
        _range(fragment["start"], fragment["end"]),
        fragment["take"].rpartition("/")[2],
        _range(fragment["takeStart"], fragment["takeEnd"]),
        f"{(fragment['end'] - fragment['start']) / length:.2f}",
        f"{fragment['distance']:.1f}",
        f"{fragment['scale']:.2f}",
        "" if before is None else "consecutive" if _is_consecutive(before, fragment) else "blended",
    ]


def _range(start: float, end: float) -> str:
    return f"{start:g} \N{EN DASH} {end:g}"
