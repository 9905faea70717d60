"""The data of the plots against the result they are about, number by number."""

import itertools
import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mtex_usd.constraints.planting import Hold
from mtex_usd.errors import ResultError
from mtex_usd.motion import quaternion
from mtex_usd.review.plots import build_plots
from mtex_usd.review.plots.curves import short_names
from mtex_usd.review.plots.quantized import LEVELS, pack_rows
from mtex_usd.texture.recipe import Segment
from tests.oracle import joining as joining_twin
from tests.oracle import matching as matching_twin
from tests.oracle import pyramid as pyramid_twin
from tests.review.plots_support import RECIPE, make_character, unpack_rows
from tests.synthetic import JOINTS, POSITIONS, RIGHT_KNEE, make_skeleton


@pytest.fixture(scope="module")
def character():
    return make_character()


@pytest.fixture(scope="module")
def plots(character):
    return build_plots(character)


def close(unpacked, expected, *, rows=slice(None)):
    """Check values [R, ...] to half a step of each row."""
    values, off = unpacked.values[rows], unpacked.off[rows]
    assert values.shape == np.shape(expected)
    return np.all(np.abs(values - expected).reshape(len(off), -1).max(axis=1) <= off + 1e-6)


def copied_rows(plots, character):
    """Where the result's columns are among the rows; they come first and in order."""
    assert plots["curves"]["columns"] == list(range(len(plots["channels"])))
    return slice(len(character.channels))


# --- Curves ---------------------------------------------------------------------------------------------------------


def test_sketch_and_variants_are_those_of_the_result(plots, character):
    rows = copied_rows(plots, character)
    assert [channel["token"] for channel in plots["channels"][rows]] == list(character.channels)
    assert close(unpack_rows(plots["curves"]["sketch"]), character.texturing.sketch_curves.T, rows=rows)
    curves = np.stack([variant.motion.curves.T for variant in character.variants], axis=1)
    assert close(unpack_rows(plots["curves"]["finished"]), curves, rows=rows)


def test_joined_paths_are_those_of_the_result(plots, character):
    rows = copied_rows(plots, character)
    joined = np.stack([variant.motion.joined.T for variant in character.variants], axis=1)
    assert close(unpack_rows(plots["curves"]["joins"]["joined"]), joined, rows=rows)


def test_a_variant_changed_by_contacts_is_shown_as_it_was_finished():
    knee = JOINTS.index(RIGHT_KNEE)
    bend = quaternion.exp(np.array([np.radians(10.0), 0.0, 0.0]))

    def bend_knee(result):
        clips = [np.array(variant.clip.rotations) for variant in result.variants]
        for rotations in clips:
            rotations[:, knee] = quaternion.multiply(rotations[:, knee], bend)
        variants = [
            replace(variant, clip=replace(variant.clip, rotations=rotations))
            for variant, rotations in zip(result.variants, clips, strict=True)
        ]
        return replace(result, variants=tuple(variants))

    plots = build_plots(make_character(change=bend_knee))
    (row,) = [i for i, channel in enumerate(plots["channels"]) if channel["label"] == "RightLeg.rx"]
    assert plots["channels"][row]["roles"] == ["contact"]
    finished, own = (unpack_rows(plots["curves"][name]).values[row] for name in ("finished", "sketch"))
    np.testing.assert_allclose(finished - own, 10.0, atol=0.01)


def test_fragments_as_captured_skewed_and_joined_follow_the_paper():
    # One angle alone is a plain curve, so the paper's own steps can be taken on it.
    character = make_character(replace(RECIPE, texture=(), synthesize=("LeftArm.rx",), path_cost="consecutive"))
    plots = build_plots(character)
    joins = {name: unpack_rows(plots["curves"]["joins"][name]) for name in ("captured", "skewed", "joined")}
    assert plots["joinFrames"] == 10
    for i, variant in enumerate(plots["variants"]):
        captured = joins["captured"].values[0, i]
        pieces = [
            captured[fragment["first"] + q : fragment["last"] + q + 1].tolist()
            for q, fragment in enumerate(plots["fragments"])
        ]
        whole = [True] * len(variant["continued"])
        skewed = joining_twin.join(pieces, whole, plots["joinFrames"])
        joined = joining_twin.join(pieces, variant["continued"], plots["joinFrames"])
        # Quadratics are fitted to numbers that are half a step off.
        tolerance = 4.0 * max(joins[name].off[0] for name in joins)
        np.testing.assert_allclose(joins["skewed"].values[0, i], skewed, atol=tolerance)
        np.testing.assert_allclose(joins["joined"].values[0, i], joined, atol=tolerance)
    assert not all(plots["variants"][0]["continued"])


