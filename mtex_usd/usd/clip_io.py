"""Clips out of stages and into files."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, Vt
from scipy.spatial.transform import Rotation

from mtex_usd.errors import InputError
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import FloatArray, Skeleton
from mtex_usd.usd.animation import sample_take
from mtex_usd.usd.arguments import FilePath, PrimPath, as_file_path, as_prim_path
from mtex_usd.usd.atomic import check_target, mark_layer, write_layer
from mtex_usd.usd.diagnostics import open_layer
from mtex_usd.usd.names import make_prim_name, make_unique
from mtex_usd.usd.sampled_clip import to_clip
from mtex_usd.usd.schema import read_take_settings
from mtex_usd.usd.skeletons import find_bindings, find_take_skeleton, make_bare_skeleton, read_skeleton

__all__ = ["ClipReader", "read_clip", "write_clip"]

_FILE_ENDING = re.compile(r"\.[A-Za-z]\w*$")
_STAGE_AXES = {UsdGeom.Tokens.y: np.array([0.0, 1.0, 0.0]), UsdGeom.Tokens.z: np.array([0.0, 0.0, 1.0])}
_SAME_AXIS = 1e-6
_REAL_LAST = [1, 2, 3, 0]  # as USD keeps quaternions in memory


def read_clip(stage_or_file: Usd.Stage | FilePath, prim_path: PrimPath) -> Clip:
    """Read an animation on all joints of its skeleton.

    Parameters
    ----------
    stage_or_file
        A stage, read as it is composed, or a file to open.
    prim_path
        A SkelAnimation. Its MtexTakeAPI, where applied, limits the range and may name the skeleton.

    Returns
    -------
    Clip
        At the animation's own rate; an animation of hand-set keys at the stage's. Without any Skeleton the rest is that
        of :func:`mtex_usd.usd.skeletons.make_bare_skeleton`.

    Raises
    ------
    InputError
        Where the file cannot be opened, the path names no SkelAnimation (lists those there are), or its values are bad.
    StageError
        Where the animation or its Skeleton is incomplete.

    Examples
    --------
    >>> clip = read_clip("takes.usd", "/Takes/take_07_01")  # doctest: +SKIP
    >>> clip.rotations.shape  # doctest: +SKIP
    (315, 31, 4)
    """
    asked = as_prim_path(prim_path, "prim_path")
    stage = stage_or_file if isinstance(stage_or_file, Usd.Stage) else _open_stage(stage_or_file)
    prim = stage.GetPrimAtPath(asked) if Sdf.Path.IsValidPathString(asked) else None
    if not prim:
        there_are = [str(prim.GetPath()) for prim in stage.Traverse() if prim.IsA("SkelAnimation")]
        raise InputError(
            f"{stage.GetRootLayer().identifier} has no prim {asked}",
            expected="the path of a SkelAnimation",
            fix=f"There are: {', '.join(there_are) or 'none'}.",
        )
    return ClipReader(stage).read_take(prim)


class ClipReader:
    """Reads what belongs to the clips of one stage; walks the stage and reads each Skeleton once.

    Parameters
    ----------
    stage
        The composed stage, which must not change meanwhile.
    """

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        self._bindings = find_bindings(stage)
        self._skeletons: dict[Sdf.Path, Skeleton] = {}

    def read_skeleton(self, prim: Usd.Prim) -> Skeleton:
        """Read a Skeleton prim, as :func:`mtex_usd.usd.skeletons.read_skeleton`; the same prim, the same object."""
        prim_path = prim.GetPath()
        if prim_path not in self._skeletons:
            self._skeletons[prim_path] = read_skeleton(prim)
        return self._skeletons[prim_path]

    def find_skeleton(self, prim: Usd.Prim) -> Usd.Prim | None:
        """Find the Skeleton of a take, as :func:`mtex_usd.usd.skeletons.find_take_skeleton`."""
        return find_take_skeleton(prim, read_take_settings(prim), bindings=self._bindings)

    def read_take(self, prim: Usd.Prim, *, skeleton: Skeleton | None = None) -> Clip:
        """Read a take on all joints of its skeleton, at its own rate and within its usable range.

        Parameters
        ----------
        prim
            A SkelAnimation.
        skeleton
            Whose joints a take without a Skeleton is read on, those it has and those above, if it has no others.

        Returns
        -------
        Clip
            Named as the prim's path.

        Raises
        ------
        InputError, StageError
            As :func:`read_clip`.
        """
        samples = sample_take(self._stage, prim, read_take_settings(prim))
        bound = self.find_skeleton(prim)
        if bound:
            return to_clip(samples, self.read_skeleton(bound))
        if skeleton is not None and set(samples.joints) <= set(skeleton.joints):
            return to_clip(samples, _cut_skeleton(skeleton, samples.joints))
        return to_clip(samples, make_bare_skeleton(samples, self._stage))


def _cut_skeleton(skeleton: Skeleton, joints: Sequence[str]) -> Skeleton:
    """Leave out what is neither one of some joints nor above one."""
    kept = {skeleton.joints.index(joint) for joint in joints}
    for joint in range(len(skeleton.joints) - 1, -1, -1):  # parents come before their children
        if joint in kept and skeleton.parents[joint] >= 0:
            kept.add(int(skeleton.parents[joint]))
    order = sorted(kept)
    return replace(skeleton, joints=tuple(skeleton.joints[joint] for joint in order), rest=skeleton.rest[order])


def _open_stage(file_path: FilePath) -> Usd.Stage:
    return Usd.Stage.Open(open_layer(as_file_path(file_path, "stage or file")))


def write_clip(clip: Clip, file_path: FilePath, prim_path: PrimPath) -> str:
    """Write a clip and its skeleton to a new USD file, whole or not at all.

    Parameters
    ----------
    clip
        Any clip; rotations and translations are stored in single precision, scales in half.
    file_path
        A name ending in .usd, .usda or .usdc. A file there is replaced only if this function wrote it.
    prim_path
        Where the animation goes; the Skeleton goes beside it, bound to it. Names that USD does not allow are made
        valid: ``/Takes/07_01.bvh`` becomes ``/Takes/take_07_01``.

    Returns
    -------
    str
        The path of the SkelAnimation in the file. :func:`read_clip` gives the clip back: rest, rate, start and all.

    Raises
    ------
    InputError
        Where the path is not absolute, or the file cannot or must not be written.
    """
    target = as_file_path(file_path, "file_path")
    check_target(target, "clip")
    animation_path = _valid_path(as_prim_path(prim_path, "prim_path"))
    parent = animation_path.GetParentPath()
    skeleton_path = parent.AppendChild(make_unique("Skeleton", {animation_path.name}))
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    with Sdf.ChangeBlock():
        _author_metadata(layer, clip, animation_path)
        for ancestor in parent.GetPrefixes():
            _define(layer, ancestor, "SkelRoot" if ancestor.IsRootPrimPath() else "Scope")
        _author_skeleton(_define(layer, skeleton_path, "Skeleton"), clip.skeleton, animation_path)
        _author_animation(_define(layer, animation_path, "SkelAnimation"), clip)
    write_layer(layer, target)
    return str(animation_path)


def _valid_path(prim_path: str) -> Sdf.Path:
    names = prim_path.removeprefix("/").split("/")
    if not prim_path.startswith("/") or not all(names):
        raise InputError(f'"{prim_path}" is no path for a clip', expected='an absolute path such as "/Takes/walk"')
    last = names.pop()
    last = last if Sdf.Path.IsValidIdentifier(last) else _FILE_ENDING.sub("", last)
    valid = [make_prim_name(name, prefix="_") for name in names] + [make_prim_name(last, prefix="take_")]
    return Sdf.Path("/" + "/".join(valid))


def _up_axis(skeleton: Skeleton) -> str | None:
    """Name the axis that is up; None where a transform has to bring the skeleton upright."""
    return next((axis for axis, up in _STAGE_AXES.items() if np.abs(skeleton.up - up).max() <= _SAME_AXIS), None)


def _author_metadata(layer: Sdf.Layer, clip: Clip, animation_path: Sdf.Path) -> None:
    mark_layer(layer, "clip")
    layer.timeCodesPerSecond = clip.rate * clip.time_codes_per_frame
    layer.framesPerSecond = clip.rate
    layer.startTimeCode, layer.endTimeCode = float(clip.time_codes[0]), float(clip.time_codes[-1])
    layer.defaultPrim = animation_path.GetPrefixes()[0].name
    root = layer.pseudoRoot
    root.SetInfo(UsdGeom.Tokens.upAxis, _up_axis(clip.skeleton) or UsdGeom.Tokens.y)
    root.SetInfo(UsdGeom.Tokens.metersPerUnit, clip.skeleton.meters_per_unit)


def _define(layer: Sdf.Layer, prim_path: Sdf.Path, type_name: str) -> Sdf.PrimSpec:
    spec = Sdf.CreatePrimInLayer(layer, prim_path)
    spec.specifier = Sdf.SpecifierDef
    spec.typeName = type_name
    return spec


def _set_uniform(spec: Sdf.PrimSpec, name: str, type_name: Sdf.ValueTypeName, value: object) -> None:
    Sdf.AttributeSpec(spec, name, type_name, Sdf.VariabilityUniform).default = value


def _matrices(values: FloatArray) -> Vt.Matrix4dArray:
    return Vt.Matrix4dArray.FromNumpy(np.ascontiguousarray(values))  # type: ignore[no-any-return, no-untyped-call]


def _author_skeleton(spec: Sdf.PrimSpec, skeleton: Skeleton, animation_path: Sdf.Path) -> None:
    bind = skeleton.rest.copy()
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            bind[joint] = bind[joint] @ bind[parent]
    _set_uniform(spec, "joints", Sdf.ValueTypeNames.TokenArray, Vt.TokenArray(skeleton.joints))
    _set_uniform(spec, "restTransforms", Sdf.ValueTypeNames.Matrix4dArray, _matrices(skeleton.rest))
    _set_uniform(spec, "bindTransforms", Sdf.ValueTypeNames.Matrix4dArray, _matrices(bind))
    spec.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=["SkelBindingAPI"]))
    Sdf.RelationshipSpec(spec, "skel:animationSource", custom=False).targetPathList.explicitItems = [animation_path]
    if _up_axis(skeleton) is None:
        _turn_upright(spec, skeleton)


def _turn_upright(spec: Sdf.PrimSpec, skeleton: Skeleton) -> None:
    turn, _ = Rotation.align_vectors([_STAGE_AXES[UsdGeom.Tokens.y]], [skeleton.up])
    matrix = np.eye(4)
    matrix[:3, :3] = turn.as_matrix().T  # USD multiplies row vectors
    Sdf.AttributeSpec(spec, "xformOp:transform", Sdf.ValueTypeNames.Matrix4d).default = Gf.Matrix4d(matrix)
    _set_uniform(spec, "xformOpOrder", Sdf.ValueTypeNames.TokenArray, Vt.TokenArray(["xformOp:transform"]))


def _author_animation(spec: Sdf.PrimSpec, clip: Clip) -> None:
    _set_uniform(spec, "joints", Sdf.ValueTypeNames.TokenArray, Vt.TokenArray(clip.joints))
    kinds = Sdf.ValueTypeNames
    times = clip.time_codes.tolist()
    rotations = np.ascontiguousarray(clip.rotations[..., _REAL_LAST], dtype=np.float32)
    translations = np.ascontiguousarray(clip.translations, dtype=np.float32)
    scales = np.ascontiguousarray(clip.scales, dtype=np.float16)
    _set_samples(spec, "rotations", kinds.QuatfArray, times, map(Vt.QuatfArray.FromNumpy, rotations))
    _set_samples(spec, "translations", kinds.Float3Array, times, map(Vt.Vec3fArray.FromNumpy, translations))
    _set_samples(spec, "scales", kinds.Half3Array, times, map(Vt.Vec3hArray.FromNumpy, scales))


def _set_samples(
    spec: Sdf.PrimSpec, name: str, type_name: Sdf.ValueTypeName, times: list[float], values: Iterable[object]
) -> None:
    attribute_path = Sdf.AttributeSpec(spec, name, type_name).path
    for time_code, value in zip(times, values, strict=True):
        spec.layer.SetTimeSample(attribute_path, time_code, value)
