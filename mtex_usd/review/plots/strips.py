"""What each variant is made of over time: takes, fragments, joins, and contacts."""

from mtex_usd.constraints.planting import Hold
from mtex_usd.review.plots.retrace import Joining, Retraced
from mtex_usd.review.shot import ReviewedVariant
from mtex_usd.texture.result import FragmentUse

__all__ = ["describe_takes", "describe_variants"]


def describe_takes(told: Retraced) -> list[dict[str, object]]:
    """Give the takes, in the order candidates count them.

    Parameters
    ----------
    told
        The result with its steps.

    Returns
    -------
    list
        ``name``, the part of it that tells takes apart as ``label``, ``frameCount``, ``start`` (time code of its first
        frame) and ``timeCodesPerFrame``.
    """
    clips = [take.clip for take in told.ground.takes]
    labels = [clip.name.rpartition("/")[2] for clip in clips]
    unique = len(set(labels)) == len(labels)
    return [
        {
            "name": clip.name,
            "label": label if unique else clip.name,
            "frameCount": clip.frame_count,
            "start": clip.start,
            "timeCodesPerFrame": clip.time_codes_per_frame,
        }
        for clip, label in zip(clips, labels, strict=True)
    ]


def describe_variants(told: Retraced) -> list[dict[str, object]]:
    """Give the variants with their fragments and contacts.

    Parameters
    ----------
    told
        The result with its steps.

    Returns
    -------
    list
        ``choice`` is the candidate each fragment is, -1 for none of them; ``continued`` tells for every join whether it
        was consecutive in the take.
    """
    joinings = told.joinings
    return [_describe_variant(told, *pair) for pair in zip(told.character.variants, joinings, strict=True)]


def _describe_variant(told: Retraced, variant: ReviewedVariant, joining: Joining) -> dict[str, object]:
    motion = variant.motion
    return {
        "name": variant.name,
        "rank": motion.rank,
        "distance": motion.distance,
        "zeroCostJoins": motion.zero_cost_joins,
        "choice": told.find_choice(motion),
        "continued": joining.continued.tolist(),
        "fragments": [_describe_use(told, use) for use in variant.fragments],
        "contacts": [_describe_hold(hold) for hold in variant.holds],
    }


def _describe_use(told: Retraced, use: FragmentUse) -> dict[str, object]:
    take, first, last = told.locate(use)
    return {
        "start": use.start,
        "end": use.end,
        "take": take,
        "takeStart": use.take_start,
        "takeEnd": use.take_end,
        "takeFirst": first,
        "takeLast": last,
        "distance": float(f"{use.distance:.6g}"),
        "scale": float(f"{use.scale:.4g}"),
    }


def _describe_hold(hold: Hold) -> dict[str, object]:
    """A point that is held; contacts of one point differ in the number at the end of their names."""
    point, _, number = hold.name.rpartition(" ")
    return {
        "name": hold.name,
        "point": point if point and number.isdigit() else hold.name,
        "first": hold.first,
        "last": hold.last,
    }
