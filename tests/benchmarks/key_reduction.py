"""How few keys motion comes down to, and how fast, beside Blender's Decimate and beside what is possible at all.

``python -m tests.benchmarks.key_reduction [--data DIR] [--runs N]`` prints for the captured walk 07_01 without its
T-pose, and for a clip as large as that of the issue, 743 frames of two figures of 31 joints from 91_01,

- curves: keys and processor time of ``reduce_keys`` beside Blender's Decimate at error 0.01. Blender reduces the four
  components of each moving joint's quaternion, as its own importers make them. What it is then off by, as we measure
  that, is the tolerance for ours, in degrees and in metres. Blender runs where ``MTEX_BLENDER_PYTHON`` names a Python
  that has bpy; the time is that of the operator alone, ours is all that ``reduce_keys`` does;
- poses: how many ``reduce_poses`` needs at 0.5 degrees and 5 mm for some groups of joints, in parts of the frames, and
  how many any method needs for the rotations alone (``tests/benchmarks/pose_bound.py``).
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mtex_usd.edit import ReducedKeys, reduce_keys, reduce_poses
from mtex_usd.edit.curve_space import select_channels
from mtex_usd.edit.keys.difference import measure_difference
from mtex_usd.edit.keys.sampled import play_between
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.motion.timing import resample_clip
from tests.benchmarks.pose_bound import count_needed_poses
from tests.captures import load_capture

__all__ = [
    "GROUPS",
    "LEAST_FACTOR",
    "Reduction",
    "compare_curves",
    "compare_poses",
    "main",
    "pair_up",
    "run_blender",
    "time_ours",
]

LEAST_FACTOR = 20.0
ERROR = 0.01
DEGREES = 0.5

GROUPS = {
    "legs": ("*UpLeg", "*Leg", "*Foot"),
    "legs and spine": ("Hips", "*UpLeg", "*Leg", "*Foot", "LowerBack", "Spine*"),
    "all that is captured": ("Hips", "*Leg", "*Foot", "*Back", "Spine*", "Neck*", "Head", "*Shoulder", "*Arm", "*Hand"),
    "all joints": (),
}

_PER_FRAME = 1  # what Blender looks at; between frames its curves are farther off
_FRAMES = 743
_SECOND_FIGURE = 800  # frames after the first
_BLENDER = Path(__file__).with_name("blender_decimate.py")


@dataclass(frozen=True, kw_only=True)
class Reduction:
    """What a reduction left, and took: largest errors, of rotations and of places, and processor time."""

    keys: int
    degrees: float
    metres: float
    seconds: float


def pair_up(clip: Clip, *, frames: int, later: int) -> Clip:
    """Make two figures of one, the second so many frames ahead."""

    def pair(rows: np.ndarray) -> np.ndarray:
        return np.concatenate([rows[:frames], rows[later : later + frames]], axis=1)

    names = clip.joints + tuple("/".join(f"second_{part}" for part in joint.split("/")) for joint in clip.joints)
    rest = np.concatenate([clip.rest, clip.rest])
    return replace(
        clip,
        skeleton=Skeleton(joints=names, rest=rest, meters_per_unit=clip.skeleton.meters_per_unit),
        rotations=pair(clip.rotations),
        translations=pair(clip.translations),
        scales=pair(clip.scales),
    )


def run_blender(interpreter: str, clip: Clip, *, error: float) -> Reduction:
    """Reduce the rotations of the joints that move with Blender's Decimate."""
    moving = np.flatnonzero(np.ptp(clip.rotations, axis=0).max(axis=-1) > 0.0)
    with tempfile.TemporaryDirectory() as folder:
        given, found = Path(folder, "in.npz"), Path(folder, "out.npz")
        np.savez(given, rotations=quaternion.unroll(clip.rotations)[:, moving], per_frame=_PER_FRAME)
        environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
        command = [interpreter, str(_BLENDER), str(given), str(found), str(error)]
        subprocess.run(command, check=True, capture_output=True, env=environment)
        out = np.load(found)
        played, keys, seconds = out["played"], int(out["keys"]), float(out["seconds"])
    fine = play_between(clip, _PER_FRAME)
    rotations = np.array(fine.rotations)
    rotations[:, moving] = quaternion.normalize(played)
    degrees, metres = measure_difference(replace(fine, rotations=rotations), fine)
    return Reduction(keys=keys, degrees=float(degrees.max()), metres=float(metres.max()), seconds=seconds)


