"""The parts of every real skeleton, written out by hand: by name, and again by shape with the names taken away.

``{}`` stands for either side. A joint is given by the end of its path, as much as it takes to tell it from others.
"""

from functools import cache

import numpy as np
import pytest
from pxr import Usd

from mtex_usd.formats.amc import read_amc
from mtex_usd.formats.bvh import read_bvh
from mtex_usd.formats.gltf import read_gltf
from mtex_usd.motion.anatomy import find_anatomy
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.usd.clip_io import ClipReader
from mtex_usd.usd.names import build_joint_paths
from tests.anatomy_support import permute_siblings, rename_joints

MOTION_BUILDER_LIMBS = {
    "clavicle": "{}Shoulder",
    "upperArm": "{}Arm",
    "foreArm": "{}ForeArm",
    "hand": "{}Hand",
    "thigh": "{}UpLeg",
    "shin": "{}Leg",
    "foot": "{}Foot",
    "toes": "{}ToeBase",
}
FINGERS = {
    "thumb1": "{}HandThumb1",
    "thumb2": "{}HandThumb2",
    "thumb3": "{}HandThumb3",
    "index1": "{}HandIndex1",
    "index2": "{}HandIndex2",
    "index3": "{}HandIndex3",
    "middle1": "{}HandMiddle1",
    "middle2": "{}HandMiddle2",
    "middle3": "{}HandMiddle3",
    "ring1": "{}HandRing1",
    "ring2": "{}HandRing2",
    "ring3": "{}HandRing3",
    "pinky1": "{}HandPinky1",
    "pinky2": "{}HandPinky2",
    "pinky3": "{}HandPinky3",
}
ACCLAIM = {
    "clavicle": "{}clavicle",
    "upperArm": "{}humerus",
    "foreArm": "{}radius",
    "hand": "{}wrist",
    "thigh": "{}femur",
    "shin": "{}tibia",
    "foot": "{}foot",
    "toes": "{}toes",
    "thumb1": "{}thumb",
}
JOINTS = {
    "clavicle": "{}Collar",
    "upperArm": "{}Shoulder",
    "foreArm": "{}Elbow",
    "hand": "{}Wrist",
    "thigh": "{}Hip",
    "shin": "{}Knee",
    "foot": "{}Ankle",
    "toes": "{}Toe",
}
BIOVISION = {
    "clavicle": "{}Collar",
    "upperArm": "{}UpArm",
    "foreArm": "{}LowArm",
    "hand": "{}Hand",
    "thigh": "{}UpLeg",
    "shin": "{}LowLeg",
    "foot": "{}Foot",
}
PIXAR = {
    "clavicle": "{}Shldr",
    "upperArm": "{}Arm",
    "foreArm": "{}Elbow",
    "hand": "{}Hand",
    "thumb1": "{}Hand/Thumb",
    "thumb2": "{}Hand/Thumb/Mid",
    "thumb3": "{}Hand/Thumb/Mid/Tip",
    "index1": "{}Hand/Index",
    "index2": "{}Hand/Index/Mid",
    "index3": "{}Hand/Index/Mid/Tip",
    "middle1": "{}Hand/Middle",
    "middle2": "{}Hand/Middle/Mid",
    "middle3": "{}Hand/Middle/Mid/Tip",
    "ring1": "{}Hand/Ring",
    "ring2": "{}Hand/Ring/Mid",
    "ring3": "{}Hand/Ring/Mid/Tip",
    "pinky1": "{}Hand/Pinky",
    "pinky2": "{}Hand/Pinky/Mid",
    "pinky3": "{}Hand/Pinky/Mid/Tip",
    "thigh": "{}Leg",
    "shin": "{}Knee",
    "foot": "{}Foot",
    "toes": "{}Toes",
}
RIGGED_LEGS = {"thigh": "leg_joint_{}_1", "shin": "leg_joint_{}_2", "foot": "leg_joint_{}_3", "toes": "leg_joint_{}_5"}


def both(limbs, left, right):
    """Write the parts of both sides."""
    sides = {"left": left, "right": right}
    return {f"{side}.{part}": joint.format(name) for side, name in sides.items() for part, joint in limbs.items()}


def trunk(hips, chest, neck, head):
    return {"hips": hips, "chest": chest, "neck": neck, "head": head}


