"""The root's way where it is synthesized: it begins where the sketch's does, carries on, and keeps to the floor."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from mtex_usd.motion.channels import Channel
from mtex_usd.texture.engine import texture_motion
from mtex_usd.texture.given import GivenFragment, texture_given
from mtex_usd.texture.recipe import Recipe, Segment
from mtex_usd.texture.space import goes_along_ground
from tests.synthetic import block, make_skeleton, turned, walk

BOTH_HIPS = ("LeftUpLeg.rx", "RightUpLeg.rx")
TRAVEL = Recipe(match=BOTH_HIPS, synthesize=("Hips.t",), paths=3)
HEIGHT = 1


@lru_cache
def takes():
    return tuple(walk(150, seed=i, name=f"/Takes/t{i}") for i in range(3))


@lru_cache
def sketch(frames=150):
    return block(walk(frames, seed=77, detail=0.0))


def way(clip):
    return clip.translations[:, 0]


def moved(clip, offset):
    translations = np.array(clip.translations)
    translations[:, 0] += offset
    return replace(clip, translations=translations)


def ways(own, pool, recipe):
    return [way(variant.clip) for variant in texture_motion(own, pool, recipe).variants]


@pytest.mark.parametrize(
    "recipe",
    [
        TRAVEL,
        replace(TRAVEL, synthesize=("Hips.tz", "LeftArm"), texture=("Hips.tx",)),
        replace(TRAVEL, synthesize=("Hips.r", "Hips.t", "*Arm"), scale=True),
        replace(TRAVEL, synthesize=("LeftArm",), texture=("Hips.t",)),
        replace(TRAVEL, segments=(Segment(name="kept", start=0.0, end=4.0, synthesize=("LeftArm",)),)),
    ],
)
def test_the_first_frame_is_where_the_sketch_has_it(recipe):
    own = moved(turned(sketch(), 40.0), [120.0, 30.0, -50.0])
    for result in ways(own, takes(), recipe):
        np.testing.assert_allclose(result[0], way(own)[0], atol=1e-9)


@pytest.mark.parametrize("texture", [(), ("Hips.t",)])
def test_where_in_the_room_takes_were_recorded_does_not_matter(texture):
    recipe = replace(TRAVEL, texture=texture, synthesize=("LeftArm",) if texture else ("Hips.t",))
    elsewhere = [moved(take, [700.0, 40.0, -300.0 * i]) for i, take in enumerate(takes())]
    for one, other in zip(ways(sketch(), takes(), recipe), ways(sketch(), elsewhere, recipe), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-6)


def test_the_way_is_as_long_as_the_takes_strides():
    """The sketch marks time on the spot; the takes walk 2.5 cm a frame."""
    own = sketch()
    spot = replace(own, translations=np.tile(own.translations[:1], (own.frame_count, 1, 1)))
    for result in ways(spot, takes(), TRAVEL):
        assert result[-1, 2] - result[0, 2] == pytest.approx(149 * 2.5, rel=0.15)


def test_height_does_not_add_up_from_fragment_to_fragment():
    """Takes up a slope of 30 cm: a way twice as long stays within their heights."""
    rise = np.zeros((150, 3))
    rise[:, HEIGHT] = np.linspace(0.0, 30.0, 150)
    heights = np.concatenate([way(moved(take, rise))[:, HEIGHT] for take in takes()])
    for result in ways(sketch(290), [moved(take, rise) for take in takes()], TRAVEL):
        assert np.ptp(result[:, HEIGHT]) < 1.05 * np.ptp(heights)


@pytest.mark.parametrize("segments", [(), (Segment(name="walks", start=50.0, end=100.0, synthesize=("Hips.t",)),)])
def test_fragments_given_back_go_the_same_way_to_the_bit(segments):
    recipe = replace(TRAVEL, synthesize=() if segments else ("Hips.t",), texture=("RightLeg",), segments=segments)
    found = texture_motion(sketch(), takes(), recipe).variants
    paths = [
        [
            GivenFragment(
                first=round(use.start),
                last=round(use.end),
                take=use.take,
                take_first=use.take_start,
                take_last=use.take_end,
            )
            for use in variant.fragments
        ]
        for variant in found
    ]
    again = texture_given(sketch(), takes(), recipe, paths=paths).variants
    for one, other in zip(found, again, strict=True):
        np.testing.assert_array_equal(one.clip.translations, other.clip.translations)


# Time segments: ramps are 10 frames, so roles hold fully 6 frames from a border.

WALKS = Segment(name="walks", start=50.0, end=100.0, synthesize=("Hips.t",))
INSIDE = replace(TRAVEL, synthesize=(), texture=("RightLeg",), segments=(WALKS,))


def test_before_a_segment_the_root_is_the_sketchs_and_after_it_walks_on_as_the_sketch_does():
    own = way(sketch())
    for result in ways(sketch(), takes(), INSIDE):
        np.testing.assert_allclose(result[:44], own[:44], atol=1e-9)
        assert np.linalg.norm(result[106] - own[106]) > 5.0
        np.testing.assert_allclose(np.diff(result[106:], axis=0), np.diff(own[106:], axis=0), atol=1e-9)


def test_after_a_segment_the_root_is_on_the_sketchs_floor_again():
    """The sketch climbs 80 cm: it goes on from there within the segment, and is as high as before after it."""
    climb = np.zeros((150, 3))
    climb[:, HEIGHT] = np.interp(np.arange(150), [10.0, 40.0], [0.0, 80.0])
    own = moved(sketch(), climb)
    for result in ways(own, takes(), INSIDE):
        np.testing.assert_allclose(result[106:, HEIGHT], way(own)[106:, HEIGHT], atol=1e-9)
        assert np.abs(result[50:100, HEIGHT] - way(own)[50:100, HEIGHT]).max() < 8.0


def test_no_step_at_a_border_is_longer_than_those_of_sketch_and_path():
    result = texture_motion(sketch(), takes(), INSIDE)
    columns = [result.channels.index(f"Hips.{kind}") for kind in ("tx", "tz")]
    longest = np.abs(np.diff(result.sketch_curves[:, columns], axis=0)).max(axis=0)
    for variant in result.variants:
        limit = np.maximum(longest, np.abs(np.diff(variant.joined[:, columns], axis=0)).max(axis=0))
        assert np.all(np.abs(np.diff(variant.curves[:, columns], axis=0)).max(axis=0) <= 1.05 * limit)


# Which axes are the ground's


@pytest.mark.parametrize(
    ("up", "expected"),
    [
        ((0.0, 1.0, 0.0), "xz"),
        ((0.0, 0.0, -1.0), "xy"),
        ((0.0, np.cos(0.5), np.sin(0.5)), "xz"),
        ((0.0, np.sqrt(0.5), np.sqrt(0.5)), "xyz"),
    ],
)
def test_axes_that_carry_the_way_along_the_ground(up, expected):
    found = [axis for axis in "xyz" if goes_along_ground(Channel(0, f"t{axis}"), 0, np.array(up))]
    assert "".join(found) == expected


def test_turns_and_other_joints_do_not_go_along_the_ground():
    up = make_skeleton().up
    assert not goes_along_ground(Channel(0, "rx"), 0, up)
    assert not goes_along_ground(Channel(3, "tx"), 0, up)
