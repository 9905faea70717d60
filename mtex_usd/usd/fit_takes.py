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
    sketch_prim, take_prims
        Where MtexRetargetAPI may be applied; a take's own pairs are stronger than the sketch's.
    sketch
        The sketch on all joints of the character.
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
    _check_general(sketch_prim, general, takes)
    fitted = []
    for prim, take in zip(take_prims, takes, strict=True):
        own = read_pairs(prim)
        said = {pair.joint for pair in own}
        pairs = [pair for pair in general if pair.joint not in said and (not pair.source or _has(take, pair.source))]
        try:
            fitted.append(fit_take(take, sketch, (*own, *pairs)))
        except InputError as error:
            raise InputError(
                f"{prim.GetPath()}: {error.message}", expected=error.expected, found=error.found
            ) from error
    return tuple(fitted)


def _has(take: Clip, joint: str) -> bool:
    return any(joint in (path, path.rpartition("/")[2]) for path in take.joints)


def _check_general(sketch_prim: Usd.Prim, pairs: Sequence[Pair], takes: Sequence[Clip]) -> None:
    for pair in pairs:
        if pair.source and not any(_has(take, pair.source) for take in takes):
            raise InputError(
                f"{sketch_prim.GetPath()}.mtex:retarget:pairs: no take has a joint {pair.source!r}",
                expected=f"one of {', '.join(path.rpartition('/')[2] for path in takes[0].joints)}" if takes else "",
            )
