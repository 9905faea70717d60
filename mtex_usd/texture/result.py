"""What the method gives: finished variants and everything needed to check them."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.motion.clip import Clip

__all__ = ["FragmentUse", "TexturedMotion", "Variant"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]


@dataclass(frozen=True)
class FragmentUse:
    """Where one stretch of a variant comes from.

    Parameters
    ----------
    start, end
        Time codes on the sketch, both included.
    take
        The take's name (its prim path).
    take_start, take_end
        Time codes on the take, both included.
    distance
        Matching distance, degrees squared summed over frames.
    scale
        Factor on the copied data, 1 unless scaling is on.
    band
        The band that was matched.
    """

    start: float
    end: float
    take: str
    take_start: float
    take_end: float
    distance: float
    scale: float
    band: int


@dataclass(frozen=True, eq=False)
class Variant:
    """One finished version of the sketch.

    Parameters
    ----------
    rank
        1 is the best.
    distance
        Sum of the fragments' matching distances.
    zero_cost_joins
        How many joins were consecutive in their take.
    fragments
        One per sketch fragment.
    clip
        The result on all joints of the skeleton.
    joined
        The joined path before texturing and synthesis, shape [F, C]; columns as `TexturedMotion.channels`.
    curves
        The result in the same columns, shape [F, C].
    """

    rank: int
    distance: float
    zero_cost_joins: int
    fragments: tuple[FragmentUse, ...]
    clip: Clip
    joined: FloatArray
    curves: FloatArray


@dataclass(frozen=True, eq=False)
class TexturedMotion:
    """All variants of one sketch on one character.

    Parameters
    ----------
    sketch
        The sketch on the frame grid.
    channels
        Full tokens of the copied channels, length C. Where a joint's three rotations share their roles its columns are
        a rotation vector about its mean rotation, else Euler angles in `rotation_orders`; degrees and stage units.
    sketch_curves
        The sketch in the same columns, shape [F, C].
    textured, synthesized
        How far each column is textured and synthesized at each frame, 0 to 1, shape [F, C].
    rotation_orders
        Euler order by joint path, for every joint with a role for one of its rotations.
    mean_rotations
        By joint path, real first, in skeleton axes (the root's in the facing frame), for every joint copied as a
        vector.
    breaks
        Frames of the sketch's breaks, shape [Q + 1].
    variants
        Best first.
    notes
        What a user should know: takes skipped, limits lifted, fewer variants than asked.
    """

    sketch: Clip
    channels: tuple[str, ...]
    sketch_curves: FloatArray
    textured: FloatArray
    synthesized: FloatArray
    rotation_orders: Mapping[str, str]
    mean_rotations: Mapping[str, FloatArray]
    breaks: IntArray
    variants: tuple[Variant, ...]
    notes: tuple[str, ...]
