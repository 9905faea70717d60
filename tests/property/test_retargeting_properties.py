"""What holds of every retargeting, whatever the bodies and the motion, and that it is what its slow twin does."""

import itertools
from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mtex_usd.constraints.retargeting import Pair, map_joints, retarget
from mtex_usd.constraints.retargeting.body import Body, shortest_turn
from mtex_usd.constraints.retargeting.sections import Chain, Section
from mtex_usd.constraints.retargeting.transfer import Stance, turn_section
from mtex_usd.motion import quaternion
from mtex_usd.motion.correspondence import keep_joints
from mtex_usd.motion.skeleton import Skeleton
from tests.anatomy_support import rename_joints
from tests.oracle import retargeting as oracle
from tests.retargeting_support import (
    AIMED,
    HUMAN,
    STICK,
    angle_apart,
    animate,
    assert_same_motion,
    direction,
    human,
    in_space,
    index_of,
    last,
    lower_turns,
    lowered,
    move,
    random_turns,
    rest_clip,
    stretched,
    turn_space,
    with_legs,
)

SEEDS = st.integers(0, 2**32 - 1)
SIZES = st.floats(0.01, 100.0)
FEW = settings(max_examples=15)
NONE = np.array([1.0, 0.0, 0.0, 0.0])
Z = np.array([0.0, 0.0, 1.0])


def axis_turns():
    """All turns that take coordinate axes to coordinate axes."""
    signs = [np.array(each)[:, None] for each in itertools.product((1.0, -1.0), repeat=3)]
    matrices = [np.eye(3)[list(order)] * sign for order in itertools.permutations(range(3)) for sign in signs]
    return [Rotation.from_matrix(m).as_quat(scalar_first=True) for m in matrices if np.linalg.det(m) > 0.0]


TURNS = axis_turns()


def two_humans(seed):
    """A take and a character of different builds, with their joints oriented at random."""
    rng = np.random.default_rng(seed)
    source, target = (human(stretched(HUMAN, rng), seed=int(rng.integers(2**32))) for _ in range(2))
    return rng, source, target


@FEW
@given(seed=SEEDS, size=SIZES)
def test_onto_the_same_skeleton_it_is_the_same_motion(seed, size):
    rng = np.random.default_rng(seed)
    skeleton = human(stretched(HUMAN, rng), size=size, seed=seed % 7)
    clip = move(skeleton, rng)
    for onto in (skeleton, clip):
        same = retarget(clip, onto)
        assert quaternion.angle_between(same.rotations, clip.rotations).max() < 1e-9
        np.testing.assert_allclose(same.translations, clip.translations, atol=1e-9 * size)
        assert same.skeleton is skeleton


@FEW
@given(seed=SEEDS, turn=st.sampled_from(TURNS), size=SIZES)
def test_neither_up_axis_nor_units_of_the_take_change_anything(seed, turn, size):
    rng, source, target = two_humans(seed)
    clip = move(source, rng)
    assert_same_motion(retarget(turn_space(clip, turn, size), target), retarget(clip, target), tolerance=1e-7)


@FEW
@given(seed=SEEDS, turn=st.sampled_from(TURNS), size=SIZES)
def test_the_character_turns_with_its_space(seed, turn, size):
    rng, source, target = two_humans(seed)
    clip = move(source, rng)
    turned = turn_space(rest_clip(target), turn, size).skeleton
    expected = turn_space(retarget(clip, target), turn, size)
    places, rotations = in_space(retarget(clip, turned))
    expected_places, expected_rotations = in_space(expected)
    np.testing.assert_allclose(places, expected_places, atol=1e-7 * size)
    assert quaternion.angle_between(rotations, expected_rotations).max() < 1e-7


@FEW
@given(seed=SEEDS, orientations=SEEDS)
def test_joint_orientations_of_the_take_change_nothing(seed, orientations):
    rng = np.random.default_rng(seed)
    body, target = stretched(HUMAN, rng), human(stretched(HUMAN, rng), seed=3)
    turns, places = random_turns(rng, 4, len(target.joints)), rng.normal(size=(4, 3))
    plain, oriented = (animate(human(body, seed=seed), turns, places) for seed in (None, orientations))
    assert_same_motion(retarget(plain, target), retarget(oriented, target), tolerance=1e-7)


