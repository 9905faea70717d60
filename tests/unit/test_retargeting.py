"""Retargeting: pairs of joints, how bodies stand and where their floor is, and what is left as it is."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

import mtex_usd
from mtex_usd.constraints.retargeting import Pair, fit_take, map_joints, retarget
from mtex_usd.constraints.retargeting.body import estimate_ground, measure_body, measure_scale, rest_ground
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.anatomy import find_anatomy
from mtex_usd.motion.skeleton import Skeleton
from tests.anatomy_support import rename_joints
from tests.retargeting_support import (
    AIMED,
    HUMAN,
    angle_apart,
    animate,
    assert_same_motion,
    direction,
    human,
    in_space,
    index_of,
    last,
    lowered,
    move,
    random_turns,
    rest_clip,
)

TAIL = {
    "tail1": ("hips", (0.0, 0.95, -0.2)),
    "tail2": ("tail1", (0.0, 0.95, -0.4)),
    "tail3": ("tail2", (0.0, 0.95, -0.6)),
}
ROPE = ("A", "A/B", "A/B/C")
X, Y, Z = np.eye(3)


def make_rope(joints=ROPE, *, along=(0.0, 1.0, 0.0)):
    """A chain that is no body, a unit from joint to joint."""
    rest = np.tile(np.eye(4), (len(joints), 1, 1))
    rest[1:, 3, :3] = along
    return Skeleton(joints=tuple(joints), rest=rest)


def moving(skeleton, seed=0):
    return move(skeleton, np.random.default_rng(seed))


def opposite_tails(axis):
    """A motion of a body whose tail rests along an axis, and a body whose tail rests against it."""
    along, against = (
        {f"tail{i}": (f"tail{i - 1}" if i > 1 else "hips", HUMAN["hips"][1] + i * step * axis) for i in (1, 2, 3)}
        for step in (0.2, -0.2)
    )
    return moving(human({**HUMAN, **along})), human({**HUMAN, **against}, seed=1)


def mapped_names(joint_map):
    """Which joints drive which, by last names."""
    return {last(joint): [last(other) for other in by] for joint, by in joint_map.mapped.items()}


def turned_since_rest(clip, name):
    _, world = in_space(clip)
    joint = index_of(clip.skeleton, name)
    return quaternion.multiply(world[:, joint], quaternion.conjugate(clip.skeleton.rest_orientations[joint]))


def assert_turned_alike(clip, name, other, other_name):
    turns = turned_since_rest(clip, name), turned_since_rest(other, other_name)
    assert quaternion.angle_between(*turns).max() < 1e-9


def assert_at_rest(clip, name):
    joint = index_of(clip.skeleton, name)
    assert quaternion.angle_between(clip.rotations[:, joint], clip.skeleton.rest_rotations[joint]).max() < 1e-12
    expected = np.tile(clip.skeleton.rest_translations[joint], (clip.frame_count, 1))
    np.testing.assert_array_equal(clip.translations[:, joint], expected)


class TestPairs:
    def test_a_pair_is_stronger_than_what_a_joint_is_recognised_as(self):
        clip, target = moving(human()), human(seed=1)
        moved = retarget(clip, target, pairs=[("left.hand", "right.foot")])
        assert_turned_alike(moved, "left.hand", clip, "right.foot")
        assert angle_apart(direction(clip, "left.foreArm", "left.hand"), direction(moved, "left.foreArm", "left.hand"))

    def test_arms_that_are_paired_crosswise_cross(self):
        clip, target = moving(human()), human(seed=1)
        bones = ("upperArm", "foreArm", "hand")
        pairs = [(f"left.{bone}", f"right.{bone}") for bone in bones] + [(f"right.{b}", f"left.{b}") for b in bones]
        moved = retarget(clip, target, pairs=pairs)
        for upper, lower in itertools.pairwise(bones):
            own = direction(moved, f"left.{upper}", f"left.{lower}")
            assert angle_apart(own, direction(clip, f"right.{upper}", f"right.{lower}")) < 1e-9

    @pytest.mark.parametrize("name", ["head", "left.foreArm", "chest", "spine", "left.toes"])
    def test_an_empty_source_leaves_the_joint_at_rest(self, name):
        clip, target = moving(human()), human(lowered(HUMAN, 40.0), seed=1)
        moved = retarget(clip, target, pairs=[(name, "")])
        assert_at_rest(moved, name)
        joint_map = map_joints(clip.skeleton, target, [Pair(name, "")])
        assert [last(joint) for joint in joint_map.unmapped] == [name]

    def test_what_is_above_a_joint_left_at_rest_is_aimed_as_ever(self):
        clip, target = moving(human()), human(lowered(HUMAN, 40.0), seed=1)
        moved = retarget(clip, target, pairs=[("left.foreArm", ""), ("right.thigh", "")])
        for upper, lower in AIMED:
            if upper not in {"left.foreArm", "right.thigh"}:
                assert angle_apart(direction(clip, upper, lower), direction(moved, upper, lower)) < 1e-9, upper

    def test_hips_left_at_rest_neither_turn_nor_travel(self):
        clip, target = moving(human()), human(seed=1)
        moved = retarget(clip, target, pairs=[("hips", "")])
        assert_at_rest(moved, "hips")
        assert (
            angle_apart(direction(clip, "left.thigh", "left.shin"), direction(moved, "left.thigh", "left.shin")) < 1e-9
        )
        assert "spine" in mapped_names(map_joints(clip.skeleton, target, [Pair("hips", "")]))

    def test_a_pair_within_the_trunk_divides_it(self):
        body = {
            **{name: place for name, place in HUMAN.items() if name == "hips"},
            "low": ("hips", (0.0, 1.00, 0.0)),
            "mid": ("low", (0.0, 1.10, 0.0)),
            **{name: place for name, place in HUMAN.items() if name not in {"hips", "spine"}},
            "chest": ("mid", (0.0, 1.25, -0.02)),
        }
        source, target = human(), human(body, seed=1)
        assert mapped_names(map_joints(source, target))["mid"] == ["spine", "chest"]
        joint_map = map_joints(source, target, [Pair("mid", "spine")])
        assert [section.name for section in joint_map.sections[:2]] == ["hips to neck", "hips to neck, below"]
        names = mapped_names(joint_map)
        assert (names["low"], names["mid"]) == (["hips"], ["spine"])
        clip = moving(source)
        moved = retarget(clip, target, pairs=[("mid", "spine"), ("chest", "chest")])
        for upper, own in (("spine", "mid"), ("chest", "chest")):
            lower = {"mid": "chest", "chest": "neck"}[own]
            assert angle_apart(direction(clip, upper, lower), direction(moved, own, lower)) < 1e-9

    @pytest.mark.parametrize("joint", ["spine", "chest"])
    def test_a_pair_of_a_trunk_joint_with_another_limbs_is_followed_too(self, joint):
        clip, target = moving(human()), human(seed=1)
        moved = retarget(clip, target, pairs=[(joint, "left.foot")])
        assert_turned_alike(moved, joint, clip, "left.foot")

    def test_pairs_of_a_tail_are_followed(self):
        source = human({**HUMAN, "fluke1": ("hips", (0.1, 0.9, -0.1)), "fluke2": ("fluke1", (0.2, 0.7, -0.3))})
        target = human({**HUMAN, **TAIL}, seed=1)
        clip = moving(source)
        assert {last(joint) for joint in map_joints(source, target).unmapped} == set(TAIL)
        moved = retarget(clip, target, pairs=[("tail1", "fluke1"), ("tail3", "fluke2")])
        for upper, lower in (("tail1", "tail2"), ("tail2", "tail3")):
            assert angle_apart(direction(moved, upper, lower), direction(clip, "fluke1", "fluke2")) < 1e-9
        joint_map = map_joints(source, target, [Pair("tail1", "fluke1"), Pair("tail3", "fluke2")])
        assert joint_map.unmapped == joint_map.unused == ()

    def test_a_tail_of_the_same_names_needs_no_pairs(self):
        clip = moving(human({**HUMAN, **TAIL}))
        moved = retarget(clip, human({**HUMAN, **TAIL}, seed=1))
        for upper, lower in (("tail1", "tail2"), ("tail2", "tail3")):
            assert angle_apart(direction(moved, upper, lower), direction(clip, upper, lower)) < 1e-9
        assert_turned_alike(moved, "tail3", clip, "tail3")

    def test_joints_of_the_same_name_that_are_something_else_do_not_count(self):
        source = rename_joints(human(), lambda index, _: f"joint_{index}")
        body = {"hips": HUMAN["hips"], "skirt": ("hips", (0.0, 0.7, 0.1)), **HUMAN}
        target = rename_joints(human(body), lambda index, _: f"joint_{index}")
        # joint_1 is the skirt of one and the spine of the other.
        assert map_joints(source, target).unmapped == ("joint_0/joint_1",)

    @pytest.mark.parametrize("axis", [Z, Y, X], ids="zyx")
    def test_a_tail_that_rests_the_other_way_round_is_turned_about(self, axis):
        clip, target = opposite_tails(axis)
        moved = retarget(clip, target)
        assert angle_apart(direction(moved, "tail1", "tail2"), direction(clip, "tail1", "tail2")) < 1e-9

    @pytest.mark.parametrize("axis", [Z, Y, X], ids="zyx")
    def test_and_turns_about_with_the_body_whichever_way_that_faces(self, axis):
        clip, target = opposite_tails(axis)
        turns, places = (np.array(array) for array in (in_space(clip)[1], clip.translations[:, 0]))
        round_up = quaternion.exp(np.radians(70.0) * Y)
        other = animate(clip.skeleton, quaternion.multiply(round_up, turns), quaternion.rotate(round_up, places))
        moved, also_moved = retarget(clip, target), retarget(other, target)
        expected = quaternion.multiply(round_up, turned_since_rest(moved, "tail1"))
        assert quaternion.angle_between(turned_since_rest(also_moved, "tail1"), expected).max() < 1e-7

    def test_full_paths_tell_joints_of_one_name_apart(self):
        target = rename_joints(human(), lambda _, name: name.replace("left.toes", "end").replace("right.toes", "end"))
        paths = [joint for joint in target.joints if last(joint) == "end"]
        joint_map = map_joints(human(), target, [Pair(paths[0], "head")])
        assert joint_map.mapped[paths[0]] == {human().joints[index_of(human(), "head")]: 1.0}
        with pytest.raises(InputError, match=rf"'end' names several joints.*full joint path; found {paths[0]}, "):
            map_joints(human(), target, [Pair("end", "head")])

    @pytest.mark.parametrize(
        ("pair", "message"),
        [
            (("tail", "head"), r"'tail' names no joint to retarget; expected one of the joints hips, spine, chest"),
            (("head", "nose"), r"'nose' names no joint to retarget; expected one of the joints hips, spine, chest"),
            (("", "head"), r"'' names no joint to retarget"),
        ],
    )
    def test_unknown_names(self, pair, message):
        with pytest.raises(InputError, match=message):
            retarget(moving(human()), human(), pairs=[pair])

    def test_a_joint_paired_twice(self):
        target = human()
        path = target.joints[index_of(target, "head")]
        with pytest.raises(InputError, match=rf"a joint is paired twice; .*found 'head', '{path}'"):
            map_joints(human(), target, [Pair("head", "neck"), Pair(path, "head")])


class TestWhatIsNoHumanoid:
    def test_without_pairs_it_is_refused(self):
        with pytest.raises(InputError, match=r"the take's skeleton cannot be retargeted; expected .*found A, B, C"):
            retarget(moving(make_rope()), human())
        with pytest.raises(InputError, match=r"the character's skeleton cannot be retargeted; .*MtexRetargetAPI"):
            retarget(moving(human()), make_rope())

    def test_ropes_follow_by_pairs(self):
        clip, target = moving(make_rope()), make_rope(("P", "P/Q", "P/Q/R"), along=(0.0, 0.6, 0.8))
        moved = retarget(clip, target, pairs=[("P", "A"), ("Q", "B"), ("R", "C")])
        for upper, lower, own, below in (("A", "B", "P", "Q"), ("B", "C", "Q", "R")):
            assert angle_apart(direction(moved, own, below), direction(clip, upper, lower)) < 1e-9

    def test_a_humanoid_can_drive_a_rope(self):
        clip, target = moving(human()), make_rope()
        moved = retarget(clip, target, pairs=[("A", "left.upperArm"), ("B", "left.foreArm"), ("C", "left.hand")])
        for upper, lower, own, below in (("upperArm", "foreArm", "A", "B"), ("foreArm", "hand", "B", "C")):
            wanted = direction(clip, f"left.{upper}", f"left.{lower}")
            assert angle_apart(direction(moved, own, below), wanted) < 1e-9

    def test_a_rope_drives_the_arm_it_is_paired_with_and_nothing_else(self):
        pairs = [("left.upperArm", "A"), ("left.foreArm", "B"), ("left.hand", "C")]
        moved = retarget(moving(make_rope()), human(), pairs=pairs)
        assert_at_rest(moved, "hips")
        assert_at_rest(moved, "right.foreArm")
        clip = moving(make_rope())
        assert angle_apart(direction(moved, "left.upperArm", "left.foreArm"), direction(clip, "A", "B")) < 1e-9


def body_of(skeleton):
    anatomy = find_anatomy(skeleton)
    return measure_body(skeleton, anatomy), anatomy


class TestBodies:
    @pytest.mark.parametrize("degrees", [-70.0, 0.0, 45.0, 80.0])
    def test_a_standing_body_is_upright_wherever_its_arms_are(self, degrees):
        body, _ = body_of(human(lowered(HUMAN, degrees), seed=1))
        assert body.is_upright
        np.testing.assert_allclose(quaternion.rotate(body.frame, np.eye(3)), np.eye(3), atol=1e-12)
        assert body.lowest == pytest.approx(0.02)

    @pytest.mark.parametrize(("axis", "degrees"), [(X, -90.0), (X, 90.0), (Z, 90.0), (X, 180.0)])
    def test_a_body_that_rests_lying_is_brought_upright(self, axis, degrees):
        turn = quaternion.exp(np.radians(degrees) * axis)
        body, _ = body_of(human(turn=turn, seed=2))
        assert not body.is_upright
        np.testing.assert_allclose(quaternion.rotate(body.standing, Y), Y, atol=1e-9)
        np.testing.assert_allclose(
            quaternion.rotate(body.frame, np.eye(3)), quaternion.rotate(turn, np.eye(3)), atol=1e-9
        )
        assert body.lowest == pytest.approx(0.02 if degrees != 180.0 else -0.02, abs=0.05)

    def test_a_body_on_its_back_is_driven_to_stand(self):
        lying = human(turn=quaternion.exp(np.radians(-90.0) * X), seed=2)
        clip = moving(human())
        moved = retarget(clip, lying)
        for upper, lower in AIMED:
            assert angle_apart(direction(moved, upper, lower), direction(clip, upper, lower)) < 1e-6
        back = retarget(moved, human())
        assert angle_apart(direction(back, "hips", "left.thigh"), direction(clip, "hips", "left.thigh")) < 1e-9

    def test_a_body_that_leans_a_little_leans_on(self):
        body, _ = body_of(human(turn=quaternion.exp(np.radians(15.0) * X)))
        assert body.is_upright

    def test_a_body_may_face_anywhere(self):
        turn = quaternion.exp(np.radians(130.0) * Y)
        body, _ = body_of(human(turn=turn))
        assert quaternion.angle_between(body.frame, turn) < 1e-7

    def test_legs_alone_are_a_body(self):
        legs = {
            "Hips": ("", (0.0, 0.9, 0.0)),
            "@UpLeg": ("Hips", (0.09, 0.9, 0.0)),
            "@Leg": ("@UpLeg", (0.09, 0.5, 0.0)),
            "@Foot": ("@Leg", (0.09, 0.1, 0.0)),
        }
        skeleton = rename_joints(human(legs), lambda _, name: name.replace("left", "Left").replace("right", "Right"))
        assert body_of(skeleton)[0].is_upright
        clip = moving(skeleton)
        assert_same_motion(retarget(clip, skeleton), clip)

    def test_a_rest_pose_that_says_nothing_is_taken_as_it_is(self):
        heap = human({name: (above, (0.0, place[1], 0.0)) for name, (above, place) in HUMAN.items()})
        body, _ = body_of(heap)
        np.testing.assert_allclose(quaternion.rotate(body.frame, np.eye(3)), np.eye(3), atol=1e-12)


class TestFloors:
    @pytest.mark.parametrize(
        ("height", "ground"),
        [(0.0, 0.0), (3.0, 3.02), (-3.0, -2.98), (0.1, 0.0), (-0.95, 0.0)],
        ids=["on zero", "above", "below", "nearly on zero", "hips at the origin"],
    )
    def test_by_the_rest_pose(self, height, ground):
        skeleton = human(origin=(0.0, height, 0.0))
        body, anatomy = body_of(skeleton)
        assert rest_ground(skeleton, anatomy, body) == pytest.approx(ground)

    @pytest.mark.parametrize(("height", "ground"), [(0.0, 0.0), (0.95, 0.0), (0.1, -0.93)])
    def test_by_where_the_feet_of_a_motion_get_to(self, height, ground):
        """A rig whose hips rest at the origin, and a motion in which they are so high."""
        skeleton = human(origin=(0.0, -0.95, 0.0))
        body, anatomy = body_of(skeleton)
        still = rest_clip(skeleton, frames=20)
        clip = animate(
            skeleton, np.tile([1.0, 0.0, 0.0, 0.0], (20, len(still.joints), 1)), np.tile([0.0, height, 0.0], (20, 1))
        )
        expected = -0.93 if height < 0.5 else ground
        assert estimate_ground(clip, anatomy, body) == pytest.approx(expected)

    def test_a_few_frames_below_the_floor_do_not_count(self):
        skeleton = human(origin=(0.0, -0.95, 0.0))
        body, anatomy = body_of(skeleton)
        places = np.tile([0.0, 0.95, 0.0], (200, 1))
        places[17] -= (0.0, 5.0, 0.0)
        still = np.tile([1.0, 0.0, 0.0, 0.0], (200, len(skeleton.joints), 1))
        assert estimate_ground(animate(skeleton, still, places), anatomy, body) == 0.0

    def test_feet_that_rest_a_little_above_zero_stand_on_it(self):
        """The joint of the toes is above the sole; whichever way the floor is told, it is the same."""
        skeleton = human(size=100.0)
        body, anatomy = body_of(skeleton)
        assert body.lowest == pytest.approx(2.0)
        assert estimate_ground(rest_clip(skeleton), anatomy, body) == rest_ground(skeleton, anatomy, body) == 0.0

    def test_without_feet_the_floor_is_zero(self):
        skeleton = human(leave_out=("left.foot", "right.foot", "left.toes", "right.toes"))
        body, anatomy = body_of(skeleton)
        assert body.lowest == estimate_ground(rest_clip(skeleton), anatomy, body) == 0.0
        assert rest_ground(skeleton, anatomy, body) == 0.0
        clip = moving(skeleton)
        assert_same_motion(retarget(clip, skeleton), clip)

    def test_from_floor_to_floor(self):
        """A capture whose hips rest at the origin stands on zero, a character where its rest pose or motion does."""
        source, target = human(origin=(0.0, -0.95, 0.0)), human(size=2.0, origin=(0.0, 7.0, 0.0), seed=1)
        heights = 0.95 + np.array([0.0, 0.1, -0.2])
        still = np.tile([1.0, 0.0, 0.0, 0.0], (3, len(source.joints), 1))
        clip = animate(source, still, heights[:, None] * Y)
        for onto in (target, rest_clip(target)):
            places, _ = in_space(retarget(clip, onto))
            np.testing.assert_allclose(places[:, 0, 1] - 7.04, 2.0 * heights)

    @pytest.mark.parametrize("left_out", [(), ("left.shin", "right.shin")])
    def test_legs_are_measured_from_thigh_to_ankle(self, left_out):
        source, target = human(), human(size=1.7)
        pairs = [Pair(name, "") for name in left_out]
        assert map_joints(source, target, pairs).scale == pytest.approx(1.7)

    def test_without_legs_to_measure_the_trunk_is(self):
        anatomy = find_anatomy(human())
        trunk = type(anatomy)("mixed", {part: anatomy.parts[part] for part in ("hips", "neck")})
        assert measure_scale(human(), trunk, human(size=3.0), trunk) == pytest.approx(3.0)
        rope = type(anatomy)("pairs", {"hips": 0})
        assert measure_scale(make_rope(), rope, human(), anatomy) == 1.0


class TestOddMotion:
    def test_a_frame_in_which_a_bone_vanishes_spoils_no_other(self):
        clip, target = moving(human()), human(lowered(HUMAN, 40.0), seed=1)
        translations = np.array(clip.translations)
        translations[2, index_of(clip.skeleton, "left.foreArm")] = 0.0
        whole, mended = retarget(clip, target), retarget(replace(clip, translations=translations), target)
        assert np.isfinite(mended.rotations).all()
        np.testing.assert_array_equal(mended.rotations[[0, 1, 3]], whole.rotations[[0, 1, 3]])

    def test_joints_without_length_are_turned_all_the_same(self):
        """Captures begin legs and trunk with joints that lie on the hips."""
        body = {
            "hips": HUMAN["hips"],
            "low": ("hips", HUMAN["hips"][1]),
            "lower": ("low", HUMAN["hips"][1]),
            **HUMAN,
            "spine": ("lower", HUMAN["spine"][1]),
        }
        for source, target in (
            (human(body), human(seed=1)),
            (human(), human(body, seed=1)),
            (human(body), human(body)),
        ):
            moved = retarget(moving(source), target)
            assert np.isfinite(moved.rotations).all()
            assert_turned_alike(moved, "hips", moving(source), "hips")

    def test_quaternions_do_not_flip_from_frame_to_frame(self):
        skeleton = human()
        angles = np.linspace(0.0, 4.0 * np.pi, 60)
        turns = np.tile(quaternion.exp(angles[:, None] * Y)[:, None], (1, len(skeleton.joints), 1))
        clip = animate(skeleton, turns, np.tile(skeleton.rest_positions[0], (60, 1)))
        signs = np.where(np.arange(60) % 3, 1.0, -1.0)[:, None, None]
        moved = retarget(replace(clip, rotations=signs * clip.rotations), human(seed=1))
        assert (np.sum(moved.rotations[1:] * moved.rotations[:-1], axis=-1) > 0.0).all()


class TestFitting:
    def test_a_take_of_the_characters_own_skeleton_is_left_as_it_is(self):
        skeleton = human(seed=1)
        take, sketch = moving(skeleton, 1), moving(skeleton, 2)
        fitted = fit_take(take, sketch)
        assert fitted.clip is take
        assert fitted.joint_map is None

    @pytest.mark.parametrize("options", [{"seed": 1}, {"size": 2.5}, {"origin": (0.0, -0.95, 0.0)}])
    def test_so_is_one_of_the_same_names_and_rest_pose(self, options):
        take = moving(human(**options))
        assert fit_take(take, moving(human())).clip is take

    def test_and_one_that_lacks_joints(self):
        take = moving(human(leave_out=("left.toes", "right.toes", "left.hand")))
        assert fit_take(take, moving(human())).clip is take

    def test_one_whose_arms_rest_lower_is_retargeted(self):
        take = moving(human(lowered(HUMAN, 45.0)))
        fitted = fit_take(take, moving(human(seed=1)))
        assert fitted.joint_map is not None
        assert set(fitted.clip.joints) == set(human().joints)
        for upper, lower in AIMED:
            assert angle_apart(direction(take, upper, lower), direction(fitted.clip, upper, lower)) < 1e-9

    @pytest.mark.parametrize(("degrees", "is_same"), [(1.5, True), (2.5, False)])
    def test_a_little_is_as_good_as_nothing(self, degrees, is_same):
        take = moving(human(lowered(HUMAN, degrees)))
        assert (fit_take(take, moving(human())).clip is take) == is_same

    def test_one_of_other_names_has_the_joints_that_map(self):
        source = rename_joints(human(), lambda index, _: f"bone_{index}")
        target = human({**HUMAN, **TAIL}, seed=1)
        fitted = fit_take(moving(source), moving(target))
        assert {last(joint) for joint in target.joints} - {last(joint) for joint in fitted.clip.joints} == set(TAIL)
        assert fitted.joint_map.anatomies[0].convention == "hierarchy"

    def test_one_of_the_same_names_that_rests_lying_is_retargeted(self):
        take = moving(human(turn=quaternion.exp(np.radians(-90.0) * X)))
        assert fit_take(take, moving(human())).joint_map is not None

    def test_pairs_make_a_take_of_ones_own_another(self):
        skeleton = human()
        take = moving(skeleton)
        fitted = fit_take(take, moving(skeleton, 1), [Pair("head", "neck")])
        assert_turned_alike(fitted.clip, "head", take, "neck")

    def test_what_is_no_humanoid_goes_by_names(self):
        take = moving(make_rope())
        assert fit_take(take, moving(human())).clip is take
        assert fit_take(take, moving(make_rope())).clip is take
        fitted = fit_take(take, moving(make_rope(("P", "P/Q"))), [Pair("P", "A"), Pair("Q", "C")])
        assert fitted.clip.joints == ("P", "P/Q")

    def test_takes_of_one_skeleton_share_a_map(self):
        source, sketch = human(lowered(HUMAN, 45.0)), moving(human())
        maps = [fit_take(moving(source, seed), sketch).joint_map for seed in (1, 2)]
        assert maps[0] is maps[1]


def test_the_public_function_is_this_one():
    assert mtex_usd.constraints.retarget is retarget


def test_pairs_may_be_tuples_or_pairs():
    clip, target = moving(human()), human(seed=1)
    both = [retarget(clip, target, pairs=[pair]) for pair in (("head", "neck"), Pair("head", "neck"))]
    np.testing.assert_array_equal(both[0].rotations, both[1].rotations)


def test_weights_of_a_joint_sum_to_one():
    body = {
        "hips": HUMAN["hips"],
        "s1": ("hips", (0.0, 1.0, 0.0)),
        "s2": ("s1", (0.0, 1.1, 0.0)),
        "s3": ("s2", (0.0, 1.2, 0.0)),
        **{name: place for name, place in HUMAN.items() if name not in {"hips", "spine", "chest"}},
        "neck": ("s3", HUMAN["neck"][1]),
        "@.clavicle": ("s3", HUMAN["@.clavicle"][1]),
    }
    for source, target in ((human(), human(body)), (human(body), human())):
        for by in map_joints(source, target).mapped.values():
            assert sum(by.values()) == pytest.approx(1.0, abs=2e-3)
            assert len(by) <= 2


def test_random_turns_are_no_rest():
    """What most tests above move by is worth the name."""
    assert quaternion.log(random_turns(np.random.default_rng(0), 5, 3)).any(axis=-1).all()
