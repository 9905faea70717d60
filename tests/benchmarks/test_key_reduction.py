"""The benchmark of key reduction compares like with like; for numbers ``python -m tests.benchmarks.key_reduction``."""

import os

import numpy as np
import pytest

from tests.benchmarks.key_reduction import compare_curves, compare_poses, pair_up, run_blender, time_ours
from tests.synthetic import walk


@pytest.fixture
def interpreter() -> str:
    found = os.environ.get("MTEX_BLENDER_PYTHON", "")
    if not found:
        pytest.skip("MTEX_BLENDER_PYTHON is not set; it names a Python that has bpy")
    return found


def test_two_figures_are_the_clip_twice() -> None:
    clip = walk(50, seed=1)
    pair = pair_up(clip, frames=30, later=15)
    count = len(clip.joints)
    assert pair.rotations.shape == (30, 2 * count, 4)
    np.testing.assert_array_equal(pair.rotations[:, count:], clip.rotations[15:45])
    np.testing.assert_array_equal(pair.parents[count:][clip.parents >= 0], clip.parents[clip.parents >= 0] + count)


def test_ours_is_within_the_error_it_is_compared_at() -> None:
    found = time_ours(walk(60, seed=2), degrees=1.0, metres=0.01, runs=1)
    assert found.degrees <= 1.0
    assert found.metres <= 0.01
    assert found.seconds > 0.0


def test_poses_are_printed_beside_what_is_needed(capsys) -> None:
    clip = walk(40, seed=2)
    compare_poses(clip, {"all joints": ()})
    assert "any method at least" in capsys.readouterr().out


def test_blender_is_measured_as_ours_is(interpreter: str, capsys) -> None:
    clip = walk(60, seed=2)
    fine = run_blender(interpreter, clip, error=0.001)
    coarse = run_blender(interpreter, clip, error=0.05)
    assert coarse.keys < fine.keys
    assert fine.degrees < 0.5 < coarse.degrees
    compare_curves(clip, interpreter, runs=1)
    assert "times faster" in capsys.readouterr().out