@FEW
@given(seed=SEEDS, degrees=st.floats(-40.0, 85.0))
def test_where_the_arms_of_the_take_rest_changes_nothing(seed, degrees):
    rng = np.random.default_rng(seed)
    raised, low = human(seed=1), human(lowered(HUMAN, degrees), seed=2)
    turns, places = random_turns(rng, 4, len(raised.joints)), rng.normal(size=(4, 3))
    plain, other = animate(raised, turns, places), animate(low, lower_turns(low, turns, degrees), places)
    for target in (human(size=0.3), human(lowered(HUMAN, 45.0), seed=3)):
        assert_same_motion(retarget(plain, target), retarget(other, target), tolerance=1e-7)
    # Arms that do not rest in one plane with the take's may roll a little otherwise; they lie along them even so.
    target = human(stretched(HUMAN, rng))
    np.testing.assert_allclose(*(in_space(retarget(clip, target))[0] for clip in (plain, other)), atol=1e-7)


@FEW
@given(seed=SEEDS, rename_target=st.booleans())
def test_names_change_nothing(seed, rename_target):
    rng = np.random.default_rng(seed)
    # Of too odd a build, and without names the parts are not to be told.
    source, target = (human(stretched(HUMAN, rng, share=0.05), seed=seed % 5) for _ in range(2))
    clip = move(source, rng)
    renamed = rename_joints(source, lambda index, _: f"bone_{index}")
    other = rename_joints(target, lambda index, _: f"b{index:02d}") if rename_target else target
    moved = retarget(replace(clip, skeleton=renamed), other)
    assert_same_motion(moved, retarget(clip, target), tolerance=1e-9)


@FEW
@given(seed=SEEDS, degrees=st.floats(0.0, 80.0))
def test_aimed_bones_follow_the_take(seed, degrees):
    rng = np.random.default_rng(seed)
    clip = move(human(stretched(HUMAN, rng), seed=1), rng, size=1.5)
    moved = retarget(clip, human(lowered(stretched(HUMAN, rng), degrees), seed=2))
    for upper, lower in AIMED:
        assert angle_apart(direction(clip, upper, lower), direction(moved, upper, lower)) < 1e-6, upper


@FEW
@given(seed=SEEDS)
def test_there_and_back_the_bones_point_as_before(seed):
    rng, source, target = two_humans(seed)
    clip = move(source, rng)
    back = retarget(retarget(clip, target), source)
    for upper, lower in AIMED:
        assert angle_apart(direction(clip, upper, lower), direction(back, upper, lower)) < 1e-9, upper
    _, turns = in_space(clip)
    _, turned_back = in_space(back)
    for name in ("hips", "head", "left.foot", "right.toes"):
        joint = index_of(source, name)
        assert quaternion.angle_between(turns[:, joint], turned_back[:, joint]).max() < 1e-9


@FEW
@given(seed=SEEDS, longer=st.floats(0.5, 2.0))
def test_the_hips_travel_as_far_as_the_legs_are_long(seed, longer):
    rng = np.random.default_rng(seed)
    source, target = human(seed=1), human(with_legs(HUMAN, longer), seed=2)
    clip = move(source, rng)
    moved = retarget(clip, target)
    way, own_way = (np.diff(in_space(c)[0][:, 0], axis=0) for c in (clip, moved))
    np.testing.assert_allclose(own_way, longer * way, atol=1e-9)
    np.testing.assert_allclose(map_joints(source, target).scale, longer)


@FEW
@given(seed=SEEDS)
def test_the_character_keeps_its_bones(seed):
    rng, source, target = two_humans(seed)
    moved = retarget(move(source, rng), target)
    below = [joint for joint, parent in enumerate(target.parents) if parent >= 0]
    np.testing.assert_array_equal(
        moved.translations[:, below], np.tile(target.rest_translations[below], (moved.frame_count, 1, 1))
    )
    np.testing.assert_array_equal(moved.scales, 1.0)
    assert (moved.rate, moved.start, moved.name) == (24.0, 0.0, "/Take")


