"""Humanoids of any build and motions of them in space, for the tests of retargeting.

A motion is told by how every joint has turned in space since rest, which is the same on every rig of the body: whatever
its joints are called, however they are oriented, whichever way up it is.
"""

from dataclasses import replace

import numpy as np

from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from tests.anatomy_support import BODY, place_body

# Arms straight out to the sides, so that lowering them is a turn about the front alone.
HUMAN = {
    **{name: place for name, place in BODY.items() if name != "@.knuckle"},
    "@.upperArm": ("@.clavicle", (0.18, 1.42, -0.02)),
    "@.foreArm": ("@.upperArm", (0.46, 1.42, -0.02)),
    "@.hand": ("@.foreArm", (0.71, 1.42, -0.02)),
}
# One bone per section: the trunk is a single one.
STICK = {
    **{name: place for name, place in HUMAN.items() if name not in {"spine", "chest"}},
    "neck": ("hips", (0.0, 1.47, -0.01)),
    "@.clavicle": ("hips", (0.03, 1.40, 0.0)),
}
ARM_BELOW = ("@.foreArm", "@.hand")
AIMED = (
    ("neck", "head"),
    *(
        (f"{side}.{upper}", f"{side}.{lower}")
        for side in ("left", "right")
        for upper, lower in (
            ("clavicle", "upperArm"),
            ("upperArm", "foreArm"),
            ("foreArm", "hand"),
            ("thigh", "shin"),
            ("shin", "foot"),
        )
    ),
)


def stretched(body, rng, *, share=0.2):
    """Give a body of another build, every bone longer or shorter and leaning a little, that stands on zero."""
    places = {}
    for name, (parent, place) in body.items():
        bone = np.subtract(place, body[parent][1]) if parent else np.array(place)
        noise = rng.uniform(-share, share, size=4) * [1.0, *([np.linalg.norm(bone)] * 3)]
        # What lies in the middle stays there, or left and right would not mirror each other.
        lean = noise[1:] * (0.0 if "@" not in name else 1.0, 0.5, 0.5) if parent else 0.0
        places[name] = (parent, tuple((places[parent][1] if parent else 0.0) + (1.0 + noise[0]) * bone + lean))
    floor = min(place[1] for name, (_, place) in places.items() if name.endswith(("foot", "toes")))
    return {name: (parent, tuple(np.subtract(place, (0.0, floor, 0.0)))) for name, (parent, place) in places.items()}


def lowered(body, degrees):
    """Give a body whose arms rest lower."""
    down = quaternion.exp(np.array([0.0, 0.0, -np.radians(degrees)]))
    shoulder = np.array(body["@.upperArm"][1])
    turned = {
        name: (body[name][0], tuple(shoulder + quaternion.rotate(down, np.subtract(body[name][1], shoulder))))
        for name in ARM_BELOW
    }
    return {**body, **turned}


def with_legs(body, factor):
    """Give a body with longer or shorter legs, whose feet stand where they did."""
    hip, knee, ankle, toes = (np.array(body[f"@.{part}"][1]) for part in ("thigh", "shin", "foot", "toes"))
    rise = np.array([0.0, (factor - 1.0) * (hip - ankle)[1], 0.0])
    longer = {"@.shin": hip + factor * (knee - hip), "@.foot": hip + factor * (ankle - hip)}
    longer["@.toes"] = longer["@.foot"] + toes - ankle
    return {name: (parent, tuple(longer.get(name, place) + rise)) for name, (parent, place) in body.items()}


def lower_turns(skeleton, turns, degrees):
    """Give the turns since rest of the same motion on the skeleton whose arms rest lower; joints as :func:`lowered`."""
    out = np.array(turns)
    for index, joint in enumerate(skeleton.joints):
        name = last(joint)
        if name.partition(".")[2] in {"upperArm", "foreArm", "hand"}:
            sign = 1.0 if name.startswith("left") else -1.0
            raised = quaternion.exp(np.array([0.0, 0.0, sign * np.radians(degrees)]))
            out[:, index] = quaternion.multiply(out[:, index], raised)
    return out


def last(joint):
    """The last name of a joint path."""
    return joint.rpartition("/")[2]


def index_of(skeleton, name):
    """The joint of a last name."""
    (found,) = [i for i, joint in enumerate(skeleton.joints) if last(joint) == name]
    return found


