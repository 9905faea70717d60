"""Mirroring: against reflected matrices, who is whose partner, planes, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mtex_usd.edit import mirror
from mtex_usd.edit.mirroring import pair_joints
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.texture.facing import measure_heading
from tests.cleaning_support import BODY, make_walk, positions
from tests.oracle import edit_filters as oracle
from tests.synthetic import HIPS, POSITIONS, make_skeleton, on_joints, skeleton_turns, turned, walk

X = np.array([1.0, 0.0, 0.0])


def other_side(joint):
    return joint.replace("Left", "*").replace("Right", "Left").replace("*", "Right")


def matrices(turns):
    return Rotation.from_quat(turns.reshape(-1, 4), scalar_first=True).as_matrix().reshape(*turns.shape[:-1], 3, 3)


@pytest.mark.parametrize("oriented", [None, 7])
def test_world_turns_and_places_are_reflected(oriented):
    clip = make_walk(30, oriented=oriented)
    mirrored = mirror(clip)
    partners = [clip.joints.index(other_side(joint)) for joint in clip.joints]
    before, after = matrices(skeleton_turns(clip)), matrices(skeleton_turns(mirrored))
    for frame in range(30):
        np.testing.assert_allclose(after[frame], oracle.mirrored_matrices(before[frame], partners, X), atol=1e-9)
    np.testing.assert_allclose(positions(mirrored), positions(clip)[:, partners] * [-1.0, 1.0, 1.0], atol=1e-9)


@pytest.mark.parametrize("plane", ["rest", "facing"])
@pytest.mark.parametrize("heading", [0.0, 130.0])
def test_twice_is_the_original(plane, heading):
    clip = turned(make_walk(20, oriented=2), heading)
    twice = mirror(mirror(clip, plane=plane), plane=plane)
    assert np.abs(np.abs(np.sum(twice.rotations * clip.rotations, axis=-1)) - 1.0).max() < 1e-12
    assert quaternion.angle_between(twice.rotations, clip.rotations).max() < 1e-12
    np.testing.assert_allclose(twice.translations, clip.translations, rtol=0.0, atol=1e-11)


def test_facing_keeps_place_and_direction_at_the_first_frame():
    clip = turned(make_walk(60), 75.0)
    mirrored = mirror(clip, plane="facing")
    np.testing.assert_allclose(positions(mirrored)[0, 0], positions(clip)[0, 0], atol=1e-9)
    before, after = measure_heading(clip, 0), measure_heading(mirrored, 0)
    np.testing.assert_allclose(after - after[0], -(before - before[0]), atol=1e-9)
    assert np.sin(after[0] - before[0]) == pytest.approx(0.0, abs=1e-9)
    assert np.cos(after[0] - before[0]) == pytest.approx(1.0)


def test_scales_go_to_the_other_side():
    clip = make_walk(5)
    scales = np.array(clip.scales)
    scales[:, clip.joints.index("Hips/LeftUpLeg")] = 2.0
    mirrored = mirror(replace(clip, scales=scales))
    assert (mirrored.scales[:, clip.joints.index("Hips/RightUpLeg")] == 2.0).all()
    assert (mirrored.scales[:, clip.joints.index("Hips/LeftUpLeg")] == 1.0).all()


def test_joints_without_names_of_parts_are_paired_by_side_words_or_by_place():
    extra = {
        f"{HIPS}/Pocket_L": (12.0, 90.0, 5.0),
        f"{HIPS}/Pocket_R": (-9.0, 80.0, 9.0),
        f"{HIPS}/tail": (0.0, 95.0, -20.0),
        f"{HIPS}/wingA": (30.0, 99.0, -5.0),
        f"{HIPS}/wingB": (-30.0, 99.5, -5.0),
        f"{HIPS}/wingA/tip1": (60.0, 99.0, -5.0),
        f"{HIPS}/wingB/tip2": (-60.0, 99.0, -5.0),
        f"{HIPS}/sword_L": (20.0, 70.0, 0.0),
    }
    where = POSITIONS | extra
    skeleton = make_skeleton(tuple(where), positions=where)
    names = [joint.rpartition("/")[2] for joint in skeleton.joints]
    partners = {names[a]: names[b] for a, b in enumerate(pair_joints(skeleton))}
    assert partners["LeftArm"] == "RightArm"
    assert partners["Pocket_L"] == "Pocket_R"
    assert partners["wingB"] == "wingA"
    assert partners["tip2"] == "tip1"
    assert partners["tail"] == "tail"
    assert partners["sword_L"] == "sword_L"
    assert partners["Hips"] == "Hips"
    assert (pair_joints(skeleton)[pair_joints(skeleton)] == np.arange(len(names))).all()


def test_a_body_that_is_not_quite_straight_walks_on_straight():
    crooked = BODY | {"Hips/LeftUpLeg": (9.0, 90.0, 0.4)}
    clip = replace(make_walk(30), skeleton=make_skeleton(tuple(crooked), positions=crooked))
    moved = mirror(clip).translations[:, 0] - clip.skeleton.rest_translations[0]
    np.testing.assert_allclose(moved, (clip.translations[:, 0] - clip.skeleton.rest_translations[0]) * [-1, 1, 1])


def test_bad_requests_are_refused():
    with pytest.raises(InputError, match="bad plane to mirror about; expected rest or facing; found 'floor'"):
        mirror(walk(5), plane="floor")
    with pytest.raises(InputError, match="the skeleton has no left and right"):
        mirror(on_joints(walk(5), (HIPS, "Hips/Spine", "Hips/Spine/Head")))
