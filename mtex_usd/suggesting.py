"""Which match channels and band to choose for the sketches of a shot, by finding their takes again."""

from collections.abc import Sequence
from dataclasses import dataclass

from mtex_usd.errors import InputError
from mtex_usd.motion.arguments import as_whole_number
from mtex_usd.motion.channels import Channel, resolve_channels
from mtex_usd.progress import ProgressCallback, report_progress
from mtex_usd.texture.suggestion import Choice, Ranked, Task, rank_choices, set_task
from mtex_usd.usd.arguments import FilePath, PrimPath, as_file_path, as_prim_paths
from mtex_usd.usd.atomic import check_target
from mtex_usd.usd.recipe_layer import MatchRecipe, check_overridable, write_recipes
from mtex_usd.usd.shot import Job, find_cast, read_jobs
from mtex_usd.usd.source_stage import find_override, open_source

__all__ = ["MOST_SUGGESTIONS", "Suggestion", "Suggestions", "suggest"]

MOST_SUGGESTIONS = 10
"""How many suggestions there are unless otherwise asked for."""


@dataclass(frozen=True)
class Suggestion:
    """Match channels and a band, and how well takes that were held out were found again with them.

    Parameters
    ----------
    rank
        Place by error and smoothness among all that were tried, 1 is the best.
    recipe
        Match channels, break channel and band, as the schema has them.
    error
        Mean distance of what is filled in from where the held-out takes have it, metres.
    relative_error
        The same in heights of the character at rest.
    smoothness
        Jerk of what is filled in relative to the takes': 1 is as smooth, more is rougher, less calmer.
    is_own
        Whether the sketch asks for it already.
    """

    rank: int
    recipe: MatchRecipe
    error: float
    relative_error: float
    smoothness: float
    is_own: bool


@dataclass(frozen=True)
class Suggestions:
    """What is suggested for one sketch.

    Parameters
    ----------
    anim
        Path of the sketch.
    suggestions
        Best first; the last may be what the sketch asks for, where that did not come among the best.
    held_out
        Paths of the takes that were held out, each in turn.
    notes
        What a user should know.
    left_out
        Why sketches of the shot are missing here; the same for all.
    """

    anim: str
    suggestions: tuple[Suggestion, ...]
    held_out: tuple[str, ...]
    notes: tuple[str, ...]
    left_out: tuple[str, ...]


def suggest(
    stage_path: FilePath,
    *,
    anim: PrimPath | Sequence[PrimPath] = (),
    top: int = MOST_SUGGESTIONS,
    apply: FilePath | None = None,
    progress: ProgressCallback | None = None,
) -> tuple[Suggestions, ...]:
    """Rank match channels and bands for the sketches of a shot.

    Parameters
    ----------
    stage_path
        The shot, or the thin root of an earlier run. It and all it is made of stay as they are.
    anim
        Prim path or paths of the sketches to work on; by default all.
    top
        How many suggestions are wanted for each.
    apply
        A layer to write the first suggestion of every sketch into, as overs; put it first among the shot's sublayers.
    progress
        Called with how much is done, of how much, and what is being done.

    Returns
    -------
    tuple of Suggestions
        One per sketch. The same input gives the same suggestions.

    Raises
    ------
    InputError
        Options, channels, takes or files that are not right; fewer than two takes; no channel to choose from.
    StageError
        No recipe, no animation, nothing that plays it; a sketch inside an instance that was to be applied to.

    Notes
    -----
    Every take is held out in turn, sketched by splines through a frame every quarter of a second, and what the recipe
    textures and synthesizes is found again from the other takes (Pullen & Bregler 2002 leave the choice of channels and
    band to the animator). Contacts and time segments play no part in that.
    """
    count = as_whole_number(top, "top", least=1)
    sketches = as_prim_paths(anim, "anim")
    shot = as_file_path(stage_path, "stage")
    target = None if apply is None else as_file_path(apply, "apply")
    if target is not None:
        check_target(target, "recipe")
    source = open_source(shot)
    cast = find_cast(source.stage, only=sketches, previous=find_override(shot))
    # A sketch that several characters play is one sketch: what it matches on is the same for all.
    characters = list({character.animation: character for character in reversed(cast.wanted)}.values())[::-1]
    if target is not None:
        check_overridable(source.stage, [character.animation for character in characters])
    found = {}
    for job in read_jobs(source.stage, characters):
        found[job.character.animation] = _suggest_one(job, count, progress, cast.left_out)
    if target is not None:
        write_recipes(source.stage, {path: each.suggestions[0].recipe for path, each in found.items()}, target)
    return tuple(found.values())


def _suggest_one(job: Job, count: int, progress: ProgressCallback | None, left_out: tuple[str, ...]) -> Suggestions:
    name = str(job.character.animation)

    def report(done: int, total: int, what: str) -> None:
        report_progress(progress, done, total, f"{name}: {what}")

    task = set_task(job.sketch, [take.clip for take in job.takes], job.recipe)
    ranked = rank_choices(task, count=count, report=report)
    height = job.sketch.skeleton.height * job.sketch.skeleton.meters_per_unit
    return Suggestions(
        anim=name,
        suggestions=tuple(_describe(each, task, height) for each in ranked),
        held_out=tuple(trial.truth.name for trial in task.trials),
        notes=_notes(job, task),
        left_out=left_out,
    )


def _describe(ranked: Ranked, task: Task, height: float) -> Suggestion:
    score = ranked.score
    return Suggestion(
        rank=ranked.rank,
        recipe=_as_recipe(ranked.choice, task.joints),
        error=score.error,
        relative_error=score.error / height if height > 0.0 else 0.0,
        smoothness=score.smoothness,
        is_own=ranked.is_own,
    )


def _as_recipe(choice: Choice, joints: Sequence[str]) -> MatchRecipe:
    return MatchRecipe(
        match=tuple(_shorten(channel, joints) for channel in choice.match),
        break_channel=_shorten(choice.break_channel, joints),
        band=choice.band,
    )


def _shorten(channel: Channel, joints: Sequence[str]) -> str:
    """Give a channel's token with the joint's last name where that is enough, else with its path."""
    token = channel.name(joints).rpartition("/")[2]
    try:
        found = resolve_channels([token], joints, source="")
    except InputError:
        found = ()
    return token if found == (channel,) else channel.name(joints)


def _notes(job: Job, task: Task) -> tuple[str, ...]:
    notes = list(task.notes)
    if len(task.trials) < len(task.takes):
        notes.append(f"{len(task.trials)} of {len(task.takes)} takes are held out, the others are copied from alone")
    notes += [
        f"segment {segment.name} has match channels, break channel or band of its own and keeps them"
        for segment in job.recipe.segments
        if (segment.match, segment.break_channel, segment.match_band) != (None, None, None)
    ]
    return tuple(notes)
