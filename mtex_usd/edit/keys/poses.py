"""Key reduction to sparse poses: few frames with all joints, so that what UsdSkel plays between them fits.

What it does to contacts: as for curves, a standing foot moves within the tolerance; `contact_frames` are kept exactly.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.curve_space import select_channels
from mtex_usd.edit.keys.outliers import bridge_outliers, find_outliers
from mtex_usd.edit.keys.pose_fitting import Poses, PoseSearch, play_poses
from mtex_usd.edit.keys.request import OUTLIER, check_contact_frames, check_tolerance, list_outliers
from mtex_usd.edit.keys.tolerance import Tolerance
from mtex_usd.motion.clip import Clip

__all__ = ["ReducedPoses", "reduce_poses"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]


@dataclass(frozen=True, eq=False, kw_only=True)
class ReducedPoses:
    """A motion by N poses.

    Parameters
    ----------
    base
        The clip that was reduced.
    frames
        Where in the clip the poses are, counted from 0, shape [N].
    rotations, translations, scales
        The poses, shapes [N, J, 4], [N, J, 3] and [N, J, 3].
    tolerance
        What was asked for; None where a number of poses was.
    max_degrees, max_metres
        Largest difference from the clip, both as UsdSkel plays them, of a joint's rotation and of a joint's place, at
        frames and three times between each two; of the joints that count.
    discarded
        Joint paths and frames that were taken for outliers; the differences are measured without them.
    """

    base: Clip
    frames: IntArray
    rotations: FloatArray
    translations: FloatArray
    scales: FloatArray
    tolerance: Tolerance | None
    max_degrees: float
    max_metres: float
    discarded: tuple[tuple[str, int], ...] = ()

    @property
    def key_count(self) -> int:
        """How many poses there are."""
        return len(self.frames)

    @property
    def time_codes(self) -> FloatArray:
        """Time codes of the poses, shape [N]."""
        return self.base.time_codes[self.frames]

    def evaluate(self, *, per_frame: int = 1) -> Clip:
        """Play the poses, as UsdSkel does: the shortest slerp, translations and scales on lines.

        Parameters
        ----------
        per_frame
            Frames of the result to each frame of the clip that was reduced.
        """
        poses = Poses(self.frames, self.rotations, self.translations, self.scales)
        return play_poses(poses, self.base, per_frame)


def reduce_poses(
    clip: Clip,
    *,
    tolerance_deg: float = 0.5,
    tolerance_m: float = 0.005,
    key_count: int | None = None,
    channels: Sequence[str] = (),
    contact_frames: Sequence[int] = (),
    robust: bool = False,
) -> ReducedPoses:
    """Find few poses that, played by UsdSkel, look like a clip.

    Parameters
    ----------
    clip
        The clip.
    tolerance_deg
        Largest angle between a joint's rotation and the original's, degrees.
    tolerance_m
        Largest distance of a joint, and so of every end effector, from its original place in skeleton space, metres.
    key_count
        In place of tolerances: at most so many frames, with both kinds of error as small as that allows; the
        tolerances then only say how many degrees weigh as much as how many metres.
    channels
        Joints that have to stay within the tolerances, as channel tokens; none means all. One joint that shakes makes
        keys for all, so leave out those that carry nothing. Left out, they are still fitted as well as the keys allow.
    contact_frames
        Frames, counted from 0, that are kept as they are; so are the first and the last frame.
    robust
        Leave out rotations that stand out by themselves by more than three times the tolerance.

    Returns
    -------
    ReducedPoses
        The poses, and what they differ from the clip by when played.

    Raises
    ------
    InputError
        For frames outside the clip, tolerances that are not above 0, or too few keys.

    Notes
    -----
    Poses are fitted so that the largest error is small, so they need not be the clip's at those frames. Which frames
    are keys is a shortest path through stretches that one slerp can follow, sought again with what the fit has shown;
    within 1 to 6 % of the fewest that any method needs on captured walks. All in all some milliseconds a frame.

    Examples
    --------
    >>> reduced = reduce_poses(take, tolerance_deg=0.5, tolerance_m=0.005)  # doctest: +SKIP
    >>> reduced.frames, reduced.evaluate().rate  # doctest: +SKIP
    """
    tolerance = check_tolerance(tolerance_deg, tolerance_m)
    fixed = check_contact_frames(clip, contact_frames, key_count)
    outliers = find_outliers(clip, least_degrees=OUTLIER * tolerance_deg) if robust else None
    wanted = clip if outliers is None else bridge_outliers(clip, outliers)
    joints = np.array(sorted({channel.joint for channel in select_channels(clip, channels)}), dtype=np.intp)
    search = PoseSearch(wanted, tolerance, fixed, joints)
    poses = search.reduce() if key_count is None else search.fit_count(key_count)
    degrees, metres = search.measure(poses)
    return ReducedPoses(
        base=clip,
        frames=poses.frames,
        rotations=poses.rotations,
        translations=poses.translations,
        scales=poses.scales,
        tolerance=tolerance if key_count is None else None,
        max_degrees=float(degrees.max()),
        max_metres=float(metres.max()),
        discarded=list_outliers(clip, outliers),
    )
