"""Panels for pictures of motion: a channel over time, strobed figures, the way over the floor.

What was there before is grey, what an edit made of it has a colour of Okabe & Ito's palette, which colour-blind people
can tell apart.
"""

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from PIL import Image

from mtex_usd.edit.curve_space import CurveSpace
from mtex_usd.edit.frames import take_frames
from mtex_usd.motion.channels import resolve_channels
from mtex_usd.motion.clip import Clip
from tests.pictures.sheet import find_view

mpl.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.collections import LineCollection

__all__ = [
    "BLUE",
    "GREEN",
    "GREY",
    "ORANGE",
    "VERMILION",
    "cut",
    "draw_curve",
    "draw_figures",
    "draw_way",
    "label",
    "make_figure",
    "place_joint",
    "read_channel",
    "save",
]

GREY, BLUE, VERMILION, GREEN = "#999999", "#0072b2", "#d55e00", "#009e73"
ORANGE = "#e69f00"

_SIZE_INCHES, _DPI, _COLOURS = (10.0, 4.5), 100, 256


def make_figure(title: str, layout: str) -> tuple[plt.Figure, dict[str, plt.Axes]]:
    """Make a picture with named panels, laid out as in matplotlib's subplot_mosaic."""
    rows = [list(row) for row in layout.split("/")]
    figure, panels = plt.subplot_mosaic(rows, figsize=_SIZE_INCHES, layout="constrained")
    figure.suptitle(title, fontsize=11)
    for axes in panels.values():
        axes.tick_params(labelsize=7)
        axes.spines[["top", "right"]].set_visible(False)
    return figure, panels


def label(axes: plt.Axes, title: str, x: str = "time [s]", y: str = "", *, legend: bool = False) -> None:
    """Write what a panel shows."""
    axes.set_title(title, loc="left", fontsize=8.5, pad=16 if legend else 6)
    axes.set_xlabel(x, fontsize=8)
    axes.set_ylabel(y, fontsize=8)
    if legend:
        # Above the panel, where no curve is.
        axes.legend(fontsize=7, frameon=False, loc="lower left", bbox_to_anchor=(-0.01, 0.98), ncols=5, borderpad=0.0)


def save(figure: plt.Figure, file_path: Path) -> None:
    """Write a small PNG: lines need few colours."""
    figure.canvas.draw()
    figure.savefig(file_path, dpi=_DPI)
    plt.close(figure)
    with Image.open(file_path) as image:
        few = image.convert("RGB").quantize(_COLOURS, dither=Image.Dither.NONE)
    few.save(file_path, optimize=True)


def cut(clip: Clip, first: int, last: int) -> Clip:
    """Take frames first to last, both included."""
    return take_frames(clip, slice(first, last + 1))


def read_channel(clip: Clip, token: str) -> np.ndarray:
    """One channel in degrees or stage units, shape [F]."""
    (channel,) = resolve_channels([token], clip.joints, source="the picture")
    angles, offsets = ((channel,), ()) if channel.is_rotation else ((), (channel,))
    return CurveSpace(clip, (), angles, offsets).curves[:, 0]


def place_joint(clip: Clip, name: str) -> np.ndarray:
    """Places of a joint in skeleton space, shape [F, 3]."""
    joint = next(index for index, path in enumerate(clip.joints) if path.rpartition("/")[2] == name)
    return clip.skeleton.joint_positions([joint], clip.rotations, clip.translations)[:, 0]


def draw_curve(axes: plt.Axes, clip: Clip, values: np.ndarray, colour: str, **style: object) -> None:
    """Draw a value of every frame over the time in seconds."""
    axes.plot(np.arange(len(values)) / clip.rate, values, color=colour, **{"linewidth": 1.2, **style})


def draw_figures(
    axes: plt.Axes,
    clip: Clip,
    frames: Sequence[int],
    colour: str,
    *,
    view: np.ndarray | None = None,
    apart: float = 0.0,
) -> None:
    """Draw stick figures at frames, seen across a level direction; with `apart` each on its own place, so far on.

    The direction is that of the first figure's own right side where none is given.
    """
    skeleton, up = clip.skeleton, clip.skeleton.up
    positions, _ = skeleton.world_pose(clip.rotations[list(frames)], clip.translations[list(frames)])
    across = find_view(positions[0], skeleton, up) if view is None else view
    along = positions @ across
    if apart:
        along = along - along[:, :1] + apart * np.arange(len(along))[:, None]
    points = np.stack([along, positions @ up], axis=-1)
    joints = np.flatnonzero(skeleton.parents >= 0)
    bones = np.stack([points[:, skeleton.parents[joints]], points[:, joints]], axis=2)
    axes.add_collection(LineCollection(bones.reshape(-1, 2, 2), colors=colour, linewidths=1.2))
    axes.autoscale_view()
    axes.set_aspect("equal")


def draw_way(axes: plt.Axes, clip: Clip, colour: str, **style: object) -> None:
    """Draw the way of the hips over the floor, seen from above, in metres."""
    places = place_joint(clip, "Hips") * clip.skeleton.meters_per_unit
    axes.plot(places[:, 0], places[:, 2], color=colour, **{"linewidth": 1.4, **style})
    axes.set_aspect("equal")
