"""Key reduction: fits against dense least squares, tolerances everywhere, counts, contacts, outliers, refusals."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.edit import KeyCurve, reduce_keys, reduce_poses
from mtex_usd.edit.curve_space import select_channels
from mtex_usd.edit.keys.deviation import make_deviation
from mtex_usd.edit.keys.hermite import KeySet, fit_curves
from mtex_usd.edit.keys.sampled import play_between, sample_channels
from mtex_usd.edit.keys.tolerance import Tolerance
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from tests.cleaning_support import add_noise, make_walk, turn_joint
from tests.oracle import edit_keys as oracle
from tests.synthetic import HIPS, LEFT_ARM, LEFT_KNEE, RIGHT_ARM, SPINE, walk


def differences(clip, reduced, per_frame):
    """Largest angle in degrees and distance in metres between what is played, with the slow twins."""
    times = np.arange((clip.frame_count - 1) * per_frame + 1) / per_frame
    frames = np.arange(clip.frame_count)
    joints = range(len(clip.joints))
    expected = np.stack([oracle.play_rotations(frames, clip.rotations[:, j], times) for j in joints], axis=1)
    found = reduced.evaluate(per_frame=per_frame)
    moved = np.stack([[np.interp(times, frames, c) for c in clip.translations[:, j].T] for j in joints])
    angles = oracle.angles_between(expected, found.rotations).max()
    distances = [
        np.linalg.norm(
            oracle.place_joints(clip.parents, expected[t], moved[:, :, t])
            - oracle.place_joints(clip.parents, found.rotations[t], found.translations[t]),
            axis=-1,
        ).max()
        for t in range(0, len(times), 3)
    ]
    return angles, max(distances) * clip.skeleton.meters_per_unit


def test_fits_are_the_dense_least_squares():
    rng = np.random.default_rng(4)
    samples = np.cumsum(rng.standard_normal((3, 40)), axis=1)
    keys = [[0, 7, 8, 20, 39], [0, 39], [0, 13, 26, 39]]
    pinned, broken = [[0, 39, 20], [0, 39], [13]], [[8], [0, 39], [13, 26]]
    marks = [np.zeros((3, 40), dtype=bool) for _ in range(3)]
    for mark, of_channels in zip(marks, (keys, pinned, broken), strict=True):
        for channel, places in enumerate(of_channels):
            mark[channel, places] = True
    curves = fit_curves(samples, KeySet(*marks)).curves
    for channel in range(3):
        expected = oracle.fit_hermite(samples[channel], keys[channel], pinned[channel], broken[channel], 0.1)
        np.testing.assert_allclose(curves[channel], expected, atol=1e-7)


def test_the_first_order_model_tells_small_differences():
    clip = make_walk(20, oriented=5)
    channels = select_channels(clip, ())
    samples = sample_channels(clip, channels, 1)
    rng = np.random.default_rng(1)
    step = 1e-4
    errors = step * rng.standard_normal(samples.values.shape)
    turns, shifts = make_deviation(samples, Tolerance(degrees=1.0, metres=1.0)).propagate(errors)
    from mtex_usd.edit.keys.curves import rebuild

    off = rebuild(samples, samples.values + errors)
    angles = oracle.angles_between(clip.rotations, off.rotations)
    np.testing.assert_allclose(np.degrees(np.linalg.norm(turns, axis=1)).T, angles, atol=1e-3 * step, rtol=1e-3)
    for frame in (0, 7, 19):
        before = oracle.place_joints(clip.parents, clip.rotations[frame], clip.translations[frame])
        after = oracle.place_joints(clip.parents, off.rotations[frame], off.translations[frame])
        np.testing.assert_allclose(shifts[:, :, frame], after - before, atol=1e-3 * step)


@pytest.mark.parametrize("reduce", [reduce_keys, reduce_poses])
@pytest.mark.parametrize(("degrees", "metres"), [(0.5, 0.005), (3.0, 0.002), (0.2, np.inf)])
def test_everything_stays_within_both_tolerances(reduce, degrees, metres):
    clip = walk(80, seed=6, rate=30.0)
    reduced = reduce(clip, tolerance_deg=degrees, tolerance_m=metres)
    angle, distance = differences(clip, reduced, 4)
    assert angle <= degrees * 1.001
    assert distance <= metres
    assert reduced.max_degrees == pytest.approx(angle, abs=1e-5)
    assert reduced.max_metres >= distance - 1e-9


def test_noise_and_jumps_stay_within_the_tolerances_too():
    clip = turn_joint(add_noise(walk(60, seed=2), 1.0), LEFT_KNEE, 30, 59, 120.0, axis=(0.6, 0.0, 0.8))
    for reduced in (reduce_keys(clip), reduce_poses(clip)):
        angle, distance = differences(clip, reduced, 8)
        assert angle <= 0.51
        assert distance <= 0.005


def test_curves_are_bezier_curves_with_tangents_a_third_wide():
    clip = replace(walk(50, seed=3), start=1001.0, time_codes_per_frame=2.0)
    for curve in reduce_keys(clip).curves[:12]:
        times = np.linspace(curve.time_codes[0] - 3.0, curve.time_codes[-1] + 3.0, 77)
        held = (curve.time_codes, curve.values, curve.slopes_before, curve.slopes_after)
        np.testing.assert_allclose(curve.evaluate(times), [oracle.evaluate_bezier(*held, t) for t in times], atol=1e-9)
        np.testing.assert_allclose(curve.widths, np.diff(curve.time_codes) / 3.0)
        np.testing.assert_allclose(curve.time_codes, 1001.0 + 2.0 * curve.frames)


def test_a_smooth_swing_takes_few_keys():
    clip = walk(240, rate=120.0, detail=0.0)
    reduced = reduce_keys(clip)
    moving = [len(curve.values) for curve in reduced.curves if len(curve.values) > 1]
    assert np.mean(moving) < 0.05 * 240
    assert reduced.key_count == sum(len(curve.values) for curve in reduced.curves)


def test_what_does_not_move_has_one_key():
    clip = walk(30, detail=0.0)
    curves = {(curve.joint, curve.kind): curve for curve in reduce_keys(clip).curves}
    still = curves["Hips/Spine/Head", "rx"]
    assert isinstance(still, KeyCurve)
    assert len(still.values) == 1
    np.testing.assert_array_equal(still.evaluate(np.array([-1.0, 5.0, 99.0])), still.values[0])


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_the_shortest_clips_come_back(frames):
    clip = walk(frames, seed=1)
    for reduced in (reduce_keys(clip), reduce_poses(clip)):
        again = reduced.evaluate()
        assert again.frame_count == frames
        assert np.degrees(quaternion.angle_between(clip.rotations, again.rotations)).max() < 0.5


def test_only_chosen_channels_become_curves_and_the_rest_keeps_its_bits():
    clip = walk(40, seed=9)
    reduced = reduce_keys(clip, channels=["LeftArm", "Hips.ty"], tolerance_deg=4.0, tolerance_m=0.1)
    assert [(c.joint, c.kind) for c in reduced.curves] == [
        (HIPS, "ty"), (LEFT_ARM, "rx"), (LEFT_ARM, "ry"), (LEFT_ARM, "rz"),
    ]  # fmt: skip
    again = reduced.evaluate()
    changed = (clip.rotations != again.rotations).any(axis=(0, 2))
    assert {clip.joints[j] for j in np.flatnonzero(changed)} == {LEFT_ARM}
    assert (again.translations[:, 1:] == clip.translations[:, 1:]).all()


@pytest.mark.parametrize("reduce", [reduce_keys, reduce_poses])
def test_contact_frames_are_keys_with_the_exact_pose(reduce):
    clip = walk(60, seed=4)
    reduced = reduce(clip, contact_frames=[17, 18, 41])
    keys = (
        [curve.frames for curve in reduced.curves if len(curve.values) > 1]
        if reduce is reduce_keys
        else [reduced.frames]
    )
    for frames in keys:
        assert {0, 17, 18, 41, 59} <= set(frames.tolist())
    again = reduced.evaluate()
    for frame in (0, 17, 18, 41, 59):
        assert np.degrees(quaternion.angle_between(clip.rotations[frame], again.rotations[frame])).max() < 1e-9
        np.testing.assert_allclose(clip.translations[frame], again.translations[frame], atol=1e-9)


@pytest.mark.parametrize("reduce", [reduce_keys, reduce_poses])
def test_more_keys_fit_better_and_no_more_are_used_than_allowed(reduce):
    clip = walk(120, rate=60.0, seed=5)
    errors = []
    for count in (6, 12, 24):
        reduced = reduce(clip, key_count=count)
        used = max(len(c.values) for c in reduced.curves) if reduce is reduce_keys else reduced.key_count
        assert used <= count
        assert reduced.tolerance is None
        errors.append(reduced.max_degrees)
    assert errors[0] > 1.5 * errors[1] > 2.0 * errors[2]


@pytest.mark.parametrize("reduce", [reduce_keys, reduce_poses])
def test_robust_discards_what_stands_out(reduce):
    clip = make_walk(100)
    spiked = turn_joint(turn_joint(clip, LEFT_KNEE, 50, 50, 40.0), RIGHT_ARM, 70, 71, 30.0)
    plain, robust = reduce(spiked), reduce(spiked, robust=True)
    assert set(robust.discarded) == {(LEFT_KNEE, 50), (RIGHT_ARM, 70), (RIGHT_ARM, 71)}
    assert plain.discarded == ()
    assert robust.key_count < plain.key_count
    again = robust.evaluate()
    assert np.degrees(quaternion.angle_between(clip.rotations[50], again.rotations[50])).max() < 2.0


def test_joints_that_do_not_count_make_no_poses():
    clip = add_noise(walk(80, rate=60.0, detail=0.0), 0.0)
    rotations = np.array(clip.rotations)
    shaking = add_noise(clip, 10.0).rotations
    head = clip.joints.index("Hips/Spine/Head")
    rotations[:, head] = shaking[:, head]
    clip = replace(clip, rotations=rotations)
    counted = [joint for joint in clip.joints if joint != "Hips/Spine/Head"]
    few, many = reduce_poses(clip, channels=counted), reduce_poses(clip)
    assert few.key_count < 0.5 * many.key_count
    assert few.max_degrees <= 0.5
    assert SPINE in counted


def test_poses_have_time_codes_and_unit_rotations():
    clip = replace(walk(40), start=1001.0, time_codes_per_frame=2.5)
    reduced = reduce_poses(clip)
    np.testing.assert_allclose(reduced.time_codes, 1001.0 + 2.5 * reduced.frames)
    np.testing.assert_allclose(np.linalg.norm(reduced.rotations, axis=-1), 1.0)
    assert reduced.rotations.shape == (reduced.key_count, len(clip.joints), 4)
    assert reduced.scales.shape == reduced.translations.shape == (reduced.key_count, len(clip.joints), 3)


def test_between_frames_the_motion_is_slerped():
    clip = walk(10, seed=2)
    fine = play_between(clip, 5)
    times = np.arange(46) / 5.0
    for joint in range(len(clip.joints)):
        expected = oracle.play_rotations(np.arange(10), clip.rotations[:, joint], times)
        assert oracle.angles_between(expected, fine.rotations[:, joint]).max() < 1e-6
    assert fine.rate == 5.0 * clip.rate


@pytest.mark.parametrize("reduce", [reduce_keys, reduce_poses])
def test_bad_requests_are_refused(reduce):
    clip = walk(20)
    with pytest.raises(InputError, match="bad tolerance; expected degrees and metres above 0; found 0 degrees"):
        reduce(clip, tolerance_deg=0.0)
    with pytest.raises(InputError, match="bad tolerance"):
        reduce(clip, tolerance_m=np.nan)
    with pytest.raises(InputError, match="contact frames outside the clip; expected 0 to 19; found -1, 20"):
        reduce(clip, contact_frames=[-1, 5, 20])
    with pytest.raises(InputError, match="too few keys; expected at least 3, for the ends and the contacts; found 2"):
        reduce(clip, contact_frames=[5], key_count=2)
    with pytest.raises(InputError, match="no joint fits 'Tail'"):
        reduce(clip, channels=["Tail"])
