"""Key reduction to cubic curves (Gleicher 2000, section 1.5).

What it does to contacts: a foot that stands still moves within the tolerance; where that shows, give the frames where
it lands and lifts as `contact_frames`: there all channels have keys with the exact values.
"""

from collections.abc import Sequence

from mtex_usd.edit.curve_space import select_channels
from mtex_usd.edit.keys.curves import ReducedKeys
from mtex_usd.edit.keys.job import Job, fit_count, fit_tolerance
from mtex_usd.edit.keys.outliers import bridge_outliers, find_outliers
from mtex_usd.edit.keys.request import OUTLIER, check_contact_frames, check_tolerance, list_outliers
from mtex_usd.motion.clip import Clip

__all__ = ["reduce_keys"]


def reduce_keys(
    clip: Clip,
    *,
    tolerance_deg: float = 0.5,
    tolerance_m: float = 0.005,
    key_count: int | None = None,
    channels: Sequence[str] = (),
    contact_frames: Sequence[int] = (),
    robust: bool = False,
) -> ReducedKeys:
    """Find cubic curves with few keys that play like a clip.

    Parameters
    ----------
    clip
        The clip.
    tolerance_deg
        Largest angle between a joint's rotation and the original's, degrees.
    tolerance_m
        Largest distance of a joint, and so of every end effector, from its original place in skeleton space, metres.
    key_count
        In place of tolerances: so many keys for every channel that moves, at the frames where its largest error is
        smallest.
    channels
        Channel tokens as in recipes; none means the rotations of all joints and the translations of those that move.
    contact_frames
        Frames, counted from 0, that are keys of every channel that moves, with the exact values; so are the first and
        the last frame.
    robust
        Leave out rotations that stand out by themselves by more than three times the tolerance.

    Returns
    -------
    ReducedKeys
        The curves, and what they differ from the clip by. Channels that do not move have one key.

    Raises
    ------
    InputError
        For unknown channels, frames outside the clip, tolerances that are not above 0, or too few keys.

    Notes
    -----
    Curves are fitted by least squares to the motion as UsdSkel plays it, half frames included. Keys are added to the
    channels that are to blame for what is outside the tolerance, then taken away and put elsewhere as long as that
    saves some: few keys, not provably the fewest.

    Examples
    --------
    >>> reduced = reduce_keys(take, tolerance_deg=0.5, tolerance_m=0.005)  # doctest: +SKIP
    >>> reduced.key_count, reduced.evaluate().rate  # doctest: +SKIP
    """
    tolerance = check_tolerance(tolerance_deg, tolerance_m)
    frames = check_contact_frames(clip, contact_frames, key_count)
    chosen = select_channels(clip, channels)
    outliers = find_outliers(clip, least_degrees=OUTLIER * tolerance_deg) if robust else None
    wanted = clip if outliers is None else bridge_outliers(clip, outliers)
    job = Job(wanted, chosen, frames)
    outcome = fit_tolerance(job, tolerance) if key_count is None else fit_count(job, key_count)
    return ReducedKeys(
        base=clip,
        curves=outcome.curves,
        orders={clip.joints[joint]: order for joint, order in job.samples.orders.items()},
        tolerance=tolerance if key_count is None else None,
        max_degrees=float(outcome.degrees.max()),
        max_metres=float(outcome.metres.max()),
        discarded=list_outliers(clip, outliers),
    )
