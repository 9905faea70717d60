"""Grids of time and resampling: known motions, known filters, known ends."""

import subprocess
import sys

import numpy as np
import pytest
from scipy.signal import resample_poly
from scipy.spatial.transform import Rotation

from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.motion.timing import find_even_step, frame_time_codes, prefer_step, resample_clip
from tests.oracle.resampling import reduce_curve

ONE_JOINT = Skeleton(joints=("Hips",), rest=np.eye(4)[None])


def clip_of(*, rate, translations=None, rotations=None, start=0.0, time_codes_per_frame=1.0):
    frames = len(translations) if translations is not None else len(rotations)
    return Clip(
        skeleton=ONE_JOINT,
        rate=rate,
        rotations=np.tile([1.0, 0.0, 0.0, 0.0], (frames, 1, 1)) if rotations is None else rotations,
        translations=np.zeros((frames, 1, 3)) if translations is None else translations,
        scales=np.ones((frames, 1, 3)),
        start=start,
        time_codes_per_frame=time_codes_per_frame,
        name="/Takes/walk",
    )


def along_x(curve):
    translations = np.zeros((len(curve), 1, 3))
    translations[:, 0, 0] = curve
    return translations


def spin(degrees):
    return Rotation.from_euler("x", np.asarray(degrees)[:, None], degrees=True).as_quat(scalar_first=True)[:, None]


class TestFrameTimeCodes:
    @pytest.mark.parametrize(
        ("start", "end", "step", "expected"),
        [
            (1.0, 4.0, 1.0, [1, 2, 3, 4]),
            (0.0, 20.0, 5.0, [0, 5, 10, 15, 20]),
            (1.0, 4.9, 1.0, [1, 2, 3, 4]),
            (7.0, 7.0, 1.0, [7]),
            (-2.0, 0.0, 0.5, [-2, -1.5, -1, -0.5, 0]),
        ],
    )
    def test_lists_every_frame_of_the_range(self, start, end, step, expected):
        np.testing.assert_array_equal(frame_time_codes(start, end, step), expected)

    def test_end_counts_despite_rounding(self):
        assert len(frame_time_codes(0.0, 0.7, 0.1)) == 8  # 0.7 / 0.1 is 6.999999999999999
        assert len(frame_time_codes(0.0, 1.0 - 0.9e-6, 1.0)) == 2
        assert len(frame_time_codes(0.0, 1.0 - 1.1e-6, 1.0)) == 1

    @pytest.mark.parametrize(
        ("start", "end", "step"), [(2.0, 1.0, 1.0), (0.0, 1.0, 0.0), (0.0, 1.0, -1.0), (0.0, np.inf, 1.0)]
    )
    def test_refuses_what_is_no_range(self, start, end, step):
        with pytest.raises(InputError, match=r"bad range of frames.*start"):
            frame_time_codes(start, end, step)


class TestFindEvenStep:
    def test_rounded_time_codes(self):
        times = np.round(np.arange(500) / 120.0, 3)  # milliseconds: steps of 0.008 and 0.009
        assert find_even_step(times) == pytest.approx(1.0 / 120.0, rel=1e-4)

    def test_drifting_time_codes(self):
        assert find_even_step(np.array([0.0, 1.0001, 2.0003, 3.0004, 4.0006])) == pytest.approx(1.0, rel=2e-4)

    def test_skipped_frames(self):
        assert find_even_step(np.array([0.0, 1.0, 2.0, 5.0, 6.0, 7.0, 20.0])) == pytest.approx(1.0)

    def test_one_stray_sample_does_not_matter(self):
        assert find_even_step(np.append(np.arange(100.0), 99.5)) == pytest.approx(1.0, rel=0.01)

    @pytest.mark.parametrize("times", [[], [3.0], [0.0, 1.0, 2.4, 4.1, 5.0, 6.5]])
    def test_hand_set_keys_have_no_step(self, times):
        assert find_even_step(np.array(times)) is None


class TestPreferStep:
    def test_takes_the_nearest_preferred_step(self):
        times = np.arange(20) * 1.0002 + np.tile([0.0, 0.01], 10)
        assert prefer_step(times, 1.0002, [1.0, 1.001, 2.0]) == 1.0

    def test_keeps_the_measured_step_where_it_is_exact(self):
        """119.88 per second is not 120 / 1.001."""
        times = np.arange(20) * (24.0 / 119.88)
        assert prefer_step(times, 24.0 / 119.88, [24.0 * 1.001 / 120.0]) == 24.0 / 119.88
        assert prefer_step(times, 24.0 / 119.88 * (1.0 + 1e-12), [24.0 / 119.88]) == 24.0 / 119.88

    def test_keeps_the_measured_step_where_the_preferred_grid_runs_away(self):
        times = np.arange(5000) * 1.0002 + np.tile([0.0, 0.01], 2500)
        assert prefer_step(times, 1.0002, [1.0]) == 1.0002

    def test_keeps_the_measured_step_where_none_is_near(self):
        assert prefer_step(np.arange(20) * 0.9, 0.9, [1.0]) == 0.9


