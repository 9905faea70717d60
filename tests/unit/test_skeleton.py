"""The skeleton: parents, rest pose and forward kinematics."""

import numpy as np
import pytest

from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.skeleton import Skeleton, parents_of
from tests.synthetic import JOINTS, POSITIONS, make_skeleton, random_rotations


def eyes(count):
    return np.tile(np.eye(4), (count, 1, 1))


def test_the_parent_is_the_nearest_listed_ancestor():
    assert parents_of(("A", "A/B", "A/B/C/D", "X", "A/E")).tolist() == [-1, 0, 1, -1, 0]


def test_a_name_that_only_begins_alike_is_no_ancestor():
    assert parents_of(("Hip", "Hips/Leg")).tolist() == [-1, -1]


@pytest.mark.parametrize("oriented", [None, 1, 2])
def test_rest_positions_do_not_depend_on_joint_orientations(oriented):
    skeleton = make_skeleton(oriented=oriented)
    positions, orientations = skeleton.world_pose(skeleton.rest_rotations, skeleton.rest_translations)
    np.testing.assert_allclose(positions, [POSITIONS[joint] for joint in JOINTS], atol=1e-9)
    assert quaternion.angle_between(orientations, skeleton.rest_orientations).max() < 1e-7
    assert skeleton.height == pytest.approx(120.0)


def test_forward_kinematics_is_the_product_of_matrices():
    rng = np.random.default_rng(5)
    skeleton = make_skeleton(oriented=5)
    rotations, translations = random_rotations(rng, 3, len(JOINTS)), rng.standard_normal((3, len(JOINTS), 3))
    positions, orientations = skeleton.world_pose(rotations, translations)
    for frame in range(3):
        world = []
        for joint, parent in enumerate(skeleton.parents):
            local = np.eye(4)
            local[:3, :3] = quaternion.rotate(rotations[frame, joint], np.eye(3))
            local[3, :3] = translations[frame, joint]
            world.append(local @ world[parent] if parent >= 0 else local)
        np.testing.assert_allclose(positions[frame], [matrix[3, :3] for matrix in world], atol=1e-9)
        expected = quaternion.from_usd_matrix(np.array(world))
        assert quaternion.angle_between(orientations[frame], expected).max() < 1e-6


def test_height_is_measured_along_up():
    skeleton = make_skeleton()
    sideways = Skeleton(joints=skeleton.joints, rest=skeleton.rest, up=np.array([1.0, 0.0, 0.0]))
    assert sideways.height == pytest.approx(90.0)


def test_rest_transforms_must_fit_the_joints():
    with pytest.raises(InputError, match=r"do not fit the joints; expected shape \(2, 4, 4\); found \(3, 4, 4\)"):
        Skeleton(joints=("A", "A/B"), rest=eyes(3))


def test_joints_are_listed_once():
    with pytest.raises(InputError, match="joint paths are not unique; found A/B"):
        Skeleton(joints=("A", "A/B", "A/B"), rest=eyes(3))


def test_a_parent_comes_before_its_children():
    with pytest.raises(InputError, match="a joint comes before its parent; found A/B"):
        Skeleton(joints=("A/B", "A"), rest=eyes(2))


def test_positions_of_a_few_joints_are_those_of_the_whole_pose():
    rng = np.random.default_rng(6)
    skeleton = make_skeleton(oriented=6)
    rotations, translations = random_rotations(rng, 3, len(JOINTS)), rng.standard_normal((3, len(JOINTS), 3))
    whole, _ = skeleton.world_pose(rotations, translations)
    np.testing.assert_allclose(skeleton.joint_positions((8, 2), rotations, translations), whole[:, [8, 2]], atol=1e-12)


def test_a_chain_leads_from_the_root_to_the_joint():
    skeleton = make_skeleton()
    chain = [skeleton.joints[i] for i in skeleton.chain(JOINTS.index("Hips/Spine/LeftArm/LeftForeArm"))]
    assert chain == ["Hips", "Hips/Spine", "Hips/Spine/LeftArm", "Hips/Spine/LeftArm/LeftForeArm"]
