"""Draw a written result: strobed stick figures, one row per variant, read back through UsdSkel.

    python -m tests.pictures.sheet shot.mtex.stage.usda -o sheet.png --title "A walk"

Figures are seen from their right side where they stand, or, with --in-place, each from its own in columns side by side.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdSkel

from mtex_usd.motion.anatomy import find_anatomy
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.texture.facing import find_hips
from mtex_usd.usd.skeletons import read_skeleton

mpl.use("Agg")
from matplotlib import pyplot as plt

LEFT, RIGHT, MIDDLE = "#0072b2", "#d55e00", "#444444"


def read_positions(stage: Usd.Stage, skeleton_path: str, time_codes: Sequence[float]) -> np.ndarray:
    """Joint positions in the world, shape [F, J, 3]."""
    prim = stage.GetPrimAtPath(skeleton_path)
    query = UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton(prim))
    frames = []
    for time_code in time_codes:
        world = UsdGeom.XformCache(time_code).GetLocalToWorldTransform(prim)
        frames.append(np.array([matrix * world for matrix in query.ComputeJointSkelTransforms(time_code)])[:, 3, :3])
    return np.array(frames)


def find_set(stage: Usd.Stage) -> tuple[Usd.Prim, str]:
    """The first prim with a variant set of ours."""
    for prim in stage.Traverse():
        for name in prim.GetVariantSets().GetNames():
            if name == "mtex" or name.startswith("mtex_"):
                return prim, name
    raise SystemExit("no mtex variant set on this stage")


def find_skeleton(model: Usd.Prim) -> str:
    """The first bound Skeleton at or below the model."""
    prims = Usd.PrimRange(model, Usd.TraverseInstanceProxies())
    return next(str(prim.GetPath()) for prim in prims if prim.IsA(UsdSkel.Skeleton))


def colour_joints(skeleton: Skeleton) -> list[str]:
    """Colour of every joint's bone by the side of the body it is on."""
    anatomy = find_anatomy(skeleton)
    begins = {} if anatomy is None else anatomy.parts
    sides = {LEFT: "left.", RIGHT: "right."}
    colours = []
    for joint in range(len(skeleton.joints)):
        above = skeleton.chain(joint)
        found = [
            c for c, side in sides.items() if any(j in above for part, j in begins.items() if part.startswith(side))
        ]
        colours.append(found[0] if found else MIDDLE)
    return colours


def find_view(pose: np.ndarray, skeleton: Skeleton, up: np.ndarray) -> np.ndarray:
    """The level direction a figure faces: it is drawn from its right side."""
    hips = find_hips(skeleton)
    across = pose[hips[1]] - pose[hips[0]] if hips else np.eye(3)[0]
    anatomy = find_anatomy(skeleton)
    if anatomy is not None and hips and hips[0] == anatomy.parts["right.thigh"]:
        across = -across
    front = np.cross(up, across)
    return front / np.linalg.norm(front)


def draw_row(
    axes: plt.Axes, positions: np.ndarray, skeleton: Skeleton, up: np.ndarray, views: np.ndarray, shifts: np.ndarray
) -> None:
    """Draw one row of figures, each seen across its view; bones that no rest pose places are left out."""
    colours = colour_joints(skeleton)
    longest = 0.5 * np.ptp(positions[0] @ up)
    for pose, view, shift in zip(positions, views, shifts, strict=True):
        for joint, parent in enumerate(skeleton.parents):
            ends = pose[[parent, joint]]
            if parent >= 0 and np.linalg.norm(ends[1] - ends[0]) < longest:
                axes.plot(ends @ view + shift, ends @ up, color=colours[joint], linewidth=1.1)
    axes.set_aspect("equal")
    axes.axis("off")


def make_sheet(stage_path: Path, out: Path, *, variants: Sequence[str], count: int, title: str, in_place: bool) -> None:
    """Draw the chosen variants of a written stage."""
    stage = Usd.Stage.Open(str(stage_path))
    model, set_name = find_set(stage)
    up = np.eye(3)[1 if UsdGeom.GetStageUpAxis(stage) == "Y" else 2]
    times = np.linspace(stage.GetStartTimeCode(), stage.GetEndTimeCode(), count).round()
    names = list(variants) or ["original", *model.GetVariantSet(set_name).GetVariantNames()[1:4]]
    figure, rows = plt.subplots(len(names), 1, figsize=(12, 2.1 * len(names)), squeeze=False)
    for axes, name in zip(rows[:, 0], names, strict=True):
        prim = Sdf.CreatePrimInLayer(stage.GetSessionLayer(), model.GetPath())
        prim.variantSelections[set_name] = name
        skeleton_path = find_skeleton(model)
        skeleton = read_skeleton(stage.GetPrimAtPath(skeleton_path))
        positions = read_positions(stage, skeleton_path, times)
        views = np.array([find_view(pose, skeleton, up) for pose in positions])
        shifts = np.zeros(count)
        if in_place:
            spread = np.arange(count) * 0.75 * np.ptp(positions[0] @ up)
            shifts = spread - np.sum(positions[:, 0] * views, axis=1)
        else:
            views[:] = find_view(positions[0], skeleton, up)
        draw_row(axes, positions, skeleton, up, views, shifts)
        axes.set_title(name, loc="left", fontsize=9, family="monospace")
    figure.suptitle(title, fontsize=11)
    figure.tight_layout()
    figure.savefig(out, dpi=90)
    plt.close(figure)


def main() -> None:
    """Read the command line and draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stage", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--variant", action="append", default=[])
    parser.add_argument("--figures", type=int, default=14)
    parser.add_argument("--title", default="")
    parser.add_argument("--in-place", action="store_true")
    given = parser.parse_args()
    make_sheet(
        given.stage,
        given.output,
        variants=given.variant,
        count=given.figures,
        title=given.title,
        in_place=given.in_place,
    )


if __name__ == "__main__":
    main()
