"""The plots in the page: all of them drawn, their numbers those of the result, and tied to the player."""

import json

import numpy as np
import pytest

from mtex_usd.reviewing import build_report
from tests.oracle import pyramid as pyramid_twin
from tests.review.browser import find_chromium, open_browser, open_page
from tests.review.plots_support import unpack_rows
from tests.review.support import copy_samples, make_review

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
pytestmark = pytest.mark.skipif(find_chromium() is None, reason="no chromium; set MTEX_CHROMIUM to one")

PLOTS = ["strip", "curves", "keyed", "bands", "matches", "candidates", "joins", "correlation", "contacts"]

# How much of each canvas of a plot is not empty, and how many shapes its SVG pictures have.
INK = """(id) => {
  const node = document.querySelector(`[data-plot=${id}]`);
  const filled = (canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let count = 0;
    for (let i = 3; i < data.length; i += 4) count += data[i] > 0;
    return count;
  };
  return {
    canvases: [...node.querySelectorAll("canvas")].map(filled),
    shapes: node.querySelectorAll("svg[role=img] :is(rect, line, circle, text)").length,
  };
}"""


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    samples = copy_samples(tmp_path_factory.mktemp("plots"))
    file_path = samples / "review.html"
    file_path.write_bytes(build_report(make_review(samples / "walk.usda", contacts="detect", paths=3)))
    return file_path


@pytest.fixture(scope="module")
def browser():
    with open_browser() as opened:
        yield opened


@pytest.fixture
def shown(browser, report):
    with open_page(browser, report) as opened:
        yield opened
        assert opened.complaints == []
        assert [url for url in opened.requests if not url.startswith(("file:", "data:"))] == []


def plot(shown, name):
    """Bring one plot into view and wait until it is drawn."""
    node = shown.page.locator(f"[data-plot={name}]")
    node.scroll_into_view_if_needed()
    shown.page.wait_for_function("(id) => document.querySelector(`[data-plot=${id}]`).dataset.drawn", arg=name)
    shown.settle()
    return node


def frame(shown):
    return shown.evaluate("() => mtexReview.player.frame")


def plots_data(shown):
    return shown.evaluate("() => JSON.parse(document.getElementById('mtex-data').textContent)")["characters"][0][
        "plots"
    ]


@pytest.mark.parametrize("width", [1440, 375])
def test_every_plot_is_there_and_drawn(browser, report, width):
    with open_page(browser, report, width=width) as shown:
        found = shown.evaluate("() => [...document.querySelectorAll('[data-plot]')].map((node) => node.dataset.plot)")
        assert found == PLOTS
        for name in PLOTS:
            node = plot(shown, name)
            assert node.locator("h3").inner_text() != ""
            assert len(node.locator(".plots-how").inner_text()) > 40
            ink = shown.evaluate(INK, name)
            assert ink["canvases"] or ink["shapes"] > 10
            assert all(filled > 500 for filled in ink["canvases"])
        assert shown.evaluate("() => document.documentElement.scrollWidth <= innerWidth")
        assert shown.complaints == []


def test_plots_out_of_view_wait(shown):
    drawn = "() => [...document.querySelectorAll('[data-plot]')].filter((node) => node.dataset.drawn).length"
    assert shown.evaluate(drawn) < len(PLOTS)


def test_no_text_is_too_small(shown):
    for name in PLOTS:
        plot(shown, name)
    sizes = shown.evaluate(
        "() => [...document.querySelectorAll('#plots *')].filter((node) => node.childNodes.length && "
        "[...node.childNodes].some((child) => child.nodeType === 3 && child.textContent.trim()))"
        ".map((node) => parseFloat(getComputedStyle(node).fontSize))"
    )
    assert min(sizes) >= 11


def test_pictures_say_what_they_show(shown):
    for name in PLOTS:
        node = plot(shown, name)
        labels = node.locator("[role=img]").evaluate_all("(nodes) => nodes.map((node) => node.ariaLabel ?? '')")
        assert labels
        assert all(len(label) > 15 for label in labels)


def test_packed_curves_are_read_back(shown):
    plots = plots_data(shown)
    row = plots["curves"]["columns"][3]
    read = shown.evaluate(
        "async ([packed, row, part]) => [...(await import('mtex/plots_data.js')).unpackRow(packed, row, part)]",
        [plots["curves"]["finished"], row, 1],
    )
    np.testing.assert_allclose(read, unpack_rows(plots["curves"]["finished"]).values[row, 1], atol=1e-12)


@pytest.mark.parametrize("frames", [3, 24, 101])
def test_bands_are_those_of_the_pyramid(shown, frames):
    curve = np.cumsum(np.random.default_rng(frames).standard_normal(frames))
    split = shown.evaluate(
        "async ([curve, count]) => { const { bands, residual } = (await import('mtex/plots_pyramid.js'))"
        ".decompose(Float64Array.from(curve), count); return [...bands, residual].map((band) => [...band]); }",
        [curve.tolist(), pyramid_twin.count_bands(frames)],
    )
    bands, residual = pyramid_twin.decompose(curve)
    np.testing.assert_allclose(split, [*bands, residual], atol=1e-12)
    np.testing.assert_allclose(np.sum(split, axis=0), curve, atol=1e-12)


