"""Contacts on the CMU captures, against steps counted by eye and against the slow twin.

The steps were counted on plots of the heights and speeds of ankles and toes, less the frame of the added T-pose: a step
is a time a foot stands between two swings or at an end of the clip.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from mtex_usd import read_clip
from mtex_usd.constraints.contacts import detect_contacts, estimate_ground, find_effectors
from mtex_usd.motion.timing import resample_clip
from tests.captures import UNIT_M, load_capture
from tests.oracle import contacts as oracle

FEET = ("left.heel", "left.toes", "right.heel", "right.toes")


@cache
def detect(data_dir, name):
    return detect_contacts(load_capture(data_dir, name))


def by_effector(contacts):
    return {name: [(c.first, c.last) for c in contacts if c.effector.name == name] for name in FEET}


@pytest.mark.parametrize(("name", "left", "right"), [("07_01", 2, 3), ("07_05", 3, 3), ("91_01", 19, 19)])
def test_plain_walks_give_one_contact_of_the_toes_per_step(data_dir, name, left, right):
    found = by_effector(detect(data_dir, name))
    assert (len(found["left.toes"]), len(found["right.toes"])) == (left, right)


def test_plain_steps_have_one_heel_and_one_toe_contact_of_plausible_length(data_dir):
    """The heel comes down first and leaves first, and each stands for 0.35 to 0.65 s in the walk's own rhythm."""
    found = by_effector(detect(data_dir, "07_01"))
    for side in ("left", "right"):
        assert len(found[f"{side}.heel"]) == len(found[f"{side}.toes"])
        for heel, toes in zip(found[f"{side}.heel"], found[f"{side}.toes"], strict=True):
            assert heel[0] <= toes[0]
            assert heel[1] < toes[1]
            inner = heel[0] > 0 and toes[1] < 315
            assert not inner or 0.35 <= (toes[1] - heel[0] + 1) / 120.0 <= 0.75


@pytest.mark.parametrize("name", ["07_01", "91_01", "91_13"])
def test_nothing_is_planted_in_swing(data_dir, name):
    """No planted point moves faster than 0.6 m/s, measured by plain differences over a twentieth of a second."""
    clip = load_capture(data_dir, name)
    tracks = {effector.name: _track(clip, effector) for effector in find_effectors(clip.skeleton, clip=clip)}
    for contact in detect(data_dir, name):
        track = tracks[contact.effector.name][contact.first : contact.last + 1] * UNIT_M
        assert (np.linalg.norm(track[6:] - track[:-6], axis=1) * 20.0).max(initial=0.0) < 0.6


@pytest.mark.parametrize("name", ["07_01", "91_01"])
def test_walks_always_have_a_foot_on_the_floor(data_dir, name):
    clip = load_capture(data_dir, name)
    assert _planted(clip, detect(data_dir, name)).any(axis=1).all()


@pytest.mark.parametrize(("name", "flights"), [("09_01", 3), ("09_05", 3)])
def test_runs_have_flight(data_dir, name, flights):
    clip = load_capture(data_dir, name)
    planted = _planted(clip, detect(data_dir, name)).any(axis=1)
    assert np.count_nonzero(np.diff(planted.astype(int)) == -1) == flights
    assert 0.3 < 1.0 - planted.mean() < 0.8


def test_jumps_leave_the_floor_with_both_feet(data_dir):
    """01_01 jumps and lands at frames 215 to 280 and again and again: both feet off for a quarter of a second."""
    clip = load_capture(data_dir, "01_01")
    planted = _planted(clip, detect(data_dir, "01_01")).any(axis=1)
    assert not planted[225:270].any()
    assert planted[100:210].all()


@pytest.mark.parametrize("name", ["07_01", "07_05", "91_01", "09_01", "01_01"])
def test_frame_rate_moves_no_border_by_more_than_a_24th(data_dir, name):
    clip = load_capture(data_dir, name)
    fast, slow = (by_effector(detect_contacts(c)) for c in (clip, resample_clip(clip, 24.0)))
    for effector in FEET:
        a, b = np.array(fast[effector]), 5 * np.array(slow[effector])
        assert a.shape == b.shape
        assert np.abs(a - b).max(initial=0) <= 5


