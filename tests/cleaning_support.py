"""A walking humanoid with feet, hands and toes, and the errors that captures have, made on purpose."""

from dataclasses import replace

import numpy as np

from mtex_usd.motion import quaternion
from tests.synthetic import (
    LEFT_ARM,
    LEFT_FOREARM,
    LEFT_KNEE,
    LEFT_LEG,
    POSITIONS,
    RIGHT_ARM,
    RIGHT_FOREARM,
    RIGHT_KNEE,
    SPINE,
    make_skeleton,
    walk,
)

LEFT_FOOT, RIGHT_FOOT = f"{LEFT_KNEE}/LeftFoot", f"{RIGHT_KNEE}/RightFoot"
LEFT_TOE, RIGHT_TOE = f"{LEFT_FOOT}/LeftToe", f"{RIGHT_FOOT}/RightToe"
LEFT_HAND, RIGHT_HAND = f"{LEFT_FOREARM}/LeftHand", f"{RIGHT_FOREARM}/RightHand"

BODY = POSITIONS | {
    LEFT_FOOT: (9.0, 8.0, -2.0),
    LEFT_TOE: (9.0, 2.0, 12.0),
    RIGHT_FOOT: (-9.0, 8.0, -2.0),
    RIGHT_TOE: (-9.0, 2.0, 12.0),
    LEFT_HAND: (70.0, 145.0, 0.0),
    RIGHT_HAND: (-70.0, 145.0, 0.0),
}
BENDS = (
    (LEFT_KNEE, 25.0, (1.0, 0.0, 0.0)),
    (RIGHT_KNEE, 25.0, (1.0, 0.0, 0.0)),
    (LEFT_FOREARM, -40.0, (0.0, 1.0, 0.0)),
    (RIGHT_FOREARM, 40.0, (0.0, 1.0, 0.0)),
)


def make_walk(frames=240, *, rate=120.0, seed=0, oriented=None, stride_hz=0.9):
    """Walk on feet that turn, knees and elbows always bent; toes carry nothing."""
    clip = walk(
        frames,
        rate=rate,
        seed=seed,
        stride_hz=stride_hz,
        skeleton=make_skeleton(tuple(BODY), oriented=oriented, positions=BODY),
    )
    for joint, degrees, axis in BENDS:
        clip = turn_joint(clip, joint, 0, frames - 1, degrees, axis)
    rotations = np.array(clip.rotations)
    swing = np.radians(15.0) * np.sin(2.0 * np.pi * stride_hz * np.arange(frames) / rate)
    for joint in (LEFT_FOOT, RIGHT_FOOT):
        turn = quaternion.exp(swing[:, None] * np.array([1.0, 0.0, 0.0]))
        rotations[:, clip.joints.index(joint)] = quaternion.multiply(rotations[:, clip.joints.index(joint)], turn)
    return replace(clip, rotations=rotations)


def chain_of(clip, upper):
    """Indices of an upper joint, its middle and its end."""
    first = clip.joints.index(upper)
    middle = int(np.flatnonzero(clip.parents == first)[0])
    return first, middle, int(np.flatnonzero(clip.parents == middle)[0])


def flip(clip, upper, first, last, degrees=180.0):
    """Turn a limb about the line from its upper joint to its end, from first to last frame; its end's rotation too."""
    top, middle, end = chain_of(clip, upper)
    run = slice(first, last + 1)
    rotations = np.array(clip.rotations)
    local, bent = rotations[run, top], rotations[run, middle]
    reach = quaternion.rotate(bent, clip.translations[run, end]) + clip.translations[run, middle]
    axis = quaternion.rotate(local, reach)
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    turn = quaternion.exp(np.radians(degrees) * axis)
    rotations[run, top] = quaternion.multiply(turn, local)
    # The end's own rotation flips along with it, as solvers do.
    rotations[run, end] = quaternion.multiply(
        quaternion.exp(np.radians([0.0, 0.0, 0.8 * degrees])), rotations[run, end]
    )
    return replace(clip, rotations=rotations)


def turn_joint(clip, joint, first, last, degrees, axis=(0.0, 0.0, 1.0)):
    """Turn one joint by so many degrees from first to last frame."""
    rotations = np.array(clip.rotations)
    turn = quaternion.exp(np.radians(degrees) * np.array(axis))
    j = clip.joints.index(joint)
    rotations[first : last + 1, j] = quaternion.multiply(rotations[first : last + 1, j], turn)
    return replace(clip, rotations=rotations)


def prepend_rest(clip, frames=1):
    """Put the rest pose before a clip, as releases for some software do."""
    rest = np.tile(clip.skeleton.rest_rotations, (frames, 1, 1))
    translations = np.tile(clip.translations[:1], (frames, 1, 1))
    return replace(
        clip,
        rotations=np.concatenate([rest, clip.rotations]),
        translations=np.concatenate([translations, clip.translations]),
        scales=np.concatenate([clip.scales[:1]] * frames + [clip.scales]),
    )


def add_noise(clip, degrees, seed=0):
    """Add white noise to every joint, so many degrees of standard deviation per axis."""
    rng = np.random.default_rng(seed)
    noise = quaternion.exp(np.radians(degrees) * rng.standard_normal((*clip.rotations.shape[:2], 3)))
    return replace(clip, rotations=quaternion.multiply(clip.rotations, noise))


def positions(clip):
    """Joint positions in skeleton space, [F, J, 3]."""
    return clip.skeleton.world_pose(clip.rotations, clip.translations)[0]


def changed_frames(before, after):
    """Mark the frames and joints whose bits differ, [F, J]."""
    return (before.rotations != after.rotations).any(axis=-1) | (before.translations != after.translations).any(axis=-1)


def dirty_clip():
    """Walk far from rest, with a leading rest pose at frame 0 and the left leg flipped at frames 101 to 106."""
    clip = make_walk()
    for joint in (LEFT_ARM, RIGHT_ARM, SPINE):
        clip = turn_joint(clip, joint, 0, clip.frame_count - 1, 60.0)
    return prepend_rest(flip(clip, LEFT_LEG, 100, 105))


def write_bvh(clip, file_path):
    """Write a clip with joints along the axes, Euler order ZXY."""
    lines = ["HIERARCHY"]

    def add(joint, depth):
        pad, name = "  " * depth, clip.joints[joint].rpartition("/")[2]
        offset = " ".join(f"{v:.9g}" for v in clip.skeleton.rest_translations[joint])
        channels = "6 Xposition Yposition Zposition" if depth == 0 else "3"
        lines.extend([f"{pad}{'JOINT' if depth else 'ROOT'} {name}", pad + "{", f"{pad}  OFFSET {offset}"])
        lines.append(f"{pad}  CHANNELS {channels} Zrotation Xrotation Yrotation")
        children = [j for j, parent in enumerate(clip.parents) if parent == joint]
        order.append(joint)
        for child in children:
            add(child, depth + 1)
        if not children:
            lines.extend([f"{pad}  End Site", pad + "  {", f"{pad}    OFFSET 0 0 1", pad + "  }"])
        lines.append(pad + "}")

    order = []
    add(0, 0)
    angles = quaternion.to_euler(clip.rotations, "ZXY")[:, order][..., [2, 0, 1]]
    values = np.concatenate([clip.translations[:, 0], angles.reshape(clip.frame_count, -1)], axis=1)
    lines += ["MOTION", f"Frames: {clip.frame_count}", f"Frame Time: {1.0 / clip.rate:.9f}"]
    lines += [" ".join(f"{v:.7f}" for v in row) for row in values]
    file_path.write_text("\n".join(lines) + "\n")
    return file_path
