"""``usdmtex-conform``: timelines edited as other applications do, made into variants and read back from the layers."""

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import opentimelineio as otio
import pytest
from pxr import Sdf, Usd

from mtex_usd.cli.usdmtex_conform import main
from tests.cli.support import MODEL, SKETCH, Capture, contents, read_custom_data, variant_names
from tests.editorial.support import read_samples, read_timeline, write_shot, write_timeline

REACH = 14  # frames that bands 2 and 3, the texture, see on either side
Track = otio.schema.Track


@pytest.fixture
def shot(shot_folder: Path) -> Path:
    """A walk that was processed, and its timeline."""
    write_shot("walk.usda")
    return shot_folder


def refused(capsys: Capture, folder: Path, *arguments: str, code: int = 2) -> str:
    """Run what must fail: nothing is written or printed; gives the message."""
    before = contents(folder)
    assert main(arguments) == code
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("usdmtex-conform: error: ")
    assert "Traceback" not in captured.err
    assert contents(folder) == before
    return captured.err


def changed_times(variant: str, *, layer: str = "walk.conform.usd", other: str = "path_01") -> list[float]:
    """Time codes at which a variant made from a timeline differs from one of usdmtex."""
    ours, theirs = read_samples(layer, MODEL, variant), read_samples(layer.replace("conform", "mtex"), MODEL, other)
    assert ours.keys() == theirs.keys()
    assert all(ours[name].keys() == theirs[name].keys() for name in ours)
    differing = {t for name in ours for t in ours[name] if ours[name][t].tobytes() != theirs[name][t].tobytes()}
    return sorted(differing)


def edit(change: Callable[[Track], object]) -> None:
    """Change the first track as another application would."""
    timeline = read_timeline()
    change(timeline.tracks[0])
    write_timeline(timeline)


def swap(track: Track, first: int) -> None:
    """Let two neighbouring clips change places."""
    clips = [track.pop(first), track.pop(first)]
    for clip in clips:
        track.insert(first, clip)


@pytest.mark.parametrize("name", ["walk", "walk_to_stop", "phrase"])
def test_a_timeline_without_edits_gives_the_same_samples(shot_folder: Path, name: str) -> None:
    folder = Path(__file__).resolve().parents[2] / "sample_stages"
    (shot_folder / f"{name}.usda").write_bytes((folder / f"{name}.usda").read_bytes())
    write_shot(f"{name}.usda")
    assert main(["edit.otio", f"{name}.usda", "-q"]) == 0
    names = variant_names(f"{name}.conform.usd")
    assert names == variant_names(f"{name}.mtex.usd") == ["original", *(f"path_0{n}" for n in range(1, 6))]
    for variant in names[1:]:
        assert changed_times(variant, layer=f"{name}.conform.usd", other=variant) == []


def test_contacts_are_held_as_usdmtex_holds_them(shot_folder: Path) -> None:
    stage = Usd.Stage.Open("walk.usda")
    stage.GetPrimAtPath(SKETCH).CreateAttribute("mtex:contacts", Sdf.ValueTypeNames.Token).Set("detect")
    stage.GetRootLayer().Save()
    write_shot("walk.usda")
    assert main(["edit.otio", "walk.usda", "-q"]) == 0
    assert changed_times("path_01") == changed_times("path_03", other="path_03") == []
    assert read_custom_data("walk.conform.stage.usda", "path_01")["contacts"]


def test_the_band_of_the_command_line_is_kept(shot_folder: Path) -> None:
    write_shot("walk.usda", band=5)
    assert main(["edit.otio", "walk.usda", "-q"]) == 0
    assert changed_times("path_01") == []
    timeline = read_timeline()
    assert timeline.tracks[0][0].metadata["mtex"]["band"] == 5


@pytest.mark.parametrize("rate", [23.976, 30, 60, 120])
def test_takes_of_other_rates_come_back_the_same(shot_folder: Path, rate: float) -> None:
    takes = shot_folder / "takes.usda"
    takes.write_text(takes.read_text().replace("PerSecond = 24", f"PerSecond = {rate}"))
    write_shot("walk.usda")
    assert read_timeline().tracks[0][0].source_range.start_time.rate == pytest.approx(rate)
    assert main(["edit.otio", "walk.usda", "-q"]) == 0
    assert changed_times("path_01") == changed_times("path_02", other="path_02") == []


def test_a_shot_of_other_time_codes_comes_back_the_same(shot_folder: Path) -> None:
    layer = Sdf.Layer.CreateNew("shot.usda")
    layer.subLayerPaths = ["./walk.usda"]
    layer.subLayerOffsets[0] = Sdf.LayerOffset(202.5)
    layer.framesPerSecond, layer.timeCodesPerSecond = 24.0, 48.0
    layer.startTimeCode, layer.endTimeCode = 202.0, 600.0
    layer.Save()
    write_shot("shot.usda")
    timeline = read_timeline()
    assert timeline.global_start_time == otio.opentime.RationalTime(101.25, 24)
    assert timeline.duration() == otio.opentime.RationalTime(171, 24)
    assert timeline.tracks[0][0].media_reference.available_range.start_time.value == 101.25
    assert main(["edit.otio", "shot.usda", "-q"]) == 0
    assert changed_times("path_01", layer="shot.conform.usd") == []


