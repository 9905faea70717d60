"""Laws of the whole method that hold for every recipe, sketch and set of takes."""

from functools import lru_cache

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mtex_usd.motion import quaternion
from mtex_usd.texture.engine import texture_motion
from mtex_usd.texture.pyramid import decompose
from mtex_usd.texture.recipe import Recipe, Segment
from tests.oracle import texturing as twin
from tests.synthetic import JOINTS, block, make_skeleton, turned, walk

TOLERANCE_DEGREES = np.degrees(1e-5)
ROLES = {
    "texture": ("LeftUpLeg", "RightLeg.rx", "LeftLeg", "Spine.rz", "RightUpLeg.rx"),
    "synthesize": ("Hips.r", "Hips.t", "LeftArm", "RightArm.rx", "RightArm.ry", "*ForeArm", "Head", "Spine.rx"),
}


@lru_cache(maxsize=8)
def takes(oriented):
    skeleton = make_skeleton(oriented=oriented)
    return tuple(walk(110, seed=i, skeleton=skeleton, heading=60.0 * i, name=f"/T{i}") for i in range(3))


def some(tokens, *, least=0):
    return st.lists(st.sampled_from(tokens), min_size=least, unique=True).map(tuple)


@st.composite
def segments(draw, frames):
    if frames < 20 or not draw(st.booleans()):
        return ()
    start = draw(st.integers(0, frames - 12))
    end = draw(st.integers(start + 10, frames - 1))
    return (
        Segment(
            name="a",
            start=float(start),
            end=float(end),
            match=draw(st.none() | some(("LeftLeg.rx", "RightUpLeg.rx"), least=1)),
            match_band=draw(st.none() | st.integers(0, 6)),
            texture=draw(st.none() | some(ROLES["texture"])),
            synthesize=draw(st.none() | some(ROLES["synthesize"], least=1)),
            scale=draw(st.none() | st.booleans()),
        ),
    )


@st.composite
def cases(draw):
    frames = draw(st.integers(2, 130))
    oriented = draw(st.sampled_from([None, 1]))
    own = walk(frames, seed=draw(st.integers(10, 15)), heading=draw(st.floats(-180.0, 180.0)), detail=1.0, start=0.0)
    recipe = Recipe(
        match=draw(some(("LeftUpLeg.rx", "RightUpLeg.rx", "Hips.ty", "LeftLeg.rx"))),
        match_band=draw(st.integers(0, 6)),
        match_lower=draw(st.booleans()),
        texture=draw(some(ROLES["texture"])),
        synthesize=draw(some(ROLES["synthesize"], least=1)),
        texture_bands=draw(st.sampled_from([(0, 0), (1, 3), (2, 2)])),
        synthesis_band=draw(st.integers(0, 3)),
        path_cost=draw(st.sampled_from(["consecutive", "continuity"])),
        candidates=draw(st.integers(0, 12)),
        paths=draw(st.integers(1, 4)),
        scale=draw(st.booleans()),
        join_time=draw(st.floats(0.0, 0.8)),
        segments=draw(segments(frames)),
    )
    return block(own) if draw(st.booleans()) else own, takes(oriented), recipe


def touched(result):
    return {name.rpartition(".")[0] for name in result.channels}


def still(result):
    """Joints that only have translations copied."""
    rotating = {name.rpartition(".")[0] for name in result.channels if name[-2] == "r"}
    return {JOINTS.index(joint) for joint in touched(result) - rotating}


@settings(max_examples=40)
@given(cases())
def test_results_are_sound_and_leave_the_rest_alone(case):
    own, pool, recipe = case
    result = texture_motion(own, pool, recipe)
    assert 1 <= len(result.variants) <= recipe.paths
    assert (len(result.variants) < recipe.paths) == any("there are no more different ones" in n for n in result.notes)
    rest = [i for i, joint in enumerate(JOINTS) if joint not in touched(result)]
    for variant in result.variants:
        assert np.isfinite(variant.clip.rotations).all()
        assert np.isfinite(variant.clip.translations).all()
        np.testing.assert_allclose(np.linalg.norm(variant.clip.rotations, axis=-1), 1.0, atol=1e-9)
        np.testing.assert_array_equal(variant.clip.rotations[:, rest], own.rotations[:, rest])
        np.testing.assert_array_equal(variant.clip.translations[:, rest], own.translations[:, rest])
        np.testing.assert_allclose(variant.clip.translations[0], own.translations[0], atol=1e-9)  # begins in its place
        turning = [i for i, joint in enumerate(JOINTS) if joint in touched(result) and i not in still(result)]
        signs = np.sum(variant.clip.rotations[1:, turning] * variant.clip.rotations[:-1, turning], axis=-1)
        assert np.all(signs >= 0.0)  # readers that blend components see no jump
        assert (variant.fragments[0].start, variant.fragments[-1].end) == (own.time_codes[0], own.time_codes[-1])
    choices = [tuple((use.take, use.take_start) for use in variant.fragments) for variant in result.variants]
    assert len(set(choices)) == len(choices)


@settings(max_examples=30)
@given(cases())
def test_texture_and_synthesis_are_what_the_laws_say(case):
    """Where a role holds fully, frame by frame: y - x + sum B(x) = sum B(m), or y = m less its highest bands."""
    own, pool, recipe = case
    recipe = Recipe(**{**vars(recipe), "segments": ()})
    result = texture_motion(own, pool, recipe)
    first, last = (given or usual for given, usual in zip(recipe.texture_bands, (2, 3), strict=True))
    for variant in result.variants[:2]:
        for column in range(len(result.channels)):
            joined = variant.joined[:, column].tolist()
            sketch = result.sketch_curves[:, column].tolist()
            if result.textured[0, column] == 1.0:
                expected = twin.texture(sketch, joined, first, last)
            else:
                assert result.synthesized[0, column] == 1.0
                expected = twin.synthesize(joined, recipe.synthesis_band or 2)
            np.testing.assert_allclose(variant.curves[:, column], expected, atol=TOLERANCE_DEGREES)


@settings(max_examples=20)
@given(cases(), st.floats(-180.0, 180.0))
def test_which_way_the_takes_walk_does_not_matter(case, degrees):
    own, pool, recipe = case
    one = texture_motion(own, pool, recipe)
    other = texture_motion(own, [turned(take, degrees) for take in pool], recipe)
    for a, b in zip(one.variants, other.variants, strict=True):
        if [use.take_start for use in a.fragments] != [use.take_start for use in b.fragments]:
            np.testing.assert_allclose(a.distance, b.distance, rtol=1e-6)  # a tie, cut either way by rounding
            continue
        assert quaternion.angle_between(a.clip.rotations, b.clip.rotations).max() < 1e-5
        np.testing.assert_allclose(a.clip.translations, b.clip.translations, atol=1e-5)


@settings(max_examples=20)
@given(cases())
def test_synthesized_motion_has_no_more_of_the_highest_band_than_what_is_copied(case):
    own, pool, recipe = case
    result = texture_motion(own, pool, Recipe(**{**vars(recipe), "segments": (), "synthesis_band": 2}))
    full = result.synthesized[0] == 1.0
    for variant in result.variants:
        before, after = (decompose(curves[:, full]).band(1) for curves in (variant.joined, variant.curves))
        assert np.square(after).sum() <= np.square(before).sum() + 1e-9
