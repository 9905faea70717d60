"""The recipe resolved: what each channel is for, and when."""

import numpy as np
import pytest

from mtex_usd.errors import InputError
from mtex_usd.motion.channels import Channel
from mtex_usd.texture.recipe import Recipe, Segment
from mtex_usd.texture.roles import ramp, resolve_roles
from tests.synthetic import JOINTS, LEFT_ARM, LEFT_LEG, RIGHT_LEG, walk

LEFT, RIGHT, ARM = (JOINTS.index(joint) for joint in (LEFT_LEG, RIGHT_LEG, LEFT_ARM))
ANIMATED = (Channel(LEFT, "rx"), Channel(RIGHT, "rx"))
RECIPE = Recipe(match=("LeftUpLeg.rx",), synthesize=("LeftArm",))


def resolve(recipe=RECIPE, *, frames=100, rate=24.0, start=0.0, step=1.0, animated=ANIMATED):
    return resolve_roles(recipe, walk(frames, rate=rate, start=start, step=step, name="/Sketch"), animated)


def with_segments(*segments, **settings):
    return Recipe(match=("LeftUpLeg.rx",), synthesize=("LeftArm",), segments=segments, **settings)


def test_without_segments_one_span_covers_the_sketch():
    (span,) = resolve().spans
    assert (span.first, span.last) == (0, 99)
    assert span.match == (Channel(LEFT, "rx"),)
    assert span.break_channel == Channel(LEFT, "rx")
    assert span.synthesize == {Channel(ARM, kind) for kind in ("rx", "ry", "rz")}
    assert resolve().borders == ()


@pytest.mark.parametrize(
    ("rate", "match", "texture", "synthesis"),
    [(24.0, 4, (2, 3), 2), (30.0, 4, (2, 3), 2), (60.0, 5, (3, 4), 3), (120.0, 6, (4, 5), 4)],
)
def test_bands_follow_the_rate(rate, match, texture, synthesis):
    roles = resolve(rate=rate)
    assert roles.spans[0].match_band == roles.heading_band == match
    assert roles.spans[0].texture_bands == texture
    assert roles.synthesis_band == synthesis


def test_bands_that_are_given_stay():
    roles = resolve(
        Recipe(match=("LeftUpLeg.rx",), texture=("LeftArm",), match_band=6, texture_bands=(1, 4), synthesis_band=3)
    )
    assert (roles.spans[0].match_band, roles.spans[0].texture_bands, roles.synthesis_band) == (6, (1, 4), 3)


def test_one_texture_band_may_be_given():
    assert resolve(Recipe(texture=("LeftArm",), texture_bands=(1, 0))).spans[0].texture_bands == (1, 3)
    assert resolve(Recipe(texture=("LeftArm",), texture_bands=(5, 0))).spans[0].texture_bands == (5, 5)
    assert resolve(Recipe(texture=("LeftArm",), texture_bands=(0, 1))).spans[0].texture_bands == (1, 1)


@pytest.mark.parametrize(("frames", "band"), [(2, 1), (3, 1), (5, 2), (9, 3), (16, 3), (17, 4), (500, 4)])
def test_the_match_band_is_at_most_what_the_sketch_is_long_enough_for(frames, band):
    roles = resolve(frames=frames)
    assert roles.spans[0].match_band == band
    assert bool(roles.notes) == (frames < 17)


def test_a_lower_match_band_is_noted():
    (note,) = resolve(frames=9).notes
    assert note.startswith("band 4")
    assert "9" in note
    assert note.endswith("matched on band 3")


def test_an_empty_match_list_is_what_moves_and_is_not_synthesized():
    recipe = Recipe(synthesize=("RightUpLeg", "LeftArm"))
    assert resolve(recipe).spans[0].match == (Channel(LEFT, "rx"),)


def test_the_break_channel_may_be_any():
    assert resolve(
        Recipe(match=("LeftUpLeg.rx", "RightUpLeg.rx"), texture=("LeftArm",), break_channel="RightUpLeg.rx")
    ).spans[0].break_channel == Channel(RIGHT, "rx")


def test_segments_divide_the_sketch_and_share_border_frames():
    segment = Segment(name="stomp", start=30.0, end=59.0, match=("RightUpLeg.rx",), scale=True, match_band=3)
    roles = resolve(with_segments(segment))
    assert [(span.first, span.last) for span in roles.spans] == [(0, 30), (30, 59), (59, 99)]
    assert roles.borders == (30, 59)
    assert [span.match for span in roles.spans] == [(Channel(leg, "rx"),) for leg in (LEFT, RIGHT, LEFT)]
    assert [span.scale for span in roles.spans] == [False, True, False]
    assert [span.match_band for span in roles.spans] == [4, 3, 4]
    assert all(span.synthesize == roles.spans[0].synthesize for span in roles.spans)
    assert roles.heading_band == 4


