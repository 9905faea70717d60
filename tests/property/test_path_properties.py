"""The path search finds what listing every path finds."""

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mtex_usd.texture.paths import consecutive_lattice, continuity_lattice, find_best_path, find_paths
from tests.oracle import paths as twin

SEEDS = st.integers(0, 2**32 - 1)
POSITIONS = st.integers(1, 5)
CANDIDATES = st.integers(1, 4)
COUNTS = st.integers(1, 40)
LIKELY = st.floats(0.0, 1.0)


class Case:
    """Random candidates; real-valued distances, so nothing ties."""

    def __init__(self, seed, positions, most, likely):
        rng = np.random.default_rng(seed)
        sizes = rng.integers(1, most + 1, size=positions)
        self.distances = [rng.uniform(0.0, 100.0, size=size) for size in sizes]
        shapes = list(itertools.pairwise(sizes))
        self.consecutive = [rng.random(shape) < likely for shape in shapes]
        self.gaps = [rng.uniform(0.0, 50.0, size=shape) for shape in shapes]
        self.lengths = rng.integers(2, 30, size=positions).tolist()
        self.path_count = int(np.prod(sizes))


@given(SEEDS, POSITIONS, CANDIDATES, LIKELY, COUNTS)
def test_consecutive_equals_listing_all(seed, positions, most, likely, count):
    case = Case(seed, positions, most, likely)
    found = find_paths(consecutive_lattice(case.distances, case.consecutive), count)
    assert [path.choice for path in found] == twin.rank_consecutive(case.distances, case.consecutive, count)
    assert len(found) == min(count, case.path_count)
    assert all(path.joins == twin.zero_joins(path.choice, case.consecutive) for path in found)


@given(SEEDS, POSITIONS, CANDIDATES, LIKELY, COUNTS, st.floats(0.0, 10.0))
def test_continuity_equals_listing_all(seed, positions, most, likely, count, weight):
    case = Case(seed, positions, most, likely)
    lattice = continuity_lattice(case.distances, case.lengths, case.consecutive, case.gaps, weight=weight)
    found = find_paths(lattice, count)
    expected = twin.rank_continuity(case.distances, case.lengths, case.consecutive, case.gaps, weight, count)
    assert [path.choice for path in found] == expected
    for path in found:
        cost = twin.continuity_cost(path.choice, case.distances, case.lengths, case.consecutive, case.gaps, weight)
        np.testing.assert_allclose(path.cost, cost, rtol=1e-9, atol=1e-9)


@given(SEEDS, POSITIONS, CANDIDATES, LIKELY, st.integers(0, 4), st.floats(0.0, 1.0))
def test_the_best_path_that_differs_equals_listing_all(seed, positions, most, likely, others, apart):
    case = Case(seed, positions, most, likely)
    lattice = continuity_lattice(case.distances, case.lengths, case.consecutive, case.gaps, weight=1.0)
    rng = np.random.default_rng(seed + 1)
    differs = [rng.random((others, len(column))) < apart for column in case.distances]
    fitting = [
        choice
        for choice in twin.list_paths(case.distances)
        if all(any(differs[q][other, k] for q, k in enumerate(choice)) for other in range(others))
    ]
    found = find_best_path(lattice, differs)
    if not fitting:
        assert found is None
        return
    assert found is not None
    expected = min(
        fitting,
        key=lambda c: twin.continuity_cost(c, case.distances, case.lengths, case.consecutive, case.gaps, 1.0),
    )
    assert found.choice == expected


@given(SEEDS, st.integers(1, 4), st.integers(1, 3), st.integers(1, 100))
def test_equal_distances_still_give_every_set_once_and_no_path_twice(seed, positions, most, count):
    """Ties may come in any order, but the laws hold."""
    case = Case(seed, positions, most, 0.5)
    flat = [np.zeros(len(column)) for column in case.distances]
    found = find_paths(consecutive_lattice(flat, case.consecutive), count)
    assert len(found) == min(count, case.path_count)
    assert len({path.choice for path in found}) == len(found)
    sets = {twin.zero_joins(choice, case.consecutive) for choice in twin.list_paths(flat)}
    distinct = found[: len(sets)]
    assert len({path.joins for path in distinct}) == len(distinct)
    joins = [len(path.joins) for path in distinct]
    assert joins == sorted(joins, reverse=True)
