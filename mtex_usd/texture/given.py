"""Texturing from fragments that somebody chose, as an editor does on a timeline, and not the search.

What is done with the fragments is the same: a path that the search found, given back, makes the same motion to the bit.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.candidates import Candidates
from mtex_usd.texture.engine import Ground, assemble_motion, describe_path, read_ground
from mtex_usd.texture.finish import Finisher
from mtex_usd.texture.matching import fit_scale, measure_distance
from mtex_usd.texture.pool import Matching
from mtex_usd.texture.recipe import Recipe
from mtex_usd.texture.result import TexturedMotion, Variant

__all__ = ["GivenFragment", "texture_given"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]


@dataclass(frozen=True, kw_only=True)
class GivenFragment:
    """A stretch of a sketch and the part of a take that goes there.

    Parameters
    ----------
    first, last
        Frames of the sketch, both included; the last of one fragment is the first of the next.
    take
        The take's name.
    take_first, take_last
        Where in the take, in frames at the sketch's rate, both included; may lie between frames.
    """

    first: int
    last: int
    take: str
    take_first: float
    take_last: float


def texture_given(
    sketch: Clip,
    takes: Sequence[Clip],
    recipe: Recipe,
    *,
    paths: Sequence[Sequence[GivenFragment]],
    held: Mapping[int, FloatArray] | None = None,
) -> TexturedMotion:
    """Texture and synthesize a sketch from given fragments.

    Parameters
    ----------
    sketch, takes, recipe
        As for :func:`mtex_usd.texture.engine.texture_motion`.
    paths
        One or more, each a row of fragments from the sketch's first frame through its last.
    held
        As there.

    Returns
    -------
    TexturedMotion
        One variant per path, ranked in their order; `breaks` are those of all of them.

    Raises
    ------
    InputError
        As :func:`mtex_usd.texture.engine.texture_motion`, and where fragments do not fill the sketch, or a take has no
        such frames or cannot be measured.
    """
    ground = read_ground(sketch, takes, recipe)
    made: list[tuple[Variant, Finisher]] = []
    for rank, path in enumerate(paths, start=1):
        fragments = _find_borders(path, sketch)
        candidates = [_locate(given, ground) for given in path]
        finisher = ground.build_finisher(fragments, candidates, recipe, held or {})
        choice = [0] * len(path)
        joins = int(finisher.find_continued(choice).sum())
        made.append((describe_path(rank, choice, joins, finisher.finish(choice), finisher), finisher))
    breaks = np.unique([frame for path in paths for given in path for frame in (given.first, given.last)])
    return assemble_motion(
        made[-1][1],
        tuple(variant for variant, _ in made),
        breaks.astype(np.intp),
        [*ground.roles.notes, *ground.absent],
    )


def _find_borders(path: Sequence[GivenFragment], sketch: Clip) -> IntArray:
    """First and last frames on the sketch, shape [Q, 2]."""
    firsts, lasts = [given.first for given in path], [given.last for given in path]
    if [0, *lasts] != [*firsts, sketch.frame_count - 1] or any(
        last <= first for first, last in zip(firsts, lasts, strict=True)
    ):
        raise InputError(
            f"{sketch.name}: the fragments do not fill the sketch",
            expected=f"each to begin where the one before ends, from frame 0 through {sketch.frame_count - 1}",
            found=", ".join(f"{given.first} to {given.last}" for given in path) or "no fragments",
        )
    return np.array([firsts, lasts], dtype=np.intp).T


def _locate(given: GivenFragment, ground: Ground) -> Candidates:
    """Give the one candidate there is for a stretch, measured as the search would."""
    take = _find_take(given, ground)
    span = ground.roles.span_at(given.first)
    pool = ground.pools[Matching.of_span(span)]
    starts = pool.starts[pool.take_of == take]
    if not starts.size:
        raise _refuse(given, ground, "the take is too short to be matched")
    fragment = np.array([given.first, given.last], dtype=np.intp)
    pair = starts[0] + np.array([given.take_first, given.take_last])
    return Candidates(
        take=np.array([take], dtype=np.intp),
        first=np.array([given.take_first], dtype=np.float64),
        last=np.array([given.take_last], dtype=np.float64),
        distance=np.array([measure_distance(pool.sketch, fragment, pool.features, pair)]),
        scale=np.array([fit_scale(pool.sketch, fragment, pool.features, pair) if span.scale else 1.0]),
        stretch_lifted=False,
    )


def _find_take(given: GivenFragment, ground: Ground) -> int:
    names = [take.clip.name for take in ground.takes]
    if given.take not in names:
        raise _refuse(given, ground, f"it is none of the takes with all joints that are needed: {', '.join(names)}")
    take = names.index(given.take)
    if not 0.0 <= given.take_first < given.take_last <= ground.takes[take].clip.frame_count - 1:
        raise _refuse(given, ground, "the take has no such frames")
    return take


def _refuse(given: GivenFragment, ground: Ground, why: str) -> InputError:
    start, end = ground.sketch.clip.time_codes[[given.first, given.last]]
    return InputError(f"{ground.sketch.clip.name}: {given.take} cannot be used from {start:g} to {end:g}: {why}")
