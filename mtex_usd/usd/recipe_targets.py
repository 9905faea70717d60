"""Which animations of a stage are sketches, and which takes each of them names."""

from collections.abc import Iterable, Iterator, Sequence

from pxr import Pcp, Sdf, Usd

from mtex_usd.errors import InputError, StageError
from mtex_usd.usd.schema import SKETCH_API, TAKES_PROPERTY, has_api

__all__ = ["find_sketches", "find_takes", "is_own_output"]

_OUTPUT_SUFFIX = "_mtex"
_OUTPUT_KEY = "mtex"
_FILE_ARCS = (Pcp.ArcTypeReference, Pcp.ArcTypePayload)


def is_own_output(prim: Usd.Prim) -> bool:
    """Tell whether this project wrote an animation as the result of a sketch.

    Parameters
    ----------
    prim
        Ours are named ``<sketch>_mtex`` and carry ``customData["mtex"]``, or, where the variant shows the original, at
        least delete the recipe's schema that they inherit from the sketch.
    """
    if not prim.GetName().endswith(_OUTPUT_SUFFIX):
        return False
    return prim.GetCustomDataByKey(_OUTPUT_KEY) is not None or any(map(_deletes_recipe, prim.GetPrimStack()))


def _deletes_recipe(spec: Sdf.PrimSpec) -> bool:
    schemas = spec.GetInfo("apiSchemas")
    return isinstance(schemas, Sdf.TokenListOp) and any(name.startswith("Mtex") for name in schemas.deletedItems)


def find_sketches(stage: Usd.Stage, *, only: Sequence[str] = ()) -> tuple[Usd.Prim, ...]:
    """Find the animations that carry a recipe.

    Parameters
    ----------
    stage
        The composed stage.
    only
        Paths of the sketches wanted; empty for all.

    Returns
    -------
    tuple of Usd.Prim
        In the stage's order, or in that of ``only`` (each once). Those inside instances are instance proxies.

    Raises
    ------
    InputError
        Where a path of ``only`` names nothing, or no SkelAnimation.
    StageError
        Where there is no sketch, or a named animation has no recipe.
    """
    sketches = tuple(filter(_is_sketch, _animations_below(stage.GetPseudoRoot())))
    if only:
        return tuple(dict.fromkeys(_named_sketch(stage, prim_path, sketches) for prim_path in only))
    if not sketches:
        raise StageError(
            f"{stage.GetRootLayer().identifier} has no recipe",
            expected=f"a SkelAnimation with {SKETCH_API} applied",
            found=_list_prims(_animations_below(stage.GetPseudoRoot()), "no SkelAnimation"),
            fix=f"Apply {SKETCH_API} to the sketch and set {TAKES_PROPERTY}.",
        )
    return sketches


def _is_sketch(prim: Usd.Prim) -> bool:
    return has_api(prim, SKETCH_API) and not is_own_output(prim)


def _named_sketch(stage: Usd.Stage, prim_path: str, sketches: tuple[Usd.Prim, ...]) -> Usd.Prim:
    prim = stage.GetPrimAtPath(prim_path) if Sdf.Path.IsValidPathString(prim_path) else None
    there_are = f"The sketches of this stage: {_list_prims(sketches, 'none')}."
    if not prim or not prim.IsA("SkelAnimation"):
        found = (prim.GetTypeName() or "a typeless prim") if prim else "no such prim"
        raise InputError(f"cannot take {prim_path} as a sketch", expected="a SkelAnimation", found=found, fix=there_are)
    if is_own_output(prim):
        raise StageError(f"{prim_path} is what this tool wrote", expected="the original sketch", fix=there_are)
    if not has_api(prim, SKETCH_API):
        raise StageError(f"{prim_path} has no recipe", expected=f"{SKETCH_API} applied", fix=there_are)
    return prim


