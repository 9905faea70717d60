"""Joining fragments, against figures worked out by hand and the equations of section 3.4."""

import numpy as np
import pytest

from mtex_usd.motion import quaternion
from mtex_usd.texture.joining import blend_weights, join_curves, join_rotations

APART, FOLLOWS = np.array([False]), np.array([True])


def column(*values):
    return np.array(values, dtype=np.float64)[:, None]


def join(fragments, continued=APART, join_frames=0, *, turning=False, sliding=False):
    joined = join_curves(fragments, continued, join_frames, turning=np.array([turning]), sliding=np.array([sliding]))
    return joined[:, 0]


@pytest.mark.parametrize("reach", [3, 5, 10, 20])
def test_the_weight_is_1_at_the_join_and_0_at_n_and_flat_at_both(reach):
    """The misprint: equation 1 as printed is 4 at the join."""
    weights = blend_weights(reach)
    assert weights[reach] == 1.0
    np.testing.assert_allclose(weights[[0, -1]], 0.0, atol=1e-30)
    np.testing.assert_allclose(weights, weights[::-1], atol=1e-15)
    t = np.arange(reach + 1)
    np.testing.assert_allclose(weights[reach:], 0.5 + 0.5 * np.cos(np.pi * t / reach), atol=1e-15)


def test_new_end_points_are_the_mean_of_the_meeting_points():
    joined = join([column(0, 0, 0), column(10, 10, 10)])
    np.testing.assert_allclose(joined, [0.0, 2.5, 5.0, 7.5, 10.0])


def test_the_skew_subtracts_one_line_and_adds_another():
    left, right = column(1, 5, 2), column(6, 0, 3, 7)
    joined = join([left, right])
    # Left: from the line 1..2 to the line 1..4. Right: from the line 6..7 to the line 4..7.
    np.testing.assert_allclose(joined[:3], [1.0, 5.0 - 1.5 + 2.5, 4.0])
    np.testing.assert_allclose(joined[2:], [4.0, 0.0 - 19.0 / 3.0 + 5.0, 3.0 - 20.0 / 3.0 + 6.0, 7.0])


def test_a_fragment_between_two_joins_meets_both():
    joined = join([column(0, 0), column(4, 4, 4), column(0, 0)], np.array([False, False]))
    np.testing.assert_allclose(joined, [0.0, 2.0, 4.0 - 2.0, 2.0, 0.0])


def test_the_quadratic_is_fitted_to_2_frames_from_the_join_up_to_n():
    """What lies within one frame of the join does not shape the curve."""
    t = np.arange(-12.0, 13.0)
    parabola = 1.0 + 2.0 * t + 0.5 * t * t
    bumped = np.array(parabola)
    bumped[11:14] += [3.0, 0.0, -4.0]
    joined = join([bumped[:13, None], bumped[12:, None]], join_frames=6)
    weights = np.zeros(25)
    weights[6:19] = blend_weights(6)
    np.testing.assert_allclose(joined, weights * parabola + (1.0 - weights) * bumped, atol=1e-10)


def test_below_3_frames_nothing_is_fitted():
    sharp = [column(0, 1, 2, 3, 4, 5), column(5, 4, 3, 2, 1, 0)]
    np.testing.assert_array_equal(join(sharp, join_frames=2), [0, 1, 2, 3, 4, 5, 4, 3, 2, 1, 0])
    short = [column(0, 1, 2, 3, 4, 5), column(5, 4, 3, 2, 1)]
    np.testing.assert_array_equal(join(short, join_frames=9), [0, 1, 2, 3, 4, 5, 4, 3, 2, 1])


def test_n_is_at_most_half_the_shorter_fragment():
    whole = np.sin(1.3 * np.arange(-20.0, 8.0))
    joined = join([whole[:21, None], whole[20:, None]], join_frames=15)
    changed = np.flatnonzero(np.abs(joined - whole) > 1e-12) - 20
    assert changed.min() == -2
    assert changed.max() == 2


