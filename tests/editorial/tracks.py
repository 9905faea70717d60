"""A shot of three clips to edit, and any shots at all: made without stages."""

import itertools
from collections.abc import Callable
from pathlib import Path

import opentimelineio as otio
from hypothesis import strategies as st

from mtex_usd.editorial.placing import PlacedTrack, place_track
from mtex_usd.editorial.reading import read_timeline
from mtex_usd.editorial.records import FrameGrid, SketchPaths, TakeMedia, TimelineHead
from mtex_usd.editorial.writing import build_timeline
from mtex_usd.texture.given import GivenFragment
from mtex_usd.texture.result import FragmentUse, Variant

__all__ = [
    "FILE",
    "FRAGMENTS",
    "GRIDS",
    "LIMIT",
    "SHOT",
    "Edit",
    "edited",
    "make_paths",
    "media",
    "timelines",
    "trim",
    "write",
]

RATES = (23.976, 24.0, 24000 / 1001, 25.0, 30.0, 60.0, 119.88, 120.0)
HEAD = TimelineHead(shot=Path("/shots/shot.usda"), version="1", options={})
FILE = Path("/takes/all takes.usd")
LIMIT = 4.0


def take_grids(rate: float, shot: FrameGrid, seconds: float, start: float) -> tuple[FrameGrid, FrameGrid]:
    """A take at its own rate, and the same at the shot's."""
    time_codes = shot.rate * shot.time_codes_per_frame
    grids = [
        FrameGrid(rate=r, start=start, time_codes_per_frame=time_codes / r, frame_count=int(seconds * r + 1e-6) + 1)
        for r in (rate, shot.rate)
    ]
    return grids[0], grids[1]


def as_use(fragment: GivenFragment, shot: FrameGrid, take: FrameGrid) -> FragmentUse:
    return FragmentUse(
        start=shot.time_code_at(fragment.first),
        end=shot.time_code_at(fragment.last),
        take=fragment.take,
        take_start=take.time_code_at(fragment.take_first),
        take_end=take.time_code_at(fragment.take_last),
        distance=1.5,
        scale=0.75,
        band=4,
    )


def as_variant(uses: tuple[FragmentUse, ...]) -> Variant:
    # What timelines say of a variant is its fragments; its motion is not looked at.
    return Variant(
        rank=1,
        distance=1.0,
        zero_cost_joins=0,
        fragments=uses,
        clip=None,
        joined=None,
        curves=None,  # type: ignore[arg-type]
    )


def make_paths(fragments: tuple[GivenFragment, ...], shot: FrameGrid, at_shot: dict[str, FrameGrid]) -> SketchPaths:
    """Make the one path of a sketch."""
    variant = as_variant(tuple(as_use(each, shot, at_shot[each.take]) for each in fragments))
    return SketchPaths(
        anim="/A/Sketch",
        model="/A",
        variant_set="mtex",
        grid=shot,
        variants={"path_01": variant},
        max_stretch=LIMIT,
        recipe_digest="",
    )


def write(
    folder: Path,
    fragments: tuple[GivenFragment, ...],
    shot: FrameGrid,
    takes: dict[str, TakeMedia],
    at_shot: dict[str, FrameGrid],
) -> Path:
    """Write the timeline of one path."""
    file_path = folder / "edit.otio"
    file_path.write_text(build_timeline(HEAD, [make_paths(fragments, shot, at_shot)], takes))
    return file_path


@st.composite
def timelines(draw):
    """A shot, its takes and fragments as the search may choose them."""
    shot_rate = draw(st.sampled_from(RATES))
    start = draw(st.sampled_from((0.0, 1.0, 101.0, -12.5, 1001.0)))
    cuts = [0, *sorted(draw(st.sets(st.integers(1, 400), min_size=1, max_size=12)))]
    shot = FrameGrid(
        rate=shot_rate,
        start=start,
        time_codes_per_frame=draw(st.sampled_from((1.0, 5.0, 0.8))),
        frame_count=cuts[-1] + 1,
    )
    names = ("/Takes/walk", "/Takes/run", "/More/walk")
    grids = {
        name: take_grids(draw(st.sampled_from(RATES)), shot, 20.0, draw(st.sampled_from((0.0, 86400.0, 7.25))))
        for name in names
    }
    fragments = []
    for first, last in itertools.pairwise(cuts):
        name = draw(st.sampled_from(names))
        count = grids[name][1].frame_count
        length = draw(st.integers(1, min(count - 1, 600)))  # beyond the limit too, as where the search lifts it
        begin = draw(st.integers(0, count - 1 - length))
        fragments.append(
            GivenFragment(first=first, last=last, take=name, take_first=float(begin), take_last=float(begin + length))
        )
    return shot, grids, tuple(fragments)


def media(grids: dict[str, tuple[FrameGrid, FrameGrid]], which: int) -> dict[str, TakeMedia]:
    return {name: TakeMedia(prim_path=name, file_path=FILE, grid=pair[which]) for name, pair in grids.items()}


SHOT = FrameGrid(rate=24.0, start=101.0, time_codes_per_frame=1.0, frame_count=61)
GRIDS = {name: take_grids(120.0, SHOT, 10.0, 0.0) for name in ("/Takes/walk", "/Takes/run", "/More/walk")}
FRAGMENTS = (
    GivenFragment(first=0, last=20, take="/Takes/walk", take_first=10.0, take_last=40.0),
    GivenFragment(first=20, last=40, take="/Takes/run", take_first=100.0, take_last=120.0),
    GivenFragment(first=40, last=60, take="/Takes/walk", take_first=200.0, take_last=210.0),
)

Edit = Callable[[otio.schema.Track], object]


def edited(folder: Path, edit: Edit) -> PlacedTrack:
    """Place the track after an edit made as another application would."""
    file_path = write(folder, FRAGMENTS, SHOT, media(GRIDS, 0), {name: pair[1] for name, pair in GRIDS.items()})
    timeline = otio.adapters.read_from_file(str(file_path))
    edit(timeline.tracks[0])
    otio.adapters.write_to_file(timeline, str(file_path))
    (track,) = read_timeline(file_path).tracks
    return place_track(track, SHOT, media(GRIDS, 1), max_stretch=LIMIT)


def trim(clip: otio.schema.Clip, *, begin: float = 0.0, length: float = 0.0) -> None:
    """Move a clip's begin in its take and change its length, in frames of the take."""
    old = clip.source_range
    clip.source_range = otio.opentime.TimeRange(
        old.start_time + otio.opentime.RationalTime(begin, old.start_time.rate),
        old.duration + otio.opentime.RationalTime(length, old.duration.rate),
    )
