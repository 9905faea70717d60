"""Small synthetic motions: a humanoid of eleven joints that walks by sines, on any rig, in any direction, at any rate.

Poses are made in skeleton axes (`rx` turns about the skeleton's x on every rig) and brought to the rig's own joint axes
at the end, so one motion can be had on rigs with differently oriented joints. Centimetres, Y up, facing +Z at rest.
"""

from dataclasses import replace

import numpy as np

from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import to_local_rotations, to_local_translations
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton, parents_of

HIPS, SPINE, HEAD = "Hips", "Hips/Spine", "Hips/Spine/Head"
LEFT_ARM, RIGHT_ARM = "Hips/Spine/LeftArm", "Hips/Spine/RightArm"
LEFT_FOREARM, RIGHT_FOREARM = f"{LEFT_ARM}/LeftForeArm", f"{RIGHT_ARM}/RightForeArm"
LEFT_LEG, RIGHT_LEG = "Hips/LeftUpLeg", "Hips/RightUpLeg"
LEFT_KNEE, RIGHT_KNEE = f"{LEFT_LEG}/LeftLeg", f"{RIGHT_LEG}/RightLeg"

POSITIONS = {
    HIPS: (0.0, 95.0, 0.0),
    SPINE: (0.0, 110.0, 0.0),
    HEAD: (0.0, 165.0, 0.0),
    LEFT_ARM: (18.0, 145.0, 0.0),
    LEFT_FOREARM: (45.0, 145.0, 0.0),
    RIGHT_ARM: (-18.0, 145.0, 0.0),
    RIGHT_FOREARM: (-45.0, 145.0, 0.0),
    LEFT_LEG: (9.0, 90.0, 0.0),
    LEFT_KNEE: (9.0, 45.0, 0.0),
    RIGHT_LEG: (-9.0, 90.0, 0.0),
    RIGHT_KNEE: (-9.0, 45.0, 0.0),
}
JOINTS = tuple(POSITIONS)
UP = np.array([0.0, 1.0, 0.0])
STRIDE_HZ = 0.9


def random_rotations(rng, *shape):
    """Unit quaternions spread evenly over all rotations."""
    return quaternion.normalize(rng.standard_normal((*shape, 4)))


def make_skeleton(joints=JOINTS, *, oriented=None, positions=None):
    """Build the humanoid; `oriented` is a seed for random joint orientations, None for joints along the axes."""
    where = np.array([(positions or POSITIONS)[joint] for joint in joints])
    world = np.tile([1.0, 0.0, 0.0, 0.0], (len(joints), 1))
    if oriented is not None:
        world = random_rotations(np.random.default_rng(oriented), len(joints))
    rest = np.tile(np.eye(4), (len(joints), 1, 1))
    for joint, parent in enumerate(parents_of(joints)):
        base = quaternion.conjugate(world[parent]) if parent >= 0 else np.array([1.0, 0.0, 0.0, 0.0])
        origin = where[parent] if parent >= 0 else np.zeros(3)
        local = quaternion.multiply(base, world[joint])
        # USD's row vectors: the rows are the turned axes.
        rest[joint, :3, :3] = quaternion.rotate(local, np.eye(3))
        rest[joint, 3, :3] = quaternion.rotate(base, where[joint] - origin)
    return Skeleton(joints=tuple(joints), rest=rest, up=UP)


def make_clip(skeleton, rate, turns, positions, *, name="/Clip", start=0.0, step=1.0):
    """Build a clip from rotations in skeleton axes [F, J, 4] and the first joint's positions [F, 3]."""
    frames = len(turns)
    offsets = np.zeros((frames, len(skeleton.joints), 3))
    offsets[:, 0] = positions - skeleton.rest_translations[0]
    return Clip(
        skeleton=skeleton,
        rate=rate,
        rotations=quaternion.unroll(to_local_rotations(turns, skeleton)),
        translations=to_local_translations(offsets, skeleton),
        scales=np.ones((frames, len(skeleton.joints), 3)),
        start=start,
        time_codes_per_frame=step,
        name=name,
    )