def test_a_captured_fragment_that_fits_is_the_take_itself(plots, character):
    captured = unpack_rows(plots["curves"]["joins"]["captured"])
    takes = unpack_rows(plots["curves"]["takes"]["values"])
    starts = plots["curves"]["takes"]["starts"]
    matched = [i for i, channel in enumerate(plots["channels"]) if "match" in channel["roles"]]
    found = 0
    for i, variant in enumerate(plots["variants"]):
        for q, (use, fragment) in enumerate(zip(variant["fragments"], plots["fragments"], strict=True)):
            length = fragment["last"] - fragment["first"]
            if use["takeLast"] - use["takeFirst"] != length:
                continue
            found += 1
            begin = starts[use["take"]] + int(use["takeFirst"])
            piece = captured.values[:, i, fragment["first"] + q : fragment["last"] + q + 1]
            off = (captured.off + takes.off)[matched, None]
            assert np.all(np.abs(piece - takes.values[:, begin : begin + length + 1])[matched] <= off)
    assert found > 0


def test_matched_angles_have_columns_beside_those_copied_whole(plots):
    forms = {(channel["label"], channel["form"]): channel for channel in plots["channels"]}
    angle, vector = forms["LeftUpLeg.rx", "angle"], forms["LeftUpLeg.rx", "vector"]
    assert angle["roles"] == ["match", "break"]
    assert vector["roles"] == ["texture"]
    assert angle["matchBand"] == 4
    assert vector["matchBand"] is None
    assert angle["textureBands"] == [2, 3]
    assert forms["LeftArm.ry", "vector"]["synthesisBand"] == 2
    assert forms["LeftArm.ry", "vector"]["textureBands"] is None


def test_bands_are_those_a_sketch_of_this_length_has(plots):
    assert [band["number"] for band in plots["curves"]["bands"]] == list(range(1, pyramid_twin.count_bands(100) + 1))
    assert plots["curves"]["bands"][3]["hz"] == pytest.approx(0.8, abs=0.05)


# --- Strips ---------------------------------------------------------------------------------------------------------


def test_every_strip_covers_every_frame_once(plots, character):
    covered = np.zeros(plots["frameCount"], dtype=int)
    for fragment in plots["fragments"]:
        covered[fragment["first"] : fragment["last"]] += 1
    assert covered[:-1].tolist() == [1] * (plots["frameCount"] - 1)
    assert plots["fragments"][-1]["last"] == plots["frameCount"] - 1
    for variant in plots["variants"]:
        assert len(variant["fragments"]) == len(plots["fragments"])
        for use, fragment in zip(variant["fragments"], plots["fragments"], strict=True):
            assert [use["start"], use["end"]] == [101.0 + 2.0 * fragment[end] for end in ("first", "last")]


def test_fragments_are_those_of_the_result(plots, character):
    for shown, variant in zip(plots["variants"], character.variants, strict=True):
        assert shown["name"] == variant.name
        assert sum(shown["continued"]) == variant.motion.zero_cost_joins == shown["zeroCostJoins"]
        for use, fragment in zip(shown["fragments"], variant.fragments, strict=True):
            take = plots["takes"][use["take"]]
            assert take["name"] == fragment.take
            assert use["takeStart"] == take["start"] + use["takeFirst"] * take["timeCodesPerFrame"]
            assert (use["takeStart"], use["takeEnd"]) == (fragment.take_start, fragment.take_end)
            assert use["distance"] == pytest.approx(fragment.distance, rel=1e-5)


