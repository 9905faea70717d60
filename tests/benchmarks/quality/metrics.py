"""How near a result is to the truth, how smooth, how lively and how varied.

Everything looks at the synthesized joints only. "Vectors" are rotation vectors in degrees about the truth's mean pose,
unrolled in time; energies are about the takes' mean pose, the same for results and takes.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
import numpy.typing as npt

from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.review import numbers
from mtex_usd.review.numbers import band_energy, third_difference
from mtex_usd.texture.pyramid import decompose
from tests.benchmarks.quality.cases import METERS_PER_UNIT, Fold

__all__ = [
    "Scores",
    "angular_error",
    "band_energy",
    "combine_scores",
    "detail_ratio",
    "joint_indices",
    "largest_turn",
    "npss",
    "pose_vectors",
    "position_error",
    "put_on_truth",
    "remove_top_band",
    "score_variants",
    "third_difference",
    "variant_distance",
]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

DETAIL_BANDS = (2, 3)


@dataclass(frozen=True)
class Scores:
    """All metrics of one method on one clip, or on a case.

    Parameters
    ----------
    error
        Mean distance of head, elbows and hands from the truth, metres.
    angle
        Mean angle from the truth, degrees.
    npss
        Difference of the normalised power spectra, 0 is equal.
    jerk
        Third difference relative to that of the truth without band 1.
    detail
        Energy in bands 2 and 3 relative to the takes'.
    spread
        Mean pairwise distance of the variants, metres; nan where there is one.
    turn
        Largest turn in a single frame, degrees.
    """

    error: float
    angle: float
    npss: float
    jerk: float
    detail: float
    spread: float
    turn: float


def joint_indices(clip: Clip, last_names: Sequence[str]) -> IntArray:
    """Find joints by last name, in the order given."""
    names = [joint.rpartition("/")[2] for joint in clip.joints]
    return np.array([names.index(name) for name in last_names], dtype=np.intp)


def put_on_truth(fold: Fold, result: Clip) -> Clip:
    """Put the result's synthesized joints onto the truth's root, hips and legs."""
    joints = joint_indices(fold.truth, fold.case.rig.synthesized)
    rotations = np.array(fold.truth.rotations)
    rotations[:, joints] = result.rotations[:, joints]
    return replace(fold.truth, rotations=rotations)


def _measured_positions(fold: Fold, clip: Clip) -> FloatArray:
    positions, _ = clip.skeleton.world_pose(clip.rotations, clip.translations)
    return np.asarray(METERS_PER_UNIT * positions[:, joint_indices(clip, fold.case.rig.measured)])


def _mean_distance(fold: Fold, a: Clip, b: Clip) -> float:
    apart = _measured_positions(fold, put_on_truth(fold, a)) - _measured_positions(fold, put_on_truth(fold, b))
    return float(np.linalg.norm(apart, axis=-1).mean())


def position_error(fold: Fold, result: Clip) -> float:
    """Mean distance of the measured joints from the truth in metres, over joints, then frames."""
    return _mean_distance(fold, result, fold.truth)


def variant_distance(fold: Fold, variants: Sequence[Clip]) -> float:
    """Mean distance of the measured joints over all pairs of variants, metres; nan for fewer than two."""
    pairs = list(itertools.combinations(variants, 2))
    return float(np.mean([_mean_distance(fold, a, b) for a, b in pairs])) if pairs else float("nan")


def angular_error(fold: Fold, result: Clip) -> float:
    """Mean angle between result and truth, degrees, over frames and synthesized joints."""
    joints = joint_indices(fold.truth, fold.case.rig.synthesized)
    angles = quaternion.angle_between(fold.truth.rotations[:, joints], result.rotations[:, joints])
    return float(np.degrees(angles).mean())


def largest_turn(fold: Fold, result: Clip) -> float:
    """Largest turn of a synthesized joint from one frame to the next, degrees."""
    joints = joint_indices(fold.truth, fold.case.rig.synthesized)
    return numbers.largest_turn(result.rotations[:, joints])


def pose_vectors(clip: Clip, joints: IntArray, means: FloatArray) -> FloatArray:
    """Rotation vectors about given mean rotations [J', 4], degrees, shape [F, J' * 3]."""
    relative = quaternion.multiply(quaternion.conjugate(means), clip.rotations[:, joints])
    vectors = quaternion.unroll_vectors(quaternion.log(relative))
    return np.degrees(vectors).reshape(clip.frame_count, -1)


def _about_truth(fold: Fold, clip: Clip) -> FloatArray:
    joints = joint_indices(fold.truth, fold.case.rig.synthesized)
    return pose_vectors(clip, joints, quaternion.mean(fold.truth.rotations[:, joints]))


def npss(truth: FloatArray, result: FloatArray) -> float:
    """Normalised power spectrum similarity of two sets of curves [F, C] (Gopalakrishnan et al. 2019, section 3.3).

    Per curve, the area between the cumulated power spectra, each scaled to sum to 1; the mean over curves is weighted
    by the truth's power. Unlike the original the area is a mean over frequencies and not their sum, so that clips of
    different lengths compare.
    """
    true_power, power = (np.square(np.abs(np.fft.fft(curves, axis=0))) for curves in (truth, result))
    shares = [p / np.maximum(p.sum(axis=0), np.finfo(float).tiny) for p in (true_power, power)]
    areas = np.abs(np.cumsum(shares[0], axis=0) - np.cumsum(shares[1], axis=0)).mean(axis=0)
    weights = true_power.sum(axis=0)
    return float(areas @ weights / weights.sum())


def detail_ratio(fold: Fold, result: Clip) -> float:
    """Energy of a result in bands 2 and 3 relative to the takes', every frame of a take counting alike."""
    names = fold.case.rig.synthesized
    taken = [take.rotations[:, joint_indices(take, names)] for take in fold.takes]
    means = quaternion.mean(np.concatenate(taken))
    energies = [
        band_energy(pose_vectors(take, joint_indices(take, names), means), *DETAIL_BANDS) for take in fold.takes
    ]
    usual = np.average(energies, weights=[take.frame_count for take in fold.takes])
    vectors = pose_vectors(result, joint_indices(result, names), means)
    return float(band_energy(vectors, *DETAIL_BANDS) / usual)


