"""Timelines as files: what is no timeline is told so, and what is not ours to replace is left alone."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import opentimelineio as otio
import pytest

from mtex_usd.editorial.files import check_timeline_target, write_timeline_text
from mtex_usd.editorial.reading import read_timeline, select_tracks
from mtex_usd.editorial.records import TimelineHead
from mtex_usd.editorial.writing import build_timeline
from mtex_usd.errors import InputError
from tests.editorial.tracks import FRAGMENTS, GRIDS, SHOT, make_paths, media, write


@pytest.fixture
def edit(tmp_path: Path) -> Path:
    """A timeline as we write it."""
    return write(tmp_path, FRAGMENTS, SHOT, media(GRIDS, 0), {name: pair[1] for name, pair in GRIDS.items()})


BAD_TEXTS = {
    "nothing": ("", "is damaged or no timeline; expected an OpenTimelineIO file"),
    "half": ('{"OTIO_SCHEMA": "Timeline.1", "tracks": {', "is damaged or no timeline"),
    "a layer": ("#usda 1.0\n", "is damaged or no timeline"),
    "other JSON": ('{"version": 1, "results": []}', "found JSON that is not OpenTimelineIO's"),
    "a list": ('["OTIO_SCHEMA"]', "found JSON that is not OpenTimelineIO's"),
    "a deep one": ('{"OTIO_SCHEMA": "Timeline.1", "metadata": ' + '{"a":' * 300 + "1" + "}" * 301, "200 levels"),
    "a bottomless one": ('{"OTIO_SCHEMA": "Timeline.1", "a": ' + "[" * 200_000 + "]" * 200_000 + "}", "is damaged"),
    "a clip": (otio.schema.Clip("walk").to_json_string(), "is no timeline; expected a Timeline; found Clip walk"),
    "an unknown schema": ('{"OTIO_SCHEMA": "Reel.1"}', "is no timeline"),
    "of the future": ('{"OTIO_SCHEMA": "Timeline.99"}', "is damaged; .*unsupported schema version"),
    "wrong types": ('{"OTIO_SCHEMA": "Timeline.1", "tracks": 3}', "is damaged"),
    "of two schemas": (
        '{"OTIO_SCHEMA": "Timeline.1", "tracks": [{"OTIO_SCHEMA": "Clip.1", "media_references": {"a": 1}}]}',
        "a clip that is of the first schema and of a later one",
    ),
    "nothing in it": ('{"OTIO_SCHEMA": "Timeline.1", "tracks": null}', "is (damaged|no timeline)"),
    "parts missing": (
        '{"OTIO_SCHEMA": "Timeline.1", "tracks": {"OTIO_SCHEMA": "Stack.1", "effects": 3}}',
        "is damaged",
    ),
    "no tracks": (otio.schema.Timeline("empty").to_json_string(), "has no track; expected at least one"),
}


@pytest.mark.parametrize("kind", BAD_TEXTS)
def test_what_is_no_timeline_is_refused(tmp_path: Path, kind: str) -> None:
    text, message = BAD_TEXTS[kind]
    file = tmp_path / "bad.otio"
    file.write_text(text)
    with pytest.raises(InputError, match=rf"bad\.otio.*{message}"):
        read_timeline(file)


def test_what_is_no_text_is_refused(tmp_path: Path) -> None:
    (tmp_path / "bad.otio").write_bytes(b"PXR-USDC\xff\x00")
    with pytest.raises(InputError, match="it is no text"):
        read_timeline(tmp_path / "bad.otio")


@pytest.mark.parametrize("band", [0, -1, "4", 2.5, True, {}])
def test_a_bad_band_is_refused(edit: Path, band: object) -> None:
    content = json.loads(edit.read_text())
    content["metadata"]["mtex"]["options"] = {"band": band}
    edit.write_text(json.dumps(content))
    with pytest.raises(InputError, match="bad option band; expected a whole number of at least 1"):
        read_timeline(edit)


def nest(timeline: otio.schema.Timeline) -> None:
    timeline.tracks.append(otio.schema.Stack(name="inner"))


def trim_all(timeline: otio.schema.Timeline) -> None:
    timeline.tracks.source_range = timeline.tracks[0].trimmed_range()


@pytest.mark.parametrize(
    ("change", "message"), [(nest, "Stack inner lies between the tracks"), (trim_all, "as a whole is trimmed")]
)
def test_edits_of_the_whole_are_refused(edit: Path, change: Callable, message: str) -> None:
    timeline = otio.adapters.read_from_file(str(edit))
    change(timeline)
    otio.adapters.write_to_file(timeline, str(edit))
    with pytest.raises(InputError, match=message):
        read_timeline(edit)


def test_sound_is_left_out_and_strange_metadata_is_none(edit: Path) -> None:
    timeline = otio.adapters.read_from_file(str(edit))
    timeline.tracks.append(otio.schema.Track("music", kind=otio.schema.TrackKind.Audio))
    timeline.metadata["mtex"] = "mine"
    timeline.tracks[0].metadata["mtex"]["anim"] = 3
    otio.adapters.write_to_file(timeline, str(edit))
    read = read_timeline(edit)
    assert read.notes == ("track music is sound and left out",)
    assert [(track.name, track.anim, track.model) for track in read.tracks] == [("path_01", "", "/A")]
    assert read.band is None


def test_tracks_are_found_by_name(edit: Path) -> None:
    timeline = read_timeline(edit)
    assert select_tracks(timeline, ()) == timeline.tracks == select_tracks(timeline, ["path_01"])
    with pytest.raises(InputError, match="has no track path_2; expected one of path_01"):
        select_tracks(timeline, ["path_01", "path_2"])


def test_ours_is_replaced_also_after_otioconvert(edit: Path) -> None:
    text = edit.read_text()
    otio.adapters.write_to_file(otio.adapters.read_from_file(str(edit)), str(edit))
    assert edit.read_text() != text
    write_timeline_text(edit, text)
    assert edit.read_text() == text
    assert [file.name for file in edit.parent.iterdir()] == ["edit.otio"]


def test_what_somebody_edited_is_left_alone(edit: Path) -> None:
    timeline = otio.adapters.read_from_file(str(edit))
    timeline.tracks[0][0].name = "better"
    otio.adapters.write_to_file(timeline, str(edit))
    with pytest.raises(InputError, match="was edited since usdmtex wrote it; it is left alone"):
        check_timeline_target(edit)


@pytest.mark.parametrize("text", ["", "notes", '{"OTIO_SCHEMA": "Timeline.1", "metadata": {}}', '{"metadata": 3}'])
def test_what_is_not_ours_is_left_alone(tmp_path: Path, text: str) -> None:
    file = tmp_path / "cut.otio"
    file.write_text(text)
    with pytest.raises(InputError, match="exists and was not written by usdmtex"):
        write_timeline_text(file, "new")
    assert file.read_text() == text


def test_places_that_cannot_be_written_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"is no timeline name; expected a name ending in \.otio"):
        check_timeline_target(tmp_path / "edit.xml")
    with pytest.raises(InputError, match="there is no folder"):
        check_timeline_target(tmp_path / "none" / "edit.otio")
    (tmp_path / "folder.otio").mkdir()
    with pytest.raises(InputError, match="it is a folder"):
        check_timeline_target(tmp_path / "folder.otio")


@pytest.mark.parametrize(
    ("places", "names"),
    [
        ([("/A/Sketch", "/A")], ["path_01"]),
        ([("/A/Walk", "/A"), ("/A/Run", "/A")], ["Walk_path_01", "Run_path_01"]),
        ([("/Walk", "/A"), ("/Walk", "/B")], ["A_Walk_path_01", "B_Walk_path_01"]),
        ([("/X/Walk", "/X/A"), ("/Y/Walk", "/Y/A")], ["A_Walk_1_path_01", "A_Walk_2_path_01"]),
    ],
)
def test_tracks_of_several_sketches_are_all_called_differently(places: list[tuple[str, str]], names: list[str]) -> None:
    takes, at_shot = media(GRIDS, 0), {name: pair[1] for name, pair in GRIDS.items()}
    sketches = [replace(make_paths(FRAGMENTS, SHOT, at_shot), anim=anim, model=model) for anim, model in places]
    head = TimelineHead(shot=Path("/shot.usda"), version="1", options={"band": 4})
    content = json.loads(build_timeline(head, sketches, takes))
    assert [track["name"] for track in content["tracks"]["children"]] == names
    assert [track["metadata"]["mtex"]["variant"] for track in content["tracks"]["children"]] == ["path_01"] * len(names)
    assert content["metadata"]["mtex"]["options"] == {"band": 4}
    assert content["metadata"]["mtex"]["shot"] == "/shot.usda"
