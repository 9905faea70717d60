"""What the page is told of one character: plain data and packed arrays."""

from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from mtex_usd.constraints.kinematics import pose_skeleton
from mtex_usd.constraints.planting import Hold
from mtex_usd.motion.clip import Clip
from mtex_usd.review.body import Body, describe_body
from mtex_usd.review.numbers import Measure
from mtex_usd.review.packing import pack_array, pack_places
from mtex_usd.review.places import place_joints
from mtex_usd.review.plots import build_plots
from mtex_usd.review.recipe_text import recipe_to_usda
from mtex_usd.review.shot import ReviewedCharacter, ReviewedVariant

__all__ = ["describe_character"]


def describe_character(character: ReviewedCharacter) -> dict[str, object]:
    """Give all that the page shows of one character, ready for JSON.

    Parameters
    ----------
    character
        One sketch with its variants.
    """
    sketch = character.sketch
    places = place_joints(sketch)
    measure = Measure(character)
    return {
        "anim": character.anim,
        "model": character.model,
        "variantSet": character.variant_set,
        "rate": sketch.rate,
        "start": sketch.start,
        "timeCodesPerFrame": sketch.time_codes_per_frame,
        "frameCount": sketch.frame_count,
        "breaks": character.texturing.breaks.tolist(),
        "notes": list(character.notes),
        "recipe": recipe_to_usda(character.recipe),
        "body": _describe_body(sketch, describe_body(sketch.skeleton, places)),
        "sketch": {"places": pack_places(places), "numbers": asdict(measure.measure(sketch))},
        "variants": [_describe_variant(variant, measure) for variant in character.variants],
        "plots": build_plots(character),
    }


def _describe_body(sketch: Clip, body: Body) -> dict[str, object]:
    skeleton = sketch.skeleton
    return {
        "joints": [joint.rpartition("/")[2] for joint in skeleton.joints],
        "bones": body.bones,
        "sides": body.sides,
        "head": body.head,
        "ends": body.ends,
        "up": skeleton.up.tolist(),
        "front": body.front.tolist(),
        "height": body.height,
        "floor": body.floor,
        "metersPerUnit": skeleton.meters_per_unit,
    }


def _describe_variant(variant: ReviewedVariant, measure: Measure) -> dict[str, object]:
    motion = variant.motion
    return {
        "name": variant.name,
        "rank": motion.rank,
        "distance": motion.distance,
        "zeroCostJoins": motion.zero_cost_joins,
        "joins": max(len(variant.fragments) - 1, 0),
        "places": pack_places(place_joints(variant.clip)),
        "contacts": _describe_contacts(variant.holds, variant.clip),
        "numbers": asdict(measure.measure(variant.clip)),
    }


def _describe_contacts(holds: Sequence[Hold], clip: Clip) -> list[dict[str, object]]:
    """Give when points are held and where they are then, places packed with shape [N, 3]."""
    if not holds:
        return []
    pose = pose_skeleton(clip.skeleton, clip.rotations, clip.translations)
    return [
        {
            "name": hold.name,
            "first": hold.first,
            "last": hold.last,
            "places": pack_array(pose.place(hold.joint, np.asarray(hold.offset))[hold.first : hold.last + 1]),
        }
        for hold in holds
    ]
