"""Wave-shaping: a smooth monotone curve from a channel's values to new ones (Gleicher 2000, section 1.6.3.2).

What it does to contacts: the joint takes other angles at the same moments, so a hand or foot below it stands elsewhere;
where the curve is the identity nothing moves.
"""

from collections.abc import Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.curve_space import CurveSpace, select_channels
from mtex_usd.errors import InputError
from mtex_usd.motion.arguments import as_clip, as_number, as_numbers, as_tokens, as_word, refuse
from mtex_usd.motion.clip import Clip

__all__ = ["make_soft_limits", "waveshape"]

FloatArray = npt.NDArray[np.float64]

_ROUNDING = 1e-12  # of the largest value: shaped values this near are meant to be the same
_FARTHEST = 1e9  # degrees or stage units
_LEAST_APART = 1e-6  # of two values: nearer ones coincide
_SOFT_POINTS = 24
_SOFT_PART = 0.75  # of the softness in which the bend's points lie
_SOFT_REACH = 8.0  # softnesses: exp(-8) of the softness is left below the limit


def waveshape(
    clip: Clip,
    *,
    points: Sequence[tuple[float, float]],
    channels: Sequence[str],
    about: Literal["mean", "rest"] = "mean",
) -> Clip:
    """Pass channels through a curve.

    Parameters
    ----------
    clip
        The clip.
    points
        Pairs of a value and what becomes of it, in degrees for rotations and stage units for translations, from `about`
        on; at least two, the values increasing, what they become never decreasing. Between them the curve is smooth
        and monotone (PCHIP), outside it goes on straight.
    channels
        Channel tokens as in recipes, at least one; rotations or translations, not both. Every channel is shaped on its
        own, rotations as Euler angles in skeleton axes.
    about
        ``"mean"``: values count from the channel's mean over the clip; ``"rest"``: from the rest pose, as limits do.

    Returns
    -------
    Clip
        Frames whose values the curve leaves as they are keep their bits.

    Raises
    ------
    InputError
        For unknown channels or none, rotations together with translations, and points that are no monotone curve.

    Notes
    -----
    Contacts: a joint of the leg moves the foot with it. Thighs that swing 1.2 times as far make the sample walk's
    planted feet slide by 8 cm and rise by 5 cm; above the hips nothing happens to them.

    Examples
    --------
    >>> livelier = waveshape(take, points=[(-60, -80), (0, 0), (60, 80)], channels=["*Arm.rx"])  # doctest: +SKIP
    """
    as_clip(clip)
    curve = _check_points(points)
    as_word(about, ("mean", "rest"), "bad origin of the curve")
    if not as_tokens(channels):
        raise InputError("no channels to shape", expected="at least one channel token", found="none")
    chosen = select_channels(clip, channels)
    angles = tuple(channel for channel in chosen if channel.is_rotation)
    offsets = tuple(channel for channel in chosen if not channel.is_rotation)
    if angles and offsets:
        raise InputError(
            "one curve cannot shape degrees and stage units",
            fix="Shape rotations and translations one after the other.",
        )
    space = CurveSpace(clip, (), angles, offsets)
    origin = space.curves.mean(axis=0) if about == "mean" else np.zeros(len(chosen))
    return space.add(_shape(space.curves - origin, curve))


def make_soft_limits(lower: float, upper: float, *, softness: float = 10.0) -> tuple[tuple[float, float], ...]:
    """Make the points of a soft clip, for :func:`waveshape` with ``about="rest"``: limits that are never passed.

    Parameters
    ----------
    lower, upper
        Least and greatest value, degrees or stage units; infinite where there is no limit on that side.
    softness
        How far before a limit values begin to be held back, above 0. Farther inside nothing changes.

    Returns
    -------
    tuple of pairs
        As `points` of :func:`waveshape`.

    Raises
    ------
    InputError
        Where both limits are infinite, or closer than twice the softness.
    """
    lower, upper = (
        as_number(limit, "limits", expected="numbers", least=-np.inf, most=np.inf) for limit in (lower, upper)
    )
    softness = as_number(softness, "softness")
    if not (lower < upper and upper - lower > 2.0 * softness and min(-lower, upper) < np.inf):
        raise InputError(
            "bad limits",
            expected="a softness above 0, a limit, and an upper one more than twice the softness above the lower",
            found=f"{lower:g} to {upper:g}, softness {softness:g}",
        )
    bend = _bend(softness)
    below = [(lower - x, lower - y) for x, y in bend[::-1]] if lower > -np.inf else []
    above = [(upper + x, upper + y) for x, y in bend] if upper < np.inf else []
    # On a side without limit one more point lets the identity go on for ever.
    onwards = [] if above else [(below[-1][0] + softness, below[-1][1] + softness)]
    backwards = [] if below else [(above[0][0] - softness, above[0][1] - softness)]
    return tuple((float(x), float(y)) for x, y in (*backwards, *below, *above, *onwards))


def _bend(softness: float) -> FloatArray:
    """Values and what they become, both from an upper limit on, from the last that stays to those held at the limit."""
    # The spline bends a little before its own points do: between the first two of these.
    scale = _SOFT_PART * softness
    beyond = np.linspace(0.0, _SOFT_REACH, _SOFT_POINTS)
    curve = scale * np.stack([beyond - 1.0, -np.exp(-beyond)], axis=1)
    curve[-1, 1] = 0.0
    return np.concatenate([[[-softness, -softness]], curve, [[2.0 * curve[-1, 0], 0.0]]])


def _check_points(points: object) -> FloatArray:
    expected = f"at least two pairs of numbers, none beyond {_FARTHEST:g}"
    curve = as_numbers(points, "points of the curve", expected=expected)
    if curve.ndim != 2 or curve.shape[1:] != (2,) or len(curve) < 2 or not (np.abs(curve) <= _FARTHEST).all():
        raise refuse(points, "points of the curve", expected)
    rises = np.diff(curve, axis=0)
    if (rises[:, 0] < _LEAST_APART).any() or (rises[:, 1] < 0.0).any():
        raise InputError(
            "the points are no monotone curve",
            expected="increasing values, and results that never decrease",
            found=str([tuple(pair) for pair in curve.tolist()]),
        )
    return curve


def _shape(values: FloatArray, curve: FloatArray) -> FloatArray:
    """How much each value changes, exactly 0 where the curve is the identity but for rounding."""
    from scipy.interpolate import PchipInterpolator  # noqa: PLC0415  (slow to import, seldom used)

    x, y = curve.T
    spline = PchipInterpolator(x, y)
    slopes = spline.derivative()([x[0], x[-1]])
    inside = np.clip(values, x[0], x[-1])
    outside = np.where(values < x[0], slopes[0], slopes[1]) * (values - inside)
    change = spline(inside) + outside - values
    scale = max(float(np.abs(values).max()), float(np.abs(curve).max()))
    return np.asarray(np.where(np.abs(change) <= _ROUNDING * scale, 0.0, change))
