"""Frequency filters: low-, high- and band-pass, and the equalizer (Gleicher 2000, section 1.6.3.1).

What they do to contacts: a filter knows no floor. Every filtered leg moves its foot, so feet slide and sink by about
what the filter removed; give them back by inverse kinematics, or filter only what carries no contact.
"""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.curve_space import CurveSpace, make_curve_space
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.arguments import as_clip, as_number, as_numbers, as_whole_number, refuse
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.pyramid import Bands, decompose

__all__ = ["bandpass", "equalize", "highpass", "lowpass"]

FloatArray = npt.NDArray[np.float64]

_LARGEST_ORDER = 16
_MOST_GAINS = 24  # a band more would take years of frames
_LARGEST_GAIN = 240.0  # decibels: beyond, angles are not what they were any more
_SLOWEST = 1e-300  # or dividing by a cut-off that is almost none would overflow
_LARGEST_EXPONENT = 700.0  # beyond, the exponential overflows


def lowpass(clip: Clip, *, frequency: float, channels: Sequence[str] = (), order: int = 4) -> Clip:
    """Keep what is slower than a frequency.

    Parameters
    ----------
    clip
        The clip; from 2 frames on something may change.
    frequency
        Cut-off in Hz, above 0: half the amplitude is let through there. From half the frame rate on the clip comes back
        as it is.
    channels
        Channel tokens as in recipes; none means the rotations of all joints and the translations of those that move.
    order
        Order of the Butterworth filter, 1 to 16; steeper the higher, but it rings beside sharp movement.

    Returns
    -------
    Clip
        Where nothing changes the bits stay: other channels' joints, joints at rest, the first and the last frame.

    Raises
    ------
    InputError
        For unknown channels, a frequency or an order out of range.

    Notes
    -----
    Zero phase: the response is that of ``scipy.signal.butter`` run forward and backward. It is applied in the
    frequency domain (sine transform) to what is left beside the line through both ends, continued by point reflection
    without end, so that there is no start-up error at any cut-off and a straight line passes unchanged.

    Contacts: on the sample walk (feet still within 1.1 cm) planted feet slide by up to 4 cm and rise as much at 2
    Hz; from 4 Hz on they are as still as before. Filtering spine and arms alone leaves them as they are.

    Examples
    --------
    >>> calm = lowpass(take, frequency=6.0, channels=["Spine*"])  # doctest: +SKIP
    """
    as_clip(clip)
    _check_frequency(frequency, above=0.0)
    _check_order(order)
    space = make_curve_space(clip, channels)
    if frequency >= 0.5 * clip.rate:
        return clip
    return space.add(_lowpass(space.curves, frequency / clip.rate, order) - space.curves)


def highpass(clip: Clip, *, frequency: float, channels: Sequence[str] = (), order: int = 4) -> Clip:
    """Keep what is faster than a frequency, about the mean pose.

    Parameters
    ----------
    clip
        The clip.
    frequency
        Cut-off in Hz, below half the frame rate: half the amplitude is let through there. 0 gives the clip as it is.
    channels
        As for :func:`lowpass`. With the root's translation among them the character treads on the spot.
    order
        As for :func:`lowpass`.

    Returns
    -------
    Clip
        The mean of every channel, and what :func:`lowpass` with the same frequency takes away.

    Raises
    ------
    InputError
        For unknown channels, a frequency or an order out of range.

    Notes
    -----
    Contacts: none is left. Without the root's slow travel feet are drawn over the floor by their whole stance, on
    the sample walk up to 42 cm from its middle, and sink by 5 cm. Choose channels that carry no contact.
    """
    low = as_number(frequency, "frequency of the filter", expected="0 Hz or more", least=0.0, unit="Hz")
    return bandpass(clip, frequencies=(low, math.inf), channels=channels, order=order)


def bandpass(clip: Clip, *, frequencies: tuple[float, float], channels: Sequence[str] = (), order: int = 4) -> Clip:
    """Keep what lies between two frequencies, about the mean pose.

    Parameters
    ----------
    clip
        The clip.
    frequencies
        Lower and upper cut-off in Hz; a lower of 0 is :func:`lowpass` and keeps the pose, an upper of at least half the
        frame rate is :func:`highpass`, both give the clip as it is.
    channels, order
        As for :func:`lowpass`.

    Returns
    -------
    Clip
        The mean of every channel and the band.

    Raises
    ------
    InputError
        For unknown channels, an order out of range, frequencies in the wrong order or beyond what the rate can hold.

    Notes
    -----
    Contacts: as for :func:`highpass`, unless the lower frequency is 0, and then as for :func:`lowpass`.
    """
    as_clip(clip)
    low, high = _check_frequencies(frequencies)
    _check_order(order)
    space = make_curve_space(clip, channels)
    if low == 0.0:
        return lowpass(clip, frequency=high, channels=channels, order=order)
    if low >= 0.5 * clip.rate:
        raise InputError(
            "nothing is left between the frequencies",
            expected=f"a lower one below half the frame rate, {0.5 * clip.rate:g} Hz",
            found=f"{low:g} Hz",
        )
    upper = space.curves if high >= 0.5 * clip.rate else _lowpass(space.curves, high / clip.rate, order)
    return space.replace_by(upper - _lowpass(space.curves, low / clip.rate, order))


