"""What edits do to contacts, as their docstrings say, measured on the sample walks: their feet stand within 1.1 cm."""

from dataclasses import replace

import numpy as np
import pytest

import mtex_usd
from mtex_usd import constraints, edit
from mtex_usd.motion import quaternion
from tests.conftest import PROJECT


def read_take(name, *, seconds=10.0):
    clip = mtex_usd.read_clip(PROJECT / "sample_stages" / "takes.usda", f"/Takes/{name}")
    part = slice(0, round(seconds * clip.rate))
    return replace(clip, rotations=clip.rotations[part], translations=clip.translations[part], scales=clip.scales[part])


def track(clip, effector):
    positions, world = clip.skeleton.world_pose(clip.rotations, clip.translations)
    offset = np.broadcast_to(effector.offset, (clip.frame_count, 3))
    return positions[:, effector.joint] + quaternion.rotate(world[:, effector.joint], offset)


def measure_slides(clip, contacts):
    """Farthest from the middle of each stance over the floor, centimetres."""
    slides = []
    for contact in contacts:
        level = track(clip, contact.effector)[contact.first : contact.last + 1, [0, 2]]
        slides.append(np.linalg.norm(level - level.mean(axis=0), axis=1).max())
    return np.array(slides)


@pytest.fixture(scope="module")
def walk():
    return read_take("walk_natural")


@pytest.fixture(scope="module")
def contacts(walk):
    return constraints.detect_contacts(walk)


UPPER = ["Spine*", "*Arm*", "Head"]


@pytest.mark.parametrize(
    ("change", "least", "most"),
    [
        (lambda clip: clip, 0.0, 1.1),
        (lambda clip: edit.lowpass(clip, frequency=2.0), 3.0, 4.0),
        (lambda clip: edit.lowpass(clip, frequency=4.0), 0.0, 1.1),
        (lambda clip: edit.lowpass(clip, frequency=2.0, channels=UPPER), 0.0, 1.1),
        (lambda clip: edit.highpass(clip, frequency=0.5), 35.0, 45.0),
        (lambda clip: edit.equalize(clip, gains=[0.0, 6.0]), 2.0, 3.1),
        (lambda clip: edit.equalize(clip, gains=[0.0, 0.0, 0.0, 6.0]), 15.0, 21.0),
        (lambda clip: edit.median(clip, window_s=0.15), 3.0, 6.1),
        (lambda clip: edit.robust_mean(clip, window_s=0.25), 3.0, 9.0),
        (lambda clip: edit.waveshape(clip, points=[(-9, -18), (9, 18)], channels=["*Arm.ry"]), 0.0, 1.1),
        (lambda clip: edit.reduce_keys(clip, tolerance_deg=0.5, tolerance_m=0.005).evaluate(), 0.0, 1.1),
    ],
)
def test_planted_feet_slide_as_documented(walk, contacts, change, least, most):
    assert len(contacts) > 30
    assert least <= measure_slides(change(walk), contacts).max() <= most


@pytest.mark.parametrize("factor", [1.0 / 3.0, 0.5, 1.5, 2.0])
def test_feet_stand_as_still_at_any_speed(walk, contacts, factor):
    scaled = edit.scale_time(walk, factor=factor)
    times = [(np.ceil(contact.first * factor), np.floor(contact.last * factor)) for contact in contacts]
    moved = [replace(c, first=int(a), last=int(b)) for c, (a, b) in zip(contacts, times, strict=True) if b > a + 1]
    assert len(moved) > 30
    assert measure_slides(scaled, moved).max() <= 1.3


@pytest.mark.parametrize(("weight", "most"), [(0.5, 0.8), (1.5, 1.4)])
def test_blended_in_step_feet_stand_where_both_stand(weight, most):
    slow, brisk = read_take("walk_slow", seconds=5.5), read_take("walk_brisk", seconds=3.9)
    brisk = edit.warp_time(brisk, pairs=edit.align(brisk, slow).pairs, frame_count=slow.frame_count)
    both = []
    for one in constraints.detect_contacts(slow):
        for other in constraints.detect_contacts(brisk):
            first, last = max(one.first, other.first), min(one.last, other.last)
            if one.effector.name == other.effector.name and last - first >= 3:
                both.append(replace(one, first=first, last=last))
    assert len(both) > 10
    assert measure_slides(edit.blend(slow, brisk, weights=weight).clip, both).max() <= most


def test_a_blended_transition_keeps_feet_still():
    walk, brisk = read_take("walk_natural", seconds=5.0), read_take("walk_brisk", seconds=5.0)
    at = edit.find_transition(walk, brisk, frames=(60, 110), other_frames=(10, 60))
    joined = edit.join(walk, brisk, transition=at)
    over = [c for c in constraints.detect_contacts(joined.clip) if c.last >= joined.first and c.first <= joined.last]
    assert len(over) >= 3
    assert measure_slides(joined.clip, over).max() <= 1.4
