"""A clip: every joint of a skeleton at every frame."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.errors import InputError
from mtex_usd.motion.skeleton import FloatArray, IntArray, Skeleton

__all__ = ["Clip"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Clip:
    """A motion sampled at even intervals on the joints of one skeleton.

    Parameters
    ----------
    skeleton
        The skeleton whose joints, in its order, the arrays follow.
    rate
        Frames per second.
    rotations
        Relative to the parent, real part first, shape [F, J, 4].
    translations
        Relative to the parent, in stage units, shape [F, J, 3].
    scales
        Shape [F, J, 3].
    start
        Time code of the first frame.
    time_codes_per_frame
        How far one frame is in time codes (timeCodesPerSecond / rate).
    name
        What messages call it, usually a prim path.

    Raises
    ------
    InputError
        Where the shapes do not fit, there is no frame, or the rate is not positive.
    """

    skeleton: Skeleton
    rate: float
    rotations: FloatArray
    translations: FloatArray
    scales: FloatArray
    start: float = 0.0
    time_codes_per_frame: float = 1.0
    name: str = ""

    def __post_init__(self) -> None:
        """Check that the shapes fit each other."""
        frames, joints = len(self.rotations), len(self.skeleton.joints)
        shapes = (self.rotations.shape, self.translations.shape, self.scales.shape)
        expected = ((frames, joints, 4), (frames, joints, 3), (frames, joints, 3))
        if shapes != expected:
            raise InputError(f"clip {self.name}: shapes do not fit", expected=str(expected), found=str(shapes))
        if frames == 0:
            raise InputError(f"clip {self.name} has no frames", expected="at least one frame")
        if not (self.rate > 0.0 and np.isfinite(self.rate)):
            raise InputError(f"clip {self.name}: bad rate", expected="frames per second above 0", found=str(self.rate))

    @property
    def joints(self) -> tuple[str, ...]:
        """Joint paths, length J."""
        return self.skeleton.joints

    @property
    def parents(self) -> IntArray:
        """Index of each joint's parent, -1 for a root, shape [J]."""
        return self.skeleton.parents

    @property
    def rest(self) -> FloatArray:
        """Rest transforms relative to the parent, shape [J, 4, 4], USD layout."""
        return self.skeleton.rest

    @property
    def frame_count(self) -> int:
        """How many frames there are (F)."""
        return len(self.rotations)

    @property
    def time_codes(self) -> npt.NDArray[np.float64]:
        """Time code of every frame, shape [F]."""
        return self.start + self.time_codes_per_frame * np.arange(self.frame_count, dtype=np.float64)
