"""Wave-shaping: curves about mean and rest, soft limits, identities, and what is refused."""

import numpy as np
import pytest

from mtex_usd.edit import make_soft_limits, waveshape
from mtex_usd.edit.curve_space import CurveSpace, select_channels
from mtex_usd.errors import InputError
from tests.synthetic import LEFT_KNEE, LEFT_LEG, RIGHT_LEG, walk


def read(clip, *tokens):
    channels = select_channels(clip, tokens)
    turning = tuple(channel for channel in channels if channel.is_rotation)
    return CurveSpace(clip, (), turning, tuple(channel for channel in channels if not channel.is_rotation)).curves


def test_a_straight_curve_scales_a_channel_about_its_mean():
    clip = walk(60, seed=1)
    shaped = waveshape(clip, points=[(-50.0, -75.0), (50.0, 75.0)], channels=["*UpLeg.rx"])
    before, after = read(clip, "*UpLeg.rx"), read(shaped, "*UpLeg.rx")
    np.testing.assert_allclose(after, before.mean(axis=0) + 1.5 * (before - before.mean(axis=0)), atol=1e-9)
    changed = (clip.rotations != shaped.rotations).any(axis=(0, 2))
    assert {clip.joints[j] for j in np.flatnonzero(changed)} == {LEFT_LEG, RIGHT_LEG}


def test_the_curve_goes_through_its_points_monotone_and_smooth_and_goes_on_straight():
    clip = walk(400, seed=2, leg=60.0)
    points = [(-20.0, -30.0), (-5.0, -5.0), (10.0, 5.0), (20.0, 5.0)]
    before = read(clip, "LeftUpLeg.rx")[:, 0]
    after = read(waveshape(clip, points=points, channels=["LeftUpLeg.rx"], about="rest"), "LeftUpLeg.rx")[:, 0]
    order = np.argsort(before)
    assert (np.diff(after[order]) > -1e-9).all()
    np.testing.assert_allclose(after[before > 20.0], 5.0, atol=1e-9)
    for x, y in points:
        near = np.abs(before - x) < 1.0
        assert near.any()
        np.testing.assert_allclose(after[near], y, atol=2.5)
    slopes = np.diff(after[order]) / np.maximum(np.diff(before[order]), 1e-3)
    outside = before[order][1:] < -20.0
    assert np.ptp(slopes[outside]) < 1e-3 * slopes[outside].max() + 0.2


def test_the_identity_keeps_every_bit():
    clip = walk(60, seed=3)
    shaped = waveshape(clip, points=[(-9.0, -9.0), (0.5, 0.5), (4.0, 4.0)], channels=["*"])
    assert np.array_equal(shaped.rotations, clip.rotations)


def test_soft_limits_hold_and_leave_what_is_inside():
    clip = walk(120, seed=4, leg=40.0)
    before = read(clip, "LeftLeg.rx")
    assert before.max() > 60.0
    shaped = waveshape(clip, points=make_soft_limits(10.0, 60.0, softness=8.0), channels=["LeftLeg.rx"], about="rest")
    after = read(shaped, "LeftLeg.rx")
    assert after.max() <= 60.0 + 1e-9
    assert after.min() >= 10.0 - 1e-9
    inside = ((before > 18.0) & (before < 52.0))[:, 0]
    assert inside.sum() > 10
    knee = clip.joints.index(LEFT_KNEE)
    assert np.array_equal(shaped.rotations[inside, knee], clip.rotations[inside, knee])


@pytest.mark.parametrize(("lower", "upper"), [(-np.inf, 30.0), (10.0, np.inf)])
def test_one_limit_alone_leaves_the_other_side(lower, upper):
    clip = walk(120, seed=4, leg=40.0)
    points = make_soft_limits(lower, upper, softness=4.0)
    after = read(waveshape(clip, points=points, channels=["LeftLeg.rx"], about="rest"), "LeftLeg.rx")
    before = read(clip, "LeftLeg.rx")
    free = before < 26.0 if upper < np.inf else before > 14.0
    np.testing.assert_allclose(after[free], before[free], atol=1e-9)
    assert after.max() <= upper
    assert after.min() >= lower


def test_translations_are_shaped_in_stage_units():
    clip = walk(60)
    shaped = waveshape(clip, points=[(-1.0, 0.0), (1.0, 0.0)], channels=["Hips.ty"])
    height = read(clip, "Hips.ty")
    np.testing.assert_allclose(read(shaped, "Hips.ty"), height.mean(), atol=1e-9)


@pytest.mark.parametrize(
    "points", [[(0.0, 0.0)], [(0.0, 0.0), (0.0, 1.0)], [(0.0, 1.0), (1.0, 0.0)], [(0.0, np.nan), (1.0, 1.0)], [(1.0,)]]
)
def test_what_is_no_monotone_curve_is_refused(points):
    with pytest.raises(InputError, match=r"bad points of the curve|no monotone curve"):
        waveshape(walk(10), points=points, channels=["Head"])


def test_bad_requests_are_refused():
    line = [(0.0, 0.0), (1.0, 1.0)]
    with pytest.raises(InputError, match="no channels to shape"):
        waveshape(walk(10), points=line, channels=[])
    with pytest.raises(InputError, match="one curve cannot shape degrees and stage units"):
        waveshape(walk(10), points=line, channels=["Hips.rx", "Hips.tx"])
    with pytest.raises(InputError, match="bad origin of the curve; expected mean or rest; found 'zero'"):
        waveshape(walk(10), points=line, channels=["Head"], about="zero")
    with pytest.raises(InputError, match="bad limits"):
        make_soft_limits(0.0, 10.0, softness=5.0)
    with pytest.raises(InputError, match="bad limits"):
        make_soft_limits(-np.inf, np.inf)