def remove_top_band(fold: Fold) -> Clip:
    """The truth without band 1 of its synthesized joints: what a perfect result of the method would be."""
    joints = joint_indices(fold.truth, fold.case.rig.synthesized)
    means = quaternion.mean(fold.truth.rotations[:, joints])
    smooth = decompose(pose_vectors(fold.truth, joints, means)).at_or_below(2)
    rotations = np.array(fold.truth.rotations)
    turns = quaternion.exp(np.radians(smooth).reshape(len(smooth), -1, 3))
    rotations[:, joints] = quaternion.multiply(means, turns)
    return replace(fold.truth, rotations=quaternion.unroll(rotations))


def _synthesized_jerk(fold: Fold, clip: Clip) -> float:
    return third_difference(clip.rotations[:, joint_indices(clip, fold.case.rig.synthesized)])


def score_variants(fold: Fold, variants: Sequence[Clip]) -> Scores:
    """Measure the first of some variants against the truth, and all against each other."""
    best = variants[0]
    truth, result = _about_truth(fold, fold.truth), _about_truth(fold, best)
    return Scores(
        error=position_error(fold, best),
        angle=angular_error(fold, best),
        npss=npss(truth, result),
        jerk=_synthesized_jerk(fold, best) / _synthesized_jerk(fold, remove_top_band(fold)),
        detail=detail_ratio(fold, best),
        spread=variant_distance(fold, variants),
        turn=largest_turn(fold, best),
    )


def combine_scores(scores: Sequence[Scores]) -> Scores:
    """Mean over clips; of the turn the largest."""
    means = {field.name: float(np.mean([getattr(s, field.name) for s in scores])) for field in fields(Scores)}
    return replace(Scores(**means), turn=max(s.turn for s in scores))
