"""Trials: every take in turn is held out, sketched as an animator would have sketched it, and to be found again."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import Channel, to_local_rotations, to_local_translations
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.correspondence import corresponding_joints
from mtex_usd.texture.reading import Motion, read_takes

__all__ = ["MOST_SECONDS", "MOST_TRIALS", "Trial", "bring_takes", "make_trials", "share_joints", "sketch_take"]

FloatArray = npt.NDArray[np.float64]

MOST_TRIALS = 12
"""More takes than this are not held out: those that are lie evenly among all."""

MOST_SECONDS = 20.0
"""Of a longer take no more than this is held out, from its middle."""

# Animators block on sixes at 24 frames/s.
_KEY_SPACING_S = 0.25
# What rests on the facing frame is taken into it and out again: any band will do.
_ANY_BAND = 4


@dataclass(frozen=True, eq=False)
class Trial:
    """One take to be found again; all clips are on the character's skeleton.

    Parameters
    ----------
    held
        Which of all takes is held out.
    truth
        That take, or as much of it as is tried.
    sketch
        Its sketch: splines through a few frames of the sketched joints, all else at rest.
    takes
        The other takes.
    """

    held: int
    truth: Clip
    sketch: Clip
    takes: tuple[Clip, ...]


def bring_takes(
    sketch: Clip, takes: Sequence[Clip], root: int, copied: Sequence[Channel]
) -> tuple[tuple[Clip, ...], tuple[str, ...]]:
    """Put takes onto the sketch's skeleton, joints they lack at rest.

    Parameters
    ----------
    sketch
        The sketch whose skeleton it is.
    takes
        Takes at the sketch's rate, on skeletons of their own.
    root
        The sketch's root joint.
    copied
        Channels that are textured or synthesized; a take that lacks one of their joints is left out.

    Returns
    -------
    tuple
        The takes, and a note for each that is left out.

    Raises
    ------
    InputError
        Where no take has all the joints.
    """
    motions, notes = read_takes(takes, sketch, root, _ANY_BAND, copied)
    return tuple(_on_skeleton(motion, sketch, root) for motion in motions), tuple(notes)


def share_joints(sketch: Clip, takes: Sequence[Clip], copied: Sequence[Channel]) -> frozenset[int]:
    """Give the sketch's joints that all takes have which can be used.

    Parameters
    ----------
    sketch, takes, copied
        As :func:`bring_takes` takes them.
    """
    needed = {channel.joint for channel in copied}
    found = [corresponding_joints(take.joints, sketch.joints).keys() for take in takes]
    usable = [joints for joints in found if needed <= joints]
    return frozenset.intersection(*map(frozenset, usable)) if usable else frozenset()


def _on_skeleton(motion: Motion, sketch: Clip, root: int) -> Clip:
    rotations = np.array(motion.rotations)
    rotations[:, root] = motion.facing.out_of(rotations[:, root])
    translations = to_local_translations(motion.offsets, sketch.skeleton)
    return replace(
        motion.clip,
        skeleton=sketch.skeleton,
        rotations=quaternion.unroll(to_local_rotations(rotations, sketch.skeleton)),
        translations=translations,
        scales=np.ones_like(translations),
    )


def make_trials(takes: Sequence[Clip], sketched: Sequence[Channel]) -> tuple[Trial, ...]:
    """Hold takes out in turn, at most :data:`MOST_TRIALS` of them.

    Parameters
    ----------
    takes
        Takes on the character's skeleton.
    sketched
        Channels the animator keyed and the method does not fill in: the trials' sketches move their joints alone.

    Raises
    ------
    InputError
        Where there are fewer than two takes, or none is long enough to be sketched.
    """
    if len(takes) < 2:
        raise InputError(
            "a recipe is tried by holding one take out and finding it again from the others",
            expected="at least two takes that have all joints with a role",
            found=str(len(takes)),
            fix="Name more takes in mtex:takes.",
        )
    step = _key_step(takes[0])
    long_enough = [number for number, take in enumerate(takes) if take.frame_count > 2 * step]
    if not long_enough:
        raise InputError(
            "no take is long enough to be held out",
            expected=f"more than {2 * step} frames at {takes[0].rate:g} frames/s",
            found=f"{max(take.frame_count for take in takes)} at the most",
        )
    chosen = {long_enough[int(i)] for i in np.linspace(0, len(long_enough) - 1, MOST_TRIALS).round()}
    return tuple(_hold_out(takes, held, sketched) for held in sorted(chosen))


def _hold_out(takes: Sequence[Clip], held: int, sketched: Sequence[Channel]) -> Trial:
    truth = _take_middle(takes[held])
    return Trial(held, truth, sketch_take(truth, sketched), (*takes[:held], *takes[held + 1 :]))


def _take_middle(take: Clip) -> Clip:
    """Cut a long take down."""
    most = round(MOST_SECONDS * take.rate)
    if take.frame_count <= most:
        return take
    first = (take.frame_count - most) // 2
    part = slice(first, first + most)
    return replace(
        take,
        rotations=take.rotations[part],
        translations=take.translations[part],
        scales=take.scales[part],
        start=take.start + first * take.time_codes_per_frame,
    )


def sketch_take(take: Clip, sketched: Sequence[Channel]) -> Clip:
    """Give what an animator would have keyed of a take: cubic splines through a frame every quarter of a second.

    Parameters
    ----------
    take
        A take on the character's skeleton.
    sketched
        Channels keyed; of their joints all rotations, or all translations, are. The others rest.
    """
    turned = sorted({channel.joint for channel in sketched if channel.is_rotation})
    moved = sorted({channel.joint for channel in sketched if not channel.is_rotation})
    frames = take.frame_count
    rotations = np.tile(take.skeleton.rest_rotations, (frames, 1, 1))
    translations = np.tile(take.skeleton.rest_translations, (frames, 1, 1))
    rotations[:, turned] = quaternion.normalize(_through_keys(quaternion.unroll(take.rotations[:, turned]), take))
    translations[:, moved] = _through_keys(take.translations[:, moved], take)
    return replace(take, rotations=rotations, translations=translations, name=f"sketch of {take.name}")


def _key_step(take: Clip) -> int:
    return max(1, round(_KEY_SPACING_S * take.rate))


def _through_keys(curves: FloatArray, take: Clip) -> FloatArray:
    """Spline through every so many frames and the last."""
    last = take.frame_count - 1
    keys = np.unique(np.append(np.arange(0, take.frame_count, _key_step(take)), last))
    return np.asarray(CubicSpline(keys, curves[keys])(np.arange(take.frame_count)))
