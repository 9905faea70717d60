"""Working beside a stage that a viewer has open: what it shows written for another process, and results put over it.

Nothing is ever written to the user's files. What was made lies in one anonymous sublayer of the session layer, which
later runs replace as a command's run replaces the override layer on disk.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

from pxr import Kind, Sdf, Usd, UsdSkel

from mtex_usd.errors import InputError, StageError
from mtex_usd.usd.atomic import layer_kind, write_layer
from mtex_usd.usd.diagnostics import read_layer
from mtex_usd.usd.skeletons import find_bindings
from mtex_usd.usd.thin_root import author_metadata
from mtex_usd.usd.variants import find_sets

__all__ = ["add_result", "find_animations", "find_skeletons", "session_offset", "session_result", "write_snapshot"]

_OWN = frozenset({"subLayers", "subLayerOffsets", "customLayerData", "primChildren", "documentation", "comment"})

# Anonymous layers live as long as somebody holds them, and stages do not hold those they name by identifier when the
# session layer changes hands; one per stage's session layer.
_held: dict[str, Sdf.Layer] = {}


def find_animations(stage: Usd.Stage, prims: Sequence[Usd.Prim]) -> tuple[Sdf.Path, ...]:
    """Find the animations that belong to what a user picked, the animator's own and not our outputs.

    Parameters
    ----------
    stage
        The composed stage.
    prims
        An animation stands for itself, a Skeleton for what it plays, a mesh for what its Skeleton plays, anything else
        for what the Skeletons of the SkelRoot or model play that it is, or is part of.

    Returns
    -------
    tuple of Sdf.Path
        Each once.

    Raises
    ------
    StageError
        Where nothing that was picked plays an animation.
    """
    sources = {found.output: found.source for found in find_sets(stage) if found.source}
    played = [path for prim in prims for path in _animations_of(prim)]
    found = tuple(dict.fromkeys(sources.get(path, path) for path in played))
    if not found:
        raise StageError(
            "nothing selected plays an animation",
            expected="a mesh, a Skeleton, an animation or a model with one",
            found=", ".join(str(prim.GetPath()) for prim in prims) or "an empty selection",
        )
    return found


def find_skeletons(stage: Usd.Stage, prims: Sequence[Usd.Prim]) -> tuple[Usd.Prim, ...]:
    """Find the Skeletons that belong to what a user picked.

    Parameters
    ----------
    stage
        The composed stage.
    prims
        As :func:`find_animations` takes them; an animation stands for the Skeletons that play it, or its output.

    Returns
    -------
    tuple of Usd.Prim
        Each once; none where there is none.
    """
    outputs = {found.source: found.output for found in find_sets(stage)}
    bindings = find_bindings(stage)
    found: list[Usd.Prim] = []
    for prim in prims:
        path = prim.GetPath()
        played = (*bindings.get(path, ()), *bindings.get(outputs.get(path, Sdf.Path.emptyPath), ()))
        found += played if prim.IsA("SkelAnimation") else _skeletons_of(prim)
    return tuple({each.GetPath(): each for each in found}.values())


def _animations_of(prim: Usd.Prim) -> Iterator[Sdf.Path]:
    if prim.IsA("SkelAnimation"):
        yield prim.GetPath()
        return
    for skeleton in _skeletons_of(prim):
        source = UsdSkel.BindingAPI(skeleton).GetInheritedAnimationSource()
        if source:
            yield source.GetPath()


def _skeletons_of(prim: Usd.Prim) -> list[Usd.Prim]:
    if prim.IsA("Skeleton"):
        return [prim]
    skinned = UsdSkel.BindingAPI(prim).GetInheritedSkeleton()
    if skinned:
        return [skinned.GetPrim()]
    while prim and not prim.IsPseudoRoot() and not _is_character(prim):
        prim = prim.GetParent()
    if not prim or prim.IsPseudoRoot():
        return []
    below = Usd.PrimRange(prim, Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate))
    return [each for each in below if each.IsA("Skeleton")]


def _is_character(prim: Usd.Prim) -> bool:
    kind = Usd.ModelAPI(prim).GetKind()
    is_model = Kind.Registry.IsA(kind, Kind.Tokens.model) and not Kind.Registry.IsA(kind, Kind.Tokens.group)
    return prim.IsA("SkelRoot") or is_model


def write_snapshot(stage: Usd.Stage, folder: Path) -> Path:
    """Write what a stage shows beyond its files into a folder, for another process to open.

    Parameters
    ----------
    stage
        As the viewer has it, edits of the session layer included.
    folder
        Of this job alone.

    Returns
    -------
    Path
        A layer that stacks a copy of the session layer over the stage's root layer; beside it ``result.usd``, the
        result of an earlier job where there is one.

    Raises
    ------
    InputError
        Where the stage has no file, or a file that it is made of has unsaved edits: another process cannot see them.
    """
    root = stage.GetRootLayer()
    if not root.realPath:
        raise InputError("the stage has no file that another process could open", fix="Save it first.")
    unsaved = [layer.identifier for layer in stage.GetUsedLayers() if layer.dirty and not layer.anonymous]
    if unsaved:
        raise InputError(f"{', '.join(sorted(unsaved))} has unsaved edits", fix="Save or reload it first.")
    session = folder / "session.usda"
    _copy_session(stage).Export(str(session))
    earlier = session_result(stage)
    if earlier is not None:
        write_layer(earlier, folder / "result.usd")
    snapshot = Sdf.Layer.CreateAnonymous("snapshot.usda")
    fields = {key: root.pseudoRoot.GetInfo(key) for key in root.pseudoRoot.ListInfoKeys() if key not in _OWN}
    author_metadata(snapshot, fields)
    snapshot.subLayerPaths[:] = [str(session), root.realPath]
    snapshot.Export(str(folder / "shot.usda"))
    return folder / "shot.usda"


def _copy_session(stage: Usd.Stage) -> Sdf.Layer:
    copy = Sdf.Layer.CreateAnonymous("session.usda")
    copy.TransferContent(stage.GetSessionLayer())
    copy.subLayerPaths[:] = [path for path in _sublayers(copy) if not path.startswith("anon:")]
    return copy


def _sublayers(layer: Sdf.Layer) -> list[str]:
    return [str(path) for path in layer.subLayerPaths]  # type: ignore[attr-defined]


def session_result(stage: Usd.Stage) -> Sdf.Layer | None:
    """Give the layer with what was made for a stage in this session; None where nothing was.

    Parameters
    ----------
    stage
        The stage.
    """
    layers = [Sdf.Layer.Find(path) for path in _sublayers(stage.GetSessionLayer()) if path.startswith("anon:")]
    return next((layer for layer in layers if layer and layer_kind(layer) == "override"), None)


def add_result(stage: Usd.Stage, file_path: Path) -> Sdf.Layer:
    """Put an override layer over a stage, as the first sublayer of the session layer.

    Parameters
    ----------
    stage
        Only its session layer changes.
    file_path
        The override layer; it is read, and may be deleted then. The result of an earlier job is replaced.

    Returns
    -------
    Sdf.Layer
        The sublayer.

    Raises
    ------
    InputError
        Where the file cannot be read.
    """
    result = Sdf.Layer.CreateAnonymous("usdmtex.usdc")
    result.TransferContent(read_layer(file_path))
    session, earlier = stage.GetSessionLayer(), session_result(stage)
    _held[session.identifier] = result
    kept = [path for path in _sublayers(session) if earlier is None or path != earlier.identifier]
    session.subLayerPaths[:] = [result.identifier, *kept]
    return result


def session_offset(stage: Usd.Stage) -> Sdf.LayerOffset:
    """Give what brings a time of the session layer to the stage's; not the identity where it has a rate of its own.

    Parameters
    ----------
    stage
        The stage.
    """
    target = stage.GetEditTargetForLocalLayer(stage.GetSessionLayer())
    return target.GetMapFunction().timeOffset
