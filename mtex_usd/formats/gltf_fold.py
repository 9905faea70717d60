"""Joints relative to their parent joints, with all that is no joint between them folded in."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from mtex_usd.formats.gltf_container import FloatArray, GltfFile
from mtex_usd.formats.gltf_nodes import GltfNode, split_matrix

__all__ = ["FoldedPose", "fold_pose"]

_SAME_SCALE = 1e-5  # exporters leave 1.0000001


@dataclass(frozen=True, eq=False, kw_only=True)
class FoldedPose:
    """Joints relative to their parent joints.

    Parameters
    ----------
    parents
        Index of each joint's parent among the joints, -1 for a root.
    translations, rotations, scales
        Shapes [F, J, 3], [F, J, 4] (real part last) and [F, J, 3].
    sheared
        Whether shear had to be left out.
    """

    parents: tuple[int, ...]
    translations: FloatArray
    rotations: FloatArray
    scales: FloatArray
    sheared: bool

    @property
    def has_unit_scales(self) -> bool:
        """Whether every scale is 1 to rounding."""
        return bool(np.all(np.abs(self.scales - 1.0) <= _SAME_SCALE))


@dataclass(frozen=True, eq=False)
class _Local:
    """A node over time, or at rest as one frame: shapes [F, 3], [F, 4] and [F, 3]."""

    translation: FloatArray
    rotation: FloatArray
    scale: FloatArray

    def to_matrices(self) -> FloatArray:
        """Transforms for column vectors, shape [F, 4, 4]."""
        matrices = np.tile(np.eye(4), (len(self.translation), 1, 1))
        matrices[:, :3, :3] = Rotation.from_quat(self.rotation).as_matrix() * self.scale[:, None, :]
        matrices[:, :3, 3] = self.translation
        return matrices


def fold_pose(
    file: GltfFile,
    nodes: Sequence[GltfNode],
    joints: Sequence[int],
    sampled: Mapping[tuple[int, str], FloatArray],
    *,
    frame_count: int,
) -> tuple[FoldedPose, FoldedPose]:
    """Fold the nodes that are no joints into the joints, at rest and in motion.

    Parameters
    ----------
    file, nodes
        The file and its nodes.
    joints
        Node indices, a parent before its children, length J.
    sampled
        Values over time by node and property, shape [F, W].
    frame_count
        F.

    Returns
    -------
    tuple of FoldedPose
        At rest, one frame, and in motion.

    Raises
    ------
    FormatError
        Where something above a joint is scaled to nothing.
    """
    folder = _Folder(file, nodes, joints, sampled, frame_count)
    return folder.fold(moving=False), folder.fold(moving=True)


class _Folder:
    def __init__(
        self,
        file: GltfFile,
        nodes: Sequence[GltfNode],
        joints: Sequence[int],
        sampled: Mapping[tuple[int, str], FloatArray],
        frame_count: int,
    ) -> None:
        self.file, self.nodes, self.joints = file, nodes, joints
        self.sampled, self.frame_count = sampled, frame_count
        self.index = {joint: i for i, joint in enumerate(joints)}
        self.above = [self._list_above(joint) for joint in joints]
        self.parents = tuple(self._find_parent(i) for i in range(len(joints)))
        self.factors = [self._constant_factor(i) for i in range(len(joints))]
        self.lengths = self._accumulate_lengths()

    def _list_above(self, joint: int) -> list[int]:
        """Give the nodes between a joint and its parent joint, topmost first."""
        above: list[int] = []
        node = self.nodes[joint].parent
        while node >= 0 and node not in self.index:
            above.append(node)
            node = self.nodes[node].parent
        return above[::-1]

    def _find_parent(self, i: int) -> int:
        top = self.above[i][0] if self.above[i] else self.joints[i]
        return self.index.get(self.nodes[top].parent, -1)

    def _local(self, node: int, *, moving: bool) -> _Local:
        rest = self.nodes[node].rest
        moved = {path: self.sampled.get((node, path)) if moving else None for path in rest}
        count = max([1, *(len(values) for values in moved.values() if values is not None)])
        filled = [np.repeat(rest[path][None], count, axis=0) if v is None else v for path, v in moved.items()]
        return _Local(*filled)

    def _matrices_above(self, i: int, *, moving: bool) -> FloatArray:
        product = np.eye(4)[None]
        for node in self.above[i]:
            product = product @ self._local(node, moving=moving).to_matrices()
        return product

    def _constant_factor(self, i: int) -> tuple[float | None, float | None]:
        """Give the uniform scale above a joint and its own, each None unless it stays as it is at rest."""
        above = [_uniform_scale(self._matrices_above(i, moving=moving)[:, :3, :3]) for moving in (False, True)]
        locals_ = [self._local(self.joints[i], moving=moving).scale for moving in (False, True)]
        own = [_uniform_scale(scale[:, :, None] * np.eye(3)) for scale in locals_]
        return _agreed(above), _agreed(own)

    def _accumulate_lengths(self) -> list[float]:
        """Give the factor that the scales taken out above each joint's children leave in their translations."""
        lengths: list[float] = []
        for (above, own), parent in zip(self.factors, self.parents, strict=True):
            lengths.append((lengths[parent] if parent >= 0 else 1.0) * (above or 1.0) * (own or 1.0))
        return lengths

    def fold(self, *, moving: bool) -> FoldedPose:
        count, joint_count = self.frame_count if moving else 1, len(self.joints)
        arrays = [np.empty((count, joint_count, width)) for width in (3, 4, 3)]
        sheared = False
        for i in range(joint_count):
            *parts, joint_sheared = self._fold_joint(i, moving=moving)
            sheared |= joint_sheared
            for array, part in zip(arrays, parts, strict=True):
                array[:, i] = part
        return FoldedPose(
            parents=self.parents, translations=arrays[0], rotations=arrays[1], scales=arrays[2], sheared=sheared
        )

    def _fold_joint(self, i: int, *, moving: bool) -> tuple[FloatArray, FloatArray, FloatArray, bool]:
        local = self._local(self.joints[i], moving=moving)
        above, own = self.factors[i]
        scale = local.scale if own is None else np.ones_like(local.scale)
        translation, rotation, sheared = local.translation, local.rotation, False
        if self.above[i]:
            outer = self._matrices_above(i, moving=moving)
            matrices = outer @ _Local(translation, rotation, scale).to_matrices()
            if above is not None:
                matrices[:, :3, :3] /= above
            translation, rotation, scale, sheared = split_matrix(self.file, matrices, f"nodes[{self.joints[i]}]")
        length = self.lengths[self.parents[i]] if self.parents[i] >= 0 else 1.0
        return translation * length, rotation, scale, sheared


def _uniform_scale(upper: FloatArray) -> float | None:
    """Give the one factor by which linear maps [F, 3, 3] scale at all times, None where there is none."""
    squares = np.swapaxes(upper, 1, 2) @ upper
    factor = float(np.sqrt(np.trace(squares[0]) / 3.0))
    if not factor > 0.0 or not np.isfinite(factor) or np.any(np.linalg.det(upper) <= 0.0):
        return None
    return factor if bool(np.all(np.abs(squares / factor**2 - np.eye(3)) <= 2.0 * _SAME_SCALE)) else None


def _agreed(factors: Sequence[float | None]) -> float | None:
    rest, moving = factors
    if rest is None or moving is None or abs(moving - rest) > _SAME_SCALE * rest:
        return None
    return rest
