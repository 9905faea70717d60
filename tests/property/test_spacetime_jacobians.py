"""Derivatives of every kind of constraint against finite differences, on random skeletons and motions."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mtex_usd.constraints.spacetime import (
    DistanceBetween,
    MassOver,
    OrientationAt,
    PathFollow,
    PlaneAbove,
    PlaneOn,
    Point,
    PointAt,
    PointStill,
    RotationRange,
)
from mtex_usd.constraints.spacetime.problem import Settings, choose_cast, compile_problem
from mtex_usd.constraints.spacetime.scene import Scene
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from tests.synthetic import random_rotations

FRAMES = 5
SEEDS = st.integers(0, 2**32 - 1)
KINDS = (
    "point", "still", "above", "on", "orientation", "range", "lock", "distance", "meet", "path", "mass",
)  # fmt: skip


def random_clip(rng, joints=6):
    """A random tree of joints in random poses, its bones changing length, centimetres."""
    paths = ["j0"]
    for number in range(1, joints):
        paths.append(f"{paths[rng.integers(number)]}/j{number}")
    rest = np.tile(np.eye(4), (joints, 1, 1))
    rest[:, :3, :3] = quaternion.rotate(random_rotations(rng, joints)[:, None], np.eye(3))
    rest[:, 3, :3] = rng.uniform(-40.0, 40.0, (joints, 3))
    skeleton = Skeleton(joints=tuple(paths), rest=rest)
    turns = quaternion.exp(rng.uniform(-0.6, 0.6, (FRAMES, joints, 3)))
    return Clip(
        skeleton=skeleton,
        rate=24.0,
        rotations=quaternion.multiply(skeleton.rest_rotations, turns),
        translations=rng.uniform(-40.0, 40.0, (FRAMES, joints, 3)),
        scales=np.ones((FRAMES, joints, 3)),
    )


def make(kind, rng, joint, other):
    """One constraint of a kind, about random places."""
    frames = np.array([0, 2, 3])
    point = Point(joint, tuple(rng.uniform(-10.0, 10.0, 3)))
    partner = Point(other, tuple(rng.uniform(-10.0, 10.0, 3)), clip=1)
    place, angles = rng.uniform(-50.0, 50.0, 3), rng.uniform(10.0, 60.0, 3)
    return {
        "point": lambda: PointAt(kind, point, frames, place),
        "still": lambda: PointStill(kind, point, frames),
        "above": lambda: PlaneAbove(kind, point, frames, 3.0, place),
        "on": lambda: PlaneOn(kind, point, frames, [1.0, 2.0, 3.0]),
        "orientation": lambda: OrientationAt(kind, joint, frames, random_rotations(rng, 3)),
        "range": lambda: RotationRange(kind, joint, frames, -angles, angles, order="ZXY", axes=random_rotations(rng)),
        "lock": lambda: RotationRange(kind, joint, frames, [0.0, 5.0, -np.inf], [0.0, 5.0, 20.0]),
        "distance": lambda: DistanceBetween(kind, point, partner, frames, 12.0),
        "meet": lambda: DistanceBetween(kind, point, partner, frames, 0.0),
        "path": lambda: PathFollow(kind, point, [0.5, 2.0, 3.5], rng.uniform(-50.0, 50.0, (3, 3))),
        "mass": lambda: MassOver(kind, rng.uniform(-50.0, 50.0, (4, 3)), frames, margin=1.0),
    }[kind]()


def already_met(clip, joint):
    """Ask a joint to be turned as it is."""
    frames = np.arange(FRAMES)
    world = clip.skeleton.world_rotations(clip.rotations)[frames, clip.joints.index(joint)]
    return OrientationAt("met orientation", joint, frames, world)


def make_problem(kind, seed):
    rng = np.random.default_rng(seed)
    clips = (random_clip(rng), random_clip(rng))
    joint = clips[0].joints[-1]
    met = kind == "met orientation"
    constraints = [already_met(clips[0], joint) if met else make(kind, rng, joint, clips[1].joints[3])]
    scene = Scene(clips=clips, window=(0, FRAMES - 1))
    scene.write_all(constraints)
    options = Settings(
        frequency=6.0, joint_weights={}, translation_weight=1.0, smoothness=0.0, highpass=0.0, fixed=frozenset()
    )
    problem = compile_problem(choose_cast(scene, options), constraints, scene)
    changes = rng.uniform(-0.5, 0.5, (len(problem.frames), len(problem.cast.weights)))
    places = rng.uniform(-0.5, 0.5, (len(problem.place_owners), 3))
    return problem, changes, places


def differences(problem, changes, places, column, step=1e-6):
    """Change of every row by one channel at its own frame."""
    shift = step * np.eye(changes.shape[1])[column]
    more = problem.evaluate(changes + shift, places).residual
    less = problem.evaluate(changes - shift, places).residual
    return (more - less) / (2.0 * step)


def far_from_folds(residual, jacobian):
    """Away from half turns and gimbal lock, where angles jump."""
    return np.abs(residual).max() < 2.6 and np.abs(jacobian).max() < 50.0


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=15)
@given(seed=SEEDS)
def test_derivatives_are_the_limits_of_differences(kind, seed):
    problem, changes, places = make_problem(kind, seed)
    found = problem.evaluate(changes, places)
    assume(far_from_folds(found.residual, found.jacobian))
    expected = np.stack([differences(problem, changes, places, c) for c in range(changes.shape[1])], axis=1)
    assert len(found.residual) > 0
    np.testing.assert_allclose(found.jacobian, expected, atol=2e-6 * max(1.0, np.abs(expected).max()))


@pytest.mark.parametrize("kind", ["point", "above", "mass", "distance", "met orientation"])
@settings(max_examples=10)
@given(seed=SEEDS)
def test_second_derivatives_are_those_of_the_pulled_rows(kind, seed):
    """At no displacement, where they are exact; for an orientation, where it is the one asked for."""
    problem, changes, places = make_problem(kind, seed)
    zero, step = 0.0 * changes, 1e-4
    pulls = np.random.default_rng(seed).uniform(-1.0, 1.0, len(problem.info.frame))
    bends = problem.evaluate(zero, places).bend(pulls)
    expected = np.zeros_like(bends)
    at = np.searchsorted(problem.frames, problem.info.frame)
    for column in range(changes.shape[1]):
        shift = step * np.eye(changes.shape[1])[column]
        rows = problem.evaluate(zero + shift, places).jacobian - problem.evaluate(zero - shift, places).jacobian
        np.add.at(expected[:, column], at, pulls[:, None] * rows / (2.0 * step))
    assert np.abs(expected).max() > 0.01
    expected = 0.5 * (expected + np.swapaxes(expected, 1, 2))
    np.testing.assert_allclose(bends, expected, atol=1e-5 * max(1.0, np.abs(expected).max()))
