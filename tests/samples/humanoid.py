"""The sample character: joints, proportions and a simple body.

Y up, facing +Z, left is +X, centimetres, 175 cm tall, T-pose, every joint oriented as the skeleton. Segment lengths are
Drillis & Contini's fractions of stature (in Winter 2009, Biomechanics and Motor Control of Human Movement, figure 4.1).
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from tests.samples.rotations import compose, rotate

__all__ = ["JOINTS", "NAMES", "OFFSETS", "PARENTS", "SOLE_POINTS", "STATURE", "Segment", "forward", "index_of", "skin"]

FloatArray = npt.NDArray[np.float64]

STATURE = 175.0

# Fractions of stature: thigh 0.245, shank 0.246, ankle height 0.039, upper arm 0.186, forearm 0.146, hand 0.108, foot
# 0.152. Half the distance of the hip centres is 0.36 of the 24 cm between the iliac spines (Bell et al. 1990). Where
# the joints sit along the spine and the foot, and where the shoulders begin, is a choice of this project.
_LEG = {
    "UpLeg": (8.6, -4.8, 0.0),
    "Leg": (0.0, -round(0.245 * STATURE, 1), 0.0),
    "Foot": (0.0, -round(0.246 * STATURE, 1), 0.0),
    "Toe": (0.0, -4.8, 13.0),
}
_ARM = {
    "Shoulder": (3.0, 20.5, 0.0),
    "Arm": (15.6, 1.0, 0.0),
    "ForeArm": (round(0.186 * STATURE, 1), 0.0, 0.0),
    "Hand": (round(0.146 * STATURE, 1), 0.0, 0.0),
}
_SPINE = {"Spine": (0.0, 7.0, 0.0), "Spine1": (0.0, 17.0, 0.0), "Neck": (0.0, 23.5, -1.0), "Head": (0.0, 9.0, 1.0)}


def _chain(parent: str, side: str, offsets: dict[str, tuple[float, float, float]]) -> dict[str, tuple[float, ...]]:
    sign = -1.0 if side == "Right" else 1.0
    out = {}
    for name, (x, y, z) in offsets.items():
        parent = f"{parent}/{side}{name}"
        out[parent] = (sign * x if x else 0.0, y, z)
    return out


def _build() -> dict[str, tuple[float, ...]]:
    joints: dict[str, tuple[float, ...]] = {"Hips": (0.0, 97.5, 0.0)}
    joints |= _chain("Hips", "Left", _LEG) | _chain("Hips", "Right", _LEG) | _chain("Hips", "", _SPINE)
    chest = "Hips/Spine/Spine1"
    return joints | _chain(chest, "Left", _ARM) | _chain(chest, "Right", _ARM)


_REST = _build()
JOINTS = tuple(_REST)
NAMES = tuple(joint.rpartition("/")[2] for joint in JOINTS)
PARENTS = tuple(JOINTS.index(joint.rpartition("/")[0]) if "/" in joint else -1 for joint in JOINTS)
OFFSETS: FloatArray = np.array(list(_REST.values()), dtype=np.float64)

# Points of the sole that meet the ground, as (joint, offset): heel, ball, tip of the toes.
SOLE_POINTS = (("Foot", (0.0, -6.8, -6.6)), ("Toe", (0.0, -2.0, 0.0)), ("Toe", (0.0, -2.0, 7.0)))


def index_of(name: str) -> int:
    """Index of a joint by its last name."""
    return NAMES.index(name)


def forward(rotations: FloatArray, root: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Forward kinematics: local rotations [F, J, 4] and root [F, 3] to positions [F, J, 3] and rotations [F, J, 4]."""
    positions, world = np.zeros((*rotations.shape[:2], 3)), rotations.copy()
    positions[:, 0] = root
    for joint, parent in enumerate(PARENTS):
        if parent >= 0:
            world[:, joint] = compose(world[:, parent], rotations[:, joint])
            positions[:, joint] = positions[:, parent] + rotate(world[:, parent], OFFSETS[joint])
    return positions, world


@dataclass(frozen=True, kw_only=True)
class Segment:
    """A tapered tube of the body: rings (distance along the axis, two radii) on one joint."""

    joint: str
    axis: int
    rings: tuple[tuple[float, float, float], ...]
    center: tuple[float, float, float] = (0.0, 0.0, 0.0)


