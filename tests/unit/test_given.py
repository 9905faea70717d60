"""Texturing from given fragments: what the search found gives the same motion, and any fragments may be given."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.engine import texture_motion
from mtex_usd.texture.given import GivenFragment, texture_given
from mtex_usd.texture.recipe import Recipe
from mtex_usd.texture.result import TexturedMotion, Variant
from mtex_usd.texture.stretching import stretch_cubic
from tests.synthetic import block, walk

FRAMES = 120
RECIPE = Recipe(
    match=("LeftUpLeg.rx",), texture=("*UpLeg",), synthesize=("Spine", "*Arm"), paths=3, scale=True, candidates=6
)
SKETCH = block(walk(FRAMES, seed=1, detail=0.0, start=10.0))
TAKES = tuple(walk(200, seed=seed, name=f"/Takes/{name}", start=5.0) for seed, name in ((2, "a"), (3, "b"), (4, "c")))


def as_given(variant: Variant, sketch: Clip, takes: tuple[Clip, ...]) -> list[GivenFragment]:
    start = {take.name: take.start for take in takes}
    return [
        GivenFragment(
            first=round(use.start - sketch.start),
            last=round(use.end - sketch.start),
            take=use.take,
            take_first=use.take_start - start[use.take],
            take_last=use.take_end - start[use.take],
        )
        for use in variant.fragments
    ]


def given(*paths: list[GivenFragment], recipe: Recipe = RECIPE, takes: tuple[Clip, ...] = TAKES) -> TexturedMotion:
    return texture_given(SKETCH, takes, recipe, paths=paths)


@pytest.mark.parametrize("scale", [True, False])
@pytest.mark.parametrize("cost", ["consecutive", "continuity"])
def test_what_was_found_gives_the_same_motion(scale: bool, cost: str) -> None:
    recipe = replace(RECIPE, scale=scale, path_cost=cost)
    found = texture_motion(SKETCH, TAKES, recipe)
    again = given(*(as_given(variant, SKETCH, TAKES) for variant in found.variants), recipe=recipe)
    assert np.array_equal(again.breaks, found.breaks)
    assert again.channels == found.channels
    for new, old in zip(again.variants, found.variants, strict=True):
        assert np.array_equal(new.clip.rotations, old.clip.rotations)
        assert np.array_equal(new.clip.translations, old.clip.translations)
        assert np.array_equal(new.joined, old.joined)
        assert (new.rank, new.zero_cost_joins) == (old.rank, old.zero_cost_joins)
        assert [use.distance for use in new.fragments] == pytest.approx([use.distance for use in old.fragments])
        assert [replace(use, distance=0.0) for use in new.fragments] == [
            replace(use, distance=0.0) for use in old.fragments
        ]


def test_the_take_itself_is_what_comes_out() -> None:
    """One fragment at its own pace, wherever it begins: what is synthesized is the take without its highest band."""
    whole = [GivenFragment(first=0, last=FRAMES - 1, take="/Takes/a", take_first=30.0, take_last=30.0 + FRAMES - 1)]
    motion = given(whole, recipe=replace(RECIPE, scale=False))
    arm = next(number for number, joint in enumerate(SKETCH.joints) if joint.endswith("LeftArm"))
    made = motion.variants[0].clip.rotations[:, arm]
    shifts = range(27, 34)
    apart = [quaternion.angle_between(made, TAKES[0].rotations[s : s + FRAMES, arm]).mean() for s in shifts]
    assert shifts[int(np.argmin(apart))] == 30
    assert np.degrees(min(apart)) < 0.7
    assert motion.breaks.tolist() == [0, FRAMES - 1]


def test_fragments_may_begin_between_frames() -> None:
    """Half a frame later in the take is, at that speed, half way between the two paths a frame apart."""
    paths = [
        [GivenFragment(first=0, last=119, take="/Takes/b", take_first=40.0 + s, take_last=159.0 + s)]
        for s in (0.0, 0.5, 1.0)
    ]
    joined = [variant.joined for variant in given(*paths, recipe=replace(RECIPE, scale=False)).variants]
    off = np.abs(joined[1] - 0.5 * (joined[0] + joined[2])).max()
    assert 0.0 < off < 0.1 * np.abs(joined[2] - joined[0]).max()
    uses = given(paths[1]).variants[0].fragments
    assert (uses[0].take_start, uses[0].take_end) == (45.5, 164.5)


def test_each_path_has_its_own_cuts() -> None:
    one = [GivenFragment(first=0, last=119, take="/Takes/a", take_first=0.0, take_last=119.0)]
    two = [
        GivenFragment(first=0, last=31, take="/Takes/a", take_first=0.0, take_last=31.0),
        GivenFragment(first=31, last=119, take="/Takes/a", take_first=31.0, take_last=119.0),
    ]
    motion = given(one, two, recipe=replace(RECIPE, scale=False))
    assert motion.breaks.tolist() == [0, 31, 119]
    assert [variant.zero_cost_joins for variant in motion.variants] == [0, 1]
    # What goes on in its take goes on in the result.
    assert np.abs(motion.variants[0].joined - motion.variants[1].joined).max() < 1e-9


BASE = GivenFragment(first=0, last=119, take="/Takes/a", take_first=0.0, take_last=119.0)


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ([], "do not fill the sketch.*found no fragments"),
        ([replace(BASE, last=100)], "do not fill the sketch.*from frame 0 through 119; found 0 to 100"),
        ([replace(BASE, last=60), replace(BASE, first=61)], "do not fill the sketch"),
        ([replace(BASE, last=60), replace(BASE, first=60, last=60), replace(BASE, first=60)], "do not fill"),
        ([replace(BASE, take="/Takes/x")], "/Takes/x cannot be used from 10 to 129: it is none of the takes.*/Takes/a"),
        ([replace(BASE, take_last=199.5)], "/Takes/a cannot be used from 10 to 129: the take has no such frames"),
        ([replace(BASE, take_first=-0.5)], "the take has no such frames"),
        ([replace(BASE, take_first=119.0)], "the take has no such frames"),
    ],
)
def test_fragments_that_cannot_be_are_refused(path: list[GivenFragment], message: str) -> None:
    with pytest.raises(InputError, match=message):
        given(path)


def test_a_take_too_short_to_be_measured_is_refused() -> None:
    short = walk(6, seed=5, name="/Takes/short")
    path = [replace(BASE, take="/Takes/short", take_last=5.0)]
    with pytest.raises(InputError, match="/Takes/short cannot be used from 10 to 129: the take is too short"):
        given(path, takes=(*TAKES, short))


def test_a_stretch_between_frames_reads_the_spline_there() -> None:
    frames = np.arange(60.0)
    curves = np.stack([np.sin(frames / 9.0), np.cos(frames / 7.0)], axis=1)
    at = np.linspace(20.25, 33.75, 28)
    expected = np.stack([np.sin(at / 9.0), np.cos(at / 7.0)], axis=1)
    assert np.abs(stretch_cubic(curves, 20.25, 33.75, 28) - expected).max() < 1e-4
    shifted = stretch_cubic(curves, 20.5, 30.5, 11)
    assert np.abs(shifted[:, 0] - np.sin(np.arange(20.5, 31.0) / 9.0)).max() < 1e-4