RELEASE = {
    **trunk("Hips", "Spine1", "Neck", "Head"),
    **both(MOTION_BUILDER_LIMBS, "Left", "Right"),
    **{"left.index1": "LeftHandIndex1", "right.index1": "RightHandIndex1"},
    **{"left.thumb1": "LThumb", "right.thumb1": "RThumb"},
}
AMC = {**trunk("root", "thorax", "lowerneck", "head"), **both(ACCLAIM, "l", "r")}
GENO = {**trunk("Hips", "Spine3", "Neck", "Head"), **both(MOTION_BUILDER_LIMBS | FINGERS, "Left", "Right")}
HIK = {
    **trunk("Fight_Hips", "Fight_Spine3", "Fight_Neck", "Fight_Head"),
    **both(MOTION_BUILDER_LIMBS | FINGERS, "Fight_Left", "Fight_Right"),
    "right.foot": "Fight_s_genrig_RightFoot",
}
CESIUM = {
    **trunk("Skeleton_torso_joint_1", "torso_joint_3", "Skeleton_neck_joint_1", "Skeleton_neck_joint_2"),
    **both(RIGGED_LEGS, "L", "R"),
    "left.upperArm": "Skeleton_arm_joint_L__4_",
    "left.foreArm": "Skeleton_arm_joint_L__3_",
    "left.hand": "Skeleton_arm_joint_L__2_",
    "right.upperArm": "Skeleton_arm_joint_R",
    "right.foreArm": "Skeleton_arm_joint_R__2_",
    "right.hand": "Skeleton_arm_joint_R__3_",
}
FIGURE = {
    **trunk("torso_joint_1", "torso_joint_3", "neck_joint_1", "neck_joint_2"),
    **both(RIGGED_LEGS, "L", "R"),
    **both({"upperArm": "arm_joint_{}_1", "foreArm": "arm_joint_{}_2", "hand": "arm_joint_{}_3"}, "L", "R"),
}

HUMANOIDS = {
    "cmu_bvh/07/07_01.bvh": ("MotionBuilder", RELEASE),
    "cmu_bvh/05/05_01.bvh": ("MotionBuilder", RELEASE),
    "cmu_bvh/09/09_01.bvh": ("MotionBuilder", RELEASE),
    "cmu_bvh/01/01_01.bvh": ("MotionBuilder", RELEASE),
    "cmu_bvh/91_from_amc/91_01.bvh": ("CMU", AMC),
    "cmu_asfamc/91/91_01.amc": ("CMU", AMC),
    "cmu_asfamc/01/01_01.amc": ("CMU", AMC),
    "bvh_dialects/biovision_example_2frames.bvh": (
        "Biovision",
        {**trunk("Hips", "Chest", "Neck", "Head"), **both(BIOVISION, "Left", "Right")},
    ),
    "bvh_dialects/cmu1_31j_ZYX+ZXY_30fps.bvh": (
        "Biovision",
        {
            **trunk("Hips", "Chest2", "lowerneck", "Head"),
            **both(JOINTS, "Left", "Right"),
            **{"left.thumb1": "LThumb", "right.thumb1": "RThumb"},
        },
    ),
    "bvh_dialects/fair1_27j_119.88fps.bvh": (
        "MotionBuilder",
        {
            **trunk("Hips", "Spine3", "Neck", "Head"),
            **both(MOTION_BUILDER_LIMBS | {"thumb1": "{}HandThumb1"}, "Left", "Right"),
        },
    ),
    "bvh_dialects/geno_75j_poschannels_alljoints_crlf.bvh": ("MotionBuilder", GENO),
    "bvh_dialects/pybvh_23j_YXZ_crlf.bvh": (
        "Biovision",
        {**trunk("Hips", "Chest4", "Neck", "Head"), **both(JOINTS, "Left", "Right")},
    ),
    "bvh_dialects/pybvh_24j_mixedorders.bvh": (
        "MotionBuilder",
        {**trunk("Hips", "Spine3", "Neck", "Head"), **both(MOTION_BUILDER_LIMBS, "Left", "Right")},
    ),
    "bvh_dialects/pybvh_60j_mixedorders_crlf.bvh": (
        "MotionBuilder",
        {**GENO, "left.toes": "LeftForeFoot", "right.toes": "RightForeFoot"},
    ),
    "gltf/CesiumMan.glb": ("hierarchy", CESIUM),
    "usd/CesiumMan.usdz": ("hierarchy", CESIUM),
    "usd/RiggedFigure.usdz": ("hierarchy", FIGURE),
    "usd/HIK_Export.usda": ("MotionBuilder", HIK),
    "usd_pixar_tests/skeleton.usda": (
        "mixed",
        {**trunk("Hips", "UpChest", "Neck", "Head"), **both(PIXAR, "L", "R")},
    ),
}
# The first two are humans, but of one leg or none.
NO_HUMANOIDS = (
    "bvh_dialects/rotation_first_root.bvh",
    "bvh_dialects/full_precision_frame_time.bvh",
    "bvh_dialects/bvh_anim_simple.bvh",
    "bvh_dialects/fairmotion_noendsite_XYZ.bvh",
    "gltf/03_skinned_cylinder.gltf",
    "gltf/simple_skin.gltf",
    "usd/RiggedSimple.usdz",
    "usd/framerate.usda",
    "usd/skelCube.usda",
    "usd/skinCluster.usda",
    "usd_pixar_tests/usdview_arm.usda",
    "usd_pixar_tests/twoBends.usda",
)
READERS = {".bvh": read_bvh, ".amc": read_amc, ".glb": lambda path: read_gltf(path)[0]}
READERS[".gltf"] = READERS[".glb"]


