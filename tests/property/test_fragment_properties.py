"""Laws of cutting that hold for every curve."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mtex_usd.texture.fragments import cut_at, find_turns, merge_breaks
from tests.oracle import fragments as twin

# Small whole numbers make plateaus; floats make none.
STEPPED = st.lists(st.integers(-3, 3).map(float), min_size=2, max_size=60)
SMOOTH = st.lists(st.floats(-100.0, 100.0), min_size=2, max_size=60)
CURVES = STEPPED | SMOOTH


def cut(curve, dead_band=0.0):
    return cut_at(merge_breaks(len(curve), find_turns(np.array(curve), dead_band)))


@given(CURVES)
def test_equals_the_slow_twin_without_a_dead_band(curve):
    assert [tuple(pair) for pair in cut(curve).tolist()] == twin.cut(curve)


@given(CURVES, st.floats(0.0, 50.0))
def test_fragments_tile_the_clip_and_share_their_borders(curve, dead_band):
    fragments = cut(curve, dead_band)
    assert fragments[0, 0] == 0
    assert fragments[-1, 1] == len(curve) - 1
    np.testing.assert_array_equal(fragments[1:, 0], fragments[:-1, 1])
    assert np.all(fragments[:, 1] > fragments[:, 0])


@given(CURVES, st.floats(0.0, 50.0))
def test_turns_go_up_and_down_in_turn_and_swing_past_the_dead_band(curve, dead_band):
    values = np.array(curve)
    turns = find_turns(values, dead_band)
    swings = np.diff(values[turns])
    assert np.all(np.abs(swings) >= dead_band)
    assert np.all(swings[1:] * swings[:-1] < 0.0)


@given(CURVES, st.floats(0.0, 50.0))
def test_a_turn_is_extreme_between_its_neighbours(curve, dead_band):
    values = np.array(curve)
    breaks = merge_breaks(len(values), find_turns(values, dead_band))
    for before, turn, after in zip(breaks[:-2], breaks[1:-1], breaks[2:], strict=True):
        around = values[before : after + 1]
        assert values[turn] in (around.max(), around.min())


@given(CURVES, st.floats(0.0, 50.0))
def test_upside_down_it_turns_at_the_same_frames(curve, dead_band):
    values = np.array(curve)
    np.testing.assert_array_equal(find_turns(values, dead_band), find_turns(-values, dead_band))