@FEW
@given(seed=SEEDS)
def test_joints_nothing_maps_to_stay_at_rest(seed):
    rng = np.random.default_rng(seed)
    body = {
        **HUMAN,
        "tail": ("hips", (0.0, 0.9, -0.2)),
        "tip": ("tail", (0.0, 0.8, -0.4)),
        "@.twist": ("@.foreArm", (0.6, 1.42, -0.02)),
    }
    source, target = human(stretched(HUMAN, rng)), human(body, seed=4)
    joint_map = map_joints(source, target)
    assert {last(joint) for joint in joint_map.unmapped} == {"tail", "tip", "left.twist", "right.twist"}
    moved = retarget(move(source, rng), target)
    for joint in map(target.joints.index, joint_map.unmapped):
        expected = np.tile(target.rest_rotations[joint], (moved.frame_count, 1))
        assert quaternion.angle_between(moved.rotations[:, joint], expected).max() < 1e-12


def with_spine(places):
    """A body whose trunk has joints at these heights between hips and neck, the last one its chest."""
    body = {name: place for name, place in HUMAN.items() if name not in {"spine", "chest"}}
    above = "hips"
    for number, height in enumerate(places, start=1):
        body[f"spine{number}"] = (above, (0.0, height, 0.0))
        above = f"spine{number}"
    ordered = {name: (parent if parent != "chest" else above, place) for name, (parent, place) in body.items()}
    return {**{n: p for n, p in ordered.items() if n == "hips" or n.startswith("spine")}, **ordered}


def bent(skeleton, degrees, frames=3):
    """A trunk that bends to the side as evenly as its joints can, to `degrees` at the neck."""
    neck = index_of(skeleton, "neck")
    base, top = skeleton.rest_positions[0][1], skeleton.rest_positions[neck][1]
    heights = skeleton.rest_positions[:, 1]
    trunk = skeleton.chain(neck)
    shares = np.ones(len(skeleton.joints))
    for joint, child in itertools.pairwise(trunk):
        shares[joint] = ((heights[joint] + heights[child]) / 2.0 - base) / (top - base)
    shares[0] = 0.0
    angles = np.radians(degrees) * np.linspace(0.0, 1.0, frames)[:, None] * shares
    turns = quaternion.exp(angles[..., None] * np.array([0.0, 0.0, 1.0]))
    return animate(skeleton, turns, np.tile(skeleton.rest_positions[0], (frames, 1)))


@FEW
@given(counts=st.tuples(st.integers(2, 7), st.integers(2, 7)), degrees=st.floats(-60.0, 60.0))
def test_trunks_bend_alike_with_any_numbers_of_joints(counts, degrees):
    few, many = (human(with_spine(0.95 + 0.52 * np.arange(1, count + 1) / (count + 1))) for count in counts)
    clip = bent(few, degrees)
    moved = retarget(clip, many)
    ends = [direction(c, "hips", "neck") for c in (clip, moved)]
    assert angle_apart(*ends) < np.radians(0.12 * abs(degrees) + 0.1)
    _, turned = in_space(moved)
    neck = index_of(many, "neck")
    np.testing.assert_allclose(
        quaternion.twist(turned[:, neck], np.array([0.0, 0.0, 1.0])), np.radians(degrees) * np.array([0.0, 0.5, 1.0])
    )
    steps = np.diff(quaternion.twist(turned[-1, many.chain(neck)], np.array([0.0, 0.0, 1.0])))
    assert (steps * np.sign(degrees) >= -1e-9).all()


@FEW
@given(seed=SEEDS, share=st.floats(0.1, 0.9))
def test_a_stiff_joint_more_in_the_takes_trunk_changes_no_direction(seed, share):
    rng = np.random.default_rng(seed)
    heights = [1.05, 1.15, 1.30]
    more = sorted([*heights, (1.0 - share) * 1.15 + share * 1.30])
    source, finer, target = (
        human(with_spine(heights)),
        human(with_spine(more)),
        human(with_spine([1.08, 1.2, 1.26, 1.4])),
    )
    clip = move(source, rng, size=0.3)
    _, world = in_space(clip)
    kept = [0, 1, 2, 2, *range(3, len(source.joints))]
    moved, other = (
        retarget(animate(skeleton, turns, clip.translations[:, 0]), target)
        for skeleton, turns in ((source, world), (finer, world[:, kept]))
    )
    trunk = ["spine1", "spine2", "spine3", "spine4", "neck"]
    for upper, lower in itertools.pairwise(trunk):
        assert angle_apart(direction(moved, upper, lower), direction(other, upper, lower)) < 1e-9


