"""Tracks as fragments: what is written comes back, and edits do what they do elsewhere."""

from dataclasses import replace
from pathlib import Path

import opentimelineio as otio
import pytest
from hypothesis import given

from mtex_usd.editorial.placing import PlacedTrack, place_track
from mtex_usd.editorial.reading import read_timeline
from tests.editorial.tracks import FRAGMENTS, LIMIT, edited, media, timelines, trim, write


@given(timelines())
def test_any_sequence_of_fragments_comes_back(tmp_path_factory: pytest.TempPathFactory, case) -> None:
    shot, grids, fragments = case
    at_shot = {name: pair[1] for name, pair in grids.items()}
    file_path = write(tmp_path_factory.mktemp("law"), fragments, shot, media(grids, 0), at_shot)
    (track,) = read_timeline(file_path).tracks
    placed = place_track(track, shot, media(grids, 1), max_stretch=LIMIT)
    assert placed == PlacedTrack(fragments=fragments, notes=())


@given(timelines())
def test_tracks_are_as_long_as_the_shot_and_media_have_their_own_rate(tmp_path_factory, case) -> None:
    shot, grids, fragments = case
    at_shot = {name: pair[1] for name, pair in grids.items()}
    file_path = write(tmp_path_factory.mktemp("law"), fragments, shot, media(grids, 0), at_shot)
    timeline = otio.adapters.read_from_file(str(file_path))
    (track,) = timeline.tracks
    frames = [clip.duration().to_seconds() * shot.rate for clip in track]
    lengths = [fragment.last - fragment.first for fragment in fragments]
    assert frames == pytest.approx([*lengths[:-1], lengths[-1] + 1])
    assert track.duration().to_seconds() * shot.rate == pytest.approx(shot.frame_count)
    for clip, fragment in zip(track, fragments, strict=True):
        own = grids[fragment.take][0]
        for a_range in (clip.source_range, clip.media_reference.available_range):
            assert a_range.start_time.rate == a_range.duration.rate == own.rate
        available = clip.media_reference.available_range
        assert available.duration.value == own.frame_count
        assert available.start_time.value * own.time_codes_per_frame == pytest.approx(own.start)
        begin = at_shot[fragment.take].time_code_at(fragment.take_first)
        assert clip.source_range.start_time.value * own.time_codes_per_frame == pytest.approx(begin)
        stretch = (fragment.take_last - fragment.take_first) / (fragment.last - fragment.first)
        assert clip.effects[0].time_scalar == pytest.approx(stretch)


def test_swapped_clips_take_each_others_places(tmp_path: Path) -> None:
    def swap(track):
        clips = [track.pop(0), track.pop(0)]
        track.insert(0, clips[0])
        track.insert(0, clips[1])

    placed = edited(tmp_path, swap)
    assert [(f.take, f.first, f.last) for f in placed.fragments[:2]] == [("/Takes/run", 0, 20), ("/Takes/walk", 20, 40)]
    assert placed.fragments[2] == FRAGMENTS[2]


def test_a_cut_moves_with_what_is_played(tmp_path: Path) -> None:
    def roll(track):  # the first clip grows by five frames of the shot, the second loses them at its head
        trim(track[0], length=25.0)
        trim(track[1], begin=25.0, length=-25.0)

    first, second, third = edited(tmp_path, roll).fragments
    assert first == replace(FRAGMENTS[0], last=25, take_last=47.5)
    assert second == replace(FRAGMENTS[1], first=25, take_first=105.0)
    assert third == FRAGMENTS[2]


def cut(track: otio.schema.Track) -> None:
    """Cut the second clip in two."""
    half = track[1].clone()
    trim(track[1], length=-50.0)
    trim(half, begin=50.0, length=-50.0)
    track.insert(2, half)


def test_a_razor_cut_alone_changes_nothing(tmp_path: Path) -> None:
    assert edited(tmp_path, cut) == PlacedTrack(fragments=FRAGMENTS, notes=())


def test_what_was_cut_and_moved_stays_apart(tmp_path: Path) -> None:
    def cut_twice(track):
        cut(track)
        track[2].effects[0].time_scalar = 1.25

    fragments = edited(tmp_path, cut_twice).fragments
    assert fragments[1] == replace(FRAGMENTS[1], last=30, take_last=110.0)
    assert fragments[2] == replace(FRAGMENTS[1], first=30, take_first=110.0, take_last=122.5)


def test_another_take_by_its_media_alone(tmp_path: Path) -> None:
    def relink(track):
        track[1].media_reference = otio.schema.ExternalReference(target_url="file:///elsewhere/all%20takes.usd")
        track[1].media_reference.name = "/More/walk"

    placed = edited(tmp_path, relink)
    assert placed.fragments[1] == replace(FRAGMENTS[1], take="/More/walk")
    assert placed.notes == ("track path_01: run at 121: was /Takes/run, its media is /More/walk now",)


def test_another_stretch(tmp_path: Path) -> None:
    def slow(track):
        track[1].effects[0].time_scalar = 0.625

    assert edited(tmp_path, slow).fragments[1] == replace(FRAGMENTS[1], take_last=112.5)


def test_a_clip_without_a_warp_plays_as_recorded(tmp_path: Path) -> None:
    placed = edited(tmp_path, lambda track: track[0].effects.clear())
    assert placed.fragments[0] == replace(FRAGMENTS[0], take_last=30.0)


def test_a_cut_between_frames_is_moved_and_said(tmp_path: Path) -> None:
    def roll(track):
        trim(track[0], length=1.0)
        trim(track[1], begin=1.0, length=-1.0)

    placed = edited(tmp_path, roll)
    assert (placed.fragments[0].last, placed.fragments[1].first) == (20, 20)
    assert placed.notes == ("track path_01: run at 121.2: the cut lies between frames and is moved to the nearest",)


def test_a_whole_take_may_be_used(tmp_path: Path) -> None:
    def widen(track):
        track[1].source_range = otio.opentime.TimeRange(
            otio.opentime.RationalTime(0, 120), otio.opentime.RationalTime(100, 120)
        )
        track[1].effects[0].time_scalar = 4.0
        track[1].source_range = otio.opentime.TimeRange(
            otio.opentime.RationalTime(1201 - 400, 120), otio.opentime.RationalTime(100, 120)
        )

    fragment = edited(tmp_path, widen).fragments[1]
    assert (fragment.take_first, fragment.take_last) == pytest.approx((160.2, 240.0))
