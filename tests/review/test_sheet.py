"""The contact sheet: a row for the sketch and one for each variant, and files that are ours alone."""

import io
import itertools
from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.errors import InputError
from mtex_usd.review.places import place_joints
from mtex_usd.review.sheet import SKETCH_COLOUR, VARIANT_COLOURS, build_sheet
from mtex_usd.review.sheet_drawing import SheetBlock, SheetRow, draw_sheet
from mtex_usd.reviewing import build_report, check_report_target, check_sheet_target
from tests.review.support import copy_samples, make_review

Image = pytest.importorskip("PIL.Image", reason="Pillow is not installed")


@pytest.fixture(scope="module")
def review(tmp_path_factory):
    return make_review(copy_samples(tmp_path_factory.mktemp("samples")) / "walk.usda", paths=3)


def to_pixels(png):
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), int)


def rows_of(pixels, colour):
    """Rows of the picture in which a colour is."""
    wanted = np.array([int(colour[at : at + 2], 16) for at in (1, 3, 5)])
    return np.flatnonzero((np.abs(pixels - wanted).max(axis=-1) <= 6).any(axis=1))


def test_the_sketch_and_every_variant_have_a_row_of_their_own(review):
    pixels = to_pixels(build_sheet(review))
    colours = (SKETCH_COLOUR, *VARIANT_COLOURS[:3])
    bars = [rows_of(pixels[:, 24:29], colour) for colour in colours]
    for above, below in itertools.pairwise(bars):
        assert above.max() < below.min()
    for bar, colour in zip(bars, colours, strict=True):
        figures = pixels[bar.min() - 30 : bar.max() + 60, 180:]
        assert rows_of(figures, colour).size > 40
    assert rows_of(pixels, VARIANT_COLOURS[3]).size == 0


def test_the_same_review_gives_the_same_bytes(review):
    assert build_sheet(review) == build_sheet(review)


def test_more_characters_make_a_longer_sheet(review):
    twice = replace(review, characters=review.characters * 2)
    assert to_pixels(build_sheet(twice)).shape[0] > 1.8 * to_pixels(build_sheet(review)).shape[0]


@pytest.mark.parametrize(("in_place", "columns"), [(True, 5), (False, 1)])
def test_figures_that_stay_are_put_side_by_side_where_asked(review, in_place, columns):
    sketch = review.characters[0].sketch
    pose = np.repeat(place_joints(sketch)[:1], 5, axis=0)
    row = SheetRow(name="stays", caption=(), colour="#d55e00", positions=pose)
    block = SheetBlock(heading="", skeleton=sketch.skeleton, time_codes=np.zeros(5), rows=(row,))
    pixels = to_pixels(draw_sheet([block], title="", in_place=in_place))[:, 180:]
    heads = (np.abs(pixels - [213, 94, 0]).max(axis=-1) <= 6).sum(axis=0) > 8
    assert np.count_nonzero(np.diff(heads.astype(int)) == 1) == columns


def test_what_was_written_may_be_written_again_and_is_the_same(review, tmp_path):
    for name, build, check in (
        ("a.png", build_sheet, check_sheet_target),
        ("a.html", build_report, check_report_target),
    ):
        (tmp_path / name).write_bytes(build(review))
        check(tmp_path / name)
        assert (tmp_path / name).read_bytes() == build(review)


@pytest.mark.parametrize(("check", "ending"), [(check_report_target, ".html"), (check_sheet_target, ".png")])
def test_what_others_wrote_is_left_alone(tmp_path, check, ending):
    target = tmp_path / f"mine{ending}"
    target.write_bytes(b"<html>somebody's own</html>")
    with pytest.raises(InputError, match=r"mine\.\w+ exists and was not written by usdmtex"):
        check(target)
    assert target.read_bytes() == b"<html>somebody's own</html>"


@pytest.mark.parametrize(("check", "ending"), [(check_report_target, ".html"), (check_sheet_target, ".png")])
def test_names_and_folders_that_will_not_do_are_refused(tmp_path, check, ending):
    with pytest.raises(InputError, match=rf"expected a name ending in \{ending}"):
        check(tmp_path / "a.txt")
    with pytest.raises(InputError, match="there is no folder"):
        check(tmp_path / "none" / f"a{ending}")
    (tmp_path / f"folder{ending}").mkdir()
    with pytest.raises(InputError, match="it is a folder"):
        check(tmp_path / f"folder{ending}")
    check(tmp_path / f"new{ending}")
