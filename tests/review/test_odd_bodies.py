"""Figures that are no humanoids, and notes longer than the panel: both are to be seen whole."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.review.body import describe_body, find_bones
from mtex_usd.review.page import build_page
from tests.review.browser import find_chromium, open_browser, open_page
from tests.review.support import copy_samples, make_review

UPRIGHT, FLAT = np.array([0.0, 2.0, 0.0]), np.array([0.0, 0.0, 2.0])


def make_chain(step, count):
    rest = np.tile(np.eye(4), (count, 1, 1))
    rest[1:, 3, :3] = step
    joints = ["/".join(f"j{number}" for number in range(last + 1)) for last in range(count)]
    return Skeleton(joints=tuple(joints), rest=rest, up=np.array([0.0, 1.0, 0.0]))


@pytest.mark.parametrize("step", [UPRIGHT, FLAT], ids=["upright", "flat"])
@pytest.mark.parametrize("count", [2, 3, 4])
def test_chains_of_few_bones_are_drawn_whole(step, count):
    skeleton = make_chain(step, count)
    bones = find_bones(skeleton, skeleton.rest_positions)
    assert bones == tuple((joint, joint + 1) for joint in range(count - 1))


def test_what_lies_flat_has_a_height_to_be_shown_at():
    skeleton = make_chain(FLAT + np.array([0.0, 1e-12, 0.0]), 9)
    body = describe_body(skeleton, np.repeat(skeleton.rest_positions[None], 5, axis=0))
    assert body.height == pytest.approx(16.0 / 4.0)


@pytest.mark.skipif(find_chromium() is None, reason="no chromium; set MTEX_CHROMIUM to one")
def test_long_notes_stay_in_their_panel(tmp_path):
    pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    review = make_review(copy_samples(tmp_path) / "walk.usda", paths=1)
    noted = replace(review.characters[0], notes=("take is left out: it has no " + "/Fight_Spine" * 40,))
    page = tmp_path / "noted.html"
    page.write_text(build_page(replace(review, characters=(noted,))), "utf-8")
    with open_browser() as browser, open_page(browser, page) as opened:
        notes = opened.evaluate(
            "() => { const list = document.getElementById('notes'); return [list.scrollWidth, list.clientWidth]; }"
        )
    assert notes[0] <= notes[1]
