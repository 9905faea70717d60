"""What timelines are written from and read against, as plain data."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from mtex_usd.motion.clip import Clip
from mtex_usd.texture.result import Variant

__all__ = ["FORMAT", "FrameGrid", "SketchPaths", "TakeMedia", "TimelineHead", "mark_of"]

# Says in a timeline's metadata["mtex"] that this project wrote it, and in which form.
FORMAT = 1


def mark_of(metadata: Mapping[str, object]) -> Mapping[str, object]:
    """Give our part of an object's metadata, which others may have made anything of; empty where it is none."""
    mark = metadata.get("mtex")
    return mark if isinstance(mark, Mapping) else {}


@dataclass(frozen=True, kw_only=True)
class FrameGrid:
    """The frames of a shot or of a take.

    Parameters
    ----------
    rate
        Frames per second.
    start
        Time code of the first frame.
    time_codes_per_frame
        How far one frame is in time codes.
    frame_count
        How many frames there are.
    """

    rate: float
    start: float
    time_codes_per_frame: float
    frame_count: int

    @classmethod
    def of_clip(cls, clip: Clip) -> "FrameGrid":
        """Give the frames of a clip."""
        return cls(
            rate=clip.rate,
            start=clip.start,
            time_codes_per_frame=clip.time_codes_per_frame,
            frame_count=clip.frame_count,
        )

    @property
    def first_frame(self) -> float:
        """Number of the first frame, counted from time code 0: what editorial calls its time."""
        return self.start / self.time_codes_per_frame

    def time_code_at(self, frame: float) -> float:
        """Give the time code of a frame, the first being frame 0."""
        return self.start + self.time_codes_per_frame * frame


@dataclass(frozen=True, kw_only=True)
class TakeMedia:
    """A take as media.

    Parameters
    ----------
    prim_path
        Where it is on the stage, which is its name everywhere.
    file_path
        The file that holds its samples.
    grid
        Its frames: when a timeline is written, those recorded; when one is read, those at the shot's rate.
    """

    prim_path: str
    file_path: Path
    grid: FrameGrid

    @property
    def name(self) -> str:
        """Last name of the prim path: what clips are called."""
        return self.prim_path.rpartition("/")[2]


@dataclass(frozen=True, eq=False, kw_only=True)
class SketchPaths:
    """All paths of one sketch on one character.

    Parameters
    ----------
    anim, model, variant_set
        The sketch, the prim with the variant set, and the set.
    grid
        Frames of the sketch.
    variants
        By name of the variant.
    max_stretch
        ``mtex:maxStretch``: fragments beyond it are marked, as the search had lifted the limit for them.
    recipe_digest
        Tells whether the recipe was changed since.
    """

    anim: str
    model: str
    variant_set: str
    grid: FrameGrid
    variants: Mapping[str, Variant]
    max_stretch: float
    recipe_digest: str


@dataclass(frozen=True, kw_only=True)
class TimelineHead:
    """What a timeline says about itself.

    Parameters
    ----------
    shot
        The shot's file.
    version
        Version of the tool.
    options
        What stood on the command line instead of the recipe: ``band``, where given.
    """

    shot: Path
    version: str
    options: Mapping[str, int]
