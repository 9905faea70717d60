"""Joints of the same name in two skeletons, and motions on part of their joints."""

import numpy as np

from mtex_usd.motion import quaternion
from mtex_usd.motion.correspondence import corresponding_joints, keep_joints
from tests.retargeting_support import human, in_space, move


def test_joints_correspond_by_path():
    assert corresponding_joints(("A", "A/B", "A/B/C"), ("A", "A/B/C")) == {0: 0, 1: 2}


def test_then_by_last_name():
    assert corresponding_joints(("Root", "Root/Hips", "Root/Hips/Leg"), ("Hips", "Hips/Leg")) == {0: 1, 1: 2}


def test_a_path_comes_before_a_name():
    assert corresponding_joints(("A", "A/X", "B", "B/Y"), ("B", "B/X", "A", "A/X")) == {0: 2, 2: 0, 3: 1}


def test_names_that_are_not_unique_do_not_count():
    assert corresponding_joints(("A", "A/End", "B", "B/End"), ("C", "C/End")) == {}
    assert corresponding_joints(("C", "C/End"), ("A", "A/End", "B", "B/End")) == {}


def test_nothing_in_common():
    assert corresponding_joints(("A",), ("B",)) == {}
    assert corresponding_joints((), ("B",)) == {}


def test_keeping_all_is_the_same_motion():
    clip = move(human(seed=1), np.random.default_rng(0))
    kept = keep_joints(clip, range(len(clip.joints)))
    assert kept.joints == clip.joints
    assert quaternion.angle_between(kept.rotations, clip.rotations).max() < 1e-9
    np.testing.assert_allclose(kept.translations, clip.translations, atol=1e-9)
    np.testing.assert_allclose(kept.rest, clip.rest, atol=1e-12)


def test_what_is_left_out_between_is_taken_along():
    clip = move(human(seed=1), np.random.default_rng(0))
    joints = [0, *(i for i, joint in enumerate(clip.joints) if joint.endswith(("left.hand", "left.toes")))]
    kept = keep_joints(clip, joints)
    assert kept.parents.tolist() == [-1, 0, 0]
    places, _ = in_space(clip)
    kept_places, _ = in_space(kept)
    np.testing.assert_allclose(kept_places, places[:, joints], atol=1e-9)
    np.testing.assert_allclose(kept.skeleton.rest_positions, clip.skeleton.rest_positions[joints], atol=1e-9)
    assert (kept.rate, kept.start, kept.name, kept.scales.shape) == (clip.rate, clip.start, clip.name, (4, 3, 3))


def test_without_the_root_joints_stand_in_space():
    clip = move(human(seed=1), np.random.default_rng(0))
    kept = keep_joints(clip, [3])
    places, turns = in_space(clip)
    np.testing.assert_allclose(kept.translations[:, 0], places[:, 3])
    assert quaternion.angle_between(kept.rotations[:, 0], turns[:, 3]).max() < 1e-9
