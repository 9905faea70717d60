"""Edit Contact: the window shows the steps, and what its rows say is what the character does."""

import numpy as np
import pytest
from pxr import Usd

from mtex_usd.constraints.planting.steps import StepMover
from mtex_usd.errors import NoSolutionError
from mtex_usd.usdview import window as windows
from tests.usdview.usdview import Usdview, wait_until
from tests.usdview.walk import MESH, STEP, joint_places, rotations


@pytest.fixture
def editing(walk, boxes):
    """Give a usdview with the walk, and the window opened on its mesh."""
    usdview = Usdview(Usd.Stage.Open(str(walk))).load()
    usdview.select(MESH)
    usdview.trigger("Edit Contact...")
    assert boxes == []
    window = windows.open_window("contact")
    window.tree.setCurrentItem(window.tree.topLevelItem(0).child(STEP))
    return usdview, window


def settle(window):
    wait_until(lambda: not window.timer.isActive())


def test_the_list_has_every_step_with_its_time(editing, prepared):
    _, window = editing
    head = window.tree.topLevelItem(0)
    assert head.text(0) == "/Humanoid, path_01"
    listed = [tuple(head.child(row).text(column) for column in range(3)) for row in range(head.childCount())]
    assert listed == [(step.name.replace(".", " "), f"{step.first}", f"{step.last}") for step in prepared[1].steps]


def test_choosing_a_step_shows_its_frame_and_its_place(editing, prepared):
    usdview, window = editing
    step = prepared[1].steps[STEP]
    assert usdview.api.frame == Usd.TimeCode(step.first)
    assert [row.value for row in window.times] == [0, step.first, step.last]
    np.testing.assert_allclose([row.value for row in window.places], step.place, atol=1e-3)


def test_dragging_a_slider_moves_the_foot_at_once(editing):
    usdview, window = editing
    stage, first = usdview.model.stage, window.times[1].value
    before = joint_places(stage, "RightFoot", [first])
    window.places[1].slider.setValue(20)
    lifted = window.places[1].change
    assert lifted > 5.0
    settle(window)
    np.testing.assert_allclose(joint_places(stage, "RightFoot", [first]) - before, [[0, lifted, 0]], atol=0.6)
    assert window.status.text().startswith("The motion is changed from ")


def test_shifting_moves_both_ends(editing):
    _, window = editing
    item = window.tree.currentItem()
    first, last = int(item.text(1)), int(item.text(2))
    window.times[0].spin.setValue(2)
    settle(window)
    assert (int(item.text(1)), int(item.text(2))) == (first + 2, last + 2)


def test_what_cannot_be_is_said_in_the_window_and_the_motion_stays(editing, boxes):
    usdview, window = editing
    window.times[0].spin.setValue(8.0)
    settle(window)
    before = rotations(usdview.model.stage)
    window.places[1].spin.setValue(300.0)
    settle(window)
    assert "cannot be moved so far" in window.status.text()
    np.testing.assert_array_equal(rotations(usdview.model.stage), before)
    window._reset()
    window.times[1].spin.setValue(window.times[2].value + 5)
    settle(window)
    assert "cannot be held then" in window.status.text()
    assert boxes == []


def test_what_the_solve_cannot_meet_is_said_in_the_window(editing, boxes, monkeypatch):
    _, window = editing

    def refuse(*_, **__):
        raise NoSolutionError("2 of 24 constraints cannot be met together")

    monkeypatch.setattr(StepMover, "move", refuse)
    window.places[1].spin.setValue(window.places[1].value + 1)
    settle(window)
    assert (
        window.status.text() == "right heel, right toes stays where it was: 2 of 24 constraints cannot be met together"
    )
    assert boxes == []


def test_cancel_takes_everything_back(editing):
    usdview, window = editing
    session = usdview.model.stage.GetSessionLayer()
    window.places[0].spin.setValue(window.places[0].value + 4)
    settle(window)
    assert session.GetPrimAtPath("/Humanoid")
    window.dialog.reject()
    assert session.empty


def test_keep_leaves_the_edit_and_a_click_on_reset_does_not(editing):
    usdview, window = editing
    session = usdview.model.stage.GetSessionLayer()
    before = rotations(usdview.model.stage)
    window.places[0].spin.setValue(window.places[0].value + 4)
    settle(window)
    window._reset()
    np.testing.assert_array_equal(rotations(usdview.model.stage), before)
    assert session.empty
    window.places[0].spin.setValue(window.places[0].value + 4)
    settle(window)
    window.dialog.accept()
    assert (rotations(usdview.model.stage) != before).any()
    assert list(session.GetPrimAtPath("/Humanoid").variantSets["mtex"].variants.keys()) == ["path_01"]


def test_one_step_after_the_other_adds_up(editing):
    usdview, window = editing
    head = window.tree.topLevelItem(0)
    stage = usdview.model.stage
    times = [float(head.child(row).text(1)) for row in (STEP, STEP + 1)]
    before = [joint_places(stage, joint, [time]) for joint, time in zip(("RightFoot", "LeftFoot"), times, strict=True)]
    for row in (STEP, STEP + 1):
        window.tree.setCurrentItem(head.child(row))
        window.places[1].spin.setValue(window.places[1].value + 6)
        settle(window)
    after = [joint_places(stage, joint, [time]) for joint, time in zip(("RightFoot", "LeftFoot"), times, strict=True)]
    for a, b in zip(before, after, strict=True):
        np.testing.assert_allclose(b - a, [[0, 6, 0]], atol=0.6)
    window._reset()
    again = joint_places(stage, "RightFoot", times[:1])
    np.testing.assert_allclose(again, after[0], atol=0.05)


def test_the_same_command_again_begins_anew(editing):
    usdview, window = editing
    window.places[0].spin.setValue(window.places[0].value + 4)
    settle(window)
    usdview.trigger("Edit Contact...")
    assert windows.open_window("contact") is not window
    assert usdview.model.stage.GetSessionLayer().empty


def test_an_accepted_edit_plays_in_a_fresh_stage(editing, tmp_path):
    usdview, window = editing
    window.places[1].spin.setValue(window.places[1].value + 8)
    settle(window)
    window.dialog.accept()
    usdview.trigger("Accept Path...")
    accept = windows.open_window("accept")
    accept.field.setText(str(tmp_path / "accepted.usda"))
    accept._accept()
    np.testing.assert_array_equal(
        rotations(Usd.Stage.Open(str(tmp_path / "accepted.usda"))), rotations(usdview.model.stage)
    )


def test_the_original_and_strangers_are_refused(walk, boxes):
    usdview = Usdview(Usd.Stage.Open(str(walk))).load()
    usdview.select(MESH)
    usdview.trigger("Original")
    usdview.trigger("Edit Contact...")
    usdview.select("/Takes")
    usdview.trigger("Edit Contact...")
    assert boxes[0] == "/Humanoid shows the original, which stays as it is. Select a path first."
    assert boxes[1].startswith("nothing selected plays an animation; expected a mesh, a Skeleton")
    assert windows.open_window("contact") is None
