"""The candidates of every sketch fragment, and what joining them costs."""

import numpy as np
import pytest

from mtex_usd.texture.candidates import Candidates, build_lattice
from mtex_usd.texture.recipe import Recipe


def candidates(*uses, distance=None):
    take, first, last = np.array(uses).T
    found = np.zeros(len(uses)) if distance is None else np.array(distance)
    return Candidates(take, first, last, found, np.ones(len(uses)), stretch_lifted=False)


LEFT = candidates((0, 0, 10), (1, 0, 10), distance=[4.0, 8.0])
RIGHT = candidates((0, 10, 20), (0, 11, 20), (1, 5, 10), distance=[1.0, 2.0, 3.0])
FRAGMENTS = np.array([[0, 7], [7, 11]])
CURVES = [np.stack([np.arange(30.0), 2.0 * np.arange(30.0)], axis=1), np.full((30, 2), 10.0)]


def lattice(cost, *, weight=1.0, sliding=(False, False)):
    recipe = Recipe(path_cost=cost, path_weight=weight)
    return build_lattice([LEFT, RIGHT], FRAGMENTS, CURVES, np.array(sliding), recipe)


@pytest.mark.parametrize("cost", ["consecutive", "continuity"])
def test_consecutive_is_the_next_frame_of_the_same_take(cost):
    (table,) = lattice(cost).consecutive
    assert table.tolist() == [[True, False, False], [False, False, False]]


def test_continuity_costs_distance_per_frame_and_the_mean_squared_gap():
    found = lattice("continuity", weight=3.0)
    np.testing.assert_allclose(found.node_costs[0], [4.0 / 8.0, 8.0 / 8.0])
    np.testing.assert_allclose(found.node_costs[1], [1.0 / 5.0, 2.0 / 5.0, 3.0 / 5.0])
    # Left ends at (10, 20) and (10, 10); right begins at (10, 20), (11, 22) and (10, 10).
    expected = 3.0 * np.array([[0.0, 0.5 * (1 + 4), 0.5 * 100], [0.5 * 100, 0.5 * (1 + 144), 0.0]])
    np.testing.assert_allclose(found.join_costs[0], expected, atol=1e-9)


def test_columns_that_carry_on_have_no_gap():
    found = lattice("continuity", sliding=(False, True))
    np.testing.assert_allclose(found.join_costs[0], [[0.0, 1.0, 0.0], [0.0, 1.0, 0.0]], atol=1e-9)


def test_the_papers_cost_is_0_or_more_than_any_distance():
    found = lattice("consecutive")
    assert found.join_costs[0][0, 0] == 0.0
    assert np.delete(found.join_costs[0].ravel(), 0).min() > 8.0 + 3.0
    np.testing.assert_array_equal(found.node_costs[0], LEFT.distance)
