"""The other steps of the clean-up: leading frames, spikes, gaps, noise, floor and jumps."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.edit.cleaning import fill_gaps, repair_spikes, report_floor, report_jumps, smooth_noise, trim_leading
from mtex_usd.edit.cleaning.noise import find_sharp_frames, measure_noise
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from tests.cleaning_support import (
    LEFT_TOE,
    add_noise,
    changed_frames,
    make_walk,
    positions,
    prepend_rest,
    turn_joint,
)
from tests.synthetic import HIPS, LEFT_ARM, LEFT_KNEE, LEFT_LEG, RIGHT_ARM, SPINE


def angles(a, b):
    return np.degrees(quaternion.angle_between(a.rotations, b.rotations))


def spread_arms_down(clip):
    """Hold the arms far from rest, so that the rest pose jumps."""
    for joint, sign in ((LEFT_ARM, -1.0), (RIGHT_ARM, 1.0)):
        clip = turn_joint(clip, joint, 0, clip.frame_count - 1, sign * 70.0)
    return turn_joint(turn_joint(clip, LEFT_LEG, 0, clip.frame_count - 1, 20.0), SPINE, 0, clip.frame_count - 1, 15.0)


@pytest.mark.parametrize("rate", [24.0, 30.0, 120.0])
@pytest.mark.parametrize("frames", [1, 2])
def test_leading_rest_pose_is_taken_off(rate, frames):
    clip = spread_arms_down(make_walk(rate=rate))
    given = replace(prepend_rest(clip, frames), start=10.0, time_codes_per_frame=2.0)
    result = trim_leading(given)
    assert (result.clip.rotations == clip.rotations).all()
    assert result.dropped_frames == frames
    assert result.clip.start == 10.0 + 2.0 * frames
    assert [(c.step, c.joint, c.first, c.last) for c in result.changes] == [("leading", "", 0, frames - 1)]


def test_junk_after_the_rest_pose_is_leading_too():
    clip = spread_arms_down(make_walk())
    junk = prepend_rest(turn_joint(prepend_rest(clip), RIGHT_ARM, 0, 0, 90.0))
    assert trim_leading(junk).dropped_frames == 2


@pytest.mark.parametrize("rate", [24.0, 120.0])
def test_a_clip_without_leading_frames_is_the_same_clip(rate):
    clip = make_walk(rate=rate)
    assert trim_leading(clip).clip is clip


def test_too_few_frames_are_left_alone():
    clip = prepend_rest(spread_arms_down(make_walk(4)))
    assert trim_leading(clip).clip is clip


@pytest.mark.parametrize("spike_filter", ["median", "robust"])
@pytest.mark.parametrize("last", [100, 102])
def test_spikes_are_replaced(spike_filter, last):
    clip = make_walk()
    result = repair_spikes(turn_joint(clip, LEFT_KNEE, 100, last, 80.0), spike_filter=spike_filter)
    assert angles(clip, result.clip).max() < 12.0
    assert [(c.joint, c.first, c.last) for c in result.changes] == [(LEFT_KNEE, 100, last)]


def test_spikes_leave_all_else():
    spiked = turn_joint(make_walk(), LEFT_KNEE, 100, 101, 80.0)
    changed = changed_frames(spiked, repair_spikes(spiked).clip)
    assert np.argwhere(changed).tolist() == [
        [100, spiked.joints.index(LEFT_KNEE)],
        [101, spiked.joints.index(LEFT_KNEE)],
    ]


def test_a_turn_that_lasts_is_no_spike():
    clip = turn_joint(make_walk(), LEFT_KNEE, 100, 239, 80.0)
    assert repair_spikes(clip).clip is clip


def test_a_spike_of_the_toes_stays_out_of_the_way():
    clip = turn_joint(make_walk(), LEFT_TOE, 100, 100, 120.0)
    assert repair_spikes(clip).clip is clip


@pytest.mark.parametrize("spike_filter", ["median", "robust"])
def test_spikes_of_the_root_position_are_replaced(spike_filter):
    clip = make_walk()
    translations = np.array(clip.translations)
    translations[50, 0] += [0.0, 40.0, 0.0]
    result = repair_spikes(replace(clip, translations=translations), spike_filter=spike_filter)
    assert np.abs(result.clip.translations - clip.translations).max() < 5.0
    assert [(c.joint, c.first, c.last) for c in result.changes] == [(HIPS, 50, 50)]


def test_unknown_spike_filter_is_named():
    with pytest.raises(InputError, match="unknown spike filter; expected median or robust; found 'mean'"):
        repair_spikes(make_walk(20), spike_filter="mean")


def test_missing_frames_of_a_joint_are_interpolated():
    clip = make_walk()
    j = clip.joints.index(LEFT_KNEE)
    rotations = np.array(clip.rotations)
    rotations[100:110, j] = np.nan
    rotations[150:153, j] = 0.0
    given = replace(clip, rotations=rotations)
    result = fill_gaps(given)
    assert angles(clip, result.clip).max() < 0.6
    assert [(c.joint, c.first, c.last) for c in result.changes] == [(LEFT_KNEE, 100, 109), (LEFT_KNEE, 150, 152)]
    kept = np.ones(240, dtype=bool)
    kept[100:110] = kept[150:153] = False
    assert (result.clip.rotations[kept] == clip.rotations[kept]).all()


def test_missing_positions_are_interpolated():
    clip = make_walk()
    translations = np.array(clip.translations)
    translations[100:106, 0] = np.nan
    result = fill_gaps(replace(clip, translations=translations))
    assert np.abs(result.clip.translations - clip.translations).max() < 0.1


def test_missing_frames_at_the_ends_hold_the_nearest():
    clip = make_walk()
    rotations = np.array(clip.rotations)
    rotations[:5] = np.nan
    rotations[-5:] = np.nan
    filled = fill_gaps(replace(clip, rotations=rotations)).clip
    assert np.abs(filled.rotations[:5] - clip.rotations[5]).max() < 1e-15
    assert np.abs(filled.rotations[-5:] - clip.rotations[-6]).max() < 1e-15


def test_held_frames_of_the_whole_pose_are_interpolated():
    clip = make_walk()
    rotations, translations = np.array(clip.rotations), np.array(clip.translations)
    rotations[101:107], translations[101:107] = rotations[100], translations[100]
    result = fill_gaps(replace(clip, rotations=rotations, translations=translations))
    assert [(c.joint, c.first, c.last) for c in result.changes] == [("", 101, 106)]
    assert angles(clip, result.clip).max() < 0.5


def test_a_long_hold_is_noted_and_left():
    clip = make_walk()
    rotations, translations = np.array(clip.rotations), np.array(clip.translations)
    rotations[101:180], translations[101:180] = rotations[100], translations[100]
    given = replace(clip, rotations=rotations, translations=translations)
    result = fill_gaps(given)
    assert result.clip is given
    assert [(note.first, note.last) for note in result.notes] == [(101, 179)]


def test_long_missing_data_is_filled_and_noted():
    clip = make_walk()
    rotations = np.array(clip.rotations)
    rotations[100:160, 1] = np.nan
    result = fill_gaps(replace(clip, rotations=rotations))
    assert np.isfinite(result.clip.rotations).all()
    assert [note.what for note in result.notes] == ["long without data"]


def test_standing_still_is_no_gap():
    clip = make_walk()
    still = replace(clip, rotations=np.repeat(clip.rotations[:1], 240, axis=0), translations=clip.translations)
    assert fill_gaps(still).clip is still


def test_a_joint_without_any_data_is_an_error():
    clip = make_walk(20)
    rotations = np.array(clip.rotations)
    rotations[:, 3] = np.nan
    with pytest.raises(InputError, match=f"{clip.joints[3]} has no data at any frame"):
        fill_gaps(replace(clip, rotations=rotations))


def test_noise_is_reduced_away_from_contacts_and_hits():
    clip = make_walk(480)
    noisy = add_noise(clip, 1.5)
    result = smooth_noise(noisy)
    filtered = np.zeros(480, dtype=bool)
    for change in result.changes:
        filtered[change.first : change.last + 1] = True
    assert filtered.sum() > 100
    before, after = angles(clip, noisy)[filtered].mean(), angles(clip, result.clip)[filtered].mean()
    assert after < 0.6 * before
    assert not changed_frames(noisy, result.clip)[~filtered].any()


def test_frames_around_contacts_and_hits_keep_their_bits():
    hit = turn_joint(make_walk(480), LEFT_ARM, 200, 479, 50.0, axis=(0.0, 1.0, 0.0))
    sharp = find_sharp_frames(hit)
    assert sharp[196:204].any()
    assert not changed_frames(hit, smooth_noise(hit).clip)[198:203].any()
    assert sharp.sum() < 240


def test_a_low_pass_is_zero_phase():
    clip = make_walk(480, stride_hz=0.9)
    smooth = smooth_noise(clip).clip
    leg = clip.joints.index(LEFT_LEG)
    a, b = (c.rotations[:, leg, 1] - c.rotations[:, leg, 1].mean() for c in (clip, smooth))
    lags = [float(np.dot(a[10:-10], np.roll(b, lag)[10:-10])) for lag in range(-5, 6)]
    assert int(np.argmax(lags)) == 5


def test_what_is_constant_stays_out_of_the_way():
    noisy = make_walk(480)
    smooth = smooth_noise(noisy).clip
    toe = noisy.joints.index(LEFT_TOE)
    assert (smooth.rotations[:, toe] == noisy.rotations[:, toe]).all()


def test_a_cutoff_above_the_rate_changes_nothing():
    clip = make_walk(rate=24.0)
    assert smooth_noise(clip, cutoff_hz=12.0).clip is clip


@pytest.mark.parametrize("cutoff", [0.0, -1.0, float("nan")])
def test_bad_cutoff_is_an_error(cutoff):
    with pytest.raises(InputError, match="bad cutoff of the noise filter; expected a frequency above 0"):
        smooth_noise(make_walk(20), cutoff_hz=cutoff)


@pytest.mark.parametrize("degrees", [0.5, 2.0])
def test_noise_is_measured_in_degrees(degrees):
    assert measure_noise(add_noise(make_walk(480), degrees)) == pytest.approx(degrees, rel=0.2)


def test_floor_is_reported_not_repaired():
    clip = make_walk()
    lowest = float(positions(clip)[..., 1].min())
    result = report_floor(clip, height=lowest + 4.0)
    assert result.clip is clip
    assert result.changes == ()
    assert any(note.joint.endswith("Toe") and "4.0 cm below the floor" in note.what for note in result.notes)
    assert report_floor(clip, height=lowest).notes == ()


def test_a_floor_above_the_root_is_another_floor():
    (note,) = report_floor(make_walk(), height=500.0).notes
    assert str(note) == "floor: frames 0-239: the root itself is below height 500: the floor is elsewhere"


def test_a_step_of_the_foot_itself_is_reported():
    clip = make_walk()
    translations = np.array(clip.translations)
    translations[100:, 0] += [12.0, 0.0, 0.0]
    given = replace(clip, translations=translations)
    result = report_jumps(given)
    assert result.clip is given
    assert {note.first for note in result.notes} == {100}
    assert "its place jumps by 0.12" in result.notes[0].what


def test_a_joint_that_turns_round_and_stays_is_reported():
    result = report_jumps(turn_joint(make_walk(), LEFT_KNEE, 100, 239, 150.0, axis=(0.0, 1.0, 0.0)))
    assert [(n.joint, n.first) for n in result.notes if "turns" in n.what] == [(LEFT_KNEE, 100)]
