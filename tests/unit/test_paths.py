"""Choosing paths: what counts first, what makes two paths one, and what comes when all are taken."""

import numpy as np
import pytest

from mtex_usd.texture.paths import consecutive_lattice, continuity_lattice, find_best_path, find_paths

PAIR = np.array([0.0, 10.0])


def test_one_zero_cost_join_outweighs_any_distance():
    distances = [np.array([0.0, 1e6]), np.array([0.0, 1e6])]
    consecutive = [np.array([[False, False], [False, True]])]
    best = find_paths(consecutive_lattice(distances, consecutive), 1)[0]
    assert best.choice == (1, 1)
    assert best.joins == {(0, 1, 1)}


def test_without_zero_cost_joins_there_is_one_choice_and_then_the_next_by_distance():
    lattice = consecutive_lattice([np.array([0.0, 3.0]), np.array([0.0, 1.0])], [np.zeros((2, 2), dtype=bool)])
    found = find_paths(lattice, 5)
    assert [path.choice for path in found] == [(0, 0), (0, 1), (1, 0), (1, 1)]
    assert [path.cost for path in found[1:]] == [1.0, 3.0, 4.0]


def test_the_same_joins_make_one_choice_represented_by_its_closest():
    distances = [PAIR, np.array([0.0, 9.0]), np.array([5.0, 4.0, 6.0])]
    consecutive = [np.array([[True, False], [False, False]]), np.zeros((2, 3), dtype=bool)]
    first, second = find_paths(consecutive_lattice(distances, consecutive), 2)
    assert first.choice == (0, 0, 1)
    assert first.joins == {(0, 0, 0)}
    assert second.joins == frozenset()
    assert second.choice == (0, 1, 1)


def test_one_fragment_ranks_by_distance():
    found = find_paths(consecutive_lattice([np.array([3.0, 1.0, 2.0])], []), 2)
    assert [path.choice for path in found] == [(1,), (2,)]


def test_fewer_paths_than_asked_come_back_where_there_are_no_more():
    assert len(find_paths(consecutive_lattice([np.array([1.0])], []), 5)) == 1


def test_distances_of_zero_everywhere():
    lattice = consecutive_lattice([np.zeros(2), np.zeros(2)], [np.eye(2, dtype=bool)])
    assert [len(path.joins) for path in find_paths(lattice, 3)] == [1, 1, 0]


def test_continuity_weighs_gap_against_distance():
    distances, lengths = [np.array([0.0]), np.array([0.0, 8.0])], [4, 4]
    consecutive, gaps = [np.zeros((1, 2), dtype=bool)], [np.array([[1.0, 0.0]])]

    def best(weight):
        return find_paths(continuity_lattice(distances, lengths, consecutive, gaps, weight=weight), 1)[0]

    assert (best(1.9).choice, best(2.1).choice) == ((0, 0), (0, 1))
    assert best(2.1).cost == pytest.approx(2.0)


def test_continuity_does_not_charge_a_consecutive_join():
    lattice = continuity_lattice(
        [np.array([0.0]), np.array([0.0])], [3, 3], [np.array([[True]])], [np.array([[9.0]])], weight=1.0
    )
    assert find_paths(lattice, 1)[0].cost == 0.0


def test_the_best_path_without_anything_to_differ_from_is_the_best_path():
    lattice = consecutive_lattice([PAIR, PAIR], [np.zeros((2, 2), dtype=bool)])
    nothing = [np.zeros((0, 2), dtype=bool)] * 2
    found = find_best_path(lattice, nothing)
    assert found is not None
    assert found.choice == (0, 0)


def test_no_path_where_none_differs():
    lattice = consecutive_lattice([PAIR, PAIR], [np.zeros((2, 2), dtype=bool)])
    assert find_best_path(lattice, [np.zeros((1, 2), dtype=bool)] * 2) is None


def test_many_fragments_and_candidates_are_no_burden():
    """64 candidates at 100 fragments: 64 ** 100 paths cannot be listed."""
    rng = np.random.default_rng(7)
    distances = [rng.uniform(size=64) for _ in range(100)]
    consecutive = [rng.random((64, 64)) < 0.02 for _ in range(99)]
    found = find_paths(consecutive_lattice(distances, consecutive), 10)
    assert len({path.joins for path in found}) == 10
