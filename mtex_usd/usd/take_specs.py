"""The prims of a take library, authored on the layer with Sdf: it has no schemas to register, and it is fastest."""

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt
from pxr import Gf, Sdf, Vt

from mtex_usd.formats.recording import ChannelLimit, Recording

__all__ = ["author_samples", "author_skeleton", "author_take_api", "define_prim", "read_matrices", "set_uniform"]

FloatArray = npt.NDArray[np.float64]

_UNIFORM = Sdf.VariabilityUniform
_REAL_LAST = [1, 2, 3, 0]  # as Vt's quaternion buffers have them
_TRANSFORM = "xformOp:transform"


def define_prim(layer: Sdf.Layer, prim_path: Sdf.Path, type_name: str) -> Sdf.PrimSpec:
    """Define a typed prim."""
    spec = Sdf.CreatePrimInLayer(layer, prim_path)
    spec.specifier = Sdf.SpecifierDef
    spec.typeName = type_name
    return spec


def set_uniform(
    spec: Sdf.PrimSpec, name: str, type_name: Sdf.ValueTypeName, value: object, *, custom: bool = False
) -> None:
    """Author an attribute that holds one value for all time."""
    Sdf.AttributeSpec(spec, name, type_name, _UNIFORM, custom).default = value


def author_skeleton(
    spec: Sdf.PrimSpec, recording: Recording, joints: tuple[str, ...], placement: FloatArray | None
) -> None:
    """Author joints, rest and bind pose, limits, and the names the file has for the joints.

    Parameters
    ----------
    spec
        A Skeleton.
    recording
        Gives the rest.
    joints
        Its joint paths.
    placement
        Transform from skeleton space to the library's world, shape [4, 4]; None where they are the same.
    """
    kinds = Sdf.ValueTypeNames
    set_uniform(spec, "joints", kinds.TokenArray, joints)
    set_uniform(spec, "restTransforms", kinds.Matrix4dArray, _to_matrices(recording.rest_transforms))
    set_uniform(spec, "bindTransforms", kinds.Matrix4dArray, _to_matrices(recording.bind_transforms))
    data: dict[str, object] = {"jointNames": Vt.StringArray(recording.names)}
    if recording.dof_axes is not None:
        data["limitAxes"] = Vt.QuatdArray.FromNumpy(np.ascontiguousarray(recording.dof_axes[:, _REAL_LAST]))  # type: ignore[no-untyped-call]
    spec.SetInfo("customData", {"mtex": data})
    for limit in recording.limits:
        _author_limit(spec, joints, limit)
    if placement is not None:
        Sdf.AttributeSpec(spec, _TRANSFORM, kinds.Matrix4d).default = Gf.Matrix4d(placement)
        set_uniform(spec, "xformOpOrder", kinds.TokenArray, Vt.TokenArray([_TRANSFORM]))


def _author_limit(spec: Sdf.PrimSpec, joints: tuple[str, ...], limit: ChannelLimit) -> None:
    # A property name holds no dot: the channel LeftLeg.rx becomes mtex:limits:LeftLeg:rx.
    name = f"mtex:limits:{joints[limit.joint].rpartition('/')[2]}:{limit.channel}"
    value = Gf.Vec2d(limit.lower, limit.upper)
    set_uniform(spec, name, Sdf.ValueTypeNames.Double2, value, custom=True)


def read_matrices(spec: Sdf.PrimSpec, name: str) -> FloatArray | None:
    """Give a matrix attribute's default, shape [4, 4] or [N, 4, 4]; None where it has none."""
    attribute = spec.attributes.get(name)
    if attribute is None or attribute.default is None:
        return None
    return np.array(attribute.default, dtype=np.float64)


def _to_matrices(matrices: FloatArray) -> Vt.Matrix4dArray:
    return Vt.Matrix4dArray.FromNumpy(np.ascontiguousarray(matrices))  # type: ignore[no-any-return, no-untyped-call]


def author_take_api(spec: Sdf.PrimSpec, skeleton_path: Sdf.Path, end: float, style: str) -> None:
    """Apply MtexTakeAPI by its metadata, so that the schema need not be registered.

    Parameters
    ----------
    spec
        A SkelAnimation whose samples start at time code 0.
    skeleton_path
        Its Skeleton.
    end
        Time code of the last frame.
    style
        Not authored where empty.
    """
    schemas = Sdf.TokenListOp()
    schemas.prependedItems = ["MtexTakeAPI"]
    spec.SetInfo("apiSchemas", schemas)
    set_uniform(spec, "mtex:take:start", Sdf.ValueTypeNames.TimeCode, Sdf.TimeCode(0.0))
    set_uniform(spec, "mtex:take:end", Sdf.ValueTypeNames.TimeCode, Sdf.TimeCode(end))
    if style:
        set_uniform(spec, "mtex:take:style", Sdf.ValueTypeNames.Token, style)
    relationship = Sdf.RelationshipSpec(spec, "mtex:take:skeleton", False, _UNIFORM)  # noqa: FBT003
    relationship.targetPathList.explicitItems = [skeleton_path]


def author_samples(spec: Sdf.PrimSpec, recording: Recording, time_codes: FloatArray) -> None:
    """Author rotations, translations and scales, without a scale that is 1 throughout at every frame.

    Parameters
    ----------
    spec
        A SkelAnimation.
    recording
        Gives the values.
    time_codes
        Of the frames, shape [F].
    """
    kinds, times = Sdf.ValueTypeNames, time_codes.tolist()
    rotations = np.ascontiguousarray(recording.rotations[..., _REAL_LAST], dtype=np.float32)
    translations = np.ascontiguousarray(recording.translations, dtype=np.float32)
    _author_array(spec, "rotations", kinds.QuatfArray, times, map(Vt.QuatfArray.FromNumpy, rotations))
    _author_array(spec, "translations", kinds.Float3Array, times, map(Vt.Vec3fArray.FromNumpy, translations))
    if recording.scales is not None:
        scales = np.ascontiguousarray(recording.scales, dtype=np.float16)
        _author_array(spec, "scales", kinds.Half3Array, times, map(Vt.Vec3hArray.FromNumpy, scales))
        return
    # UsdSkel reads no transforms at all where one of the three is missing.
    attribute = Sdf.AttributeSpec(spec, "scales", kinds.Half3Array)
    attribute.default = Vt.Vec3hArray([Gf.Vec3h(1.0)] * len(recording.names))


def _author_array(
    spec: Sdf.PrimSpec, name: str, type_name: Sdf.ValueTypeName, times: list[float], values: Iterable[object]
) -> None:
    path = Sdf.AttributeSpec(spec, name, type_name).path
    for time_code, value in zip(times, values, strict=True):
        spec.layer.SetTimeSample(path, time_code, value)
