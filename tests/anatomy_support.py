"""Skeletons for the tests of anatomy: from written-out hierarchies, and a humanoid with places for all its joints."""

from dataclasses import replace

import numpy as np

from mtex_usd.motion import quaternion
from mtex_usd.motion.skeleton import Skeleton, parents_of


def read_hierarchy(text):
    """Read a hierarchy written by indentation, ``name = part`` or ``name``.

    Returns the skeleton, whose rest pose says nothing (a joint is one unit above its parent), and joint path by part.
    """
    paths, parts, above = [], {}, []
    for line in text.splitlines():
        if not line.strip():
            continue
        depth = len(line) - len(line.lstrip())
        name, _, part = (word.strip() for word in line.partition("="))
        above = [entry for entry in above if entry[0] < depth]
        path = f"{above[-1][1]}/{name}" if above else name
        above.append((depth, path))
        paths.append(path)
        if part:
            parts[part] = path
    rest = np.tile(np.eye(4), (len(paths), 1, 1))
    rest[1:, 3, 1] = 1.0
    return Skeleton(joints=tuple(paths), rest=rest), parts


def both_sides(text, left, right):
    """Write a hierarchy for both sides: lines with ``{}`` and the deeper ones after them are repeated for the right."""
    out, block, depth = [], [], None
    for line in [*text.splitlines(), ""]:
        indent = len(line) - len(line.lstrip())
        if depth is not None and (not line.strip() or indent <= depth):
            out += [entry.replace("{}", left).replace("@", "left") for entry in block]
            out += [entry.replace("{}", right).replace("@", "right") for entry in block]
            block, depth = [], None
        if depth is None and "{}" in line:
            depth = indent
        (out if depth is None else block).append(line)
    return "\n".join(out)


def rename_joints(skeleton, name_of):
    """Give joints other last names; `name_of` takes index and last name. Ancestors that are not listed are left out."""
    paths = []
    for index, (joint, parent) in enumerate(zip(skeleton.joints, skeleton.parents, strict=True)):
        name = name_of(index, joint.rpartition("/")[2])
        paths.append(f"{paths[parent]}/{name}" if parent >= 0 else name)
    return replace(skeleton, joints=tuple(paths))


def permute_siblings(skeleton, rng):
    """List the joints in another order, parents still before their children; also gives the old index by new one."""
    order, waiting = [], [-1]
    while waiting:
        joint = waiting.pop(rng.integers(len(waiting)))
        order += [joint] if joint >= 0 else []
        waiting += np.flatnonzero(skeleton.parents == joint).tolist()
    joints = tuple(skeleton.joints[joint] for joint in order)
    return replace(skeleton, joints=joints, rest=skeleton.rest[order]), order


# Metres, Y up, facing +Z; of the sides the left one, at +X.
BODY = {
    "hips": ("", (0.0, 0.95, 0.0)),
    "spine": ("hips", (0.0, 1.05, 0.0)),
    "chest": ("spine", (0.0, 1.25, -0.02)),
    "neck": ("chest", (0.0, 1.47, -0.01)),
    "head": ("neck", (0.0, 1.56, 0.02)),
    "@.clavicle": ("chest", (0.03, 1.40, 0.0)),
    "@.upperArm": ("@.clavicle", (0.18, 1.42, -0.02)),
    "@.foreArm": ("@.upperArm", (0.46, 1.42, -0.02)),
    "@.hand": ("@.foreArm", (0.71, 1.42, -0.01)),
    "@.knuckle": ("@.hand", (0.81, 1.42, 0.0)),
    "@.thigh": ("hips", (0.09, 0.90, 0.0)),
    "@.shin": ("@.thigh", (0.10, 0.49, 0.01)),
    "@.foot": ("@.shin", (0.11, 0.08, -0.02)),
    "@.toes": ("@.foot", (0.12, 0.02, 0.12)),
}
SPINE = {"spine", "left.knuckle", "right.knuckle"}  # joints of the body that are no part of the anatomy

QUADRUPED = {
    "hips": ("", (0.0, 0.60, -0.30)),
    "tail1": ("hips", (0.0, 0.60, -0.40)),
    "tail2": ("tail1", (0.0, 0.55, -0.60)),
    "spine": ("hips", (0.0, 0.62, 0.0)),
    "chest": ("spine", (0.0, 0.62, 0.20)),
    "neck": ("chest", (0.0, 0.75, 0.35)),
    "head": ("neck", (0.0, 0.85, 0.45)),
    "@.thigh": ("hips", (0.06, 0.55, -0.30)),
    "@.shin": ("@.thigh", (0.06, 0.33, -0.27)),
    "@.foot": ("@.shin", (0.06, 0.10, -0.33)),
    "@.toes": ("@.foot", (0.06, 0.0, -0.30)),
    "@.front_thigh": ("chest", (0.06, 0.55, 0.22)),
    "@.front_shin": ("@.front_thigh", (0.06, 0.33, 0.20)),
    "@.front_foot": ("@.front_shin", (0.06, 0.10, 0.21)),
    "@.front_toes": ("@.front_foot", (0.06, 0.0, 0.25)),
}


def place_body(body=None, *, leave_out=(), turn=(1.0, 0.0, 0.0, 0.0), origin=(0.0, 0.0, 0.0), size=1.0, seed=None):
    """Build a skeleton from places; joint names are the keys, their order the dictionary's.

    What is left out hands its children to its parent; `turn` turns the whole body, `seed` orients joints at random.
    """
    places = {}
    for name, (parent, place) in (body or BODY).items():
        for side, sign in (("left", 1.0), ("right", -1.0)) if "@" in name else (("", 1.0),):
            mirrored = np.multiply(place, (sign, 1.0, 1.0))
            places[name.replace("@", side)] = (parent.replace("@", side), mirrored)
    paths, positions = {}, []
    for name, (above, place) in places.items():
        parent = above
        while parent in leave_out:
            parent = places[parent][0]
        if name not in leave_out:
            paths[name] = f"{paths[parent]}/{name}" if parent else name
            positions.append(place)
    turn = np.asarray(turn)
    positions = quaternion.rotate(turn, size * np.array(positions)) + origin
    return _orient(tuple(paths.values()), positions, seed)


def _orient(joints, positions, seed):
    world = np.tile([1.0, 0.0, 0.0, 0.0], (len(joints), 1))
    if seed is not None:
        world = quaternion.normalize(np.random.default_rng(seed).standard_normal(world.shape))
    rest = np.tile(np.eye(4), (len(joints), 1, 1))
    for joint, parent in enumerate(parents_of(joints)):
        base = quaternion.conjugate(world[parent]) if parent >= 0 else np.array([1.0, 0.0, 0.0, 0.0])
        offset = positions[joint] - (positions[parent] if parent >= 0 else 0.0)
        rest[joint, :3, :3] = quaternion.rotate(quaternion.multiply(base, world[joint]), np.eye(3))
        rest[joint, 3, :3] = quaternion.rotate(base, offset)
    return Skeleton(joints=joints, rest=rest)
