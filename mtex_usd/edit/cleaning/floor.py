"""What goes through the floor: reported, not repaired, since only constraints can mend it without harm."""

import sys

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.cleaning.limbs import body_size
from mtex_usd.edit.cleaning.report import CleaningResult, Finding, list_runs
from mtex_usd.motion.arguments import as_clip_with_gaps, as_number
from mtex_usd.motion.clip import Clip

__all__ = ["report_floor"]


def report_floor(clip: Clip, *, height: float = 0.0, least_size: float = 0.005) -> CleaningResult:
    """Note every joint that is below the floor, with the frames and the depth of the worst run.

    Parameters
    ----------
    clip
        The clip, which is given back as it is.
    height
        Height of the floor along up, skeleton units.
    least_size
        Least depth that is noted, in sizes of the body.

    Returns
    -------
    CleaningResult
        Notes only, one per joint; where a root is below, one for the whole, since the floor is then elsewhere.

    Raises
    ------
    InputError
        Where a number is out of range.
    """
    as_clip_with_gaps(clip)
    height = as_number(height, "height of the floor", expected="a finite number", least=-sys.float_info.max)
    least_size = as_number(least_size, "least_size", expected="0 or more", least=0.0)
    positions, _ = clip.skeleton.world_pose(clip.rotations, clip.translations)
    depths = height - positions @ clip.skeleton.up
    deep = depths > least_size * body_size(clip.skeleton)
    sunk = np.asarray(deep[:, clip.parents < 0].any(axis=1))
    if sunk.any():
        what = f"the root itself is below height {height:g}: the floor is elsewhere"
        first, last = list_runs(sunk)[0]
        return CleaningResult(clip=clip, notes=(Finding(step="floor", joint="", first=first, last=last, what=what),))
    notes = [
        _describe(clip, joint, depths[:, joint], deep[:, joint]) for joint in np.flatnonzero(deep.any(axis=0)).tolist()
    ]
    return CleaningResult(clip=clip, notes=tuple(notes))


def _describe(clip: Clip, joint: int, depths: npt.NDArray[np.float64], deep: npt.NDArray[np.bool_]) -> Finding:
    first, last = max(list_runs(deep), key=lambda run: float(depths[run[0] : run[1] + 1].max()))
    centimetres = 100.0 * float(depths.max()) * clip.skeleton.meters_per_unit
    what = f"{centimetres:.1f} cm below the floor, the deepest of {int(deep.sum())} frames below it"
    return Finding(step="floor", joint=clip.joints[joint], first=first, last=last, what=what)
