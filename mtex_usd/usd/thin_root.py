"""The thin root: a small text layer that stacks the override layer over the shot, to be opened in a viewer.

USD reads the metadata of a stage from its root layer alone, so a root without it would change how the shot plays:
without ``timeCodesPerSecond`` over a shot of 30 a second, samples at 1 and 5 move to 0.8 and 4.
"""

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt
from pxr import Sdf, Usd, UsdGeom

from mtex_usd.errors import InputError
from mtex_usd.usd.atomic import mark_layer
from mtex_usd.usd.stage_rate import stage_rate

__all__ = ["ROOT_METADATA", "author_metadata", "build_thin_root", "read_root_metadata", "thin_root_path"]

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
        Where the shot has no file.
    """
    shot = stage.GetRootLayer().realPath
    if not shot:
        raise InputError("the stage has no file that a thin root could stack", fix="Save it first.")
    root = Sdf.Layer.CreateAnonymous("stage.usda")
    mark_layer(root, "stage")
    author_metadata(root, metadata)
    root.subLayerPaths[:] = [_relative(str(out), out), _relative(shot, out)]
    return root


def _relative(target: str, beside: Path) -> str:
    folder = os.path.abspath(beside.parent)  # noqa: PTH100 (Path.resolve would follow links, which anchoring does not)
    try:
        relative = os.path.relpath(os.path.abspath(target), folder)  # noqa: PTH100
    except ValueError:  # another drive
        return target
    posix = relative.replace(os.sep, "/")
    return posix if posix.startswith("../") else f"./{posix}"
