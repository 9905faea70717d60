"""Sketch and takes measured for matching: what is compared, in which unit, and where it is cut."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.errors import InputError
from mtex_usd.motion.channels import Channel
from mtex_usd.texture.pool import Matching, build_pool
from mtex_usd.texture.reading import read_sketch, read_takes
from mtex_usd.texture.recipe import Recipe
from mtex_usd.texture.space import Space
from tests.oracle import fragments as cutting
from tests.oracle import matching as comparing
from tests.oracle import pyramid
from tests.synthetic import JOINTS, LEFT_KNEE, LEFT_LEG, make_clip, make_skeleton, walk

LEG, KNEE = Channel(JOINTS.index(LEFT_LEG), "rx"), Channel(JOINTS.index(LEFT_KNEE), "rx")
HEIGHT, FORWARD = Channel(0, "ty"), Channel(0, "tz")
SPACE = Space(0, (), (), {LEG.joint: "ZYX", KNEE.joint: "ZYX"}, np.empty((0, 4)))
RECIPE = Recipe()


def swing(degrees, *, rate=24.0, heights=None, name="/Take"):
    """A clip whose left leg turns about x by given degrees, and whose hips go up and down."""
    frames = len(degrees)
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (frames, len(JOINTS), 1))
    half = 0.5 * np.radians(np.array(degrees, dtype=np.float64))
    turns[:, LEG.joint, 0], turns[:, LEG.joint, 1] = np.cos(half), np.sin(half)
    position = np.tile([0.0, 95.0, 0.0], (frames, 1))
    position[:, 1] += np.zeros(frames) if heights is None else heights
    return make_clip(make_skeleton(), rate, turns, position, name=name)


def pool_of(sketch, takes, recipe=RECIPE, *, match=(LEG,), band=4, broken=LEG):
    own = read_sketch(sketch, 0, 4)
    motions, _ = read_takes(takes, sketch, 0, 4, match)
    return build_pool(own, motions, SPACE, Matching(match, broken, band), recipe)


def wave(frames, *, hertz=0.8, rate=24.0, size=30.0, phase=0.0):
    return size * np.sin(2.0 * np.pi * hertz * np.arange(frames) / rate + phase)


def below(curve, band):
    bands, _ = pyramid.decompose(curve)
    return [value - sum(b[i] for b in bands[: band - 1]) for i, value in enumerate(curve)]


SKETCH, TAKE = wave(80, phase=0.4), 10.0 + wave(120, size=20.0)


def test_the_band_and_what_lies_below_it_are_compared():
    pool = pool_of(swing(SKETCH), [swing(TAKE)])
    np.testing.assert_allclose(pool.sketch.values[:, 0], below(SKETCH.tolist(), 4), atol=1e-9)
    np.testing.assert_allclose(pool.features.values[:, 0], below(TAKE.tolist(), 4), atol=1e-9)
    bands, _ = pyramid.decompose(TAKE.tolist())
    np.testing.assert_allclose(pool.features.band[:, 0], bands[3], atol=1e-9)


def test_or_the_band_alone():
    pool = pool_of(swing(SKETCH), [swing(TAKE)], replace(RECIPE, match_lower=False))
    np.testing.assert_array_equal(pool.features.values, pool.features.band)


@pytest.mark.parametrize(("rate", "weight"), [(24.0, 1.0), (24.0, 0.25), (60.0, 1.0), (120.0, 4.0)])
def test_derivatives_are_per_24th_of_a_second_and_weighted_on_their_squares(rate, weight):
    frames = int(4.0 * rate)
    sketch, take = (swing(wave(frames, rate=rate, phase=phase), rate=rate) for phase in (0.0, 1.0))
    pool = pool_of(sketch, [take], replace(RECIPE, derivative_weight=weight))
    expected = np.array(comparing.derivative(pool.features.values[:, 0].tolist())) * rate / 24.0 * np.sqrt(weight)
    np.testing.assert_allclose(pool.features.slopes[:, 0], expected, atol=1e-9)


def test_derivatives_are_of_the_whole_clip_before_cutting():
    """At a cut the slope is that of the motion across it, not of one side."""
    pool = pool_of(swing(SKETCH), [swing(TAKE)])
    inner = pool.fragments[1, 0]
    values = pool.features.values[:, 0]
    assert pool.features.slopes[inner, 0] == pytest.approx((values[inner + 1] - values[inner - 1]) / 2.0)


def test_sketch_and_takes_are_cut_where_the_band_turns():
    takes = [swing(TAKE), swing(wave(60, phase=0.0))]
    pool = pool_of(swing(SKETCH), takes)
    bands, _ = pyramid.decompose(SKETCH.tolist())
    assert pool.sketch_turns.tolist() == cutting.find_turns(bands[3])
    expected, at = [], 0
    for degrees in (TAKE, wave(60, phase=0.0)):
        bands, _ = pyramid.decompose(degrees.tolist())
        expected += [(at + first, at + last) for first, last in cutting.cut(bands[3])]
        at += len(degrees)
    assert [tuple(pair) for pair in pool.fragments.tolist()] == expected


def test_no_fragment_spans_two_takes():
    pool = pool_of(swing(SKETCH), [swing(TAKE, name="/a"), swing(TAKE, name="/b")])
    ends = pool.starts + 119
    assert np.all(pool.fragments[:, 0] >= pool.starts)
    assert np.all(pool.fragments[:, 1] <= ends)
    assert pool.take_of.tolist() == sorted(pool.take_of.tolist())
    assert set(pool.starts.tolist()) == {0, 120}


def test_swings_of_less_than_a_fiftieth_of_the_range_do_not_cut():
    """Noise in a hold: the sketch is nearly still for half its time."""
    still = np.concatenate([wave(60), np.full(90, wave(61)[-1]) + wave(90, size=0.05)])
    moving = np.concatenate([wave(60), np.full(90, wave(61)[-1]) + wave(90, size=3.0)])
    quiet, busy = (pool_of(swing(curve), [swing(TAKE)]).sketch_turns for curve in (still, moving))
    assert np.sum(quiet > 84) == 0
    assert np.sum(busy > 84) >= 4


def test_takes_a_whole_turn_away_are_compared_on_the_nearest():
    """170 degrees here and -170 there are 20 degrees apart."""
    sketch, take = swing(170.0 + wave(80, size=5.0)), swing(-170.0 + wave(120, size=5.0))
    pool = pool_of(sketch, [take])
    assert abs(pool.sketch.values.mean() - pool.features.values.mean()) == pytest.approx(20.0, abs=2.0)


def test_rotations_alone_are_compared_in_degrees():
    pool = pool_of(swing(SKETCH), [swing(TAKE)], match=(LEG, KNEE))
    np.testing.assert_allclose(pool.features.values[:, 0], below(TAKE.tolist(), 4), atol=1e-9)


def test_translations_are_scaled_to_the_rotations_deviation_over_the_takes():
    heights = 3.0 * np.sin(np.arange(120.0) / 5.0)
    take = swing(TAKE, heights=heights)
    pool = pool_of(swing(SKETCH, heights=heights[:80]), [take], match=(LEG, HEIGHT))
    assert pool.features.values[:, 1].std() == pytest.approx(pool.features.values[:, 0].std())
    ratio = pool.features.values[:, 0].std() / np.std(below(heights.tolist(), 4))
    np.testing.assert_allclose(pool.sketch.values[:, 1], ratio * np.array(below(heights[:80].tolist(), 4)), atol=1e-6)


def test_travel_along_the_ground_counts_by_its_course_within_a_fragment():
    own, take = walk(100, seed=1), walk(150, seed=2)
    pool = pool_of(own, [take], match=(LEG, HEIGHT, FORWARD))
    assert pool.features.centred.tolist() == [False, False, True]
    parts = [pool.features.values[a : b + 1, 2] for a, b in pool.fragments]
    spread = np.concatenate([part - part.mean() for part in parts]).std()
    assert spread == pytest.approx(pool.features.values[:, 0].std())


def test_a_translation_that_is_still_in_the_takes_does_not_count():
    pool = pool_of(swing(SKETCH, heights=np.arange(80.0)), [swing(TAKE)], match=(LEG, HEIGHT))
    np.testing.assert_array_equal(pool.sketch.values[:, 1], 0.0)


def test_the_break_channel_need_not_be_matched():
    sketch, take = walk(100, seed=1), walk(150, seed=2)
    pool = pool_of(sketch, [take], match=(KNEE,), broken=LEG)
    assert pool.sketch_turns.tolist() == pool_of(sketch, [take], match=(LEG,)).sketch_turns.tolist()
    assert pool.features.values.shape[1] == 1


def test_takes_too_short_are_skipped():
    pool = pool_of(swing(SKETCH), [swing(TAKE[:16]), swing(TAKE), swing(TAKE[:17])])
    assert pool.skipped == (0,)
    assert set(pool.take_of.tolist()) == {1, 2}


def test_no_take_long_enough():
    with pytest.raises(InputError, match=r"expected 17 frames at 24 frames/s for band 4; found 12 at the most"):
        pool_of(swing(SKETCH), [swing(TAKE[:12]), swing(TAKE[:3])])


def test_a_sketch_of_two_frames_is_matched_on_its_residual():
    pool = pool_of(swing([0.0, 5.0]), [swing(TAKE)], band=1)
    np.testing.assert_allclose(pool.sketch.values[:, 0], [0.0, 5.0], atol=1e-9)
    assert pool_of(swing([0.0, 5.0]), [swing([1.0, 2.0])], band=1).fragments.tolist() == [[0, 1]]
