"""Variants whose frames are not the sketch's any more: page and sheet show what plays at the sketch's frames."""

import numpy as np
import pytest

from mtex_usd.review.page import build_page
from mtex_usd.review.places import place_joints
from mtex_usd.review.sheet import build_sheet
from tests.review.support import copy_samples, make_review, play, write_result

EDITED = """#usda 1.0
(
    endTimeCode = 170
    framesPerSecond = 24
    metersPerUnit = 0.01
    startTimeCode = 0
    subLayers = [@./walk.usda@]
    timeCodesPerSecond = 24
    upAxis = "Y"
)

over "Humanoid"
{{
    over "Sketch" (prepend apiSchemas = ["MtexEditStackAPI", "MtexEditAPI:time"])
    {{
        uniform token[] mtex:edits:after = ["time"]
        uniform int mtex:paths = 1
        {edit}
    }}
}}
"""
SLOWER = """uniform token mtex:edit:time:op = "scaleTime"
        uniform double mtex:edit:time:factor = 1.25"""
FASTER = """uniform token mtex:edit:time:op = "scaleTime"
        uniform double mtex:edit:time:factor = 0.6"""


@pytest.fixture
def samples(tmp_path):
    return copy_samples(tmp_path)


@pytest.mark.parametrize("edit", [SLOWER, FASTER], ids=["slower", "faster"])
def test_shown_is_what_plays_at_the_frames_of_the_sketch(samples, edit):
    shot = samples / "edited.usda"
    shot.write_text(EDITED.format(edit=edit))
    (character,) = make_review(shot).characters
    times = character.sketch.time_codes
    (variant,) = character.variants
    np.testing.assert_array_equal(variant.clip.time_codes, times)
    played = play(write_result(shot), "path_01", times.tolist())
    np.testing.assert_allclose(place_joints(variant.clip), played, atol=0.175)  # 1e-3 of the height


@pytest.mark.parametrize(("edit", "last"), [(SLOWER, "212"), (FASTER, "102")], ids=["slower", "faster"])
def test_says_how_long_it_is(samples, edit, last):
    shot = samples / "edited.usda"
    shot.write_text(EDITED.format(edit=edit))
    review = make_review(shot)
    assert any(f"0 to {last} long; shown is 0 to 170" in note for note in review.characters[0].notes)


def test_page_and_sheet_are_made_of_it(samples):
    shot = samples / "edited.usda"
    shot.write_text(EDITED.format(edit=SLOWER))
    review = make_review(shot)
    assert "shown is 0 to 170" in build_page(review)
    assert build_sheet(review).startswith(b"\x89PNG")


def test_unedited_frames_bring_no_note(samples):
    (character,) = make_review(samples / "walk.usda", paths=1).characters
    assert not any("shown is" in note for note in character.notes)
