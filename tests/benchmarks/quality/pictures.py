"""Pictures to judge results by: stick figures in strobes from the side and the front, and curves over time."""

import re
from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
import numpy.typing as npt

mpl.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.facing import measure_heading
from mtex_usd.texture.pyramid import decompose
from mtex_usd.texture.result import TexturedMotion, Variant
from tests.benchmarks.quality.baselines import regress_pose
from tests.benchmarks.quality.cases import METERS_PER_UNIT, Fold
from tests.benchmarks.quality.metrics import joint_indices, pose_vectors, position_error, put_on_truth
from tests.benchmarks.quality.settings import DEFAULT, LITERAL, SETTINGS, run_method

__all__ = ["draw_case", "draw_curves", "draw_strip"]

FloatArray = npt.NDArray[np.float64]

LEFT, RIGHT, MIDDLE, FAINT = "#0072b2", "#d55e00", "#333333", "#bbbbbb"
_FIGURES = 16
_SPACING = 1.1  # metres from figure to figure
_ARMS = {"release": ("LeftArm", "RightArm", "LeftForeArm"), "original": ("lhumerus", "rhumerus", "lradius")}


def draw_case(folds: Sequence[Fold], folder: Path, *, most: int = 2) -> list[Path]:
    """Draw the first folds of a case; give the files."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for fold in folds[:most]:
        results = {name: run_method(fold, **SETTINGS[name]) for name in (LITERAL, DEFAULT)}
        stem = re.sub(r"\W+", "_", f"{fold.case.name} {fold.truth.name}")
        files.append(draw_strip(fold, results, folder / f"{stem}_strip.png"))
        files.append(draw_curves(fold, results, folder / f"{stem}_curves.png"))
    return files


def draw_strip(fold: Fold, results: dict[str, TexturedMotion], file_path: Path) -> Path:
    """Strobed figures, truth, sketch, both results and regression in rows, seen from the side and from the front."""
    rows = {
        "truth": fold.truth,
        "sketch": fold.sketch,
        **{name.split(":")[0]: put_on_truth(fold, r.variants[0].clip) for name, r in results.items()},
        "ridge": put_on_truth(fold, regress_pose(fold)),
    }
    figure, axes = plt.subplots(2 * len(rows), 1, figsize=(22, 5.2 * len(rows)), layout="constrained")
    frames = np.unique(np.linspace(0, fold.truth.frame_count - 1, _FIGURES).astype(int))
    for row, (name, clip) in enumerate(rows.items()):
        error = f", {position_error(fold, clip):.3f} m" if name not in ("truth", "sketch") else ""
        for view in (0, 1):
            axis = axes[2 * row + view]
            _draw_figures(axis, clip, frames, view)
            axis.set_title(f"{name}{error}, {('side', 'front')[view]}", loc="left")
    figure.suptitle(f"{fold.case.name}: {fold.truth.name}, every figure in place; left blue, right orange")
    return _save(figure, file_path)


def _draw_figures(axis: Axes, clip: Clip, frames: npt.NDArray[np.intp], view: int) -> None:
    """Figures side by side, each turned to face the same way."""
    positions = _facing_positions(clip)
    names = [joint.rpartition("/")[2].lower() for joint in clip.joints]
    bones = [j for j, parent in enumerate(clip.parents) if parent >= 0 and not _is_finger(names[j])]
    for number, frame in enumerate(frames):
        across = positions[frame, :, 2 if view == 0 else 0] + number * _SPACING
        for joint in bones:
            ends = [int(clip.parents[joint]), joint]
            axis.plot(across[ends], positions[frame, ends, 1], color=_side_colour(names[joint]), lw=1.8)
        axis.text(number * _SPACING, -0.08, str(frame), ha="center", va="top", fontsize=8)
    axis.set_aspect("equal")
    axis.set_axis_off()


def _is_finger(name: str) -> bool:
    return any(part in name for part in ("thumb", "finger", "index"))


def _side_colour(name: str) -> str:
    if name.startswith("lower"):
        return MIDDLE
    return {"l": LEFT, "r": RIGHT}.get(name[0], MIDDLE)


def _facing_positions(clip: Clip) -> FloatArray:
    """Joint positions in metres about the root's place on the floor, turned so that the character faces along z."""
    positions, _ = clip.skeleton.world_pose(clip.rotations, clip.translations)
    floor = positions[..., 1].min()
    centred = positions - np.stack([positions[:, 0, 0], np.full(len(positions), floor), positions[:, 0, 2]], 1)[:, None]
    heading = decompose(measure_heading(clip, 0)[:, None]).at_or_below(4)[:, 0]
    turns = quaternion.exp(-heading[:, None] * clip.skeleton.up)
    return METERS_PER_UNIT * quaternion.rotate(turns[:, None], centred)