def test_otioconvert_takes_nothing_away(shot: Path) -> None:
    convert = [sys.executable, "-m", "opentimelineio.console.otioconvert"]
    subprocess.run([*convert, "-i", "edit.otio", "-o", "again.otio"], check=True)
    assert read_timeline("again.otio").is_equivalent_to(read_timeline())
    assert main(["again.otio", "walk.usda", "-q"]) == 0
    assert changed_times("path_01") == changed_times("path_05", other="path_05") == []


def test_otiostat_finds_nothing_odd(shot: Path) -> None:
    stat = [sys.executable, "-m", "opentimelineio.console.otiostat", "edit.otio"]
    said = subprocess.run(stat, check=True, capture_output=True, text=True).stdout
    for line in ("Tracks are the same length: True", "number of clips: 60", "total duration: RationalTime(171, 24)"):
        assert line in said
    assert "Tracks with non standard types: 0" in said


def test_swapped_clips_change_their_frames_and_the_joins(shot: Path) -> None:
    track = read_timeline().tracks[0]
    ranges = [track.range_of_child_at_index(i) for i in range(len(track))]
    edit(lambda track: swap(track, 5))
    assert main(["edit.otio", "walk.usda", "--track", "path_01", "-q"]) == 0
    changed = changed_times("path_01")
    # The clips beside them end where they now meet, which moves them up to their other ends.
    first, last = ranges[4].start_time.value, ranges[7].end_time_exclusive().value
    assert set(np.arange(ranges[5].start_time.value, ranges[6].end_time_exclusive().value)) <= set(changed)
    assert first - REACH < changed[0] and changed[-1] < last + REACH
    fragments = read_custom_data("walk.conform.stage.usda", "path_01")["fragments"]
    old = read_custom_data("walk.mtex.stage.usda", "path_01")["fragments"]
    assert [f["takeStart"] for f in fragments[5:7]] == [f["takeStart"] for f in (old[6], old[5])]
    assert [*fragments[:5], *fragments[7:]] == [*old[:5], *old[7:]]
    assert all(new["distance"] > was["distance"] for new, was in zip(fragments[5:7], (old[6], old[5]), strict=True))


def test_cuts_may_lie_anywhere(shot: Path) -> None:
    """Away from the breaks of sketch and takes; what is played stays the same, so only the joins differ."""

    def roll(track: Track) -> None:
        for clip, begin, length in ((track[2], 0, 2), (track[3], 2, -2)):
            old = clip.source_range
            clip.source_range = otio.opentime.TimeRange(
                old.start_time + otio.opentime.RationalTime(begin, 24),
                old.duration + otio.opentime.RationalTime(length, 24),
            )

    edit(roll)
    assert main(["edit.otio", "walk.usda", "--track", "path_01", "-q"]) == 0
    fragments = read_custom_data("walk.conform.stage.usda", "path_01")["fragments"]
    old = read_custom_data("walk.mtex.stage.usda", "path_01")["fragments"]
    assert fragments[2]["end"] == fragments[3]["start"] == old[2]["end"] + 2.0
    assert fragments[3]["end"] == old[3]["end"]
    changed = changed_times("path_01")
    assert old[1]["start"] - REACH < changed[0] and changed[-1] < old[4]["end"] + REACH


def test_a_razor_cut_alone_changes_nothing(shot: Path) -> None:
    def cut(track: Track) -> None:
        half, five = track[4].clone(), otio.opentime.RationalTime(5, 24)
        taken = otio.opentime.RationalTime(5 * half.effects[0].time_scalar, 24)
        old = half.source_range
        track[4].source_range = otio.opentime.TimeRange(old.start_time, five)
        half.source_range = otio.opentime.TimeRange(old.start_time + taken, old.duration - five)
        track.insert(5, half)

    edit(cut)
    assert main(["edit.otio", "walk.usda", "--track", "path_01", "-q"]) == 0
    assert changed_times("path_01") == []
    assert len(read_custom_data("walk.conform.stage.usda", "path_01")["fragments"]) == 12


