"""The search is exact: it finds what comparing everything with everything finds."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mtex_usd.texture.matching import MOST_SCALE, Features, fit_scale, match_fragments, stretch_linearly
from tests.oracle import matching as twin

SEEDS = st.integers(0, 2**32 - 1)


def random_features(rng, frames, channels, *, centred=False):
    return Features(
        values=rng.standard_normal((frames, channels)),
        slopes=rng.standard_normal((frames, channels)),
        band=rng.standard_normal((frames, channels)),
        centred=np.full(channels, centred),
    )


def random_fragments(rng, frames):
    count = int(rng.integers(1, frames // 2))
    breaks = np.sort(rng.choice(np.arange(1, frames - 1), size=count, replace=False))
    edges = np.concatenate([[0], breaks, [frames - 1]])
    return np.stack([edges[:-1], edges[1:]], axis=1)


def as_lists(features):
    return np.concatenate([features.values, features.slopes], axis=1).T.tolist()


@given(SEEDS, st.integers(1, 3), st.integers(1, 12), st.floats(0.2, 5.0))
def test_equals_the_slow_twin(seed, channels, count, max_stretch):
    rng = np.random.default_rng(seed)
    sketch, pool = random_features(rng, 30, channels), random_features(rng, 60, channels)
    own, taken = random_fragments(rng, 30), random_fragments(rng, 60)
    found = match_fragments(sketch, own, pool, taken, candidates=count, max_stretch=max_stretch)
    assert len(found) == len(own)
    for fragment, match in zip(own.tolist(), found, strict=True):
        expected, lifted = twin.match(as_lists(sketch), fragment, as_lists(pool), taken.tolist(), count, max_stretch)
        assert match.fragments.tolist() == [index for _, index in expected]
        np.testing.assert_allclose(match.distances, [distance for distance, _ in expected], rtol=1e-9)
        assert match.stretch_lifted == lifted


@given(SEEDS, st.floats(1.0, 5.0))
def test_a_fragment_of_the_sketch_itself_comes_first_at_distance_zero(seed, max_stretch):
    rng = np.random.default_rng(seed)
    sketch = random_features(rng, 40, 2)
    own = random_fragments(rng, 40)
    found = match_fragments(sketch, own, sketch, own, candidates=3, max_stretch=max_stretch)
    for number, match in enumerate(found):
        assert match.fragments[0] == number
        assert match.distances[0] == 0.0


@given(SEEDS, st.integers(2, 20), st.integers(2, 20))
def test_stretching_equals_the_slow_twin(seed, frames, wanted):
    curve = np.random.default_rng(seed).standard_normal((frames, 1))
    stretched = stretch_linearly(curve, np.array([[0, frames - 1]]), wanted)[0, :, 0]
    np.testing.assert_allclose(stretched, twin.stretch(curve[:, 0].tolist(), 0, frames - 1, wanted), atol=1e-12)


@given(SEEDS, st.floats(-200.0, 200.0))
def test_centred_columns_do_not_care_where_they_are(seed, offset):
    rng = np.random.default_rng(seed)
    sketch, pool = (random_features(rng, frames, 2, centred=True) for frames in (30, 60))
    own, taken = random_fragments(rng, 30), random_fragments(rng, 60)
    away = Features(pool.values + offset, pool.slopes, pool.band, pool.centred)
    one = match_fragments(sketch, own, pool, taken, candidates=60, max_stretch=4.0)
    other = match_fragments(sketch, own, away, taken, candidates=60, max_stretch=4.0)
    for a, b in zip(one, other, strict=True):
        np.testing.assert_allclose(np.sort(a.distances), np.sort(b.distances), rtol=1e-6, atol=1e-6)


@given(SEEDS, st.integers(2, 30), st.integers(2, 30), st.integers(1, 4))
def test_the_scale_is_the_least_squares_factor_or_zero(seed, own_frames, take_frames, channels):
    rng = np.random.default_rng(seed)
    sketch, pool = random_features(rng, own_frames, channels), random_features(rng, take_frames, channels)
    found = fit_scale(sketch, np.array([0, own_frames - 1]), pool, np.array([0, take_frames - 1]))
    columns = [twin.stretch(column, 0, take_frames - 1, own_frames) for column in pool.band.T.tolist()]
    factor = np.linalg.lstsq(np.ravel(columns)[:, None], sketch.band.T.ravel(), rcond=None)[0][0]
    assert found >= 0.0
    np.testing.assert_allclose(found, min(max(factor, 0.0), MOST_SCALE), rtol=1e-9, atol=1e-12)


@given(SEEDS, st.floats(0.0, 3.0))
def test_a_scaled_copy_is_scaled_by_that_factor(seed, factor):
    rng = np.random.default_rng(seed)
    pool = random_features(rng, 20, 2)
    sketch = Features(pool.values, pool.slopes, factor * pool.band, pool.centred)
    found = fit_scale(sketch, np.array([3, 12]), pool, np.array([3, 12]))
    np.testing.assert_allclose(found, factor, atol=1e-12)
