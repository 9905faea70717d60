"""What holds of every humanoid: neither order, names, orientations nor the way it lies change its parts."""

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mtex_usd.motion import quaternion
from mtex_usd.motion.anatomy import PARTS, find_anatomy
from mtex_usd.motion.skeleton import Skeleton
from tests.anatomy_conventions import CONVENTIONS
from tests.anatomy_support import SPINE, permute_siblings, place_body, read_hierarchy, rename_joints

SEEDS = st.integers(0, 2**32 - 1)
LEFT_OUT = st.lists(st.sampled_from(("clavicle", "toes", "knuckle")), unique=True)
NAMES = st.text("abLlRr_. 0123thumbfingerleghdUpLowArm", min_size=1, max_size=12)


@given(seed=SEEDS, left_out=LEFT_OUT, rigid=st.tuples(SEEDS, st.floats(0.01, 100.0)))
def test_the_shape_tells_whichever_way_the_body_lies(seed, left_out, rigid) -> None:
    rng = np.random.default_rng(rigid[0])
    turn = quaternion.normalize(rng.standard_normal(4))
    names = tuple(f"{side}.{part}" for side in ("left", "right") for part in left_out)
    # Without toes nothing tells front from back, and the sides are by the axes.
    turn = np.array([1.0, 0.0, 0.0, 0.0]) if "toes" in left_out else turn
    skeleton = place_body(leave_out=names, turn=turn, origin=rng.normal(size=3), size=rigid[1], seed=seed)
    expected = {joint.rpartition("/")[2]: index for index, joint in enumerate(skeleton.joints)}
    anatomy = find_anatomy(rename_joints(skeleton, lambda index, _: f"joint_{index}"))
    assert anatomy is not None
    assert anatomy.parts == {part: joint for part, joint in expected.items() if part not in SPINE}


@given(rig=st.sampled_from(sorted(CONVENTIONS)), seed=SEEDS)
def test_the_order_of_siblings_makes_no_difference(rig, seed) -> None:
    skeleton, expected = read_hierarchy(CONVENTIONS[rig][1])
    permuted, _ = permute_siblings(skeleton, np.random.default_rng(seed))
    anatomy = find_anatomy(permuted)
    assert anatomy is not None
    assert {part: permuted.joints[joint] for part, joint in anatomy.parts.items()} == expected
    assert anatomy.convention == CONVENTIONS[rig][0]


@given(seed=SEEDS, names=st.lists(NAMES, min_size=1, max_size=30))
def test_any_tree_with_any_names_has_sound_parts_or_none(seed, names) -> None:
    rng = np.random.default_rng(seed)
    paths: list[str] = []
    for index, name in enumerate(names):
        parent = rng.integers(-1, index) if index else -1
        paths.append(f"{paths[parent]}/{name}{index}x" if parent >= 0 else f"{name}{index}x")
    rest = np.tile(np.eye(4), (len(paths), 1, 1))
    rest[:, 3, :3] = rng.normal(size=(len(paths), 3)) * rng.integers(0, 2, size=(len(paths), 1))
    _check_sound(Skeleton(joints=tuple(paths), rest=rest))


@given(rig=st.sampled_from(sorted(CONVENTIONS)), seed=SEEDS, count=st.integers(2, 8))
def test_exchanged_names_have_sound_parts_or_none(rig, seed, count) -> None:
    skeleton, _ = read_hierarchy(CONVENTIONS[rig][1])
    names = [joint.rpartition("/")[2] for joint in skeleton.joints]
    picked = np.random.default_rng(seed).permutation(len(names))[:count].tolist()
    exchanged = dict(zip(picked, [*picked[1:], picked[0]], strict=True))
    _check_sound(rename_joints(skeleton, lambda index, _: names[exchanged.get(index, index)]))


def _check_sound(skeleton: Skeleton) -> None:
    anatomy = find_anatomy(skeleton)
    if anatomy is None:
        return
    parts = anatomy.parts
    assert set(parts) <= set(PARTS)
    assert len(set(parts.values())) == len(parts)
    for side in ("left", "right"):
        for limb in (("thigh", "shin", "foot", "toes"), ("clavicle", "upperArm", "foreArm", "hand", "index1")):
            joints = [parts[f"{side}.{part}"] for part in limb if f"{side}.{part}" in parts]
            for upper, lower in itertools.pairwise(joints):
                assert upper in skeleton.chain(lower)[:-1]
        assert parts["hips"] in skeleton.chain(parts[f"{side}.thigh"])[:-1]
