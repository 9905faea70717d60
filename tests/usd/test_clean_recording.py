"""The clean-up on recordings, and what a take library keeps of it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

from mtex_usd.errors import InputError
from mtex_usd.formats.recording import Recording
from mtex_usd.importing import import_takes, list_takes
from mtex_usd.usd.clean_recording import clean_recording
from mtex_usd.usd.custom_data import from_metadata
from tests.cleaning_support import dirty_clip, make_walk, write_bvh
from tests.synthetic import LEFT_LEG


def make_recording(clip):
    return Recording(
        source=Path("walk.bvh"),
        names=tuple(joint.rpartition("/")[2] for joint in clip.joints),
        parents=tuple(int(parent) for parent in clip.parents),
        offsets=clip.skeleton.rest_translations,
        rate=clip.rate,
        rotations=clip.rotations,
        translations=clip.translations,
        meters_per_unit=0.01,
        up_axis="Y",
    )


def test_a_recording_is_cleaned_like_its_clip():
    recording = make_recording(dirty_clip())
    cleaned = clean_recording(recording, ("auto",))
    assert [(c.step, c.first, c.last) for c in cleaned.changes] == [
        ("leading", 0, 0),
        ("flips", 101, 106),
        ("flips", 101, 106),
    ]
    assert cleaned.recording.frame_count == recording.frame_count - 1
    assert cleaned.recording.skipped_frames == 1


def test_frames_count_in_the_file_after_skipping():
    recording = make_recording(dirty_clip()).without_first(1)
    cleaned = clean_recording(recording, ("leading", "flips"))
    assert {(c.step, c.first, c.last) for c in cleaned.changes} == {("flips", 101, 106)}


def test_no_steps_give_the_recording_back():
    recording = make_recording(dirty_clip())
    assert clean_recording(recording, ()).recording is recording
    clean = make_recording(make_walk())
    assert clean_recording(clean, ("auto",)).recording is clean


@pytest.mark.parametrize("up_axis", ["Y", "Z"])
def test_the_floor_is_that_of_the_files_world(up_axis):
    clip = make_walk()
    recording = replace(make_recording(clip), up_axis=up_axis)
    placement = np.eye(4)
    if up_axis == "Z":
        placement[:3, :3] = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]
    lowest = clip.skeleton.world_pose(clip.rotations, clip.translations)[0][..., 1].min()
    placement[3, "XYZ".index(up_axis)] = -lowest - 3.0
    sunk = clean_recording(replace(recording, placement=placement), ("floor",))
    assert any("3.0 cm below the floor" in note.what for note in sunk.notes)
    placement[3, "XYZ".index(up_axis)] = -lowest
    assert clean_recording(replace(recording, placement=placement), ("floor",)).notes == ()


def test_a_single_joint_is_no_trouble():
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (20, 1, 1))
    places = np.random.default_rng(0).standard_normal((20, 1, 3))
    lone = Recording(
        source=Path("a"),
        names=("a",),
        parents=(-1,),
        offsets=np.zeros((1, 3)),
        rate=30.0,
        rotations=turns,
        translations=places,
    )
    assert clean_recording(lone, ("auto",)).recording is lone


def test_the_library_keeps_what_was_changed(tmp_path):
    source = write_bvh(dirty_clip(), tmp_path / "walk.bvh")
    result = import_takes([source], out=tmp_path / "takes.usda", clean=["auto"])
    (cleaned,) = result.cleaned
    assert cleaned.prim_path == result.takes[0].prim_path
    assert [change.step for change in cleaned.changes] == ["leading", "flips", "flips"]
    stage = Usd.Stage.Open(str(tmp_path / "takes.usda"))
    data = stage.GetPrimAtPath(cleaned.prim_path).GetCustomData()["mtex"]
    kept = from_metadata(data["changes"])
    assert [(c["step"], c["first"], c["last"]) for c in kept] == [
        ("leading", 0, 0),
        ("flips", 101, 106),
        ("flips", 101, 106),
    ]
    assert kept[1]["joint"] == LEFT_LEG
    assert data["skippedFrames"] == 1


def test_without_clean_up_nothing_is_cleaned_or_said(tmp_path):
    source = write_bvh(dirty_clip(), tmp_path / "walk.bvh")
    result = import_takes([source], out=tmp_path / "takes.usda")
    assert result.cleaned == ()
    assert result.takes[0].frame_count == 241


def test_cleaned_otherwise_it_is_another_take(tmp_path):
    source = write_bvh(dirty_clip(), tmp_path / "walk.bvh")
    for clean in ((), ("auto",), ("auto",), ("leading",)):
        import_takes([source], out=tmp_path / "takes.usda", clean=clean)
    assert [entry.frame_count for entry in list_takes(tmp_path / "takes.usda")] == [241, 240, 240]


def test_an_unknown_step_stops_before_anything_is_read(tmp_path):
    with pytest.raises(InputError, match="unknown step of the clean-up: polish; expected auto or any of leading"):
        import_takes([tmp_path / "missing.bvh"], out=tmp_path / "takes.usda", clean=["polish"])
    assert not (tmp_path / "takes.usda").exists()