@pytest.mark.parametrize("name", ["07_01", "07_05", "09_01", "01_01"])
def test_five_millimetres_of_noise_change_little(data_dir, name):
    clip = load_capture(data_dir, name)
    noise = np.random.default_rng(1).normal(0.0, 0.005 / UNIT_M, (clip.frame_count, 3))
    translations = np.array(clip.translations)
    translations[:, 0] += noise
    clean, noisy = (by_effector(detect_contacts(c)) for c in (clip, replace(clip, translations=translations)))
    for effector in FEET:
        a, b = np.array(clean[effector]), np.array(noisy[effector])
        assert a.shape == b.shape
        assert np.abs(a - b).max(initial=0) <= 5


@pytest.mark.parametrize(("name", "rate"), [("07_01", 120.0), ("91_02", 24.0), ("09_01", 24.0), ("05_02", 120.0)])
def test_equals_the_slow_twin(data_dir, name, rate):
    clip = resample_clip(load_capture(data_dir, name), rate)
    effectors = find_effectors(clip.skeleton, clip=clip)
    found = detect_contacts(clip, effectors=effectors)
    tracks = [_track(clip, effector) for effector in effectors]
    expected = oracle.detect(tracks, clip.rate, clip.skeleton.up, scale=_leg(clip) / 0.95)
    for effector, contacts in zip(effectors, expected, strict=True):
        own = [c for c in found if c.effector is effector]
        assert [(c.first, c.last) for c in own] == [(first, last) for first, last, _ in contacts]
        for contact, (_, _, point) in zip(own, contacts, strict=True):
            np.testing.assert_allclose(contact.point, point, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "low", "high"), [("07_01", 0.01, 0.035), ("91_01", 0.03, 0.05), ("01_01", 0.05, 0.08)]
)
def test_ground_is_where_the_feet_stand(data_dir, name, low, high):
    """As read off the plots, in metres above the capture's own floor."""
    clip = load_capture(data_dir, name)
    assert low < estimate_ground(clip, find_effectors(clip.skeleton, clip=clip)) * UNIT_M < high


def test_heels_are_level_with_the_toes_where_the_rest_pose_says_nothing(data_dir):
    """The rest pose of HIK_Export is not upright: only the motion shows how its feet stand."""
    clip = read_clip(data_dir / "usd" / "HIK_Export.usda", "/Fight_Dummy_Fight/Fight_Hips/Animation")
    contacts = detect_contacts(clip)
    heights = {name: [c.point @ clip.skeleton.up for c in contacts if c.effector.name == name] for name in FEET}
    for side in ("left", "right"):
        assert len(heights[f"{side}.toes"]) >= 4
        assert abs(np.median(heights[f"{side}.heel"]) - np.median(heights[f"{side}.toes"])) < 2.0


def _track(clip, effector):
    return oracle.track_point(clip.parents, clip.rotations, clip.translations, effector.joint, effector.offset)


def _planted(clip, contacts):
    """Whether each foot stands, [F, 2]."""
    planted = np.zeros((clip.frame_count, 2), dtype=bool)
    for contact in contacts:
        planted[contact.first : contact.last + 1, int(contact.effector.name.startswith("right"))] = True
    return planted


def _leg(clip):
    """Length of a leg from the pelvis to the ankle along the rest pose, mean of both."""
    names = [joint.rpartition("/")[2].lower() for joint in clip.joints]
    feet = [names.index(foot) for foot in ("leftfoot", "rightfoot") if foot in names] or [
        names.index(foot) for foot in ("lfoot", "rfoot")
    ]
    lengths = []
    for joint in feet:
        length = 0.0
        while clip.parents[joint] >= 0:
            length += float(np.linalg.norm(clip.skeleton.rest_translations[joint]))
            joint = clip.parents[joint]  # noqa: PLW2901
        lengths.append(length)
    return sum(lengths) / 2.0
