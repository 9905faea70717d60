"""Suggestions on captures: as good as the best of a search; the whole search is in `tests/benchmarks/suggestion.py`."""

from pathlib import Path

import numpy as np
import pytest

from mtex_usd.texture.suggestion import Task, evaluate_choice, rank_choices, set_task
from mtex_usd.texture.suggestion.choices import list_pairs
from mtex_usd.texture.suggestion.rehearsal import rehearse_choices
from mtex_usd.texture.suggestion.sampling import read_cast
from tests.benchmarks.quality.cases import DANCE, WALK, Case
from tests.benchmarks.quality.settings import make_recipe
from tests.quality.real import case_folds

LIVELIEST, TAKES = 4, 4


def set_up(case: Case, data_dir: Path) -> Task:
    """A few takes of a case."""
    folds = case_folds(case, data_dir)[:TAKES]
    return set_task(folds[0].sketch, [fold.truth for fold in folds], make_recipe(case))


@pytest.mark.parametrize("case", [WALK, DANCE], ids=lambda case: case.name)
def test_the_first_suggestion_is_as_good_as_a_search(case: Case, data_dir: Path) -> None:
    task = set_up(case, data_dir)
    choices = list_pairs(task.channels[:LIVELIEST], task.bands[1:3])
    errors = {choice: evaluate_choice(task, choice).error for choice in choices}
    assert rank_choices(task)[0].score.error <= 1.05 * min(errors.values())
    cast = read_cast(task.takes, task.trials, task.ends)
    rehearsed = rehearse_choices(cast, choices, task.root, task.recipe)
    together = np.corrcoef([rehearsed[choice] for choice in choices], [errors[choice] for choice in choices])
    assert together[0, 1] > 0.85
