"""The recipe: what the animator marked on the sketch, as plain data.

The defaults here are the schema's fallbacks; a test holds the two together. They apply where a property is not
authored, whether or not the schema is registered in the process.
"""

from dataclasses import dataclass

__all__ = ["CONTACTS", "PATH_COSTS", "Recipe", "Segment"]

CONTACTS = ("off", "detect", "declared")
PATH_COSTS = ("consecutive", "continuity")


@dataclass(frozen=True, kw_only=True)
class Segment:
    """Settings for a span of time; None means as the recipe (Pullen & Bregler 2002, section 4.1).

    Times are time codes of the stage, both ends included.
    """

    name: str
    start: float
    end: float
    match: tuple[str, ...] | None = None
    break_channel: str | None = None
    match_band: int | None = None
    texture: tuple[str, ...] | None = None
    synthesize: tuple[str, ...] | None = None
    texture_bands: tuple[int, int] | None = None
    scale: bool | None = None


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """Everything MtexSketchAPI and MtexSegmentAPI say, except where the takes are.

    Channel tokens are unresolved; bands are those of the stage's own rate, 0 meaning the paper's frequencies.
    """

    match: tuple[str, ...] = ()
    texture: tuple[str, ...] = ()
    synthesize: tuple[str, ...] = ()
    break_channel: str = ""
    match_band: int = 0
    match_lower: bool = True
    path_cost: str = "continuity"
    path_weight: float = 3.4
    diversity: float = 0.0
    texture_bands: tuple[int, int] = (0, 0)
    synthesis_band: int = 0
    derivative_weight: float = 1.0
    candidates: int = 0
    paths: int = 5
    max_stretch: float = 4.0
    scale: bool = False
    join_time: float = 0.4
    contacts: str = "off"
    segments: tuple[Segment, ...] = ()
