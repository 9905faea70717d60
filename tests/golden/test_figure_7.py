"""Pullen & Bregler 2002, figure 7, the paper's own example of choosing paths.

Four sketch fragments, three candidates each, closest first; numbers are fragments of the take in order of time: n and
n + 1 are consecutive. Rank stands for distance. Section 3.3 names the three best paths: 4-5-6-2, 4-5-4-5 and 1-2-4-5.
"""

import itertools

import numpy as np
import pytest

from mtex_usd.texture.paths import consecutive_lattice, find_paths
from tests.oracle import paths as twin

CANDIDATES = [[4, 1, 3], [5, 7, 2], [9, 4, 6], [2, 8, 5]]
RANKS = [[0.0, 1.0, 2.0]] * 4
BEST = [(4, 5, 6, 2), (4, 5, 4, 5), (1, 2, 4, 5)]
# As printed, with the next fragment in the rows.
PRINTED = [
    [[0, 1, 1], [1, 1, 1], [1, 0, 1]],
    [[1, 1, 1], [1, 1, 1], [0, 1, 1]],
    [[1, 1, 1], [1, 1, 1], [1, 0, 1]],
]


def consecutive():
    return [[[b == a + 1 for b in right] for a in left] for left, right in itertools.pairwise(CANDIDATES)]


def find(count):
    tables = [np.array(table) for table in consecutive()]
    return find_paths(consecutive_lattice([np.array(ranks) for ranks in RANKS], tables), count)


def fragments_of(choice):
    return tuple(CANDIDATES[q][k] for q, k in enumerate(choice))


def test_the_cost_matrices_are_as_printed():
    costs = [np.where(np.array(table), 0, 1).T.tolist() for table in consecutive()]
    assert costs == PRINTED


def test_the_three_best_paths():
    found = find(3)
    assert [fragments_of(path.choice) for path in found] == BEST
    assert [len(path.joins) for path in found] == [2, 2, 2]


def test_the_first_of_them_if_fewer_are_asked():
    assert [fragments_of(path.choice) for path in find(1)] == BEST[:1]


@pytest.mark.parametrize("count", [3, 4, 5, 6, 7, 8])
def test_distinct_sets_with_fewer_joins_come_next(count):
    """Every set of zero-cost joins once, then by rank sum; where sums tie, any order."""
    found = find(count)
    expected = twin.rank_consecutive(RANKS, consecutive(), count)
    score = [(len(path.joins), twin.sum_of_distances(path.choice, RANKS)) for path in found]
    assert score == [(len(twin.zero_joins(c, consecutive())), twin.sum_of_distances(c, RANKS)) for c in expected]


def test_every_set_of_zero_cost_joins_comes_once_before_any_twice():
    sets = {twin.zero_joins(choice, consecutive()) for choice in twin.list_paths(RANKS)}
    found = find(len(sets))
    assert {path.joins for path in found} == sets


def test_all_there_are_and_no_more():
    found = find(1000)
    assert len(found) == 3**4
    assert len({path.choice for path in found}) == 3**4
