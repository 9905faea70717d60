"""Draw a written result: strobed stick figures, one row per variant, read back through UsdSkel.

    python -m tests.pictures.sheet shot.mtex.stage.usda -o sheet.png --title "A walk"

The drawing is that of ``usdmtex --sheet``; what it draws is here read from the stage that was written, whatever wrote
it. Figures are seen from their right side where they stand if they go far enough, else, or with --in-place, each from
its own in columns side by side. Other pictures draw single rows into figures of matplotlib.
"""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdSkel

from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.review.body import find_bones, find_front, find_sides
from mtex_usd.review.sheet import SKETCH_COLOUR, VARIANT_COLOURS
from mtex_usd.review.sheet_drawing import SheetBlock, SheetRow, draw_sheet
from mtex_usd.usd.skeletons import read_skeleton

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SIDE_COLOURS = {"left": "#0072b2", "right": "#d55e00", "middle": "#444444"}


def find_view(pose: np.ndarray, skeleton: Skeleton, up: np.ndarray) -> np.ndarray:
    """The level direction a figure faces: it is drawn from its right side."""
    return find_front(replace(skeleton, up=up), pose)


def draw_row(
    axes: "Axes", positions: np.ndarray, skeleton: Skeleton, up: np.ndarray, views: np.ndarray, shifts: np.ndarray
) -> None:
    """Draw one row of figures, each seen across its view."""
    sides = find_sides(skeleton)
    bones = find_bones(replace(skeleton, up=up), positions[0])
    for pose, view, shift in zip(positions, views, shifts, strict=True):
        for parent, joint in bones:
            ends = pose[[parent, joint]]
            axes.plot(ends @ view + shift, ends @ up, color=SIDE_COLOURS[sides[joint]], linewidth=1.1)
    axes.set_aspect("equal")
    axes.axis("off")


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


def read_rows(
    stage: Usd.Stage, model: Usd.Prim, set_name: str, names: Sequence[str], time_codes: Sequence[float]
) -> tuple[tuple[SheetRow, ...], Skeleton]:
    """Give a row per variant, the original in grey, and the skeleton, its up that of the stage."""
    rows = []
    for name in names:
        prim = Sdf.CreatePrimInLayer(stage.GetSessionLayer(), model.GetPath())
        prim.variantSelections[set_name] = name
        skeleton_path = find_skeleton(model)
        colour = SKETCH_COLOUR if name == "original" else VARIANT_COLOURS[len(rows) % len(VARIANT_COLOURS)]
        rows.append(
            SheetRow(name=name, caption=(), colour=colour, positions=read_positions(stage, skeleton_path, time_codes))
        )
    skeleton = read_skeleton(stage.GetPrimAtPath(skeleton_path))
    up = np.eye(3)[1 if UsdGeom.GetStageUpAxis(stage) == "Y" else 2]
    return tuple(rows), Skeleton(joints=skeleton.joints, rest=skeleton.rest, up=up)


def make_sheet(stage_path: Path, out: Path, *, variants: Sequence[str], count: int, title: str, in_place: bool) -> None:
    """Draw the chosen variants of a written stage."""
    stage = Usd.Stage.Open(str(stage_path))
    model, set_name = find_set(stage)
    times = np.linspace(stage.GetStartTimeCode(), stage.GetEndTimeCode(), count).round()
    names = list(variants) or ["original", *model.GetVariantSet(set_name).GetVariantNames()[1:4]]
    rows, skeleton = read_rows(stage, model, set_name, names, times.tolist())
    block = SheetBlock(heading=str(model.GetPath()), skeleton=skeleton, time_codes=times, rows=rows)
    out.write_bytes(draw_sheet([block], title=title or stage_path.name, in_place=in_place or None))


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
