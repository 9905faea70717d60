"""Animation samplers of glTF evaluated at even times (glTF 2.0, appendix C)."""

from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from mtex_usd.formats.gltf_container import FloatArray, GltfFile

__all__ = ["GltfCurve", "read_curve"]

_INTERPOLATIONS = ("STEP", "LINEAR", "CUBICSPLINE")
_NEARLY_EQUAL = 0.9995  # cosine of half the turn above which slerp is a straight line to rounding
_SHORTEST = 1e-6


@dataclass(frozen=True, eq=False, kw_only=True)
class GltfCurve:
    """One animated property of a node.

    Parameters
    ----------
    times
        Of the keys, seconds, increasing, shape [K].
    values
        Of the keys, shape [K, W]; rotations real part last, as glTF has them.
    tangents_in, tangents_out
        Of the keys per second, shape [K, W]; None unless the curve is a CUBICSPLINE.
    steps
        Whether values hold until the next key.
    turns
        Whether the values are rotations.
    """

    times: FloatArray
    values: FloatArray
    tangents_in: FloatArray | None = None
    tangents_out: FloatArray | None = None
    steps: bool = False
    turns: bool = False

    def sample(self, times: FloatArray) -> FloatArray:
        """Evaluate the curve; it holds before the first and after the last key.

        Parameters
        ----------
        times
            Seconds, shape [F].

        Returns
        -------
        FloatArray
            Shape [F, W]; rotations of unit length.
        """
        right = np.searchsorted(self.times, times, side="right")
        left = np.clip(right - 1, 0, len(self.times) - 1)
        after = np.minimum(left + 1, len(self.times) - 1)
        if self.steps:
            return self._finish(self.values[left])
        span = self.times[after] - self.times[left]
        part = np.clip((times - self.times[left]) / np.where(span > 0.0, span, 1.0), 0.0, 1.0)[:, None]
        if self.tangents_in is not None and self.tangents_out is not None:
            out, into = span[:, None] * self.tangents_out[left], span[:, None] * self.tangents_in[after]
            return self._finish(_hermite(self.values[left], out, into, self.values[after], part))
        if self.turns:
            return self._finish(_slerp(self.values[left], self.values[after], part))
        return self.values[left] + part * (self.values[after] - self.values[left])

    def _finish(self, values: FloatArray) -> FloatArray:
        if not self.turns:
            return values
        length = np.linalg.norm(values, axis=-1, keepdims=True)
        return cast(FloatArray, values / np.maximum(length, _SHORTEST))


def _hermite(start: FloatArray, out: FloatArray, into: FloatArray, end: FloatArray, part: FloatArray) -> FloatArray:
    square, cube = part**2, part**3
    return (
        (2.0 * cube - 3.0 * square + 1.0) * start
        + (cube - 2.0 * square + part) * out
        + (3.0 * square - 2.0 * cube) * end
        + (cube - square) * into
    )


def _slerp(start: FloatArray, end: FloatArray, part: FloatArray) -> FloatArray:
    """Turn at even speed along the shorter way."""
    cosine = np.sum(start * end, axis=-1, keepdims=True)
    end = np.where(cosine < 0.0, -end, end)
    cosine = np.minimum(np.abs(cosine), 1.0)
    straight = cosine > _NEARLY_EQUAL
    angle = np.arccos(np.where(straight, 0.0, cosine))
    sine = np.sin(angle)
    first = np.where(straight, 1.0 - part, np.sin((1.0 - part) * angle) / sine)
    second = np.where(straight, part, np.sin(part * angle) / sine)
    return first * start + second * end


def read_curve(file: GltfFile, sampler: Any, *, width: int, what: str) -> GltfCurve:
    """Read a sampler.

    Parameters
    ----------
    file
        The file.
    sampler
        An animation sampler as pygltflib gives it.
    width
        3 for translations and scales, 4 for rotations.
    what
        What messages call it.

    Raises
    ------
    FormatError
        Where its times do not increase, times and values do not fit, or a rotation has no length.
    """
    interpolation = sampler.interpolation or "LINEAR"
    if interpolation not in _INTERPOLATIONS:
        raise file.error(f"{what}: unknown interpolation {str(interpolation)[:40]!r}")
    times = file.read_accessor(sampler.input, width=1)[:, 0]
    values = file.read_accessor(sampler.output, width=width)
    if not len(times):
        raise file.error(f"{what} has no keys")
    if np.any(np.diff(times) <= 0.0):
        raise file.error(f"{what}: the times of its keys do not increase")
    parts = 3 if interpolation == "CUBICSPLINE" else 1
    if len(values) != parts * len(times):
        raise file.error(f"{what} should have {parts * len(times)} values for {len(times)} times, found {len(values)}")
    tangents_in, values, tangents_out = _split_tangents(values) if parts == 3 else (None, values, None)
    return GltfCurve(
        times=times,
        values=_unit_keys(file, values, what) if width == 4 and parts == 1 else values,
        tangents_in=tangents_in,
        tangents_out=tangents_out,
        steps=interpolation == "STEP",
        turns=width == 4,
    )


def _split_tangents(values: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    return values[0::3], values[1::3], values[2::3]


def _unit_keys(file: GltfFile, values: FloatArray, what: str) -> FloatArray:
    """Bring rotations to unit length, which those stored as integers only come near to."""
    lengths = np.linalg.norm(values, axis=-1, keepdims=True)
    if np.any(lengths < _SHORTEST):
        raise file.error(f"{what}: a rotation has no length")
    return cast(FloatArray, values / lengths)