def random_turns(rng, frames, count, *, size=0.5):
    """Turns in space since rest that differ by joint, about `size` radians large, [F, J, 4]."""
    return quaternion.exp(size * rng.normal(size=(frames, count, 3)) / np.sqrt(3.0))


def animate(skeleton, turns, places, *, rate=24.0, name="/Take"):
    """Build a clip: turns in space since rest [F, J, 4] and places of the first joint [F, 3]."""
    world = quaternion.multiply(turns, skeleton.rest_orientations)
    rotations = np.array(world)
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            rotations[:, joint] = quaternion.multiply(quaternion.conjugate(world[:, parent]), world[:, joint])
    translations = np.tile(skeleton.rest_translations, (len(turns), 1, 1))
    translations[:, 0] = places
    return Clip(
        skeleton=skeleton,
        rate=rate,
        rotations=quaternion.unroll(rotations),
        translations=translations,
        scales=np.ones_like(translations),
        name=name,
    )


def move(skeleton, rng, *, frames=4, size=0.5):
    """Build a random motion near the rest pose."""
    places = skeleton.rest_positions[0] + 0.3 * skeleton.height * rng.normal(size=(frames, 3))
    return animate(skeleton, random_turns(rng, frames, len(skeleton.joints), size=size), places)


def rest_clip(skeleton, frames=2):
    """Build a clip that stands at rest."""
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (frames, len(skeleton.joints), 1))
    return animate(skeleton, turns, np.tile(skeleton.rest_positions[0], (frames, 1)))


def in_space(clip):
    """Positions [F, J, 3] and rotations [F, J, 4] in skeleton space."""
    return clip.skeleton.world_pose(clip.rotations, clip.translations)


def direction(clip, upper, lower):
    """Unit vectors from one joint to another, by last names, [F, 3]."""
    positions, _ = in_space(clip)
    bone = positions[:, index_of(clip.skeleton, lower)] - positions[:, index_of(clip.skeleton, upper)]
    return bone / np.linalg.norm(bone, axis=-1, keepdims=True)


def angle_apart(a, b):
    """Largest angle in radians between unit vectors; exact for small ones."""
    return float(2.0 * np.arcsin(np.clip(np.linalg.norm(a - b, axis=-1) / 2.0, 0.0, 1.0)).max())


def assert_same_motion(clip, other, *, tolerance=1e-9):
    """The joints of both are at the same places and turned alike; lengths are of the order of one."""
    (places, turns), (other_places, other_turns) = in_space(clip), in_space(other)
    np.testing.assert_allclose(places, other_places, atol=tolerance)
    assert quaternion.angle_between(turns, other_turns).max() < tolerance


def turn_space(clip, turn, size):
    """Give a motion in another space: turned as a whole, up with it, and in other units."""
    skeleton = clip.skeleton
    world = quaternion.multiply(turn, skeleton.rest_orientations)
    positions = size * quaternion.rotate(turn, skeleton.rest_positions)
    moved, turned = in_space(clip)
    rest = np.array(skeleton.rest)
    rotations, translations = quaternion.multiply(turn, turned), size * quaternion.rotate(turn, moved)
    local_rotations, local_translations = np.array(rotations), np.array(translations)
    for joint, parent in enumerate(skeleton.parents):
        above = world[parent] if parent >= 0 else np.array([1.0, 0.0, 0.0, 0.0])
        origin = positions[parent] if parent >= 0 else np.zeros(3)
        back = quaternion.conjugate(above)
        rest[joint, :3, :3] = quaternion.rotate(quaternion.multiply(back, world[joint]), np.eye(3))
        rest[joint, 3, :3] = quaternion.rotate(back, positions[joint] - origin)
        if parent >= 0:
            back = quaternion.conjugate(rotations[:, parent])
            local_rotations[:, joint] = quaternion.multiply(back, rotations[:, joint])
            local_translations[:, joint] = quaternion.rotate(back, translations[:, joint] - translations[:, parent])
    up = quaternion.rotate(turn, skeleton.up)
    turned_skeleton = Skeleton(
        joints=skeleton.joints, rest=rest, up=np.round(up), meters_per_unit=skeleton.meters_per_unit / size
    )
    return replace(clip, skeleton=turned_skeleton, rotations=local_rotations, translations=local_translations)


def human(body=None, **options):
    """Build the skeleton of a body; see :func:`tests.anatomy_support.place_body`."""
    return place_body(body or HUMAN, **options)
