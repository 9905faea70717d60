"""Finding the take fragments nearest to each sketch fragment (Pullen & Bregler 2002, section 3.2).

All takes lie end to end in one pool; a fragment is a pair of frames in it. The search is exact: for each length that
occurs in the sketch all fragments are stretched to it at once and compared by the sum of squared differences.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

__all__ = [
    "MOST_SCALE",
    "Features",
    "Match",
    "candidate_count",
    "fit_scale",
    "match_fragments",
    "measure_distance",
    "stretch_linearly",
]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]
BoolArray = npt.NDArray[np.bool_]

_MOST_CANDIDATES = 64
# Beyond this a take is too small a motion to say how a large one would look; arms would turn over.
MOST_SCALE = 4.0


@dataclass(frozen=True, eq=False)
class Features:
    """What is compared, for one clip or for a pool of clips end to end.

    Parameters
    ----------
    values
        Match channels, the band (and what lies below it), shape [F, M].
    slopes
        Their first derivative times the root of the derivative weight, shape [F, M].
    band
        The band's values alone, for the scale factor, shape [F, M].
    centred
        Columns compared about their mean over the fragment (the root's travel), shape [M].
    """

    values: FloatArray
    slopes: FloatArray
    band: FloatArray
    centred: BoolArray


@dataclass(frozen=True, eq=False)
class Match:
    """The candidates of one sketch fragment, closest first.

    Parameters
    ----------
    fragments
        Indices into the pool's fragments, shape [K].
    distances
        Sums of squared differences, shape [K].
    stretch_lifted
        Whether every fragment was longer than the stretch limit, so that the limit was lifted.
    """

    fragments: IntArray
    distances: FloatArray
    stretch_lifted: bool


def candidate_count(requested: int, fragment_count: int) -> int:
    """Give K: as requested, or a tenth of all take fragments, from 1 to 64 (Pullen & Bregler 2002, section 3.3)."""
    if requested > 0:
        return min(requested, fragment_count)
    return min(max(round(fragment_count / 10), 1), _MOST_CANDIDATES)


def stretch_linearly(curves: FloatArray, fragments: IntArray | FloatArray, frame_count: int) -> FloatArray:
    """Stretch or compress fragments to one length by linear interpolation.

    Parameters
    ----------
    curves
        Shape [F, M].
    fragments
        First and last frames, shape [N, 2].
    frame_count
        Frames of the result (n).

    Returns
    -------
    FloatArray
        Shape [N, n, M].
    """
    fractions = np.linspace(0.0, 1.0, frame_count)
    positions = fragments[:, :1] + (fragments[:, 1:] - fragments[:, :1]) * fractions
    left = np.minimum(positions.astype(np.intp), len(curves) - 2) if len(curves) > 1 else positions.astype(np.intp)
    right = np.minimum(left + 1, len(curves) - 1)
    weight = (positions - left)[..., None]
    return np.asarray(curves[left] * (1.0 - weight) + curves[right] * weight)


def _stretched_feature(features: Features, fragments: IntArray | FloatArray, frame_count: int) -> FloatArray:
    """Give values and slopes of fragments at one length, flat, shape [N, n * 2M]."""
    values = stretch_linearly(features.values, fragments, frame_count)
    means = values.mean(axis=1, keepdims=True)
    values = values - np.where(features.centred, means, 0.0)
    slopes = stretch_linearly(features.slopes, fragments, frame_count)
    return np.concatenate([values, slopes], axis=2).reshape(len(fragments), -1)


def match_fragments(
    sketch: Features,
    sketch_fragments: IntArray,
    pool: Features,
    pool_fragments: IntArray,
    *,
    candidates: int,
    max_stretch: float,
) -> tuple[Match, ...]:
    """Find the closest take fragments of every sketch fragment.

    Parameters
    ----------
    sketch
        Features of the sketch.
    sketch_fragments
        First and last frames, shape [Q, 2].
    pool
        Features of all takes end to end.
    pool_fragments
        First and last frames, shape [N, 2]; each lies inside one take.
    candidates
        K, how many to keep.
    max_stretch
        Longest take fragment in lengths of the sketch fragment; where none is short enough the limit is lifted.

    Returns
    -------
    tuple of Match
        One per sketch fragment; among equals the earlier fragment of the pool comes first.
    """
    lengths = sketch_fragments[:, 1] - sketch_fragments[:, 0]
    pool_lengths = pool_fragments[:, 1] - pool_fragments[:, 0]
    found: dict[int, Match] = {}
    for length in np.unique(lengths):
        allowed = np.flatnonzero(pool_lengths <= max_stretch * length)
        lifted = allowed.size == 0
        allowed = np.arange(len(pool_fragments)) if lifted else allowed
        stretched = _stretched_feature(pool, pool_fragments[allowed], length + 1)
        of_length = np.flatnonzero(lengths == length)
        wanted = _stretched_feature(sketch, sketch_fragments[of_length], length + 1)
        for number, feature in zip(of_length, wanted, strict=True):
            distances = np.square(stretched - feature).sum(axis=1)
            nearest = np.argsort(distances, kind="stable")[:candidates]
            found[int(number)] = Match(allowed[nearest], distances[nearest], lifted)
    return tuple(found[number] for number in range(len(sketch_fragments)))


def measure_distance(
    sketch: Features, sketch_fragment: IntArray, pool: Features, pool_fragment: IntArray | FloatArray
) -> float:
    """Give the distance that :func:`match_fragments` finds between one sketch fragment and one of the pool.

    Parameters
    ----------
    sketch
        Features of the sketch.
    sketch_fragment
        First and last frame, shape [2].
    pool
        Features of all takes end to end.
    pool_fragment
        First and last frame, shape [2]; may lie between frames.
    """
    frame_count = int(sketch_fragment[1] - sketch_fragment[0]) + 1
    wanted = _stretched_feature(sketch, sketch_fragment[None], frame_count)
    return float(np.square(_stretched_feature(pool, pool_fragment[None], frame_count) - wanted).sum(axis=1)[0])


def fit_scale(
    sketch: Features, sketch_fragment: IntArray, pool: Features, pool_fragment: IntArray | FloatArray
) -> float:
    """Give the factor s, 0 to 4, that minimises ||M s - A|| over the match band (Pullen & Bregler 2002, section 3.2).

    A is the sketch fragment's band, M the take fragment's, stretched to its length. Where the take's band is still
    there is nothing to scale, and s is 1.
    """
    frame_count = int(sketch_fragment[1] - sketch_fragment[0]) + 1
    wanted = sketch.band[sketch_fragment[0] : sketch_fragment[1] + 1]
    taken = stretch_linearly(pool.band, pool_fragment[None], frame_count)[0]
    energy = float(np.sum(taken * taken))
    if energy == 0.0:
        return 1.0
    return min(max(float(np.sum(taken * wanted)) / energy, 0.0), MOST_SCALE)
