"""Strobed stick figures and foot heights, before and after."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np

from mtex_usd.constraints.contacts import find_effectors
from mtex_usd.constraints.kinematics import place_points
from mtex_usd.motion.clip import Clip
from tests.pictures.sheet import draw_row, find_view

mpl.use("Agg")
from matplotlib import pyplot as plt

FIGURES = 12


def draw_scene(before: Sequence[Clip], after: Sequence[Clip], out: Path) -> None:
    """Draw the motions of a scene, seen from the first character's right side, and the heights of their feet."""
    figure, axes = plt.subplots(3, 1, figsize=(12, 8))
    for row, clips, title in ((axes[0], before, "before"), (axes[1], after, "after")):
        for clip in clips:
            _draw_clip(row, clip, clips[0])
        row.set_title(title, loc="left", fontsize=9, family="monospace")
    for clips, style in ((before, ":"), (after, "-")):
        _draw_feet(axes[2], clips[-1], style)
    figure.tight_layout()
    figure.savefig(out, dpi=80)
    plt.close(figure)


def _draw_clip(axes: plt.Axes, clip: Clip, seen_from: Clip) -> None:
    frames = np.linspace(0, clip.frame_count - 1, FIGURES).astype(int)
    positions, _ = clip.skeleton.world_pose(clip.rotations[frames], clip.translations[frames])
    first, _ = seen_from.skeleton.world_pose(seen_from.rotations[:1], seen_from.translations[:1])
    view = find_view(first[0], seen_from.skeleton, clip.skeleton.up)
    shifts = np.linspace(0.0, 0.4 * FIGURES * np.ptp(positions[0] @ clip.skeleton.up), FIGURES)
    draw_row(axes, positions, clip.skeleton, clip.skeleton.up, np.tile(view, (FIGURES, 1)), shifts)


def _draw_feet(axes: plt.Axes, clip: Clip, style: str) -> None:
    effectors = find_effectors(clip.skeleton)
    joints, offsets = [e.joint for e in effectors], np.array([e.offset for e in effectors])
    places = place_points(clip.skeleton, joints, offsets, clip.rotations, clip.translations)
    for number, effector in enumerate(effectors):
        colour = "#0072b2" if effector.name.startswith("left") else "#d55e00"
        axes.plot(places[:, number] @ clip.skeleton.up, style, color=colour, linewidth=0.8)
    axes.set_title("heights of heels and toes (dotted: before)", loc="left", fontsize=9, family="monospace")