def draw_curves(fold: Fold, results: dict[str, TexturedMotion], file_path: Path) -> Path:
    """Arm channels over time with breaks and joins, one channel's bands, and the fragments the path was made of."""
    joints = _ARMS["original" if fold.truth.joints[0] == "root" else "release"]
    figure, axes = plt.subplots(len(joints) + 4, 1, figsize=(16, 3.0 * (len(joints) + 4)), layout="constrained")
    clips = {"truth": fold.truth, "ridge": regress_pose(fold)}
    clips |= {name.split(":")[0]: result.variants[0].clip for name, result in results.items()}
    for axis, joint in zip(axes, joints, strict=False):
        _draw_joint(axis, fold, clips, joint)
        _mark_joins(axis, results[DEFAULT].variants[0])
    _draw_bands(axes[len(joints) : len(joints) + 2], fold, clips, joints[0])
    _draw_fragments(axes[-2], fold, results[DEFAULT], joints[0])
    _draw_speeds(axes[-1], fold, clips)
    _mark_joins(axes[-1], results[DEFAULT].variants[0])
    for axis in axes:
        axis.set_xlim(0, fold.truth.frame_count - 1)
    axes[0].legend(loc="upper right", fontsize=8)
    figure.suptitle(
        f"{fold.case.name}: {fold.truth.name}; lines: breaks of the default, solid where a join is not consecutive"
    )
    return _save(figure, file_path)


def _style(name: str) -> dict[str, object]:
    colours = {"truth": "black", "ridge": FAINT, "literal PB": RIGHT, "default": LEFT}
    return {"color": colours[name], "lw": 2.0 if name == "truth" else 1.3, "label": name}


def _component(fold: Fold, clip: Clip, joint: str) -> FloatArray:
    """The one of a joint's three curves that moves most in the truth, degrees."""
    index = joint_indices(fold.truth, [joint])
    mean = quaternion.mean(fold.truth.rotations[:, index])
    main = int(np.ptp(pose_vectors(fold.truth, index, mean), axis=0).argmax())
    return pose_vectors(clip, index, mean)[:, main]


def _draw_joint(axis: Axes, fold: Fold, clips: dict[str, Clip], joint: str) -> None:
    for name, clip in clips.items():
        axis.plot(_component(fold, clip, joint), **_style(name))
    axis.set_ylabel(f"{joint}, °")


def _draw_bands(axes: Sequence[Axes], fold: Fold, clips: dict[str, Clip], joint: str) -> None:
    """Bands 2 and 3 together, and the match band."""
    for axis, (first, last) in zip(axes, ((2, 3), (fold.case.band, fold.case.band)), strict=True):
        for name, clip in clips.items():
            axis.plot(decompose(_component(fold, clip, joint)[:, None]).sum_of(first, last)[:, 0], **_style(name))
        axis.set_ylabel(f"{joint}, bands {first} to {last}")


def _draw_fragments(axis: Axes, fold: Fold, result: TexturedMotion, joint: str) -> None:
    """The pieces of every variant, as recorded, stretched in time."""
    takes = {take.name: take for take in fold.takes}
    axis.plot(_component(fold, fold.truth, joint), color="black", lw=2.0)
    for variant in result.variants:
        for used in variant.fragments:
            piece = _component(fold, takes[used.take], joint)[int(used.take_start) : int(used.take_end) + 1]
            times = np.linspace(used.start, used.end, len(piece))
            first = variant.rank == 1
            axis.plot(times, piece, color=LEFT if first else FAINT, lw=1.6 if first else 0.8, zorder=2 if first else 1)
    axis.set_ylabel(f"{joint}, pieces as recorded")


def _draw_speeds(axis: Axes, fold: Fold, clips: dict[str, Clip]) -> None:
    joints = joint_indices(fold.truth, fold.case.rig.synthesized)
    for name, clip in clips.items():
        turns = quaternion.angle_between(clip.rotations[:-1, joints], clip.rotations[1:, joints])
        axis.plot(np.degrees(turns).max(axis=1), **_style(name))
    axis.set_ylabel("fastest joint, °/frame")


def _mark_joins(axis: Axes, variant: Variant) -> None:
    for left, right in zip(variant.fragments[:-1], variant.fragments[1:], strict=True):
        follows = left.take == right.take and left.take_end == right.take_start
        axis.axvline(left.end, color=FAINT, lw=1.2, ls=":" if follows else "-", zorder=0)


def _save(figure: plt.Figure, file_path: Path) -> Path:
    figure.savefig(file_path, dpi=60)
    plt.close(figure)
    return file_path
