"""Real takes on real characters of other skeletons: bones, height and sides follow, and the command takes them.

Places, swings and facings are read here from joints named by hand.
"""

import json
from functools import cache

import numpy as np
import pytest
from pxr import Usd

import mtex_usd
from mtex_usd.cli.usdmtex import main
from mtex_usd.constraints.retargeting import retarget
from mtex_usd.motion.timing import resample_clip
from tests.benchmarks.retargeting import RATE, drop_first, load_character, load_takes, score_pair
from tests.quality.retarget_shots import SKETCH, author_recipe, write_leg_sketch
from tests.usd.playback import animation_arrays, select_variant

AMC = {"hips": "root", "neck": "lowerneck", "head": "head"}
AMC |= {
    f"{side}.{part}": f"{side[0]}{joint}"
    for side in ("left", "right")
    for part, joint in {
        "upperArm": "humerus",
        "foreArm": "radius",
        "hand": "wrist",
        "thigh": "femur",
        "shin": "tibia",
        "foot": "foot",
    }.items()
}
HIK = {
    "hips": "Fight_Hips",
    "left.upperArm": "Fight_LeftArm",
    "left.foreArm": "Fight_LeftForeArm",
    "left.hand": "Fight_LeftHand",
    "left.thigh": "Fight_LeftUpLeg",
    "left.shin": "Fight_LeftLeg",
    "left.foot": "Fight_LeftFoot",
}
HIK |= {part.replace("left", "right"): joint.replace("Left", "Right") for part, joint in HIK.items()}
HIK["right.foot"] = "Fight_s_genrig_RightFoot"
CESIUM = {
    "hips": "Skeleton_torso_joint_1",
    "left.upperArm": "Skeleton_arm_joint_L__4_",
    "left.foreArm": "Skeleton_arm_joint_L__3_",
    "left.hand": "Skeleton_arm_joint_L__2_",
    "right.upperArm": "Skeleton_arm_joint_R",
    "right.foreArm": "Skeleton_arm_joint_R__2_",
    "right.hand": "Skeleton_arm_joint_R__3_",
}
FIGURE = {"hips": "torso_joint_1"}
for letter, side in (("L", "left"), ("R", "right")):
    legs = {f"{side}.{part}": f"leg_joint_{letter}_{i}" for i, part in enumerate(("thigh", "shin", "foot"), start=1)}
    CESIUM |= legs
    FIGURE |= legs
    FIGURE |= {f"{side}.{p}": f"arm_joint_{letter}_{i}" for i, p in enumerate(("upperArm", "foreArm", "hand"), start=1)}

CHARACTERS = {"HIK_Export.usda": HIK, "CesiumMan.usdz": CESIUM, "RiggedFigure.usdz": FIGURE}
WALK = "cmu_asfamc/91/91_01.amc"
LIMBS = [
    (f"{side}.{upper}", f"{side}.{lower}")
    for side in ("left", "right")
    for upper, lower in (("upperArm", "foreArm"), ("foreArm", "hand"), ("thigh", "shin"), ("shin", "foot"))
]

on_every_character = pytest.mark.parametrize("name", CHARACTERS)


@cache
def walk_on(data_dir, name):
    """The walk, and what it is on a character."""
    (take,) = load_takes(data_dir, (WALK,))
    return take, score_pair(take, load_character(data_dir / "usd" / name))


