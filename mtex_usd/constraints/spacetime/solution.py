"""What a solve gives."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from mtex_usd.constraints.spacetime.character import Character
from mtex_usd.constraints.spacetime.memory import Memory
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import FloatArray

__all__ = ["Displacement", "Solution", "make_solution", "measure_energy_above"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Displacement:
    """The change of one clip.

    Parameters
    ----------
    rotations
        Rotation vectors d of R = R0 exp(d), radians, [F, J, 3]; zero where a joint keeps its motion.
    translation
        Change of the root joint's translation, skeleton units, [F, 3].
    root
        The joint whose translation changes; -1 where none may.
    """

    rotations: FloatArray
    translation: FloatArray
    root: int


@dataclass(frozen=True, eq=False, kw_only=True)
class Solution:
    """A motion that meets its constraints.

    Parameters
    ----------
    clips
        The changed motion, one clip per character.
    displacements
        What was changed.
    knots
        Break points of the displacement's spline, frames, [S + 1].
    iterations
        Steps of the search.
    step
        Largest change of any channel in the last step, radians or reaches of the character.
    residuals
        Largest violation of each constraint by name, metres or radians.
    places
        Where the points that keep still do so, by the constraint's name, skeleton units, [3].
    memory
        What :func:`resolve_near` goes on from.
    """

    clips: tuple[Clip, ...]
    displacements: tuple[Displacement, ...]
    knots: FloatArray
    iterations: int
    step: float
    residuals: Mapping[str, float]
    places: Mapping[str, FloatArray]
    memory: Memory = field(repr=False)


def measure_energy_above(displacement: Displacement, rate: float, frequency: float) -> float:
    """Measure what share of a displacement's energy is at higher frequencies.

    Parameters
    ----------
    displacement
        The change of one clip.
    rate
        Frames per second.
    frequency
        Hz.

    Returns
    -------
    float
        Of the squares of all rotation vectors; 0 where nothing turns.

    Notes
    -----
    By the cosine transform, which continues a curve as in a mirror: the Fourier transform would count the step from the
    last frame to the first.
    """
    from scipy.fft import dct  # noqa: PLC0415  (slow to import, seldom used)

    curves = displacement.rotations.reshape(len(displacement.rotations), -1)
    energy = np.square(dct(curves, axis=0, norm="ortho")).sum(axis=1)
    above = 0.5 * rate * np.arange(len(curves)) / len(curves) > frequency
    total = float(energy.sum())
    return float(energy[above].sum()) / total if total > 0.0 else 0.0


def make_solution(memory: Memory, residuals: Mapping[str, float], *, iterations: int, step: float) -> Solution:
    """Apply the whole spline to the clips."""
    changes = np.asarray(memory.knots.matrix @ memory.coefficients)
    changed = [_displace(character, changes) for character in memory.cast.characters]
    unit = memory.clips[0].skeleton.meters_per_unit
    return Solution(
        clips=tuple(clip for clip, _ in changed),
        displacements=tuple(displacement for _, displacement in changed),
        knots=memory.knots.breaks,
        iterations=iterations,
        step=step,
        residuals=residuals,
        places={name: place / unit for name, place in memory.places.items()},
        memory=memory,
    )


def _displace(character: Character, changes: FloatArray) -> tuple[Clip, Displacement]:
    """Apply channels at all frames [F, C] to a character's clip; what does not change keeps its bits."""
    clip = character.clip
    vectors, moves = np.zeros((*clip.rotations.shape[:2], 3)), np.zeros((clip.frame_count, 3))
    turning = np.array(character.turning, dtype=np.intp)
    columns = slice(character.first_column, character.first_column + 3 * len(turning))
    vectors[:, turning] = changes[:, columns].reshape(len(changes), len(turning), 3)
    rotations, translations = np.array(clip.rotations), np.array(clip.translations)
    turned = vectors.any(axis=2)
    rotations[turned] = quaternion.multiply(rotations[turned], quaternion.exp(vectors[turned]))
    if character.root >= 0:
        moves = changes[:, character.translation_columns] / clip.skeleton.meters_per_unit
        translations[:, character.root] += moves
    changed = replace(clip, rotations=rotations, translations=translations)
    return changed, Displacement(rotations=vectors, translation=moves, root=character.root)
