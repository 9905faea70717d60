"""A walk that slows to a stop: with scale on the arms calm down with the legs (Pullen & Bregler 2002, section 4.1)."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.motion import quaternion
from mtex_usd.texture.pyramid import decompose
from tests.benchmarks.quality.cases import WALK, Fold, load_captures, make_sketch, to_clip
from tests.benchmarks.quality.metrics import joint_indices, pose_vectors
from tests.benchmarks.quality.settings import run_method

ARMS = ("LeftArm", "LeftForeArm", "RightArm", "RightForeArm")
THIGHS = ("LeftUpLeg", "RightUpLeg")
WALKING, STANDING = 0.3, 0.85  # parts of the clip: full swing up to the one, no swing from the other


def slow_to_a_stop(curves):
    """The legs' swings about their mean fade away."""
    part = np.linspace(0.0, 1.0, len(curves.root))
    fade = np.clip((STANDING - part) / (STANDING - WALKING), 0.0, 1.0)
    fade = fade * fade * (3.0 - 2.0 * fade)
    legs = np.array([joint.rpartition("/")[2] in WALK.rig.legs for joint in curves.joints])
    angles = np.array(curves.angles)
    middle = angles[:, legs].mean(axis=0)
    angles[:, legs] = middle + fade[:, None, None] * (angles[:, legs] - middle)
    return make_sketch(replace(curves, angles=angles))


def swing(clip, names):
    """Amplitude while walking and while standing: root mean square of what is faster than 0.3 Hz, degrees."""
    joints = joint_indices(clip, names)
    curves = decompose(pose_vectors(clip, joints, quaternion.mean(clip.rotations[:, joints]))).sum_of(2, 5)
    frames = len(curves)
    parts = curves[: int(WALKING * frames)], curves[int(STANDING * frames) :]
    return tuple(float(np.sqrt(np.square(part).mean())) for part in parts)


@pytest.fixture(scope="module")
def walks(data_dir):
    return load_captures(data_dir / "cmu_bvh" / WALK.folder, WALK.clips)


def run_slowed(walks, name, *, scale):
    sketch = slow_to_a_stop(walks[name])
    takes = tuple(to_clip(curves) for other, curves in walks.items() if other != name)
    return run_method(Fold(WALK, sketch, sketch, takes), scale=scale)


@pytest.mark.parametrize("name", ["07_03", "07_05", "07_06"])
class TestSlowingWalk:
    def test_sketch_does_stop(self, walks, name):
        before, after = swing(slow_to_a_stop(walks[name]), THIGHS)
        assert after < 0.05 * before

    def test_arms_follow_with_scale(self, walks, name):
        for variant in run_slowed(walks, name, scale=True).variants:
            before, after = swing(variant.clip, ARMS)
            assert after < 0.25 * before

    def test_arms_go_on_without(self, walks, name):
        for variant in run_slowed(walks, name, scale=False).variants:
            before, after = swing(variant.clip, ARMS)
            assert after > 0.6 * before
            assert all(fragment.scale == 1.0 for fragment in variant.fragments)

    def test_factors_fall_to_nothing(self, walks, name):
        for variant in run_slowed(walks, name, scale=True).variants:
            factors = [fragment.scale for fragment in variant.fragments]
            assert factors[-1] < 0.15
            assert factors[-1] < 0.2 * max(factors)
