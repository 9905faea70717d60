"""Names of variant sets and outputs: short where they can be, and once written never changed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from pathlib import Path

from pxr import Sdf, Usd

from mtex_usd.usd.atomic import is_ours
from mtex_usd.usd.diagnostics import open_layer

__all__ = ["Place", "SetName", "choose_names", "read_set_names"]

_SET = "mtex"

# An animation and the model that plays it.
Place = tuple[Sdf.Path, Sdf.Path]


@dataclass(frozen=True, kw_only=True)
class SetName:
    """What a sketch's variant set on one model is called, and the SkelAnimation its variants define."""

    variant_set: str
    output: Sdf.Path


def read_set_names(layer_files: Sequence[Path], models: Sequence[Sdf.Path]) -> dict[Place, SetName]:
    """Read which sets earlier runs wrote.

    Parameters
    ----------
    layer_files
        Override layers, the ones to believe first; files that are not there or not ours say nothing.
    models
        The prims to look at.

    Returns
    -------
    dict[Place, SetName]
        By animation and model.
    """
    names: dict[Place, SetName] = {}
    for layer_file in filter(is_ours, layer_files):
        layer = open_layer(layer_file)
        for prim in filter(None, map(layer.GetPrimAtPath, models)):
            for place, name in _sets_of(prim):
                names.setdefault(place, name)
    return names


def _sets_of(model: Sdf.PrimSpec) -> list[tuple[Place, SetName]]:
    found = []
    for set_name, variant_set in model.variantSets.items():
        original = variant_set.variants.get("original")
        for child in original.primSpec.nameChildren if original else ():
            for reference in child.referenceList.prependedItems:
                name = SetName(variant_set=set_name, output=model.path.AppendChild(child.name))
                found.append(((reference.primPath, model.path), name))
    return found


def choose_names(stage: Usd.Stage, places: Sequence[Place], known: Mapping[Place, SetName]) -> tuple[SetName, ...]:
    """Give each sketch on each model the name it had, else a free one.

    Parameters
    ----------
    stage
        Sets and prims that stand on it are not ours, since our own layers are muted; their names are taken.
    places
        Animation and model, in order of who chooses first.
    known
        Names of earlier runs; those of animations that are gone are free again.

    Returns
    -------
    tuple[SetName, ...]
        One per place: set ``mtex``, else ``mtex_<Anim>``, else with a number; output ``<Anim>_mtex``.
    """
    alive = {place: name for place, name in known.items() if stage.GetPrimAtPath(place[0])}
    chosen: dict[Place, SetName] = {}
    for animation, model in places:
        others = [name for place, name in {**alive, **chosen}.items() if place[1] == model]
        chosen[animation, model] = alive.get((animation, model)) or _new_name(stage, animation, model, others)
    return tuple(chosen[place] for place in places)


def _new_name(stage: Usd.Stage, animation: Sdf.Path, model: Sdf.Path, others: Sequence[SetName]) -> SetName:
    prim = stage.GetPrimAtPath(model)
    sets = {*prim.GetVariantSets().GetNames(), *(name.variant_set for name in others)}
    outputs = {name.output for name in others}
    set_names = (_SET, f"{_SET}_{animation.name}", *(f"{_SET}_{animation.name}_{i}" for i in range(2, len(sets) + 2)))
    numbered = (model.AppendChild(f"{animation.name}{'' if i == 1 else f'_{i}'}_{_SET}") for i in count(1))
    return SetName(
        variant_set=next(name for name in set_names if name not in sets),
        output=next(path for path in numbered if path not in outputs and not stage.GetPrimAtPath(path)),
    )