def time_ours(clip: Clip, *, degrees: float, metres: float, runs: int) -> Reduction:
    """Reduce the rotations of all joints to curves; the keys of curves that do not move count, too."""
    reduced, seconds = _time(
        lambda: reduce_keys(clip, tolerance_deg=degrees, tolerance_m=metres, channels=["*.r"]), runs
    )
    return Reduction(keys=reduced.key_count, degrees=reduced.max_degrees, metres=reduced.max_metres, seconds=seconds)


def _time(reduce: Callable[[], ReducedKeys], runs: int) -> tuple[ReducedKeys, float]:
    seconds = []
    for _ in range(runs):
        start = time.process_time()
        result = reduce()
        seconds.append(time.process_time() - start)
    return result, statistics.median(seconds)


def compare_curves(clip: Clip, interpreter: str, *, runs: int) -> bool:
    """Print Blender's reduction and ours of a clip; tell whether ours is better, and so many times as fast."""
    theirs = run_blender(interpreter, clip, error=ERROR)
    ours = time_ours(clip, degrees=theirs.degrees, metres=theirs.metres, runs=runs)
    factor = theirs.seconds / ours.seconds
    for name, found in (("Blender", theirs), ("reduce_keys", ours)):
        error = f"{found.degrees:.2f} degrees and {1e3 * found.metres:.1f} mm"
        print(f"  {name:12s} {found.keys:6d} keys, off by {error} at most, {found.seconds:.2f} s")
    good = factor >= LEAST_FACTOR and ours.keys < theirs.keys
    print(f"  {factor:.1f} times faster (least {LEAST_FACTOR:g}), {ours.keys / theirs.keys:.0%} of the keys:", end=" ")
    print("ok" if good else "BELOW")
    return good


def compare_poses(clip: Clip, groups: Mapping[str, Sequence[str]]) -> None:
    """Print how many poses groups of joints, by channel tokens, need: ours and at the least."""
    for group, tokens in groups.items():
        start = time.process_time()
        reduced = reduce_poses(clip, channels=tokens)
        seconds = time.process_time() - start
        joints = sorted({channel.joint for channel in select_channels(clip, tokens)})
        needed = count_needed_poses(clip.rotations[:, joints], DEGREES)
        shares = [count / clip.frame_count for count in (reduced.key_count, needed)]
        print(f"  {group:20s} {shares[0]:4.0%} of {clip.frame_count} frames in {seconds:.2f} s,", end=" ")
        print(f"any method at least {shares[1]:4.1%}")


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print; the exit code is 1 where the curves are not better and so many times as fast."""
    parser = argparse.ArgumentParser(description="Measure key reduction.")
    parser.add_argument("--data", type=Path, default=os.environ.get("MTEX_TEST_DATA", "../shared/data"))
    parser.add_argument("--runs", type=int, default=7, help="runs of ours that count (default: 7)")
    options = parser.parse_args(arguments)
    walk = load_capture(Path(options.data), "07_01")
    two = pair_up(load_capture(Path(options.data), "91_01"), frames=_FRAMES, later=_SECOND_FIGURE)
    interpreter, results = os.environ.get("MTEX_BLENDER_PYTHON", ""), []
    for name, clip in (("07_01", walk), ("two figures of 91_01", two)):
        print(f"{name}, {clip.frame_count} frames, {len(clip.joints)} joints, beside Blender's Decimate at {ERROR}:")
        if interpreter:
            results.append(compare_curves(clip, interpreter, runs=options.runs))
        else:
            print("  not measured: MTEX_BLENDER_PYTHON is not set; it names a Python that has bpy")
    for rate in (walk.rate, 30.0, 24.0):
        print(f"07_01 at {rate:g} frames/s, poses at {DEGREES} degrees and 5 mm:")
        compare_poses(resample_clip(walk, rate), GROUPS)
    return int(not all(results))


if __name__ == "__main__":
    sys.exit(main())
