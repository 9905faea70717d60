"""Opening what the animator made, also where our own output is already stacked over it.

A second run has to read the original animation: given a thin root it opens the shot below, and override layers of ours
anywhere on the stage are muted. Nothing is ever edited here.
"""

from dataclasses import dataclass
from pathlib import Path

from pxr import Sdf, Tf, Usd

from mtex_usd.errors import InputError
from mtex_usd.usd.diagnostics import describe_error

__all__ = ["SourceStage", "layer_kind", "open_source"]


@dataclass(frozen=True, kw_only=True)
class SourceStage:
    """A shot as its animator left it.

    Parameters
    ----------
    stage
        Open for reading; our own override layers are muted, also those that a thin root stacked over it.
    source_path
        The shot's file; differs from the file asked for where that was a thin root of ours.
    previous_override
        The strongest override layer of ours that was stacked over the shot; None where there was none.
    """

    stage: Usd.Stage
    source_path: Path
    previous_override: Path | None


def layer_kind(layer: Sdf.Layer) -> str:
    """Tell what we wrote a layer as, ``"override"``, ``"stage"`` or ``"takes"``; empty for a layer not ours."""
    mark = layer.customLayerData.get("mtex")
    return str(mark.get("kind", "")) if isinstance(mark, dict) and mark.get("generator") == "usdmtex" else ""


def open_source(stage_path: Path) -> SourceStage:
    """Open a shot for reading, through our own thin root and without our override layers.

    Parameters
    ----------
    stage_path
        A shot or a thin root written by :func:`mtex_usd.usd.override.write_override`.

    Returns
    -------
    SourceStage
        The stage, and what lay over the shot.

    Raises
    ------
    InputError
        Where the file, or the shot that a thin root stacks, is missing or no USD file; where it is an override layer.
    """
    layer = _open_layer(stage_path)
    if layer_kind(layer) == "override":
        raise InputError(
            f"{stage_path} is an override layer, which holds no animation of its own",
            fix="Give the shot or the thin root (.stage.usda) instead.",
        )
    if layer_kind(layer) != "stage":
        return _open_shot(layer, None)
    override, shot = _sublayers_of(layer)
    return _open_shot(_open_layer(shot), override)


def _sublayers_of(thin_root: Sdf.Layer) -> tuple[Path, Path]:
    # A user may have stacked more layers in between.
    sublayers: list[str] = list(thin_root.subLayerPaths)  # type: ignore[call-overload]
    if len(sublayers) < 2:
        raise InputError(
            f"{thin_root.identifier} is a thin root that stacks no shot",
            expected="the override layer and the shot as sublayers",
            found=", ".join(sublayers) or "none",
            fix="Give the shot instead.",
        )
    return Path(thin_root.ComputeAbsolutePath(sublayers[0])), Path(thin_root.ComputeAbsolutePath(sublayers[-1]))


def _open_layer(file_path: Path) -> Sdf.Layer:
    if not file_path.is_file():
        found = "a folder" if file_path.is_dir() else "no such file"
        raise InputError(f"cannot open {file_path}", expected="a USD file", found=found)
    try:
        layer = Sdf.Layer.FindOrOpen(str(file_path))
    except Tf.ErrorException as error:
        raise InputError(f"cannot read {file_path}: {describe_error(error)}") from error
    if not layer:
        raise InputError(f"cannot read {file_path}", expected="a USD file")
    return layer


def _open_shot(layer: Sdf.Layer, previous: Path | None) -> SourceStage:
    stage = Usd.Stage.Open(layer)
    ours = [used.realPath for used in _layers_by_strength(stage) if layer_kind(used) == "override"]
    overrides = [str(previous), *ours] if previous else ours
    if overrides:
        stage.MuteAndUnmuteLayers(overrides, [])
    return SourceStage(
        stage=stage,
        source_path=Path(layer.realPath),
        previous_override=Path(overrides[0]) if overrides else None,
    )


def _layers_by_strength(stage: Usd.Stage) -> list[Sdf.Layer]:
    stacked = stage.GetLayerStack(includeSessionLayers=False)
    others = sorted(set(stage.GetUsedLayers()) - set(stacked), key=lambda layer: layer.identifier)
    return [*stacked, *others]
