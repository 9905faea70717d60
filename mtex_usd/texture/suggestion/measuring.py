"""How near a trial's result is to the truth, and how smooth."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.texture.pyramid import decompose
from mtex_usd.texture.suggestion.trials import Trial

__all__ = ["Ends", "Measure", "Score", "combine_scores"]

FloatArray = npt.NDArray[np.float64]

# What being twice as rough, or half as lively, as the truth counts beside the error.
_SMOOTHNESS_WEIGHT = 0.05
_SMOOTHNESS_RANGE = (1.0 / 16.0, 16.0)


@dataclass(frozen=True)
class Score:
    """How well takes that were held out were found again.

    Parameters
    ----------
    error
        Mean distance of the ends of the bones that were filled in from where the truth has them, metres.
    smoothness
        Third difference of the rotations relative to that of the truth without the bands that synthesis never gives: 1
        is as smooth as the truth, more is rougher, less calmer.
    """

    error: float
    smoothness: float

    @property
    def merit(self) -> float:
        """What choices are ranked by, metres: the error, and 5 % of it for every factor of 2 in smoothness."""
        apart = abs(float(np.log2(np.clip(self.smoothness, *_SMOOTHNESS_RANGE))))
        return self.error * (1.0 + _SMOOTHNESS_WEIGHT * apart)


def combine_scores(scores: Sequence[Score]) -> Score:
    """Give the mean over trials; of smoothness the geometric mean."""
    smoothness = np.clip([score.smoothness for score in scores], *_SMOOTHNESS_RANGE)
    return Score(float(np.mean([score.error for score in scores])), float(np.exp(np.log(smoothness).mean())))


@dataclass(frozen=True, eq=False)
class Ends:
    """The ends of bones: where a joint's children sit, or for one without, as far on as its own bone is long.

    Parameters
    ----------
    joints
        Joints whose turning is to be seen.
    carriers
        The joint each end is fixed to, length N.
    offsets
        Where the end is in that joint's space, stage units, shape [N, 3].
    """

    joints: tuple[int, ...]
    carriers: tuple[int, ...]
    offsets: FloatArray

    @classmethod
    def of_joints(cls, skeleton: Skeleton, joints: Sequence[int]) -> "Ends":
        """Find the ends of the bones of some joints."""
        children = {i: np.zeros(3) for i, parent in enumerate(skeleton.parents.tolist()) if parent in joints}
        back = quaternion.rotate(quaternion.conjugate(skeleton.rest_rotations), skeleton.rest_translations)
        tips = {joint: back[joint] for joint in joints if joint not in skeleton.parents}
        carriers = sorted({**children, **tips})
        return cls(tuple(joints), tuple(carriers), np.array([tips.get(carrier, np.zeros(3)) for carrier in carriers]))

    def place(self, clip: Clip, base: Clip) -> FloatArray:
        """Give where the ends get to when a clip's joints are put on another clip's, metres, shape [F, N, 3]."""
        rotations, translations = np.array(base.rotations), np.array(base.translations)
        rotations[:, self.joints] = clip.rotations[:, self.joints]
        translations[:, self.joints] = clip.translations[:, self.joints]
        positions, world = clip.skeleton.world_pose(rotations, translations)
        carriers = list(self.carriers)
        places = positions[:, carriers] + quaternion.rotate(world[:, carriers], self.offsets)
        return np.asarray(places * clip.skeleton.meters_per_unit)


@dataclass(frozen=True, eq=False)
class Measure:
    """What a trial's results are held against.

    Parameters
    ----------
    trial
        The trial.
    ends
        Of the joints that are filled in, or where there are none those that are textured.
    highest_band
        The highest band results can have.
    """

    trial: Trial
    ends: Ends
    highest_band: int

    @cached_property
    def _true_places(self) -> FloatArray:
        return self.ends.place(self.trial.truth, self.trial.truth)

    @cached_property
    def _true_jerk(self) -> float:
        """Of the truth without the bands that no result has."""
        rotations = self.trial.truth.rotations[:, self.ends.joints]
        means = quaternion.mean(rotations)
        vectors = quaternion.unroll_vectors(quaternion.log(quaternion.multiply(quaternion.conjugate(means), rotations)))
        smooth = decompose(vectors.reshape(len(vectors), -1)).at_or_below(self.highest_band)
        return _third_difference(quaternion.multiply(means, quaternion.exp(smooth.reshape(vectors.shape))))

    def score(self, result: Clip) -> Score:
        """Compare a result with the truth; what is not copied is the truth's in both."""
        error = float(np.linalg.norm(self.ends.place(result, self.trial.truth) - self._true_places, axis=-1).mean())
        jerk = _third_difference(result.rotations[:, self.ends.joints])
        return Score(error, jerk / max(self._true_jerk, float(np.finfo(np.float64).tiny)))


def _third_difference(rotations: FloatArray) -> float:
    """Root mean square of the third difference, radians per frame cubed; rotations [F, J, 4].

    The vectors of a difference are taken about the first of its four poses.
    """
    count = len(rotations) - 3
    start = quaternion.conjugate(rotations[:count])
    steps = [quaternion.log(quaternion.multiply(start, rotations[i : i + count])) for i in (1, 2, 3)]
    return float(np.sqrt(np.square(3.0 * steps[0] - 3.0 * steps[1] + steps[2]).mean()))
