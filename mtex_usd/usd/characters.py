"""Who plays an animation, and where the variants of each go.

A character is a SkelRoot and the Skeletons below it. Its variant set goes on a prim that can be edited and that a
director would pick: the nearest model that holds this character alone, else its SkelRoot; where there is instancing the
outermost instance, since nothing below an instance can be edited.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from pxr import Kind, Sdf, Usd, UsdSkel

from mtex_usd.errors import StageError
from mtex_usd.usd.schema import read_take_settings
from mtex_usd.usd.set_names import Place, SetName, choose_names, read_set_names

__all__ = ["Character", "find_characters"]


@dataclass(frozen=True, kw_only=True)
class Character:
    """One character that plays one animation; every path is one of the composed stage.

    Parameters
    ----------
    animation
        The source SkelAnimation.
    skeletons
        The Skeletons that play it; may lie inside an instance.
    model
        The prim that gets the variant set; never inside an instance.
    variant_set
        Name of the set: ``mtex``, or ``mtex_<Anim>`` for further sketches on the same model.
    output
        The SkelAnimation that every variant defines below the model.
    """

    animation: Sdf.Path
    skeletons: tuple[Sdf.Path, ...]
    model: Sdf.Path
    variant_set: str
    output: Sdf.Path


@dataclass(frozen=True)
class _Rig:
    """One Skeleton: its SkelRoot (itself, where it has none), its outermost instance and what it plays."""

    skeleton: Sdf.Path
    root: Sdf.Path
    instance: Sdf.Path
    plays: Sdf.Path


def find_characters(
    stage: Usd.Stage, animation_paths: Sequence[Sdf.Path], *, previous: Path | None = None
) -> tuple[Character, ...]:
    """Find the characters of all sketches of a stage and name their variant sets.

    Parameters
    ----------
    stage
        As :func:`mtex_usd.usd.source_stage.open_source` gives it, our own override layers muted.
    animation_paths
        The sketches, all at once, since the names of their sets depend on each other; the first get the plainest names.
    previous
        The override layer of an earlier run, if there is one; its sets keep their names, and so do those of our
        override layers that are muted on the stage.

    Returns
    -------
    tuple[Character, ...]
        In the order of the sketches, the characters of one sketch in stage order.

    Raises
    ------
    StageError
        Where an animation is not on the stage, or no Skeleton plays it and neither its ``mtex:take:skeleton`` nor its
        SkelRoot tells which should, or that one has another sketch to play.
    """
    rigs = _find_rigs(stage)
    holders = Counter(ancestor for root in {rig.root for rig in rigs} for ancestor in root.GetPrefixes())
    places: list[tuple[Sdf.Path, Sdf.Path, tuple[Sdf.Path, ...]]] = []
    players = _find_players(stage, animation_paths, rigs)
    for animation in animation_paths:
        by_model: dict[Sdf.Path, list[Sdf.Path]] = {}
        for rig in players[animation]:
            by_model.setdefault(_model_of(stage, rig, holders), []).append(rig.skeleton)
        places.extend((animation, model, tuple(skeletons)) for model, skeletons in by_model.items())
    asked = [(animation, model) for animation, model, _ in places]
    names = choose_names(stage, asked, _known_names(stage, previous, asked))
    return tuple(
        Character(
            animation=animation, skeletons=skeletons, model=model, variant_set=name.variant_set, output=name.output
        )
        for (animation, model, skeletons), name in zip(places, names, strict=True)
    )


def _find_rigs(stage: Usd.Stage) -> list[_Rig]:
    skeletons = (prim for prim in stage.Traverse(Usd.TraverseInstanceProxies()) if prim.IsA("Skeleton"))
    return [_rig_of(prim) for prim in skeletons]


def _rig_of(skeleton: Usd.Prim) -> _Rig:
    root = UsdSkel.Root.Find(skeleton)
    played = UsdSkel.BindingAPI(skeleton).GetInheritedAnimationSource()
    return _Rig(
        skeleton=skeleton.GetPath(),
        root=root.GetPath() if root else skeleton.GetPath(),
        instance=_outermost_instance(skeleton),
        plays=played.GetPath() if played else Sdf.Path.emptyPath,
    )


def _outermost_instance(prim: Usd.Prim) -> Sdf.Path:
    stage = prim.GetStage()
    instances = (path for path in prim.GetPath().GetPrefixes() if stage.GetPrimAtPath(path).IsInstance())
    return next(instances, Sdf.Path.emptyPath)


def _model_of(stage: Usd.Stage, rig: _Rig, holders: Mapping[Sdf.Path, int]) -> Sdf.Path:
    if rig.instance:
        return rig.instance
    for path in reversed(rig.root.GetPrefixes()):
        if holders[path] == 1 and _is_model_kind(stage.GetPrimAtPath(path)):
            return path
    return rig.root


def _is_model_kind(prim: Usd.Prim) -> bool:
    # By kind and not Prim.IsModel, which wants an unbroken hierarchy; usdview's "select enclosing model" does the same.
    return bool(Kind.Registry.IsA(Usd.ModelAPI(prim).GetKind(), Kind.Tokens.model))


def _find_players(
    stage: Usd.Stage, animations: Sequence[Sdf.Path], rigs: Sequence[_Rig]
) -> dict[Sdf.Path, tuple[_Rig, ...]]:
    """Give each sketch its players: those bound to it, else one that has nothing else to play."""
    missing = [animation for animation in animations if not stage.GetPrimAtPath(animation)]
    if missing:
        raise StageError(f"there is no prim {missing[0]}", fix="Name an animation that is on the stage.")
    bound = {animation: tuple(rig for rig in rigs if rig.plays == animation) for animation in animations}
    players = {animation: found for animation, found in bound.items() if found}
    named = {path: read_take_settings(stage.GetPrimAtPath(path)).skeleton for path in animations if path not in players}
    # Who names a Skeleton comes before who takes the one that is left.
    for animation in sorted(named, key=lambda path: named[path] is None):
        taken = {rig.skeleton: path for path, found in players.items() for rig in found}
        players[animation] = (_own_rig(stage.GetPrimAtPath(animation), named[animation], rigs, taken),)
    return players


def _own_rig(
    animation: Usd.Prim, named: Sdf.Path | None, rigs: Sequence[_Rig], taken: Mapping[Sdf.Path, Sdf.Path]
) -> _Rig:
    """Give the Skeleton that a sketch names, else that of its own SkelRoot, for a sketch that none is bound to."""
    root = UsdSkel.Root.Find(animation)
    beside = [rig for rig in rigs if root and rig.root == root.GetPath()]
    own = [rig for rig in rigs if rig.skeleton == named] or beside
    free = [rig for rig in own if rig.skeleton not in taken]
    if len(free) == 1:
        return free[0]
    playing = (f"{rig.skeleton} playing {taken.get(rig.skeleton, rig.plays) or 'nothing'}" for rig in own)
    raise StageError(
        f"no Skeleton plays {animation.GetPath()}",
        expected="a bound Skeleton, or one Skeleton without another sketch in the animation's own SkelRoot",
        found=", ".join(playing) or "no Skeleton beside it",
        fix="Set skel:animationSource on the Skeleton (with SkelBindingAPI applied), or name the Skeleton in the "
        "sketch's mtex:take:skeleton (with MtexTakeAPI applied).",
    )


def _known_names(stage: Usd.Stage, previous: Path | None, places: Sequence[Place]) -> dict[Place, SetName]:
    models = sorted({model for _, model in places})
    files = [*([previous] if previous else []), *map(Path, stage.GetMutedLayers())]
    return read_set_names(files, models)
