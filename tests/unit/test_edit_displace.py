"""Motion warping: known changes and what is refused."""

import numpy as np
import pytest

from mtex_usd.edit import Displacement, PoseChange, displace
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from tests.synthetic import HEAD, HIPS, JOINTS, LEFT_ARM, LEFT_LEG, make_skeleton, on_joints, walk

ARM = JOINTS.index(LEFT_ARM)


def change_angle(clip, moved, joint):
    """Degrees, exactly 0 where the bits are the same."""
    same = (clip.rotations[:, joint] == moved.rotations[:, joint]).all(axis=-1)
    angles = np.degrees(quaternion.angle_between(clip.rotations[:, joint], moved.rotations[:, joint]))
    return np.where(same, 0.0, angles)


def test_one_key_is_a_bump_within_its_scope():
    """Gleicher 2000, figure 24: the change comes and goes smoothly, farther or nearer."""
    clip = walk(60)
    key = PoseChange(frame=30, rotations={"LeftArm": (0.0, 0.0, 30.0)})
    for scope in (5.0, 20.0):
        angles = change_angle(clip, displace(clip, Displacement(keys=[key], scope=scope)), ARM)
        assert angles[30] == pytest.approx(30.0)
        outside = np.abs(np.arange(60) - 30) >= scope
        assert (angles[outside] == 0.0).all()
        assert (angles[~outside] > 0.0).all()
        along = 1.0 - np.abs(np.arange(60) - 30)[~outside] / scope
        np.testing.assert_allclose(angles[~outside], 30.0 * along**2 * (3.0 - 2.0 * along), atol=1e-9)


def test_a_scope_may_differ_before_and_after():
    clip = walk(60)
    key = PoseChange(frame=30, rotations={LEFT_ARM: (0.0, 20.0, 0.0)})
    angles = change_angle(clip, displace(clip, Displacement(keys=[key], scope=(4.0, 20.0))), ARM)
    np.testing.assert_array_equal(np.flatnonzero(angles), np.arange(27, 50))


def test_without_scope_the_change_holds():
    clip = walk(60)
    keys = [PoseChange(frame=f, rotations={LEFT_ARM: (0.0, v, 0.0)}) for f, v in ((20, 10.0), (40, 25.0))]
    angles = change_angle(clip, displace(clip, Displacement(keys=keys)), ARM)
    np.testing.assert_allclose(angles[:21], 10.0)
    np.testing.assert_allclose(angles[40:], 25.0)


def test_zero_holds_a_joint():
    """A joint goes through the keys that name it and no others."""
    clip = walk(60)
    keys = [
        PoseChange(frame=10, rotations={LEFT_ARM: (0.0, 0.0, 0.0), HEAD: (5.0, 0.0, 0.0)}),
        PoseChange(frame=30, rotations={LEFT_ARM: (0.0, 0.0, 20.0)}),
    ]
    moved = displace(clip, Displacement(keys=keys))
    assert (change_angle(clip, moved, ARM)[:11] == 0.0).all()
    np.testing.assert_allclose(change_angle(clip, moved, JOINTS.index(HEAD)), 5.0)


@pytest.mark.parametrize("oriented", [None, 7])
def test_vectors_turn_about_the_skeletons_axes_on_every_rig(oriented):
    """As channels do: the leg of a figure at rest, turned about x, swings in the plane across x."""
    skeleton = make_skeleton(oriented=oriented)
    clip = walk(5, leg=0.0, arm=0.0, detail=0.0, skeleton=skeleton)
    moved = displace(clip, Displacement(keys=[PoseChange(frame=2, rotations={LEFT_LEG: (90.0, 0.0, 0.0)})]))
    knee = skeleton.joint_positions([JOINTS.index(LEFT_LEG), JOINTS.index(f"{LEFT_LEG}/LeftLeg")], *arrays(moved))
    thigh = knee[2, 1] - knee[2, 0]
    assert abs(thigh[1]) < 5.0
    assert abs(thigh[2]) == pytest.approx(45.0, abs=1.0)


def arrays(clip):
    return clip.rotations, clip.translations


def test_translations_are_added_along_the_skeletons_axes():
    clip = walk(30, skeleton=make_skeleton(oriented=3))
    key = PoseChange(frame=15, translations={HIPS: (1.0, 2.0, 3.0)})
    moved = displace(clip, Displacement(keys=[key], scope=10))
    np.testing.assert_allclose(moved.translations[15, 0] - clip.translations[15, 0], [1.0, 2.0, 3.0], atol=1e-9)
    np.testing.assert_array_equal(moved.rotations, clip.rotations)


def test_a_key_may_take_some_channels_of_a_pose_only():
    clip, other = walk(30, seed=1), walk(30, seed=2)
    key = PoseChange.to_clip(clip, other, frame=10, channels=[LEFT_ARM])
    assert set(key.rotations) == {LEFT_ARM}
    assert not key.translations
    one_axis = PoseChange.to_clip(clip, other, frame=10, channels=[f"{LEFT_ARM}.rx"])
    np.testing.assert_array_equal(one_axis.rotations[LEFT_ARM][1:], 0.0)


def test_two_frames():
    clip = walk(2)
    moved = displace(clip, Displacement(keys=[PoseChange(frame=0, rotations={HEAD: (0, 10, 0)})], scope=1))
    np.testing.assert_allclose(change_angle(clip, moved, JOINTS.index(HEAD)), [10.0, 0.0], atol=1e-9)


def test_refuses_two_changes_at_one_frame():
    key = PoseChange(frame=3, rotations={HEAD: (1, 0, 0)})
    with pytest.raises(InputError, match=f"two changes of {HEAD} at one frame.*found frame 3 twice"):
        displace(walk(10), Displacement(keys=[key, key]))


@pytest.mark.parametrize("scope", [0.0, -3.0, (5.0, 0.0), float("nan")])
def test_refuses_an_empty_scope(scope):
    key = PoseChange(frame=3, rotations={HEAD: (1, 0, 0)})
    with pytest.raises(
        InputError, match="bad scope of a displacement; expected one or two finite numbers of frames above 0"
    ):
        displace(walk(10), Displacement(keys=[key], scope=scope))


@pytest.mark.parametrize("vector", [(1, 2), (1, 2, float("nan")), 3.0])
def test_refuses_what_is_no_vector(vector):
    key = PoseChange(frame=3, rotations={HEAD: vector})
    with pytest.raises(InputError, match=f"bad change of {HEAD} at frame 3; expected three finite numbers"):
        displace(walk(10), Displacement(keys=[key]))


def test_refuses_an_unknown_joint():
    with pytest.raises(InputError, match="keys of a displacement: no joint fits"):
        displace(walk(10), Displacement(keys=[PoseChange(frame=3, rotations={"Tail": (1, 0, 0)})]))


def test_refuses_frames_and_poses_that_do_not_fit():
    clip = walk(10)
    with pytest.raises(InputError, match="bad frame of /Take; expected a whole number, 0 to 9; found 10"):
        PoseChange.to_clip(clip, walk(20), frame=10)
    with pytest.raises(InputError, match="bad frame of /Take; expected a whole number, 0 to 19; found 20"):
        PoseChange.to_clip(clip, walk(20), frame=3, target_frame=20)
    with pytest.raises(InputError, match="the pose does not fit the clip's joints"):
        PoseChange.to_clip(clip, on_joints(clip, JOINTS[:4]), frame=3)
