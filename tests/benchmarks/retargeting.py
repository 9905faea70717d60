"""How well takes drive characters: ``python -m tests.benchmarks.retargeting [--data DIR]``.

Prints for every take on every character how many joints follow, how far its bones are from the take's in direction, and
how long it took. Directions are read here from the joints' places, on sections of several joints between the places at
the same share of their length at rest (:mod:`tests.oracle.retargeting`), not with the package's own code.

- aimed: the bones of trunk, neck, arms and legs, which are to lie along the take's: mean and worst, degrees;
- pelvis, feet: bones that turn as the take's since rest and keep their build: mean, degrees;
- scale: legs of the character in those of the take's; height: mean over frames of the hips' heights above the floor,
  character to take. The two have to agree.
"""

import argparse
import os
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt
from pxr import Usd

import mtex_usd
from mtex_usd.constraints.retargeting import JointMap, map_joints, retarget_mapped
from mtex_usd.constraints.retargeting.body import estimate_ground, rest_ground
from mtex_usd.constraints.retargeting.sections import Section
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.motion.timing import resample_clip
from mtex_usd.usd.clip_io import ClipReader
from tests.oracle.retargeting import read_place, stations_of

__all__ = ["CHARACTERS", "TAKES", "Score", "load_character", "load_takes", "main", "score_pair", "time_pair"]

FloatArray = npt.NDArray[np.float64]

RATE = 24.0
TAKES = (
    "cmu_asfamc/91/91_01.amc",
    "cmu_bvh/91_from_amc/91_13.bvh",
    "cmu_bvh/07/07_01.bvh",
    "cmu_bvh/05/05_02.bvh",
    "cmu_bvh/09/09_01.bvh",
)
CHARACTERS = ("usd/HIK_Export.usda", "usd/CesiumMan.usdz", "usd/RiggedFigure.usdz")


@dataclass(frozen=True, kw_only=True)
class Score:
    """One take on one character; angles in degrees.

    Parameters
    ----------
    motion
        The character's.
    joint_map
        What mapped to what.
    aimed, pelvis, feet
        Angles of bones from the take's, shape [F, N] each.
    height
        Mean over frames of the hips' heights above the floor, character to take.
    """

    motion: Clip
    joint_map: JointMap
    aimed: FloatArray
    pelvis: FloatArray
    feet: FloatArray
    height: float


@cache
def load_character(file_path: Path) -> Skeleton:
    """Read the first skeleton of a stage."""
    stage = Usd.Stage.Open(str(file_path))
    prims = [prim for prim in stage.Traverse() if prim.GetTypeName() == "Skeleton"]
    return ClipReader(stage).read_skeleton(prims[0])


@cache
def load_takes(data_dir: Path, names: tuple[str, ...]) -> tuple[Clip, ...]:
    """Import captures and read them at 24 frames a second, less the leading T-pose."""
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "takes.usd"
        mtex_usd.import_takes([data_dir / name for name in names], out=library)
        stage = Usd.Stage.Open(str(library))
        clips = [mtex_usd.read_clip(stage, f"/Takes/take_{Path(name).stem}") for name in names]
    return tuple(drop_first(resample_clip(clip, RATE)) for clip in clips)


def drop_first(clip: Clip, count: int = 1) -> Clip:
    """Leave out the first frames."""
    arrays = {name: getattr(clip, name)[count:] for name in ("rotations", "translations", "scales")}
    return replace(clip, **arrays)


def score_pair(take: Clip, character: Skeleton) -> Score:
    """Drive a character by a take and measure what came of it."""
    joint_map = map_joints(take.skeleton, character)
    motion = retarget_mapped(take, joint_map)
    groups: dict[str, list[FloatArray]] = {"aimed": [], "pelvis": [], "feet": []}
    places = [clip.skeleton.world_pose(clip.rotations, clip.translations)[0] for clip in (take, motion)]
    for section in joint_map.sections:
        for at, angles in _measure_section(section, joint_map, *places):
            group = "feet" if "foot" in section.name else "pelvis"
            groups["aimed" if section.is_aimed(at) else group].append(angles)
    measured = {name: np.stack(angles or [np.zeros(len(places[0]))], axis=1) for name, angles in groups.items()}
    height = _hips_height(motion, joint_map, 1) / _hips_height(take, joint_map, 0)
    return Score(motion=motion, joint_map=joint_map, height=height, **measured)