def test_another_take_and_another_stretch(shot: Path, capsys: Capture) -> None:
    def relink(track: Track) -> None:
        track[0].media_reference.metadata["mtex"]["take"] = "/Takes/walk_brisk"
        track[0].effects[0].time_scalar = 0.75

    edit(relink)
    assert main(["edit.otio", "walk.usda", "--track", "path_01"]) == 0
    captured = capsys.readouterr()
    assert "walk_slow at 0: was /Takes/walk_slow, its media is /Takes/walk_brisk now" in captured.err
    fragment = read_custom_data("walk.conform.stage.usda", "path_01")["fragments"][0]
    assert fragment["take"] == "/Takes/walk_brisk"
    length = fragment["end"] - fragment["start"]
    assert fragment["takeEnd"] - fragment["takeStart"] == pytest.approx(0.75 * length)


def test_tracks_name_their_variants(shot: Path, capsys: Capture) -> None:
    timeline = read_timeline()
    for track, name in zip(timeline.tracks, ("director's cut", "original", "take 2", "take 2", ""), strict=True):
        track.name = name
    write_timeline(timeline)
    assert main(["edit.otio", "walk.usda", "--select", "take_2_2"]) == 0
    assert variant_names("walk.conform.usd") == sorted(
        ["original", "director_s_cut", "original_2", "take_2", "take_2_2", "track_05"]
    )
    out = capsys.readouterr().out
    assert "take_2_2\t12 fragments\tdistance" in out
    assert "wrote " in out and "walk.conform.usd" in out and "walk.conform.stage.usda" in out
    layer = Sdf.Layer.OpenAsAnonymous("walk.conform.usd")
    assert layer.GetPrimAtPath(MODEL).variantSelections["mtex"] == "take_2_2"
    assert read_custom_data("walk.conform.stage.usda", "take_2")["timeline"] == {"file": "edit.otio", "track": "take 2"}


def test_the_same_timeline_gives_the_same_bytes(shot: Path) -> None:
    assert main(["edit.otio", "walk.usda", "-q"]) == 0
    once = contents(shot)
    assert main(["edit.otio", "walk.conform.stage.usda", "-q"]) == 0
    assert contents(shot) == once


def test_a_dry_run_writes_nothing(shot: Path, capsys: Capture) -> None:
    before = contents(shot)
    assert main(["edit.otio", "walk.usda", "--dry-run"]) == 0
    assert contents(shot) == before
    assert "wrote" not in capsys.readouterr().out


def make_gap(track: Track) -> None:
    five = otio.opentime.RationalTime(5, 24)
    old = track[3].source_range
    track[3].source_range = otio.opentime.TimeRange(old.start_time + five, old.duration - five)
    track.insert(3, otio.schema.Gap(source_range=otio.opentime.TimeRange(duration=five)))


def make_longer(track: Track) -> None:
    old = track[2].source_range
    longer = old.duration + otio.opentime.RationalTime(3, 24)
    track[2].source_range = otio.opentime.TimeRange(old.start_time, longer)


def move_out(track: Track) -> None:
    late = otio.opentime.RationalTime(236, 24)
    track[2].source_range = otio.opentime.TimeRange(late, track[2].source_range.duration)


def overlap(track: Track) -> None:
    five = otio.opentime.RationalTime(5, 24)
    track.insert(3, otio.schema.Transition("dissolve", "SMPTE_Dissolve", five, five))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: setattr(t[2].media_reference, "target_url", "file:///other.usd"), "{name} at 29: unknown take"),
        (make_gap, "Gap at 44: a gap"),
        (overlap, "dissolve at 44: clips overlap"),
        (make_longer, "end at 174.*{last}.*expected 171 frames"),
        (move_out, "{name} at 29: outside the take"),
        (lambda t: setattr(t[2].effects[0], "time_scalar", -1.0), "{name} at 29: the time warp runs backwards"),
        (lambda t: setattr(t[2].effects[0], "time_scalar", 5.0), "{name} at 29: the time warp does not fit"),
    ],
    ids=["take", "gap", "overlap", "length", "range", "reverse", "stretch"],
)
def test_broken_edits_are_refused(shot: Path, capsys: Capture, change: Callable[[Track], object], message: str) -> None:
    track = read_timeline().tracks[0]
    pattern = message.format(name=f"track path_01: {track[2].name}", last=track[-1].name)
    edit(change)
    assert re.search(pattern, refused(capsys, shot, "edit.otio", "walk.usda"))
    # The other tracks are as they were.
    assert main(["edit.otio", "walk.usda", "--track", "path_02", "-q"]) == 0


def test_a_file_that_is_no_timeline_is_refused(shot: Path, capsys: Capture) -> None:
    assert "edit.otio is damaged" in cut_short(shot, capsys)
    for name in ("walk.usda", "walk.mtex.usd"):
        assert f"{name} is damaged or no timeline" in refused(capsys, shot, name, "walk.usda")
    assert "cannot read none.otio: No such file" in refused(capsys, shot, "none.otio", "walk.usda")
    assert "cannot read .; expected a file" in refused(capsys, shot, ".", "walk.usda")


