"""The review page: one HTML file with everything in it, which opens from disk without network."""

import html
import json
from importlib import resources

from mtex_usd.review.bundle import read_scripts, read_styles
from mtex_usd.review.character_data import describe_character
from mtex_usd.review.shot import Review

__all__ = ["PAGE_MARK", "build_page"]

PAGE_MARK = '<meta name="generator" content="usdmtex review">'


def build_page(review: Review) -> str:
    """Give the whole page.

    Parameters
    ----------
    review
        What is shown.

    Returns
    -------
    str
        HTML that fetches nothing; a security policy in it keeps it so.
    """
    data = {
        "title": review.title,
        "command": review.command,
        "characters": [describe_character(character) for character in review.characters],
    }
    parts = {
        "generator": PAGE_MARK,
        "title": html.escape(review.title),
        "styles": read_styles(),
        "imports": _in_element(read_scripts()),
        "data": _in_element(json.dumps(data, allow_nan=False, separators=(",", ":"))),
    }
    page = (resources.files("mtex_usd.review") / "static" / "page.html").read_text("utf-8")
    for name, text in parts.items():
        page = page.replace(f"<!--{name}-->", text, 1)
    return page


def _in_element(text: str) -> str:
    """Escape JSON so that nothing in it ends the element it is in."""
    return text.replace("<", "\\u003c")
