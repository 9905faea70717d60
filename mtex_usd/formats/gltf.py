"""Files in glTF 2.0 (.gltf, .glb): the motion of their skins' joints as arrays.

Each animation gives one recording for every skeleton that it moves. What stands between and above the joints and is no
joint itself is folded into them, moving or not, so that a root's transform is the one in the file's world: Y up,
metres. A uniform scale that never changes is taken into the translations below it, as bone lengths, and leaves the
scales 1.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mtex_usd.formats.gltf_container import FloatArray, GltfFile, open_gltf
from mtex_usd.formats.gltf_curves import GltfCurve, read_curve
from mtex_usd.formats.gltf_fold import FoldedPose, fold_pose
from mtex_usd.formats.gltf_nodes import GltfNode, JointGroup, group_joints, read_nodes
from mtex_usd.formats.recording import NoMotionError, Recording
from mtex_usd.motion import quaternion, timing

__all__ = ["DEFAULT_RATE", "read_gltf"]

DEFAULT_RATE = 30.0
"""Frames per second where the keys are not evenly spaced and the caller does not tell."""

_WIDTHS = {"translation": 3, "rotation": 4, "scale": 3}
_SLOWEST, _FASTEST = 10.0, 1000.0  # frames per second; keys further apart are hand-set, closer ones a mistake
_NTSC = 1.001
_MOST_FRAMES = 1_000_000
_MOST_NUMBERS = 400_000_000
_FRAME_FITS = 1e-4
_REAL_FIRST = [3, 0, 1, 2]

_Curves = dict[tuple[int, str], GltfCurve]


def read_gltf(file_path: Path, *, rate: float | None = None) -> tuple[Recording, ...]:
    """Read all motions of a glTF file.

    Parameters
    ----------
    file_path
        Text or binary.
    rate
        Frames per second to sample at; where None that of the keys, else 30.

    Returns
    -------
    tuple of Recording
        One for each animation and skeleton it moves, from its first key through its last. `clip` is the animation's
        name where there are several.

    Raises
    ------
    FormatError
        Where the file is malformed, saying where; :class:`~mtex_usd.formats.recording.NoMotionError` where nothing in
        it moves a joint.
    """
    file = open_gltf(file_path)
    nodes = read_nodes(file)
    animations = [_read_animation(file, i, raw) for i, raw in enumerate(file.pick_all("animations"))]
    driven = {node for animation in animations for node, _ in animation.curves}
    groups = group_joints(file, nodes, driven)
    found = [
        (animation, group, curves)
        for animation in animations
        for group in groups
        if (curves := _pick_curves(nodes, group, animation.curves))
    ]
    if not found:
        raise NoMotionError(file_path, None, "has no animation of joints")
    clips = _name_clips(nodes, [(animation, group) for animation, group, _ in found])
    return tuple(
        _record(file, nodes, group, curves, clip=clip, rate=rate)
        for (_, group, curves), clip in zip(found, clips, strict=True)
    )


@dataclass(frozen=True, eq=False)
class _Animation:
    name: str
    curves: _Curves


def _read_animation(file: GltfFile, index: int, raw: Any) -> _Animation:
    curves: _Curves = {}
    what = f"animations[{index}]"
    for i, channel in enumerate(raw.channels if isinstance(raw.channels, list) else []):
        place = f"{what}.channels[{i}]"
        target = _read_target(file, file.check_object(channel, place))
        if target is None:
            continue
        if target in curves:
            raise file.error(f"{what} moves the {target[1]} of nodes[{target[0]}] twice")
        sampler = _pick_sampler(file, raw, channel.sampler, place)
        curves[target] = read_curve(file, sampler, width=_WIDTHS[target[1]], what=f"{what}.samplers[{channel.sampler}]")
    return _Animation(raw.name if isinstance(raw.name, str) and raw.name else f"animation_{index}", curves)


def _read_target(file: GltfFile, channel: Any) -> tuple[int, str] | None:
    """Give the node and property a channel moves; None for morph weights and the targets of extensions."""
    node, path = getattr(channel.target, "node", None), getattr(channel.target, "path", None)
    if node is None or not isinstance(path, str) or path not in _WIDTHS:
        return None
    file.pick("nodes", node)
    return node, path


def _pick_sampler(file: GltfFile, raw: Any, index: object, place: str) -> Any:
    samplers = raw.samplers if isinstance(raw.samplers, list) else []
    if isinstance(index, bool) or not isinstance(index, int) or not 0 <= index < len(samplers):
        raise file.error(f"{place}: there is no sampler {str(index)[:20]}")
    return file.check_object(samplers[index], f"the sampler {index} of {place}")


def _pick_curves(nodes: Sequence[GltfNode], group: JointGroup, curves: _Curves) -> _Curves:
    """Give the curves of the joints and of what stands above them."""
    involved: set[int] = set()
    for joint in group.joints:
        node = joint
        while node >= 0 and node not in involved:
            involved.add(node)
            node = nodes[node].parent
    return {target: curve for target, curve in curves.items() if target[0] in involved}


def _name_clips(nodes: Sequence[GltfNode], found: Sequence[tuple[_Animation, JointGroup]]) -> list[str]:
    """Name each motion by its animation, and by its skeleton where that is not enough; one alone needs no name."""
    if len(found) == 1:
        return [""]
    names = [animation.name for animation, _ in found]
    if len({group for _, group in found}) == 1:
        return names
    return [f"{animation.name}_{group.name or nodes[group.joints[0]].name}" for animation, group in found]


def _record(
    file: GltfFile, nodes: Sequence[GltfNode], group: JointGroup, curves: _Curves, *, clip: str, rate: float | None
) -> Recording:
    times, rate = _choose_times(file, curves, rate, joint_count=len(group.joints))
    with np.errstate(all="ignore"):  # of absurd but finite keys; checked below
        rest, pose = fold_pose(file, nodes, group.joints, _sample_curves(curves, times), frame_count=len(times))
    _check_finite(file, rest)
    _check_finite(file, pose)
    return Recording(
        source=file.file_path,
        names=tuple(nodes[joint].name for joint in group.joints),
        parents=pose.parents,
        offsets=rest.translations[0],
        rate=rate,
        rotations=quaternion.unroll(pose.rotations[..., _REAL_FIRST]),
        translations=pose.translations,
        scales=None if pose.has_unit_scales and rest.has_unit_scales else pose.scales,
        rest=_to_usd_matrices(rest),
        meters_per_unit=1.0,
        up_axis="Y",
        clip=clip,
        companions=tuple(file.companions),
        notes=("shear above a joint is left out, which USD animations cannot hold",) if pose.sheared else (),
    )


def _sample_curves(curves: _Curves, times: FloatArray) -> Mapping[tuple[int, str], FloatArray]:
    return {target: curve.sample(times) for target, curve in curves.items()}


def _choose_times(file: GltfFile, curves: _Curves, rate: float | None, *, joint_count: int) -> tuple[FloatArray, float]:
    """Lay frames from the first key through the last; give their times in seconds and the rate."""
    keys = np.unique(np.concatenate([curve.times for curve in curves.values()]))
    rate = rate or _measure_rate(keys) or DEFAULT_RATE
    frames = (keys[-1] - keys[0]) * rate
    if not (frames < _MOST_FRAMES and frames * joint_count * 10 < _MOST_NUMBERS):
        raise file.error(
            f"an animation lasts {keys[-1] - keys[0]:.6g} s, which at {rate:g} frames/s is too long to read"
        )
    count = int(np.floor(frames + _FRAME_FITS)) + 1
    return keys[0] + np.arange(count) / rate, rate


def _measure_rate(keys: FloatArray) -> float | None:
    """Give the rate of evenly spaced keys, rounded to the whole or NTSC rate that was meant; None for others."""
    step = timing.find_even_step(keys)
    if step is None or not _SLOWEST <= 1.0 / step <= _FASTEST:
        return None
    likely = [round(1.0 / step), round(_NTSC / step) / _NTSC]
    return 1.0 / timing.prefer_step(keys, step, [1.0 / rate for rate in likely])


def _check_finite(file: GltfFile, pose: FoldedPose) -> None:
    if not all(np.all(np.isfinite(values)) for values in (pose.translations, pose.rotations, pose.scales)):
        raise file.error("a joint's transform is not finite")


def _to_usd_matrices(rest: FoldedPose) -> FloatArray:
    from scipy.spatial.transform import Rotation  # noqa: PLC0415  (slow to import)

    matrices = np.tile(np.eye(4), (len(rest.parents), 1, 1))
    turned = np.swapaxes(Rotation.from_quat(rest.rotations[0]).as_matrix(), 1, 2)  # USD multiplies row vectors
    matrices[:, :3, :3] = rest.scales[0][:, :, None] * turned
    matrices[:, 3, :3] = rest.translations[0]
    return matrices
