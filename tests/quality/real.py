"""The benchmark's folds and what the method makes of them, computed once per session, and what the laws are about.

What a law is checked against is rebuilt here from the takes and the fragment table, with scipy, not with the package.
"""

from functools import cache
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import get_window
from scipy.spatial.transform import Rotation

from tests.benchmarks.quality.cases import Case, Fold, load_folds
from tests.benchmarks.quality.metrics import joint_indices
from tests.benchmarks.quality.settings import SETTINGS, run_method


@cache
def case_folds(case: Case, data_dir: Path) -> tuple[Fold, ...]:
    """Every fold of a case."""
    return tuple(load_folds(case, data_dir))


@cache
def case_results(case: Case, data_dir: Path, setting: str, textured: bool = False):
    """Folds of a case, each with its result; with the legs textured too if asked."""
    extra = {"texture": case.rig.legs} if textured else {}
    return tuple((fold, run_method(fold, **SETTINGS[setting], **extra)) for fold in case_folds(case, data_dir))


def copied_joints(result):
    """Indices of the joints copied whole, in the order of the result's columns."""
    return [result.sketch.joints.index(joint) for joint in result.mean_rotations]


def angles(rotations):
    """Angle in degrees from each frame to the next, [F, J, 4] to [F - 1, J]."""
    return between(rotations[:-1], rotations[1:])


def between(a, b):
    """Angle in degrees between rotations of the same shape [..., 4]."""
    turn = _rotation(a).inv() * _rotation(b)
    return np.degrees(turn.magnitude()).reshape(a.shape[:-1])


def _rotation(q):
    return Rotation.from_quat(np.reshape(q, (-1, 4)), scalar_first=True)


def joined_rotations(result, variant):
    """The joined path as rotations, from its columns and the reported means, [F, W, 4]."""
    means = np.stack(list(result.mean_rotations.values()))
    vectors = np.radians(variant.joined[:, : 3 * len(means)]).reshape(-1, 3)
    turned = _rotation(np.tile(means, (len(variant.joined), 1))) * Rotation.from_rotvec(vectors)
    return turned.as_quat(scalar_first=True).reshape(len(variant.joined), -1, 4)


def vectors_about(means, rotations):
    """Rotation vectors about means [W, 4] in degrees, the turn nearest none, [F, W, 4] to [F, W, 3]."""
    relative = _rotation(np.tile(means, (len(rotations), 1))).inv() * _rotation(rotations)
    return np.degrees(relative.as_rotvec()).reshape(*rotations.shape[:-1], 3)


def stretched_fragments(fold, result, variant):
    """The fragments of a variant as they were before joining, one [n, W, 4] per sketch fragment."""
    takes = {take.name: take for take in fold.takes}
    names = [joint.rpartition("/")[2] for joint in result.mean_rotations]
    pieces = []
    for used in variant.fragments:
        take = takes[used.take]
        rotations = take.rotations[:, joint_indices(take, names)]
        pieces.append(_stretch(rotations, used.take_start, used.take_end, round(used.end - used.start) + 1))
    return pieces


def _stretch(rotations, first, last, frames):
    """Cubic stretch of unit quaternions; low-passed first where it compresses."""
    step = (last - first) / (frames - 1)
    flat = rotations.reshape(len(rotations), -1)
    if step > 1.0:
        reach = int(np.ceil(4.0 * step))
        sinc = np.sinc(np.arange(-reach, reach + 1) / step) * get_window(("kaiser", 5.0), 2 * reach + 1, fftbins=False)
        padded = np.pad(flat, ((reach, reach), (0, 0)), mode="reflect", reflect_type="odd")
        flat = np.stack([np.convolve(column, sinc / sinc.sum(), mode="valid") for column in padded.T], axis=1)
    times = np.linspace(first, last, frames)
    values = CubicSpline(np.arange(len(flat)), flat)(times) if step != 1.0 else flat[times.astype(int)]
    stretched = values.reshape(frames, -1, 4)
    return stretched / np.linalg.norm(stretched, axis=-1, keepdims=True)


def turn_limits(pieces):
    """What ALGORITHM allows near joins, degrees per frame, for every step of the whole, [F - 1, W].

    1.2 times the fastest turn of the stretched fragment plus half the gaps at its two joins spread over its frames.
    """
    none = np.zeros((1, pieces[0].shape[1]))
    ends, begins = np.stack([p[-1] for p in pieces[:-1]]), np.stack([p[0] for p in pieces[1:]])
    gaps = np.concatenate([none, between(ends, begins), none])
    limits = []
    for number, piece in enumerate(pieces):
        steps = len(piece) - 1
        spread = 0.5 * (gaps[number] + gaps[number + 1]) / steps
        limits.append(np.tile(1.2 * (angles(piece).max(axis=0) + spread), (steps, 1)))
    return np.concatenate(limits)