class TestResampleClip:
    @pytest.mark.parametrize("rate", [24.0, 24.0 * (1.0 + 0.9e-6), 24.0 * (1.0 - 0.9e-6)])
    def test_same_rate_is_the_same_clip(self, rate):
        clip = clip_of(rate=24.0, translations=along_x(np.random.default_rng(1).standard_normal(9)))
        assert resample_clip(clip, rate) is clip

    def test_equals_resample_poly_where_the_ratio_is_whole(self):
        curve = np.cumsum(np.random.default_rng(2).standard_normal(403))
        resampled = resample_clip(clip_of(rate=120.0, translations=along_x(curve)), 24.0).translations[:, 0, 0]
        np.testing.assert_allclose(resampled, resample_poly(curve, 1, 5, padtype="line"), atol=1e-11)

    @pytest.mark.parametrize(("rate", "up", "down"), [(120.0, 1, 5), (30.0, 4, 5), (119.88, 200, 999), (36.0, 2, 3)])
    def test_equals_the_slow_twin(self, rate, up, down):
        curve = np.cumsum(np.random.default_rng(3).standard_normal(83))
        resampled = resample_clip(clip_of(rate=rate, translations=along_x(curve)), 24.0).translations[:, 0, 0]
        np.testing.assert_allclose(resampled, reduce_curve(curve, up, down), atol=1e-9)

    @pytest.mark.parametrize("rate", [120.0, 119.88, 60.0, 30.0, 29.97, 24.024, 23.976, 12.0, 7.1234567])
    def test_walks_at_the_same_speed(self, rate):
        """A slow swing must be where it was in seconds, and the clip as long, to a frame."""
        seconds = np.arange(int(10 * rate) + 1) / rate
        clip = clip_of(rate=rate, translations=along_x(3.0 * seconds + np.sin(2.0 * np.pi * 0.9 * seconds)))
        resampled = resample_clip(clip, 24.0)
        at = np.arange(resampled.frame_count) / 24.0
        assert seconds[-1] - 1.0 / 24.0 < at[-1] <= seconds[-1] + 1e-6
        inside = (at > 2.0) & (at < 8.0)
        expected = 3.0 * at + np.sin(2.0 * np.pi * 0.9 * at)
        # A third of a percent: the filter's own ripple, and the cubic at 7 frames/s.
        np.testing.assert_allclose(
            resampled.translations[inside, 0, 0], expected[inside], atol=0.02 if rate < 10 else 0.004
        )

    def test_fast_motion_does_not_come_back_as_slow(self):
        seconds = np.arange(1201) / 120.0
        tremble = np.sin(2.0 * np.pi * 23.0 * seconds)  # at 24 frames/s without a filter: 1 Hz
        resampled = resample_clip(clip_of(rate=120.0, translations=along_x(tremble)), 24.0).translations[48:-48, 0, 0]
        assert np.abs(tremble[::5]).max() > 0.9
        assert np.abs(resampled).max() < 0.01

    def test_straight_lines_stay_straight_to_the_ends(self):
        line = 5.0 + 0.25 * np.arange(101)
        resampled = resample_clip(clip_of(rate=100.0, translations=along_x(line)), 24.0)
        np.testing.assert_allclose(resampled.translations[:, 0, 0], 5.0 + 25.0 * np.arange(25) / 24.0, atol=1e-12)

    def test_what_never_changes_keeps_its_bits(self):
        translations = along_x(np.random.default_rng(4).standard_normal(50))
        translations[:, 0, 1] = 0.1
        for rate in (24.0, 200.0):
            resampled = resample_clip(clip_of(rate=120.0, translations=translations), rate)
            assert (resampled.translations[:, 0, 1] == 0.1).all()
            assert (resampled.scales == 1.0).all()
            assert (resampled.rotations == [1.0, 0.0, 0.0, 0.0]).all()

    def test_cubic_motion_is_refined_exactly(self):
        frames = np.arange(11.0)
        clip = clip_of(rate=12.0, translations=along_x(0.01 * frames**3 - frames))
        resampled = resample_clip(clip, 30.0)
        at = np.arange(26) * 12.0 / 30.0
        np.testing.assert_allclose(resampled.translations[:, 0, 0], 0.01 * at**3 - at, atol=1e-12)

    def test_keeps_start_and_tells_the_new_frame_distance(self):
        clip = clip_of(rate=120.0, translations=along_x(np.arange(21.0)), start=101.0, time_codes_per_frame=0.2)
        resampled = resample_clip(clip, 24.0)
        assert (resampled.rate, resampled.start, resampled.name) == (24.0, 101.0, "/Takes/walk")
        assert resampled.time_codes_per_frame == pytest.approx(1.0)
        np.testing.assert_allclose(resampled.time_codes, [101, 102, 103, 104, 105])

    def test_turning_past_a_full_turn_is_steady(self):
        """900 degrees at 2 per frame, with signs flipped as exporters do: 10 per frame at a fifth of the rate."""
        rotations = spin(2.0 * np.arange(451))
        rotations[100:] *= -1.0
        rotations[333] *= -1.0
        resampled = resample_clip(clip_of(rate=120.0, rotations=rotations), 24.0).rotations[:, 0]
        np.testing.assert_allclose(np.linalg.norm(resampled, axis=-1), 1.0, atol=1e-12)
        turns = Rotation.from_quat(resampled, scalar_first=True)
        steps = np.degrees((turns[:-1].inv() * turns[1:]).magnitude())
        np.testing.assert_allclose(steps[12:-12], 10.0, atol=0.05)

    def test_a_single_frame_stays_one(self):
        assert resample_clip(clip_of(rate=120.0, translations=along_x([4.0])), 24.0).translations[0, 0, 0] == 4.0

    @pytest.mark.parametrize("rate", [0.0, -24.0, np.inf, np.nan])
    def test_refuses_what_is_no_rate(self, rate):
        with pytest.raises(InputError, match=r"cannot resample /Takes/walk; expected a rate above 0"):
            resample_clip(clip_of(rate=24.0, translations=along_x([0.0, 1.0])), rate)


def test_slow_imports_are_left_out():
    code = "import sys, mtex_usd.motion.timing; print(*({'scipy.signal', 'scipy.interpolate'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "\n"
