"""Draw a take and the same motion on characters of other skeletons, one row each.

    python -m tests.pictures.retargeting takes.usd /Takes/take_91_01 A.usda B.usdz -o retarget.png

Every figure is seen from its own right side.
"""

import argparse
from pathlib import Path

import matplotlib as mpl
import numpy as np
from pxr import Usd, UsdSkel

import mtex_usd
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.usd.skeletons import read_skeleton
from tests.pictures.sheet import draw_row, find_view

mpl.use("Agg")
from matplotlib import pyplot as plt


def read_character(stage_path: str) -> Skeleton:
    """The first Skeleton of a stage."""
    stage = Usd.Stage.Open(stage_path)
    return next(read_skeleton(prim) for prim in stage.Traverse() if prim.IsA(UsdSkel.Skeleton))


def draw_clip(axes: plt.Axes, clip: mtex_usd.Clip, frames: np.ndarray, title: str) -> None:
    """Draw one row, as high as the others whatever the unit."""
    skeleton, up = clip.skeleton, clip.skeleton.up
    positions, _ = skeleton.world_pose(clip.rotations[frames], clip.translations[frames])
    positions = positions / np.median(np.ptp(positions[:, :5] @ up, axis=1))
    views = np.array([find_view(pose, skeleton, up) for pose in positions])
    shifts = np.arange(len(frames)) * 1.6 - np.sum(positions[:, 0] * views, axis=1)
    draw_row(axes, positions, skeleton, up, views, shifts)
    axes.set_title(title, loc="left", fontsize=9, family="monospace")


def main() -> None:
    """Read the command line and draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("takes")
    parser.add_argument("take")
    parser.add_argument("characters", nargs="+")
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--figures", type=int, default=12)
    given = parser.parse_args()
    clip = mtex_usd.read_clip(given.takes, given.take)
    frames = np.linspace(0, clip.frame_count - 1, given.figures).astype(int)
    rows = [(given.take, clip)]
    rows += [(Path(name).name, mtex_usd.constraints.retarget(clip, read_character(name))) for name in given.characters]
    figure, axes = plt.subplots(len(rows), 1, figsize=(12, 2.1 * len(rows)), squeeze=False)
    for row, (title, motion) in zip(axes[:, 0], rows, strict=True):
        draw_clip(row, motion, frames, title)
    figure.tight_layout()
    figure.savefig(given.output, dpi=90)


if __name__ == "__main__":
    main()