def test_contacts_are_named_by_the_point_they_hold():
    names = ("left.heel 1", "left.heel 2", "grip")
    holds = tuple(
        Hold(name=name, joint=1, offset=np.zeros(3), first=10 * i, last=10 * i + 5) for i, name in enumerate(names)
    )
    (first, *_) = build_plots(make_character(holds=holds))["variants"]
    shown = [(contact["point"], contact["first"], contact["last"]) for contact in first["contacts"]]
    assert shown == [("left.heel", 0, 5), ("left.heel", 10, 15), ("grip", 20, 25)]


def test_keys_are_frames_of_the_sketch(plots, character):
    assert plots["keys"] == list(range(0, 100, 8))
    between = replace(character, key_times=np.array([101.0, 102.0]))
    assert build_plots(between)["keys"] == [0.0, 0.5]


# --- Matches --------------------------------------------------------------------------------------------------------


def test_a_path_takes_its_fragments_from_the_candidates(plots):
    for variant in plots["variants"]:
        for k, use, fragment in zip(variant["choice"], variant["fragments"], plots["fragments"], strict=True):
            assert fragment["take"][k] == use["take"]
            assert (fragment["takeFirst"][k], fragment["takeLast"][k]) == (use["takeFirst"], use["takeLast"])
            assert fragment["distance"][k] == pytest.approx(use["distance"], rel=1e-4)


def test_a_fragment_that_is_no_candidate_is_said_to_be_none(character):
    first = character.variants[0]
    use = first.fragments[0]
    moved = replace(use, take_start=use.take_start + 1.0, take_end=use.take_end + 1.0)
    fragments = (moved, *first.fragments[1:])
    edited = replace(first, motion=replace(first.motion, fragments=fragments))
    plots = build_plots(replace(character, variants=(edited, *character.variants[1:])))
    assert plots["variants"][0]["choice"][0] == -1
    assert plots["variants"][0]["fragments"][0]["takeStart"] == moved.take_start


def test_zero_cost_joins_are_all_pairs_that_follow_on(plots):
    counted = 0
    for left, right in itertools.pairwise(plots["fragments"]):
        pairs = {(left["joins"][i], left["joins"][i + 1]) for i in range(0, len(left["joins"]), 2)}
        expected = {
            (a, b)
            for a in range(len(left["take"]))
            for b in range(len(right["take"]))
            if left["take"][a] == right["take"][b] and left["takeLast"][a] == right["takeFirst"][b]
        }
        assert pairs == expected
        counted += len(pairs)
    assert counted > 0
    assert plots["fragments"][-1]["joins"] == []


def test_what_is_overlaid_is_what_was_compared(plots):
    (way,) = plots["ways"]
    sketch, pool = unpack_rows(way["sketch"]).values, unpack_rows(way["pool"]).values
    assert (way["labels"], way["band"], way["lower"]) == (["LeftUpLeg.rx", "RightUpLeg.rx"], 4, True)
    for fragment in plots["fragments"]:
        assert fragment["distance"] == sorted(fragment["distance"])
        for k, take in enumerate(fragment["take"]):
            clip = pool[:, way["starts"][take] :][:, : plots["takes"][take]["frameCount"]]
            found = _distance(sketch, clip, fragment, (fragment["takeFirst"][k], fragment["takeLast"][k]))
            assert found == pytest.approx(fragment["distance"][k], rel=0.02, abs=0.5)


def _distance(sketch, take, fragment, candidate):
    """Squared differences of values and slopes, channel by channel, with the slow twin's stretch."""
    total, first, last = 0.0, fragment["first"], fragment["last"]
    for own, taken in zip(sketch, take, strict=True):
        for a, b in ((own, taken), (np.gradient(own), np.gradient(taken))):
            stretched = matching_twin.stretch(b.tolist(), *candidate, last - first + 1)
            total += float(np.square(a[first : last + 1] - stretched).sum())
    return total


def test_the_sketch_is_cut_where_the_shown_band_turns(plots):
    cut = unpack_rows(plots["ways"][0]["cut"]).values[0]
    for fragment in plots["fragments"][1:]:
        around = cut[fragment["first"] - 2 : fragment["first"] + 3]
        middle = cut[fragment["first"]]
        assert middle in (around.max(), around.min())