class Body:
    """Places of the joints of a motion, [F, 3] by part, in metres or what else the rig is in."""

    def __init__(self, clip, names):
        self.clip, self.up = clip, clip.skeleton.up
        lasts = [joint.rpartition("/")[2] for joint in clip.joints]
        self.index = {
            part: next(i for i, last in enumerate(lasts) if last.endswith(name)) for part, name in names.items()
        }
        places, _ = clip.skeleton.world_pose(clip.rotations, clip.translations)
        self.places = {part: places[:, joint] for part, joint in self.index.items()}
        self.rest = {part: clip.skeleton.rest_positions[joint] for part, joint in self.index.items()}

    def bone(self, upper, lower):
        vectors = self.places[lower] - self.places[upper]
        return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)

    def left(self):
        """Unit vectors to the left, level."""
        return self._level(self.places["left.thigh"] - self.places["right.thigh"])

    def front(self):
        return np.cross(self.left(), self.up)

    def _level(self, vectors):
        level = vectors - (vectors @ self.up)[:, None] * self.up
        return level / np.linalg.norm(level, axis=-1, keepdims=True)

    def leg(self):
        """Length of a leg from thigh to ankle at rest, mean of both."""
        bones = [
            np.linalg.norm(self.rest[f"{side}.{b}"] - self.rest[f"{side}.{a}"])
            for side in ("left", "right")
            for a, b in (("thigh", "shin"), ("shin", "foot"))
        ]
        return sum(bones) / 2.0

    def height(self):
        return self.places["hips"] @ self.up

    def swing(self, upper, lower):
        """How far forward a bone swings from hanging, degrees; its mean is what it is about."""
        bone = self.bone(upper, lower)
        return np.degrees(np.arctan2(np.sum(bone * self.front(), axis=-1), -(bone @ self.up)))

    def in_body(self, vectors):
        """Components to the left, up and front."""
        return np.stack(
            [np.sum(vectors * axis, axis=-1) for axis in (self.left(), self.up, self.front())],
            axis=-1,
        )


def bodies(data_dir, name):
    take, score = walk_on(data_dir, name)
    return Body(take, AMC), Body(score.motion, CHARACTERS[name])


@on_every_character
def test_every_aimed_bone_has_the_direction_of_the_takes(data_dir, name):
    _, score = walk_on(data_dir, name)
    assert score.aimed.shape[1] == {"HIK_Export.usda": 15, "CesiumMan.usdz": 11, "RiggedFigure.usdz": 11}[name]
    assert score.aimed.mean() < 1e-6
    assert score.aimed.max() < 1e-5


@on_every_character
def test_angles_between_bones_of_limbs_are_the_takes(data_dir, name):
    """Whatever the spaces are: an elbow bends as the take's, and arms go with legs as the take's do."""
    take, own = bodies(data_dir, name)
    bones = [np.stack([body.bone(*limb) for limb in LIMBS], axis=1) for body in (take, own)]
    cosines = [np.einsum("fai,fbi->fab", b, b) for b in bones]
    np.testing.assert_allclose(*cosines, atol=1e-9)


@on_every_character
def test_hips_keep_their_height_by_the_length_of_the_legs(data_dir, name):
    take, own = bodies(data_dir, name)
    ratio = own.leg() / take.leg()
    _, score = walk_on(data_dir, name)
    assert score.joint_map.scale == pytest.approx(ratio, rel=1e-9)
    assert score.height == pytest.approx(ratio, rel=1e-9)
    # Captures stand on zero; how high the character's own floor is stays the same throughout.
    floors = own.height() - ratio * take.height()
    np.testing.assert_allclose(floors, floors[0], atol=1e-9 * own.leg())
    assert abs(floors[0]) < 0.1 * own.leg()


@on_every_character
def test_left_stays_left(data_dir, name):
    take, own = bodies(data_dir, name)
    for part in ("hand", "foot"):
        apart = [body.in_body(body.places[f"left.{part}"] - body.places[f"right.{part}"]) for body in (take, own)]
        scaled = [a / body.leg() for a, body in zip(apart, (take, own), strict=True)]
        assert np.corrcoef(scaled[0][:, 2], scaled[1][:, 2])[0, 1] > 0.98
        on_their_sides = [(a[:, 0] > 0.0).mean() for a in apart]
        assert on_their_sides[1] > (0.99 if part == "hand" else 0.9)
        assert on_their_sides[1] == pytest.approx(on_their_sides[0], abs=0.05)


@on_every_character
def test_it_travels_the_same_way_as_it_faces(data_dir, name):
    take, own = bodies(data_dir, name)
    ways = [body.in_body(np.gradient(body.places["hips"], axis=0)) / body.leg() for body in (take, own)]
    assert ways[0][:, 2].mean() > 0.02
    np.testing.assert_allclose(np.linalg.norm(ways[0], axis=-1), np.linalg.norm(ways[1], axis=-1), atol=1e-9)
    headings = [np.degrees(np.arctan2(way[:, 0], way[:, 2])) for way in ways]
    off = (headings[1] - headings[0] + 180.0) % 360.0 - 180.0
    assert np.abs(off).mean() < 5.0


