"""Laws of resampling that hold for every motion."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.motion.timing import find_even_step, frame_time_codes, resample_clip
from tests.oracle.resampling import reduce_curve

SKELETON = Skeleton(joints=("Hips", "Hips/Leg"), rest=np.tile(np.eye(4), (2, 1, 1)))
FRAMES = st.integers(2, 60)
RATES = st.floats(5.0, 240.0)
SEEDS = st.integers(0, 2**32 - 1)


def smooth_clip(seed, frames, rate):
    """Joints that swing less than half a turn from frame to frame."""
    rng = np.random.default_rng(seed)
    walk = np.cumsum(0.2 * rng.standard_normal((frames, 2, 3)), axis=0)
    return Clip(
        skeleton=SKELETON,
        rate=rate,
        rotations=quaternion.unroll(quaternion.exp(walk)),
        translations=np.cumsum(rng.standard_normal((frames, 2, 3)), axis=0),
        scales=np.ones((frames, 2, 3)),
        start=float(rng.integers(-100, 100)),
    )


@given(SEEDS, FRAMES, RATES, RATES)
def test_lasts_as_long_and_starts_when_it_did(seed, frames, old, new):
    clip = smooth_clip(seed, frames, old)
    resampled = resample_clip(clip, new)
    before, after = (frames - 1) / old, (resampled.frame_count - 1) / resampled.rate
    assert before - 1.0 / resampled.rate < after <= before + 1e-5 / resampled.rate
    assert resampled.start == clip.start
    np.testing.assert_allclose(np.linalg.norm(resampled.rotations, axis=-1), 1.0, atol=1e-12)


@given(SEEDS, FRAMES, RATES, RATES)
def test_the_signs_of_quaternions_do_not_matter(seed, frames, old, new):
    clip = smooth_clip(seed, frames, old)
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], size=(frames, 2, 1))
    flipped = Clip(
        skeleton=SKELETON,
        rate=old,
        rotations=clip.rotations * signs,
        translations=clip.translations,
        scales=clip.scales,
    )
    one, other = resample_clip(clip, new).rotations, quaternion.unroll(resample_clip(flipped, new).rotations)
    np.testing.assert_allclose(np.abs(np.sum(one * other, axis=-1)), 1.0, atol=1e-9)


@given(SEEDS, FRAMES, RATES, RATES)
def test_turning_the_whole_motion_commutes(seed, frames, old, new):
    """Nothing depends on the axes: turned then resampled is resampled then turned."""
    clip = smooth_clip(seed, frames, old)
    turn = quaternion.normalize(np.random.default_rng(seed + 1).standard_normal(4))
    turned = Clip(
        skeleton=SKELETON,
        rate=old,
        rotations=quaternion.multiply(turn, clip.rotations),
        translations=quaternion.rotate(turn, clip.translations),
        scales=clip.scales,
    )
    before, after = resample_clip(turned, new), resample_clip(clip, new)
    np.testing.assert_allclose(before.rotations, quaternion.multiply(turn, after.rotations), atol=1e-7)
    np.testing.assert_allclose(before.translations, quaternion.rotate(turn, after.translations), atol=1e-9)


@given(SEEDS, st.integers(1, 12), st.integers(2, 6))
def test_forwards_is_backwards(seed, seconds, factor):
    """No delay: where the last frame falls on the new grid, reversing before or after is the same."""
    clip = smooth_clip(seed, seconds * factor + 1, float(factor))
    reverse = Clip(
        skeleton=SKELETON,
        rate=clip.rate,
        rotations=clip.rotations[::-1],
        translations=clip.translations[::-1],
        scales=clip.scales,
    )
    one, other = resample_clip(clip, 1.0), resample_clip(reverse, 1.0)
    np.testing.assert_allclose(one.translations, other.translations[::-1], atol=1e-10)


@given(SEEDS, st.integers(2, 40), st.integers(1, 9), st.integers(2, 10))
def test_fast_equals_slow(seed, frames, up, more):
    clip = smooth_clip(seed, frames, float(up + more))
    resampled = resample_clip(clip, float(up))
    divisor = np.gcd(up, up + more)
    expected = reduce_curve(clip.translations[:, 1, 2], up // divisor, (up + more) // divisor)
    np.testing.assert_allclose(resampled.translations[:, 1, 2], expected, atol=1e-9)


@given(st.floats(-1e4, 1e4), st.integers(0, 400), st.floats(1e-3, 1e3))
def test_a_grid_ends_where_it_was_told(start, frames, step):
    grid = frame_time_codes(start, start + frames * step, step)
    assert len(grid) == frames + 1
    assert grid[0] == start


@given(SEEDS, st.integers(3, 200), st.floats(1e-3, 1e3))
def test_even_samples_are_recognised_through_jitter(seed, frames, step):
    jitter = np.random.default_rng(seed).uniform(-0.05, 0.05, frames)
    found = find_even_step(step * (np.arange(frames) + jitter))
    assert found is not None
    assert abs(found / step - 1.0) <= 0.1 / (frames - 1) + 1e-9
