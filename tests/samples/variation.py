"""Seeded variation: smooth 1/f noise and band-limited detail, as sums of cosines with random phases.

Only the raw 64-bit stream of PCG64 is used, which numpy keeps stable over versions; its distributions are not.
"""

import numpy as np
import numpy.typing as npt

__all__ = ["cosine_sum", "detail", "fractal", "uniforms"]

FloatArray = npt.NDArray[np.float64]


def uniforms(seed: int, count: int) -> FloatArray:
    """Draw numbers in [0, 1), shape [count]."""
    raw = np.random.PCG64(seed).random_raw(count)
    return np.asarray(raw >> np.uint64(11), dtype=np.float64) * 2.0**-53


def cosine_sum(position: FloatArray, frequencies: FloatArray, *, slope: float, seed: int) -> FloatArray:
    """Sum cosines of amplitude f**-slope and random phase, scaled to unit standard deviation over a long time.

    Parameters
    ----------
    position
        Where to evaluate, shape [F]: seconds for frequencies in Hz, strides for cycles per stride.
    frequencies
        Shape [N].
    """
    amplitudes = frequencies**-slope
    phases = uniforms(seed, len(frequencies))
    waves = np.cos(2.0 * np.pi * (np.outer(position, frequencies) + phases))
    return waves @ amplitudes / np.sqrt(np.sum(amplitudes**2) / 2.0)


def fractal(stride: FloatArray, seed: int) -> FloatArray:
    """Noise over strides with a 1/f power spectrum, slower than one cycle in two strides (Hausdorff et al. 1995)."""
    return cosine_sum(stride, np.arange(1.0, 9.0) / 16.0, slope=0.5, seed=seed)


def detail(time_s: FloatArray, seed: int) -> FloatArray:
    """Small motion between 2 and 6 Hz with a 1/f amplitude spectrum (assumed)."""
    offsets = uniforms(seed + 1, 20)
    return cosine_sum(time_s, 2.0 + 4.0 * (np.arange(20) + offsets) / 20.0, slope=1.0, seed=seed)