@cache
def load_skeleton(data_dir, name):
    """The first skeleton of a file."""
    path = data_dir / name
    return _load_recorded(READERS[path.suffix](path)) if path.suffix in READERS else _load_usd(path)


def _load_recorded(recording):
    joints = recording.joint_paths or build_joint_paths(recording.names, recording.parents)
    rest = recording.rest
    if rest is None:
        rest = np.tile(np.eye(4), (len(joints), 1, 1))
        rest[:, 3, :3] = recording.offsets
    return Skeleton(joints=tuple(joints), rest=rest)


def _load_usd(path):
    stage = Usd.Stage.Open(str(path))
    prims = [prim for prim in stage.Traverse() if prim.GetTypeName() == "Skeleton"]
    return ClipReader(stage).read_skeleton(prims[0])


def expected_joints(skeleton, table):
    """Joint index by part; every entry fits one joint alone."""
    found = {}
    for part, end in table.items():
        (found[part],) = [i for i, joint in enumerate(skeleton.joints) if f"/{joint}".endswith(f"/{end}")]
    return found


def body_of(parts):
    """The parts without fingers, which the shape does not tell."""
    return {part: joint for part, joint in parts.items() if not part[-1].isdigit()}


@pytest.mark.parametrize("name", HUMANOIDS)
def test_every_part_of_the_real_skeletons(data_dir, name):
    skeleton = load_skeleton(data_dir, name)
    convention, table = HUMANOIDS[name]
    anatomy = find_anatomy(skeleton)
    assert anatomy.parts == expected_joints(skeleton, table)
    assert anatomy.convention == convention


@pytest.mark.parametrize("name", HUMANOIDS)
def test_the_same_parts_without_names(data_dir, name):
    skeleton = load_skeleton(data_dir, name)
    anatomy = find_anatomy(rename_joints(skeleton, lambda index, _: f"joint_{index}"))
    assert anatomy.convention == "hierarchy"
    assert anatomy.parts == body_of(expected_joints(skeleton, HUMANOIDS[name][1]))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", HUMANOIDS)
def test_the_same_parts_in_any_order_of_siblings(data_dir, name, seed):
    skeleton = load_skeleton(data_dir, name)
    permuted, order = permute_siblings(skeleton, np.random.default_rng(seed))
    for rig in (permuted, rename_joints(permuted, lambda index, _: f"joint_{order[index]}")):
        found = {part: order[joint] for part, joint in find_anatomy(rig).parts.items()}
        expected = expected_joints(skeleton, HUMANOIDS[name][1])
        assert found == (body_of(expected) if rig is not permuted else expected)


@pytest.mark.parametrize("name", NO_HUMANOIDS)
def test_what_has_no_two_legs_is_no_humanoid(data_dir, name):
    assert find_anatomy(load_skeleton(data_dir, name)) is None