@FEW
@given(seed=SEEDS, counts=st.tuples(st.integers(1, 5), st.integers(1, 5)), keeps_first=st.booleans())
def test_a_chain_is_turned_as_by_the_twin(seed, counts, keeps_first):
    rng = np.random.default_rng(seed)
    source, target = (_chain_skeleton(rng, count) for count in counts)
    clip = move(source, rng, size=0.4)
    positions, world = in_space(clip)
    turns = quaternion.multiply(world, quaternion.conjugate(source.rest_orientations))
    bodies = tuple(Body(frame=NONE, upright=NONE, lowest=0.0) for _ in range(2))
    stance = Stance(source=source, target=target, bodies=bodies)
    chains = [Chain(tuple(range(count)), count) for count in counts]
    section = Section("trunk", *chains, "aim", keeps_first=keeps_first)
    found = turn_section(section, stance, turns, positions, lean=NONE)
    for frame in range(clip.frame_count):
        expected = oracle.bend_chain(
            list(source.rest_positions),
            list(target.rest_positions),
            [Rotation.from_quat(turns[frame, joint], scalar_first=True) for joint in range(counts[0])],
            list(positions[frame]),
            keeps_first=keeps_first,
        )
        for joint, rotation in enumerate(expected):
            own = Rotation.from_quat(target.rest_orientations[joint], scalar_first=True)
            got = Rotation.from_quat(found[frame, joint], scalar_first=True)
            # Near half a turn the shortest way loses half its digits.
            assert ((rotation * own).inv() * got).magnitude() < 1e-6


def _chain_skeleton(rng, bones):
    """A chain that rises, its joints oriented at random; one joint more than bones."""
    names = tuple("/".join(f"j{i}" for i in range(count + 1)) for count in range(bones + 1))
    rest = np.tile(np.eye(4), (bones + 1, 1, 1))
    world = quaternion.normalize(rng.normal(size=(bones + 1, 4)))
    above = NONE
    for joint in range(bones + 1):
        back = quaternion.conjugate(above)
        rest[joint, :3, :3] = quaternion.rotate(quaternion.multiply(back, world[joint]), np.eye(3))
        offset = rng.uniform([-0.1, 0.3, -0.1], [0.1, 1.0, 0.1])
        rest[joint, 3, :3] = quaternion.rotate(back, offset)
        above = world[joint]
    return Skeleton(joints=names, rest=rest)


@FEW
@given(seed=SEEDS, degrees=st.floats(0.0, 80.0), turn=st.sampled_from(TURNS))
def test_a_pose_is_what_the_twin_gives(seed, degrees, turn):
    rng = np.random.default_rng(seed)
    source = human(stretched(STICK, rng), seed=1)
    clip = turn_space(move(source, rng), turn, 3.0)
    target = human(lowered(stretched(STICK, rng), degrees), seed=2)
    moved = retarget(clip, target)
    places, world = in_space(moved)
    rigs = [_rig(clip.skeleton, quaternion.rotate(turn, np.eye(3)).T), _rig(target, np.eye(3))]
    frames = [
        (list(map(_rotation, clip.rotations[frame])), list(clip.translations[frame]))
        for frame in range(clip.frame_count)
    ]
    floors = [_below(clip.skeleton), _below(target)]
    scale = _leg(target) / _leg(clip.skeleton)
    poses = oracle.retarget(*rigs, _bones(clip.skeleton, target), frames, hips=(0, 0), scale=scale, floors=floors)
    for frame, (rotations, expected) in enumerate(poses):
        np.testing.assert_allclose(places[frame], expected, atol=1e-7)
        got = Rotation.from_quat(world[frame], scalar_first=True)
        assert (Rotation.concatenate(rotations).inv() * got).magnitude().max() < 1e-7


def _rotation(q):
    return Rotation.from_quat(q, scalar_first=True)


def _rig(skeleton, axes):
    rotations = list(map(_rotation, skeleton.rest_rotations))
    return oracle.Rig(skeleton.parents.tolist(), rotations, list(skeleton.rest_translations), axes)