def equalize(clip: Clip, *, gains: Sequence[float], channels: Sequence[str] = (), residual_gain: float = 0.0) -> Clip:
    """Scale the frequency bands of a motion, as a graphic equalizer does (Bruderlin & Williams 1995).

    Parameters
    ----------
    clip
        The clip.
    gains
        Decibels by band of the pyramid, the highest frequency first (see :mod:`mtex_usd.texture.pyramid`); 0 leaves a
        band as it is, 6.02 doubles it, -inf mutes it. Bands without a gain, and what is slower, stay; gains of bands
        that the clip is too short for have nothing to act on.
    channels
        As for :func:`lowpass`.
    residual_gain
        Decibels for what is left below the last band the clip has, about its mean.

    Returns
    -------
    Clip
        With 0 dB throughout the clip as it is.

    Raises
    ------
    InputError
        For unknown channels, more than 24 gains, and gains that are not numbers or above 240 dB.

    Notes
    -----
    Contacts: the nearer a band is to the steps, the farther planted feet slide. At 6 dB on all channels of the
    sample walk (24 frames/s) band 2 makes it 3 cm, band 3 11 cm, band 4, which holds the stride, 20 cm; there -6 dB
    make 11 cm.
    """
    as_clip(clip)
    factors = [_to_factor(gain) for gain in _list_gains(gains)]
    residual = _to_factor(residual_gain)
    space = make_curve_space(clip, channels)
    bands = decompose(space.curves)
    change = np.zeros_like(space.curves)
    for factor, band in zip(factors, bands.bands, strict=False):
        change += (factor - 1.0) * band
    if residual != 1.0:
        change = _scale_residual(space, bands, change, residual)
    return space.add(change) if change.any() else clip


def _scale_residual(space: CurveSpace, bands: Bands, change: FloatArray, factor: float) -> FloatArray:
    """Extend a change so that the slowest part of each channel comes nearer to its mean, or goes farther from it."""
    extended: FloatArray = change + (factor - 1.0) * (bands.residual - bands.residual.mean(axis=0))
    if space.whole:
        bent, slow = space.add(change), space.add(bands.residual - space.curves)
        extended[:, : 3 * len(space.whole)] = _turn_residual(space, slow.rotations, bent.rotations, factor)
    return extended


def _turn_residual(space: CurveSpace, slow: FloatArray, bent: FloatArray, factor: float) -> FloatArray:
    """Turn changed rotations as their slow part has to turn; columns of the change from the clip's own, [F, 3 W]."""
    slow, bent = slow[:, space.whole], bent[:, space.whole]
    means = quaternion.mean(slow)
    away = quaternion.unroll_vectors(quaternion.log(quaternion.multiply(quaternion.conjugate(means), slow)))
    scaled = quaternion.multiply(means, quaternion.exp(factor * away))
    turned = quaternion.multiply(quaternion.multiply(scaled, quaternion.conjugate(slow)), bent)
    before = space.clip.rotations[:, space.whole]
    vectors = quaternion.log(quaternion.multiply(quaternion.conjugate(before), turned))
    return np.asarray(np.degrees(vectors).reshape(len(before), -1))


def _list_gains(gains: object) -> FloatArray:
    expected = f"a list of decibels, one for each band, at most {_MOST_GAINS}"
    listed = as_numbers(gains, "gains", expected=expected)
    if listed.ndim != 1 or len(listed) > _MOST_GAINS:
        raise refuse(gains, "gains", expected)
    return listed


def _to_factor(gain: object) -> float:
    decibels = as_number(
        gain,
        "gain",
        expected=f"decibels: a number up to {_LARGEST_GAIN:g}, or -inf to mute",
        least=-math.inf,
        most=_LARGEST_GAIN,
    )
    return float(10.0 ** (decibels / 20.0))


def _check_frequencies(frequencies: object) -> tuple[float, float]:
    """Give the lower and the upper frequency, the upper one perhaps infinite."""
    expected = "a lower and an upper one in Hz"
    pair = as_numbers(frequencies, "frequencies of the filter", expected=expected)
    if pair.shape != (2,):
        raise refuse(frequencies, "frequencies of the filter", expected)
    low = as_number(float(pair[0]), "frequency of the filter", expected="0 Hz or more", least=0.0, unit="Hz")
    _check_frequency(float(pair[1]), above=low)
    return low, float(pair[1])


def _check_frequency(frequency: object, *, above: float) -> None:
    as_number(
        frequency,
        "frequency of the filter",
        expected=f"above {above:g} Hz",
        least=math.nextafter(above, math.inf),
        most=math.inf,
        unit="Hz",
    )


def _check_order(order: object) -> None:
    as_whole_number(order, "order of the filter", least=1, most=_LARGEST_ORDER, expected=f"1 to {_LARGEST_ORDER}")


def _lowpass(curves: FloatArray, cutoff: float, order: int) -> FloatArray:
    """Filter columns [F, C]; the cut-off is in cycles per frame, below one half."""
    from scipy.fft import dst, idst  # noqa: PLC0415  (slow to import, seldom used)

    last = len(curves) - 1
    if last < 1:
        return curves
    line = curves[0] + (curves[-1] - curves[0]) * (np.arange(last + 1) / last)[:, None]
    out = np.array(line)
    if last > 1:
        # Between ends that are 0, sines that fit into the clip are the frequencies of its endless point reflection.
        warped = np.tan(0.5 * np.pi * np.arange(1, last) / last) / max(np.tan(np.pi * cutoff), _SLOWEST)
        response = 1.0 / (1.0 + np.exp(np.minimum(2.0 * order * np.log(warped), _LARGEST_EXPONENT)))
        rest = dst((curves - line)[1:-1], type=1, axis=0)
        out[1:-1] += idst(response[:, None] * rest, type=1, axis=0)
    out[-1] = curves[-1]
    return out
