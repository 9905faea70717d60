"""Print the quality tables.

    python -m tests.benchmarks.quality.run [--data DIR] [--pictures DIR] [--quick] [--held-out] [--sweep] [--usd]

One markdown table per case: the method in four settings, the baselines, and the truth itself for comparison. With
--usd the default is also run through real stages and played back. README.md in the folder above says what the columns
are and what to make of them.
"""

import argparse
import os
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path

import numpy as np

from mtex_usd.motion.clip import Clip
from tests.benchmarks.quality.baselines import BASELINES
from tests.benchmarks.quality.cases import CASES, HELD_OUT, Case, Fold, load_folds
from tests.benchmarks.quality.metrics import (
    Scores,
    combine_scores,
    remove_top_band,
    score_variants,
    variant_distance,
)
from tests.benchmarks.quality.settings import SETTINGS, run_method
from tests.benchmarks.quality.sweep import sweep_report, write_table

__all__ = ["case_table", "main"]

Method = Callable[[Fold], Sequence[Clip]]

# How far what UsdSkel plays may be from the arrays, metres: single precision, summed over a chain of joints.
USD_TOLERANCE = 1e-4

_HEADINGS = ("error m", "angle °", "NPSS", "jerk", "detail", "spread m", "turn °")
_DIGITS = (4, 2, 3, 2, 2, 3, 1)


def _methods() -> dict[str, Method]:
    """Every row of a table: its name and what gives its variants."""
    rows: dict[str, Method] = {
        "truth": lambda fold: [fold.truth],
        "truth without band 1": lambda fold: [remove_top_band(fold)],
    }
    rows |= {name: _baseline(make) for name, make in BASELINES.items()}
    rows |= {name: _setting(values) for name, values in SETTINGS.items()}
    return rows


def _baseline(make: Callable[[Fold], Clip]) -> Method:
    return lambda fold: [make(fold)]


def _setting(values: Mapping[str, object]) -> Method:
    return lambda fold: [variant.clip for variant in run_method(fold, **values).variants]


def case_table(case: Case, folds: Sequence[Fold]) -> str:
    """One case as a markdown table."""
    rows = {name: combine_scores([score_variants(f, method(f)) for f in folds]) for name, method in _methods().items()}
    limit = f", limit {case.limit:.3f} m" if np.isfinite(case.limit) else ""
    title = f"### {case.name}\n\nmatch {', '.join(case.match)}; band {case.band}; {len(folds)} clips{limit}\n"
    return "\n".join(
        [title, *write_table(("method", *_HEADINGS), ((name, *_cells(s)) for name, s in rows.items())), ""]
    )


def _cells(scores: Scores) -> list[str]:
    values = [getattr(scores, field.name) for field in fields(scores)]
    return ["" if np.isnan(v) else f"{v:.{digits}f}" for v, digits in zip(values, _DIGITS, strict=True)]


def _check_usd(case: Case, folds: Sequence[Fold]) -> str:
    """Run the default through stages; say how far what is played is from the arrays."""
    from tests.benchmarks.quality.usd_check import process_fold

    apart = []
    for fold in folds:
        with tempfile.TemporaryDirectory() as folder:
            _, played = process_fold(fold, Path(folder))
        apart.append(variant_distance(fold, [played, run_method(fold).variants[0].clip]))
    verdict = "equal" if max(apart) <= USD_TOLERANCE else "DIFFERENT"
    return f"Through USD: {case.name}: {verdict}, at most {max(apart):.1e} m apart on average over a clip\n"


def _find_data(given: Path | None) -> Path:
    default = Path(__file__).resolve().parents[4] / "shared" / "data"
    folder = given or Path(os.environ.get("MTEX_TEST_DATA", default))
    if not (folder / "cmu_bvh").is_dir():
        sys.exit(f"no captures in {folder}: name the folder that holds cmu_bvh with --data or MTEX_TEST_DATA")
    return folder


def _parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.quality.run", description="Quality tables.")
    parser.add_argument("--data", type=Path, help="folder with cmu_bvh")
    parser.add_argument("--pictures", type=Path, help="also draw stick figures and curves into this folder")
    parser.add_argument("--quick", action="store_true", help="two clips of each case")
    parser.add_argument("--held-out", action="store_true", help="also the cases nothing was chosen by")
    parser.add_argument("--sweep", action="store_true", help="also a sweep of the path weight")
    parser.add_argument("--usd", action="store_true", help="also through real stages")
    return parser.parse_args(arguments)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the tables; give 1 where what USD plays is not what was computed, else 0."""
    options = _parse(arguments)
    data = _find_data(options.data)
    cases = (*CASES, *HELD_OUT) if options.held_out else CASES
    folds = {case.name: load_folds(case, data)[: 2 if options.quick else None] for case in cases}
    report = [case_table(case, folds[case.name]) for case in cases]
    if options.usd:
        report += [_check_usd(case, folds[case.name]) for case in CASES]
    if options.sweep:
        report.append(sweep_report([folds[case.name] for case in CASES]))
    print("\n".join(report))
    if options.pictures:
        from tests.benchmarks.quality.pictures import draw_case

        for case in cases:
            print(*draw_case(folds[case.name], options.pictures), sep="\n")
    return 1 if any("DIFFERENT" in part for part in report) else 0


if __name__ == "__main__":
    sys.exit(main())
