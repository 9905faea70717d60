"""Reading clips for the method: in skeleton axes, on the sketch's joints, the root in the facing frame."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import Channel, to_skeleton_rotations, to_skeleton_translations
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.correspondence import corresponding_joints
from mtex_usd.texture.alignment import align_skeletons
from mtex_usd.texture.facing import Facing, find_root

__all__ = ["Motion", "choose_root", "read_sketch", "read_takes"]

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Motion:
    """A clip read for the method; joints are the sketch's, J of them, at rest where a take lacks them.

    Parameters
    ----------
    clip
        Where it comes from, on its own skeleton.
    rotations
        In skeleton axes and relative to rest, the root's in the facing frame, shape [F, J, 4].
    offsets
        Translations in skeleton axes and relative to rest, shape [F, J, 3].
    travel
        The root's position, straightened along the facing, shape [F, 3].
    facing
        The facing frame over time.
    """

    clip: Clip
    rotations: FloatArray
    offsets: FloatArray
    travel: FloatArray
    facing: Facing


def choose_root(sketch: Clip, takes: Sequence[Clip]) -> int:
    """Give the root: the topmost joint with animated translation in the sketch, else in a take, else joint 0."""
    own = find_root(sketch)
    if own is not None:
        return own
    for take in takes:
        root = find_root(take)
        if root is not None:
            back = corresponding_joints(sketch.joints, take.joints)
            return back.get(root, 0)
    return 0


def read_sketch(sketch: Clip, root: int, heading_band: int) -> Motion:
    """Read the sketch; what is slower than the heading band is heading."""
    rotations = to_skeleton_rotations(sketch.rotations, sketch.skeleton)
    offsets = to_skeleton_translations(sketch.translations, sketch.skeleton)
    return _face(sketch, rotations, offsets, Facing.of_clip(sketch, root, heading_band), root)


def read_takes(
    takes: Sequence[Clip], sketch: Clip, root: int, heading_band: int, channels: Sequence[Channel]
) -> tuple[list[Motion], list[str]]:
    """Read takes onto the sketch's joints.

    Parameters
    ----------
    takes, sketch
        All at one rate.
    root
        The sketch's root joint.
    heading_band
        What is slower than this band is heading.
    channels
        Channels with a role; a take that lacks one of their joints is left out.

    Returns
    -------
    tuple
        The motions, and a note for each take left out.

    Raises
    ------
    InputError
        Where no take has all joints with a role; the message names those that are missing.
    """
    needed = {channel.joint for channel in channels}
    motions, notes, lacking = [], [], set()
    for take in takes:
        found = corresponding_joints(take.joints, sketch.joints)
        missing = needed - found.keys()
        if missing:
            lacking |= missing
            notes.append(f"take {take.name} is left out: it has no {_names(missing, sketch)}")
            continue
        motions.append(_read_take(take, sketch, found, root, heading_band))
    if not motions:
        raise InputError(
            f"{sketch.name}: no take has all joints with a role",
            expected=f"joints named {_names(lacking or needed, sketch)}",
            found="; ".join(notes) or "no takes",
            fix="Use takes with joints of these names, or of a humanoid, or name pairs of joints in MtexRetargetAPI.",
        )
    return motions, notes


def _names(joints: set[int], sketch: Clip) -> str:
    return ", ".join(sketch.joints[joint] for joint in sorted(joints))


def _read_take(clip: Clip, sketch: Clip, found: dict[int, int], root: int, heading_band: int) -> Motion:
    """Read a take in the sketch's axes, size and joints; `found` gives the take's joint by the sketch's."""
    alignment = align_skeletons(clip.skeleton, sketch.skeleton, found)
    carrier = find_root(clip)
    if carrier is None:
        carrier = found.get(root, 0)
    clip_root = found.get(root, carrier)
    if carrier != clip_root and carrier in clip.skeleton.chain(clip_root):
        clip, carrier = _carry_below(clip, clip_root), clip_root
    rotations = alignment.rotations(to_skeleton_rotations(clip.rotations, clip.skeleton))
    offsets = alignment.offsets(to_skeleton_translations(clip.translations, clip.skeleton))
    below = next((joint for joint, other in found.items() if other == carrier and joint != root), None)
    if clip.joints != sketch.joints:
        known = found if below is not None else {**found, root: clip_root}
        rotations, offsets = _reorder(rotations, offsets, known, len(sketch.joints))
    own = Facing.of_clip(clip, carrier, heading_band)
    facing = Facing(own.heading, sketch.skeleton.up)
    if below is None:
        return _face(clip, rotations, offsets, facing, root)
    return _face_below(clip, rotations, offsets, facing, root, below)


def _carry_below(clip: Clip, root: int) -> Clip:
    """Give the joint that is the sketch's root all the motion of those above it, which rest."""
    skeleton = clip.skeleton
    positions, world = skeleton.world_pose(clip.rotations, clip.translations)
    rotations, translations = np.array(clip.rotations), np.array(clip.translations)
    above = skeleton.chain(root)[:-1]
    rotations[:, above], translations[:, above] = skeleton.rest_rotations[above], skeleton.rest_translations[above]
    back = quaternion.conjugate(skeleton.rest_orientations[above[-1]])
    rotations[:, root] = quaternion.unroll(quaternion.multiply(back, world[:, root]))
    translations[:, root] = quaternion.rotate(back, positions[:, root] - skeleton.rest_positions[above[-1]])
    return replace(clip, rotations=rotations, translations=translations)


def _face(clip: Clip, rotations: FloatArray, offsets: FloatArray, facing: Facing, root: int) -> Motion:
    rotations[:, root] = facing.into(rotations[:, root])
    return Motion(clip, rotations, offsets, facing.unroll_travel(offsets[:, root]), facing)


def _face_below(
    clip: Clip, rotations: FloatArray, offsets: FloatArray, facing: Facing, root: int, below: int
) -> Motion:
    """Face a take that is moved by a joint below the sketch's root: heading and way go to the root, the rest stays."""
    way, up = np.array(offsets[:, below]), facing.up
    rotations[:, below] = facing.into(rotations[:, below])
    rotations[:, root] = [1.0, 0.0, 0.0, 0.0]
    height = (way @ up)[:, None] * up
    offsets[:, below], offsets[:, root] = height, way - height
    return Motion(clip, rotations, offsets, facing.unroll_travel(offsets[:, root]), facing)


def _reorder(
    rotations: FloatArray, offsets: FloatArray, indices: dict[int, int], joint_count: int
) -> tuple[FloatArray, FloatArray]:
    """Put a take's joints where the sketch has them; the others stay at rest."""
    own, others = list(indices), list(indices.values())
    placed = np.zeros((len(rotations), joint_count, 4))
    placed[..., 0] = 1.0
    placed[:, own] = rotations[:, others]
    moved = np.zeros((len(offsets), joint_count, 3))
    moved[:, own] = offsets[:, others]
    return placed, moved
