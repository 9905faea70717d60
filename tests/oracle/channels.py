"""Slow twin of the channels' axes: D = W (R_rest^-1 R) W^-1 with 3 x 3 matrices and column vectors."""

import math


def product(a, b):
    """Multiply two 3 x 3 matrices."""
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def transpose(a):
    """Swap rows and columns: the inverse of a rotation."""
    return [[a[j][i] for j in range(3)] for i in range(3)]


def matrix_of(quaternion):
    """Rotation matrix, for column vectors, of a unit quaternion (w, x, y, z)."""
    w, x, y, z = (float(value) for value in quaternion)
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]


def turn_about(axis, degrees):
    """Rotation matrix about a coordinate axis: 0, 1 or 2."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out = [[float(a == b) for b in range(3)] for a in range(3)]
    out[i][i], out[i][j], out[j][i], out[j][j] = c, -s, s, c
    return out


def rest_orientation(joint, parents, rest_rotations):
    """Accumulate rest rotations from the root down to a joint: W, in skeleton space."""
    own = matrix_of(rest_rotations[joint])
    parent = parents[joint]
    return own if parent < 0 else product(rest_orientation(parent, parents, rest_rotations), own)


def in_skeleton_axes(local, joint, parents, rest_rotations):
    """Read one local rotation (w, x, y, z) of a joint relative to rest, in the skeleton's axes."""
    orientation = rest_orientation(joint, parents, rest_rotations)
    relative = product(transpose(matrix_of(rest_rotations[joint])), matrix_of(local))
    return product(product(orientation, relative), transpose(orientation))


def from_angles(angles, order):
    """Compose a rotation of angles about x, y, z in degrees, for an intrinsic order such as "ZYX"."""
    out = [[float(a == b) for b in range(3)] for a in range(3)]
    for letter in order:
        axis = "XYZ".index(letter)
        out = product(out, turn_about(axis, angles[axis]))
    return out
