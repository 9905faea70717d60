"""Contacts on motions made for it: one point that stands, moves and stands again, and what is refused."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mtex_usd.constraints.contacts import Effector, detect_contacts, estimate_ground, find_effectors
from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from tests.synthetic import walk

POINT = (Effector(name="point", joint=0, offset=np.array([0.0, -2.0, 0.0])),)


def point_clip(places, rate=120.0, joints=("Ball",)):
    """One joint at places [F, 3], skeleton units of a centimetre."""
    frames = len(places)
    return Clip(
        skeleton=Skeleton(joints=joints, rest=np.tile(np.eye(4), (len(joints), 1, 1))),
        rate=rate,
        rotations=np.tile([1.0, 0.0, 0.0, 0.0], (frames, len(joints), 1)),
        translations=np.asarray(places, dtype=float)[:, None].repeat(len(joints), axis=1),
        scales=np.ones((frames, len(joints), 3)),
        name="ball",
    )


def hop(frames=60, *, height=30.0, length=80.0):
    """Stand for as many frames, hop, stand again: places [3 * frames, 3]."""
    phase = np.clip((np.arange(3 * frames) - frames) / frames, 0.0, 1.0)
    ease = phase * phase * (3.0 - 2.0 * phase)
    return np.stack([length * ease, 2.0 + 4.0 * height * ease * (1.0 - ease), np.zeros(3 * frames)], axis=1)


def test_a_hop_has_two_contacts_at_the_places_it_stands():
    first, second = detect_contacts(point_clip(hop()), effectors=POINT)
    assert (first.first, second.last) == (0, 179)
    assert 58 <= first.last <= 68
    assert 112 <= second.first <= 122
    np.testing.assert_allclose(first.point, [0.0, 0.0, 0.0], atol=0.05)
    np.testing.assert_allclose(second.point, [80.0, 0.0, 0.0], atol=0.05)


def test_sliding_fast_along_the_floor_is_no_contact():
    places = hop()
    places[:, 1] = 2.0
    contacts = detect_contacts(point_clip(places), effectors=POINT)
    assert contacts[0].last < 75
    assert len(contacts) == 2


def test_hovering_still_above_the_floor_is_no_contact():
    places = hop()
    places[100:, 1] = np.maximum(places[100:, 1], 25.0)
    assert [c.first for c in detect_contacts(point_clip(places), effectors=POINT)] == [0]


def test_a_given_ground_decides_what_is_high():
    clip = point_clip(hop())
    assert detect_contacts(clip, effectors=POINT, ground=-20.0) == ()
    assert len(detect_contacts(clip, effectors=POINT, ground=0.0)) == 2


def test_a_short_doubt_does_not_break_a_contact():
    places = hop()
    places[30:33, 0] += 3.0
    assert len(detect_contacts(point_clip(places), effectors=POINT)) == 2


def test_short_contacts_are_dropped():
    assert detect_contacts(point_clip(hop()), effectors=POINT, shortest_s=1.0) == ()


def test_the_plant_ignores_a_few_frames_elsewhere():
    places = np.tile([5.0, 2.0, 0.0], (120, 1))
    places[:6, 0] += np.linspace(2.0, 0.0, 6)
    (contact,) = detect_contacts(point_clip(places), effectors=POINT)
    np.testing.assert_allclose(contact.point, [5.0, 0.0, 0.0], atol=0.01)


def test_one_frame_stands_where_it_is():
    contacts = detect_contacts(point_clip(hop()[:1], rate=5.0), effectors=POINT)
    assert [(c.first, c.last) for c in contacts] == [(0, 0)]


def test_ground_leaves_out_what_never_comes_down():
    places = hop()
    clip = point_clip(places, joints=("Ball", "Kite"))
    kite = Effector(name="kite", joint=1, offset=np.array([0.0, 70.0, 0.0]))
    assert estimate_ground(clip, POINT) == pytest.approx(0.0, abs=0.1)
    assert estimate_ground(clip, (*POINT, kite)) == pytest.approx(0.0, abs=0.1)
    assert {c.effector.name for c in detect_contacts(clip, effectors=(*POINT, kite))} == {"point"}


def foot_skeleton(*, tilt=0.0):
    """Two legs with feet; at rest the toes are `tilt` lower than flat, centimetres."""
    names, positions = [], []
    for side, x in (("Left", 10.0), ("Right", -10.0)):
        leg = f"Hips/{side}UpLeg", f"Hips/{side}UpLeg/{side}Leg", f"Hips/{side}UpLeg/{side}Leg/{side}Foot"
        names += [*leg, f"{leg[-1]}/{side}ToeBase"]
        positions += [(x, -5.0, 0.0), (0.0, -42.0, 0.0), (0.0, -41.0, 0.0), (0.0, -6.0 - tilt, 13.0)]
    names, positions = ["Hips", *names], [(0.0, 96.0, 0.0), *positions]
    rest = np.tile(np.eye(4), (len(names), 1, 1))
    rest[:, 3, :3] = positions
    return Skeleton(joints=tuple(names), rest=rest)


def test_heels_are_below_and_behind_the_ankles():
    skeleton = foot_skeleton()
    effectors = find_effectors(skeleton)
    assert [e.name for e in effectors] == ["left.heel", "left.toes", "right.heel", "right.toes"]
    assert [skeleton.joints[e.joint].rpartition("/")[2] for e in effectors[:2]] == ["LeftFoot", "LeftToeBase"]
    np.testing.assert_allclose(effectors[0].offset, [0.0, -6.0, -3.9], atol=1e-9)
    np.testing.assert_allclose(effectors[1].offset, 0.0)


def standing_clip(skeleton, angle):
    """Stand for 60 frames with the feet turned up by an angle about x, radians."""
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (60, 9, 1))
    feet = [i for i, joint in enumerate(skeleton.joints) if joint.endswith("Foot")]
    rotations[:, feet] = [np.cos(angle / 2.0), -np.sin(angle / 2.0), 0.0, 0.0]
    return Clip(
        skeleton=skeleton,
        rate=24.0,
        rotations=rotations,
        translations=np.tile(skeleton.rest_translations, (60, 1, 1)),
        scales=np.ones((60, 9, 3)),
    )


def test_a_foot_that_stands_tells_how_its_sole_is():
    """The rest pose points the toes down; where the character stands the foot is turned back to be flat."""
    skeleton = foot_skeleton(tilt=5.0)
    clip = standing_clip(skeleton, np.arctan2(11.0, 13.0) - np.arctan2(6.0, 13.0))
    heel, toes, *_ = find_effectors(skeleton, clip=clip)
    positions, orientations = skeleton.world_pose(clip.rotations, clip.translations)
    below = Rotation.from_quat(orientations[0, heel.joint], scalar_first=True).apply(heel.offset)
    assert positions[0, heel.joint, 1] + below[1] == pytest.approx(positions[0, toes.joint, 1])


def test_a_foot_that_kneels_tells_nothing():
    skeleton = foot_skeleton()
    kneeling = find_effectors(skeleton, clip=standing_clip(skeleton, -np.pi / 2.0))
    np.testing.assert_array_equal(kneeling[0].offset, find_effectors(skeleton)[0].offset)


def test_skeletons_without_feet_are_refused():
    with pytest.raises(InputError, match=r"no feet found on the skeleton.*found Ball.*Give the effectors"):
        detect_contacts(point_clip(hop()))


def test_no_effectors_are_refused():
    with pytest.raises(InputError, match="no effectors"):
        detect_contacts(walk(10), effectors=())
    with pytest.raises(InputError, match="no effectors"):
        estimate_ground(walk(10), ())


@pytest.mark.parametrize("name", ["height_m", "speed_m_s", "shortest_s"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.inf, np.nan])
def test_bad_thresholds_are_refused(name, value):
    with pytest.raises(InputError, match=f"bad {name}.*above 0"):
        detect_contacts(point_clip(hop()), effectors=POINT, **{name: value})


def test_a_bad_ground_is_refused():
    with pytest.raises(InputError, match="bad ground"):
        detect_contacts(point_clip(hop()), effectors=POINT, ground=np.nan)
