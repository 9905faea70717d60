"""Transitions, loops and blends on the CMU captures."""

import numpy as np
import pytest

from mtex_usd.edit import align, blend, find_transition, join, scale_time, warp_time
from mtex_usd.edit.pose_features import common_joints, pose_positions
from mtex_usd.motion import quaternion
from mtex_usd.motion.timing import resample_clip
from tests.captures import load_capture
from tests.oracle import edit_align as oracle


def fastest(*clips):
    """How far each joint turns from frame to frame at most, [J]."""
    return np.max([quaternion.angle_between(c.rotations[1:], c.rotations[:-1]).max(axis=0) for c in clips], axis=0)


@pytest.mark.parametrize("rate", [120.0, 24.0])
@pytest.mark.parametrize("method", ["auto", "blend", "interpolate"])
def test_from_a_straight_walk_to_a_sad_one_nothing_turns_too_fast(data_dir, rate, method):
    clip, other = (resample_clip(load_capture(data_dir, name), rate) for name in ("91_02", "91_13"))
    result = join(clip, other, method=method)
    assert result.method == ("interpolate" if method == "interpolate" else "blend")
    assert (fastest(result.clip) <= 1.2 * fastest(clip, other) + 1e-9).all()
    assert not result.notes


def pace(clip):
    """How far the root moves over the floor from frame to frame, [F - 1]."""
    return np.linalg.norm(np.diff(clip.translations[:, 0, [0, 2]], axis=0), axis=1)


def longest_walk(clip):
    """First and last frame of the longest run at more than a quarter of the fastest pace."""
    edges = np.flatnonzero(
        np.diff(np.concatenate([[False], pace(clip) > 0.25 * pace(clip).max(), [False]]).astype(int))
    )
    first, end = max(edges.reshape(-1, 2).tolist(), key=lambda run: run[1] - run[0])
    return first, end - 1


def test_in_mid_walk_too(data_dir):
    """Out of one into the other while both walk, at a pace that both have."""
    clip, other = load_capture(data_dir, "91_02"), load_capture(data_dir, "91_13")
    ranges = longest_walk(clip), longest_walk(other)
    assert all(last - first > 120 for first, last in ranges)
    found = find_transition(clip, other, frames=ranges[0], other_frames=ranges[1])
    result = join(clip, other, transition=found, method="blend")
    assert (fastest(result.clip) <= 1.2 * fastest(clip, other) + 1e-9).all()
    steps = pace(result.clip)[result.first : result.last]
    paces = [pace(each)[first:last] for each, (first, last) in zip((clip, other), ranges, strict=True)]
    assert min(each.min() for each in paces) <= steps.min()
    assert steps.max() <= max(each.max() for each in paces)


@pytest.mark.parametrize("names", [("07_01", "01_01"), ("07_01", "09_01"), ("05_02", "07_01")])
def test_between_strangers_nothing_turns_too_fast(data_dir, names):
    clip, other = (resample_clip(load_capture(data_dir, name), 30.0) for name in names)
    result = join(clip, other)
    assert (fastest(result.clip) <= 1.2 * fastest(clip, other) + 1e-9).all()


@pytest.mark.parametrize("name", ["07_01", "09_01", "91_13"])
def test_a_closed_loop_goes_on_for_ever(data_dir, name):
    clip = resample_clip(load_capture(data_dir, name), 60.0)
    cycle = join(clip, clip).clip
    long = scale_time(cycle, factor=1.0, frame_count=5 * cycle.frame_count, ends="loop")
    assert (fastest(long) <= 1.2 * fastest(clip) + 1e-9).all()
    assert np.ptp(long.translations[:, 0, 1]) == pytest.approx(np.ptp(cycle.translations[:, 0, 1]), abs=1e-6)


def test_transition_equals_the_slow_twin(data_dir):
    clip, other = (resample_clip(load_capture(data_dir, name), 12.0) for name in ("07_01", "07_05"))
    found = find_transition(clip, other)
    joints = common_joints(clip, other)
    positions = pose_positions(clip, joints.of_clip), pose_positions(other, joints.of_other)
    expected = oracle.best_transition(*positions, rate=12.0, half=2)
    assert (found.frame, found.other_frame) == expected[1:]
    assert found.distance == pytest.approx(expected[0], abs=1e-6)


def test_sadder_than_sad(data_dir):
    """Exaggerated by half: the sad walk's head hangs, and hangs more beyond it."""
    clip, sad = (resample_clip(load_capture(data_dir, name), 30.0) for name in ("91_02", "91_13"))
    sad = warp_time(sad, pairs=align(sad, clip).pairs, frame_count=clip.frame_count)
    names = [joint.rpartition("/")[2].lower() for joint in clip.joints]
    head = names.index("head")

    def bow(motion):
        """How far the head's up leans to the front, degrees, in the mean."""
        up = quaternion.rotate(motion.skeleton.world_rotations(motion.rotations)[:, head], np.array([0.0, 1.0, 0.0]))
        return np.degrees(np.arccos(np.clip(up[:, 1], -1.0, 1.0))).mean()

    bows = [bow(blend(clip, sad, weights=weight, place="first").clip) for weight in (0.0, 0.5, 1.0, 1.5)]
    assert (np.diff(bows) > 0.0).all() or (np.diff(bows) < 0.0).all()
