"""How joint names are taken apart."""

import pytest

from mtex_usd.motion.anatomy.words import read_names, side_of, split_words, strip_numbering


def readings(name: str) -> set[tuple[str, str]]:
    return {(reading.side, reading.key) for reading in read_names(name)}


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("LeftUpLeg", ["left", "up", "leg"]),
        ("LHipJoint", ["l", "hip", "joint"]),
        ("lThighBend", ["l", "thigh", "bend"]),
        ("LEFTUPLEG", ["left", "upleg"]),
        ("rightforearm", ["right", "forearm"]),
        ("mixamorig:LeftHandThumb1", ["mixamorig", "left", "hand", "thumb", "1"]),
        ("J_Bip_L_UpperLeg", ["j", "bip", "l", "upper", "leg"]),
        ("Bip01 L Finger0", ["bip", "01", "l", "finger", "0"]),
        ("DEF-upper_arm.L.001", ["def", "upper", "arm", "l", "001"]),
        ("___", []),
    ],
)
def test_words(name: str, words: list[str]) -> None:
    assert split_words(name) == words


@pytest.mark.parametrize(
    ("name", "known_by"),
    [
        ("Fight_s_genrig_RightFoot", ("right", "foot")),
        ("Bip01 L Thigh", ("left", "thigh")),
        ("lfemur", ("left", "femur")),
        ("upper_arm.L", ("left", "upperarm")),
        ("thigh_jnt_r", ("right", "thigh")),
        ("thigh_r_jnt", ("right", "thigh")),
        ("left_upLeg_joint", ("left", "upleg")),
        ("DEF-thigh.L.001", ("left", "thigh")),
        ("hero_Head_bind", ("", "head")),
        ("spine.006", ("", "spine006")),
    ],
)
def test_what_a_joint_may_be_known_by(name: str, known_by: tuple[str, str]) -> None:
    assert known_by in readings(name)


@pytest.mark.parametrize(
    "name", ["ik_foot_l", "thigh_fk.L", "MCH-thigh.L", "LeftFrontLeg", "LeftArmRoll", "HeadTop_End"]
)
def test_controls_and_helpers_are_no_part(name: str) -> None:
    keys = {key for _, key in readings(name)}
    assert keys.isdisjoint({"foot", "thigh", "leg", "arm", "head"})


def test_the_plainer_name_is_the_likelier() -> None:
    costs = {name: min(r.cost for r in read_names(name) if r.key == "hip") for name in ("LeftHip", "LHipJoint")}
    assert costs["LeftHip"] < costs["LHipJoint"]


@pytest.mark.parametrize(
    ("name", "side"),
    [
        ("leg_joint_L_1", "left"),
        ("Skeleton_arm_joint_R__2_", "right"),
        ("joint_12", ""),
        ("CC_Base_L_Thigh", "left"),
        ("L_RightHand", "right"),
        ("lowerback", ""),
    ],
)
def test_sides(name: str, side: str) -> None:
    assert side_of(name) == side


def test_a_running_number_is_taken_off_all_names_or_none() -> None:
    numbered = [f"{name}_0{number}" for number, name in enumerate(["Hips", "Spine", "Head", "LeftArm", "index_01_l"])]
    assert strip_numbering(numbered) == ["Hips", "Spine", "Head", "LeftArm", "index_01_l"]
    some = ["root", "spine_01", "spine_02", "spine_03", "head"]
    assert strip_numbering(some) == some
    repeated = ["arm_1", "arm_2", "leg_1", "leg_2"]
    assert strip_numbering(repeated) == repeated
