"""The contact sheet: strobed stick figures in a picture, one row per variant, for mails and tickets."""

import numpy as np
import numpy.typing as npt

from mtex_usd.review.numbers import Measure
from mtex_usd.review.places import place_joints
from mtex_usd.review.sheet_drawing import SheetBlock, SheetRow, draw_sheet
from mtex_usd.review.shot import Review, ReviewedCharacter, ReviewedVariant

__all__ = ["SKETCH_COLOUR", "VARIANT_COLOURS", "build_sheet"]

# Those of the page; after Okabe & Ito 2008.
SKETCH_COLOUR = "#6b7480"
VARIANT_COLOURS = ("#d55e00", "#0072b2", "#009e73", "#c2699c", "#b98500", "#3b9fd6", "#8a7f00", "#3d444d")

_COUNT = 14


def build_sheet(review: Review, *, count: int = _COUNT) -> bytes:
    """Draw the contact sheet of a shot.

    Parameters
    ----------
    review
        What is shown.
    count
        Figures per row.

    Returns
    -------
    bytes
        A PNG file; the same review gives the same bytes.
    """
    blocks = [_build_block(character, count) for character in review.characters]
    return draw_sheet(blocks, title=review.title, subtitle=review.command)


def _build_block(character: ReviewedCharacter, count: int) -> SheetBlock:
    sketch = character.sketch
    frames = np.unique(np.linspace(0, sketch.frame_count - 1, count).round().astype(int))
    first = SheetRow(name="sketch", caption=("before",), colour=SKETCH_COLOUR, positions=place_joints(sketch)[frames])
    measure = Measure(character)
    others = [_build_row(variant, i, measure, frames) for i, variant in enumerate(character.variants)]
    return SheetBlock(
        heading=f"{character.anim}  on  {character.model}",
        skeleton=sketch.skeleton,
        time_codes=sketch.time_codes[frames],
        rows=(first, *others),
    )


def _build_row(variant: ReviewedVariant, index: int, measure: Measure, frames: npt.NDArray[np.intp]) -> SheetRow:
    numbers = measure.measure(variant.clip)
    ratios = [f"{name} {value:.2f}" for name, value in (("jerk", numbers.jerk), ("detail", numbers.detail)) if value]
    return SheetRow(
        name=variant.name,
        caption=(
            f"distance {variant.motion.distance:,.0f}",
            f"{variant.motion.zero_cost_joins} of {max(len(variant.fragments) - 1, 0)} joins free",
            "  ".join(ratios),
        ),
        colour=VARIANT_COLOURS[index % len(VARIANT_COLOURS)],
        positions=place_joints(variant.clip)[frames],
    )
