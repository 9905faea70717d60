"""The thin root: a small text layer that stacks the override layer over the shot, to be opened in a viewer.

USD reads the metadata of a stage from its root layer alone, so a root without it would change how the shot plays:
without ``timeCodesPerSecond`` over a shot of 30 a second, samples at 1 and 5 move to 0.8 and 4.

Users save into it what they set while looking, and stack layers of their own: all that stays when it is written again.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from pxr import Sdf, Usd, UsdGeom

from mtex_usd.errors import InputError
from mtex_usd.usd.atomic import file_kind, mark_layer
from mtex_usd.usd.diagnostics import read_layer
from mtex_usd.usd.stage_rate import stage_rate

__all__ = [
    "ROOT_METADATA",
    "StackedLayers",
    "author_metadata",
    "build_thin_root",
    "find_stacked",
    "read_root_metadata",
    "relative_path",
    "thin_root_path",
]

# What both files always author.
ROOT_METADATA = (
    "defaultPrim",
    "endTimeCode",
    "framesPerSecond",
    "metersPerUnit",
    "startTimeCode",
    "timeCodesPerSecond",
    "upAxis",
)

# What the shot's root layer says about itself and not about the stage.
_OWN = frozenset(
    {
        "comment",
        "customLayerData",
        "documentation",
        "hasOwnedSubLayers",
        "layerRelocates",
        "owner",
        "primChildren",
        "primOrder",
        "sessionOwner",
        "subLayerOffsets",
        "subLayers",
    }
)


def thin_root_path(out: Path) -> Path:
    """Name the thin root of an override layer: ``X.usd`` gives ``X.stage.usda``."""
    return out.with_name(f"{out.stem}.stage.usda")


@dataclass(frozen=True, kw_only=True)
class StackedLayers:
    """What a thin root stacks, whatever users stacked above, between and below.

    Parameters
    ----------
    override
        Our override layer; None where it was taken out.
    shot
        The shot.
    """

    override: Path | None
    shot: Path


def find_stacked(thin_root: Sdf.Layer) -> StackedLayers:
    """Find the override layer and the shot among the sublayers of a thin root.

    Parameters
    ----------
    thin_root
        Open from its file.

    Returns
    -------
    StackedLayers
        The override layer is the one that carries our mark; of several, and where it was deleted, the one whose name
        goes with the thin root's. The shot is the last of the others.

    Raises
    ------
    InputError
        Where there is no shot: nothing is stacked, as after flattening, or nothing but the override layer.
    """
    stacked = [Path(thin_root.ComputeAbsolutePath(path)) for path in _sublayers(thin_root)]
    override, shot = _find_ours(stacked, Path(thin_root.realPath).name)
    if shot is None:
        raise InputError(
            f"{thin_root.identifier} is marked as a thin root of usdmtex and stacks no shot",
            expected="the override layer and, last, the shot as sublayers",
            found=", ".join(_sublayers(thin_root)) or "no sublayers, as flattening leaves it",
            fix="Give the shot it was made of instead.",
        )
    return StackedLayers(override=None if override is None else stacked[override], shot=stacked[shot])


def _find_ours(stacked: list[Path], thin_root_name: str) -> tuple[int | None, int | None]:
    """Give the places of the override layer and of the shot; None for what is not there."""
    marked = [i for i, path in enumerate(stacked) if file_kind(path) == "override"]
    named = [i for i, path in enumerate(stacked) if thin_root_path(path).name == thin_root_name]
    lost = [i for i in named if not stacked[i].exists()]
    override = next(iter([*(i for i in marked if i in named), *marked, *lost[:1]]), None)
    others = [i for i in range(len(stacked)) if i != override and i not in marked]
    return override, others[-1] if others else None


def _sublayers(layer: Sdf.Layer) -> list[str]:
    return [str(path) for path in layer.subLayerPaths]  # type: ignore[attr-defined]


def read_root_metadata(stage: Usd.Stage, time_codes: npt.NDArray[np.float64], model: Sdf.Path) -> dict[str, object]:
    """Read what a root layer over this shot must say so that the shot plays unchanged.

    Parameters
    ----------
    stage
        The shot.
    time_codes
        Of the frames written; the shot's range is extended to hold them.
    model
        Its root prim becomes the default prim of a shot that names none.

    Returns
    -------
    dict of str to object
        By metadata field; both frame rates, range, up axis, unit and default prim are always there.
    """
    rate = stage_rate(stage)
    root = stage.GetRootLayer().pseudoRoot
    authored = {key: root.GetInfo(key) for key in root.ListInfoKeys() if key not in _OWN}
    start, end = float(time_codes.min()), float(time_codes.max())
    return authored | {
        "timeCodesPerSecond": rate.time_codes_per_second,
        "framesPerSecond": rate.rate,
        "startTimeCode": min(float(authored.get("startTimeCode", start)), start),
        "endTimeCode": max(float(authored.get("endTimeCode", end)), end),
        "upAxis": UsdGeom.GetStageUpAxis(stage),
        "metersPerUnit": UsdGeom.GetStageMetersPerUnit(stage),
        "defaultPrim": authored.get("defaultPrim") or model.GetPrefixes()[0].name,
    }


def author_metadata(layer: Sdf.Layer, metadata: Mapping[str, object]) -> None:
    """Author metadata that :func:`read_root_metadata` gave on a layer's root."""
    for key, value in sorted(metadata.items()):
        layer.pseudoRoot.SetInfo(key, value)