def test_the_number_of_a_candidate_counts_fragments_in_its_take(plots):
    (way,) = plots["ways"]
    pairs = np.reshape(way["fragments"], (-1, 2))
    for fragment in plots["fragments"]:
        for take, first, number in zip(fragment["take"], fragment["takeFirst"], fragment["number"], strict=True):
            begin = way["starts"][take]
            end = begin + plots["takes"][take]["frameCount"]
            own = pairs[(pairs[:, 0] >= begin) & (pairs[:, 0] < end)]
            assert own[number - 1, 0] - begin == first


def test_segments_have_ways_of_their_own():
    stomp = Segment(name="stomp", start=161.0, end=221.0, match=("LeftUpLeg.rx", "LeftLeg.rx"))
    plots = build_plots(make_character(replace(RECIPE, segments=(stomp,))))
    assert [way["labels"] for way in plots["ways"]] == [
        ["LeftUpLeg.rx", "RightUpLeg.rx"],
        ["LeftUpLeg.rx", "LeftLeg.rx"],
    ]
    for fragment in plots["fragments"]:
        inside = 30 <= fragment["first"] < 60
        assert fragment["way"] == int(inside)


# --- As a whole -----------------------------------------------------------------------------------------------------


def test_takes_of_another_result_are_refused(character):
    with pytest.raises(ResultError, match=r"not those its variants were made with.*without takes /Takes/t"):
        build_plots(replace(character, takes=character.takes[:1]))
    with pytest.raises(ResultError, match=r"expected 21 copied channels.*found 3 copied channels"):
        build_plots(replace(character, recipe=replace(character.recipe, texture=(), synthesize=("Spine",))))


def test_the_data_is_strict_json(plots):
    assert json.loads(json.dumps(plots, allow_nan=False)) == plots


@pytest.fixture(scope="module")
def long_plots():
    extra = [f"Hips/Spine/extra{i:02}" for i in range(31 - len(JOINTS))]
    places = POSITIONS | {name: (float(i), 150.0, 5.0) for i, name in enumerate(extra)}
    skeleton = make_skeleton((*JOINTS, *extra), positions=places)
    recipe = replace(RECIPE, texture=("*Leg",), synthesize=("Spine", "Head", "*Arm", "extra*"), paths=5)
    return build_plots(make_character(recipe, frames=480, skeleton=skeleton))


def test_twenty_seconds_of_31_joints_in_5_variants_stay_small(long_plots):
    assert (long_plots["frameCount"], len(long_plots["variants"])) == (480, 5)
    assert len(long_plots["channels"]) > 90
    assert len(json.dumps(long_plots)) < 3.0e6


def test_what_is_left_out_for_size_is_said_and_matters_least():
    plots = build_plots(make_character(frames=4000))
    curves = plots["curves"]
    for group in (curves, curves["joins"]):
        assert len(group["columns"]) + group["left_out"] == len(plots["channels"])
    assert curves["joins"]["left_out"] > 0
    assert unpack_rows(curves["joins"]["joined"]).values.shape[0] == len(curves["joins"]["columns"])
    matched = {i for i, channel in enumerate(plots["channels"]) if "match" in channel["roles"]}
    assert matched <= set(curves["joins"]["columns"])
    assert len(json.dumps(plots)) < 6.0e6


def test_names_are_short_where_that_is_clear():
    assert short_names(["Hips", "Hips/Leg", "Hips/Spine", "Hips/Spine/Leg"]) == [
        "Hips",
        "Hips/Leg",
        "Spine",
        "Hips/Spine/Leg",
    ]


@given(arrays(float, (3, 7), elements=st.floats(-1e5, 1e5, allow_subnormal=False)))
def test_packed_rows_are_off_by_half_a_step_at_the_most(rows):
    unpacked = unpack_rows(pack_rows(rows))
    assert close(unpacked, rows)
    assert np.all(2.0 * unpacked.off <= 1.001 * np.ptp(rows, axis=1) / LEVELS + 1e-6 + 1e-11 * np.abs(rows).max())


def test_a_row_that_does_not_move_comes_back_exactly():
    np.testing.assert_array_equal(unpack_rows(pack_rows([[0.5, 0.5], [0.0, 1.0]])).values[0], [0.5, 0.5])