def find_takes(stage: Usd.Stage, sketch_prim: Usd.Prim) -> tuple[Usd.Prim, ...]:
    """Find the takes that a sketch names.

    Parameters
    ----------
    stage
        The composed stage.
    sketch_prim
        The sketch. Every SkelAnimation at or below a target of its ``mtex:takes`` counts, instances included, except
        sketches, what this project wrote, and those that hold blend shapes alone.

    Returns
    -------
    tuple of Usd.Prim
        In the order of the targets, below each in the stage's order, each once.

    Raises
    ------
    StageError
        Where the sketch names no takes, composition dropped a target, or a target does not exist or holds no take.
    """
    relationship = sketch_prim.GetRelationship(TAKES_PROPERTY)
    if not relationship or not relationship.HasAuthoredTargets():
        raise StageError(f"{sketch_prim.GetPath()} names no takes", expected=f"targets of {TAKES_PROPERTY}")
    _check_dropped(sketch_prim)
    targets = relationship.GetForwardedTargets()
    if not targets:
        raise StageError(f"{relationship.GetPath()} has no targets", expected="takes, or prims above takes")
    return tuple(dict.fromkeys(take for target in targets for take in _takes_at(stage, relationship, target)))


def _takes_at(stage: Usd.Stage, relationship: Usd.Relationship, target: Sdf.Path) -> list[Usd.Prim]:
    prim = stage.GetPrimAtPath(target)
    if not prim:
        raise StageError(
            f"{relationship.GetPath()} names a prim that is not there",
            found=str(target),
            fix="Correct the path, or add the layer with the takes (a payload may be unloaded, a prim inactive).",
        )
    animations = _animations_below(prim)
    takes = [animation for animation in animations if _is_take(animation) or animation == prim]
    takes = [animation for animation in takes if not _is_sketch(animation) and not is_own_output(animation)]
    if not takes:
        found = _list_prims(animations, "none") + (", sketches or results of this tool" if animations else "")
        raise StageError(
            f"{relationship.GetPath()}: no take at or below {target}", expected="a SkelAnimation", found=found
        )
    return takes


def _is_take(animation: Usd.Prim) -> bool:
    """Whether an animation moves joints; one with blend shapes alone is none of our takes."""
    return bool(animation.GetAttribute("joints").Get())


def _animations_below(prim: Usd.Prim) -> list[Usd.Prim]:
    prims = Usd.PrimRange(prim, Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate))
    return [below for below in prims if below.IsA("SkelAnimation")]


def _list_prims(prims: Iterable[Usd.Prim], otherwise: str) -> str:
    return ", ".join(str(prim.GetPath()) for prim in prims) or otherwise


def _check_dropped(sketch_prim: Usd.Prim) -> None:
    """Refuse targets that a layer names but composition could not carry over; USD only warns.

    A layer that is referenced cannot name what lies outside the referenced prim.
    """
    source = sketch_prim.GetPrimInPrototype() if sketch_prim.IsInstanceProxy() else sketch_prim
    for node, spec in _target_specs(source.GetPrimIndex().rootNode):
        for target in spec.targetPathList.GetAppliedItems():
            if node.mapToRoot.MapSourceToTarget(target).isEmpty:
                raise _dropped(sketch_prim, node, spec, target)
        if spec.targetPathList.isExplicit:
            return  # Weaker opinions do not count.


def _dropped(sketch_prim: Usd.Prim, node: Pcp.NodeRef, spec: Sdf.RelationshipSpec, target: Sdf.Path) -> StageError:
    arc = node
    while arc.arcType not in _FILE_ARCS and not arc.IsRootNode():
        arc = arc.parent
    scope = arc.GetPathAtIntroduction().StripAllVariantSelections()
    return StageError(
        f"{sketch_prim.GetPath()}.{TAKES_PROPERTY}: composition dropped the target {target}",
        found=f"it in layer {spec.layer.identifier}, of which only {scope} is referenced",
        fix=f"Author {TAKES_PROPERTY} in the referencing layer, or move the takes below the referenced prim.",
    )


def _target_specs(node: Pcp.NodeRef) -> Iterator[tuple[Pcp.NodeRef, Sdf.RelationshipSpec]]:
    """Walk the opinions on the takes, strongest first, each with where it comes from."""
    for layer in node.layerStack.layers:
        spec = layer.GetRelationshipAtPath(node.path.AppendProperty(TAKES_PROPERTY))
        if spec:
            yield node, spec
    for child in node.children:
        yield from _target_specs(child)
