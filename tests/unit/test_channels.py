"""Channel tokens, and the axes channels turn about."""

import numpy as np
import pytest

from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import (
    Channel,
    choose_euler_order,
    resolve_channels,
    to_skeleton_rotations,
    unrolled_angles,
)
from tests.oracle import channels as twin

JOINTS = (
    "Hips",
    "Hips/Spine",
    "Hips/Spine/LeftArm",
    "Hips/Spine/RightArm",
    "Hips/LeftLeg",
    "Hips/Spine/Hand.L",
    "X/Leg",
    "Y/Leg",
)


def resolve(*tokens):
    found = resolve_channels(tokens, JOINTS, source="mtex:match of /Sketch")
    return [(channel.joint, channel.kind) for channel in found]


ROTATIONS = ("rx", "ry", "rz")


@pytest.mark.parametrize(
    ("token", "expected"),
    [
        ("Hips.rx", [(0, "rx")]),
        ("Hips.tz", [(0, "tz")]),
        ("Hips/Spine/LeftArm.ry", [(2, "ry")]),
        ("LeftArm.ry", [(2, "ry")]),
        ("LeftArm", [(2, kind) for kind in ROTATIONS]),
        ("LeftArm.r", [(2, kind) for kind in ROTATIONS]),
        ("Hips.t", [(0, kind) for kind in ("tx", "ty", "tz")]),
        ("*Arm.rx", [(2, "rx"), (3, "rx")]),
        ("*Arm*", [(joint, kind) for joint in (2, 3) for kind in ROTATIONS]),
        ("Spine*.rz", [(1, "rz")]),
        ("[LR]*Arm.rx", [(2, "rx"), (3, "rx")]),
        ("Hips/Spine/*.rx", [(2, "rx"), (3, "rx"), (5, "rx")]),
        ("X/Leg.rx", [(6, "rx")]),
        ("?/Leg.rx", [(6, "rx"), (7, "rx")]),
    ],
)
def test_tokens(token, expected):
    assert resolve(token) == expected


def test_channels_keep_the_order_of_the_tokens_and_come_once():
    assert resolve("LeftArm.rz", "Hips.rx", "LeftArm") == [(2, "rz"), (0, "rx"), (2, "rx"), (2, "ry")]


def test_no_tokens():
    assert resolve() == []


def test_names():
    assert Channel(2, "rx").name(JOINTS) == "Hips/Spine/LeftArm.rx"
    assert (Channel(2, "ty").axis, Channel(2, "ty").is_rotation) == (1, False)
    assert (Channel(2, "rz").axis, Channel(2, "rz").is_rotation) == (2, True)


def test_an_unknown_joint_lists_what_there_is():
    with pytest.raises(
        InputError,
        match=r"mtex:match of /Sketch: no joint fits 'LeftLg.rx'; expected one of the joints Hips, Spine, Left",
    ):
        resolve("LeftLg.rx")


def test_a_glob_that_fits_nothing():
    with pytest.raises(InputError, match=r"no joint fits '\*Tail\*'; expected one of the joints .*; found \*Tail\*"):
        resolve("*Tail*")


def test_globs_and_names_see_upper_and_lower_case():
    with pytest.raises(InputError, match="no joint fits 'leftarm'"):
        resolve("leftarm")
    with pytest.raises(InputError, match=r"no joint fits '\*arm\*'"):
        resolve("*arm*")


def test_a_last_name_of_several_joints():
    with pytest.raises(
        InputError, match=r"'Leg.rx' names several joints; found X/Leg, Y/Leg. Write the full joint path"
    ):
        resolve("Leg.rx")


@pytest.mark.parametrize("token", ["Hips.rw", "Hips.x", "Hips.RX"])
def test_an_unknown_channel(token):
    with pytest.raises(
        InputError, match=f"unknown channel in '{token}'; expected one of rx ry rz tx ty tz r t; found {token[5:]}"
    ):
        resolve(token)


def test_a_dot_without_a_channel():
    with pytest.raises(InputError, match=r"unknown channel in 'Hips\.'; expected .*; found nothing"):
        resolve("Hips.")


def test_a_joint_name_with_a_dot_is_reached_with_its_channel():
    assert resolve("Hand.L.rx") == [(5, "rx")]


def test_the_preferred_order_is_kept_while_it_is_safe():
    assert choose_euler_order(quaternion.exp(np.radians([[60.0, 20.0, 30.0]]))) == "ZYX"


