"""The parts of a humanoid by the names of common rigs, however prefixed, and by the shape alone."""

import re

import numpy as np
import pytest

from mtex_usd.motion import quaternion
from mtex_usd.motion.anatomy import PARTS, SIDES, Anatomy, find_anatomy
from tests.anatomy_conventions import CONVENTIONS
from tests.anatomy_support import BODY, QUADRUPED, SPINE, place_body, read_hierarchy, rename_joints
from tests.synthetic import make_skeleton

ON_ITS_BACK = quaternion.exp(np.array([-np.pi / 2.0, 0.0, 0.0]))


def name_parts(skeleton):
    """Joint path by part, as the tables have it."""
    anatomy = find_anatomy(skeleton)
    assert anatomy is not None
    return {part: skeleton.joints[joint] for part, joint in anatomy.parts.items()}


def last_parts(skeleton):
    """Last joint name by part."""
    return {part: joint.rpartition("/")[2] for part, joint in name_parts(skeleton).items()}


def convention_of(skeleton):
    anatomy = find_anatomy(skeleton)
    assert anatomy is not None
    return anatomy.convention


def indices(skeleton):
    """The parts of a skeleton from :func:`place_body`, whose joints are called by them."""
    names = [joint.rpartition("/")[2] for joint in skeleton.joints]
    return {name: index for index, name in enumerate(names) if name not in SPINE}


def nameless(skeleton):
    return rename_joints(skeleton, lambda index, _: f"joint_{index}")


def test_parts_are_listed_once_and_for_both_sides() -> None:
    assert len(set(PARTS)) == len(PARTS) == 4 + 2 * (1 + 3 + 4 + 15)
    assert all(part.replace("left.", "right.") in PARTS for part in PARTS)
    assert SIDES == ("left", "right")


@pytest.mark.parametrize("rig", CONVENTIONS)
def test_the_documented_names_of_common_rigs(rig: str) -> None:
    convention, text = CONVENTIONS[rig]
    skeleton, expected = read_hierarchy(text)
    assert name_parts(skeleton) == expected
    assert convention_of(skeleton) == convention


@pytest.mark.parametrize("rig", CONVENTIONS)
@pytest.mark.parametrize(
    "rename",
    [
        lambda _, name: f"Fight_{name}",
        lambda _, name: f"Armature_s_genrig_{name}",
        lambda _, name: f"hero:{name}",
        lambda _, name: f"{name}_jnt",
        lambda _, name: f"{name}_joint_bind",
        lambda index, name: f"{name}_0{index}",
        lambda _, name: re.sub(r"\W", "_", name),
        lambda _, name: f"{name}.001",
    ],
    ids=["prefix", "long prefix", "namespace", "suffix", "two suffixes", "numbered", "USD names", "Blender copy"],
)
def test_prefixes_and_noise_make_no_difference(rig: str, rename) -> None:
    skeleton, expected = read_hierarchy(CONVENTIONS[rig][1])
    renamed = rename_joints(skeleton, rename)
    anatomy = find_anatomy(renamed)
    assert anatomy is not None
    assert {part: skeleton.joints[joint] for part, joint in anatomy.parts.items()} == expected


@pytest.mark.parametrize("rig", ["Unreal", "VRM 1.0", "SMPL-X", "Apple", "Rigify", "Acclaim", "Character Creator"])
def test_capitals_make_no_difference(rig: str) -> None:
    skeleton, expected = read_hierarchy(CONVENTIONS[rig][1])
    anatomy = find_anatomy(rename_joints(skeleton, lambda _, name: name.upper()))
    assert anatomy is not None
    assert {part: skeleton.joints[joint] for part, joint in anatomy.parts.items()} == expected


@pytest.mark.parametrize(
    ("left", "right"), [("Left", "Right"), ("left_", "right_"), ("L_", "R_"), ("L.", "R."), ("l", "r")]
)
def test_sides_as_prefix(left: str, right: str) -> None:
    skeleton, expected = read_hierarchy(CONVENTIONS["Xsens"][1])
    renamed = rename_joints(skeleton, lambda _, name: name.replace("Left", left).replace("Right", right))
    anatomy = find_anatomy(renamed)
    assert anatomy is not None
    assert {part: skeleton.joints[joint] for part, joint in anatomy.parts.items()} == expected


