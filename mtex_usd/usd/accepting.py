"""What a director chose in a viewer, written into a layer that says so in any other process."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd

from mtex_usd.errors import InputError
from mtex_usd.usd.atomic import check_target, file_kind, mark_layer, write_layer
from mtex_usd.usd.diagnostics import open_layer, read_layer
from mtex_usd.usd.session import session_offset, session_result
from mtex_usd.usd.thin_root import author_metadata, find_stacked, read_root_metadata, relative_path
from mtex_usd.usd.variants import PathSet, selected_path

__all__ = ["Accepted", "accept_paths"]


@dataclass(frozen=True, kw_only=True)
class Accepted:
    """What was written.

    Parameters
    ----------
    layer
        The layer that was named.
    result
        The override layer written beside it, for what was made in this session; None where files had it already.
    selections
        Name of the variant by set.
    """

    layer: Path
    result: Path | None
    selections: dict[PathSet, str]


def accept_paths(stage: Usd.Stage, path_sets: Sequence[PathSet], file_path: Path, *, stacked: bool = True) -> Accepted:
    """Write what is selected into a layer, with what was edited of it in this session.

    Parameters
    ----------
    stage
        As the viewer has it; not changed.
    path_sets
        Whose selection is written; what the session selects of others is left out.
    file_path
        A new file, a thin root of ours or a layer this function wrote; those keep what else they say.
    stacked
        Whether the layer stacks the stage's root layer, so that it can be opened by itself. Otherwise it is to be put
        into a layer stack. A thin root is stacked already.

    Returns
    -------
    Accepted
        Where results were made in this session, they go into an override layer ``<name>.mtex.usd`` beside, stacked too.

    Raises
    ------
    InputError
        Where a file is there that is not ours, or cannot be written, or the stage has no file to stack.
    """
    kind = _check_file(stage, file_path)
    result = _find_result(stage, path_sets, file_path)
    layer = _open_target(file_path, kind)
    selections = {found: selected_path(stage, found) for found in path_sets}
    for found, variant in selections.items():
        Sdf.CreatePrimInLayer(layer, found.model).variantSelections[found.name] = variant
        _copy_edits(stage, layer, found, variant)
    if kind != "stage":
        _author_root(stage, layer, path_sets, file_path, stacked=stacked)
    if result is not None:
        _write_result(stage, layer, result, file_path)
    write_layer(layer, file_path)
    return Accepted(layer=file_path, result=result, selections=selections)


def _check_file(stage: Usd.Stage, file_path: Path) -> str:
    """Tell what is going to be written: a thin root of this shot that is there already, or accepted paths."""
    if file_kind(file_path) != "stage":
        check_target(file_path, "accepted")
        return "accepted"
    check_target(file_path, "stage")
    root = stage.GetRootLayer().realPath
    shot = find_stacked(open_layer(file_path)).shot
    if root and os.path.realpath(root) not in map(os.path.realpath, (file_path, shot)):
        raise InputError(
            f"{file_path} is the thin root of another shot",
            expected=f"one of {root}",
            found=f"one of {shot}",
            fix="Choose another name for the output.",
        )
    return "stage"


def _find_result(stage: Usd.Stage, path_sets: Sequence[PathSet], file_path: Path) -> Path | None:
    """Name the file for what only this session has, if any of it is accepted."""
    made = session_result(stage)
    models = {found.model for found in path_sets}
    if made is None or not any(made.GetPrimAtPath(model) for model in models):
        return None
    # A thin root X.mtex.stage.usda has its own X.mtex.usd, with what others accepted or made.
    stem, is_thin = file_path.stem.removesuffix(".stage"), file_path.stem.endswith(".stage")
    target = file_path.with_name(f"{stem.removesuffix('.mtex')}{'.accepted' if is_thin else ''}.mtex.usd")
    check_target(target, "override")
    return target


def _open_target(file_path: Path, kind: str) -> Sdf.Layer:
    layer = Sdf.Layer.CreateAnonymous(f"accepted{file_path.suffix}")
    if file_path.exists():
        layer.TransferContent(read_layer(file_path))
    elif kind == "accepted":
        mark_layer(layer, "accepted")
    return layer


def _copy_edits(stage: Usd.Stage, layer: Sdf.Layer, path_set: PathSet, variant: str) -> None:
    """Take over what the session layer itself says of the variant: motion that was edited by hand."""
    session = stage.GetSessionLayer()
    path = path_set.model.AppendVariantSelection(path_set.name, variant).AppendChild(path_set.output.name)
    if not session.GetPrimAtPath(path):
        return
    Sdf.CreatePrimInLayer(layer, path)
    Sdf.CopySpec(session, path, layer, path)
    _retime(layer.GetPrimAtPath(path), session_offset(stage))


def _retime(prim: Sdf.PrimSpec, offset: Sdf.LayerOffset) -> None:
    """Bring times of the session layer to the stage's, where the two count otherwise."""
    if offset.IsIdentity():
        return
    for attribute in prim.attributes.values():
        samples = {time: prim.layer.QueryTimeSample(attribute.path, time) for time in _sample_times(attribute)}
        attribute.ClearInfo("timeSamples")
        for time, value in samples.items():
            prim.layer.SetTimeSample(attribute.path, offset * time, value)


def _sample_times(attribute: Sdf.AttributeSpec) -> list[float]:
    return list(attribute.layer.ListTimeSamplesForPath(attribute.path))


def _author_root(
    stage: Usd.Stage, layer: Sdf.Layer, path_sets: Sequence[PathSet], file_path: Path, *, stacked: bool
) -> None:
    shown = np.array([stage.GetStartTimeCode(), stage.GetEndTimeCode()])
    author_metadata(layer, read_root_metadata(stage, shown, path_sets[0].model))
    root = stage.GetRootLayer().realPath
    if not stacked:
        return
    if not root:
        raise InputError("the stage has no file that the layer could stack", fix="Save it first, or do not stack it.")
    _stack(layer, relative_path(root, file_path), last=True)


def _write_result(stage: Usd.Stage, layer: Sdf.Layer, target: Path, file_path: Path) -> None:
    made = session_result(stage)
    assert made is not None
    write_layer(made, target)
    _stack(layer, relative_path(str(target), file_path), last=False)


def _stack(layer: Sdf.Layer, path: str, *, last: bool) -> None:
    paths = [str(each) for each in layer.subLayerPaths]  # type: ignore[attr-defined]
    if path not in paths:
        layer.subLayerPaths.insert(len(paths) if last else 0, path)
