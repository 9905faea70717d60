"""The review page in a browser: what is drawn is what USD plays, all of it works, and nothing is fetched."""

import io
import itertools
from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.motion import quaternion
from mtex_usd.review.places import place_joints
from mtex_usd.review.sheet import SKETCH_COLOUR, VARIANT_COLOURS
from mtex_usd.reviewing import build_report
from tests.review.browser import find_chromium, open_browser, open_page
from tests.review.support import COMMAND, copy_samples, make_review, play, write_result

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
pytestmark = pytest.mark.skipif(find_chromium() is None, reason="no chromium; set MTEX_CHROMIUM to one")

HEIGHT_CM = 175.0
FRAMES = (0, 67, 170)


@pytest.fixture(scope="module")
def samples(tmp_path_factory):
    return copy_samples(tmp_path_factory.mktemp("samples"))


@pytest.fixture(scope="module")
def review(samples):
    return make_review(samples / "walk.usda")


@pytest.fixture(scope="module")
def report(samples, review):
    file_path = samples / "review.html"
    file_path.write_bytes(build_report(review))
    return file_path


@pytest.fixture(scope="module")
def held_report(samples):
    review = make_review(samples / "walk.usda", contacts="detect", paths=2)
    file_path = samples / "held.html"
    file_path.write_bytes(build_report(review))
    return review, file_path


@pytest.fixture(scope="module")
def browser():
    with open_browser() as opened:
        yield opened


@pytest.fixture
def shown(browser, report):
    with open_page(browser, report) as opened:
        yield opened


def drawn_positions(shown, name, frame):
    values = shown.evaluate("([name, frame]) => [...mtexReview.jointPositions(name, frame)]", [name, frame])
    return np.array(values, dtype=float).reshape(-1, 3)


def state(shown):
    return shown.evaluate(
        "() => ({ frame: mtexReview.player.frame, variant: mtexReview.player.variant, "
        "playing: mtexReview.player.playing, loop: mtexReview.player.loop })"
    )


def figures(shown):
    shown.settle()
    return {figure["name"]: figure for figure in shown.evaluate("() => mtexReview.figures()")}


def canvas_pixels(shown):
    """What the canvas shows, without what lies over it and the mark of its focus, shape [H, W, 3]."""
    image_module = pytest.importorskip("PIL.Image")
    shown.page.add_style_tag(content=".labels, .view-top, .view-bottom { visibility: hidden; }")
    shown.settle()
    image = image_module.open(io.BytesIO(shown.page.locator("#canvas").screenshot()))
    return np.asarray(image.convert("RGB"), int)[8:-8, 8:-8]


def count_near(pixels, colour, within=14):
    wanted = np.array([int(colour[at : at + 2], 16) for at in (1, 3, 5)])
    return int((np.abs(pixels - wanted).max(axis=-1) <= within).sum())


def test_joints_are_drawn_where_usdskel_has_them(shown, samples, review):
    written = write_result(samples / "walk.usda")
    (character,) = review.characters
    codes = character.sketch.time_codes[list(FRAMES)].tolist()
    for name in ("sketch", *(variant.name for variant in character.variants)):
        expected = play(written, "original" if name == "sketch" else name, codes)
        drawn = np.array([drawn_positions(shown, name, frame) for frame in FRAMES])
        assert np.isfinite(drawn).all()
        assert np.abs(drawn - expected).max() < 1e-3 * HEIGHT_CM, name


def test_the_sketch_and_its_variants_differ_as_drawn(shown):
    apart = drawn_positions(shown, "path_01", 60) - drawn_positions(shown, "sketch", 60)
    assert np.linalg.norm(apart, axis=1).max() > 0.1 * HEIGHT_CM


def test_nothing_is_fetched_and_nothing_goes_wrong_whatever_is_pressed(browser, report):
    with open_page(browser, report) as shown:
        keys = [
            *"kkitscgfvvhhnp123?",
            "Escape",
            "ArrowLeft",
            "Shift+ArrowRight",
            "Home",
            "End",
            "[",
            "]",
            "o",
            "x",
            "r",
        ]
        for key in keys:
            shown.press(key)
            shown.settle()
        for name in ("Front", "Side", "Top", "3/4"):
            shown.page.get_by_role("button", name=name, exact=True).click()
        shown.page.locator("#theme").click()
        shown.page.locator("#copy-recipe").click()
        shown.page.locator("#plots").scroll_into_view_if_needed()
        shown.settle()
        assert shown.complaints == []
        assert [url for url in shown.requests if not url.startswith(("data:", "blob:"))] == [report.resolve().as_uri()]


def test_scrubbing_shows_the_frame(shown):
    shown.page.locator("#scrub").fill("42")
    assert state(shown)["frame"] == 42
    assert shown.page.get_by_label("Time code").input_value() == "42"
    shown.page.locator("#canvas").focus()
    shown.press("ArrowRight", "ArrowRight", "ArrowLeft")
    assert state(shown)["frame"] == 43
    shown.press("Shift+ArrowRight")
    assert state(shown)["frame"] == 67
    shown.press("End")
    assert state(shown)["frame"] == 170


