"""How large the review page of a shot is, how soon it can be read, and how fast it plays in software rendering.

``python -m tests.benchmarks.review_page`` builds the page of the speed benchmark's shot (a sketch of 440 frames on 31
joints, 12 takes, 5 variants), opens it in headless Chromium without a graphics card and plays 480 frames (the shot goes
round) of the sketch and the five variants side by side. Any other page can be given as ``--page``.
"""

import argparse
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from mtex_usd.reviewing import build_report
from tests.benchmarks.speed_shot import write_shot
from tests.review.browser import open_browser, open_page
from tests.review.support import make_review

__all__ = ["Measured", "main", "measure_page"]

FRAMES = 480
_PATHS = 5

_PLAY = """(frames) => new Promise((done) => {
  const { player } = mtexReview;
  let seen = 0;
  let begin = 0;
  player.onFrame(() => {
    if (seen === 0) begin = performance.now();
    seen += 1;
    if (seen <= frames) return;
    player.pause();
    done({ rate: (seen - 1) * 1000 / (performance.now() - begin), pixels: mtexReview.pixelRatio });
  });
  player.setFrame(0);
  player.play();
})"""


@dataclass(frozen=True, kw_only=True)
class Measured:
    """What was measured of a page.

    Parameters
    ----------
    megabytes
        Of the file.
    ready_s
        From opening to the first figures drawn, seconds.
    rate
        Frames drawn per second of playing.
    pixel_ratio
        At which it was drawn at the end; less than 1 where the machine was too slow for all pixels.
    """

    megabytes: float
    ready_s: float
    rate: float
    pixel_ratio: float


def measure_page(file_path: Path, *, frames: int = FRAMES) -> Measured:
    """Open a page and play it."""
    with open_browser() as browser:
        browser.new_page().close()  # its processes are up before the clock starts
        begin = time.perf_counter()
        with open_page(browser, file_path) as shown:
            ready = time.perf_counter() - begin
            played = shown.evaluate(_PLAY, frames)
    return Measured(
        megabytes=file_path.stat().st_size / 1e6,
        ready_s=ready,
        rate=played["rate"],
        pixel_ratio=played["pixels"],
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--page", type=Path)
    parser.add_argument("--frames", type=int, default=FRAMES)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        page = given.page or _build_page(Path(folder))
        measured = measure_page(page, frames=given.frames)
    print(f"size          {measured.megabytes:6.2f} MB")
    print(f"readable in   {measured.ready_s:6.2f} s")
    print(f"played        {given.frames} frames at {measured.rate:.2f} frames/s, drawn at {measured.pixel_ratio:g} x")


def _build_page(folder: Path) -> Path:
    review = make_review(write_shot(folder, take_rate=24.0), paths=_PATHS)
    page = folder / "review.html"
    begin = time.perf_counter()
    page.write_bytes(build_report(review))
    print(f"built in      {time.perf_counter() - begin:6.2f} s")
    return page


if __name__ == "__main__":
    main()
