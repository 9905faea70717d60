"""Opening what the animator made, also where our own output is already stacked over it.

A second run has to read the original animation: given a thin root it opens the shot below, and override layers of ours
anywhere on the stage are muted. Nothing is ever edited here.
"""

from dataclasses import dataclass
from pathlib import Path

from pxr import Sdf, Usd

from mtex_usd.errors import InputError
from mtex_usd.usd.atomic import layer_kind
from mtex_usd.usd.diagnostics import open_layer
from mtex_usd.usd.thin_root import find_stacked

__all__ = ["SourceStage", "find_override", "open_source"]


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


def find_override(stage_path: Path) -> Path:
    """Tell which override layer a run on a file is going to write, unless it is told otherwise.

    Parameters
    ----------
    stage_path
        A shot, or a thin root.

    Returns
    -------
    Path
        ``<shot>.mtex.usd`` beside a shot; the one that a thin root stacks.

    Raises
    ------
    InputError
        As :func:`open_source`.
    """
    layer = open_layer(stage_path)
    if layer_kind(layer) != "stage":
        return stage_path.with_name(f"{stage_path.stem}.mtex.usd")
    return find_stacked(layer).override or stage_path.with_name(f"{stage_path.stem.removesuffix('.stage')}.usd")


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
    layer = open_layer(stage_path)
    if layer_kind(layer) == "override":
        raise InputError(
            f"{stage_path} is an override layer, which holds no animation of its own",
            fix="Give the shot or the thin root (.stage.usda) instead.",
        )
    if layer_kind(layer) != "stage":
        return _open_shot(layer, None)
    stacked = find_stacked(layer)
    return _open_shot(open_layer(stacked.shot), stacked.override)


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
