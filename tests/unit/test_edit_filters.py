"""Frequency filters and the equalizer: responses, identities, what stays untouched, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.edit import bandpass, equalize, highpass, lowpass
from mtex_usd.edit.curve_space import make_curve_space
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.texture.pyramid import peak_frequency
from tests.oracle import edit_filters as oracle
from tests.oracle import pyramid as pyramid_oracle
from tests.synthetic import HEAD, HIPS, LEFT_ARM, LEFT_LEG, make_clip, make_skeleton, walk

RATE = 60.0
X = np.array([1.0, 0.0, 0.0])


def swing(degrees, hz, frames=601, *, mean=0.0, joint=LEFT_ARM):
    """One joint that swings about x, all else at rest."""
    skeleton = make_skeleton(oriented=3)
    turns = np.zeros((frames, len(skeleton.joints), 4))
    turns[..., 0] = 1.0
    angles = mean + degrees * np.sin(2.0 * np.pi * hz * np.arange(frames) / RATE)
    turns[:, skeleton.joints.index(joint)] = quaternion.exp(np.radians(angles)[:, None] * X)
    return make_clip(skeleton, RATE, turns, np.tile(skeleton.rest_translations[0], (frames, 1)))


def amplitude(clip, joint=LEFT_ARM):
    """Half of the way a joint turns from one side to the other, degrees, away from the ends."""
    rotations = clip.rotations[100:-100, clip.joints.index(joint)]
    return 0.5 * np.degrees(quaternion.angle_between(rotations[:, None], rotations[None]).max())


def same_bits(a, b):
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ("rotations", "translations", "scales"))


@pytest.mark.parametrize(("hz", "gain"), [(0.5, 1.0), (3.0, 0.5), (12.0, 0.0)])
def test_lowpass_halves_the_amplitude_at_its_frequency(hz, gain):
    clip = swing(50.0, hz)
    assert amplitude(lowpass(clip, frequency=3.0)) == pytest.approx(gain * amplitude(clip), abs=0.2)


@pytest.mark.parametrize(("hz", "gain"), [(0.5, 0.0), (3.0, 0.5), (12.0, 1.0)])
def test_highpass_leaves_what_lowpass_takes(hz, gain):
    clip = swing(50.0, hz)
    assert amplitude(highpass(clip, frequency=3.0)) == pytest.approx(gain * amplitude(clip), abs=0.2)


def test_bandpass_keeps_what_is_between_about_the_mean_pose():
    clip = bandpass(swing(20.0, 3.0, mean=35.0), frequencies=(1.0, 9.0))
    assert amplitude(clip) == pytest.approx(20.0, abs=0.05)
    rotations = clip.rotations[:, [clip.joints.index(LEFT_ARM)]]
    before = swing(20.0, 3.0, mean=35.0).rotations[:, [clip.joints.index(LEFT_ARM)]]
    means = quaternion.mean(rotations), quaternion.mean(before)
    assert np.degrees(quaternion.angle_between(*means)).max() < 0.05


@pytest.mark.parametrize("order", [1, 4, 8])
@pytest.mark.parametrize("frequency", [0.3, 2.0, 11.0])
def test_lowpass_is_the_slow_twin_s(order, frequency):
    clip = walk(120, seed=5)
    filtered = lowpass(clip, frequency=frequency, order=order)
    for axis in range(3):
        curve = clip.translations[:, 0, axis]
        expected = oracle.lowpass(curve, frequency, clip.rate, order)
        np.testing.assert_allclose(filtered.translations[:, 0, axis], expected, atol=2e-7)
    joint = clip.joints.index(LEFT_ARM)
    rolled = oracle.rolled_out(clip.rotations[:, joint])
    smooth = np.stack([oracle.lowpass(column, frequency, clip.rate, order) for column in rolled.T], axis=1)
    expected = oracle.turned_by(clip.rotations[:, joint], smooth - rolled)
    assert np.degrees(quaternion.angle_between(expected, filtered.rotations[:, joint])).max() < 1e-5


def test_equalize_is_the_slow_twin_s():
    clip = walk(80, seed=2)
    filtered = equalize(clip, gains=[-np.inf, 6.0, -3.0], channels=["LeftArm", "Hips.ty"])
    factors = [0.0, 10.0**0.3, 10.0**-0.15]
    joint = clip.joints.index(LEFT_ARM)
    change = np.zeros((80, 3))
    for axis, column in enumerate(oracle.rolled_out(clip.rotations[:, joint]).T):
        bands, _ = pyramid_oracle.decompose(column)
        change[:, axis] = sum((f - 1.0) * np.array(band) for f, band in zip(factors, bands, strict=False))
    expected = oracle.turned_by(clip.rotations[:, joint], change)
    assert np.degrees(quaternion.angle_between(expected, filtered.rotations[:, joint])).max() < 1e-5
    bands, _ = pyramid_oracle.decompose(clip.translations[:, 0, 1])
    moved = sum((f - 1.0) * np.array(band) for f, band in zip(factors, bands, strict=False))
    np.testing.assert_allclose(filtered.translations[:, 0, 1] - clip.translations[:, 0, 1], moved, atol=1e-9)


def test_equalize_mutes_the_band_of_a_swing():
    clip = swing(30.0, peak_frequency(4, RATE))
    muted = equalize(clip, gains=[0.0, 0.0, -np.inf, -np.inf, -np.inf])
    doubled = equalize(clip, gains=[20.0 * np.log10(2.0)] * 5)
    assert amplitude(muted) < 0.15 * 30.0
    assert amplitude(doubled) == pytest.approx(60.0, rel=0.02)


def test_the_residual_s_gain_scales_the_pose_about_its_mean():
    frames = 200
    clip = swing(0.0, 1.0, frames)
    joint = clip.joints.index(LEFT_ARM)
    slow = 30.0 * np.linspace(-1.0, 1.0, frames)
    rotations = np.array(clip.rotations)
    rotations[:, joint] = quaternion.multiply(rotations[:, joint], quaternion.exp(np.radians(slow)[:, None] * X))
    halved = equalize(replace(clip, rotations=rotations), gains=[], residual_gain=20.0 * np.log10(0.5))
    turned = np.degrees(quaternion.angle_between(halved.rotations[0, joint], halved.rotations[-1, joint]))
    assert turned == pytest.approx(30.0, abs=1e-6)


@pytest.mark.parametrize("frames", [2, 3, 5, 40])
def test_identities_keep_every_bit(frames):
    clip = walk(frames, seed=1)
    for same in (
        lowpass(clip, frequency=0.5 * clip.rate),
        lowpass(clip, frequency=np.inf),
        highpass(clip, frequency=0.0),
        bandpass(clip, frequencies=(0.0, 99.0)),
        equalize(clip, gains=[]),
        equalize(clip, gains=[0.0] * 9, residual_gain=0.0),
    ):
        assert same_bits(same, clip)


def test_two_frames_are_a_line_and_pass():
    assert same_bits(lowpass(walk(2), frequency=1.0), walk(2))


def test_only_the_channels_asked_for_change_and_what_is_still_keeps_its_bits():
    clip = walk(60, seed=4)
    filtered = lowpass(clip, frequency=2.0, channels=["LeftArm", "LeftUpLeg.rx", "Hips.tz"])
    changed = (clip.rotations != filtered.rotations).any(axis=(0, 2))
    assert {clip.joints[j] for j in np.flatnonzero(changed)} == {LEFT_ARM, LEFT_LEG}
    moved = (clip.translations != filtered.translations).any(axis=(0, 2))
    assert {clip.joints[j] for j in np.flatnonzero(moved)} == {HIPS}
    held = swing(20.0, 1.0)
    changed = (held.rotations != lowpass(held, frequency=1.0).rotations).any(axis=(0, 2))
    assert {held.joints[j] for j in np.flatnonzero(changed)} == {LEFT_ARM}


def test_the_first_and_the_last_frame_stay():
    clip = walk(50, seed=8)
    filtered = lowpass(clip, frequency=1.0)
    for frame in (0, -1):
        assert np.degrees(quaternion.angle_between(clip.rotations[frame], filtered.rotations[frame])).max() < 1e-9
        np.testing.assert_allclose(clip.translations[frame], filtered.translations[frame], atol=1e-9)


def test_a_single_angle_is_filtered_as_texturing_reads_it():
    clip = swing(40.0, 6.0)
    filtered = lowpass(clip, frequency=1.0, channels=["LeftArm.rx"])
    assert amplitude(filtered) < 0.1
    other = lowpass(clip, frequency=1.0, channels=["LeftArm.ry"])
    assert np.degrees(quaternion.angle_between(clip.rotations, other.rotations)).max() < 1e-9


def test_many_turns_are_filtered_as_turns():
    frames = 301
    skeleton = make_skeleton()
    turns = np.zeros((frames, len(skeleton.joints), 4))
    turns[..., 0] = 1.0
    angles = np.linspace(0.0, 1500.0, frames) + 5.0 * np.sin(2.0 * np.pi * 10.0 * np.arange(frames) / RATE)
    turns[:, 0] = quaternion.exp(np.radians(angles)[:, None] * np.array([0.0, 1.0, 0.0]))
    clip = make_clip(skeleton, RATE, turns, np.tile(skeleton.rest_translations[0], (frames, 1)))
    steady = make_curve_space(lowpass(clip, frequency=2.0, channels=["Hips"]), ["Hips"]).curves[:, 1]
    np.testing.assert_allclose(steady, np.linspace(0.0, 1500.0, frames), atol=0.6)


@pytest.mark.parametrize("frequency", [0.0, -1.0, np.nan])
def test_bad_frequencies_are_refused(frequency):
    with pytest.raises(InputError, match="bad frequency of the filter; expected above 0 Hz"):
        lowpass(walk(10), frequency=frequency)


def test_bands_that_hold_nothing_are_refused():
    with pytest.raises(InputError, match="expected above 3 Hz; found 2 Hz"):
        bandpass(walk(10), frequencies=(3.0, 2.0))
    with pytest.raises(InputError, match="expected 0 Hz or more"):
        highpass(walk(10), frequency=-1.0)
    with pytest.raises(InputError, match="a lower one below half the frame rate, 12 Hz; found 20 Hz"):
        highpass(walk(10), frequency=20.0)


@pytest.mark.parametrize("order", [0, 17])
def test_bad_orders_are_refused(order):
    with pytest.raises(InputError, match="bad order of the filter; expected 1 to 16"):
        lowpass(walk(10), frequency=1.0, order=order)


@pytest.mark.parametrize("gain", [np.inf, np.nan])
def test_bad_gains_are_refused(gain):
    with pytest.raises(InputError, match="bad gain; expected decibels"):
        equalize(walk(10), gains=[0.0, gain])
    with pytest.raises(InputError, match="bad gain"):
        equalize(walk(10), gains=[], residual_gain=gain)


def test_bad_channels_are_refused():
    with pytest.raises(InputError, match="no joint fits 'Tail'"):
        lowpass(walk(10), frequency=1.0, channels=["Tail"])
    with pytest.raises(InputError, match="a list of channel tokens; found 'Head'"):
        lowpass(walk(10), frequency=1.0, channels="Head")
    assert HEAD in walk(10).joints
