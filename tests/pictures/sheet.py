"""Draw a written result: strobed stick figures, one row per variant, read back through UsdSkel.

    python -m tests.pictures.sheet shot.mtex.stage.usda -o sheet.png --title "A walk"

Each figure is drawn where it stands, or, with --in-place, in columns side by side.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdSkel

mpl.use("Agg")
from matplotlib import pyplot as plt

LEFT, RIGHT, MIDDLE = "#0072b2", "#d55e00", "#444444"


def read_positions(
    stage: Usd.Stage, skeleton_path: str, time_codes: Sequence[float]
) -> tuple[np.ndarray, list[str], list[int]]:
    """Joint positions in skeleton space, shape [F, J, 3], with names and parents."""
    cache = UsdSkel.Cache()
    query = cache.GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath(skeleton_path)))
    topology = query.GetTopology()
    names = [str(joint).rpartition("/")[2] for joint in query.GetJointOrder()]
    frames = [np.array(query.ComputeJointSkelTransforms(t))[:, 3, :3] for t in time_codes]
    return np.array(frames), names, [topology.GetParent(i) for i in range(len(names))]


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


def side_of(name: str) -> str:
    """Colour of a bone by its side."""
    lower = name.lower()
    if lower.startswith("left") or (lower[0] == "l" and not lower.startswith("lower")):
        return LEFT
    if lower.startswith("right") or lower[0] == "r":
        return RIGHT
    return MIDDLE


def ground_axes(up: int) -> tuple[int, int]:
    """The two axes that span the ground."""
    return (2, 0) if up == 1 else (0, 1)


def draw_row(
    axes: plt.Axes, positions: np.ndarray, names: list[str], parents: list[int], up: int, shifts: np.ndarray
) -> None:
    """Draw one row of figures, seen along the ground's second axis."""
    along, _ = ground_axes(up)
    for pose, shift in zip(positions, shifts, strict=True):
        for joint, parent in enumerate(parents):
            if parent >= 0:
                ends = pose[[parent, joint]]
                axes.plot(ends[:, along] + shift, ends[:, up], color=side_of(names[joint]), linewidth=1.1)
    axes.set_aspect("equal")
    axes.axis("off")


def make_sheet(stage_path: Path, out: Path, *, variants: Sequence[str], count: int, title: str, in_place: bool) -> None:
    """Draw the chosen variants of a written stage."""
    stage = Usd.Stage.Open(str(stage_path))
    model, set_name = find_set(stage)
    up = 1 if UsdGeom.GetStageUpAxis(stage) == "Y" else 2
    times = np.linspace(stage.GetStartTimeCode(), stage.GetEndTimeCode(), count).round()
    names = list(variants) or ["original", *model.GetVariantSet(set_name).GetVariantNames()[1:4]]
    figure, rows = plt.subplots(len(names), 1, figsize=(12, 2.1 * len(names)), squeeze=False)
    for axes, name in zip(rows[:, 0], names, strict=True):
        prim = Sdf.CreatePrimInLayer(stage.GetSessionLayer(), model.GetPath())
        prim.variantSelections[set_name] = name
        positions, joints, parents = read_positions(stage, find_skeleton(model), times)
        height = np.ptp(positions[0][:, up])
        along = ground_axes(up)[0]
        roots = positions[:, 0, along]
        shifts = np.arange(count) * 0.75 * height - roots if in_place else np.zeros(count)
        draw_row(axes, positions, joints, parents, up, shifts)
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
