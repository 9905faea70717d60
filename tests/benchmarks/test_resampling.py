"""The resampling benchmark measures like with like; the times are for ``python -m tests.benchmarks.resampling``."""

import numpy as np

from mtex_usd.motion import quaternion
from mtex_usd.motion.timing import resample_clip
from tests.benchmarks.resampling import FRAMES, compare_resampling, make_motion, resample_in_a_loop


def test_the_loop_gives_the_same_motion() -> None:
    clip = make_motion(241)
    resampled = resample_clip(clip, 30.0)
    rotations, translations = resample_in_a_loop(clip)
    assert quaternion.angle_between(resampled.rotations, rotations).max() < 1e-7
    np.testing.assert_allclose(resampled.translations, translations, atol=1e-9)


def test_the_motion_is_as_large_as_agreed() -> None:
    assert make_motion().rotations.shape == (FRAMES, 31, 4) == (2752, 31, 4)


def test_it_is_much_faster_than_a_loop() -> None:
    found = compare_resampling(frames=481, runs=3)["resample_clip"]
    assert found.yardstick > 20.0 * found.measured
