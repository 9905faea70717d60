"""Normal walking as published: mean joint angles over one gait cycle, heel strike of the left foot at 0 %.

Degrees, every 5 % of the cycle from 0 to 95. The values are rounded normative means after the works named below,
written down from knowledge of their curves and not digitised from their pages: they have the published shape and size,
and are neither a study's exact table nor any single subject.

Sources
-------
hip
    Kadaba, Ramakrishnan & Wootten 1990, J. Orthop. Res. 8:383-392: against the pelvis, which leans forward 10 degrees.
knee, ankle
    Winter 1991, The Biomechanics and Motor Control of Human Gait, 2nd ed.: natural cadence.
pelvis_tilt, pelvis_obliquity, pelvis_rotation, hip_adduction
    Kadaba et al. 1990; Perry 1992, Gait Analysis. Tilt about its mean.
thorax_rotation
    Murray, Drought & Kory 1964, J. Bone Joint Surg. 46-A:335-360.
thorax_lean, thorax_tilt
    Thorstensson, Nilsson, Carlson & Zomlefer 1984, Acta Physiol. Scand. 121:9-22. About their means.
shoulder, elbow
    Murray, Sepic & Barnard 1967, Phys. Ther. 47:272-284: free speed.
head_pitch
    Hirasaki, Moore, Raphan & Cohen 1999, Exp. Brain Res. 127:117-130: the head pitches down as it rises.
"""

from functools import cache

import numpy as np
import numpy.typing as npt

__all__ = ["CLOSURE", "HARMONICS", "TABLES", "evaluate"]

FloatArray = npt.NDArray[np.float64]

HARMONICS = 8


def _mirrored(*half_cycle: float) -> tuple[float, ...]:
    """Complete a curve whose second half is the first for the other side: the opposite sign."""
    return half_cycle + tuple(-value for value in half_cycle)


# Positive: flexion, dorsiflexion, adduction, tilt and lean forward; of pelvis and thorax, the left side up or forward.
TABLES: dict[str, tuple[float, ...]] = {
    "hip": (35, 34, 31, 27.5, 22.5, 17.5, 12.5, 7.5, 2.5, -2, -5.5, -6.5, -2.5, 6, 16, 25, 31.5, 35.5, 37, 36.5),
    "knee": (5, 12, 18, 20, 19, 16, 12.5, 9.5, 7, 8, 12, 22, 39, 55, 64, 62, 50, 31, 13, 4),
    "ankle": (0, -4.5, -3.5, 0, 3, 5, 6.5, 8.5, 10.5, 10.5, 7, -4, -16.5, -19.5, -13, -6, -1.5, 0.5, 1, 0.5),
    "hip_adduction": (0, 3, 5, 6, 6, 5, 4.5, 4, 3.5, 3, 1, -2.5, -5.5, -6.5, -5.5, -4, -3, -2, -1.5, -1),
    "pelvis_tilt": (-0.7, -1, -0.8, -0.3, 0.3, 0.7, 1, 0.9, 0.3, -0.4) * 2,
    "pelvis_obliquity": _mirrored(0.5, 2.5, 4, 4.5, 4, 3, 2, 1.2, 0.6, 0),
    "pelvis_rotation": _mirrored(4.5, 5, 4.5, 3.5, 2.5, 1.5, 0.5, -0.8, -2.2, -3.5),
    "thorax_rotation": _mirrored(-3.3, -3.5, -3.4, -3, -2.3, -1.4, -0.4, 0.8, 1.8, 2.7),
    "thorax_lean": _mirrored(-0.3, 0.3, 0.9, 1.3, 1.5, 1.5, 1.3, 1.0, 0.6, 0.1),
    "thorax_tilt": (0.8, 1, 0.8, 0.3, -0.3, -0.8, -1, -0.8, -0.3, 0.3) * 2,
    "head_pitch": (-1.5, -1.7, -1.2, -0.4, 0.6, 1.4, 1.7, 1.3, 0.4, -0.6) * 2,
    "shoulder": (-20, -19.5, -18, -15, -11, -6, -1, 4, 7.5, 9.5, 10, 9.5, 8, 5, 1, -4, -9, -14, -17.5, -19.5),
    "elbow": (19, 17, 17, 18, 20, 23, 27, 32, 37, 41, 43, 43, 41, 38, 34, 30, 27, 24, 22, 20),
}


# What is added to the rounded means so that the three close: with them the hip of the sample's legs passes over the
# standing foot at nearly even speed and height, and the swinging toes clear the ground. Least squares over one cycle,
# where 14 cm/s, 0.35 cm of height or 0.5 cm of clearance weigh as much as 2.5 degrees at hip and knee and 1.6 at the
# ankle; rounded to half a degree. At most 6, 6.5 and 5 degrees.
CLOSURE: dict[str, tuple[float, ...]] = {
    "hip": (0, 1, 2.5, 2.5, 1.5, -0.5, -2.5, -4, -4.5, -4, -3.5, -2, -1, -1.5, 0, 4, 6, 5, 3, 1.5),
    "knee": (-0.5, 0.5, 2, 3.5, 3, 1, -0.5, -0.5, 0, 0.5, 1, 0, -1, 0.5, 3.5, 6, 6.5, 4, 1, 0),
    "ankle": (0.5, 0.5, 0.5, 0, 0, 0, 0, 1, 1.5, 2, 2.5, 5, 4, 0.5, 1, 3, 4.5, 3, 1, 1),
}


@cache
def _coefficients(name: str) -> tuple[FloatArray, FloatArray]:
    table = np.array(TABLES[name], dtype=np.float64) + np.array(CLOSURE.get(name, 0.0))
    angles = 2.0 * np.pi * np.outer(np.arange(HARMONICS + 1), np.arange(len(table))) / len(table)
    weights = np.full(HARMONICS + 1, 2.0 / len(table))
    weights[0] /= 2.0
    return weights * (np.cos(angles) @ table), weights * (np.sin(angles) @ table)


def evaluate(name: str, stride: FloatArray) -> FloatArray:
    """Evaluate a curve by its first harmonics, at positions in strides (whole: left heel strikes); any shape."""
    cosines, sines = _coefficients(name)
    angles = 2.0 * np.pi * np.asarray(stride)[..., None] * np.arange(HARMONICS + 1)
    return np.cos(angles) @ cosines + np.sin(angles) @ sines
