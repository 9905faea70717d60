"""The node tree of a glTF file, and which nodes are the joints of a skeleton."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mtex_usd.formats.gltf_container import FloatArray, GltfFile

__all__ = ["GltfNode", "JointGroup", "group_joints", "read_nodes", "split_matrix"]

_SHORTEST = 1e-12
_SHEARED = 1e-3


@dataclass(frozen=True, eq=False, kw_only=True)
class GltfNode:
    """A node as the document has it, at rest.

    Parameters
    ----------
    name
        Its name; ``node_3`` where it has none.
    parent
        Index of its parent, -1 for a root.
    translation, rotation, scale
        Relative to the parent, shapes [3], [4] (real part last, as glTF has them) and [3].
    """

    name: str
    parent: int
    translation: FloatArray
    rotation: FloatArray
    scale: FloatArray

    @property
    def rest(self) -> dict[str, FloatArray]:
        """The three properties by the names that animation channels use."""
        return {"translation": self.translation, "rotation": self.rotation, "scale": self.scale}


@dataclass(frozen=True, kw_only=True)
class JointGroup:
    """The joints of one skeleton: those of all skins that hang together.

    Parameters
    ----------
    name
        That of the first skin; may be empty.
    joints
        Node indices, a parent before its children.
    """

    name: str
    joints: tuple[int, ...]


def read_nodes(file: GltfFile) -> tuple[GltfNode, ...]:
    """Read and check the node tree.

    Parameters
    ----------
    file
        The file.

    Raises
    ------
    FormatError
        Where a node has two parents, is its own ancestor, or a transform is malformed.
    """
    raw = file.pick_all("nodes")
    parents = _find_parents(file, raw)
    _check_tree(file, parents)
    return tuple(_read_node(file, i, node, parents[i]) for i, node in enumerate(raw))


def _find_parents(file: GltfFile, raw: Sequence[Any]) -> list[int]:
    parents = [-1] * len(raw)
    for i, node in enumerate(raw):
        children = node.children or []
        for child in children if isinstance(children, list) else [children]:
            file.pick("nodes", child)
            if parents[child] >= 0:
                raise file.error(f"nodes[{child}] has two parents, nodes[{parents[child]}] and nodes[{i}]")
            parents[child] = i
    return parents


def _check_tree(file: GltfFile, parents: Sequence[int]) -> None:
    """Make sure that every node hangs on a root; each is walked once."""
    rooted: set[int] = {-1}
    for first in range(len(parents)):
        trail: dict[int, None] = {}
        node = first
        while node not in rooted:
            if node in trail:
                raise file.error(f"nodes[{node}] is its own ancestor")
            trail[node] = None
            node = parents[node]
        rooted.update(trail)


def _read_node(file: GltfFile, index: int, node: Any, parent: int) -> GltfNode:
    what = f"nodes[{index}]"
    name = node.name if isinstance(node.name, str) and node.name else f"node_{index}"
    if node.matrix is not None:
        matrix = _read_vector(file, node.matrix, f"{what}.matrix", np.eye(4).ravel()).reshape(4, 4).T
        translation, rotation, scale, _ = split_matrix(file, matrix[None], what)
        return GltfNode(name=name, parent=parent, translation=translation[0], rotation=rotation[0], scale=scale[0])
    rotation = _read_vector(file, node.rotation, f"{what}.rotation", np.array([0.0, 0.0, 0.0, 1.0]))
    length = float(np.linalg.norm(rotation))
    if length < _SHORTEST:
        raise file.error(f"{what}.rotation has no length")
    return GltfNode(
        name=name,
        parent=parent,
        translation=_read_vector(file, node.translation, f"{what}.translation", np.zeros(3)),
        rotation=rotation / length,
        scale=_read_vector(file, node.scale, f"{what}.scale", np.ones(3)),
    )


def _read_vector(file: GltfFile, value: Any, what: str, default: FloatArray) -> FloatArray:
    if value is None:
        return default
    numbers = value if isinstance(value, list) else []
    good = all(isinstance(number, int | float) and abs(number) < 1e30 for number in numbers)
    if len(numbers) != len(default) or not good:
        raise file.error(f"{what} should be {len(default)} numbers, found {str(value)[:60]}")
    return np.array(numbers, dtype=np.float64)


def split_matrix(file: GltfFile, matrices: FloatArray, what: str) -> tuple[FloatArray, FloatArray, FloatArray, bool]:
    """Split transforms into translation, rotation and scale.

    Parameters
    ----------
    file
        For the message.
    matrices
        Column vectors, shape [F, 4, 4].
    what
        What messages call them.

    Returns
    -------
    tuple
        Translations [F, 3], rotations [F, 4] (real part last), scales [F, 3], and whether shear had to be left out.

    Raises
    ------
    FormatError
        Where an axis has no length, so that there is no rotation.
    """
    from scipy.spatial.transform import Rotation  # noqa: PLC0415  (slow to import, seldom needed)

    upper = matrices[:, :3, :3]
    scales = np.linalg.norm(upper, axis=1)
    if np.any(scales < _SHORTEST):
        raise file.error(f"{what} is scaled to nothing, so it has no rotation")
    # All three axes are mirrored where one is, as UsdSkel takes a mirrored transform apart.
    scales = np.where(np.linalg.det(upper) < 0.0, -1.0, 1.0)[:, None] * scales
    axes = upper / scales[:, None, :]
    sheared = bool(np.any(np.abs(np.swapaxes(axes, 1, 2) @ axes - np.eye(3)) > _SHEARED))
    return matrices[:, :3, 3], Rotation.from_matrix(axes).as_quat(), scales, sheared


def group_joints(file: GltfFile, nodes: Sequence[GltfNode], driven: Iterable[int]) -> tuple[JointGroup, ...]:
    """Find the skeletons.

    Parameters
    ----------
    file, nodes
        The file and its nodes.
    driven
        Nodes that animations move, which are the joints of a file without skins.

    Returns
    -------
    tuple of JointGroup
        In the order of their first skins. Skins that share joints, or whose joints hang on one another's, are one.

    Raises
    ------
    FormatError
        Where a skin names a node that is not there.
    """
    skins = [(_skin_name(skin), _skin_joints(file, i, skin)) for i, skin in enumerate(file.pick_all("skins"))]
    if not skins:
        skins = [("", tuple(driven))]
    order = _walk(nodes)
    every = {joint for _, joints in skins for joint in joints}
    top_of = _find_tops(nodes, order, every)
    groups: list[tuple[str, set[int]]] = []
    for name, joints in skins:
        tops = {top_of[joint] for joint in joints}
        meeting = [group for group in groups if group[1] & tops]
        merged = tops.union(*(group[1] for group in meeting))
        place = groups.index(meeting[0]) if meeting else len(groups)
        groups = [group for group in groups if not group[1] & tops]
        groups.insert(place, (meeting[0][0] if meeting else name, merged))
    return tuple(
        JointGroup(name=name, joints=tuple(node for node in order if node in every and top_of[node] in tops))
        for name, tops in groups
        if tops
    )


def _skin_name(skin: Any) -> str:
    return skin.name if isinstance(skin.name, str) else ""


def _skin_joints(file: GltfFile, index: int, skin: Any) -> tuple[int, ...]:
    joints = skin.joints if isinstance(skin.joints, list) else []
    for joint in joints:
        file.pick("nodes", joint)
    if not joints:
        raise file.error(f"skins[{index}] has no joints")
    return tuple(joints)


def _walk(nodes: Sequence[GltfNode]) -> list[int]:
    """Give all nodes depth first."""
    children: dict[int, list[int]] = {}
    for i, node in enumerate(nodes):
        children.setdefault(node.parent, []).append(i)
    order: list[int] = []
    waiting = children.get(-1, [])[::-1]
    while waiting:
        order.append(waiting.pop())
        waiting += children.get(order[-1], [])[::-1]
    return order


def _find_tops(nodes: Sequence[GltfNode], order: Sequence[int], joints: set[int]) -> dict[int, int]:
    """Give the topmost joint at or above each node, -1 where there is none."""
    tops = {-1: -1}
    for node in order:
        above = tops[nodes[node].parent]
        tops[node] = node if above < 0 and node in joints else above
    return tops
