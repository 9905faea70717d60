"""The windows: what they list, what a click does, and that they follow what happens elsewhere."""

import pytest
from pxr import Usd
from PySide6 import QtCore, QtGui, QtWidgets

from mtex_usd.usdview import window as windows
from tests.usdview.shots import CHAR, OTHER, shown


def open_window(usdview, entry, name, *paths):
    usdview.select(*paths)
    usdview.trigger(entry)
    return windows.open_window(name)


def rows(tree):
    """Give the texts of every row below each heading."""
    heads = [tree.topLevelItem(i) for i in range(tree.topLevelItemCount())]
    columns = range(tree.columnCount())
    return {
        head.text(0): [[head.child(i).text(column) for column in columns] for i in range(head.childCount())]
        for head in heads
    }


def variant_of(usdview, model, name="mtex"):
    return usdview.model.stage.GetPrimAtPath(model).GetVariantSet(name).GetVariantSelection()


def test_paths_lists_rank_distance_and_joins_of_the_selected(usdview):
    found = rows(open_window(usdview, "Paths...", "paths", CHAR).tree)
    assert list(found) == [CHAR, f"{CHAR} {{mtex_Face}}"]
    stage = usdview.model.stage
    said = stage.GetPrimAtPath(f"{CHAR}/Anim_mtex").GetCustomDataByKey("mtex")
    best = found[CHAR][1]
    assert best[0].endswith("path_01")
    fragments = len(said["fragments"])
    joins = f"{said['zeroCostJoins']} of {fragments - 1}"
    assert best[1:] == ["1", f"{said['distance']:.1f}", joins, str(fragments)]
    assert [row[0].strip("► ") for row in found[CHAR]] == ["original", "path_01", "path_02", "path_03"]


def test_a_click_on_a_path_shows_it(usdview):
    window = open_window(usdview, "Paths...", "paths", CHAR, OTHER)
    before = shown(usdview.model.stage, f"{OTHER}/Rig/Skel")
    window.tree.itemClicked.emit(window.tree.topLevelItem(2).child(2), 0)
    assert variant_of(usdview, OTHER) == "path_02"
    assert (shown(usdview.model.stage, f"{OTHER}/Rig/Skel") != before).any()
    assert variant_of(usdview, CHAR) == "path_01"
    assert usdview.last_message == f"{OTHER}: path_02"


def test_a_real_click_reaches_the_row(usdview):
    window = open_window(usdview, "Paths...", "paths", OTHER)
    place = window.tree.visualItemRect(window.tree.topLevelItem(0).child(3)).center()
    for kind in (QtCore.QEvent.MouseButtonPress, QtCore.QEvent.MouseButtonRelease):
        event = QtGui.QMouseEvent(kind, place, place, QtCore.Qt.LeftButton, QtCore.Qt.LeftButton, QtCore.Qt.NoModifier)
        QtWidgets.QApplication.sendEvent(window.tree.viewport(), event)
    assert variant_of(usdview, OTHER) == "path_03"


def test_headings_are_not_chosen(usdview, boxes):
    window = open_window(usdview, "Paths...", "paths", OTHER)
    window.tree.itemClicked.emit(window.tree.topLevelItem(0), 0)
    assert boxes == []
    assert variant_of(usdview, OTHER) == "path_01"


def test_the_list_follows_the_menu(usdview):
    window = open_window(usdview, "Paths...", "paths", OTHER)
    usdview.trigger("Next Path")
    marked = [row[0] for row in rows(window.tree)[OTHER] if row[0].startswith("►")]
    assert marked == ["► path_02"]


def test_another_stage_closes_what_was_open(usdview, processed):
    open_window(usdview, "Paths...", "paths", OTHER)
    usdview.model.replace(Usd.Stage.Open(str(processed)))
    assert windows.open_window("paths") is None


def test_a_character_that_goes_away_closes_the_list(usdview):
    window = open_window(usdview, "Paths...", "paths", OTHER)
    stage = usdview.model.stage
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        stage.GetPrimAtPath(OTHER).SetActive(False)
    assert not window.dialog.isVisible()