def _below(skeleton):
    """The place on the floor, which is at zero, below the hips at rest."""
    hips = skeleton.rest_positions[0]
    return hips - (hips @ skeleton.up) * skeleton.up


def _leg(skeleton):
    length = 0.0
    for side in ("left", "right"):
        hip, knee, ankle = (
            skeleton.rest_positions[index_of(skeleton, f"{side}.{part}")] for part in ("thigh", "shin", "foot")
        )
        length += np.linalg.norm(knee - hip) + np.linalg.norm(ankle - knee)
    return length


def _bones(source, target):
    """What turns what on the stick figure, written out: aimed bones, the hand that follows, the rest that turns."""
    aimed = {}
    for upper, lower in AIMED:
        (joint, child), (other, other_child) = (
            tuple(index_of(skeleton, name) for name in (upper, lower)) for skeleton in (target, source)
        )
        aimed[upper] = oracle.Bone(joint, other, child, other_child)
    for side in ("left", "right"):
        hand = index_of(target, f"{side}.hand"), index_of(source, f"{side}.hand")
        aimed[f"{side}.hand"] = oracle.Bone(*hand, follows=aimed[f"{side}.foreArm"])
    for name in ("hips", "head", "left.foot", "right.foot", "left.toes", "right.toes"):
        aimed[name] = oracle.Bone(index_of(target, name), index_of(source, name))
    return list(aimed.values())


@given(seed=SEEDS, near=st.sampled_from([0.0, 1e-12, 1e-9, 1e-6, 1e-3, 1.0]))
def test_the_shortest_turn_gets_there_from_anywhere(seed, near):
    rng = np.random.default_rng(seed)
    source = rng.normal(size=(5, 3))
    source /= np.linalg.norm(source, axis=-1, keepdims=True)
    wanted = -source + near * rng.normal(size=(5, 3))
    wanted /= np.linalg.norm(wanted, axis=-1, keepdims=True)
    turn = shortest_turn(source, wanted, rng.normal(size=3))
    assert angle_apart(quaternion.rotate(turn, source), wanted) < 1e-9
    assert quaternion.angle_between(turn, NONE).max() <= np.pi + 1e-9


@given(seed=SEEDS)
def test_rounding_does_not_shake_the_turn_to_what_is_opposite(seed):
    rng = np.random.default_rng(seed)
    wanted = -Z + 1e-7 * rng.normal(size=(20, 3))
    turns = shortest_turn(Z, wanted / np.linalg.norm(wanted, axis=-1, keepdims=True), np.array([0.0, 1.0, 0.3]))
    assert quaternion.angle_between(turns, turns[:1]).max() < 1e-5


@FEW
@given(seed=SEEDS, count=st.integers(1, 12))
def test_joints_kept_move_as_before(seed, count):
    rng = np.random.default_rng(seed)
    clip = move(human(seed=5), rng, size=2.0)
    kept = sorted(rng.choice(len(clip.joints), size=count, replace=False).tolist())
    part = keep_joints(clip, kept)
    assert part.joints == tuple(clip.joints[joint] for joint in kept)
    (places, turns), (expected, expected_turns) = in_space(part), in_space(clip)
    np.testing.assert_allclose(places, expected[:, kept], atol=1e-9)
    assert quaternion.angle_between(turns, expected_turns[:, kept]).max() < 1e-9
    np.testing.assert_allclose(part.skeleton.rest_positions, clip.skeleton.rest_positions[kept], atol=1e-9)
    turned = quaternion.angle_between(part.skeleton.rest_orientations, clip.skeleton.rest_orientations[kept])
    assert turned.max() < 1e-6


@FEW
@given(seed=SEEDS)
def test_pairs_that_say_what_is_recognised_change_nothing(seed):
    rng, source, target = two_humans(seed)
    clip = move(source, rng)
    joint_map = map_joints(source, target)
    single = [(joint, next(iter(by))) for joint, by in joint_map.mapped.items() if len(by) == 1]
    pairs = [
        Pair(*pair) for pair in single if last(pair[0]) == last(pair[1]) and last(pair[0]) not in {"spine", "chest"}
    ]
    assert_same_motion(retarget(clip, target, pairs=pairs), retarget(clip, target), tolerance=1e-9)
