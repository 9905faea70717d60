"""Where a motion is cut."""

import numpy as np
import pytest

from mtex_usd.texture.fragments import cut_at, find_turns, merge_breaks


def turns_of(values, dead_band=0.0):
    return find_turns(np.array(values, dtype=np.float64), dead_band).tolist()


def test_breaks_where_the_derivative_changes_sign():
    assert turns_of([0, 1, 2, 1, 0, 1, 2]) == [2, 4]


def test_a_plateau_keeps_the_sign_before_it():
    assert turns_of([0, 1, 2, 2, 2, 1, 0]) == [4]
    assert turns_of([2, 1, 1, 1, 2]) == [3]


def test_a_plateau_on_the_way_is_no_turn():
    assert turns_of([0, 1, 1, 1, 2, 3]) == []
    assert turns_of([3, 2, 2, 1, 1, 0]) == []


def test_a_plateau_at_the_beginning_is_no_turn():
    assert turns_of([1, 1, 1, 0, -1]) == []
    assert turns_of([1, 1, 1, 2, 1]) == [3]


@pytest.mark.parametrize("values", [[0, 1, 2, 5, 9], [9, 3, 1, 0], [4, 4, 4], [0, 1], [1, 1]])
def test_a_curve_that_never_turns_is_one_fragment(values):
    fragments = cut_at(merge_breaks(len(values), turns_of(values)))
    assert fragments.tolist() == [[0, len(values) - 1]]


def test_swings_within_the_dead_band_do_not_break():
    noisy = [0, 1, 0.9, 2, 1.9, 3, 2, 2.1, 1, 0]
    assert turns_of(noisy) == [1, 2, 3, 4, 5, 6, 7]
    assert turns_of(noisy, dead_band=0.5) == [5]


def test_a_swing_of_exactly_the_dead_band_breaks():
    assert turns_of([0, 1, 0.5, 1.5], dead_band=0.5) == [1, 2]
    assert turns_of([0, 1, 0.5, 1.5], dead_band=0.5001) == []


def test_slow_drift_past_the_dead_band_breaks_at_the_true_turn():
    rise, fall = np.linspace(0.0, 1.0, 50), np.linspace(1.0, 0.0, 50)[1:]
    assert turns_of([*rise, *fall], dead_band=0.1) == [49]


def test_first_and_last_frame_are_breaks():
    assert merge_breaks(10, []).tolist() == [0, 9]


def test_turns_and_borders_merge_sorted_and_once():
    assert merge_breaks(10, [7, 2], [2, 5, 0, 9]).tolist() == [0, 2, 5, 7, 9]


def test_borders_outside_the_clip_are_dropped():
    assert merge_breaks(10, [], [-1, 10, 12]).tolist() == [0, 9]


def test_fragments_share_their_border_frames():
    assert cut_at(np.array([0, 4, 9])).tolist() == [[0, 4], [4, 9]]
