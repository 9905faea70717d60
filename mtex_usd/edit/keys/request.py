"""What key reduction is asked for, checked."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.keys.tolerance import Tolerance
from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip

__all__ = ["OUTLIER", "check_contact_frames", "check_tolerance", "list_outliers"]

BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

OUTLIER = 3.0  # times the tolerance


def check_tolerance(degrees: float, metres: float) -> Tolerance:
    """Check that both parts of a tolerance are above 0; infinite is allowed.

    Parameters
    ----------
    degrees, metres
        The parts.

    Raises
    ------
    InputError
        Where one is not.
    """
    if not (degrees > 0.0 and metres > 0.0):
        raise InputError(
            "bad tolerance", expected="degrees and metres above 0", found=f"{degrees:g} degrees, {metres:g} m"
        )
    return Tolerance(degrees=degrees, metres=metres)


def check_contact_frames(clip: Clip, contact_frames: Sequence[int], key_count: int | None) -> IntArray:
    """List the frames that have to be keys: the ends and the contacts, sorted, each once.

    Parameters
    ----------
    clip
        The clip.
    contact_frames
        Frames from 0.
    key_count
        How many keys there may be; None where there is no such limit.

    Raises
    ------
    InputError
        Where a frame is outside the clip, or there are more frames than keys.
    """
    outside = [frame for frame in contact_frames if not 0 <= frame < clip.frame_count]
    if outside:
        raise InputError(
            "contact frames outside the clip",
            expected=f"0 to {clip.frame_count - 1}",
            found=", ".join(str(frame) for frame in outside),
        )
    frames = sorted({0, clip.frame_count - 1, *contact_frames})
    if key_count is not None and key_count < len(frames):
        raise InputError(
            "too few keys", expected=f"at least {len(frames)}, for the ends and the contacts", found=str(key_count)
        )
    return np.array(frames, dtype=np.intp)


def list_outliers(clip: Clip, outliers: BoolArray | None) -> tuple[tuple[str, int], ...]:
    """Name joints and frames of outliers [F, J], joint after joint.

    Parameters
    ----------
    clip
        The clip.
    outliers
        Which they are; None where none were looked for.
    """
    if outliers is None:
        return ()
    joints, frames = np.nonzero(outliers.T)
    return tuple((clip.joints[joint], frame) for joint, frame in zip(joints.tolist(), frames.tolist(), strict=True))