def test_opening_it_again_shows_the_new_selection_alone(usdview):
    first = open_window(usdview, "Paths...", "paths", OTHER)
    second = open_window(usdview, "Paths...", "paths", CHAR)
    assert not first.dialog.isVisible()
    assert second.dialog.isVisible()
    assert OTHER not in rows(second.tree)


def test_fragments_say_which_time_comes_from_which_take(usdview):
    window = open_window(usdview, "Show Fragments...", "fragments", OTHER)
    (label, found), *_ = rows(window.tree).items()
    assert label == f"{OTHER}, path_01"
    said = usdview.model.stage.GetPrimAtPath(f"{OTHER}/Anim_mtex").GetCustomDataByKey("mtex")["fragments"]
    assert len(found) == len(said) + 1  # the strip
    for row, fragment in zip(found[1:], said.values(), strict=True):
        assert row[0] == f"{fragment['start']:g} – {fragment['end']:g}"
        assert row[1] == fragment["take"].rpartition("/")[2]
        assert row[2] == f"{fragment['takeStart']:g} – {fragment['takeEnd']:g}"
    joins = [row[6] for row in found[2:]]
    assert (
        joins.count("consecutive")
        == usdview.model.stage.GetPrimAtPath(f"{OTHER}/Anim_mtex").GetCustomDataByKey("mtex")["zeroCostJoins"]
    )


def test_a_click_on_a_fragment_shows_its_first_frame(usdview):
    window = open_window(usdview, "Show Fragments...", "fragments", OTHER)
    item = window.tree.topLevelItem(0).child(2)
    window.tree.itemClicked.emit(item, 0)
    begin = float(item.text(0).partition(" ")[0])
    assert begin > 1.0
    assert usdview.api.frame == Usd.TimeCode(begin)
    assert usdview.timeline == [begin]
    assert usdview.api.used[-2:] == ["UpdateViewport", "frame"]


def test_a_window_without_the_timelines_field_moves_the_picture_all_the_same(usdview):
    usdview.field.setParent(None)
    window = open_window(usdview, "Show Fragments...", "fragments", OTHER)
    window.tree.itemClicked.emit(window.tree.topLevelItem(0).child(2), 0)
    assert usdview.api.frame.GetValue() > 1.0
    assert usdview.timeline == []


def test_the_original_has_no_fragments(usdview, boxes):
    usdview.select(OTHER)
    usdview.trigger("Original")
    usdview.trigger("Show Fragments...")
    assert boxes == [
        "what is shown is made of no fragments; expected a path of a character; found /World/Other: original. "
        "Show a path first, with Next Path."
    ]


def test_the_strip_has_the_colours_of_the_takes(usdview):
    window = open_window(usdview, "Show Fragments...", "fragments", OTHER)
    head = window.tree.topLevelItem(0)
    image = window.tree.itemWidget(head.child(0), 0).pixmap().toImage()
    painted = {image.pixelColor(x, 11).name() for x in range(image.width())}
    assert set(window.colours.values()) & painted
    takes = {fragment["take"] for fragment in _fragments(usdview)}
    assert set(window.colours) == takes
    assert painted - set(window.colours.values()) <= {"#202020", "#000000"}


def _fragments(usdview):
    return usdview.model.stage.GetPrimAtPath(f"{OTHER}/Anim_mtex").GetCustomDataByKey("mtex")["fragments"].values()


@pytest.mark.parametrize(("entry", "name"), [("Paths...", "paths"), ("Show Fragments...", "fragments")])
def test_windows_only_use_what_is_documented_and_change_no_layer(usdview, entry, name):
    session = usdview.model.stage.GetSessionLayer()
    before = session.ExportToString()
    window = open_window(usdview, entry, name, CHAR, OTHER)
    window.dialog.reject()
    assert session.ExportToString() == before
    assert set(usdview.api.used) <= {"stage", "selectedPrims", "qMainWindow", "dataModel"}
