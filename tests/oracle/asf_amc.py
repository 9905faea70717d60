"""A second, slow ASF/AMC reader with forward kinematics in 4x4 matrices, for checking the fast one.

It shares no code and no idea with the package: words by position, one bone and one frame at a time, rotation matrices
multiplied down the hierarchy. It reads well-formed files as Vicon writes them: degrees, one line per bone and frame.
"""

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np


@dataclass
class Bone:
    """A bone with its children; column vectors, so a child's world matrix is parent @ local."""

    name: str
    direction: tuple[float, ...] = (0.0, 0.0, 0.0)
    length: float = 0.0
    axis: tuple[float, ...] = (0.0, 0.0, 0.0)
    axis_order: str = "XYZ"
    dof: list[str] = field(default_factory=list)
    children: list["Bone"] = field(default_factory=list)


def read_skeleton(file_path: Path) -> dict[str, Bone]:
    """Read the bones by name; ``root`` is one of them."""
    lines = [line.split() for line in file_path.read_text().splitlines() if line.strip() and line.strip()[0] != "#"]
    bones = {"root": Bone("root")}
    section, bone = "", bones["root"]
    for words in lines:
        if words[0].startswith(":"):
            section = words[0]
        elif section == ":root" and words[0] == "order":
            bone.dof = [word.lower() for word in words[1:]]
        elif section == ":bonedata" and words[0] == "name":
            bone = bones[words[1]] = Bone(words[1])
        elif section == ":bonedata" and words[0] == "direction":
            bone.direction = tuple(map(float, words[1:4]))
        elif section == ":bonedata" and words[0] == "length":
            bone.length = float(words[1])
        elif section == ":bonedata" and words[0] == "axis":
            bone.axis, bone.axis_order = tuple(map(float, words[1:4])), words[4]
        elif section == ":bonedata" and words[0] == "dof":
            bone.dof = words[1:]
        elif section == ":hierarchy" and words[0] not in {"begin", "end"}:
            bones[words[0]].children += [bones[name] for name in words[1:]]
    return bones


def read_frames(file_path: Path) -> list[dict[str, list[float]]]:
    """Read the values of each bone, frame by frame."""
    frames: list[dict[str, list[float]]] = []
    for line in file_path.read_text().splitlines():
        words = line.split()
        if not words or words[0][0] in "#:":
            continue
        if len(words) == 1:
            frames.append({})
        else:
            frames[-1][words[0]] = [float(word) for word in words[1:]]
    return frames


def world_positions(bones: dict[str, Bone], frame: dict[str, list[float]]) -> dict[str, np.ndarray]:
    """Where each bone begins, file units."""
    found: dict[str, np.ndarray] = {}
    _pose(bones["root"], np.eye(4), np.zeros(3), frame, found)
    return found


def _pose(
    bone: Bone, parent: np.ndarray, offset: np.ndarray, frame: dict[str, list[float]], found: dict[str, np.ndarray]
) -> None:
    values = dict(zip(bone.dof, frame.get(bone.name, [0.0] * len(bone.dof)), strict=True))
    turn = np.eye(4)
    for channel, value in values.items():
        if channel[0] == "r":
            turn = _turn("xyz".index(channel[1]), value) @ turn
    own = np.eye(4)
    for letter in bone.axis_order.lower():
        own = _turn("xyz".index(letter), bone.axis["xyz".index(letter)]) @ own
    local = own @ turn @ np.linalg.inv(own)
    local[:3, 3] = offset + [values.get(f"t{axis}", 0.0) for axis in "xyz"]
    world = parent @ local
    found[bone.name] = world[:3, 3]
    for child in bone.children:
        _pose(child, world, np.array(bone.direction) * bone.length, frame, found)


def _turn(axis: int, degrees: float) -> np.ndarray:
    first, second = (axis + 1) % 3, (axis + 2) % 3
    angle = math.radians(degrees)
    matrix = np.eye(4)
    matrix[first, first] = matrix[second, second] = math.cos(angle)
    matrix[second, first], matrix[first, second] = math.sin(angle), -math.sin(angle)
    return matrix
