"""How the default path weight was chosen, and how much that says.

Two tables: the error on the cases as they are, and the mean error when each take in turn is missing. The first is what
the limits are about; the second asks the same of several times as many, though not independent, trials.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from tests.benchmarks.quality.cases import Fold
from tests.benchmarks.quality.metrics import position_error
from tests.benchmarks.quality.settings import SETTINGS, run_method

__all__ = ["drop_each_take", "mean_error", "sweep_report", "write_table"]

PATH_WEIGHTS = (0.3, 1.0, 2.0, 3.0, 3.2, 3.3, 3.4, 3.5, 3.6, 3.7, 3.8, 3.9, 4.0, 5.0, 7.0, 10.0)
COARSE_WEIGHTS = (0.1, 0.3, 1.0, 2.0, 3.4, 5.0, 10.0, 20.0)


def write_table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Lines of a markdown table, all columns but the first to the right."""
    lines = [headings, ["---", *["---:"] * (len(headings) - 1)], *rows]
    return [f"| {' | '.join(line)} |" for line in lines]


def drop_each_take(folds: Sequence[Fold]) -> list[Fold]:
    """Every fold once for each of its takes, that take left out."""
    return [
        replace(fold, takes=fold.takes[:number] + fold.takes[number + 1 :])
        for fold in folds
        for number in range(len(fold.takes))
    ]


def mean_error(folds: Sequence[Fold], **settings: Any) -> float:
    """Mean error of the first variant, metres."""
    clips = [run_method(fold, paths=1, **settings).variants[0].clip for fold in folds]
    return float(np.mean([position_error(fold, clip) for fold, clip in zip(folds, clips, strict=True)]))


def sweep_report(cases: Sequence[Sequence[Fold]]) -> str:
    """Both tables, for the folds of each case."""
    limits = [folds[0].case.limit for folds in cases]
    names = [folds[0].case.name for folds in cases]
    headings = [f"{name} (≤ {limit:g})" for name, limit in zip(names, limits, strict=True)]
    rows = [_weight_row(cases, names, limits, weight) for weight in PATH_WEIGHTS]
    lines = ["### Error by pathWeight, m\n", *write_table(["pathWeight", *headings, "limits that hold"], rows)]
    fewer = [drop_each_take(folds) for folds in cases]
    counted = [f"{name} ({len(folds)} trials)" for name, folds in zip(names, fewer, strict=True)]
    settings: dict[str, dict[str, Any]] = {name: dict(values) for name, values in SETTINGS.items()}
    settings |= {f"pathWeight {weight:g}": {"path_weight": weight} for weight in COARSE_WEIGHTS}
    rows = [[name, *(f"{mean_error(f, **values):.4f}" for f in fewer)] for name, values in settings.items()]
    lines += ["\n### Mean error with each take left out in turn, m\n", *write_table(["settings", *counted], rows)]
    return "\n".join([*lines, ""])


def _weight_row(
    cases: Sequence[Sequence[Fold]], names: Sequence[str], limits: Sequence[float], weight: float
) -> list[str]:
    errors = [mean_error(folds, path_weight=weight) for folds in cases]
    kept = [name for name, error, limit in zip(names, errors, limits, strict=True) if error <= limit]
    return [f"{weight:g}", *(f"{error:.4f}" for error in errors), "all" if len(kept) == len(cases) else ", ".join(kept)]
