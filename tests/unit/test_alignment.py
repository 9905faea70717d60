"""Takes on skeletons that stand, face or measure otherwise read as the same motion."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.texture.alignment import align_skeletons
from mtex_usd.texture.engine import texture_motion
from mtex_usd.texture.recipe import Recipe
from tests.synthetic import HIPS, LEFT_KNEE, LEFT_LEG, RIGHT_KNEE, RIGHT_LEG, block, walk

RECIPE = Recipe(match=("LeftUpLeg.rx", "LeftLeg.rx"), synthesize=("Spine", "LeftArm", "RightArm"), paths=1)


def in_other_axes(clip: Clip, axis: tuple[float, float, float], degrees: float, size: float = 1.0) -> Clip:
    """The same motion on a skeleton whose space is turned, and larger: up and root turned, the others as they were."""
    turn = quaternion.exp(np.radians(degrees) * np.array(axis))
    rest = np.array(clip.rest)
    rest[:, 3, :3] *= size
    matrix = np.stack([quaternion.rotate(turn, row) for row in np.eye(3)])
    rest[0, :3, :3] = rest[0, :3, :3] @ matrix
    rest[0, 3, :3] = quaternion.rotate(turn, rest[0, 3, :3])
    rotations, translations = np.array(clip.rotations), np.array(clip.translations) * size
    rotations[:, 0] = quaternion.multiply(turn, rotations[:, 0])
    translations[:, 0] = quaternion.rotate(turn, translations[:, 0])
    skeleton = Skeleton(
        joints=clip.joints, rest=rest, up=quaternion.rotate(turn, clip.skeleton.up), meters_per_unit=0.01
    )
    return replace(clip, skeleton=skeleton, rotations=rotations, translations=translations)


def all_joints(clip: Clip) -> dict[int, int]:
    """Every joint corresponds to itself."""
    return {i: i for i in range(len(clip.joints))}


def test_nothing_is_touched_where_the_skeletons_agree():
    clip = walk(120)
    alignment = align_skeletons(clip.skeleton, clip.skeleton, all_joints(clip))
    assert alignment.turn is None
    assert alignment.scale == 1.0


@pytest.mark.parametrize(
    ("axis", "degrees", "size"),
    [
        ((1.0, 0.0, 0.0), 90.0, 1.0),
        ((1.0, 0.0, 0.0), -90.0, 2.0),
        ((0.0, 1.0, 0.0), 90.0, 1.0),
        ((0.0, 1.0, 0.0), 180.0, 0.01),
        ((0.0, 1.0, 0.0), 37.0, 1.0),
        ((0.0, 0.0, 1.0), 180.0, 1.0),
    ],
)
def test_takes_in_other_axes_and_sizes_give_the_same_result(axis, degrees, size):
    sketch = block(walk(120), (HIPS, LEFT_LEG, LEFT_KNEE, RIGHT_LEG, RIGHT_KNEE))
    take = walk(200, seed=3)
    straight = texture_motion(sketch, [take], RECIPE).variants[0]
    turned = texture_motion(sketch, [in_other_axes(take, axis, degrees, size)], RECIPE).variants[0]
    np.testing.assert_allclose(turned.distance, straight.distance, rtol=1e-6, atol=1e-6)
    apart = quaternion.angle_between(turned.clip.rotations, straight.clip.rotations)
    assert apart.max() < 1e-6


def test_travel_is_scaled_by_the_legs():
    sketch = walk(120)
    recipe = Recipe(match=("LeftUpLeg.rx", "LeftLeg.rx"), synthesize=("Hips.t", "LeftArm"), paths=1)
    same = texture_motion(sketch, [walk(120)], recipe).variants[0].clip
    larger = texture_motion(sketch, [in_other_axes(walk(120), (1.0, 0.0, 0.0), 0.0, 2.5)], recipe).variants[0].clip
    np.testing.assert_allclose(larger.translations, same.translations, atol=1e-6)
    assert np.ptp(same.translations[:, 0], axis=0).max() > 1.0