def _limbs(side: str, sign: float) -> tuple[Segment, ...]:
    def along(*rings: tuple[float, float, float]) -> tuple[tuple[float, float, float], ...]:
        return tuple((sign * distance, a, b) for distance, a, b in rings)

    return (
        Segment(joint=f"{side}UpLeg", axis=1, rings=((4, 6, 7), (-6, 8.5, 9), (-24, 7, 8), (-42.5, 5.5, 6))),
        Segment(joint=f"{side}Leg", axis=1, rings=((2, 5, 5.5), (-10, 5.5, 6.5), (-28, 4.5, 5), (-42.5, 3.5, 4))),
        Segment(joint=f"{side}Foot", axis=2, rings=((-6.6, 3, 2.5), (0, 3.6, 3.4), (13, 4.6, 2)), center=(0, -4, 0)),
        Segment(joint=f"{side}Toe", axis=2, rings=((0, 4.6, 1.6), (4, 4.4, 1.5), (7, 3, 1.2)), center=(0, -0.5, 0)),
        Segment(joint=f"{side}Shoulder", axis=0, rings=along((0, 4, 5), (8, 5, 5), (16, 4.5, 4.5))),
        Segment(joint=f"{side}Arm", axis=0, rings=along((-2, 4, 4), (6, 5, 5), (22, 4.2, 4.2), (32, 3.6, 3.6))),
        Segment(joint=f"{side}ForeArm", axis=0, rings=along((-1, 3.6, 3.6), (7, 4, 4), (25, 2.8, 2.4))),
        Segment(joint=f"{side}Hand", axis=0, rings=along((0, 2.2, 3), (7, 2, 4.2), (18.9, 1, 2.5))),
    )


_BODY = (
    Segment(joint="Hips", axis=1, rings=((-9, 10, 8), (-3, 16, 11), (7, 14, 10))),
    Segment(joint="Spine", axis=1, rings=((-1, 13.5, 9.5), (8, 13, 9), (17, 14, 10))),
    Segment(joint="Spine1", axis=1, rings=((-1, 14, 10), (10, 16.5, 11), (18, 15, 9), (24, 6, 6))),
    Segment(joint="Neck", axis=1, rings=((-1, 5, 5.5), (9, 5, 5.5))),
    Segment(joint="Head", axis=1, rings=((-2, 4, 5), (4, 7, 8.5), (13, 8, 9.5), (21, 3.5, 4.5)), center=(0, 0, 1.5)),
    *_limbs("Left", 1.0),
    *_limbs("Right", -1.0),
)
_CORNERS = 6


def _ring_points(segment: Segment) -> FloatArray:
    turn = 2.0 * np.pi * (np.arange(_CORNERS) + 0.5) / _CORNERS
    across = [axis for axis in range(3) if axis != segment.axis]
    points = np.zeros((len(segment.rings), _CORNERS, 3))
    for ring, (distance, first, second) in enumerate(segment.rings):
        points[ring, :, segment.axis] = distance
        points[ring, :, across[0]] = first * np.cos(turn)
        points[ring, :, across[1]] = second * np.sin(turn)
    return points + np.array(segment.center)


def _ring_faces(rings: int, first: int, *, flipped: bool) -> list[list[int]]:
    corners = [list(range(first + _CORNERS * ring, first + _CORNERS * (ring + 1))) for ring in range(rings)]
    faces = [corners[0][::-1], corners[-1]]
    for low, high in pairwise(corners):
        nexts = [(i, (i + 1) % _CORNERS) for i in range(_CORNERS)]
        faces += [[low[i], low[j], high[j], high[i]] for i, j in nexts]
    return [face[::-1] for face in faces] if flipped else faces


def skin() -> tuple[FloatArray, list[list[int]], list[int]]:
    """Build the body in the bind pose: points [N, 3], faces as point indices, and the joint of every point."""
    positions, _ = forward(np.tile([1.0, 0.0, 0.0, 0.0], (1, len(JOINTS), 1)), OFFSETS[:1])
    points: list[FloatArray] = []
    faces: list[list[int]] = []
    joints: list[int] = []
    for segment in _BODY:
        joint = index_of(segment.joint)
        rings = _ring_points(segment) + positions[0, joint]
        rising = segment.rings[-1][0] > segment.rings[0][0]
        # The two axes across y turn the other way round (x, z) than those across x and z.
        faces += _ring_faces(len(rings), _CORNERS * len(points), flipped=rising == (segment.axis == 1))
        points += list(rings)
        joints += [joint] * _CORNERS * len(rings)
    return np.concatenate(points), faces, joints
