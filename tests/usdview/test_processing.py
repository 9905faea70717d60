"""Process This Animation runs beside usdview, and leaves nothing behind but a sublayer of the session layer."""

import os
import time
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd
from PySide6 import QtCore, QtWidgets

import mtex_usd
from mtex_usd.usd.session import find_animations, write_snapshot
from mtex_usd.usd.variants import find_sets, list_paths
from mtex_usd.usdview import process_job
from tests.usdview.shots import CHAR, OTHER, shown, write_processed, write_shot
from tests.usdview.usdview import Usdview, wait_until

BODY = f"{OTHER}/Rig/Body"


@pytest.fixture
def shot(tmp_path):
    return write_shot(tmp_path)


@pytest.fixture
def scratch(tmp_path, monkeypatch):
    """Give the folder that temporary folders are made in."""
    folder = tmp_path / "scratch"
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    return folder


@pytest.fixture
def open_shot(shot, boxes):
    return Usdview(Usd.Stage.Open(str(shot))).load()


def process(usdview, *paths):
    usdview.select(*paths)
    usdview.trigger("Process This Animation...")
    return process_job.running_job()


def wait(usdview, *paths):
    assert process(usdview, *paths)
    wait_until(lambda: process_job.running_job() is None)


def files(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_the_result_plays_and_nothing_of_the_users_is_changed(open_shot, shot, scratch, boxes):
    stage, before = open_shot.model.stage, files(shot.parent)
    played = shown(stage, f"{OTHER}/Rig/Skel")
    wait(open_shot, BODY)
    assert boxes == []
    (found,) = find_sets(stage)
    assert (str(found.model), list_paths(stage, found)) == (OTHER, ("path_01", "path_02", "path_03"))
    assert (shown(stage, f"{OTHER}/Rig/Skel") != played).any()
    assert files(shot.parent) == before
    assert list(scratch.iterdir()) == []
    assert not stage.GetRootLayer().dirty
    assert open_shot.last_message.startswith(f"{OTHER}: 3 paths")


def test_it_is_what_the_command_makes(open_shot, shot, tmp_path, scratch):
    wait(open_shot, CHAR, OTHER)
    (tmp_path / "apart").mkdir()
    result = mtex_usd.process(shot, out=tmp_path / "apart" / "shot.mtex.usd")[0]
    command = Usd.Stage.Open(str(result.stage))
    for skeleton in (f"{CHAR}/Rig/Skel", f"{CHAR}/Rig/FaceSkel", f"{OTHER}/Rig/Skel"):
        np.testing.assert_array_equal(shown(open_shot.model.stage, skeleton), shown(command, skeleton))


def test_the_menu_works_on_what_was_made(open_shot, scratch, tmp_path, boxes):
    wait(open_shot, BODY)
    open_shot.trigger("Next Path")
    open_shot.trigger("Accept Path...")
    from mtex_usd.usdview import window

    accept = window.open_window("accept")
    accept.field.setText(str(tmp_path / "accepted.usda"))
    accept._accept()
    assert boxes == []
    fresh = Usd.Stage.Open(str(tmp_path / "accepted.usda"))
    assert fresh.GetPrimAtPath(OTHER).GetVariantSet("mtex").GetVariantSelection() == "path_02"
    np.testing.assert_array_equal(shown(fresh, f"{OTHER}/Rig/Skel"), shown(open_shot.model.stage, f"{OTHER}/Rig/Skel"))
    assert list(fresh.GetRootLayer().subLayerPaths) == ["./accepted.mtex.usd", "./shot.usda"]


def test_a_second_sketch_joins_the_first_and_a_second_run_replaces_its_own(open_shot, scratch):
    stage = open_shot.model.stage
    wait(open_shot, f"{CHAR}/Anim")
    open_shot.select(CHAR)
    open_shot.trigger("Next Path")
    wait(open_shot, f"{CHAR}/Face")
    assert [(found.name, str(found.source)) for found in find_sets(stage)] == [
        ("mtex", f"{CHAR}/Anim"),
        ("mtex_Face", f"{CHAR}/Face"),
    ]
    assert stage.GetPrimAtPath(CHAR).GetVariantSet("mtex").GetVariantSelection() == "path_02"
    wait(open_shot, f"{CHAR}/Anim_mtex")
    assert len(find_sets(stage)) == 2
    assert len(stage.GetSessionLayer().subLayerPaths) == 1


def test_edits_of_the_session_count(open_shot, scratch):
    stage = open_shot.model.stage
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        stage.GetPrimAtPath(f"{OTHER}/Anim").GetAttribute("mtex:paths").Set(2)
    wait(open_shot, BODY)
    assert list_paths(stage, find_sets(stage)[0]) == ("path_01", "path_02")


def test_other_sublayers_of_the_session_stay(open_shot, scratch):
    stage = open_shot.model.stage
    mine = Sdf.Layer.CreateAnonymous()
    stage.GetSessionLayer().subLayerPaths.append(mine.identifier)
    wait(open_shot, BODY)
    wait(open_shot, BODY)
    assert list(stage.GetSessionLayer().subLayerPaths)[1:] == [mine.identifier]


@pytest.mark.parametrize(("rate", "codes"), [(30.0, 30.0), (24.0, 120.0)])
def test_rates_other_than_usds_own_keep_their_times(tmp_path, boxes, scratch, rate, codes):
    usdview = Usdview(Usd.Stage.Open(str(write_shot(tmp_path, timeCodesPerSecond=codes, framesPerSecond=rate)))).load()
    wait(usdview, BODY)
    stage = usdview.model.stage
    times = stage.GetPrimAtPath(f"{OTHER}/Anim_mtex").GetAttribute("rotations").GetTimeSamples()
    assert boxes == []
    assert times[0] == 1.0
    assert times[1] - times[0] == pytest.approx(codes / rate)


def test_a_thin_root_is_processed_from_the_original(tmp_path, boxes, scratch):
    thin = write_processed(tmp_path)
    usdview = Usdview(Usd.Stage.Open(str(thin))).load()
    before = shown(usdview.model.stage, f"{OTHER}/Rig/Skel")
    usdview.select(OTHER)
    usdview.trigger("Next Path")
    usdview.trigger("Previous Path")
    wait(usdview, OTHER)
    assert boxes == []
    assert [found.name for found in find_sets(usdview.model.stage)] == ["mtex", "mtex_Face", "mtex"]
    np.testing.assert_array_equal(shown(usdview.model.stage, f"{OTHER}/Rig/Skel"), before)


def test_the_loop_goes_on_meanwhile(open_shot, scratch):
    ticks = []
    timer = QtCore.QTimer()
    timer.timeout.connect(lambda: ticks.append(time.monotonic()))
    timer.start(10)
    wait(open_shot, BODY)
    longest = max(np.diff(ticks))
    assert len(ticks) > 10
    assert longest < 2.0


def test_cancel_leaves_nothing_behind(open_shot, shot, scratch, boxes):
    stage, before = open_shot.model.stage, files(shot.parent)
    session = stage.GetSessionLayer().ExportToString()
    job = process(open_shot, BODY)
    wait_until(lambda: "begun" in job.answer)
    child = job.process.processId()
    (cancel,) = [b for b in job.dialog.findChildren(QtWidgets.QPushButton) if b.text() == "Cancel"]
    assert list(scratch.iterdir()) != []
    cancel.click()
    wait_until(lambda: process_job.running_job() is None)
    assert "made" not in job.answer
    assert list(scratch.iterdir()) == []
    assert files(shot.parent) == before
    assert stage.GetSessionLayer().ExportToString() == session
    assert find_sets(stage) == ()
    assert boxes == []
    assert open_shot.last_message == "Processing was cancelled; nothing has changed."
    with pytest.raises(ProcessLookupError):
        os.kill(child, 0)


def test_closing_the_progress_window_cancels_too(open_shot, scratch):
    job = process(open_shot, BODY)
    wait_until(lambda: "begun" in job.answer)
    job.dialog.close()
    wait_until(lambda: process_job.running_job() is None)
    assert list(scratch.iterdir()) == []
    assert job.cancelled


def test_what_is_wrong_with_a_sketch_is_said_in_a_box(open_shot, scratch, boxes, capfd):
    stage = open_shot.model.stage
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        stage.GetPrimAtPath(f"{OTHER}/Anim").GetAttribute("mtex:synthesize").Set(["LeftWing"])
    wait(open_shot, BODY)
    (text,) = boxes
    assert "LeftWing" in text
    assert "there is" in text or "expected" in text
    assert "Traceback" not in text + capfd.readouterr().err
    assert list(scratch.iterdir()) == []
    assert find_sets(stage) == ()


def test_an_animation_without_a_recipe_is_said(open_shot, scratch, boxes):
    wait(open_shot, f"{OTHER}/Takes/walk_1")
    assert "has no recipe" in boxes[0]


@pytest.mark.parametrize("picked", ["/", "/World", "/World/Box"])
def test_nothing_that_plays_is_said_before_anything_starts(open_shot, scratch, boxes, picked):
    assert process(open_shot, picked) is None
    assert boxes[0].startswith("nothing is selected" if picked == "/" else "nothing selected plays an animation")
    assert list(scratch.iterdir()) == []


def test_unsaved_edits_of_files_are_refused(open_shot, scratch, boxes):
    stage = open_shot.model.stage
    stage.GetRootLayer().comment = "unsaved"
    assert process(open_shot, BODY) is None
    assert boxes == [f"{stage.GetRootLayer().identifier} has unsaved edits. Save or reload it first."]
    assert list(scratch.iterdir()) == []
    stage.GetRootLayer().Reload(force=True)


def test_a_second_job_waits_for_the_first(open_shot, scratch, boxes):
    job = process(open_shot, BODY)
    assert process(open_shot, CHAR) is job
    assert boxes == ["an animation is being processed. Wait for it, or cancel it."]
    job.cancel()
    wait_until(lambda: process_job.running_job() is None)


def test_a_child_that_dies_is_said(open_shot, scratch, boxes):
    job = process(open_shot, BODY)
    wait_until(lambda: "begun" in job.answer)
    job.process.kill()
    wait_until(lambda: process_job.running_job() is None)
    assert boxes == ["The process that makes paths ended before its time. The terminal has the details."]
    assert list(scratch.iterdir()) == []


def test_a_program_that_does_not_start_is_said(open_shot, scratch, boxes, monkeypatch):
    monkeypatch.setattr(process_job, "make_command", lambda _: ["/no/such/python", "-c", ""])
    open_shot.select(BODY)
    open_shot.trigger("Process This Animation...")
    wait_until(lambda: process_job.running_job() is None)
    assert boxes[0].startswith("The process that makes paths does not start")
    assert list(scratch.iterdir()) == []


def test_another_stage_opened_meanwhile_is_not_touched(open_shot, scratch, tmp_path):
    (tmp_path / "second").mkdir()
    second = Usd.Stage.Open(str(write_shot(tmp_path / "second")))
    assert process(open_shot, BODY)
    open_shot.model.replace(second)
    wait_until(lambda: process_job.running_job() is None)
    assert second.GetSessionLayer().empty
    assert "Another stage was opened" in open_shot.last_message


def test_what_was_picked_stands_for_the_animators_own(processed):
    stage = Usd.Stage.Open(str(processed))

    def find(*paths):
        return [str(path) for path in find_animations(stage, [stage.GetPrimAtPath(path) for path in paths])]

    assert find(BODY) == [f"{OTHER}/Anim"]
    assert find(f"{CHAR}/Rig/Skel") == [f"{CHAR}/Anim"]
    assert find(f"{CHAR}/Anim_mtex", f"{CHAR}/Anim") == [f"{CHAR}/Anim"]
    assert sorted(find(CHAR)) == [f"{CHAR}/Anim", f"{CHAR}/Face"]
    assert sorted(find(f"{CHAR}/Rig")) == [f"{CHAR}/Anim", f"{CHAR}/Face"]


def test_a_stage_without_a_file_has_nothing_to_give(tmp_path):
    with pytest.raises(mtex_usd.InputError, match="the stage has no file that another process could open"):
        write_snapshot(Usd.Stage.CreateInMemory(), Path(tmp_path))
