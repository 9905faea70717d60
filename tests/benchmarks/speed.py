"""How fast the tool is, as ratios within one run, so that the machine does not matter.

``python -m tests.benchmarks.speed`` prints, for takes recorded at 24 and at 120 frames a second,

- `process` on a 440-frame, 31-joint sketch with 12 takes and 5 variants, everything imported, against a bare function
  that opens the stage, reads the same arrays with ``Attribute.Get`` and writes as many samples with ``SetTimeSample``;
- ``usdmtex --help`` against importing ``pxr.Usd`` and ``numpy``.

Runs of the two alternate, so that both meet the same load; what counts is the ratio of their medians.
"""

import argparse
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from pxr import Sdf, Usd

import mtex_usd
from tests.benchmarks.speed_shot import write_shot

__all__ = ["HELP_LIMIT", "PROCESS_LIMIT", "Comparison", "compare", "compare_help", "compare_process", "main"]

PATHS = 5
PROCESS_LIMIT = 3.0
HELP_LIMIT = 1.5

_ARRAYS = ("rotations", "translations", "scales")
_PROJECT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Medians, in seconds, of what is measured and of what it is measured by."""

    measured: float
    yardstick: float

    @property
    def ratio(self) -> float:
        """How many times the yardstick the measured took."""
        return self.measured / self.yardstick


def compare(measured: Callable[[], object], yardstick: Callable[[], object], *, runs: int) -> Comparison:
    """Time two functions in turns, after one run of each that does not count."""
    times: dict[Callable[[], object], list[float]] = {measured: [], yardstick: []}
    for run in range(runs + 1):
        for function, seconds in times.items():
            start = time.perf_counter()
            function()
            if run:
                seconds.append(time.perf_counter() - start)
    return Comparison(
        measured=statistics.median(times[measured]),
        yardstick=statistics.median(times[yardstick]),
    )


def compare_process(folder: Path, *, take_rate: float, runs: int) -> Comparison:
    """Time `process` against reading the same arrays and writing as many samples."""
    shot = write_shot(folder, take_rate=take_rate)
    out = folder / "shot.mtex.usd"

    def measured() -> None:
        mtex_usd.process(shot, out=out, paths=PATHS)

    measured()
    sample_counts = count_samples(out)
    return compare(measured, lambda: copy_bare(shot, folder / "bare.usd", sample_counts), runs=runs)


def count_samples(file_path: Path) -> dict[str, int]:
    """Count the samples of every attribute of a layer, by name."""
    layer = Sdf.Layer.OpenAsAnonymous(str(file_path))
    counts: dict[str, int] = {}

    def visit(spec_path: Sdf.Path) -> None:
        if spec_path.IsPropertyPath():
            counts[spec_path.name] = counts.get(spec_path.name, 0) + layer.GetNumTimeSamplesForPath(spec_path)

    layer.Traverse(Sdf.Path.absoluteRootPath, visit)
    return {name: count for name, count in counts.items() if count}


def copy_bare(shot: Path, out: Path, sample_counts: dict[str, int]) -> None:
    """Read every array of every animation, and write as many samples as `process` did, without any work between."""
    stage = Usd.Stage.Open(str(shot))
    values: dict[str, list[object]] = {name: [] for name in _ARRAYS}
    for prim in stage.Traverse():
        if prim.IsA("SkelAnimation"):
            for name in _ARRAYS:
                attribute = prim.GetAttribute(name)
                values[name] += [attribute.Get(time_code) for time_code in attribute.GetTimeSamples()]
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    types = {name: prim.GetAttribute(name).GetTypeName() for name in _ARRAYS}
    with Sdf.ChangeBlock():
        for name, count in sample_counts.items():
            _write_bare(layer, name, types[name], values[name][:count])
    layer.Export(str(out))


def _write_bare(layer: Sdf.Layer, name: str, type_name: Sdf.ValueTypeName, values: Sequence[object]) -> None:
    """Write values to one animation per variant."""
    frames = len(values) // PATHS
    for path in range(PATHS):
        prim = Sdf.CreatePrimInLayer(layer, f"/path_{path}")
        attribute_path = Sdf.AttributeSpec(prim, name, type_name).path
        for frame, value in enumerate(values[path * frames : (path + 1) * frames]):
            layer.SetTimeSample(attribute_path, float(frame), value)


def compare_help(*, runs: int) -> Comparison:
    """Time ``usdmtex --help`` against importing USD and numpy, each in a fresh process."""

    def run(code: str, *arguments: str) -> Callable[[], object]:
        command = [sys.executable, "-c", code, *arguments]
        return lambda: subprocess.run(command, cwd=_PROJECT, check=True, stdout=subprocess.DEVNULL)

    help_code = "from mtex_usd.cli.usdmtex import main; main()"
    return compare(run(help_code, "--help"), run("import numpy; from pxr import Usd"), runs=runs)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print and judge; the exit code is 1 where a ratio is above its limit."""
    parser = argparse.ArgumentParser(description="Measure the tool's speed as ratios.")
    parser.add_argument("--runs", type=int, default=9, help="runs of each that count (default: 9)")
    runs = parser.parse_args(arguments).runs
    results = [("usdmtex --help / import pxr.Usd and numpy", compare_help(runs=runs), HELP_LIMIT)]
    for take_rate in (24.0, 120.0):
        with tempfile.TemporaryDirectory() as folder:
            found = compare_process(Path(folder), take_rate=take_rate, runs=runs)
        results.append((f"process / bare copy, takes at {take_rate:g} a second", found, PROCESS_LIMIT))
    for what, found, limit in results:
        verdict = "ok" if found.ratio <= limit else "ABOVE"
        times = f"{found.measured:.3f} s / {found.yardstick:.3f} s"
        print(f"{what}: {times} = {found.ratio:.2f} (limit {limit:g}) {verdict}")
    return int(any(found.ratio > limit for _, found, limit in results))


if __name__ == "__main__":
    sys.exit(main())