def test_where_fragments_follow_nothing_is_smoothed():
    sharp = [np.arange(10.0)[:, None], np.arange(9.0, -1.0, -1.0)[:, None]]
    np.testing.assert_array_equal(join(sharp, FOLLOWS, 5), [*range(10), *range(8, -1, -1)])


def test_angles_meet_on_the_nearest_turn():
    joined = join([column(350, 355, 358), column(2, 6, 10)], turning=True)
    np.testing.assert_allclose(joined, [350.0, 356.0, 360.0, 365.0, 370.0])


def test_angles_several_turns_away_come_back():
    joined = join([column(0, 0), column(1081, 1081), column(-719, -719)], np.array([False, False]), turning=True)
    np.testing.assert_allclose(joined, [0.0, 0.5, 1.0, 1.0], atol=1e-12)


def test_plain_columns_do_not_turn():
    np.testing.assert_allclose(join([column(0, 0), column(360, 360)]), [0.0, 180.0, 360.0])


def test_travel_carries_on_from_where_it_is():
    joined = join([column(0, 1, 2), column(100, 102, 104), column(7, 7)], np.array([False, False]), sliding=True)
    np.testing.assert_allclose(joined, [0.0, 1.0, 2.0, 4.0, 6.0, 6.0])


def test_one_fragment_is_itself():
    np.testing.assert_array_equal(join([column(3, 1, 2)], np.zeros(0, dtype=bool), 9), [3.0, 1.0, 2.0])


def turn_x(*degrees):
    angles = np.radians(np.array(degrees))[:, None, None] * np.array([1.0, 0.0, 0.0])
    return quaternion.exp(angles)


def angles_x(rotations):
    return np.degrees(quaternion.twist(rotations[:, 0], np.array([1.0, 0.0, 0.0])))


def test_rotations_about_one_axis_join_as_numbers_do():
    left, right = (10, 20, 25, 20, 15, 12, 11), (20, 26, 33, 37, 38, 37, 30)
    joined = join_rotations([turn_x(*left), turn_x(*right)], APART, 2)
    np.testing.assert_allclose(angles_x(joined), join([column(*left), column(*right)]), atol=1e-9)


def test_rotations_meet_the_short_way_round():
    joined = join_rotations([turn_x(170, 170, 170), turn_x(-170, -170, -170)], APART, 0)
    np.testing.assert_allclose(np.mod(angles_x(joined), 360.0), [170.0, 175.0, 180.0, 185.0, 190.0], atol=1e-9)


def test_the_sign_of_a_quaternion_does_not_matter():
    left, right = turn_x(0, 10, 20), turn_x(30, 40, 50)
    one, other = join_rotations([left, right], APART, 0), join_rotations([left, -right], APART, 0)
    assert quaternion.angle_between(one, other).max() < 1e-7


def test_consecutive_quaternions_keep_one_sign():
    joined = join_rotations([turn_x(0, 60, 120), -turn_x(140, 200, 260)], APART, 0)
    assert np.all(np.sum(joined[1:] * joined[:-1], axis=-1) > 0.0)


def test_a_sharp_corner_is_rounded():
    left, right = np.arange(0.0, 22.0, 2.0), np.arange(20.0, -2.0, -2.0)
    joined = angles_x(join_rotations([turn_x(*left), turn_x(*right)], APART, 5))
    corner = np.concatenate([left, right[1:]])
    assert np.abs(np.diff(joined, 2)).max() < 0.7 * np.abs(np.diff(corner, 2)).max()
    np.testing.assert_allclose(joined[[0, 4, 5, 15, 16, 20]], corner[[0, 4, 5, 15, 16, 20]], atol=1e-9)


def test_each_side_of_a_join_has_its_own_limit():
    """10 degrees a frame, then 13: on neither side does the bend come near the limit of 12 and 15.6."""
    left, right = 10.0 * np.arange(17.0), 160.0 + 13.0 * np.arange(17.0)
    speeds = np.diff(np.unwrap(angles_x(join_rotations([turn_x(*left), turn_x(*right)], APART, 4)), period=360.0))
    assert np.all((speeds[12:20] > 9.9) & (speeds[12:20] < 13.1))
    assert np.abs(np.diff(speeds)).max() < 1.5
