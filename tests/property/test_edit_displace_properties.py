"""Laws of motion warping."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mtex_usd.edit import Displacement, PoseChange, displace
from mtex_usd.motion import quaternion
from tests.oracle import edit_displace as oracle
from tests.synthetic import HEAD, HIPS, JOINTS, LEFT_ARM, make_skeleton, walk

SEEDS = st.integers(0, 2**32 - 1)
VECTORS = st.tuples(*[st.floats(-60.0, 60.0)] * 3)
FRAMES = st.lists(st.integers(-5, 45), min_size=1, max_size=5, unique=True)
SCOPES = st.one_of(st.none(), st.floats(0.5, 30.0), st.tuples(st.floats(0.5, 30.0), st.floats(0.5, 30.0)))


@st.composite
def layers(draw, joint, kinds=("rotations", "translations")):
    keys = [PoseChange(frame=frame, **{kind: {joint: draw(VECTORS)} for kind in kinds}) for frame in draw(FRAMES)]
    return Displacement(keys=keys, scope=draw(SCOPES))


def same(a, b, tolerance=1e-12):
    assert quaternion.angle_between(a.rotations, b.rotations).max() <= tolerance
    np.testing.assert_allclose(a.translations, b.translations, atol=tolerance)


@settings(max_examples=25)
@given(SEEDS, st.integers(2, 40), SCOPES)
def test_no_change_keeps_every_bit(seed, frames, scope):
    clip = walk(frames, seed=seed)
    nothing = PoseChange(frame=0, rotations={HEAD: (0, 0, 0)}, translations={HIPS: (0, 0, 0)})
    for given_layers in ([], Displacement(keys=[], scope=scope), Displacement(keys=[nothing], scope=scope)):
        moved = displace(clip, given_layers)
        np.testing.assert_array_equal(moved.rotations, clip.rotations)
        np.testing.assert_array_equal(moved.translations, clip.translations)


@settings(max_examples=25)
@given(SEEDS, layers(LEFT_ARM), layers(HEAD))
def test_layers_on_different_channels_commute(seed, one, other):
    clip = walk(40, seed=seed)
    both = displace(clip, [one, other])
    np.testing.assert_array_equal(both.rotations, displace(clip, [other, one]).rotations)
    same(both, displace(displace(clip, one), other))
    same(both, displace(displace(clip, other), one))


@settings(max_examples=25)
@given(SEEDS, layers(LEFT_ARM), layers(LEFT_ARM))
def test_layers_of_one_call_add_up_in_any_order(seed, one, other):
    clip = walk(40, seed=seed)
    same(displace(clip, [one, other]), displace(clip, [other, one]), 1e-9)


@settings(max_examples=25)
@given(SEEDS, layers(LEFT_ARM, kinds=("rotations",)))
def test_what_is_added_can_be_taken_away(seed, layer):
    clip = walk(40, seed=seed)
    away = [PoseChange(frame=key.frame, rotations={LEFT_ARM: -np.array(key.rotations[LEFT_ARM])}) for key in layer.keys]
    same(displace(clip, [layer, Displacement(keys=away, scope=layer.scope)]), clip, 1e-7)


@settings(max_examples=25)
@given(SEEDS, st.integers(0, 100), layers(LEFT_ARM))
def test_equals_the_slow_twin(seed, oriented, layer):
    skeleton = make_skeleton(oriented=oriented)
    clip = walk(40, seed=seed, skeleton=skeleton)
    moved = displace(clip, layer)
    joint = JOINTS.index(LEFT_ARM)
    keys = sorted(layer.keys, key=lambda key: key.frame)
    frames = [float(key.frame) for key in keys]
    turns = [np.array(key.rotations[LEFT_ARM]) for key in keys]
    if layer.scope is not None:
        before, after = layer.scope if isinstance(layer.scope, tuple) else (layer.scope, layer.scope)
        frames = [frames[0] - before, *frames, frames[-1] + after]
        turns = [np.zeros(3), *turns, np.zeros(3)]
    for frame in range(0, 40, 3):
        change = oracle.clamped_spline(np.array(frames), np.array(turns), float(frame))
        expected = oracle.turned(clip.rotations[frame, joint], skeleton.rest_orientations[joint], change)
        assert abs(abs(moved.rotations[frame, joint] @ expected) - 1.0) < 1e-9
    others = [other for other in range(len(JOINTS)) if other != joint]
    np.testing.assert_array_equal(moved.rotations[:, others], clip.rotations[:, others])


@settings(max_examples=25)
@given(SEEDS, st.integers(0, 39), st.integers(0, 39), st.integers(0, 100))
def test_a_key_to_another_pose_meets_it(seed, frame, target_frame, oriented):
    clip = walk(40, seed=seed, skeleton=make_skeleton(oriented=oriented))
    other = walk(40, seed=seed + 1, skeleton=clip.skeleton)
    key = PoseChange.to_clip(clip, other, frame=frame, target_frame=target_frame)
    moved = displace(clip, Displacement(keys=[key], scope=5))
    angles = quaternion.angle_between(moved.rotations[frame], other.rotations[target_frame])
    assert angles.max() < 1e-7
    np.testing.assert_allclose(moved.translations[frame], other.translations[target_frame], atol=1e-9)
    far = np.abs(np.arange(40) - frame) >= 5
    np.testing.assert_array_equal(moved.rotations[far], clip.rotations[far])
