"""MtexRetargetAPI: pairs of joints that a user names."""

from pxr import Usd

from mtex_usd.constraints.retargeting import Pair
from mtex_usd.errors import InputError
from mtex_usd.usd.schema.applied import has_api, where
from mtex_usd.usd.schema.properties import TOKENS, Property, check_names, read_properties

__all__ = ["RETARGET_API", "read_pairs"]

RETARGET_API = "MtexRetargetAPI"

_PREFIX = "mtex:retarget:"
_PROPERTIES = (Property("pairs", "pairs", TOKENS),)


def read_pairs(prim: Usd.Prim) -> tuple[Pair, ...]:
    """Read and check the pairs of joints on a sketch or a take; none where the schema is not applied.

    Parameters
    ----------
    prim
        A SkelAnimation.

    Raises
    ------
    InputError
        Where a property is misspelt, of the wrong type or changes over time, where a joint lacks its partner, and where
        one of the character's joints is named twice or not at all.
    """
    if not has_api(prim, RETARGET_API):
        return ()
    check_names(prim, _PREFIX, [known.name for known in _PROPERTIES])
    tokens = read_properties(prim, _PREFIX, _PROPERTIES).get("pairs", ())
    name = where(prim, f"{_PREFIX}pairs")
    if len(tokens) % 2:
        found = f"{len(tokens)} names, the last being {tokens[-1]!r}"
        raise InputError(f"{name}: a joint lacks its partner", expected="names in pairs", found=found)
    pairs = tuple(Pair(*both) for both in zip(tokens[::2], tokens[1::2], strict=True))
    joints = [pair.joint for pair in pairs]
    wrong = next((joint for joint in joints if not joint or joints.count(joint) > 1), None)
    if wrong is not None:
        raise InputError(f"{name}: the character's joints have to be named once", found=f"{wrong!r} in {joints}")
    return pairs