def build_thin_root(stage: Usd.Stage, metadata: Mapping[str, object], out: Path) -> Sdf.Layer:
    """Make the layer that stacks an override layer over a shot.

    Where the thin root is there already, only what is ours is made anew: the root's metadata and the two sublayers,
    which stay where the user has put them. Prims and other sublayers stay as they are.

    Parameters
    ----------
    stage
        The shot.
    metadata
        As :func:`read_root_metadata` gives it.
    out
        Where the override layer goes; the thin root goes beside it.

    Returns
    -------
    Sdf.Layer
        Anonymous; both sublayers by relative paths.

    Raises
    ------
    InputError
        Where the shot has no file, or what is there already cannot be read.
    """
    shot = stage.GetRootLayer().realPath
    if not shot:
        raise InputError("the stage has no file that a thin root could stack", fix="Save it first.")
    root = _open_earlier(thin_root_path(out))
    mark_layer(root, "stage")
    author_metadata(root, metadata)
    _stack(root, out, shot)
    return root


def _open_earlier(file_path: Path) -> Sdf.Layer:
    """Give what is there as a layer of its own; an empty one where nothing is."""
    root = Sdf.Layer.CreateAnonymous("stage.usda")
    if file_path.exists():
        root.TransferContent(read_layer(file_path))
    return root


def _stack(root: Sdf.Layer, out: Path, shot: str) -> None:
    """Put both layers where they are, else the shot last and the override layer directly above it."""
    stacked = [out.parent / path for path in _sublayers(root)]
    override, earlier_shot = _find_ours(stacked, thin_root_path(out).name)
    known = (i for i, path in enumerate(stacked) if os.path.realpath(path) == os.path.realpath(shot))
    below = next(known, earlier_shot)
    if below is None:
        below = len(stacked)
        root.subLayerPaths.append(relative_path(shot, out))
    root.subLayerPaths[below] = relative_path(shot, out)
    if override is None:
        root.subLayerPaths.insert(below, relative_path(str(out), out))
    else:
        root.subLayerPaths[override] = relative_path(str(out), out)


def relative_path(target: str, beside: Path) -> str:
    """Give how a layer names another one: relative to its own folder, as far as there is one drive.

    Parameters
    ----------
    target
        The file to be named.
    beside
        The layer that names it.
    """
    folder = os.path.abspath(beside.parent)  # noqa: PTH100 (Path.resolve would follow links, which anchoring does not)
    try:
        relative = os.path.relpath(os.path.abspath(target), folder)  # noqa: PTH100
    except ValueError:  # another drive
        return target
    posix = relative.replace(os.sep, "/")
    return posix if posix.startswith("../") else f"./{posix}"