def test_gaps_at_joins_keep_every_value(shown):
    plots = plots_data(shown)
    gapped, times = shown.evaluate(
        "async (raw) => { const { PlotData } = await import('mtex/plots_data.js'); const data = new PlotData(raw);"
        " return [data.capturedWithGaps(data.curves.joins.columns[0], 0), [...data.gapped]]; }",
        plots,
    )
    captured = unpack_rows(plots["curves"]["joins"]["captured"]).values[0, 0]
    np.testing.assert_allclose([value for value in gapped if value is not None], captured, atol=1e-12)
    assert len(gapped) == len(times) == len(captured) + len(plots["fragments"]) - 1
    assert times == sorted(times)


def test_a_click_in_a_curve_goes_to_that_time(shown):
    over = plot(shown, "curves").locator(".u-over")
    box = over.bounding_box()
    shown.page.mouse.click(box["x"] + box["width"] * 0.5, box["y"] + box["height"] * 0.5)
    count = shown.evaluate("() => mtexReview.player.frameCount")
    assert abs(frame(shown) - (count - 1) / 2) <= 2


def test_arrow_keys_on_a_curve_step_once(shown):
    plot(shown, "curves").locator(".plots-chart").focus()
    shown.press("ArrowRight", "ArrowRight", "ArrowLeft", "PageDown")
    assert frame(shown) == 13


def test_cursors_follow_the_player(shown):
    chart = plot(shown, "curves")
    places = []
    for at in (10, 50):
        shown.evaluate("(frame) => mtexReview.setFrame(frame)", at)
        shown.settle()
        now, over = (chart.locator(selector).bounding_box() for selector in (".plots-now", ".u-over"))
        places.append((now["x"] + now["width"] / 2 - over["x"]) / over["width"])
    last = shown.evaluate("() => mtexReview.player.frameCount") - 1
    np.testing.assert_allclose(np.diff(places), 40 / last, atol=0.01)


def test_readouts_are_values_of_the_curves(shown):
    plots = plots_data(shown)
    node = plot(shown, "curves")
    shown.evaluate("() => mtexReview.setFrame(20)")
    shown.settle()
    column = int(node.locator("select").input_value())
    row = plots["curves"]["columns"].index(column)
    expected = unpack_rows(plots["curves"]["finished"]).values[row, 0, 20]
    text = node.locator("button[data-name=path_01] .plots-value").inner_text()
    assert float(text.rstrip("°")) == pytest.approx(expected, abs=max(0.006, 0.006 * abs(expected)))


def test_another_variant_is_drawn(shown):
    node = plot(shown, "candidates")
    before = node.locator(".plots-note").first.inner_text()
    assert before.startswith("path_01: ")
    shown.evaluate("() => mtexReview.setVariant('path_02')")
    shown.settle()
    assert node.locator(".plots-note").first.inner_text().startswith("path_02: ")
    assert node.locator(".plots-chosen").count() == len(plots_data(shown)["fragments"])


def test_the_strip_chooses_variant_and_fragment(shown):
    node = plot(shown, "strip")
    strips = node.locator("svg.plots-strip")
    assert strips.count() == 3
    pieces = strips.nth(1).locator(".plots-piece")
    assert pieces.count() == len(plots_data(shown)["fragments"])
    pieces.nth(2).hover()
    assert "path_02, fragment 3" in shown.page.locator(".plots-tip").inner_text()
    box = pieces.nth(2).bounding_box()
    shown.page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    assert shown.evaluate("() => mtexReview.player.variant") == "path_02"
    assert plots_data(shown)["fragments"][2]["first"] <= frame(shown) <= plots_data(shown)["fragments"][2]["last"]


def test_strips_fill_their_width_without_holes(shown):
    node = plot(shown, "strip")
    boxes = (
        node.locator("svg.plots-strip")
        .first.locator(".plots-piece")
        .evaluate_all(
            "(nodes) => nodes.map((node) => [Number(node.getAttribute('x')), Number(node.getAttribute('width'))])"
        )
    )
    ends = np.add(*np.transpose(boxes))
    np.testing.assert_allclose(ends[:-1], np.transpose(boxes)[0][1:], atol=1e-6)
    width = float(node.locator("svg.plots-strip").first.get_attribute("width"))
    assert (boxes[0][0], ends[-1]) == (0.0, pytest.approx(width))


def test_channels_are_found_by_name_and_shared_by_plots(shown):
    node = plot(shown, "curves")
    node.locator("input[type=search]").fill("head ry")
    options = node.locator("option").all_inner_texts()
    assert options
    assert all("Head" in option and "ry" in option for option in options)
    node.locator("input[type=search]").press("Enter")
    chosen = node.locator("select").input_value()
    assert plot(shown, "joins").locator("select").first.input_value() == chosen
    node.locator("input[type=search]").fill("no such joint")
    assert node.locator("option").count() == 0


