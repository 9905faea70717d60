"""Edits that change values and leave the time alone: filters, equalizer, medians, curves on channels, mirror."""

from mtex_usd.edit.filters import bandpass, equalize, highpass, lowpass
from mtex_usd.edit.mirroring import mirror
from mtex_usd.edit.robust import median, robust_mean
from mtex_usd.edit.shaping import make_soft_limits, waveshape
from mtex_usd.edit.stack.edit import Edit
from mtex_usd.motion.clip import Clip

__all__ = [
    "run_bandpass",
    "run_equalize",
    "run_highpass",
    "run_lowpass",
    "run_median",
    "run_mirror",
    "run_robust_mean",
    "run_waveshape",
]


def run_lowpass(clip: Clip, edit: Edit) -> Clip:
    """Run ``lowpass``."""
    (frequency,) = _frequencies(edit, 1)
    return lowpass(clip, frequency=frequency, **edit.pick(channels="channels", order="order"))


def run_highpass(clip: Clip, edit: Edit) -> Clip:
    """Run ``highpass``."""
    (frequency,) = _frequencies(edit, 1)
    return highpass(clip, frequency=frequency, **edit.pick(channels="channels", order="order"))


def run_bandpass(clip: Clip, edit: Edit) -> Clip:
    """Run ``bandpass``."""
    lower, upper = _frequencies(edit, 2)
    return bandpass(clip, frequencies=(lower, upper), **edit.pick(channels="channels", order="order"))


def _frequencies(edit: Edit, count: int) -> tuple[float, ...]:
    found = tuple(edit.settings["frequencies"])
    if len(found) != count:
        expected = "one frequency, Hz" if count == 1 else "the lower and the upper frequency, Hz"
        raise edit.fail("frequencies do not fit", expected=expected, found=str(list(found)))
    return found


def run_equalize(clip: Clip, edit: Edit) -> Clip:
    """Run ``equalize``."""
    chosen = edit.pick(channels="channels", residual_gain="residualGain")
    return equalize(clip, gains=edit.settings["gains"], **chosen)


def run_median(clip: Clip, edit: Edit) -> Clip:
    """Run ``median``."""
    return median(clip, window_s=edit.settings["window"], **edit.pick(channels="channels"))


def run_robust_mean(clip: Clip, edit: Edit) -> Clip:
    """Run ``robustMean``."""
    chosen = edit.pick(channels="channels", discard="discard")
    return robust_mean(clip, window_s=edit.settings["window"], **chosen)


def run_waveshape(clip: Clip, edit: Edit) -> Clip:
    """Run ``waveshape``: with a curve, or with limits."""
    channels = edit.settings["channels"]
    if ("points" in edit.settings) == ("limits" in edit.settings):
        raise edit.fail("no curve or two", expected="either points or limits")
    if "points" in edit.settings:
        _refuse(edit, "softness", "points")
        return waveshape(clip, points=edit.settings["points"], channels=channels, **edit.pick(about="about"))
    _refuse(edit, "about", "limits")
    lower, upper = edit.settings["limits"]
    points = make_soft_limits(lower, upper, **edit.pick(softness="softness"))
    return waveshape(clip, points=points, channels=channels, about="rest")


def _refuse(edit: Edit, name: str, beside: str) -> None:
    if name in edit.settings:
        raise edit.fail(f"{name} says nothing beside {beside}", fix=f"Remove {name}.")


def run_mirror(clip: Clip, edit: Edit) -> Clip:
    """Run ``mirror``."""
    return mirror(clip, **edit.pick(plane="plane"))
