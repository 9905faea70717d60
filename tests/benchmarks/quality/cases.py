"""The benchmark's cases: real captures, sketches made from them, and takes.

Protocol: drop CMU's added first frame (07_12: the first three), resample the unrolled Euler curves and the root from 120 to 24
frames/s with ``scipy.signal.resample_poly(x, 1, 5, padtype="line")``. The sketch is a cubic spline through every sixth frame
and the last of root, hips, thighs, shins and feet; all else is identity. The takes are the other clips of the case.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline
from scipy.signal import resample_poly

from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton

FloatArray = npt.NDArray[np.float64]

RATE = 24.0
METERS_PER_UNIT = 0.05644
SKETCHED = ("Hips", "LeftUpLeg", "LeftLeg", "LeftFoot", "RightUpLeg", "RightLeg", "RightFoot")
UPPER_BODY = (
    *("LowerBack", "Spine", "Spine1", "Neck", "Neck1", "Head"),
    *("LeftShoulder", "LeftArm", "LeftForeArm", "RightShoulder", "RightArm", "RightForeArm"),
)


@dataclass(frozen=True)
class Case:
    """One row of the table."""

    name: str
    subject: str
    clips: tuple[str, ...]
    match: tuple[str, ...]
    band: int
    limit: float


WALK = Case("walk 07", "07", tuple(f"07_{i:02}" for i in range(1, 10)), ("LeftUpLeg.rx", "LeftLeg.rx"), 4, 0.040)
DANCE = Case(
    "dance 05",
    "05",
    tuple(f"05_{i:02}" for i in (2, 3, 4, 7, 9, 12)),
    ("LeftUpLeg.rx", "RightUpLeg.rx", "LeftLeg.rx", "RightLeg.rx"),
    5,
    0.20,
)
RUN = Case("run 09", "09", tuple(f"09_{i:02}" for i in range(1, 9)), ("LeftUpLeg.rx", "LeftLeg.rx"), 3, 0.042)
CASES = (WALK, DANCE, RUN)


@dataclass(frozen=True, eq=False)
class Curves:
    """A capture as the file has it: Euler curves per joint, Z Y X, unrolled, at 24 frames/s."""

    name: str
    joints: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: FloatArray
    angles: FloatArray
    root: FloatArray


def read_cmu(file_path: Path, *, drop: int) -> Curves:
    """Read a CMU capture of the MotionBuilder-friendly release and bring it to 24 frames/s."""
    head, _, motion = file_path.read_text().partition("MOTION")
    names, parents, offsets = _read_hierarchy(head)
    values = np.loadtxt(motion.strip().splitlines()[2:])[drop:]
    angles = np.unwrap(values[:, 3:].reshape(len(values), -1, 3), period=360.0, axis=0)
    flat = np.concatenate([values[:, :3], angles.reshape(len(angles), -1)], axis=1)
    slow = resample_poly(flat, 1, 5, axis=0, padtype="line")
    return Curves(
        file_path.stem, names, parents, offsets, slow[:, 3:].reshape(len(slow), -1, 3), np.asarray(slow[:, :3])
    )


def _read_hierarchy(text: str) -> tuple[tuple[str, ...], tuple[int, ...], FloatArray]:
    names: list[str] = []
    parents: list[int] = []
    offsets: list[list[float]] = []
    stack: list[int] = []
    current = -1
    for line in text.splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] in ("ROOT", "JOINT"):
            parents.append(stack[-1] if stack else -1)
            names.append((names[parents[-1]] + "/" if stack else "") + words[1])
            current = len(names) - 1
        elif words[0] == "End":
            current = -1
        elif words[0] == "{":
            stack.append(current)
        elif words[0] == "}":
            stack.pop()
        elif words[0] == "OFFSET" and current >= 0:
            offsets.append([float(word) for word in words[1:]])
    return tuple(names), tuple(parents), np.array(offsets)


def to_clip(curves: Curves) -> Clip:
    """A capture as a clip; rest from the offsets."""
    rest = np.tile(np.eye(4), (len(curves.joints), 1, 1))
    rest[:, 3, :3] = curves.offsets
    ordered = curves.angles[..., ::-1]  # columns Z Y X to x y z
    translations = np.tile(curves.offsets, (len(curves.root), 1, 1))
    translations[:, 0] = curves.root
    return Clip(
        skeleton=Skeleton(joints=curves.joints, rest=rest, meters_per_unit=METERS_PER_UNIT),
        rate=RATE,
        rotations=quaternion.unroll(quaternion.from_euler(ordered, "ZYX")),
        translations=translations,
        scales=np.ones_like(translations),
        name=curves.name,
    )


def make_sketch(truth: Curves, *, every: int = 6) -> Clip:
    """What an animator would have keyed: a spline through every sixth frame of the lower body, all else at rest."""
    frames = np.arange(len(truth.root))
    keys = np.unique(np.append(frames[::every], frames[-1]))
    keyed = np.array([joint.rpartition("/")[2] in SKETCHED for joint in truth.joints])
    angles = np.zeros_like(truth.angles)
    angles[:, keyed] = CubicSpline(keys, truth.angles[keys][:, keyed])(frames)
    root = CubicSpline(keys, truth.root[keys])(frames)
    return to_clip(Curves(f"sketch_{truth.name}", truth.joints, truth.parents, truth.offsets, angles, root))


def load_case(case: Case, data_dir: Path) -> dict[str, Curves]:
    """All captures of a case by name."""
    folder = data_dir / "cmu_bvh" / case.subject
    return {name: read_cmu(folder / f"{name}.bvh", drop=3 if name == "07_12" else 1) for name in case.clips}


def leave_one_out(captures: dict[str, Curves]) -> Iterator[tuple[Clip, Clip, list[Clip]]]:
    """Truth, sketch and takes for each capture in turn."""
    clips = {name: to_clip(curves) for name, curves in captures.items()}
    for name, curves in captures.items():
        yield clips[name], make_sketch(curves), [clip for other, clip in clips.items() if other != name]
