"""How near suggestions come to an exhaustive search, and how much sooner.

    python -m tests.benchmarks.suggestion [--data DIR] [--case 07] [--case 05]

The search tries every ordered pair of the channels that `mtex_usd.texture.suggestion` chooses from (those of hips and
legs that swing at least a quarter as much as the liveliest, at most 16) on every band between 0.15 and 2.4 Hz, each by
making and measuring whole motions on every held-out take. Both are timed in the same process, one after the other, in
wall and processor time. The last columns are of another protocol and measure, those of `tests/benchmarks/quality`, on
the same captures and on some that neither search has seen.
"""

import argparse
import os
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from mtex_usd.texture.suggestion import Choice, Score, Task, evaluate_choice, rank_choices, set_task
from mtex_usd.texture.suggestion.choices import list_pairs
from tests.benchmarks.quality.cases import DANCE, HELD_OUT, WALK, Case, Fold, load_folds
from tests.benchmarks.quality.metrics import position_error
from tests.benchmarks.quality.settings import make_recipe, run_method

__all__ = ["Comparison", "compare_searches", "main"]

MOST_ERROR = 1.05
MOST_TIME = 0.1

T = TypeVar("T")

_CASES = {"07": (WALK, HELD_OUT[0]), "05": (DANCE, HELD_OUT[2])}


@dataclass(frozen=True, eq=False)
class Comparison:
    """What both searches came to on one case.

    Parameters
    ----------
    task
        What there was to choose from.
    best, best_score
        The pair with the least error of all.
    first, first_score
        The first suggestion.
    tried
        How many pairs and bands the search tried.
    search_s, suggestion_s
        Wall and processor seconds.
    """

    task: Task
    best: Choice
    best_score: Score
    first: Choice
    first_score: Score
    tried: int
    search_s: tuple[float, float]
    suggestion_s: tuple[float, float]

    @property
    def error_ratio(self) -> float:
        """Error of the first suggestion relative to the best pair's."""
        return self.first_score.error / self.best_score.error

    @property
    def time_ratio(self) -> float:
        """Time of the suggestion relative to the search's, the worse of wall and processor time."""
        return max(a / b for a, b in zip(self.suggestion_s, self.search_s, strict=True))


def compare_searches(case: Case, folds: Sequence[Fold]) -> Comparison:
    """Suggest for a case, and search it."""

    def set_up() -> Task:
        return set_task(folds[0].sketch, [fold.truth for fold in folds], make_recipe(case))

    def search() -> dict[Choice, Score]:
        task = set_up()
        return {choice: evaluate_choice(task, choice) for choice in list_pairs(task.channels, task.bands)}

    ranked, suggestion_s = _time(lambda: rank_choices(set_up()))
    scores, search_s = _time(search)
    best = min(scores, key=lambda choice: scores[choice].error)
    first = ranked[0]
    return Comparison(set_up(), best, scores[best], first.choice, first.score, len(scores), search_s, suggestion_s)


def _time(work: Callable[[], T]) -> tuple[T, tuple[float, float]]:
    wall, processor = time.perf_counter(), time.process_time()
    done = work()
    return done, (time.perf_counter() - wall, time.process_time() - processor)


def _quality_error(folds: Sequence[Fold], choice: Choice) -> float:
    """Error in the other protocol, metres."""
    settings = {
        "match": choice.tokens(folds[0].sketch.joints),
        "break_channel": choice.break_channel.name(folds[0].sketch.joints),
        "match_band": choice.band,
        "paths": 1,
    }
    clips = [run_method(fold, **settings).variants[0].clip for fold in folds]
    return float(np.mean([position_error(fold, clip) for fold, clip in zip(folds, clips, strict=True)]))


def _report(case: Case, made: Comparison, folds: Sequence[Fold], unseen: Sequence[Fold]) -> list[str]:
    lines = [
        f"### {case.name}",
        f"{len(made.task.trials)} takes held out, {len(made.task.channels)} channels, bands {made.task.bands}; "
        f"{made.tried} pairs and bands in {made.search_s[0]:.0f} s ({made.search_s[1]:.0f} s of processor); "
        f"suggestion {made.suggestion_s[0]:.1f} s ({made.suggestion_s[1]:.1f} s)",
        "",
        "| | error cm | smoothness | quality cm | unseen cm | match | band |",
        "| --- | ---: | ---: | ---: | ---: | --- | ---: |",
    ]
    rows: list[tuple[str, Choice, Score]] = [
        ("best pair of all", made.best, made.best_score),
        ("first suggestion", made.first, made.first_score),
    ]
    if made.task.own is not None:
        rows.append(("by hand", made.task.own, evaluate_choice(made.task, made.task.own)))
    for name, choice, score in rows:
        names = ", ".join(token.rpartition("/")[2] for token in choice.tokens(made.task.joints))
        apart = [f"{100 * _quality_error(each, choice):.2f}" for each in (folds, unseen)]
        cells = [name, f"{100 * score.error:.3f}", f"{score.smoothness:.2f}", *apart, names, str(choice.band)]
        lines.append(f"| {' | '.join(cells)} |")
    verdict = "holds" if _holds(made) else "FAILS"
    lines += ["", f"error {made.error_ratio:.3f} of the best, time {made.time_ratio:.3f} of the search: {verdict}", ""]
    return lines


def _holds(made: Comparison) -> bool:
    return made.error_ratio <= MOST_ERROR and made.time_ratio <= MOST_TIME


def _find_data(given: Path | None) -> Path:
    default = Path(__file__).resolve().parents[3] / "shared" / "data"
    folder = given or Path(os.environ.get("MTEX_TEST_DATA", default))
    if not (folder / "cmu_bvh").is_dir():
        sys.exit(f"no captures in {folder}: name the folder that holds cmu_bvh with --data or MTEX_TEST_DATA")
    return folder


def main(arguments: Sequence[str] | None = None) -> int:
    """Print both cases; give 1 where a limit does not hold, else 0."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.suggestion", description="Suggestion and search.")
    parser.add_argument("--data", type=Path, help="folder with cmu_bvh")
    parser.add_argument("--case", action="append", choices=sorted(_CASES), help="only this one; may be repeated")
    options = parser.parse_args(arguments)
    data = _find_data(options.data)
    good = True
    for name in options.case or ("07", "05"):
        case, other = _CASES[name]
        folds = load_folds(case, data)
        made = compare_searches(case, folds)
        print("\n".join(_report(case, made, folds, load_folds(other, data))), flush=True)
        good = good and _holds(made)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
