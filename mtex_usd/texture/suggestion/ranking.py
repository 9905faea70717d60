"""Choosing match channels and band: rehearse everything, try what does best in earnest, rank by what comes of it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from mtex_usd.motion.channels import Channel
from mtex_usd.texture.suggestion.choices import Choice, list_pairs
from mtex_usd.texture.suggestion.measuring import Score
from mtex_usd.texture.suggestion.rehearsal import rehearse_choices
from mtex_usd.texture.suggestion.sampling import read_cast
from mtex_usd.texture.suggestion.task import Task, evaluate_choice

__all__ = ["LEAST_EVALUATED", "Ranked", "rank_choices"]

LEAST_EVALUATED = 16
"""So many of the choices that rehearse best are tried in earnest, or as many as are asked for."""

_MOST_MATCHED = 4
_EXTENDED = 8
# Another channel has to be worth its place: by so much less error.
_WORTH = 0.97

Report = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Ranked:
    """A choice and how well it does.

    Parameters
    ----------
    choice
        Match channels, break channel and band.
    score
        Over all trials.
    is_own
        Whether the sketch has it already.
    rank
        Place among all that were tried in earnest, 1 is the best.
    """

    choice: Choice
    score: Score
    is_own: bool
    rank: int


def rank_choices(task: Task, *, count: int = LEAST_EVALUATED, report: Report | None = None) -> tuple[Ranked, ...]:
    """Rank choices of one to four match channels and a band.

    Parameters
    ----------
    task
        What there is to choose from.
    count
        How many are wanted.
    report
        Called with how much is done, of how much, and what is being done.

    Returns
    -------
    tuple of Ranked
        The best by error and smoothness first, at most `count`; and after them what the sketch has already, where that
        is not among them. The same input gives the same ranking.

    Notes
    -----
    All single channels and pairs are rehearsed in either order; the best few are then extended by one channel after the
    other. Only those that rehearse best are made into motion and measured. The scores are those of
    :func:`~mtex_usd.texture.suggestion.task.evaluate_choice`, whatever a rehearsal said.
    """
    shortlist = _shortlist(task, max(count, LEAST_EVALUATED), report)
    if task.own is not None and task.own not in shortlist:
        shortlist.append(task.own)
    scores: dict[Choice, Score] = {}
    for choice in shortlist:
        _tell(report, len(scores), len(shortlist), "trying the best")
        scores[choice] = evaluate_choice(task, choice)
    order = sorted(shortlist, key=lambda choice: scores[choice].merit)
    ranked = [Ranked(each, scores[each], each == task.own, rank) for rank, each in enumerate(order, start=1)]
    return (*ranked[:count], *(each for each in ranked[count:] if each.is_own))


def _shortlist(task: Task, count: int, report: Report | None) -> list[Choice]:
    """Give the choices that rehearse best."""
    cast = read_cast(task.takes, task.trials, task.ends)

    def rehearse(choices: Sequence[Choice], what: str) -> dict[Choice, float]:
        return rehearse_choices(
            cast, choices, task.root, task.recipe, report=lambda done, total: _tell(report, done, total, what)
        )

    singles = [Choice((channel,), channel, band) for channel in task.channels for band in task.bands]
    found = rehearse([*singles, *list_pairs(task.channels, task.bands)], "rehearsing channels")
    grown = list(found)
    for size in range(3, _MOST_MATCHED + 1):
        best = sorted((choice for choice in grown if len(choice.match) == size - 1), key=found.__getitem__)
        longer = _extend(best[:_EXTENDED], task)
        errors = rehearse(list(longer), f"rehearsing {size} channels")
        grown = [choice for choice in longer if errors[choice] <= _WORTH * found[longer[choice]]]
        found.update({choice: errors[choice] for choice in grown})
    ranked = sorted(found, key=found.__getitem__)
    # Half of them no more than pairs: a longer list is easily better by luck alone.
    short = [choice for choice in ranked if len(choice.match) <= 2][: (count + 1) // 2]
    rest = [choice for choice in ranked if choice not in short][: count - len(short)]
    return [*short, *rest]


def _extend(choices: Sequence[Choice], task: Task) -> dict[Choice, Choice]:
    """Give every choice with every other channel added, each set and cut once, and the best of what it is made from."""
    longer: dict[tuple[frozenset[Channel], Channel, int], tuple[Choice, Choice]] = {}
    for choice in choices:
        for channel in task.channels:
            if channel not in choice.match:
                added = Choice((*choice.match, channel), choice.break_channel, choice.band)
                longer.setdefault((frozenset(added.match), added.break_channel, added.band), (added, choice))
    return dict(longer.values())


def _tell(report: Report | None, done: int, total: int, what: str) -> None:
    if report is not None:
        report(done, total, what)
