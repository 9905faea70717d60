"""Characters to plot, made of synthetic walks, and packed arrays read back without the package."""

import base64
from dataclasses import dataclass

import numpy as np

from mtex_usd.review.shot import ReviewedCharacter, ReviewedVariant
from mtex_usd.texture.engine import texture_motion
from mtex_usd.texture.recipe import Recipe
from tests.synthetic import block, make_skeleton, walk

__all__ = ["RECIPE", "Unpacked", "make_character", "make_takes", "unpack_floats", "unpack_rows"]

RECIPE = Recipe(
    match=("LeftUpLeg.rx", "RightUpLeg.rx"), texture=("*UpLeg",), synthesize=("Spine", "*Arm"), paths=3, candidates=4
)


def make_takes(count=3, *, skeleton=None):
    """Walks of 150 frames."""
    skeleton = skeleton or make_skeleton()
    return tuple(walk(150, seed=i, skeleton=skeleton, name=f"/Takes/t{i}") for i in range(count))


def make_character(recipe=RECIPE, *, frames=100, skeleton=None, holds=(), change=None, start=101.0, step=2.0):
    """Work on a walk keyed on the legs; `change` makes a variant's clip another, as held contacts do."""
    skeleton = skeleton or make_skeleton()
    own = walk(frames, seed=77, detail=0.0, skeleton=skeleton, start=start, step=step)
    takes = make_takes(skeleton=skeleton)
    result = texture_motion(block(own), takes, recipe)
    if change is not None:
        result = change(result)
    variants = tuple(
        ReviewedVariant(name=f"path_{v.rank:02}", motion=v, custom_data={}, holds=holds) for v in result.variants
    )
    return ReviewedCharacter(
        anim="/Shot/Anim",
        model="/Shot",
        variant_set="mtex",
        texturing=result,
        recipe=recipe,
        takes=takes,
        key_times=start + step * np.arange(0, frames, 8),
        variants=variants,
    )


@dataclass(frozen=True, eq=False)
class Unpacked:
    """Rows read back, and the most each may be off, shape [R]."""

    values: np.ndarray
    off: np.ndarray


def unpack_floats(packed):
    """Read an array of `pack_array` back."""
    assert packed["dtype"] == "float32"
    return np.frombuffer(base64.b64decode(packed["data"]), "<f4").reshape(packed["shape"])


def unpack_rows(packed):
    """Read an array of `pack_rows` back."""
    assert packed["dtype"] == "int16"
    numbers = np.frombuffer(base64.b64decode(packed["data"]), "<i2").reshape(packed["shape"]).astype(float)
    rows = (-1, *[1] * (numbers.ndim - 1))
    middle = unpack_floats(packed["middle"]).astype(float).reshape(rows)
    step = unpack_floats(packed["step"]).astype(float)
    return Unpacked(middle + step.reshape(rows) * numbers, 0.5 * step + 1e-9)
