"""Time shifted, scaled and warped: known motions, aliasing, ends, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.edit import TimeWarp, scale_time, shift_time, warp_time
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from tests.synthetic import HIPS, LEFT_ARM, LEFT_KNEE, POSITIONS, make_clip, make_skeleton, walk

X = np.array([1.0, 0.0, 0.0])


def swinging(degrees, *, rate=24.0, x=None):
    """All joints at one angle about x, and the root at a place."""
    skeleton = make_skeleton()
    vectors = np.radians(np.asarray(degrees))[:, None, None] * np.ones((1, len(skeleton.joints), 1)) * X
    positions = np.tile(POSITIONS[HIPS], (len(degrees), 1))
    positions[:, 0] = 0.0 if x is None else x
    return make_clip(skeleton, rate, quaternion.exp(vectors), positions)


def energy(clip):
    """Mean square of angle and place about none."""
    return np.mean(np.square(quaternion.log(clip.rotations))), np.mean(np.square(clip.translations[:, 0, 0]))


class TestScaleTime:
    @pytest.mark.parametrize("frames", [40, 41, 120])
    @pytest.mark.parametrize("speed", [2.0, 3.0, 3.5, 4.0])
    def test_an_alternating_motion_leaves_nothing_when_sped_up(self, frames, speed):
        """Gleicher 2000, figures 9 to 13: taking every third frame would give the motion its old speed again."""
        alternating = np.where(np.arange(frames) % 2, -1.0, 1.0)
        clip = swinging(20.0 * alternating, x=alternating)
        fast = scale_time(clip, factor=1.0 / speed)
        for found, given_energy in zip(energy(fast), energy(clip), strict=True):
            assert found < 0.01 * given_energy
        naive = alternating[np.round(np.arange(int(frames / speed)) * speed).astype(int)]
        assert np.mean(np.square(naive)) == 1.0

    def test_what_is_slow_enough_stays_when_sped_up(self):
        time = np.arange(241)
        clip = swinging(20.0 * np.sin(2.0 * np.pi * time / 60.0))
        fast = scale_time(clip, factor=0.25)
        expected = swinging(20.0 * np.sin(2.0 * np.pi * 4.0 * np.arange(61) / 60.0))
        assert np.degrees(quaternion.angle_between(fast.rotations, expected.rotations))[3:-3].max() < 0.05

    def test_twice_as_long_goes_through_the_frames(self):
        clip = walk(30)
        slow = scale_time(clip, factor=2.0)
        assert slow.frame_count == 59
        np.testing.assert_array_equal(slow.rotations[::2], clip.rotations)
        np.testing.assert_array_equal(slow.translations[::2], clip.translations)

    def test_two_frames_remain_two(self):
        clip = walk(2)
        assert scale_time(clip, factor=0.1).frame_count == 2
        assert scale_time(clip, factor=3.0).frame_count == 4

    def test_more_frames_than_there_are_hold_the_last(self):
        clip = walk(20)
        held = scale_time(clip, factor=1.0, frame_count=30)
        np.testing.assert_array_equal(held.rotations[:20], clip.rotations)
        np.testing.assert_array_equal(held.rotations[20:], np.repeat(clip.rotations[-1:], 10, axis=0))

    def test_some_channels_keep_the_length(self):
        clip = walk(40)
        scaled = scale_time(clip, factor=2.0, channels=[LEFT_ARM, f"{LEFT_KNEE}.rx"])
        whole = scale_time(clip, factor=2.0, frame_count=40)
        arm, knee = clip.joints.index(LEFT_ARM), clip.joints.index(LEFT_KNEE)
        np.testing.assert_array_equal(scaled.rotations[:, arm], whole.rotations[:, arm])
        assert quaternion.angle_between(scaled.rotations[:, knee], whole.rotations[:, knee]).max() < 1e-6
        others = [joint for joint in range(len(clip.joints)) if joint not in (arm, knee)]
        np.testing.assert_array_equal(scaled.rotations[:, others], clip.rotations[:, others])
        np.testing.assert_array_equal(scaled.translations, clip.translations)

    @pytest.mark.parametrize("factor", [0.0, -1.0, np.nan, np.inf])
    def test_refuses_a_bad_factor(self, factor):
        with pytest.raises(InputError, match="bad factor of time; expected a finite factor above 0"):
            scale_time(walk(5), factor=factor)

    def test_refuses_less_than_a_motion(self):
        with pytest.raises(
            InputError,
            match="bad frame count; expected a whole number of frames, at least 2 and at most 200000; found 1",
        ):
            scale_time(walk(5), factor=2.0, frame_count=1)

    def test_refuses_a_change_of_length_for_some_channels(self):
        with pytest.raises(InputError, match="cannot change the length of the clip; expected 5 frames; found 7"):
            scale_time(walk(5), factor=2.0, frame_count=7, channels=[LEFT_ARM])

    def test_refuses_an_unknown_channel(self):
        with pytest.raises(InputError, match="no joint fits 'Tail'"):
            scale_time(walk(5), factor=2.0, channels=["Tail"])


class TestShiftTime:
    def test_holds_the_ends(self):
        clip = walk(20)
        late = shift_time(clip, shift_s=5.0 / 24.0)
        np.testing.assert_array_equal(late.rotations[:5], np.repeat(clip.rotations[:1], 5, axis=0))
        early = shift_time(clip, shift_s=-5.0 / 24.0)
        np.testing.assert_array_equal(early.rotations[-5:], np.repeat(clip.rotations[-1:], 5, axis=0))

    def test_a_loop_walks_on_and_round(self):
        """Each cycle goes 20 ahead and turns by a quarter: four make a square."""
        frames = 21
        skeleton = make_skeleton()
        heading = np.linspace(0.0, np.pi / 2.0, frames)
        turns = np.tile([1.0, 0.0, 0.0, 0.0], (frames, len(skeleton.joints), 1))
        turns[:, 0] = quaternion.exp(heading[:, None] * np.array([0.0, 1.0, 0.0]))
        positions = np.tile([0.0, 95.0, 0.0], (frames, 1))
        positions[:, 2] = np.arange(frames)
        clip = make_clip(skeleton, 24.0, turns, positions)
        round_about = scale_time(clip, factor=1.0, frame_count=81, ends="loop")
        corners = round_about.translations[::20, 0][:, [0, 2]]
        np.testing.assert_allclose(corners, [[0, 0], [0, 20], [20, 20], [20, 0], [0, 0]], atol=1e-9)
        np.testing.assert_array_equal(round_about.translations[:, 0, 1], 95.0)
        before = shift_time(clip, shift_s=20.0 / 24.0, ends="loop")
        np.testing.assert_allclose(before.translations[0, 0], [20.0, 95.0, 0.0], atol=1e-9)

    def test_a_loop_may_be_far_away(self):
        clip = walk(20)
        far = shift_time(clip, shift_s=19.0 * 50.0 / 24.0, ends="loop")
        np.testing.assert_allclose(far.rotations[:19, 1:], clip.rotations[:19, 1:], atol=0.0)

    @pytest.mark.parametrize("turn", [0.0, 1e-7, 0.3, -2.0, 2.0 * np.pi])
    @pytest.mark.parametrize("ends", ["loop", "extrapolate"])
    def test_far_away_it_is_where_many_short_steps_take_it(self, ends, turn):
        """A walker that goes on and turns a little in every cycle, seven cycles on."""
        walker = walk(20)
        turning = quaternion.exp(np.linspace(0.0, turn, 20)[:, None] * np.array([0.0, 1.0, 0.0]))
        rotations = np.array(walker.rotations)
        rotations[:, 0] = quaternion.multiply(turning, rotations[:, 0])
        walker = replace(walker, rotations=rotations)
        near = walker
        for _ in range(7):
            near = shift_time(near, shift_s=-19.0 / walker.rate, ends=ends)
        far = shift_time(walker, shift_s=-7.0 * 19.0 / walker.rate, ends=ends)
        np.testing.assert_allclose(far.translations, near.translations, atol=1e-6)
        assert quaternion.angle_between(far.rotations, near.rotations).max() < 1e-7

    def test_extrapolates_at_the_speed_of_the_last_tenth(self):
        clip = swinging(np.arange(20.0), x=np.arange(20.0))
        early = shift_time(clip, shift_s=-5.0 / 24.0, ends="extrapolate")
        np.testing.assert_allclose(early.translations[:, 0, 0], np.arange(5.0, 25.0), atol=1e-9)
        angles = np.degrees(quaternion.log(early.rotations)[:, 3, 0])
        np.testing.assert_allclose(angles, np.arange(5.0, 25.0), atol=1e-9)

    def test_parts_of_a_frame_are_interpolated(self):
        clip = swinging(20.0 * np.sin(np.arange(60) / 8.0))
        shifted = shift_time(clip, shift_s=0.5 / 24.0)
        expected = swinging(20.0 * np.sin((np.arange(60) - 0.5) / 8.0))
        assert np.degrees(quaternion.angle_between(shifted.rotations, expected.rotations))[2:].max() < 0.01

    def test_refuses_what_is_no_time(self):
        with pytest.raises(
            InputError, match=r"bad shift of time; expected a finite number of seconds, at most 1e\+09; found nan"
        ):
            shift_time(walk(5), shift_s=float("nan"))

    def test_refuses_unknown_ends(self):
        with pytest.raises(InputError, match="unknown ends; expected hold or loop or extrapolate; found 'bounce'"):
            shift_time(walk(5), shift_s=1.0, ends="bounce")


class TestWarpTime:
    def test_events_are_moved(self):
        """Gleicher 2000, figure 15: footsteps at 20, 40, 60, 80 made to fall at 25, 39, 63, 84."""
        clip = swinging(np.interp(np.arange(101), [0, 100], [0, 50]))
        warped = warp_time(clip, pairs=[(20, 25), (40, 39), (60, 63), (80, 84)])
        angles = np.degrees(quaternion.log(warped.rotations)[:, 3, 0])
        np.testing.assert_allclose(angles[[25, 39, 63, 84]], [10, 20, 30, 40], atol=1e-6)
        assert warped.frame_count == 105

    def test_one_pair_shifts(self):
        clip = walk(30)
        warped = warp_time(clip, pairs=[(10, 14)], frame_count=30)
        np.testing.assert_array_equal(warped.rotations, shift_time(clip, shift_s=4.0 / 24.0).rotations)

    def test_the_way_stays_the_same(self):
        """Only the speed changes: along a line the places lie on the same line, and the ends are met."""
        clip = swinging(np.zeros(61), x=np.linspace(0.0, 60.0, 61))
        warped = warp_time(clip, pairs=[(0, 0), (30, 50), (60, 80)])
        np.testing.assert_allclose(warped.translations[[0, 50, 80], 0, 0], [0.0, 30.0, 60.0], atol=1e-9)
        assert (np.diff(warped.translations[:, 0, 0]) > 0.0).all()

    def test_only_what_runs_too_fast_is_filtered(self):
        """An alternating motion vanishes where it is sped up three times, and stays where it is not."""
        alternating = np.where(np.arange(241) % 2, -1.0, 1.0)
        clip = swinging(20.0 * alternating)
        warped = warp_time(clip, pairs=[(0, 0), (30, 30), (60, 60), (180, 100), (240, 160)])
        angles = np.degrees(quaternion.log(warped.rotations)[:, 3, 0])
        np.testing.assert_allclose(np.abs(angles[:31]), 20.0, atol=1e-6)
        assert np.abs(angles[66:94]).max() < 1.0

    def test_two_frames(self):
        clip = walk(2)
        assert warp_time(clip, pairs=[(0, 0), (1, 4)]).frame_count == 5

    @pytest.mark.parametrize("pairs", [[(0, 0), (10, 20), (20, 15)], [(0, 0), (0, 5)], [(0, 0), (5, 0)]])
    def test_refuses_pairs_that_cross_or_coincide(self, pairs):
        with pytest.raises(InputError, match="pairs of a time warp cross or coincide"):
            warp_time(walk(30), pairs=pairs)

    @pytest.mark.parametrize("pairs", [[], [(1, 2, 3)], [1, 2]])
    def test_refuses_what_are_no_pairs(self, pairs):
        with pytest.raises(InputError, match="bad pairs of a time warp; expected at least one pair"):
            warp_time(walk(30), pairs=pairs)

    def test_refuses_pairs_that_are_not_finite(self):
        with pytest.raises(InputError, match="bad pairs of a time warp; expected finite frames"):
            TimeWarp(np.array([[0.0, np.nan]]))
