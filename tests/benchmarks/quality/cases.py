"""The benchmark's cases: real captures, sketches made from them, and takes.

Protocol: drop CMU's added first frame (07_12: the first three), resample the unrolled Euler curves and the root from
120 to 24 frames/s with ``scipy.signal.resample_poly(x, 1, 5, padtype="line")``. The sketch is a cubic spline through
every sixth frame and the last of root, hips, thighs, shins and feet; all else is identity. The takes are the other
clips of the case, unless it names its own.
"""

from collections.abc import Iterable
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


@dataclass(frozen=True)
class Rig:
    """Which joints play which part; last names.

    Parameters
    ----------
    sketched
        What the animator keyed.
    synthesized
        What is filled in.
    measured
        Where the error is taken.
    legs
        Joints of the legs, those that are textured where a test textures.
    """

    sketched: tuple[str, ...]
    synthesized: tuple[str, ...]
    measured: tuple[str, ...]
    legs: tuple[str, ...]


_LEGS = ("LeftUpLeg", "LeftLeg", "LeftFoot", "RightUpLeg", "RightLeg", "RightFoot")
_AMC_LEGS = ("lfemur", "ltibia", "lfoot", "rfemur", "rtibia", "rfoot")

RELEASE = Rig(
    sketched=("Hips", *_LEGS),
    synthesized=(
        *("LowerBack", "Spine", "Spine1", "Neck", "Neck1", "Head"),
        *("LeftShoulder", "LeftArm", "LeftForeArm", "RightShoulder", "RightArm", "RightForeArm"),
    ),
    measured=("Head", "LeftForeArm", "LeftHand", "RightForeArm", "RightHand"),
    legs=_LEGS,
)
# The same parts under the names of the original ASF files.
ORIGINAL = Rig(
    sketched=("root", *_AMC_LEGS),
    synthesized=(
        *("lowerback", "upperback", "thorax", "lowerneck", "upperneck", "head"),
        *("lclavicle", "lhumerus", "lradius", "rclavicle", "rhumerus", "rradius"),
    ),
    measured=("head", "lradius", "lwrist", "rradius", "rwrist"),
    legs=_AMC_LEGS,
)


@dataclass(frozen=True)
class Case:
    """One row of the table.

    Parameters
    ----------
    name
        What tables call it.
    folder
        Below ``cmu_bvh``.
    clips
        Captures to be sketched and found again, each in turn.
    match, band
        Match channels and band of the recipe.
    limit
        The error the default has to stay at or below, metres; infinite where none was asked for.
    takes
        Captures to copy from; empty means the other clips of the case.
    takes_folder
        Below ``cmu_bvh``, where it is not that of the clips.
    rig
        Names of the joints.
    """

    name: str
    folder: str
    clips: tuple[str, ...]
    match: tuple[str, ...]
    band: int
    limit: float = float("inf")
    takes: tuple[str, ...] = ()
    takes_folder: str = ""
    rig: Rig = RELEASE


def _names(subject: str, *numbers: int) -> tuple[str, ...]:
    return tuple(f"{subject}_{number:02}" for number in numbers)


_LEFT = ("LeftUpLeg.rx", "LeftLeg.rx")
_BOTH = ("LeftUpLeg.rx", "RightUpLeg.rx", "LeftLeg.rx", "RightLeg.rx")
_WALKS, _DANCES, _RUNS = _names("07", *range(1, 10)), _names("05", 2, 3, 4, 7, 9, 12), _names("09", *range(1, 9))

WALK = Case("walk 07", "07", _WALKS, _LEFT, 4, 0.040)
DANCE = Case("dance 05", "05", _DANCES, _BOTH, 5, 0.20)
RUN = Case("run 09", "09", _RUNS, _LEFT, 3, 0.042)
CASES = (WALK, DANCE, RUN)

# Nothing was chosen by these.
HELD_OUT = (
    Case("walk 07_10..12 from 07_01..09", "07", _names("07", 10, 11, 12), _LEFT, 4, takes=_WALKS),
    Case(
        "walk 91_01 02 13 (figure eight, straight, sad), leave one out",
        "91_from_amc",
        _names("91", 1, 2, 13),
        ("lfemur.rx", "ltibia.rx"),
        4,
        rig=ORIGINAL,
    ),
    Case("dance 05_11 from the dances", "05", _names("05", 11), _BOTH, 5, takes=_DANCES),
    Case("walk 05_01 from another performer's 07", "05", _names("05", 1), _LEFT, 4, takes=_WALKS, takes_folder="07"),
    Case("09_12, 16 s of walking about, from runs only", "09", _names("09", 12), _LEFT, 4, takes=_RUNS),
    Case("09_12, 16 s of walking about, from 07", "09", _names("09", 12), _LEFT, 4, takes=_WALKS, takes_folder="07"),
)


@dataclass(frozen=True, eq=False)
class Fold:
    """One capture to be found again from its sketch and some takes."""

    case: Case
    truth: Clip
    sketch: Clip
    takes: tuple[Clip, ...]


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


def make_sketch(truth: Curves, rig: Rig = RELEASE, *, every: int = 6) -> Clip:
    """What an animator would have keyed: a spline through every sixth frame of the lower body, all else at rest."""
    frames = np.arange(len(truth.root))
    keys = np.unique(np.append(frames[::every], frames[-1]))
    keyed = np.array([joint.rpartition("/")[2] in rig.sketched for joint in truth.joints])
    angles = np.zeros_like(truth.angles)
    angles[:, keyed] = CubicSpline(keys, truth.angles[keys][:, keyed])(frames)
    root = CubicSpline(keys, truth.root[keys])(frames)
    return to_clip(Curves(f"sketch_{truth.name}", truth.joints, truth.parents, truth.offsets, angles, root))


def load_captures(folder: Path, names: Iterable[str]) -> dict[str, Curves]:
    """Captures by name, their calibration poses dropped."""
    return {name: read_cmu(folder / f"{name}.bvh", drop=_frames_to_drop(name)) for name in names}


def _frames_to_drop(name: str) -> int:
    """The release added a T-pose; 07_12 begins with two more frames of it; what was converted from AMC has none."""
    if name.startswith("91"):
        return 0
    return 3 if name == "07_12" else 1


def load_folds(case: Case, data_dir: Path) -> list[Fold]:
    """A fold for each clip of a case."""
    captures = load_captures(data_dir / "cmu_bvh" / case.folder, case.clips)
    clips = {name: to_clip(curves) for name, curves in captures.items()}
    given = load_captures(data_dir / "cmu_bvh" / (case.takes_folder or case.folder), case.takes)
    takes = tuple(to_clip(curves) for curves in given.values())
    return [
        Fold(
            case,
            clips[name],
            make_sketch(curves, case.rig),
            takes or tuple(clip for other, clip in clips.items() if other != name),
        )
        for name, curves in captures.items()
    ]
