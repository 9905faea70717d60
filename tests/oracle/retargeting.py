"""Slow twin of retargeting: one frame and one joint at a time, in rotation matrices; imports nothing from the package.

`Rig` is a skeleton as plain lists. Columns of `axes` are the body's left, up and front, as it stands at rest.
"""

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation, Slerp


@dataclass(frozen=True)
class Rig:
    """Parents, rest rotations (scipy) and rest offsets relative to the parent, and the body's axes [3, 3]."""

    parents: list
    rest_rotations: list
    rest_offsets: list
    axes: np.ndarray


@dataclass(frozen=True)
class Bone:
    """A joint of the character and the take's that turns it.

    `child` is the character's joint its bone ends at, `source_child` the take's, both None where it is not aimed;
    `follows` is the bone above, whose lean at rest it keeps.
    """

    joint: int
    source: int
    child: int | None = None
    source_child: int | None = None
    follows: "Bone | None" = None


def place_joints(parents, rotations, offsets):
    """Rotations and places in space of one pose."""
    world, places = [], []
    for joint, parent in enumerate(parents):
        if parent < 0:
            world.append(rotations[joint])
            places.append(np.array(offsets[joint], dtype=float))
        else:
            world.append(world[parent] * rotations[joint])
            places.append(places[parent] + world[parent].apply(offsets[joint]))
    return world, places


def smallest_turn(a, b):
    """The smallest rotation from one direction to another, which are not opposite."""
    axis = np.cross(a, b)
    sine, cosine = np.linalg.norm(axis), np.dot(a, b)
    if sine == 0.0:
        return Rotation.identity()
    return Rotation.from_rotvec(axis / sine * np.arctan2(sine, cosine))


def retarget(source, target, bones, frames, *, hips, scale, floors):
    """Pose the character at every frame of a take.

    `frames` are pairs (rotations, offsets) of the take, relative to the parent; `hips` a pair (character's, take's);
    `floors` the places below the hips at rest (take's, character's). Gives (rotations in space, places) per frame.
    """
    return [
        pose_character(source, target, bones, rotations, offsets, hips, scale, floors) for rotations, offsets in frames
    ]


def pose_character(source, target, bones, rotations, offsets, hips, scale, floors):
    """Pose the character at one frame."""
    rest, rest_places = place_joints(source.parents, source.rest_rotations, source.rest_offsets)
    own_rest, own_places = place_joints(target.parents, target.rest_rotations, target.rest_offsets)
    world, places = place_joints(source.parents, rotations, offsets)
    onto_source = Rotation.from_matrix(source.axes @ target.axes.T)
    onto_target = onto_source.inv()
    wanted = {}
    for bone in bones:
        turn = world[bone.source] * rest[bone.source].inv()
        if bone.child is not None:
            laid = turn * onto_source
            laid = lean_bone(bone, laid, own_places, places) * laid
        elif bone.follows is not None:
            laid = turn * lean_bone(bone.follows, onto_source, own_places, rest_places) * onto_source
        else:
            laid = turn * onto_source
        wanted[bone.joint] = onto_target * laid * own_rest[bone.joint]
    hips_place = floors[1] + scale * onto_target.apply(places[hips[1]] - floors[0])
    return assemble(target, wanted, hips[0], hips_place)


def lean_bone(bone, laid, own_places, places):
    """How the character's bone has to turn to lie along the take's."""
    own = laid.apply(own_places[bone.child] - own_places[bone.joint])
    other = places[bone.source_child] - places[bone.source]
    return smallest_turn(own, other)


def assemble(rig, wanted, hips, hips_place):
    """Put wanted rotations in space into the hierarchy, the others at rest; the hips where they belong."""
    world, places = [], []
    for joint, parent in enumerate(rig.parents):
        local, offset = rig.rest_rotations[joint], np.array(rig.rest_offsets[joint], dtype=float)
        above = Rotation.identity() if parent < 0 else world[parent]
        world.append(wanted[joint] if joint in wanted else above * local)
        place = offset if parent < 0 else places[parent] + above.apply(offset)
        places.append(hips_place if joint == hips else place)
    return world, places


def bend_chain(source_points, target_points, turns, points, *, keeps_first):
    """Rotations since rest of the joints of a chain that does what another does, both in one space.

    `source_points` and `target_points` are the places at rest of the joints and of the chains' ends; `turns` are the
    take's joints' rotations since rest and `points` its places, at one frame.
    """
    stations, own = stations_of(source_points), stations_of(target_points)
    out = []
    for joint in range(len(target_points) - 1):
        if joint == 0 and keeps_first:
            out.append(turns[0])
            continue
        turn = read_turn(stations, turns, (own[joint] + own[joint + 1]) / 2.0)
        bone = turn.apply(target_points[joint + 1] - target_points[joint])
        chord = read_place(stations, points, own[joint + 1]) - read_place(stations, points, own[joint])
        out.append(smallest_turn(bone, chord) * turn)
    return out


def stations_of(points):
    """How far along the chain its joints and its end are, 0 to 1."""
    stations = [0.0]
    for a, b in itertools.pairwise(points):
        stations.append(stations[-1] + np.linalg.norm(b - a))
    return [station / stations[-1] for station in stations]


def read_turn(stations, turns, station):
    """The rotation between those of the two bones whose middles a station is between."""
    middles = [(a + b) / 2.0 for a, b in itertools.pairwise(stations)]
    if station <= middles[0]:
        return turns[0]
    for bone in range(len(middles) - 1):
        if middles[bone] <= station <= middles[bone + 1]:
            ends = Rotation.concatenate([turns[bone], turns[bone + 1]])
            return Slerp([middles[bone], middles[bone + 1]], ends)(station)
    return turns[-1]


def read_place(stations, points, station):
    """The place on the chain where a station is."""
    for bone in range(len(points) - 1):
        # Bones without length are passed over.
        if station <= stations[bone + 1] and stations[bone] < stations[bone + 1]:
            part = (station - stations[bone]) / (stations[bone + 1] - stations[bone])
            return points[bone] + part * (points[bone + 1] - points[bone])
    return points[-1]
