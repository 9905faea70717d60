"""How fast files are imported, as a ratio within one run, so that the machine does not matter.

``python -m tests.benchmarks.import_speed`` writes 100 BVH files of 1,000 frames (31 joints, 96 channels) and prints how
long ``import_takes`` takes from them to a take library on the disk, against ``numpy.array(text.split(), float)`` on the
text of each. The parts are measured too: the reader alone, and reading and filling the library without writing it.

Runs of all alternate, so that they meet the same load; what counts is the ratio of their medians.
"""

import argparse
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

import mtex_usd
from mtex_usd.formats.bvh import read_bvh
from mtex_usd.usd.take_library import TakeLibrary
from tests.benchmarks.speed import Comparison, compare
from tests.benchmarks.speed_shot import JOINTS

__all__ = ["FILES", "FRAMES", "IMPORT_LIMIT", "compare_import", "main", "parse_bare", "write_files"]

FILES = 100
FRAMES = 1000
IMPORT_LIMIT = 3.0

_SEED = 2002


def write_files(folder: Path, *, count: int, frames: int) -> list[Path]:
    """Write BVH files as MotionBuilder does: positions and rotations at the root, rotations ZYX elsewhere, 4 decimals.

    Parameters
    ----------
    folder
        Where to.
    count, frames
        How many files, and how many frames each has.
    """
    hierarchy = _describe_hierarchy()
    noise = np.random.default_rng(_SEED)
    file_paths = []
    for i in range(count):
        steps = noise.normal(scale=0.5, size=(frames, 3 * len(JOINTS) + 3))
        rows = [" ".join(f"{value:.4f}" for value in row) for row in np.cumsum(steps, axis=0).tolist()]
        motion = ["MOTION", f"Frames: {frames}", "Frame Time: .0083333", *rows, ""]
        file_paths.append(folder / f"walk_{i:03d}.bvh")
        file_paths[-1].write_text("\n".join([*hierarchy, *motion]))
    return file_paths


def _describe_hierarchy() -> list[str]:
    lines, open_joints = ["HIERARCHY"], list[str]()
    for joint in JOINTS:
        while open_joints and not joint.startswith(f"{open_joints[-1]}/"):
            lines.append("}")
            open_joints.pop()
        positions = "" if open_joints else "Xposition Yposition Zposition "
        lines += [f"{'JOINT' if open_joints else 'ROOT'} {joint.rpartition('/')[2]}", "{", "OFFSET 1.5 -2.25 0.125"]
        lines.append(f"CHANNELS {3 + len(positions.split())} {positions}Zrotation Yrotation Xrotation")
        open_joints.append(joint)
    return lines + ["}"] * len(open_joints)


def parse_bare(file_paths: Sequence[Path]) -> None:
    """Turn the motion of every file into numbers, and do nothing else."""
    for file_path in file_paths:
        text = file_path.read_text()
        motion = text[text.index("\n", text.index("Frame Time:")) :]
        np.array(motion.split(), float)


def _read(file_paths: Sequence[Path]) -> None:
    for file_path in file_paths:
        read_bvh(file_path)


def _fill(file_paths: Sequence[Path]) -> None:
    library = TakeLibrary(meters_per_unit=0.01)
    for file_path in file_paths:
        library.add(read_bvh(file_path))


def compare_import(folder: Path, *, count: int, frames: int, runs: int) -> dict[str, Comparison]:
    """Time the import and its parts against turning the same text into numbers."""
    file_paths = write_files(folder, count=count, frames=frames)
    out = folder / "takes.usd"

    def import_files() -> None:
        mtex_usd.import_takes(file_paths, out=out, replace_library=True)

    parts: dict[str, Callable[[], object]] = {
        "reading the files": lambda: _read(file_paths),
        "reading, filling a library": lambda: _fill(file_paths),
        "import_takes to a written library": import_files,
    }
    return {what: compare(part, lambda: parse_bare(file_paths), runs=runs) for what, part in parts.items()}


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print and judge; the exit code is 1 where the ratio of the import is above its limit."""
    parser = argparse.ArgumentParser(description="Measure the speed of importing BVH files as a ratio.")
    parser.add_argument("--runs", type=int, default=5, help="runs of each that count (default: 5)")
    parser.add_argument("--files", type=int, default=FILES, help=f"how many files (default: {FILES})")
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        results = compare_import(Path(folder), count=options.files, frames=FRAMES, runs=options.runs)
    for what, found in results.items():
        print(f"{what} / numpy.array(text.split(), float): {found.measured:.3f} s / {found.yardstick:.3f} s", end="")
        print(f" = {found.ratio:.2f}")
    ratio = results["import_takes to a written library"].ratio
    print(f"limit {IMPORT_LIMIT:g}: {'ok' if ratio <= IMPORT_LIMIT else 'ABOVE'}")
    return int(ratio > IMPORT_LIMIT)


if __name__ == "__main__":
    sys.exit(main())
