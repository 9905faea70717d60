"""Driving the page in headless Chromium with Playwright, where both are installed."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

__all__ = ["Opened", "find_chromium", "open_browser", "open_page"]

# What Chromium itself says where it draws without a graphics card.
_SOFTWARE = "GL Driver Message"


def find_chromium() -> str | None:
    """Where a Chromium is: MTEX_CHROMIUM, or on the path."""
    given = os.environ.get("MTEX_CHROMIUM")
    return given or shutil.which("chromium") or shutil.which("google-chrome")


@contextmanager
def open_browser() -> Iterator[Any]:
    """Start a browser that draws in software, so that no graphics card matters."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=find_chromium(), args=["--enable-unsafe-swiftshader"])
        yield browser
        browser.close()


@dataclass
class Opened:
    """A page that was opened, with all it complained of and asked for."""

    page: Any
    complaints: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def evaluate(self, script: str, argument: object = None) -> Any:
        """Run a script in the page."""
        return self.page.evaluate(script, argument)

    def press(self, *keys: str) -> None:
        """Press keys, one after the other."""
        for key in keys:
            self.page.keyboard.press(key)

    def settle(self) -> None:
        """Wait until what changed is drawn."""
        self.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


@contextmanager
def open_page(browser: Any, file_path: Path, *, width: int = 1440, height: int = 900) -> Iterator[Opened]:
    """Open a page from disk and wait until it is ready."""
    page = browser.new_page(viewport={"width": width, "height": height})
    opened = Opened(page)
    page.on("console", lambda message: _note(opened, message))
    page.on("pageerror", lambda error: opened.complaints.append(f"{error.message} {error.stack}"))
    page.on("request", lambda request: opened.requests.append(request.url))
    page.goto(file_path.resolve().as_uri())
    page.wait_for_function("window.mtexReview !== undefined", timeout=20_000)
    opened.settle()
    yield opened
    page.close()


def _note(opened: Opened, message: Any) -> None:
    if message.type in ("error", "warning") and _SOFTWARE not in message.text:
        opened.complaints.append(f"{message.type}: {message.text}")
