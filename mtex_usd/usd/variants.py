"""The variant sets this project wrote, found from whatever a user picks, and switched as viewers do.

What is selected goes into the session layer, where usdview puts it too: it is stronger than what any file says, and
nobody's file changes.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from pxr import Sdf, Usd, UsdSkel

from mtex_usd.errors import InputError, StageError
from mtex_usd.usd.custom_data import from_metadata

__all__ = [
    "PathSet",
    "choose_sets",
    "describe_path",
    "find_sets",
    "list_paths",
    "select_path",
    "selected_path",
    "step_path",
]

_SET = "mtex"
_ORIGINAL = "original"


@dataclass(frozen=True, kw_only=True)
class PathSet:
    """One variant set of ours on one character; every path is one of the composed stage.

    Parameters
    ----------
    model
        The prim with the set.
    name
        Of the set: ``mtex``, or ``mtex_<Anim>``.
    output
        The SkelAnimation that every variant defines below the model.
    source
        The animation it was made from; empty where that is not on the stage.
    skeletons
        The Skeletons that play the output.
    """

    model: Sdf.Path
    name: str
    output: Sdf.Path
    source: Sdf.Path
    skeletons: tuple[Sdf.Path, ...]

    @property
    def label(self) -> str:
        """What users read: the model's path, with the set where it is not the plain one."""
        return str(self.model) if self.name == _SET else f"{self.model} {{{self.name}}}"


def find_sets(stage: Usd.Stage) -> tuple[PathSet, ...]:
    """Find every variant set of ours on a stage.

    Parameters
    ----------
    stage
        The composed stage, override layers in it or not.

    Returns
    -------
    tuple of PathSet
        In the stage's order, the sets of one model by name.
    """
    players = _find_players(stage)
    prims = stage.Traverse(Usd.TraverseInstanceProxies())
    return tuple(found for prim in prims if prim.HasVariantSets() for found in _sets_on(prim, players))


def _find_players(stage: Usd.Stage) -> dict[Sdf.Path, list[Sdf.Path]]:
    """Skeletons by what they play."""
    players: dict[Sdf.Path, list[Sdf.Path]] = {}
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        if prim.IsA("Skeleton"):
            played = UsdSkel.BindingAPI(prim).GetInheritedAnimationSource()
            players.setdefault(played.GetPath() if played else Sdf.Path.emptyPath, []).append(prim.GetPath())
    return players


def _sets_on(prim: Usd.Prim, players: dict[Sdf.Path, list[Sdf.Path]]) -> Iterator[PathSet]:
    for name in sorted(prim.GetVariantSets().GetNames()):
        if name == _SET or name.startswith(f"{_SET}_"):
            yield from _read_set(prim, name, players)


def _read_set(prim: Usd.Prim, name: str, players: dict[Sdf.Path, list[Sdf.Path]]) -> Iterator[PathSet]:
    """Give the set, if one of the layers has an original in it that refers to an animation, as ours do."""
    for spec in _variant_specs(prim, name, _ORIGINAL):
        for child in spec.nameChildren:
            for reference in child.referenceList.prependedItems:
                output = prim.GetPath().AppendChild(child.name)
                bare = spec.path.StripAllVariantSelections()
                source = reference.primPath.ReplacePrefix(bare, prim.GetPath())
                yield PathSet(
                    model=prim.GetPath(),
                    name=name,
                    output=output,
                    source=source if prim.GetStage().GetPrimAtPath(source) else Sdf.Path.emptyPath,
                    skeletons=tuple(players.get(output, ())),
                )
                return


def _variant_specs(prim: Usd.Prim, set_name: str, variant: str) -> Iterator[Sdf.PrimSpec]:
    """Every layer's opinions on a variant, whether it is selected or not, strongest first."""
    stack = (prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim).GetPrimStack()
    for spec in stack:
        found = spec.variantSets.get(set_name)
        if found and variant in found.variants:
            yield found.variants[variant].primSpec


def choose_sets(stage: Usd.Stage, prims: Sequence[Usd.Prim]) -> tuple[PathSet, ...]:
    """Choose the sets that belong to what a user picked.

    Parameters
    ----------
    stage
        The composed stage.
    prims
        What was picked. An animation stands for the sets it is the source or the output of, a Skeleton for those it
        plays, a mesh for those of the Skeleton it is skinned to, and anything else for all sets of the nearest prim
        above that has some.

    Returns
    -------
    tuple of PathSet
        Each once, in the stage's order.

    Raises
    ------
    StageError
        Where no prim that was picked belongs to any.
    """
    sets = find_sets(stage)
    chosen = {found for prim in prims for found in _sets_of(prim, sets)}
    if not chosen:
        raise StageError(
            "nothing selected has paths to choose from",
            expected="a character that was processed: a mesh, its Skeleton, its animation or its model",
            found=", ".join(str(prim.GetPath()) for prim in prims) or "an empty selection",
            fix=_advise(sets),
        )
    return tuple(found for found in sets if found in chosen)


