"""Time edits on the CMU captures: slowed and sped up, warped and found again, Gleicher's marching example."""

from itertools import pairwise

import numpy as np
import pytest

from mtex_usd.constraints.contacts import detect_contacts, find_effectors
from mtex_usd.constraints.kinematics import place_points
from mtex_usd.edit import TimeWarp, align, blend, join, scale_time, shift_time, warp_time
from mtex_usd.motion import quaternion
from mtex_usd.motion.timing import resample_clip
from tests.captures import UNIT_M, load_capture

CURVES = {
    "late start": [(0.0, 0.0), (0.3, 0.45), (0.7, 0.65), (1.0, 1.2)],
    "hesitation": [(0.0, 0.0), (0.2, 0.3), (0.5, 0.6), (1.0, 1.0)],
    "hurry": [(0.0, 0.0), (0.5, 0.35), (1.0, 0.9)],
}


@pytest.mark.parametrize("rate", [120.0, 24.0])
@pytest.mark.parametrize("curve", CURVES)
def test_alignment_finds_a_known_warp_within_a_frame(data_dir, rate, curve):
    clip = resample_clip(load_capture(data_dir, "07_01"), rate)
    warp = TimeWarp(np.array(CURVES[curve]) * (clip.frame_count - 1))
    warped = warp_time(clip, pairs=warp.pairs)
    frames = np.arange(warped.frame_count, dtype=float)
    expected = warp.source_times(frames)[0]
    for found in (align(warped, clip).inverse, align(clip, warped)):
        error = TimeWarp(found.pairs).source_times(frames)[0] - expected
        assert np.abs(error).max() < 1.0


@pytest.mark.parametrize("rate", [120.0, 24.0])
def test_there_and_back_is_the_same_motion(data_dir, rate):
    """Slowed and sped up again; warped and back. What is lost is above the highest frequency both can carry."""
    clip = resample_clip(load_capture(data_dir, "07_01"), rate)
    slow = scale_time(scale_time(clip, factor=2.0), factor=0.5)
    warp = TimeWarp(np.array(CURVES["hesitation"]) * (clip.frame_count - 1))
    warped = warp_time(warp_time(clip, pairs=warp.pairs), pairs=warp.inverse.pairs)
    for back in (slow, warped):
        assert back.frame_count == clip.frame_count
        off = np.degrees(quaternion.angle_between(back.rotations, clip.rotations))
        assert np.sqrt(np.mean(np.square(off))) < 0.5
        assert np.abs(back.translations - clip.translations)[:, 0].max() * UNIT_M < 0.01


def test_distances_stay_when_time_is_warped(data_dir):
    clip = load_capture(data_dir, "07_01")
    warped = warp_time(clip, pairs=np.array(CURVES["late start"]) * (clip.frame_count - 1))
    lengths = [np.linalg.norm(np.diff(each.translations[:, 0], axis=0), axis=1).sum() for each in (clip, warped)]
    assert lengths[1] == pytest.approx(lengths[0], rel=1e-3)


def test_a_loop_of_a_walk_goes_on_at_its_pace(data_dir):
    clip = load_capture(data_dir, "07_01")
    late = shift_time(join(clip, clip).clip, shift_s=1.0, ends="loop")
    steps = [np.linalg.norm(np.diff(each.translations[:, 0, [0, 2]], axis=0), axis=1) for each in (clip, late)]
    assert steps[1].min() > 0.95 * steps[0].min()
    assert steps[1].max() < 1.05 * steps[0].max()


def footfalls(clip, effectors):
    """Frames where a heel comes down, less what began before the first frame, with the side."""
    contacts = detect_contacts(clip, effectors=effectors)
    return sorted((c.first, c.effector.name) for c in contacts if c.first > 0 and c.effector.name.endswith("heel"))


def heights(clip, effectors):
    """Of the points of the feet, metres, [F, 4]."""
    joints, offsets = [e.joint for e in effectors], np.array([e.offset for e in effectors])
    return place_points(clip.skeleton, joints, offsets, clip.rotations, clip.translations) @ clip.skeleton.up * UNIT_M


@pytest.mark.parametrize("rate", [120.0, 24.0])
def test_marching_in_step(data_dir, rate):
    """Gleicher 2000, figures 15 and 17: one walk's footfalls moved onto another's, then both blended half and half."""
    clip, other = (resample_clip(load_capture(data_dir, name), rate) for name in ("07_01", "07_02"))
    effectors = find_effectors(clip.skeleton, clip=clip)
    falls, wanted = footfalls(clip, effectors), footfalls(other, effectors)
    wanted = wanted[next(k for k, fall in enumerate(wanted) if fall[1] == falls[0][1]) :]
    pairs = [(a[0], b[0]) for a, b in zip(falls, wanted, strict=False)]
    assert len(pairs) >= 4
    marching = warp_time(clip, pairs=pairs, frame_count=other.frame_count, ends="extrapolate")
    moved = [fall for fall in footfalls(marching, effectors) if fall[0] >= pairs[0][1] - 1]
    assert [side for _, side in moved] == [side for _, side in wanted[: len(moved)]]
    assert max(abs(a[0] - b[0]) for a, b in zip(moved, wanted, strict=False)) <= 1

    mixed = blend(other, marching, weights=0.5)
    assert not mixed.notes
    feet = [heights(each, effectors) for each in (other, marching, mixed.clip)]
    for (first, _), (end, _) in pairwise(wanted[: len(pairs)]):
        lowest = [each[first:end].reshape(-1, 2, 2).min(axis=(0, 2)) for each in feet]
        between = np.minimum(lowest[0], lowest[1]), np.maximum(lowest[0], lowest[1])
        assert (lowest[2] < between[1] + 0.02).all()
        assert (lowest[2] > between[0] - 0.02).all()


def test_out_of_step_the_feet_hover_and_it_is_noted(data_dir):
    """The same blend without the warp: Gleicher's warning example."""
    clip = load_capture(data_dir, "07_01")
    late = shift_time(clip, shift_s=0.5)
    assert blend(clip, late, weights=0.5).notes
