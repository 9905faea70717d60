"""What anyone would try first: the mean pose, the nearest frame, and a linear regression.

All three see the match channels only, as the method does: Euler angles in degrees, and their change per frame or a
window of frames.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import resolve_channels, unrolled_angles
from mtex_usd.motion.clip import Clip
from tests.benchmarks.quality.cases import Fold
from tests.benchmarks.quality.metrics import joint_indices, pose_vectors

__all__ = ["BASELINES", "hold_mean_pose", "regress_pose", "repeat_nearest_frame", "ridge"]

FloatArray = npt.NDArray[np.float64]

_ORDER = "ZYX"  # the captures' own
_WINDOW = 5
_ALPHAS = np.logspace(-2, 6, 17)


def _match_curves(fold: Fold, clip: Clip) -> FloatArray:
    channels = resolve_channels(fold.case.match, clip.joints, source="match")
    return np.stack([unrolled_angles(clip.rotations[:, c.joint], _ORDER)[:, c.axis] for c in channels], axis=1)


def _with_rotations(fold: Fold, rotations: FloatArray) -> Clip:
    """The sketch with its synthesized joints filled in; rotations [F, J', 4]."""
    filled = np.array(fold.sketch.rotations)
    filled[:, joint_indices(fold.sketch, fold.case.rig.synthesized)] = rotations
    return replace(fold.sketch, rotations=quaternion.unroll(filled))


def _taken_rotations(fold: Fold) -> list[FloatArray]:
    return [take.rotations[:, joint_indices(take, fold.case.rig.synthesized)] for take in fold.takes]


def _taken_mean(fold: Fold) -> FloatArray:
    return quaternion.mean(np.concatenate(_taken_rotations(fold)))


def hold_mean_pose(fold: Fold) -> Clip:
    """The mean pose of the takes, at every frame."""
    mean = _taken_mean(fold)
    return _with_rotations(fold, np.broadcast_to(mean, (fold.sketch.frame_count, *mean.shape)))


def repeat_nearest_frame(fold: Fold) -> Clip:
    """At each frame the pose of the take frame whose match channels and their slopes are nearest."""
    pool = np.concatenate([_frame_features(fold, take) for take in fold.takes])
    wanted = _frame_features(fold, fold.sketch)
    squares = np.square(wanted).sum(axis=1)[:, None] + np.square(pool).sum(axis=1) - 2.0 * wanted @ pool.T
    return _with_rotations(fold, np.concatenate(_taken_rotations(fold))[squares.argmin(axis=1)])


def _frame_features(fold: Fold, clip: Clip) -> FloatArray:
    curves = _match_curves(fold, clip)
    return np.concatenate([curves, np.gradient(curves, axis=0)], axis=1)


def regress_pose(fold: Fold) -> Clip:
    """Ridge regression of the pose on the match channels of the eleven frames around.

    The penalty is the one that leaves the least error when each take in turn is predicted from the others.
    """
    inputs = [_windows(_match_curves(fold, take)) for take in fold.takes]
    means = _taken_mean(fold)
    synthesized = fold.case.rig.synthesized
    outputs = [pose_vectors(take, joint_indices(take, synthesized), means) for take in fold.takes]
    alpha = _choose_alpha(inputs, outputs)
    wanted = _windows(_match_curves(fold, fold.sketch))
    predicted = ridge(np.concatenate(inputs), np.concatenate(outputs), wanted, alpha)
    turns = quaternion.exp(np.radians(predicted).reshape(len(predicted), -1, 3))
    return _with_rotations(fold, quaternion.multiply(means, turns))


def _windows(curves: FloatArray) -> FloatArray:
    """Each frame with its neighbours, the ends repeated; [F, M] to [F, 11 M]."""
    padded = np.pad(curves, ((_WINDOW, _WINDOW), (0, 0)), mode="edge")
    shifted = [padded[shift : shift + len(curves)] for shift in range(2 * _WINDOW + 1)]
    return np.concatenate(shifted, axis=1)


def ridge(inputs: FloatArray, outputs: FloatArray, wanted: FloatArray, alpha: float) -> FloatArray:
    """Predict outputs for wanted inputs, [N, M] and [N, C] to [N', C]; inputs are scaled to unit deviation."""
    centre, spread = inputs.mean(axis=0), inputs.std(axis=0)
    scaled = (inputs - centre) / spread
    level = outputs.mean(axis=0)
    weights = np.linalg.solve(scaled.T @ scaled + alpha * np.eye(scaled.shape[1]), scaled.T @ (outputs - level))
    return np.asarray((wanted - centre) / spread @ weights + level)


def _choose_alpha(inputs: Sequence[FloatArray], outputs: Sequence[FloatArray]) -> float:
    errors = np.zeros(len(_ALPHAS))
    for left_out in range(len(inputs)):
        others = [i for i in range(len(inputs)) if i != left_out]
        known = np.concatenate([inputs[i] for i in others]), np.concatenate([outputs[i] for i in others])
        for number, alpha in enumerate(_ALPHAS):
            missed = ridge(*known, inputs[left_out], alpha) - outputs[left_out]
            errors[number] += np.square(missed).sum()
    return float(_ALPHAS[errors.argmin()])


BASELINES = {"mean pose": hold_mean_pose, "nearest frame": repeat_nearest_frame, "ridge ±5 frames": regress_pose}
