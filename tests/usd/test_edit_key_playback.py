"""Reduced keys as USD itself plays them: sparse poses through UsdSkel, curves through Ts splines."""

import numpy as np
import pytest
from pxr import Gf, Ts, Usd, UsdSkel, Vt

from mtex_usd.edit import reduce_keys, reduce_poses
from tests.cleaning_support import add_noise, turn_joint
from tests.oracle.edit_keys import angles_between, place_joints
from tests.synthetic import LEFT_KNEE, walk
from tests.usd.playback import animation_arrays

PER_FRAME = 5


def author(stage, prim_path, joints, time_codes, rotations, translations):
    """Write poses [N, J, ...] as samples of a new SkelAnimation."""
    animation = UsdSkel.Animation.Define(stage, prim_path)
    animation.CreateJointsAttr(joints)
    attributes = (animation.CreateRotationsAttr(), animation.CreateTranslationsAttr())
    animation.CreateScalesAttr().Set(Vt.Vec3hArray([Gf.Vec3h(1.0)] * len(joints)))
    for time_code, turned, moved in zip(time_codes, rotations, translations, strict=True):
        # The constructor takes components real first.
        attributes[0].Set(Vt.QuatfArray([Gf.Quatf(*map(float, q)) for q in turned]), time_code)
        attributes[1].Set(Vt.Vec3fArray.FromNumpy(moved.astype(np.float32)), time_code)


@pytest.fixture(scope="module")
def clip():
    noisy = add_noise(walk(60, seed=3, rate=30.0), 0.2)
    return turn_joint(noisy, LEFT_KNEE, 30, 59, 80.0)


def test_poses_played_by_usdskel_stay_within_both_tolerances_at_sub_frames(clip):
    reduced = reduce_poses(clip, tolerance_deg=1.0, tolerance_m=0.01)
    assert reduced.key_count < 0.8 * clip.frame_count
    stage = Usd.Stage.CreateInMemory()
    author(stage, "/All", clip.joints, clip.time_codes, clip.rotations, clip.translations)
    author(stage, "/Few", clip.joints, reduced.time_codes, reduced.rotations, reduced.translations)
    times = np.linspace(0.0, 59.0, 59 * PER_FRAME + 1).tolist()
    (_, all_turns, all_moves), (_, few_turns, few_moves) = (
        animation_arrays(stage, path, times) for path in ("/All", "/Few")
    )
    assert angles_between(all_turns, few_turns).max() <= 1.0 + 1e-3
    for number in range(len(times)):
        places = [
            place_joints(clip.parents, turns[number], moves[number])
            for turns, moves in ((all_turns, all_moves), (few_turns, few_moves))
        ]
        off = np.linalg.norm(places[0] - places[1], axis=-1).max()
        assert off * clip.skeleton.meters_per_unit <= 0.01 + 1e-5
    played = reduced.evaluate(per_frame=PER_FRAME)
    assert angles_between(played.rotations, few_turns).max() < 1e-2
    np.testing.assert_allclose(played.translations, few_moves, atol=1e-3)


def test_curves_are_what_ts_makes_of_their_keys(clip):
    """Written as Bezier knots with slopes and widths of a third of the interval, USD's splines give the same values."""
    reduced = reduce_keys(clip)
    for curve in [curve for curve in reduced.curves if len(curve.values) > 1][:9]:
        spline = Ts.Spline()
        widths = np.concatenate([[1.0], curve.widths, [1.0]])
        for number, (time_code, value) in enumerate(zip(curve.time_codes, curve.values, strict=True)):
            knot = Ts.Knot()
            knot.SetTime(float(time_code))
            knot.SetValue(float(value))
            knot.SetNextInterpolation(Ts.InterpCurve)
            knot.SetPreTanWidth(float(widths[number]))
            knot.SetPreTanSlope(float(curve.slopes_before[number]))
            knot.SetPostTanWidth(float(widths[number + 1]))
            knot.SetPostTanSlope(float(curve.slopes_after[number]))
            spline.SetKnot(knot)
        times = np.linspace(curve.time_codes[0], curve.time_codes[-1], 301)
        played = [spline.Eval(float(time_code)) for time_code in times]
        np.testing.assert_allclose(curve.evaluate(times), played, atol=1e-6)
