"""The spacetime solve on captured walks that were disturbed: planted feet are exact and what was good is kept."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from mtex_usd.constraints.contacts import detect_contacts
from mtex_usd.constraints.spacetime import (
    PlaneAbove,
    PlaneOn,
    Point,
    PointStill,
    measure_energy_above,
    solve_spacetime,
)
from mtex_usd.motion import quaternion
from mtex_usd.motion.timing import resample_clip
from tests.captures import UNIT_M, load_capture
from tests.spacetime_support import follow

FRAMES = 180


@cache
def load(data_dir, name):
    """The first seconds of a capture at 24/s, less the frame of the T-pose."""
    return resample_clip(load_capture(data_dir, name, frames=5 * FRAMES), 24.0)


def disturb(clip):
    """Move and turn the root by smooth curves of 5 cm and 5 degrees."""
    rng = np.random.default_rng(0)
    time = np.arange(clip.frame_count)[:, None] / clip.rate
    turns, moves = (_smooth(rng, time) for _ in range(2))
    rotations, translations = np.array(clip.rotations), np.array(clip.translations)
    rotations[:, 0] = quaternion.multiply(rotations[:, 0], quaternion.exp(np.radians(5.0) * turns))
    translations[:, 0] += 0.05 / UNIT_M * moves
    return replace(clip, rotations=rotations, translations=translations)


def _smooth(rng, time):
    waves = [rng.standard_normal(3) * np.sin(2.0 * np.pi * (hz * time + rng.uniform(size=3))) for hz in (0.2, 0.5, 1.1)]
    return sum(waves) / np.abs(sum(waves)).max()


@cache
def solve(data_dir, name):
    """The capture, what was made of it, and the solution, with the steps as (point, frames, height)."""
    capture = load(data_dir, name)
    disturbed = disturb(capture)
    steps = []
    for contact in detect_contacts(capture):
        point = Point(capture.joints[contact.effector.joint], tuple(contact.effector.offset))
        frames = np.arange(contact.first, contact.last + 1)
        steps.append((point, frames))
    heights = {
        point: np.mean([follow(capture, p)[frames, 1].mean() for p, frames in steps if p == point])
        for point, _ in steps
    }
    constraints = [PointStill(f"still {n}", point, frames) for n, (point, frames) in enumerate(steps)]
    constraints += [PlaneOn(f"on {n}", point, frames, heights[point]) for n, (point, frames) in enumerate(steps)]
    every = np.arange(capture.frame_count)
    constraints += [PlaneAbove(f"floor {n}", point, every, heights[point]) for n, point in enumerate(heights)]
    return capture, disturbed, solve_spacetime(disturbed, constraints), steps, heights


def slides_mm(clip, steps):
    points = [follow(clip, point)[frames] for point, frames in steps]
    return np.array([1e3 * UNIT_M * np.linalg.norm(p - p.mean(axis=0), axis=1).max() for p in points])


@pytest.mark.parametrize("name", ["07_01", "91_01"])
def test_planted_feet_are_exact(data_dir, name):
    _, disturbed, solution, steps, heights = solve(data_dir, name)
    assert len(steps) >= 8
    assert slides_mm(disturbed, steps).mean() > 20.0
    assert slides_mm(solution.clips[0], steps).max() < 0.5
    for point, frames in steps:
        height = follow(solution.clips[0], point)[:, 1] - heights[point]
        assert np.abs(height[frames]).max() * UNIT_M < 5e-4
        assert height.min() * UNIT_M > -5e-4


@pytest.mark.parametrize("name", ["07_01", "91_01"])
def test_the_change_is_slow_and_the_upper_body_keeps_its_bits(data_dir, name):
    _, disturbed, solution, _, _ = solve(data_dir, name)
    (result,), (change,) = solution.clips, solution.displacements
    assert measure_energy_above(change, result.rate, 6.0) < 0.01
    still = ~change.rotations.any(axis=(0, 2))
    assert still.sum() > 15
    np.testing.assert_array_equal(result.rotations[:, still], disturbed.rotations[:, still])
    angles = np.degrees(quaternion.angle_between(result.rotations, disturbed.rotations))
    assert np.sqrt(np.square(angles).mean()) < 3.0


@pytest.mark.parametrize("name", ["07_01", "91_01"])
def test_no_joint_jerks(data_dir, name):
    """No joint that the performer moved is accelerated much more than by the performer."""
    capture, _, solution, _, _ = solve(data_dir, name)
    before, after = (fastest_change(clip) for clip in (capture, solution.clips[0]))
    moving = solution.displacements[0].rotations.any(axis=(0, 2)) & (before > 500.0)
    assert moving.sum() >= 6
    assert (after[moving] < 1.5 * before[moving]).all()


def fastest_change(clip):
    """Largest acceleration of each joint, degrees per second squared."""
    turns = quaternion.log(quaternion.multiply(quaternion.conjugate(clip.rotations[:-1]), clip.rotations[1:]))
    return np.degrees(np.linalg.norm(np.diff(turns, axis=0), axis=2)).max(axis=0) * clip.rate**2
