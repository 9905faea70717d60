"""Reading clips for the method: which joint is which, and the root in the facing frame."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import Channel
from mtex_usd.motion.correspondence import corresponding_joints
from mtex_usd.texture.facing import measure_heading
from mtex_usd.texture.reading import choose_root, read_sketch, read_takes
from tests.synthetic import (
    HEAD,
    HIPS,
    JOINTS,
    LEFT_ARM,
    SPINE,
    UP,
    block,
    make_clip,
    make_skeleton,
    on_joints,
    turned,
    walk,
)

ARM = Channel(JOINTS.index(LEFT_ARM), "rx")


def test_joints_correspond_by_path_first():
    assert corresponding_joints(("A", "A/B", "C/B"), ("C/B", "A/B")) == {0: 2, 1: 1}


def test_then_by_last_name_where_both_have_it_once():
    assert corresponding_joints(("Rig", "Rig/Hips", "Rig/Hips/Arm"), ("Hips", "Hips/Arm")) == {0: 1, 1: 2}


def test_a_last_name_that_is_not_unique_does_not_correspond():
    assert corresponding_joints(("X", "X/Arm", "X/Y", "X/Y/Arm"), ("Arm",)) == {}
    assert corresponding_joints(("Z", "Z/Arm"), ("A", "A/Arm", "B", "B/Arm")) == {}


def still(clip):
    return replace(clip, translations=np.tile(clip.translations[:1], (clip.frame_count, 1, 1)))


def test_the_root_is_the_sketchs_or_else_a_takes():
    take = walk(20)
    assert choose_root(walk(20), []) == 0
    assert choose_root(still(walk(20)), [still(take), take]) == 0
    assert choose_root(still(walk(20)), []) == 0
    prefixed = make_skeleton(("Rig", HIPS), positions={"Rig": (0.0, 0.0, 0.0), HIPS: (0.0, 95.0, 0.0)})
    sketch = make_clip(prefixed, 24.0, np.tile([1.0, 0.0, 0.0, 0.0], (20, 2, 1)), np.zeros((20, 3)))
    assert choose_root(sketch, [take]) == 1


def test_a_sketch_is_read_in_skeleton_axes_with_its_heading_taken_out():
    clip = walk(60, heading=50.0, skeleton=make_skeleton(oriented=3))
    motion = read_sketch(clip, 0, 4)
    assert np.degrees(np.abs(quaternion.twist(motion.rotations[:, 0], np.array([0.0, 1.0, 0.0])))).max() < 12.0
    back = motion.facing.out_of(motion.rotations[:, 0])
    assert (
        quaternion.angle_between(quaternion.multiply(back, clip.skeleton.rest_rotations[0]), clip.rotations[:, 0]).max()
        < 1e-7
    )
    np.testing.assert_allclose(
        motion.facing.roll_travel(motion.travel) + clip.skeleton.rest_translations[0], clip.translations[:, 0]
    )


def test_takes_on_the_sketchs_joints_whatever_their_order():
    sketch = block(walk(60))
    take = walk(60, seed=2)
    order = tuple(sorted(JOINTS, key=lambda joint: (joint.count("/"), joint), reverse=False))
    plain, _ = read_takes([take], sketch, 0, 4, [ARM])
    shuffled, _ = read_takes([on_joints(take, order)], sketch, 0, 4, [ARM])
    np.testing.assert_allclose(shuffled[0].rotations, plain[0].rotations, atol=1e-12)
    np.testing.assert_allclose(shuffled[0].travel, plain[0].travel, atol=1e-9)


def test_what_a_take_lacks_stays_at_rest():
    take = on_joints(walk(60), [j for j in JOINTS if j != HEAD])
    (motion,), notes = read_takes([take], block(walk(60)), 0, 4, [ARM])
    np.testing.assert_array_equal(motion.rotations[:, JOINTS.index(HEAD)], np.tile([1.0, 0.0, 0.0, 0.0], (60, 1)))
    assert notes == []


def test_a_take_that_walks_another_way_reads_the_same():
    take = walk(60)
    (one, other), _ = read_takes([take, turned(take, 123.0)], block(walk(60)), 0, 4, [ARM])
    np.testing.assert_allclose(one.travel, other.travel, atol=1e-9)
    assert quaternion.angle_between(one.rotations, other.rotations).max() < 1e-7


def test_takes_without_a_role_joint_are_noted_and_if_all_lack_it_refused():
    lame = on_joints(walk(60, name="/Lame"), (HIPS, SPINE))
    sketch = block(walk(60))
    motions, notes = read_takes([lame, walk(60)], sketch, 0, 4, [ARM])
    assert len(motions) == 1
    assert notes == [f"take /Lame is left out: it has no {LEFT_ARM}"]
    with pytest.raises(
        InputError,
        match=f"no take has all joints with a role; expected joints named {LEFT_ARM}; found "
        f"take /Lame is left out: it has no {LEFT_ARM}. Use takes with joints of these names",
    ):
        read_takes([lame], sketch, 0, 4, [ARM])


def under_a_root(clip, *, carried_by):
    """The same motion on a skeleton with a joint above the hips, moved by that joint or by the hips."""
    skeleton = clip.skeleton
    joints = ("Root", *(f"Root/{joint}" for joint in skeleton.joints))
    rest = np.concatenate([np.eye(4)[None], skeleton.rest])
    still = np.tile([1.0, 0.0, 0.0, 0.0], (clip.frame_count, 1, 1))
    rotations = np.concatenate([still, clip.rotations], axis=1)
    translations = np.concatenate([np.zeros((clip.frame_count, 1, 3)), clip.translations], axis=1)
    if carried_by == "root":
        # Heading about up and the level way on the root; the hips keep what is left.
        heading = measure_heading(clip, 0)
        turn = quaternion.exp(heading[:, None] * UP)
        way = clip.translations[:, 0] * (1.0 - UP)
        rotations[:, 0], translations[:, 0] = turn, way
        rotations[:, 1] = quaternion.multiply(quaternion.conjugate(turn), clip.rotations[:, 0])
        translations[:, 1] = quaternion.rotate(quaternion.conjugate(turn), clip.translations[:, 0] - way)
    made = replace(skeleton, joints=joints, rest=rest)
    scales = np.ones_like(translations)
    return replace(clip, skeleton=made, rotations=rotations, translations=translations, scales=scales)


@pytest.mark.parametrize("sketch_carrier", ["root", "hips"])
@pytest.mark.parametrize("take_carrier", ["root", "hips"])
@pytest.mark.parametrize("heading", [0.0, 90.0])
def test_heading_is_left_out_whichever_joint_carries_it(sketch_carrier, take_carrier, heading):
    """The hips of a take read the same, whether it, or the sketch, is moved by the hips or by a joint above them."""
    sketch = under_a_root(walk(80), carried_by=sketch_carrier)
    take = under_a_root(walk(80, heading=heading), carried_by=take_carrier)
    root = choose_root(sketch, [take])
    assert root == (0 if sketch_carrier == "root" else 1)
    (motion,), _ = read_takes([take], sketch, root, 4, [Channel(1, "rx")])
    turned = np.degrees(np.abs(quaternion.twist(motion.rotations[:, 1], UP)))
    assert turned.max() < 15.0  # what is faster than the heading
    straight = read_takes([under_a_root(walk(80), carried_by="hips")], sketch, root, 4, [Channel(1, "rx")])[0][0]
    np.testing.assert_allclose(np.diff(motion.travel, axis=0), np.diff(straight.travel, axis=0), atol=0.5)