@pytest.mark.parametrize(
    ("axis", "middle"), [((0.0, 88.0, 0.0), "Y"), ((85.0, 0.0, 0.0), "X"), ((0.0, 0.0, 89.0), "Z")]
)
def test_an_axis_that_turns_far_is_not_in_the_middle(axis, middle):
    order = choose_euler_order(quaternion.exp(np.radians([axis])))
    assert order[1] != middle


def test_the_middle_angle_is_that_of_scipys_order():
    """The sine read off the quaternion, against the angles themselves, for every order."""
    turns = quaternion.normalize(np.random.default_rng(3).standard_normal((40, 4)))
    for turn in turns:
        order = choose_euler_order(turn[None])
        middles = {
            o: abs(quaternion.to_euler(turn, o)["XYZ".index(o[1])]) for o in ("ZYX", "YZX", "XYZ", "ZXY", "XZY", "YXZ")
        }
        safe = [o for o, angle in middles.items() if angle < 65.0]
        assert order == (safe[0] if safe else min(middles, key=middles.get))


def test_a_spin_unrolls_through_whole_turns():
    degrees = np.arange(0.0, 1500.0, 30.0)
    spin = quaternion.exp(np.radians(degrees)[:, None] * np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(unrolled_angles(spin, "ZYX")[:, 2], degrees, atol=1e-9)


def test_a_joint_flexed_beyond_a_right_angle_in_the_middle_axis_has_no_jump():
    degrees = 120.0 * np.sin(np.linspace(0.0, 6.0, 100))
    turns = quaternion.exp(np.radians(degrees)[:, None] * np.array([0.0, 1.0, 0.0]))
    angles = unrolled_angles(turns, "ZYX")
    np.testing.assert_allclose(angles[:, 1], degrees, atol=1e-6)
    np.testing.assert_allclose(angles[:, [0, 2]], 0.0, atol=1e-6)


def test_a_real_rig_with_oriented_joints_turns_both_legs_about_the_skeletons_x(data_dir):
    """HIK_Export: 70 joints, Z up. Matrices straight from USD, row vectors, on one side; our channels on the other."""
    from pxr import Gf, Usd, UsdSkel

    from mtex_usd.usd.skeletons import read_skeleton

    file = data_dir / "usd" / "HIK_Export.usda"
    if not file.is_file():
        pytest.skip(f"no {file.name} in {file.parent}")
    stage = Usd.Stage.Open(str(file))
    prim = next(prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Skeleton))
    skeleton = read_skeleton(prim)
    query = UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton(prim))
    world = [Gf.Matrix4d(matrix) for matrix in query.ComputeJointSkelTransforms(Usd.TimeCode.EarliestTime(), True)]
    turn = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(1, 0, 0), 25.0))
    rotations = np.array(skeleton.rest_rotations)
    names = [joint.rpartition("/")[2] for joint in skeleton.joints]
    legs = [names.index(name) for name in ("Fight_LeftUpLeg", "Fight_RightUpLeg", "Fight_LeftLeg", "Fight_RightLeg")]
    for leg in legs:
        local = world[leg] * turn * world[skeleton.parents[leg]].GetInverse()
        rotations[leg] = quaternion.from_usd_matrix(np.array(local))
    angles = quaternion.to_euler(to_skeleton_rotations(rotations[None], skeleton)[0], "ZYX")
    np.testing.assert_allclose(angles[legs], [[25.0, 0.0, 0.0]] * 4, atol=1e-3)
    others = np.delete(angles, legs, axis=0)
    np.testing.assert_allclose(others, 0.0, atol=1e-3)


def test_the_definition_on_one_joint_by_hand():
    """A leg whose own x is the skeleton's -z: turned about its own z it swings about the skeleton's x."""
    from mtex_usd.motion.skeleton import Skeleton

    rest = np.eye(4)
    rest[:3, :3] = [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]  # rows: where the joint's x, y, z point
    skeleton = Skeleton(joints=("Leg",), rest=rest[None])
    about_own_z = quaternion.exp(np.radians([0.0, 0.0, 20.0]))
    local = quaternion.multiply(skeleton.rest_rotations[0], about_own_z)
    read = to_skeleton_rotations(local[None, None], skeleton)[0, 0]
    np.testing.assert_allclose(quaternion.to_euler(read, "ZYX"), [20.0, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(twin.matrix_of(read), twin.turn_about(0, 20.0), atol=1e-12)