def test_a_time_code_typed_in_is_gone_to(shown):
    shown.page.get_by_label("Time code").fill("33")
    shown.press("Enter")
    assert state(shown)["frame"] == 33


def test_playing_stays_in_the_loop_and_runs_at_its_speed(shown):
    shown.evaluate("() => { mtexReview.player.setLoop(10, 20); mtexReview.player.setSpeed(2); }")
    shown.evaluate("() => { window.seen = []; mtexReview.player.onFrame((frame) => seen.push(frame)); }")
    shown.press("Home", "k")
    shown.page.wait_for_timeout(900)
    shown.press("k")
    seen = shown.evaluate("() => seen")[1:]
    assert state(shown)["playing"] is False
    assert set(seen) <= set(range(10, 21))
    # 0.9 s at twice 24 frames/s is 43 frames: nearly four rounds, however busy the machine at least one.
    assert any(later < earlier for earlier, later in itertools.pairwise(seen))


def test_variants_are_chosen_by_table_label_and_key(shown):
    shown.page.get_by_label("Choose path_03").check()
    assert state(shown)["variant"] == "path_03"
    shown.page.locator(".labels button", has_text="path_02").click()
    assert state(shown)["variant"] == "path_02"
    assert shown.page.get_by_label("Choose path_02").is_checked()
    shown.press("5")
    assert state(shown)["variant"] == "path_05"
    shown.press("n")
    assert state(shown)["variant"] == "path_01"


def test_side_by_side_keeps_figures_apart_and_overlay_puts_them_together(shown):
    apart = figures(shown)
    assert list(apart) == ["sketch", "path_01", "path_02", "path_03", "path_04", "path_05"]
    across = [figure["x"] for figure in apart.values()]
    assert across == sorted(across)
    assert np.diff(across).min() > 80
    assert 0 < across[0] < across[-1] < 960
    shown.press("v")
    places = np.array([figure["position"] for figure in figures(shown).values()])
    assert np.ptp(places, axis=0).max() == 0.0


def test_figures_are_hidden_and_shown_again(shown):
    shown.page.get_by_label("Show path_02").uncheck()
    shown.page.get_by_label("Show sketch").uncheck()
    assert list(figures(shown)) == ["path_01", "path_03", "path_04", "path_05"]
    shown.press("h")
    assert list(figures(shown)) == ["sketch", "path_01", "path_03", "path_04", "path_05"]
    shown.press("2")
    assert "path_02" in figures(shown)


def test_every_figure_is_seen_in_its_colour(shown):
    shown.evaluate("() => mtexReview.setFrame(40)")
    pixels = canvas_pixels(shown)
    for colour in (SKETCH_COLOUR, *VARIANT_COLOURS[:5]):
        assert count_near(pixels, colour) > 40, colour


@pytest.mark.parametrize("layer", ["t", "s", "g"])
def test_layers_change_what_is_drawn(shown, layer):
    shown.evaluate("() => mtexReview.setFrame(40)")
    before = canvas_pixels(shown)
    shown.press(layer)
    assert (canvas_pixels(shown) != before).any(axis=-1).sum() > 200
    shown.press(layer)
    assert (canvas_pixels(shown) == before).all()


def test_contact_symbols_stand_where_points_are_held(browser, held_report):
    review, file_path = held_report
    (character,) = review.characters
    with open_page(browser, file_path) as shown:
        for frame in (5, 30, 90):
            shown.evaluate("(frame) => mtexReview.setFrame(frame)", frame)
            drawn = figures(shown)
            assert drawn["sketch"]["contacts"] == 0
            for variant in character.variants:
                held = sum(hold.first <= frame <= hold.last for hold in variant.holds)
                assert drawn[variant.name]["contacts"] == held
        assert any(variant.holds for variant in character.variants)
        assert shown.complaints == []


def test_contacts_cannot_be_switched_where_none_are_held(shown):
    assert shown.page.get_by_role("button", name="Contacts").is_disabled()


def test_dragging_turns_the_camera_and_r_turns_it_back(shown):
    shown.press("t", "g")
    before = canvas_pixels(shown)
    box = shown.page.locator("#canvas").bounding_box()
    shown.page.mouse.move(box["x"] + 300, box["y"] + 60)
    shown.page.mouse.down()
    shown.page.mouse.move(box["x"] + 420, box["y"] + 90, steps=4)
    shown.page.mouse.up()
    assert (canvas_pixels(shown) != before).any(axis=-1).mean() > 0.01
    shown.press("r")
    assert (canvas_pixels(shown) == before).all()


def test_command_and_recipe_are_shown_to_the_letter(shown):
    assert shown.page.locator("#command").text_content() == COMMAND
    assert 'uniform token[] mtex:match = ["LeftUpLeg.rx", "LeftLeg.rx"]' in shown.page.locator("#recipe").text_content()