def time_pair(take: Clip, joint_map: JointMap, *, frames: int = 1000, runs: int = 3) -> float:
    """Give the milliseconds that so many frames of a take need, the best of a few runs; the take is repeated."""
    kept = np.arange(frames) % take.frame_count
    arrays = {name: getattr(take, name)[kept] for name in ("rotations", "translations", "scales")}
    long = replace(take, **arrays)
    seconds = []
    for _ in range(runs):
        start = time.perf_counter()
        retarget_mapped(long, joint_map)
        seconds.append(time.perf_counter() - start)
    return 1e3 * min(seconds)


def _measure_section(
    section: Section, joint_map: JointMap, places: FloatArray, own_places: FloatArray
) -> list[tuple[int, FloatArray]]:
    """Angles in degrees [F] of a section's bones from the take's, by place in the section."""
    if section.source.end is None or section.target.end is None:
        return []
    stance, own, other = joint_map.stance, list(section.target.all_joints), list(section.source.all_joints)
    lengths = [stations_of(list(s.rest_positions[j])) for s, j in ((stance.target, own), (stance.source, other))]
    read = [read_place(lengths[1], [places[:, joint] for joint in other], station) for station in lengths[0]]
    found = []
    for at in range(len(own) - 1):
        wanted = quaternion.rotate(stance.turn, read[at + 1] - read[at])
        angles = _angles(own_places[:, own[at + 1]] - own_places[:, own[at]], wanted)
        if angles is not None:
            found.append((at, angles))
    return found


def _angles(a: FloatArray, b: FloatArray) -> FloatArray | None:
    """Degrees between vectors [F, 3]; None for bones without length."""
    lengths = [np.linalg.norm(vectors, axis=-1) for vectors in (a, b)]
    if min(length.min() for length in lengths) < 1e-9:
        return None
    sine = np.linalg.norm(np.cross(a, b), axis=-1)
    return np.degrees(np.arctan2(sine, np.sum(a * b, axis=-1)))


def _hips_height(clip: Clip, joint_map: JointMap, which: int) -> float:
    anatomy, body = joint_map.anatomies[which], joint_map.stance.bodies[which]
    ground = rest_ground(clip.skeleton, anatomy, body) if which else estimate_ground(clip, anatomy, body)
    places = clip.skeleton.joint_positions([anatomy.parts["hips"]], clip.rotations, clip.translations)
    return float((places[:, 0] @ clip.skeleton.up - ground).mean())


def _print_score(take: str, character: str, score: Score, milliseconds: float) -> None:
    found, wanted = score.joint_map.anatomies
    print(
        f"{Path(take).stem:8} {Path(character).stem:14} {found.convention + ' to ' + wanted.convention:30}"
        f" {len(score.joint_map.mapped):3} of {len(score.motion.joints):3}"
        f" {score.aimed.mean():9.1e} {score.aimed.max():9.1e} {score.pelvis.mean():7.1f} {score.feet.mean():6.1f}"
        f" {score.joint_map.scale:8.4g} {score.height:8.4g} {milliseconds:8.0f}"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Measure how well real takes drive real characters.")
    default = Path(os.environ.get("MTEX_TEST_DATA", "../shared/data"))
    parser.add_argument("--data", type=Path, default=default, help="folder of the captures (default: MTEX_TEST_DATA)")
    data_dir = parser.parse_args(arguments).data.resolve()
    if not data_dir.is_dir():
        parser.error(f"no data in {data_dir}; set MTEX_TEST_DATA or give --data")
    print(f"{'take':8} {'character':14} {'convention':30} {'joints':>9} {'aimed':>9} {'worst':>9}", end=" ")
    print(f"{'pelvis':>7} {'feet':>6} {'scale':>8} {'height':>8} {'ms/1000':>8}")
    for name, take in zip(TAKES, load_takes(data_dir, TAKES), strict=True):
        for character in CHARACTERS:
            score = score_pair(take, load_character(data_dir / character))
            _print_score(name, character, score, time_pair(take, score.joint_map))
    return 0


if __name__ == "__main__":
    sys.exit(main())
