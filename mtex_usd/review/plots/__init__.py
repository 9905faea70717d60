"""Data of the plots: what the page draws of how a result came about (Pullen & Bregler 2002, figures 1 to 9)."""

from mtex_usd.review.plots.curves import describe_channels, describe_curves
from mtex_usd.review.plots.matches import describe_fragments, describe_ways
from mtex_usd.review.plots.retrace import retrace
from mtex_usd.review.plots.strips import describe_takes, describe_variants
from mtex_usd.review.shot import ReviewedCharacter

__all__ = ["build_plots"]


def build_plots(character: ReviewedCharacter) -> dict[str, object]:
    """Give the data of all plots of one character.

    Parameters
    ----------
    character
        One sketch with its variants.

    Returns
    -------
    dict
        Ready for JSON; frames count from 0 at the sketch's first, curves are packed channel by channel. A shot too long
        for a page has fewer channels in it; ``curves.left_out`` and ``ways[].left_out`` say how many are not.

    Raises
    ------
    ResultError
        Where takes and recipe are not those the result was made with.
    """
    told = retrace(character)
    return {
        "frameCount": character.sketch.frame_count,
        "rate": character.sketch.rate,
        "start": character.sketch.start,
        "timeCodesPerFrame": character.sketch.time_codes_per_frame,
        "joinFrames": told.join_frames,
        "keys": _key_frames(character),
        "channels": describe_channels(told),
        "curves": describe_curves(told),
        "takes": describe_takes(told),
        "ways": describe_ways(told),
        "fragments": describe_fragments(told),
        "variants": describe_variants(told),
    }


def _key_frames(character: ReviewedCharacter) -> list[float]:
    """Frames of the animator's keys, which may lie between frames."""
    sketch = character.sketch
    frames = (character.key_times - sketch.start) / sketch.time_codes_per_frame
    return [round(float(frame), 3) for frame in frames]
