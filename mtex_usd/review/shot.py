"""What is shown of a shot: its sketches, their variants, and all that is known of how they came about."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.planting import Hold
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.recipe import Recipe
from mtex_usd.texture.result import FragmentUse, TexturedMotion, Variant

__all__ = ["Review", "ReviewedCharacter", "ReviewedVariant"]

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class ReviewedVariant:
    """One finished version of a sketch.

    Parameters
    ----------
    name
        Of the variant in the override layer, such as ``path_01``.
    motion
        Its clip with the joined path and the curves it came from, rank, distance and fragments.
    custom_data
        What the variant carries as ``customData["mtex"]`` in the layer.
    holds
        Points that are held in it, by frames of the clip.
    """

    name: str
    motion: Variant
    custom_data: Mapping[str, Any]
    holds: tuple[Hold, ...] = ()

    @property
    def clip(self) -> Clip:
        """The finished motion on all joints of the skeleton, contacts held."""
        return self.motion.clip

    @property
    def fragments(self) -> tuple[FragmentUse, ...]:
        """Where each stretch comes from, one per sketch fragment."""
        return self.motion.fragments


@dataclass(frozen=True, eq=False, kw_only=True)
class ReviewedCharacter:
    """One sketch on one character.

    Parameters
    ----------
    anim, model
        Prim paths of the sketch and of the prim with the variant set.
    variant_set
        Name of the variant set.
    texturing
        All that the method found: sketch, channels, curves, breaks.
    recipe
        The settings it was made with; options of the command are in it.
    takes
        The takes at the sketch's rate, on joints the method could use; their names are those fragments have.
    key_times
        Time codes at which the sketch has authored samples, shape [S]: the animator's keys, or every frame where the
        animation was baked.
    variants
        Best first; ``original`` is the sketch and not among them.
    notes
        What a user should know of this sketch.
    """

    anim: str
    model: str
    variant_set: str
    texturing: TexturedMotion
    recipe: Recipe
    takes: tuple[Clip, ...]
    key_times: FloatArray
    variants: tuple[ReviewedVariant, ...]
    notes: tuple[str, ...] = ()

    @property
    def sketch(self) -> Clip:
        """The motion before the edit, on the frame grid."""
        return self.texturing.sketch

    @property
    def channels(self) -> tuple[str, ...]:
        """Full tokens of the copied channels, length C."""
        return self.texturing.channels


@dataclass(frozen=True, eq=False, kw_only=True)
class Review:
    """A shot to be looked at.

    Parameters
    ----------
    title
        What it is called, usually the stage's file name.
    command
        The exact command that made it, as a shell takes it.
    characters
        One per sketch and character, in stage order.
    """

    title: str
    command: str
    characters: tuple[ReviewedCharacter, ...]