def _advise(sets: Sequence[PathSet]) -> str:
    if not sets:
        return "Process the animation first."
    return f"There are paths on {', '.join(dict.fromkeys(str(found.model) for found in sets))}."


def _sets_of(prim: Usd.Prim, sets: Sequence[PathSet]) -> list[PathSet]:
    own = _sets_of_animation(prim.GetPath(), sets) or _sets_of_skeleton(prim, sets)
    if own:
        return own
    for path in reversed(prim.GetPath().GetPrefixes()):
        found = [each for each in sets if each.model == path]
        if found:
            return found
    return []


def _sets_of_animation(path: Sdf.Path, sets: Sequence[PathSet]) -> list[PathSet]:
    return [found for found in sets if path in (found.output, found.source)]


def _sets_of_skeleton(prim: Usd.Prim, sets: Sequence[PathSet]) -> list[PathSet]:
    skeleton = prim if prim.IsA("Skeleton") else UsdSkel.BindingAPI(prim).GetInheritedSkeleton()
    return [found for found in sets if skeleton and skeleton.GetPath() in found.skeletons]


def list_paths(stage: Usd.Stage, path_set: PathSet) -> tuple[str, ...]:
    """List the variants of a set that are not the original, best first.

    Parameters
    ----------
    stage, path_set
        Where it was found, and what.
    """
    names = stage.GetPrimAtPath(path_set.model).GetVariantSet(path_set.name).GetVariantNames()
    return tuple(sorted(set(names) - {_ORIGINAL}))


def selected_path(stage: Usd.Stage, path_set: PathSet) -> str:
    """Give the name of the variant that is selected.

    Parameters
    ----------
    stage, path_set
        Where it was found, and what.
    """
    return str(stage.GetPrimAtPath(path_set.model).GetVariantSet(path_set.name).GetVariantSelection())


def describe_path(stage: Usd.Stage, path_set: PathSet, variant: str) -> dict[str, object]:
    """Give what a variant says of itself, whether it is selected or not.

    Parameters
    ----------
    stage, path_set
        Where it was found, and what.
    variant
        Its name.

    Returns
    -------
    dict of str to object
        As in ``customData["mtex"]``, lists as lists; empty where nothing is said, as of the original.
    """
    said: dict[str, object] = {}
    for spec in _variant_specs(stage.GetPrimAtPath(path_set.model), path_set.name, variant):
        child = spec.nameChildren.get(path_set.output.name)
        here = from_metadata(child.customData.get(_SET, {})) if child else {}
        if isinstance(here, dict):
            said = here | said
    return said


def select_path(stage: Usd.Stage, path_set: PathSet, variant: str) -> None:
    """Select a variant in the session layer.

    Parameters
    ----------
    stage, path_set
        Where it was found, and what.
    variant
        Its name.

    Raises
    ------
    InputError
        Where the set has no such variant.
    StageError
        Where the model lies inside an instance, whose selections cannot be changed.
    """
    names = (*list_paths(stage, path_set), _ORIGINAL)
    if variant not in names:
        raise InputError(f"{path_set.label} has no variant {variant!r}", expected=f"one of {', '.join(names)}")
    prim = stage.GetPrimAtPath(path_set.model)
    if prim.IsInstanceProxy():
        raise StageError(
            f"{path_set.model} lies inside an instance, where nothing can be selected",
            fix="Set instanceable to false on the prim above that is an instance.",
        )
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        prim.GetVariantSet(path_set.name).SetVariantSelection(variant)


def step_path(stage: Usd.Stage, path_sets: Iterable[PathSet], steps: int) -> dict[PathSet, str]:
    """Go on to the next path of each set, or back; round the ends, and past the original.

    Parameters
    ----------
    stage, path_sets
        Where they were found, and what.
    steps
        1 for the next, -1 for the one before. From the original the next is the best, the one before the last.

    Returns
    -------
    dict of PathSet to str
        What is selected now.

    Raises
    ------
    StageError
        As :func:`select_path`, and where a set has nothing but the original.
    """
    chosen = {found: _neighbour(stage, found, steps) for found in path_sets}
    for found, variant in chosen.items():
        select_path(stage, found, variant)
    return chosen


def _neighbour(stage: Usd.Stage, path_set: PathSet, steps: int) -> str:
    paths, here = list_paths(stage, path_set), selected_path(stage, path_set)
    if not paths:
        raise StageError(f"{path_set.label} has no path beside the original")
    if here not in paths:
        return paths[0 if steps > 0 else -1]
    return paths[(paths.index(here) + steps) % len(paths)]
