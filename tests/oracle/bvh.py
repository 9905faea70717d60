"""A second, slow BVH reader with forward kinematics in 4x4 matrices, for checking the fast one.

It shares no code and no idea with the package: one pass over white-space separated words, recursion over braces, a
rotation matrix per channel, matrices multiplied down the hierarchy.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np


@dataclass
class Node:
    """A joint with its children; column vectors, so a child's world matrix is parent @ local."""

    name: str
    offset: list[float] = field(default_factory=list)
    channels: list[str] = field(default_factory=list)
    children: list["Node"] = field(default_factory=list)


@dataclass
class Motion:
    """A whole file: the root, seconds per frame, and a list of numbers per frame."""

    root: Node
    frame_time: float
    frames: list[list[float]]


def read(file_path: Path) -> Motion:
    """Read a well-formed file with one ROOT and names without spaces."""
    words = iter(file_path.read_text(encoding="latin-1").split())
    assert next(words) == "HIERARCHY"
    assert next(words) == "ROOT"
    root = _read_node(words)
    assert [next(words), next(words)] == ["MOTION", "Frames:"]
    count = int(next(words))
    assert [next(words), next(words)] == ["Frame", "Time:"]
    frame_time = float(next(words))
    numbers = [float(word) for word in words]
    width = len(numbers) // count
    return Motion(root, frame_time, [numbers[i * width : (i + 1) * width] for i in range(count)])


def _read_node(words: Iterator[str]) -> Node:
    node = Node(next(words))
    assert next(words) == "{"
    while (word := next(words)) != "}":
        if word == "OFFSET":
            node.offset = [float(next(words)) for _ in range(3)]
        elif word == "CHANNELS":
            node.channels = [next(words) for _ in range(int(next(words)))]
        elif word == "JOINT":
            node.children.append(_read_node(words))
        else:
            assert word == "End"
            while next(words) != "}":
                pass
    return node


def list_names(node: Node) -> list[str]:
    """Names, depth first."""
    return [node.name] + [name for child in node.children for name in list_names(child)]


def rest_positions(node: Node, origin: tuple[float, ...] = (0.0, 0.0, 0.0)) -> list[tuple[float, ...]]:
    """World positions of the joints with every rotation zero and every position at its offset, depth first."""
    here = tuple(a + b for a, b in zip(origin, node.offset, strict=True))
    return [here] + [position for child in node.children for position in rest_positions(child, here)]


def rest_size(motion: Motion) -> float:
    """Largest extent of the rest pose along an axis: its height, whichever axis is up."""
    positions = rest_positions(motion.root)
    return max(max(axis) - min(axis) for axis in zip(*positions, strict=True))


def world_transforms(motion: Motion, frame: int) -> np.ndarray:
    """World matrices of all joints at a frame, depth first, column vectors, shape [J, 4, 4]."""
    return np.array(_pose(motion.root, np.eye(4), iter(motion.frames[frame])))


def _pose(node: Node, parent: np.ndarray, values: Iterator[float]) -> list[np.ndarray]:
    place = list(node.offset)
    turn = np.eye(4)
    for channel in node.channels:
        axis = "XYZ".index(channel[0])
        if channel[1:] == "position":
            place[axis] = next(values)
        else:
            turn = turn @ _turn_matrix(axis, math.radians(next(values)))
    world = parent @ _move_matrix(place) @ turn
    return [world] + [matrix for child in node.children for matrix in _pose(child, world, values)]


def _move_matrix(place: list[float]) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, 3] = place
    return matrix


def _turn_matrix(axis: int, angle: float) -> np.ndarray:
    """Right-handed turn: for the axis z, x goes towards y."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(4)
    matrix[first, first] = matrix[second, second] = math.cos(angle)
    matrix[second, first] = math.sin(angle)
    matrix[first, second] = -math.sin(angle)
    return matrix
