"""What cannot be followed is refused, naming the clip and its time."""

from pathlib import Path

import opentimelineio as otio
import pytest

from mtex_usd.errors import InputError
from tests.editorial.tracks import FILE, Edit, edited, trim


def gap(duration: float) -> otio.schema.Gap:
    return otio.schema.Gap(source_range=otio.opentime.TimeRange(duration=otio.opentime.RationalTime(duration, 24)))


def replace_media(clip: otio.schema.Clip, url: str, name: str = "") -> None:
    clip.media_reference = otio.schema.ExternalReference(target_url=url)
    clip.media_reference.name = name


def dissolve() -> otio.schema.Transition:
    five = otio.opentime.RationalTime(5, 24)
    return otio.schema.Transition(transition_type="SMPTE_Dissolve", in_offset=five, out_offset=five)


def set_warp(track: otio.schema.Track, effect: otio.schema.Effect) -> None:
    track[1].effects[:] = [effect]


BROKEN: dict[str, tuple[Edit, str]] = {
    "a take of another file": (
        lambda t: replace_media(t[1], "file:///x/other.usd", "run"),
        "run at 121: unknown take.*/Takes/run.*found run in file:///x/other.usd",
    ),
    "a take nobody knows": (lambda t: replace_media(t[1], FILE.as_uri(), "jump"), "run at 121: unknown take"),
    "a name of two takes": (
        lambda t: replace_media(t[1], FILE.as_uri(), "walk"),
        "run at 121: unknown take.*found walk",
    ),
    "metadata of a take nobody knows": (
        lambda t: t[1].metadata["mtex"].update(take="/Takes/jump"),
        "run at 121: unknown take.*found /Takes/jump",
    ),
    "no media": (
        lambda t: setattr(t[1], "media_reference", otio.schema.MissingReference()),
        "run at 121: unknown take.*no media",
    ),
    "a gap": (lambda t: t.insert(1, gap(5)), "Gap at 121: a gap; expected clips end to end"),
    "a disabled clip": (lambda t: setattr(t[1], "enabled", False), "run at 121 is disabled, which leaves a gap"),
    "a dissolve": (lambda t: t.insert(1, dissolve()), "Transition at 121: clips overlap in a transition"),
    "a nested stack": (lambda t: t.insert(1, otio.schema.Stack(name="both")), "both at 121: Stack nested"),
    "too short": (
        lambda t: trim(t[1], length=-15.0),
        "its clips end at 159; the last clip, walk at 138, ends there;"
        " expected 61 frames, to end at 162; found 58 frames",
    ),
    "too long": (lambda t: trim(t[2], length=5.0), "end at 163.*walk at 141.*found 62 frames"),
    "a clip missing": (lambda t: t.pop(2), "end at 141.*run at 121.*found 40 frames"),
    "no clips": (lambda t: t.clear(), "its clips end at 101; expected 61 frames"),
    "before the take": (
        lambda t: trim(t[0], begin=-51.0),
        "walk at 101: outside the take /Takes/walk; expected a part of 0 to 240.*found -0.2 to 29.8",
    ),
    "past the take": (lambda t: trim(t[1], begin=900.0), "run at 121: outside the take /Takes/run"),
    "faster than the take is long": (
        lambda t: setattr(t[2].effects[0], "time_scalar", 3.0),
        "walk at 141: outside the take",
    ),
    "faster than allowed": (
        lambda t: setattr(t[0].effects[0], "time_scalar", 4.5),
        "walk at 101: the time warp does not fit; expected at most 4 times.*found 4.5",
    ),
    "reversed": (lambda t: setattr(t[1].effects[0], "time_scalar", -1.0), "run at 121: the time warp runs backwards"),
    "frozen": (lambda t: set_warp(t, otio.schema.FreezeFrame()), "run at 121: the time warp stands still"),
    "all but frozen": (
        lambda t: setattr(t[1].effects[0], "time_scalar", 0.01),
        "run at 121 plays 0.2 frames of its take",
    ),
    "no number": (
        lambda t: setattr(t[1].effects[0], "time_scalar", float("nan")),
        "run at 121: the time warp cannot be followed",
    ),
    "two warps": (
        lambda t: t[1].effects.append(otio.schema.LinearTimeWarp(time_scalar=2.0)),
        "run at 121: effects.*one LinearTimeWarp.*found LinearTimeWarp, LinearTimeWarp",
    ),
    "a curve of time": (
        lambda t: set_warp(t, otio.schema.TimeEffect(effect_name="ramp")),
        "run at 121: effects.*found TimeEffect",
    ),
    "no length": (
        lambda t: (trim(t[0], length=100.0), trim(t[1], length=-100.0)),
        "run at 141 is too short; expected a frame",
    ),
    "a trimmed track": (lambda t: setattr(t, "source_range", t[0].source_range), "track path_01 is trimmed"),
}


@pytest.mark.parametrize("edit", BROKEN, ids=str)
def test_a_broken_edit_is_refused_by_name_and_time(tmp_path: Path, edit: str) -> None:
    change, message = BROKEN[edit]
    with pytest.raises(InputError, match=message):
        edited(tmp_path, change)