def test_the_table_tells_rank_distance_and_joins(shown, review):
    best = review.characters[0].variants[0]
    cells = shown.page.locator("#variants tbody tr").nth(1).locator("td").all_text_contents()
    assert cells[0].strip() == "path_01"
    assert cells[1] == "1"
    assert float(cells[2].replace(",", "")) == pytest.approx(best.motion.distance, rel=1e-2)
    assert cells[3] == f"{best.motion.zero_cost_joins}/{len(best.fragments) - 1}"


def test_shortcuts_are_listed(shown):
    shown.press("?")
    dialog = shown.page.get_by_role("dialog")
    assert dialog.is_visible()
    assert dialog.locator("dt").count() == dialog.locator("dd").count() > 12
    shown.press("Escape")
    assert not dialog.is_visible()


@pytest.mark.parametrize("width", [320, 375, 768, 1440])
def test_no_width_scrolls_sideways(browser, report, width):
    with open_page(browser, report, width=width, height=740) as shown:
        shown.page.locator("#plots").scroll_into_view_if_needed()
        shown.settle()
        assert shown.evaluate("() => document.documentElement.scrollWidth") <= width
        assert shown.page.locator("#canvas").bounding_box()["height"] > 250
        assert shown.complaints == []


def test_controls_have_names(shown):
    unnamed = shown.evaluate(
        """() => [...document.querySelectorAll("header button, #player :is(button, input, select), aside input")]
        .filter((each) => !(each.textContent.trim() || each.ariaLabel || each.labels?.length))
        .map((each) => each.outerHTML)"""
    )
    assert unnamed == []


def test_names_with_markup_are_text(browser, samples, tmp_path):
    title = '</script><script>window.bad = 1</script><b>"walk" & co</b>'
    file_path = tmp_path / "review.html"
    file_path.write_bytes(build_report(make_review(samples / "walk.usda", title=title, paths=1)))
    with open_page(browser, file_path) as shown:
        assert shown.page.locator("#title").text_content() == title
        assert shown.page.title() == f"{title} · review"
        assert shown.evaluate("() => window.bad") is None
        assert shown.complaints == []


def test_each_of_several_characters_can_be_looked_at(browser, samples, review, tmp_path):
    other = make_review(samples / "phrase.usda", paths=2)
    file_path = tmp_path / "both.html"
    file_path.write_bytes(build_report(replace(review, characters=(*review.characters, *other.characters))))
    with open_page(browser, file_path) as shown:
        tabs = shown.page.locator("#characters button")
        assert tabs.count() == 2
        shown.press("End", "3")
        tabs.nth(1).click()
        assert list(figures(shown)) == ["sketch", "path_01", "path_02"]
        assert state(shown)["frame"] == 0
        (phrase,) = other.characters
        last = phrase.sketch.frame_count - 1
        shown.press("End")
        assert state(shown)["frame"] == last
        np.testing.assert_allclose(
            drawn_positions(shown, "path_02", last), place_joints(phrase.variants[1].clip)[last], atol=0.02
        )
        tabs.nth(0).click()
        assert len(figures(shown)) == 6
        assert shown.complaints == []


def test_a_z_up_character_stands_on_the_floor(browser, samples, review, tmp_path):
    """The same motion with z up is drawn upright, as wide and as tall as with y up."""
    (character,) = review.characters
    file_path = tmp_path / "z_up.html"
    file_path.write_bytes(build_report(replace(review, characters=(turn_to_z_up(character),))))
    with open_page(browser, file_path) as shown:
        shown.press("t")
        turned = canvas_pixels(shown)
        assert shown.complaints == []
    y_up = tmp_path / "y_up.html"
    y_up.write_bytes(build_report(review))
    with open_page(browser, y_up) as shown:
        shown.press("t")
        upright = canvas_pixels(shown)
    assert (turned != upright).any(axis=-1).mean() < 0.01


def turn_to_z_up(character):
    """The same motion in a space turned a quarter about x."""
    quarter = quaternion.exp(np.array([np.pi / 2.0, 0.0, 0.0]))

    def turn(clip):
        skeleton = clip.skeleton
        rest = np.array(skeleton.rest)
        rows = quaternion.rotate(quarter, np.eye(3))
        rest[0] = np.block([[rest[0, :3, :3] @ rows, np.zeros((3, 1))], [rest[0, 3, :3] @ rows, 1.0]])
        rotations, translations = np.array(clip.rotations), np.array(clip.translations)
        rotations[:, 0] = quaternion.multiply(quarter, rotations[:, 0])
        translations[:, 0] = quaternion.rotate(quarter, translations[:, 0])
        up = replace(skeleton, rest=rest, up=np.array([0.0, 0.0, 1.0]))
        return replace(clip, skeleton=up, rotations=rotations, translations=translations)

    motions = tuple(replace(variant.motion, clip=turn(variant.clip)) for variant in character.variants)
    variants = tuple(replace(v, motion=motion) for v, motion in zip(character.variants, motions, strict=True))
    texturing = replace(character.texturing, sketch=turn(character.sketch), variants=motions)
    return replace(character, texturing=texturing, variants=variants, takes=tuple(map(turn, character.takes)))