def walk(
    frames,
    *,
    rate=24.0,
    seed=0,
    leg=30.0,
    arm=20.0,
    detail=3.0,
    heading=0.0,
    stride_hz=STRIDE_HZ,
    skeleton=None,
    name="/Take",
    start=0.0,
    step=1.0,
):
    """Walk by sines, with drifting phase and size so that no stride is like another.

    `leg` and `arm` are amplitudes in degrees, numbers or curves [F]; `detail` that of fast movement in the upper body;
    `heading` degrees about up.
    """
    rng = np.random.default_rng(seed)
    skeleton = skeleton or make_skeleton()
    time = np.arange(frames) / rate
    phase = 2.0 * np.pi * stride_hz * time + rng.uniform(0.0, 2.0 * np.pi) + 0.3 * _drift(rng, time)
    size = 1.0 + 0.12 * _drift(rng, time)
    vectors = _pose(skeleton.joints, phase, size, leg, arm)
    vectors += detail * _detail(rng, time, skeleton.joints)
    turns = quaternion.exp(np.radians(vectors))
    yaw = np.radians(heading) + np.radians(4.0) * np.sin(phase)
    turns[:, 0] = quaternion.multiply(quaternion.exp(yaw[:, None] * UP), turns[:, 0])
    steps = 2.2 * np.asarray(leg) * stride_hz / rate * size
    ahead = np.broadcast_to(np.radians(heading), frames)
    along = np.stack([np.sin(ahead), np.zeros(frames), np.cos(ahead)], axis=1)
    across = np.stack([along[:, 2], np.zeros(frames), -along[:, 0]], axis=1)
    position = POSITIONS[HIPS] + np.cumsum(steps[:, None] * along, axis=0) + 2.0 * np.sin(phase)[:, None] * across
    position[:, 1] += 1.5 * np.cos(2.0 * phase)
    return make_clip(skeleton, rate, turns, position, name=name, start=start, step=step)


def _drift(rng, time):
    """Slow, smooth, about 1 in size."""
    return sum(np.sin(2.0 * np.pi * hz * time + rng.uniform(0.0, 6.3)) for hz in (0.11, 0.17, 0.29)) / 1.5


def _detail(rng, time, joints):
    out = np.zeros((len(time), len(joints), 3))
    for joint, name in enumerate(joints):
        upper = "Spine" in name
        for axis in range(3):
            for hz in (1.7, 3.3):
                out[:, joint, axis] += upper * 0.5 * np.sin(2.0 * np.pi * hz * time + rng.uniform(0.0, 6.3))
    return out


def _pose(joints, phase, size, leg, arm):
    """Rotation vectors in degrees and skeleton axes, [F, J, 3]."""
    swing = np.sin(phase) * size
    bend = (1.0 - np.cos(phase - 0.6)) * size
    other_bend = (1.0 + np.cos(phase - 0.6)) * size
    rx = {
        LEFT_LEG: leg * swing,
        RIGHT_LEG: -leg * swing,
        LEFT_KNEE: leg * bend,
        RIGHT_KNEE: leg * other_bend,
        LEFT_ARM: -arm * swing,
        RIGHT_ARM: arm * swing,
        LEFT_FOREARM: -arm * (1.0 + 0.5 * swing),
        RIGHT_FOREARM: -arm * (1.0 - 0.5 * swing),
        SPINE: 0.1 * arm * np.cos(2.0 * phase),
        HIPS: 0.05 * leg * np.cos(2.0 * phase),
    }
    out = np.zeros((len(phase), len(joints), 3))
    for joint, name in enumerate(joints):
        if name in rx:
            out[:, joint, 0] = rx[name]
    return out


def block(clip, joints=(HIPS, LEFT_LEG, RIGHT_LEG, LEFT_KNEE, RIGHT_KNEE), *, name="/Sketch"):
    """Make a sketch of a walk: only some joints move, the others stay at rest."""
    keep = [clip.joints.index(joint) for joint in joints]
    rotations = np.tile(clip.skeleton.rest_rotations, (clip.frame_count, 1, 1))
    rotations[:, keep] = clip.rotations[:, keep]
    return replace(clip, rotations=rotations, name=name)


def turned(clip, degrees):
    """Give the whole motion turned about up through the origin."""
    turn = quaternion.exp(np.radians(degrees) * UP)
    rotations, translations = np.array(clip.rotations), np.array(clip.translations)
    rotations[:, 0] = quaternion.multiply(turn, rotations[:, 0])
    translations[:, 0] = quaternion.rotate(turn, translations[:, 0])
    return replace(clip, rotations=rotations, translations=translations)


def on_joints(clip, joints, *, oriented=None):
    """Give the same motion on a skeleton with other joints, or another order of them."""
    skeleton = make_skeleton(joints, oriented=oriented)
    index = [clip.joints.index(joint) for joint in joints]
    return replace(
        clip,
        skeleton=skeleton,
        rotations=clip.rotations[:, index],
        translations=clip.translations[:, index],
        scales=clip.scales[:, index],
    )


def skeleton_turns(clip):
    """World rotations of all joints relative to rest, real first, [F, J, 4]."""
    world = clip.skeleton.world_rotations(clip.rotations)
    return quaternion.multiply(world, quaternion.conjugate(clip.skeleton.rest_orientations))