@pytest.mark.parametrize(
    ("left", "right"),
    [("L", "R"), ("_l", "_r"), (".L", ".R"), ("_L_", "_R_"), ("_left", "_right"), (" Left", " Right")],
)
def test_sides_as_suffix(left: str, right: str) -> None:
    def move(index: int, name: str) -> str:
        side = {"Left": left, "Righ": right}.get(name[:4], "")
        return name.removeprefix("Left").removeprefix("Right") + side

    skeleton, expected = read_hierarchy(CONVENTIONS["Xsens"][1])
    anatomy = find_anatomy(rename_joints(skeleton, move))
    assert anatomy is not None
    assert {part: skeleton.joints[joint] for part, joint in anatomy.parts.items()} == expected


def test_names_are_believed_only_where_they_agree_with_the_hierarchy() -> None:
    # A prop in the hand is called as a leg; the arm's own joints hang the wrong way round.
    text = """
    hips = hips
      thigh_l = left.thigh
        calf_l = left.shin
          foot_l = left.foot
      thigh_r = right.thigh
        calf_r = right.shin
      foot_r
      spine
        hand_l
          lowerarm_l
            upperarm_l
        head = head
    """
    skeleton, expected = read_hierarchy(text)
    found = name_parts(skeleton)
    assert {part: found.get(part) for part in expected} == expected
    assert "right.foot" not in found
    assert not any("Arm" in part or "hand" in part for part in found)


def test_a_modifier_behind_the_side_is_another_joint() -> None:
    skeleton, _ = read_hierarchy("root\n LeftFrontLeg\n  LeftFrontFoot\n RightFrontLeg\n  RightFrontFoot")
    assert find_anatomy(skeleton) is None


@pytest.mark.parametrize("seed", [None, 1])
@pytest.mark.parametrize(
    "leave_out",
    [
        (),
        ("left.knuckle", "right.knuckle"),
        ("left.clavicle", "right.clavicle"),
        ("left.toes", "right.toes"),
        ("neck",),
        ("spine",),
    ],
    ids=lambda names: " ".join(names) or "whole",
)
def test_the_shape_alone_tells_the_parts(leave_out: tuple[str, ...], seed: int | None) -> None:
    skeleton = place_body(leave_out=leave_out, seed=seed)
    anatomy = find_anatomy(nameless(skeleton))
    assert anatomy is not None
    assert anatomy.convention == "hierarchy"
    assert anatomy.parts == indices(skeleton)


def test_a_body_on_its_back_and_away_from_the_origin() -> None:
    skeleton = place_body(turn=ON_ITS_BACK, origin=(3.0, -2.0, 5.0), size=100.0)
    anatomy = find_anatomy(nameless(skeleton))
    assert anatomy is not None
    assert anatomy.parts == indices(skeleton)


def test_arms_straight_up_and_splayed_legs() -> None:
    posed = dict(BODY)
    posed["@.upperArm"] = ("@.clavicle", (0.03, 1.55, -0.02))
    posed["@.foreArm"] = ("@.upperArm", (0.03, 1.83, -0.02))
    posed["@.hand"] = ("@.foreArm", (0.03, 2.08, -0.02))
    posed["@.knuckle"] = ("@.hand", (0.03, 2.18, -0.02))
    posed["@.shin"] = ("@.thigh", (0.23, 0.51, 0.01))
    posed["@.foot"] = ("@.shin", (0.37, 0.12, -0.02))
    posed["@.toes"] = ("@.foot", (0.39, 0.06, 0.12))
    skeleton = place_body(posed)
    anatomy = find_anatomy(nameless(skeleton))
    assert anatomy is not None
    assert anatomy.parts == indices(skeleton)


def test_leaves_at_the_origin_are_ignored() -> None:
    # Short upper arms: beside them the way from the wrist to the origin would be the longer bone.
    broken = BODY | {"@.foreArm": ("@.upperArm", (0.38, 1.42, -0.02))}
    for part in ("head", "@.hand", "@.toes"):
        broken[f"{part}_end"] = (part, (0.0, 0.0, 0.0))
    skeleton = place_body(broken)
    anatomy = find_anatomy(nameless(skeleton))
    assert anatomy is not None
    assert anatomy.parts == {part: joint for part, joint in indices(skeleton).items() if not part.endswith("_end")}


