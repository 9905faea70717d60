"""Variants that differ visibly, or fewer of them."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.texture.diversity import MOST_DIVERSE_PATHS
from mtex_usd.texture.engine import texture_motion
from mtex_usd.texture.recipe import Recipe
from tests.synthetic import HIPS, JOINTS, LEFT_LEG, RIGHT_LEG, block, walk

RECIPE = Recipe(match=("LeftUpLeg.rx", "RightUpLeg.rx"), synthesize=("Spine", "*Arm"))
COPIED = [i for i, joint in enumerate(JOINTS) if "Arm" in joint or joint.endswith("Spine")]


def run(recipe, *, arms=(10.0, 25.0, 40.0, 60.0)):
    """Takes that walk alike but swing their arms differently."""
    own = block(walk(90, seed=50), (HIPS, LEFT_LEG, RIGHT_LEG))
    takes = [walk(150, seed=i, arm=arm, name=f"/T{i}") for i, arm in enumerate(arms)]
    return texture_motion(own, takes, recipe)


def greatest_difference(result, a, b):
    """Mean angle over the copied joints in the fragment where it is greatest, degrees, from the clips alone."""
    one, other = (variant.clip.rotations[:, COPIED] for variant in (a, b))
    angles = np.degrees(quaternion.angle_between(one, other)).mean(axis=1)
    breaks = result.breaks
    return max(angles[i : j + 1].mean() for i, j in itertools.pairwise(breaks))


@pytest.mark.parametrize("degrees", [1.0, 3.0, 8.0])
def test_every_variant_differs_from_every_better_one(degrees):
    result = run(replace(RECIPE, diversity=degrees, paths=4))
    assert len(result.variants) >= 2
    for number, variant in enumerate(result.variants):
        for better in result.variants[:number]:
            assert greatest_difference(result, variant, better) >= degrees - 1e-6


def test_the_best_is_the_best_with_and_without():
    plain, diverse = run(RECIPE), run(replace(RECIPE, diversity=5.0))
    assert diverse.variants[0].fragments == plain.variants[0].fragments


def test_where_no_path_differs_so_much_there_are_fewer_and_it_is_said():
    result = run(replace(RECIPE, diversity=170.0))
    assert len(result.variants) == 1
    assert result.notes[-1].startswith("1 of 5 variants")


def test_a_single_channel_counts_too():
    recipe = Recipe(match=RECIPE.match, synthesize=("LeftArm.rx", "RightArm.rx"), diversity=3.0, paths=3)
    result = run(recipe)
    assert len(result.variants) == 3
    arms = [JOINTS.index("Hips/Spine/LeftArm"), JOINTS.index("Hips/Spine/RightArm")]
    one, other = (variant.clip.rotations[:, arms] for variant in result.variants[:2])
    angles = np.degrees(quaternion.angle_between(one, other)).mean(axis=1)
    assert max(angles[i : j + 1].mean() for i, j in zip(result.breaks[:-1], result.breaks[1:], strict=True)) >= 3.0


def test_too_many_paths_for_a_diverse_choice():
    with pytest.raises(
        InputError, match=f"too many paths for a diverse choice; expected mtex:paths of at most {MOST_DIVERSE_PATHS}"
    ):
        run(replace(RECIPE, diversity=1.0, paths=MOST_DIVERSE_PATHS + 1))
