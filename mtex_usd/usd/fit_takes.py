"""Takes of a sketch as its character can use them, with what users say about joints."""

from collections.abc import Sequence

from pxr import Usd

from mtex_usd.constraints.retargeting import FittedTake, Pair, fit_take
from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip
from mtex_usd.usd.schema import read_pairs

__all__ = ["fit_takes"]


def fit_takes(
    sketch_prim: Usd.Prim, sketch: Clip, take_prims: Sequence[Usd.Prim], takes: Sequence[Clip]
) -> tuple[FittedTake, ...]:
    """Bring takes onto a character's joints, as far as they are not on them.

    Parameters
    ----------
    sketch_prim
        Where MtexRetargetAPI may be applied for all takes.
    sketch
        The sketch on all joints of the character.
    take_prims
        Where MtexRetargetAPI may be applied for one take, which is stronger.
    takes
        The takes on their own skeletons, one per prim.

    Returns
    -------
    tuple of FittedTake
        In the order of the takes.

    Raises
    ------
    InputError
        Where a pair names a joint that is not there; a pair on the sketch has to fit one of its takes at least.
    """
    general = read_pairs(sketch_prim)
    _check_general(sketch_prim, general, sketch, takes)
    fitted = []
    for prim, take in zip(take_prims, takes, strict=True):
        own = read_pairs(prim)
        known = [pair for pair in general if not pair.source or _has(take, pair.source)]
        pairs = [pair for pair in known if not any(_is_same(pair.joint, other.joint) for other in own)]
        try:
            fitted.append(fit_take(take, sketch, (*own, *pairs)))
        except InputError as error:
            message = f"{prim.GetPath()}: {error.message}"
            raise InputError(message, expected=error.expected, found=error.found, fix=error.fix) from error
    return tuple(fitted)


def _has(take: Clip, joint: str) -> bool:
    return any(joint in (path, path.rpartition("/")[2]) for path in take.joints)


def _is_same(joint: str, other: str) -> bool:
    """Whether two names may be one joint's: one may be the path, the other its last name."""
    return joint == other or joint.endswith(f"/{other}") or other.endswith(f"/{joint}")


def _check_general(sketch_prim: Usd.Prim, pairs: Sequence[Pair], sketch: Clip, takes: Sequence[Clip]) -> None:
    for pair in pairs:
        if not _has(sketch, pair.joint):
            raise InputError(
                f"{sketch_prim.GetPath()}.mtex:retarget:pairs: the character has no joint {pair.joint!r}",
                expected=f"one of {', '.join(path.rpartition('/')[2] for path in sketch.joints)}",
            )
        if pair.source and not any(_has(take, pair.source) for take in takes):
            raise InputError(
                f"{sketch_prim.GetPath()}.mtex:retarget:pairs: no take has a joint {pair.source!r}",
                expected=f"one of {', '.join(path.rpartition('/')[2] for path in takes[0].joints)}" if takes else "",
            )