@on_every_character
def test_joints_that_nothing_moves_are_named(data_dir, name):
    _, score = walk_on(data_dir, name)
    joint_map = score.joint_map
    mapped, unmapped = set(joint_map.mapped), set(joint_map.unmapped)
    assert mapped | unmapped == set(score.motion.joints)
    assert not mapped & unmapped
    fingers = {joint for joint in score.motion.joints if "Hand" in joint.rpartition("/")[2].removesuffix("Hand")}
    assert fingers <= unmapped
    assert len(fingers) == (42 if name == "HIK_Export.usda" else 0)


def test_a_character_and_back(data_dir):
    take, score = walk_on(data_dir, "HIK_Export.usda")
    back = Body(retarget(score.motion, take.skeleton), AMC)
    first = Body(take, AMC)
    for limb in LIMBS:
        assert np.abs(back.bone(*limb) - first.bone(*limb)).max() < 1e-9
    np.testing.assert_allclose(back.places["hips"], first.places["hips"], atol=1e-9)


# Through the command -------------------------------------------------------------------------------------------------

LEGS = {
    "HIK_Export.usda": (
        "Fight_Hips",
        *(joint for part, joint in HIK.items() if part.endswith(("thigh", "shin", "foot"))),
    ),
    "CesiumMan.usdz": (
        "Skeleton_torso_joint_1",
        *(joint for part, joint in CESIUM.items() if part.endswith(("thigh", "shin", "foot"))),
    ),
}
RECIPES = {
    "HIK_Export.usda": {
        "match": ["Fight_LeftUpLeg.rx", "Fight_RightUpLeg.rx"],
        "synthesize": ["*Spine*", "Fight_Neck", "Fight_Head", "*Shoulder", "*LeftArm", "*RightArm", "*ForeArm"],
    },
    "CesiumMan.usdz": {
        "match": ["leg_joint_L_1.ry", "leg_joint_R_1.ry"],
        "synthesize": ["*torso_joint_2", "torso_joint_3", "*neck*", "*arm*"],
    },
}


@pytest.fixture(scope="module")
def takes(data_dir, tmp_path_factory):
    """The walk, imported from its AMC file."""
    library = tmp_path_factory.mktemp("takes") / "takes.usd"
    mtex_usd.import_takes([data_dir / WALK], out=library)
    return library


def write_shot(folder, data_dir, takes, name, **changes):
    """A straight walk on a character, blocked, its upper body to be found."""
    (walk,) = load_takes(data_dir, ("cmu_asfamc/91/91_02.amc",))
    shot = folder / "shot.usda"
    write_leg_sketch(shot, data_dir / "usd" / name, walk, takes, LEGS[name], RECIPES[name] | changes)
    return shot


@pytest.mark.parametrize("name", LEGS)
def test_a_leg_sketch_gets_an_upper_body(data_dir, takes, tmp_path, capsys, name):
    shot = write_shot(tmp_path, data_dir, takes, name)
    assert main([str(shot), "--paths", "2", "--json", str(tmp_path / "table.json")]) == 0
    assert "take /Takes/take_91_01 retargeted, " in capsys.readouterr().err
    (result,) = json.loads((tmp_path / "table.json").read_text())["results"]
    (retargeted,) = result["retargets"]
    assert (retargeted["takes"], retargeted["takeConvention"]) == (["/Takes/take_91_01"], "CMU")
    stage = Usd.Stage.Open(str(tmp_path / "shot.mtex.stage.usda"))
    take = Body(load_takes(data_dir, (WALK,))[0], AMC)
    for variant in ("path_01", "path_02"):
        select_variant(stage, result["model"], result["variantSet"], variant)
        _check_swings(Body(mtex_usd.read_clip(stage, f"{SKETCH}_mtex"), CHARACTERS[name]), take)
        _check_legs(stage, Usd.Stage.Open(str(shot)))


def _check_swings(own, take):
    """Arms swing about as far as the take's, against the legs as the take's do, and hang on their own sides."""
    against = [_swing_apart(body, "upperArm", "foreArm", "thigh", "shin") for body in (own, take)]
    assert against[0] < -0.5
    assert against[0] == pytest.approx(against[1], abs=0.2)
    for side in ("left", "right"):
        arm = f"{side}.upperArm", f"{side}.foreArm"
        swings, takes_swings = (body.swing(*arm) for body in (own, take))
        assert swings.std() > 4.0
        assert 0.5 < swings.std() / takes_swings.std() < 1.5
        assert np.corrcoef(swings, own.swing(f"{side}.thigh", f"{side}.shin"))[0, 1] < -0.25
        assert np.median(own.bone(*arm) @ own.up) < -0.7
    apart = own.in_body(own.places["left.hand"] - own.places["right.hand"])
    assert (apart[:, 0] > 0.0).all()