def test_an_empty_list_in_a_segment_is_not_inherited():
    roles = resolve(with_segments(Segment(name="a", start=0.0, end=40.0, synthesize=())))
    assert [bool(span.synthesize) for span in roles.spans] == [False, True]


def test_segments_that_touch_leave_no_gap():
    one, other = Segment(name="a", start=10.0, end=40.0), Segment(name="b", start=40.0, end=99.0)
    assert resolve(with_segments(other, one)).borders == (10, 40)
    next_frame = Segment(name="b", start=41.0, end=99.0)
    assert resolve(with_segments(one, next_frame)).borders == (10, 40)


def test_segment_times_are_time_codes_and_are_cut_to_the_sketch():
    segment = Segment(name="a", start=0.0, end=1050.0)
    roles = resolve(with_segments(segment), start=1000.0, step=5.0)
    assert [(span.first, span.last) for span in roles.spans] == [(0, 10), (10, 99)]


def test_a_fragment_belongs_to_the_span_it_begins_in():
    roles = resolve(with_segments(Segment(name="a", start=30.0, end=59.0)))
    assert [roles.spans.index(roles.span_at(frame)) for frame in (0, 29, 30, 58, 59, 98)] == [0, 0, 1, 1, 2, 2]


@pytest.mark.parametrize(("start", "end"), [(200.0, 300.0), (-50.0, -1.0), (40.2, 40.3), (99.0, 120.0)])
def test_a_segment_outside_the_sketch(start, end):
    with pytest.raises(
        InputError, match="/Sketch: segment 'a' holds no frames of the sketch; expected a range within 0 to 99; found"
    ):
        resolve(with_segments(Segment(name="a", start=start, end=end)))


def test_a_channel_has_one_role():
    with pytest.raises(
        InputError, match=f"/Sketch: channels are both textured and synthesized; expected .*; found {LEFT_ARM}.rx"
    ):
        resolve(Recipe(match=("LeftUpLeg.rx",), texture=("LeftArm.rx",), synthesize=("LeftArm",)))


def test_nothing_to_do():
    with pytest.raises(
        InputError, match="/Sketch: nothing to do; expected channels in mtex:texture or mtex:synthesize"
    ):
        resolve(Recipe(match=("LeftUpLeg.rx",)))


def test_nothing_to_match():
    with pytest.raises(InputError, match="/Sketch: nothing to match; expected an animated channel, not synthesized"):
        resolve(Recipe(texture=("LeftArm",)), animated=())


def test_a_break_that_names_several_channels():
    with pytest.raises(
        InputError, match=r"/Sketch: break names several channels; expected one, such as .*; found LeftUpLeg"
    ):
        resolve(Recipe(match=("LeftUpLeg.rx",), texture=("LeftArm",), break_channel="LeftUpLeg"))


@pytest.mark.parametrize("role", ["match", "texture", "synthesize"])
def test_an_unknown_joint_names_the_list_and_the_segment(role):
    with pytest.raises(InputError, match=f"/Sketch: {role}: no joint fits 'Tail'"):
        resolve(Recipe(**{"match": ("LeftUpLeg.rx",), "texture": ("LeftArm",), role: ("Tail",)}))
    with pytest.raises(InputError, match=f"/Sketch, segment stomp: {role}: no joint fits 'Tail'"):
        resolve(with_segments(Segment(name="stomp", start=0.0, end=40.0, **{role: ("Tail",)})))


def test_what_is_copied_and_what_is_used():
    roles = resolve(Recipe(match=("LeftUpLeg.rx",), texture=("RightUpLeg.rx",), synthesize=("LeftArm.rx",)))
    assert set(roles.copied) == {Channel(RIGHT, "rx"), Channel(ARM, "rx")}
    assert set(roles.used) == {*roles.copied, Channel(LEFT, "rx")}


def test_a_step_becomes_a_smooth_ramp_centred_on_it():
    steps = np.repeat([0.0, 1.0], 30)[:, None]
    smooth = ramp(steps, 10)[:, 0]
    assert np.all(smooth[:24] == 0.0)
    assert np.all(smooth[36:] == 1.0)
    assert np.all(np.diff(smooth) >= 0.0)
    np.testing.assert_allclose(smooth + smooth[::-1], 1.0, atol=1e-12)
    assert np.abs(np.diff(smooth)).max() < 0.2


def test_a_role_that_never_changes_does_not_ramp():
    steps = np.ones((20, 2))
    assert ramp(steps, 10) is steps


def test_a_role_at_the_ends_does_not_fade_there():
    steps = np.repeat([1.0, 0.0], [50, 10])[:, None]
    np.testing.assert_array_equal(ramp(steps, 8)[:40], 1.0)


def test_no_join_time_no_ramp():
    steps = np.repeat([0.0, 1.0], 5)[:, None]
    np.testing.assert_array_equal(ramp(steps, 0), steps)