def test_eyes_and_a_skull_do_not_hide_the_head() -> None:
    with_eyes = BODY | {"@.eye": ("head", (0.03, 1.65, 0.1)), "jaw": ("head", (0.0, 1.57, 0.05))}
    with_skull = BODY | {"skull": ("head", (0.0, 1.78, 0.02))}
    for body in (with_eyes, with_skull):
        skeleton = place_body(body)
        anatomy = find_anatomy(nameless(skeleton))
        assert anatomy is not None
        assert skeleton.joints[anatomy.parts["head"]].endswith("/head")


def test_ears_are_no_arms() -> None:
    ears = {part: where for part, where in BODY.items() if "rm" not in part and "clavicle" not in part}
    ears = {part: where for part, where in ears.items() if "hand" not in part and "knuckle" not in part}
    ears |= {"@.ear1": ("head", (0.06, 1.7, 0.0)), "@.ear2": ("@.ear1", (0.08, 1.75, 0.0))}
    ears |= {"@.ear3": ("@.ear2", (0.09, 1.8, 0.0))}
    assert find_anatomy(nameless(place_body(ears))) is None


@pytest.mark.parametrize(("left", "right"), [("L", "R"), ("left", "right")])
def test_sides_in_nameless_joints_are_believed_over_the_toes(left: str, right: str) -> None:
    # The names are swapped against the body on purpose: only they can be what was asked.
    skeleton = place_body()
    swapped = {"left": right, "right": left}

    def keep_side(index: int, name: str) -> str:
        side = name.partition(".")[0]
        return f"joint_{swapped[side]}_{index}" if side in swapped else f"joint_{index}"

    anatomy = find_anatomy(rename_joints(skeleton, keep_side))
    assert anatomy is not None
    expected = indices(skeleton)
    assert anatomy.parts["left.foot"] == expected["right.foot"]
    assert anatomy.parts["right.hand"] == expected["left.hand"]


def test_few_joints_with_names_are_enough() -> None:
    assert last_parts(make_skeleton()) == {
        "hips": "Hips",
        "chest": "Spine",
        "head": "Head",
        "left.upperArm": "LeftArm",
        "left.foreArm": "LeftForeArm",
        "left.thigh": "LeftUpLeg",
        "left.shin": "LeftLeg",
        "right.upperArm": "RightArm",
        "right.foreArm": "RightForeArm",
        "right.thigh": "RightUpLeg",
        "right.shin": "RightLeg",
    }


@pytest.mark.parametrize(
    "rename",
    [
        lambda index, _: f"joint_{index}",
        lambda _, name: re.sub(r"(left|right)\.(\w+)", r"DEF-\2.\1", name),
        lambda _, name: name,
    ],
    ids=["nameless", "Rigify", "sided"],
)
def test_a_quadruped_is_no_humanoid(rename) -> None:
    assert find_anatomy(rename_joints(place_body(QUADRUPED), rename)) is None


@pytest.mark.parametrize(
    "text",
    [
        "joint",
        "a\n b\n  c\n   d",
        "base\n finger1\n  finger2\n   finger3\n thumb1\n  thumb2\n   thumb3",
        "Shoulder\n Elbow\n  Hand",
        "Hips\n Spine\n  Head\n LeftUpLeg\n  LeftLeg\n   LeftFoot",
        "a\nb\nc",
        "LeftUpLeg\n LeftLeg\n  RightUpLeg\n   RightLeg",
        "LeftUpLeg\n LeftLeg\nRightUpLeg\n RightLeg",
        "___\n 12\n  ...",
    ],
    ids=["one", "chain", "hand", "arm", "one leg", "roots", "leg on leg", "two roots", "no words"],
)
def test_what_is_no_humanoid_has_no_anatomy(text: str) -> None:
    skeleton, _ = read_hierarchy(text)
    assert find_anatomy(skeleton) is None


def test_a_pose_of_no_extent_has_no_anatomy_by_shape() -> None:
    skeleton = nameless(place_body(size=0.0))
    assert find_anatomy(skeleton) is None


def test_the_anatomy_is_found_once_and_cannot_be_changed() -> None:
    skeleton = place_body()
    anatomy = find_anatomy(skeleton)
    assert isinstance(anatomy, Anatomy)
    assert find_anatomy(skeleton) is anatomy
    with pytest.raises(TypeError, match="does not support item assignment"):
        anatomy.parts["hips"] = 0  # type: ignore[index]