def test_a_name_in_the_legend_hides_its_curve(shown):
    node = plot(shown, "curves")
    key = node.locator("button[data-name=sketch]")
    assert key.get_attribute("aria-pressed") == "true"
    before = shown.evaluate(INK, "curves")["canvases"][0]
    key.focus()
    shown.press("Enter")
    shown.settle()
    assert node.locator("button[data-name=sketch]").get_attribute("aria-pressed") == "false"
    assert shown.evaluate(INK, "curves")["canvases"][0] != before
    assert shown.evaluate("() => document.activeElement.dataset.name") == "sketch"


def test_fragments_are_chosen_by_button_and_list_their_candidates(shown):
    plots = plots_data(shown)
    node = plot(shown, "matches")
    node.get_by_role("button", name="Next fragment").click()
    shown.settle()
    fragment = plots["fragments"][1]
    assert frame(shown) == fragment["first"]
    assert node.locator(".plots-list tbody tr").count() == len(fragment["take"])
    assert node.locator(".plots-list tr.selected td").first.inner_text() == str(plots["variants"][0]["choice"][1] + 1)
    node.get_by_role("button", name="as recorded").click()
    shown.settle()
    assert node.get_by_role("button", name="as recorded").get_attribute("aria-pressed") == "true"


def test_a_part_of_the_shot_follows_the_player(shown):
    plot(shown, "curves")
    shown.page.get_by_role("group", name="Time shown in the curves").get_by_role("button", name="1.5 s").click()
    for at in (5, 100):
        shown.evaluate("(frame) => mtexReview.setFrame(frame)", at)
        shown.settle()
        curves = shown.page.locator("[data-plot=curves]")
        now, over = (curves.locator(part).bounding_box() for part in (".plots-now", ".u-over"))
        assert over["x"] - 2 <= now["x"] <= over["x"] + over["width"] + 2
        assert curves.locator(".plots-now").evaluate("(node) => node.style.visibility") == "visible"


COMMONEST_COLOUR = """() => {
  const canvas = document.querySelector("[data-plot=curves] canvas");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const seen = {};
  for (let i = 0; i < data.length; i += 4) {
    if (data[i + 3] < 255) continue;
    const key = data.slice(i, i + 3).join();
    seen[key] = (seen[key] ?? 0) + 1;
  }
  return Object.entries(seen).sort((a, b) => b[1] - a[1])[0][0];
}"""


def test_colours_change_with_the_scheme(shown):
    plot(shown, "curves")
    before = shown.evaluate(COMMONEST_COLOUR)
    shown.page.locator("#theme").click()
    shown.settle()
    assert shown.evaluate(COMMONEST_COLOUR) != before


MOUNT_ELSEWHERE = """async (raw) => {
  const { mountPlots } = await import("mtex/plots.js");
  const root = document.createElement("section");
  root.id = "elsewhere";
  document.querySelector("#plots").replaceWith(root);
  window.mounted = mountPlots(root, raw, mtexReview.player);
}"""


def test_channels_left_out_for_size_are_replaced_where_they_lack(shown):
    raw = plots_data(shown)
    kept = raw["curves"]["joins"]["columns"][-1]
    raw["curves"]["joins"]["columns"] = [kept]
    raw["curves"]["takes"]["columns"] = [kept]
    shown.evaluate(MOUNT_ELSEWHERE, raw)
    for name in PLOTS:
        plot(shown, name)
    assert plot(shown, "joins").locator("select").first.input_value() == str(kept)
    assert plot(shown, "keyed").locator("select").first.input_value() == str(kept)
    assert "not in this page" in plot(shown, "correlation").inner_text()


def test_a_fragment_that_is_no_candidate_is_drawn_all_the_same(shown):
    raw = plots_data(shown)
    raw["variants"][0]["choice"][0] = -1
    shown.evaluate(MOUNT_ELSEWHERE, raw)
    for name in PLOTS:
        plot(shown, name)
    assert plot(shown, "candidates").locator(".plots-chosen").count() == len(raw["fragments"]) - 1


def test_what_was_mounted_can_be_taken_away(shown):
    shown.evaluate(MOUNT_ELSEWHERE, plots_data(shown))
    before = shown.evaluate("() => mtexReview.player.listeners.frame.size")
    plot(shown, "curves")
    shown.evaluate("() => mounted.destroy()")
    assert shown.evaluate("() => document.querySelector('#elsewhere').childNodes.length") == 0
    assert shown.evaluate("() => mtexReview.player.listeners.frame.size") == before - 1
    shown.evaluate("() => { mtexReview.setFrame(7); window.dispatchEvent(new Event('mtex:theme')); }")


def test_following_a_frame_takes_no_time(shown):
    plot(shown, "bands")
    taken = shown.evaluate(
        "() => { const { player } = mtexReview; player.playing = true; const begin = performance.now();"
        " for (let i = 0; i < 100; i += 1) player.emit('frame', i); const took = (performance.now() - begin) / 100;"
        " player.playing = false; return took; }"
    )
    assert taken < 2.0


def test_the_page_holds_the_same_data_that_is_built(shown):
    plots = plots_data(shown)
    assert json.loads(json.dumps(plots, allow_nan=False)) == plots
    assert {"channels", "curves", "takes", "ways", "fragments", "variants", "keys"} <= plots.keys()
