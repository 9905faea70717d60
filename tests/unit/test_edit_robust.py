"""Median and robust mean: against slow twins, on spikes, at their identities, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mtex_usd.edit import median, robust_mean
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from tests.cleaning_support import add_noise, changed_frames, make_walk, turn_joint
from tests.oracle import edit_filters as oracle
from tests.synthetic import LEFT_ARM, LEFT_KNEE, walk

FIVE_FRAMES = 4.5 / 24.0


def noisy(seed=0):
    return add_noise(walk(30, seed=seed), 5.0, seed=seed)


def test_no_rotation_has_less_sum_of_angles_than_the_median():
    clip = noisy()
    joint = clip.joints.index(LEFT_ARM)
    result = median(clip, window_s=FIVE_FRAMES, channels=["LeftArm"])
    windows = oracle.windows_of_rotations(clip.rotations[:, joint], 2)
    rng = np.random.default_rng(0)
    for q, window in zip(result.rotations[:, joint], windows, strict=True):
        found = Rotation.from_quat(q, scalar_first=True)
        least = oracle.sum_of_angles(found, window)
        assert least <= min(oracle.sum_of_angles(other, window) for other in window) + 1e-9
        for size in (1e-3, 0.02):
            nearby = found * Rotation.from_rotvec(size * rng.standard_normal(3))
            assert least <= oracle.sum_of_angles(nearby, window) + 1e-9


def test_single_channels_have_the_median_of_their_values():
    clip = noisy()
    result = median(clip, window_s=FIVE_FRAMES, channels=["Hips.t"])
    for axis in range(3):
        windows = oracle.windows_of_values(clip.translations[:, 0, axis], 2)
        expected = [sorted(window)[2] for window in windows]
        np.testing.assert_allclose(result.translations[:, 0, axis], expected, atol=1e-9)


@pytest.mark.parametrize("discard", [0.0, 0.2, 0.5])
def test_robust_mean_is_the_slow_twin_s(discard):
    clip = noisy(seed=3)
    joint = clip.joints.index(LEFT_ARM)
    count = min(int(discard * 5 + 1e-6), 4)
    result = robust_mean(clip, window_s=FIVE_FRAMES, discard=discard, channels=["LeftArm", "Hips.t"])
    windows = oracle.windows_of_rotations(clip.rotations[:, joint], 2)
    for q, window in zip(result.rotations[1:-1, joint], windows[1:-1], strict=True):
        expected = oracle.trimmed_rotation(window, count)
        assert np.degrees((expected.inv() * Rotation.from_quat(q, scalar_first=True)).magnitude()) < 1e-4
    np.testing.assert_array_equal(result.rotations[[0, -1]], clip.rotations[[0, -1]])
    for axis in range(3):
        windows = oracle.windows_of_values(clip.translations[:, 0, axis], 2)
        expected = [oracle.trimmed_mean(np.array(window)[:, None], count)[0] for window in windows]
        np.testing.assert_allclose(result.translations[1:-1, 0, axis], expected[1:-1], atol=1e-9)
        np.testing.assert_array_equal(result.translations[[0, -1]], clip.translations[[0, -1]])


@pytest.mark.parametrize("edit", [median, robust_mean])
def test_a_spike_vanishes_and_other_joints_keep_their_bits(edit):
    clip = make_walk(120)
    spiked = turn_joint(clip, LEFT_KNEE, 50, 50, 90.0)
    result = edit(spiked, window_s=0.03, channels=["LeftLeg"])
    knee = clip.joints.index(LEFT_KNEE)
    assert np.degrees(quaternion.angle_between(clip.rotations, result.rotations)).max() < 2.0
    assert set(np.flatnonzero(changed_frames(spiked, result).any(axis=0))) <= {knee}


def test_the_median_keeps_an_edge_that_a_mean_blurs():
    clip = turn_joint(walk(40), LEFT_KNEE, 20, 39, 60.0)
    knee = clip.joints.index(LEFT_KNEE)
    steps = [
        np.degrees(quaternion.angle_between(result.rotations[1:, knee], result.rotations[:-1, knee])).max()
        for result in (median(clip, window_s=FIVE_FRAMES), robust_mean(clip, window_s=FIVE_FRAMES, discard=0.0))
    ]
    assert steps[0] > 50.0
    assert steps[1] < 25.0


@pytest.mark.parametrize("frames", [2, 3, 30])
def test_a_window_of_one_frame_keeps_every_bit(frames):
    clip = walk(frames)
    for window_s in (1e-9, 1.9 / clip.rate):
        assert median(clip, window_s=window_s) is clip
        assert robust_mean(clip, window_s=window_s) is clip


def test_steady_turning_passes():
    clip = walk(30, leg=0.0, arm=0.0, detail=0.0)
    knee = clip.joints.index(LEFT_KNEE)
    turning = np.radians(7.0 * np.arange(30))[:, None] * np.array([0.0, 0.6, 0.8])
    rotations = np.array(clip.rotations)
    rotations[:, knee] = quaternion.exp(turning)
    clip = replace(clip, rotations=rotations)
    for result in (median(clip, window_s=0.3), robust_mean(clip, window_s=0.3)):
        assert np.degrees(quaternion.angle_between(clip.rotations[:, knee], result.rotations[:, knee])).max() < 1e-5


@pytest.mark.parametrize("edit", [median, robust_mean])
def test_bad_windows_are_refused(edit):
    with pytest.raises(InputError, match="bad window; expected a length above 0 s; found -1 s"):
        edit(walk(10), window_s=-1.0)
    with pytest.raises(InputError, match="bad window; expected a length above 0 s; found 0 s"):
        edit(walk(10), window_s=0.0)
    with pytest.raises(InputError, match=r"longer than the motion can fill; expected at most 0.75 s"):
        edit(walk(10), window_s=1.0)
    with pytest.raises(InputError, match="no joint fits"):
        edit(walk(10), window_s=0.1, channels=["Tail"])


@pytest.mark.parametrize("discard", [-0.1, 0.6, np.nan])
def test_bad_parts_to_discard_are_refused(discard):
    with pytest.raises(InputError, match=r"bad part to discard; expected 0 to 0\.5"):
        robust_mean(walk(10), window_s=0.1, discard=discard)
