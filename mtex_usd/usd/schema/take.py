"""MtexTakeAPI: what to know about a recorded take."""

from dataclasses import dataclass

from pxr import Sdf, Usd

from mtex_usd.errors import InputError
from mtex_usd.usd.schema.applied import has_api, where
from mtex_usd.usd.schema.properties import FINITE, TIME_CODE, TOKEN, Property, check_names, read_properties
from mtex_usd.usd.schema.targets import check_dropped

__all__ = ["TAKE_API", "TakeSettings", "read_take_settings"]

TAKE_API = "MtexTakeAPI"

_TAKE_PROPERTIES = (
    Property("start", "start", TIME_CODE, FINITE),
    Property("end", "end", TIME_CODE, FINITE),
    Property("style", "style", TOKEN),
)


@dataclass(frozen=True, kw_only=True)
class TakeSettings:
    """What MtexTakeAPI says about a take.

    Parameters
    ----------
    start, end
        The usable range, both ends included, in time codes of the stage; None means the first or last sample.
    style
        A word for how the take was performed, or nothing.
    skeleton
        The Skeleton the take was recorded on, where it is named.
    """

    start: float | None = None
    end: float | None = None
    style: str = ""
    skeleton: Sdf.Path | None = None


def read_take_settings(prim: Usd.Prim) -> TakeSettings:
    """Read and check what MtexTakeAPI says on a take; defaults where it is not applied.

    Parameters
    ----------
    prim
        The take, a SkelAnimation.

    Returns
    -------
    TakeSettings
        Times in time codes of the stage.

    Raises
    ------
    InputError
        Where a property is misspelt, of the wrong type or not finite, the end comes before the start, or more than one
        skeleton is named.
    StageError
        Where composition dropped the skeleton.
    """
    if not has_api(prim, TAKE_API):
        return TakeSettings()
    prefix = "mtex:take:"
    check_names(prim, prefix, ["skeleton", *(known.name for known in _TAKE_PROPERTIES)])
    settings = TakeSettings(
        **read_properties(prim, prefix, _TAKE_PROPERTIES), skeleton=_read_skeleton(prim, f"{prefix}skeleton")
    )
    if settings.start is not None and settings.end is not None and settings.end < settings.start:
        found = f"{settings.start:g} to {settings.end:g}"
        raise InputError(f"{prim.GetPath()}: the take ends before it starts", expected="start before end", found=found)
    return settings


def _read_skeleton(prim: Usd.Prim, name: str) -> Sdf.Path | None:
    relationship = prim.GetRelationship(name)
    if not relationship:
        return None
    targets = relationship.GetForwardedTargets()
    if len(targets) > 1:
        found = ", ".join(map(str, targets))
        raise InputError(f"{where(prim, name)} is ambiguous", expected="one Skeleton", found=found)
    check_dropped(relationship, targets)
    return targets[0] if targets else None
