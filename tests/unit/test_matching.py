"""Finding the nearest take fragments: the limits, the number kept, and ties."""

import numpy as np
import pytest

from mtex_usd.texture.matching import Features, candidate_count, fit_scale, match_fragments, stretch_linearly


def plain(values, slopes=None, *, band=None):
    values = np.array(values, dtype=np.float64)[:, None]
    slopes = np.zeros_like(values) if slopes is None else np.array(slopes, dtype=np.float64)[:, None]
    return Features(values, slopes, values if band is None else np.array(band)[:, None], np.array([False]))


@pytest.mark.parametrize(
    ("fragments", "kept"), [(1, 1), (4, 1), (14, 1), (16, 2), (24, 2), (26, 3), (300, 30), (636, 64), (5000, 64)]
)
def test_a_tenth_is_kept_to_the_nearest_from_1_to_64(fragments, kept):
    assert candidate_count(0, fragments) == kept


def test_as_many_as_asked_are_kept_if_there_are_so_many():
    assert candidate_count(100, 500) == 100
    assert candidate_count(100, 30) == 30


# Sketch fragment of 2 steps; take fragments of 8, 9 and 2 steps.
SKETCH, OWN = plain([0.0, 1.0, 2.0]), np.array([[0, 2]])
TAKES = plain(np.linspace(0.0, 2.0, 9).tolist() + [0.0] * 9 + [5.0, 5.0, 5.0])
FRAGMENTS = np.array([[0, 8], [8, 17], [18, 20]])


def test_a_fragment_of_4_lengths_is_kept_and_a_longer_one_rejected():
    (match,) = match_fragments(SKETCH, OWN, TAKES, FRAGMENTS, candidates=3, max_stretch=4.0)
    assert match.fragments.tolist() == [0, 2]
    assert match.distances[0] == 0.0
    assert not match.stretch_lifted


def test_the_limit_is_lifted_where_it_leaves_none():
    (match,) = match_fragments(SKETCH, OWN, TAKES, FRAGMENTS[:2], candidates=3, max_stretch=2.0)
    assert match.fragments.tolist() == [0, 1]
    assert match.stretch_lifted


def test_among_equals_the_earlier_in_the_pool_comes_first():
    pool = plain([0.0, 1.0, 2.0] * 4)
    fragments = np.array([[9, 11], [0, 2], [6, 8], [3, 5]])
    (match,) = match_fragments(SKETCH, OWN, pool, fragments, candidates=3, max_stretch=4.0)
    assert match.fragments.tolist() == [0, 1, 2]
    assert match.distances.tolist() == [0.0, 0.0, 0.0]


def test_many_equals_keep_the_pools_order():
    pool = plain([9.0, 9.0, 9.0, 0.0, 1.0, 2.0] * 50)
    fragments = np.stack([np.arange(0, 300, 3), np.arange(2, 300, 3)], axis=1)
    (match,) = match_fragments(SKETCH, OWN, pool, fragments, candidates=100, max_stretch=4.0)
    assert match.fragments.tolist() == [*range(1, 100, 2), *range(0, 100, 2)]


def test_slopes_count_as_much_as_they_are_weighted():
    sketch = plain([0.0, 0.0, 0.0], [1.0, 1.0, 1.0])
    pool = plain([1.0, 1.0, 1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    fragments = np.array([[0, 2], [3, 5]])
    (match,) = match_fragments(sketch, OWN, pool, fragments, candidates=2, max_stretch=4.0)
    assert match.distances.tolist() == [3.0, 3.0]
    half = np.sqrt(0.5)
    lighter = Features(pool.values, half * pool.slopes, pool.band, pool.centred)
    wanted = Features(sketch.values, half * sketch.slopes, sketch.band, sketch.centred)
    (match,) = match_fragments(wanted, OWN, lighter, fragments, candidates=2, max_stretch=4.0)
    assert match.fragments.tolist() == [1, 0]
    np.testing.assert_allclose(match.distances, [1.5, 3.0])


def test_a_fragment_of_two_frames_matches():
    (match,) = match_fragments(
        plain([0.0, 1.0]),
        np.array([[0, 1]]),
        plain([5.0, 0.0, 0.5, 1.0]),
        np.array([[0, 1], [1, 3]]),
        candidates=1,
        max_stretch=4.0,
    )
    assert match.fragments.tolist() == [1]
    assert match.distances.tolist() == [0.0]


def test_stretching_holds_both_ends():
    curve = np.array([[0.0], [1.0], [4.0], [9.0]])
    stretched = stretch_linearly(curve, np.array([[0, 3], [1, 2]]), 5)
    np.testing.assert_allclose(stretched[:, [0, -1], 0], [[0.0, 9.0], [1.0, 4.0]])


def test_the_scale_looks_at_the_band_alone():
    """With the pose in it the factor fits the offset: a true 0.3 would read 0.9."""
    wave = np.sin(np.arange(20.0))
    take, sketch = plain(10.0 + wave, band=wave), plain(10.0 + 0.3 * wave, band=0.3 * wave)
    whole = np.array([0, 19])
    assert fit_scale(sketch, whole, take, whole) == pytest.approx(0.3)


def test_opposite_motion_scales_to_nothing_not_below():
    wave = np.sin(np.arange(20.0))
    assert fit_scale(plain(-wave), np.array([0, 19]), plain(wave), np.array([0, 19])) == 0.0


def test_a_still_take_is_not_scaled():
    assert fit_scale(plain([1.0, 2.0, 3.0]), np.array([0, 2]), plain([0.0] * 3), np.array([0, 2])) == 1.0
