"""What a reduced motion may be off by."""

from dataclasses import dataclass

__all__ = ["Tolerance"]


@dataclass(frozen=True, kw_only=True)
class Tolerance:
    """What a reduced motion may be off by.

    Parameters
    ----------
    degrees
        Of the angle between a joint's rotations.
    metres
        Of the distance between a joint's places in skeleton space.
    """

    degrees: float
    metres: float