def cut_short(folder: Path, capsys: Capture) -> str:
    file = folder / "edit.otio"
    file.write_text(file.read_text()[:20000])
    return refused(capsys, folder, "edit.otio", "walk.usda")


def test_options_that_name_nothing_are_refused(shot: Path, capsys: Capture) -> None:
    arguments = ("edit.otio", "walk.usda")
    assert "has no track path_09; expected one of path_01, path_02" in refused(
        capsys, shot, *arguments, "--track", "path_09"
    )
    assert "gets no variant 'path_09'" in refused(capsys, shot, *arguments, "--select", "path_09", "--dry-run")
    assert "cannot take /Nobody as a sketch" in refused(capsys, shot, *arguments, "--anim", "/Nobody")


def test_what_other_commands_wrote_is_left_alone(shot: Path, capsys: Capture) -> None:
    message = refused(capsys, shot, "edit.otio", "walk.usda", "-o", "walk.mtex.usd")
    assert "holds what another command made" in message
    (shot / "mine.usda").write_text("#usda 1.0\n")
    assert "was not written by usdmtex" in refused(capsys, shot, "edit.otio", "walk.usda", "-o", "mine.usda")


def test_a_renamed_track_names_its_variant(shot: Path) -> None:
    edit(lambda track: setattr(track, "name", "director"))
    assert main(["edit.otio", "walk.usda", "--track", "director", "-q"]) == 0
    assert variant_names("walk.conform.usd") == ["director", "original"]


def test_a_recipe_that_has_changed_is_said(shot: Path, capsys: Capture) -> None:
    stage = Usd.Stage.Open("walk.usda")
    stage.GetPrimAtPath(SKETCH).CreateAttribute("mtex:joinTime", Sdf.ValueTypeNames.Double).Set(0.2)
    stage.GetRootLayer().Save()
    assert main(["edit.otio", "walk.usda", "--track", "path_01"]) == 0
    assert "the recipe has changed since track path_01 was written" in capsys.readouterr().err


@pytest.fixture
def two(shot_folder: Path) -> Path:
    """A shot of two characters with a sketch each, processed, and its timeline."""
    stage = Usd.Stage.CreateNew("two.usda")
    stage.GetRootLayer().subLayerPaths = ["./walk.usda"]
    stage.SetFramesPerSecond(24)
    stage.SetTimeCodesPerSecond(24)
    other = stage.DefinePrim("/Other")
    other.GetReferences().AddInternalReference(MODEL)
    stage.GetPrimAtPath("/Other/Sketch").CreateRelationship("mtex:takes").SetTargets(["/Takes"])
    stage.GetRootLayer().Save()
    write_shot("two.usda")
    return shot_folder


def test_every_character_gets_its_own_tracks(two: Path, capsys: Capture) -> None:
    timeline = read_timeline()
    names = [track.name for track in timeline.tracks]
    assert names[:2] == ["Humanoid_Sketch_path_01", "Humanoid_Sketch_path_02"]
    assert names[5] == "Other_Sketch_path_01"
    assert timeline.tracks[5].metadata["mtex"]["anim"] == "/Other/Sketch"
    assert main(["edit.otio", "two.usda", "-q"]) == 0
    for model in (MODEL, "/Other"):
        ours = read_samples("two.conform.usd", model, "path_01")
        theirs = read_samples("two.mtex.usd", model, "path_01")
        assert all(ours[name][t].tobytes() == theirs[name][t].tobytes() for name in theirs for t in theirs[name])


def test_one_character_alone_leaves_the_other_as_it_was(two: Path, capsys: Capture) -> None:
    assert main(["edit.otio", "two.usda", "-q"]) == 0
    assert main(["edit.otio", "two.usda", "--anim", "/Other/Sketch", "--track", "Other_Sketch_path_02", "-q"]) == 0
    assert variant_names("two.conform.usd", "/Other") == ["original", "path_02"]
    assert len(variant_names("two.conform.usd", MODEL)) == 6
    message = refused(capsys, two, "edit.otio", "two.usda", "--anim", SKETCH, "--track", "Other_Sketch_path_02")
    assert "has no track for /Humanoid/Sketch; expected one of /Other/Sketch" in message


def test_a_track_that_says_nothing_needs_a_sketch_named(two: Path, capsys: Capture) -> None:
    edit(lambda track: track.metadata.clear())
    arguments = ("edit.otio", "two.usda", "--track", "Humanoid_Sketch_path_01")
    assert "does not say which sketch it is for" in refused(capsys, two, *arguments)
    assert main([*arguments, "--anim", SKETCH, "-q"]) == 0
    assert variant_names("two.conform.usd") == ["Humanoid_Sketch_path_01", "original"]


def test_help_says_what_it_does(capsys: Capture) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--help"])
    assert ended.value.code == 0
    assert "OpenTimelineIO timeline" in capsys.readouterr().out