def _swing_apart(body, arm, elbow, thigh, knee):
    """How the arms' swing apart goes with the legs', as a correlation."""
    arms, legs = (
        body.swing(f"left.{upper}", f"left.{lower}") - body.swing(f"right.{upper}", f"right.{lower}")
        for upper, lower in ((arm, elbow), (thigh, knee))
    )
    return np.corrcoef(arms, legs)[0, 1]


def _check_legs(stage, source):
    """What has no role is as the animator made it, to the bit."""
    times = [0.0, 7.0, 33.0]
    joints, rotations, translations = animation_arrays(source, SKETCH, times)
    own, now_rotations, now_translations = animation_arrays(stage, f"{SKETCH}_mtex", times)
    assert own[: len(joints)] == joints
    assert len(own) > len(joints)
    np.testing.assert_array_equal(now_rotations[:, : len(joints)], rotations)
    np.testing.assert_array_equal(now_translations[:, : len(joints)], translations)


def test_a_joint_that_no_take_maps_to_is_named(data_dir, takes, tmp_path, capsys):
    shot = write_shot(tmp_path, data_dir, takes, "HIK_Export.usda", synthesize=["*LeftArm", "*LeftHandIndex1"])
    before = sorted(tmp_path.iterdir())
    assert main([str(shot)]) == 2
    message = capsys.readouterr().err
    assert "no take has all joints with a role" in message
    assert "Fight_LeftHandIndex1" in message
    assert "MtexRetargetAPI" in message
    assert "Fight_LeftArm," not in message
    assert sorted(tmp_path.iterdir()) == before


def test_the_run_of_09_restyled_from_another_skeletons_takes(data_dir, tmp_path, capsys):
    """Pullen & Bregler's otter: a finished run, its upper body anew, by takes whose joints have other names."""
    (run,) = load_takes(data_dir, ("cmu_bvh/09/09_01.bvh",))
    shot, library = tmp_path / "run.usda", tmp_path / "takes.usd"
    sketch = mtex_usd.write_clip(run, shot, "/Otter/Run")
    mtex_usd.import_takes([data_dir / "cmu_asfamc" / "91" / "91_13.amc"], out=library)
    stage = Usd.Stage.Open(str(shot))
    upper = ["LowerBack", "Spine", "Spine1", "Neck", "Neck1", "Head", "*Shoulder", "*Arm", "*ForeArm"]
    author_recipe(stage, sketch, library, {"match": ["LeftUpLeg.rx", "LeftLeg.rx"], "synthesize": upper})
    stage.Save()
    assert main([str(shot), "--json", "-", "--paths", "3"]) == 0
    captured = capsys.readouterr()
    assert "take /Takes/take_91_13 retargeted, " in captured.err
    (result,) = json.loads(captured.out)["results"]
    (retargeted,) = result["retargets"]
    assert (retargeted["takeConvention"], retargeted["convention"]) == ("CMU", "MotionBuilder")
    assert any(joint.endswith("LeftForeArm") for joint in retargeted["mapped"])
    played = Usd.Stage.Open(str(tmp_path / "run.mtex.stage.usda"))
    restyled = mtex_usd.read_clip(played, f"{sketch}_mtex")
    arms = [i for i, joint in enumerate(run.joints) if joint.endswith("ForeArm")]
    legs = [i for i, joint in enumerate(run.joints) if "UpLeg" in joint]
    assert np.abs(restyled.rotations[:, arms] - run.rotations[:, arms]).max() > 0.1
    np.testing.assert_allclose(restyled.rotations[:, legs], run.rotations[:, legs], atol=1e-6)


def test_the_benchmark_reads_takes_without_their_t_pose(data_dir):
    (take,) = load_takes(data_dir, (WALK,))
    assert take.rate == RATE
    assert drop_first(resample_clip(take, RATE), 2).frame_count == take.frame_count - 2
