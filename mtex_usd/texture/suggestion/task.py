"""What is to be chosen for one sketch: its trials, and the channels and bands there are."""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from mtex_usd.errors import InputError
from mtex_usd.motion.channels import Channel
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.engine import animated_channels, texture_motion
from mtex_usd.texture.reading import choose_root
from mtex_usd.texture.recipe import Recipe
from mtex_usd.texture.roles import resolve_roles
from mtex_usd.texture.suggestion.choices import Choice, list_bands, moving_channels
from mtex_usd.texture.suggestion.measuring import Ends, Measure, Score, combine_scores
from mtex_usd.texture.suggestion.trials import Trial, bring_takes, make_trials, share_joints

__all__ = ["Task", "evaluate_choice", "set_task"]


@dataclass(frozen=True, eq=False)
class Task:
    """One sketch whose match channels and band are to be chosen.

    Parameters
    ----------
    recipe
        What is textured and synthesized anywhere in the sketch, and how, for trials: one path, no segments.
    root
        The character's root joint.
    takes
        All usable takes, on the character's skeleton.
    trials
        Those of them that are held out, each with its sketch and the others.
    channels
        What match channels are chosen from, the liveliest first.
    bands
        The bands tried.
    ends
        What is measured.
    highest_band
        The highest band of a result.
    own
        What the sketch itself asks for; None where the takes cannot be matched in that way.
    notes
        Takes that are left out, and why.
    """

    recipe: Recipe
    root: int
    takes: tuple[Clip, ...]
    trials: tuple[Trial, ...]
    channels: tuple[Channel, ...]
    bands: tuple[int, ...]
    ends: Ends
    highest_band: int
    own: Choice | None
    notes: tuple[str, ...]

    @property
    def joints(self) -> tuple[str, ...]:
        """Joint paths of the character's skeleton."""
        return self.takes[0].joints

    @cached_property
    def measures(self) -> tuple[Measure, ...]:
        """What results are held against, one per trial."""
        return tuple(Measure(trial, self.ends, self.highest_band) for trial in self.trials)


def set_task(sketch: Clip, takes: Sequence[Clip], recipe: Recipe) -> Task:
    """Find out what there is to choose from, and make the trials.

    Parameters
    ----------
    sketch
        The animator's motion on every joint of the character.
    takes
        Recorded motion at the sketch's rate, as :func:`mtex_usd.texture.engine.texture_motion` takes it.
    recipe
        As the sketch carries it; match channels, break channel and band are what is to be chosen.

    Raises
    ------
    InputError
        As :func:`~mtex_usd.texture.engine.texture_motion`; fewer than two takes that can be used, or none long enough;
        no channel to choose from.
    """
    root = choose_root(sketch, takes)
    animated = animated_channels(sketch, root)
    roles = resolve_roles(recipe, sketch, animated)
    filled = _join(span.synthesize for span in roles.spans)
    detailed = tuple(channel for channel in _join(span.texture for span in roles.spans) if channel not in filled)
    shared = share_joints(sketch, takes, roles.copied)
    sketched = [channel for channel in animated if channel not in filled and channel.joint in shared]
    brought, notes = bring_takes(sketch, takes, root, roles.copied)
    trials = make_trials(brought, sketched)
    bands = _find_bands(sketch, trials)
    for_trials = replace(
        recipe,
        texture=_name(detailed, sketch),
        synthesize=_name(filled, sketch),
        paths=1,
        diversity=0.0,
        segments=(),
    )
    return Task(
        recipe=for_trials,
        root=root,
        takes=brought,
        trials=trials,
        channels=_choose_channels(sketch, brought, sketched, root, bands),
        bands=bands,
        ends=Ends.of_joints(sketch.skeleton, sorted({channel.joint for channel in filled or detailed})),
        highest_band=roles.synthesis_band,
        own=_own_choice(for_trials, sketch, animated, shared),
        notes=notes,
    )


def evaluate_choice(task: Task, choice: Choice) -> Score:
    """Find every held-out take again with a choice, and compare.

    Parameters
    ----------
    task
        The trials.
    choice
        Match channels, break channel and band.

    Returns
    -------
    Score
        The mean over the trials.
    """
    recipe = choice.apply_to(task.recipe, task.joints)
    results = [texture_motion(trial.sketch, trial.takes, recipe).variants[0].clip for trial in task.trials]
    return combine_scores([measure.score(clip) for measure, clip in zip(task.measures, results, strict=True)])


def _join(sets: Iterable[frozenset[Channel]]) -> tuple[Channel, ...]:
    return tuple(sorted(frozenset().union(*sets)))


def _name(channels: Sequence[Channel], sketch: Clip) -> tuple[str, ...]:
    return tuple(channel.name(sketch.joints) for channel in channels)


def _find_bands(sketch: Clip, trials: Sequence[Trial]) -> tuple[int, ...]:
    """Give the bands that the sketch, a held-out take and some take of every trial are long enough for."""
    longest = [max(take.frame_count for take in trial.takes) for trial in trials]
    held_out = max(trial.truth.frame_count for trial in trials)
    return list_bands([sketch.frame_count, held_out, *longest], sketch.rate)


def _choose_channels(
    sketch: Clip, takes: Sequence[Clip], sketched: Sequence[Channel], root: int, bands: Sequence[int]
) -> tuple[Channel, ...]:
    channels = moving_channels(takes, sketched, root, bands)
    if not channels:
        raise InputError(
            f"{sketch.name}: there is no channel to choose from",
            expected="channels that the sketch animates, that are not synthesized, and that move in the takes",
            found=", ".join(_name(sketched, sketch)) + ", still in the takes" if sketched else "none",
        )
    return channels


def _own_choice(recipe: Recipe, sketch: Clip, animated: tuple[Channel, ...], shared: Collection[int]) -> Choice | None:
    """What the sketch itself asks for outside its segments, if the takes have all of it."""
    span = resolve_roles(recipe, sketch, animated).spans[0]
    if not {channel.joint for channel in (*span.match, span.break_channel)} <= set(shared):
        return None
    return Choice(span.match, span.break_channel, span.match_band)
