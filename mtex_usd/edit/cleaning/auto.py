"""The steps of the clean-up by name, and the choice of them that a clip needs."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from types import MappingProxyType

from mtex_usd.edit.cleaning.flips import repair_flips
from mtex_usd.edit.cleaning.floor import report_floor
from mtex_usd.edit.cleaning.gaps import fill_gaps
from mtex_usd.edit.cleaning.jumps import report_jumps
from mtex_usd.edit.cleaning.leading import trim_leading
from mtex_usd.edit.cleaning.noise import measure_noise, smooth_noise
from mtex_usd.edit.cleaning.report import CleaningResult
from mtex_usd.edit.cleaning.spikes import repair_spikes
from mtex_usd.errors import InputError
from mtex_usd.motion.arguments import as_clip_with_gaps, as_tokens
from mtex_usd.motion.clip import Clip

__all__ = ["CLEANING_STEPS", "check_steps", "clean_auto", "clean_clip"]

_AUTO = "auto"
_MEASURABLE_RATE = 60.0  # frames per second: below, fast movement passes for noise
_NOISY_DEG = 1.0  # of the noisiest joint: the CMU takes of dance, the worst at hand, have a third of it


CLEANING_STEPS: Mapping[str, Callable[[Clip], CleaningResult]] = MappingProxyType(
    {
        "leading": trim_leading,
        "gaps": fill_gaps,
        "flips": repair_flips,
        "spikes": repair_spikes,
        "jumps": report_jumps,
        "noise": smooth_noise,
        "floor": report_floor,
    }
)
"""Every step by its name, in the order that makes sense."""


def check_steps(steps: Sequence[str]) -> None:
    """Refuse names that are no steps.

    Parameters
    ----------
    steps
        Names from :data:`CLEANING_STEPS`, or ``"auto"`` alone.

    Raises
    ------
    InputError
        Naming the steps there are.
    """
    names = as_tokens(steps, "steps of the clean-up", expected=f"a list: auto or any of {', '.join(CLEANING_STEPS)}")
    unknown = [step for step in names if step not in CLEANING_STEPS and step != _AUTO]
    if unknown:
        raise InputError(
            f"unknown step of the clean-up: {', '.join(unknown)}",
            expected=f"auto or any of {', '.join(CLEANING_STEPS)}",
        )
    if _AUTO in names and len(names) > 1:
        raise InputError("auto chooses the steps itself", found=",".join(names), fix="Give auto alone, or the steps.")


def clean_clip(clip: Clip, steps: Sequence[str], *, floor_height: float = 0.0) -> CleaningResult:
    """Run steps of the clean-up in the order given, each with its own defaults.

    Parameters
    ----------
    clip
        The clip.
    steps
        Names from :data:`CLEANING_STEPS`, or ``"auto"`` alone; none leaves the clip as it is.
    floor_height
        Height of the floor along up, skeleton units.

    Returns
    -------
    CleaningResult
        Changes and notes of all steps; frames are counted in the clip that was given.

    Raises
    ------
    InputError
        For an unknown step.
    """
    as_clip_with_gaps(clip)
    check_steps(steps)
    if list(steps) == [_AUTO]:
        return clean_auto(clip, floor_height=floor_height)
    result = CleaningResult(clip=clip)
    for step in steps:
        run = partial(report_floor, height=floor_height) if step == "floor" else CLEANING_STEPS[step]
        result = result.then(run(result.clip))
    return result


def clean_auto(clip: Clip, *, floor_height: float = 0.0) -> CleaningResult:
    """Clean a clip of what is surely not the performer's, and report what else was found.

    Leading frames are taken off, gaps filled, flips turned back and spikes replaced where there are any; noise is
    filtered only where the noisiest joint has more than a degree of it, at 60 frames/s or more. Jumps of the feet and
    what is below the floor are noted.

    Parameters
    ----------
    clip
        The clip.
    floor_height
        Height of the floor along up, skeleton units.

    Returns
    -------
    CleaningResult
        What was changed where; a clean clip comes back as it is.
    """
    result = clean_clip(clip, ("leading", "gaps", "flips", "spikes", "jumps"))
    if clip.rate >= _MEASURABLE_RATE and measure_noise(result.clip) > _NOISY_DEG:
        result = result.then(smooth_noise(result.clip))
    return result.then(report_floor(result.clip, height=floor_height))
