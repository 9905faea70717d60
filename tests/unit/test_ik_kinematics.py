"""Places of points of the body and how they move when joints turn."""

import numpy as np
from scipy.spatial.transform import Rotation

from mtex_usd.constraints.kinematics import place_points, pose_skeleton, turn_columns
from tests.oracle import contacts as oracle
from tests.unit.test_ik_solver import FOOT, HAND, make_clip


def test_points_are_placed_as_the_slow_twin_places_them():
    clip = make_clip(frames=5, seed=2)
    offsets = np.array([[1.0, -2.0, 3.0], [0.0, 4.0, -1.0]])
    found = place_points(clip.skeleton, [FOOT, HAND], offsets, clip.rotations, clip.translations)
    pose = pose_skeleton(clip.skeleton, clip.rotations, clip.translations)
    for number, joint in enumerate((FOOT, HAND)):
        track = oracle.track_point(clip.parents, clip.rotations, clip.translations, joint, offsets[number])
        np.testing.assert_allclose(found[:, number], track, atol=1e-12)
        np.testing.assert_allclose(pose.place(joint, offsets[number]), track, atol=1e-12)


def test_columns_are_the_derivative_of_turns_about_axes():
    rng = np.random.default_rng(0)
    axes = rng.standard_normal((4, 2, 3))
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    pivots, points = rng.standard_normal((4, 2, 3)), rng.standard_normal((4, 3))
    columns = turn_columns(axes, pivots, points)
    assert columns.shape == (4, 3, 2)
    for number in range(2):
        arms = points - pivots[:, number]
        turned = [Rotation.from_rotvec(angle * axes[:, number]).apply(arms) for angle in (1e-6, -1e-6)]
        np.testing.assert_allclose(columns[..., number], (turned[0] - turned[1]) / 2e-6, atol=1e-8)
