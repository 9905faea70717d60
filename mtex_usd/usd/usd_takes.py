"""USD stages as sources of takes: every SkelAnimation, read as the recipe's takes are."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pxr import Sdf, Tf, Usd, UsdGeom, UsdSkel

from mtex_usd.errors import InputError, MtexError
from mtex_usd.formats.recording import FormatError, NoMotionError, Recording
from mtex_usd.formats.source_text import LARGEST
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import FloatArray
from mtex_usd.usd.atomic import layer_kind
from mtex_usd.usd.clip_io import ClipReader
from mtex_usd.usd.diagnostics import describe_error
from mtex_usd.usd.schema import read_take_settings
from mtex_usd.usd.stage_rate import stage_rate

__all__ = ["UsdTakes", "read_usd"]

_SUFFIXES = {b"#usda": ".usda", b"PXR-": ".usdc", b"PK\x03\x04": ".usdz"}
_TYPES = {
    "joints": Sdf.ValueTypeNames.TokenArray,
    "rotations": Sdf.ValueTypeNames.QuatfArray,
    "translations": Sdf.ValueTypeNames.Float3Array,
    "scales": Sdf.ValueTypeNames.Half3Array,
    "restTransforms": Sdf.ValueTypeNames.Matrix4dArray,
    "bindTransforms": Sdf.ValueTypeNames.Matrix4dArray,
}
_POSES = ("restTransforms", "bindTransforms")
_FLATTEST = 1e-6  # of the box that a joint's axes span, each of length 1
_MOST_FRAMES = 1_000_000
_OUTPUTS = {"override", "stage"}
_DAMAGE = (Tf.ErrorException, UnicodeDecodeError)  # what USD's functions raise at damaged values
_KNOWN = {".usd", ".usda", ".usdc", ".usdz"}


@dataclass(frozen=True, eq=False, kw_only=True)
class UsdTakes:
    """The animations of a stage.

    Parameters
    ----------
    recordings
        Those that could be read.
    failures
        Why others could not.
    """

    recordings: tuple[Recording, ...]
    failures: tuple[FormatError, ...]


def read_usd(file_path: Path) -> UsdTakes:
    """Read every SkelAnimation of a stage, those in instances once.

    Parameters
    ----------
    file_path
        A .usd, .usda, .usdc or .usdz file; of another name only where it refers to no other files, since USD tells
        formats by their names.

    Returns
    -------
    UsdTakes
        Each at its own rate on all joints of its Skeleton, which keeps its joint paths, rest and place.

    Raises
    ------
    FormatError
        Where USD cannot open it; :class:`~mtex_usd.formats.recording.NoMotionError` where no SkelAnimation has joints.
    """
    try:
        # Damaged numbers may overflow on the way; what comes of them is checked in the end.
        with np.errstate(all="ignore"), _open_stage(file_path) as stage:
            return _read_animations(file_path, stage)
    except _DAMAGE as error:
        raise FormatError(file_path, None, f"cannot be read: {describe_error(error)}") from error


def _read_animations(file_path: Path, stage: Usd.Stage) -> UsdTakes:
    if layer_kind(stage.GetRootLayer()) in _OUTPUTS:
        raise NoMotionError(file_path, None, "is what usdmtex made of a shot, no recording")
    prims = _find_animations(stage)
    if not prims:
        raise NoMotionError(file_path, None, "the stage has no SkelAnimation with joints")
    if UsdGeom.GetStageUpAxis(stage) not in {"Y", "Z"}:
        raise FormatError(file_path, None, f"bad upAxis {UsdGeom.GetStageUpAxis(stage)!r}; expected Y or Z")
    reader = ClipReader(stage)
    recordings, failures = [], []
    for prim in prims:
        try:
            recordings.append(_record(file_path, reader, prim, alone=len(prims) == 1))
        except MtexError as error:
            failures.append(FormatError(file_path, None, str(error)))
        except _DAMAGE as error:
            failures.append(FormatError(file_path, None, f"{prim.GetPath()}: {describe_error(error)}"))
        except (TypeError, ValueError) as error:  # samples of another type than their attribute has
            failures.append(FormatError(file_path, None, f"{prim.GetPath()}: its values are of a wrong type: {error}"))
    return UsdTakes(recordings=tuple(recordings), failures=tuple(failures))


@contextmanager
def _open_stage(file_path: Path) -> Iterator[Usd.Stage]:
    if file_path.suffix in _KNOWN:
        yield Usd.Stage.Open(str(file_path))
        return
    with file_path.open("rb") as file:
        head = file.read(5)
    suffix = next(suffix for magic, suffix in _SUFFIXES.items() if head.startswith(magic))
    with tempfile.TemporaryDirectory() as folder:
        link = Path(folder) / f"stage{suffix}"
        link.symlink_to(file_path.resolve())
        stage = Usd.Stage.Open(str(link))
        if stage.GetRootLayer().GetCompositionAssetDependencies():
            reason = f"refers to other files and has no USD name; rename it to {file_path.stem}{suffix}"
            raise FormatError(file_path, None, reason)
        yield stage


def _find_animations(stage: Usd.Stage) -> list[Usd.Prim]:
    found: dict[Sdf.Path, Usd.Prim] = {}
    for prim in Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)):
        # Without joints it moves blend shapes alone.
        if prim.IsA("SkelAnimation") and prim.GetAttribute("joints").Get():
            origin = prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim
            found.setdefault(origin.GetPath(), prim)
    return list(found.values())


def _check_types(prim: Usd.Prim) -> None:
    """Refuse attributes of another type than UsdSkel's, whose values no reader knows what to do with."""
    for name, type_name in _TYPES.items():
        attribute = prim.GetAttribute(name)
        for spec in attribute.GetPropertyStack() if attribute else ():
            if not isinstance(spec, Sdf.AttributeSpec) or spec.typeName.type != type_name.type:
                found = str(spec.typeName) if isinstance(spec, Sdf.AttributeSpec) else "a relationship"
                raise InputError(f"{attribute.GetPath()} has the wrong type", expected=str(type_name), found=found)


def _check_length(prim: Usd.Prim) -> None:
    """Refuse ranges that no recording has, before every frame of one is read."""
    times = [t for name in ("rotations", "translations", "scales") for t in prim.GetAttribute(name).GetTimeSamples()]
    frames = (max(times) - min(times)) / stage_rate(prim.GetStage()).time_codes_per_frame if times else 0.0
    if not frames <= _MOST_FRAMES:
        raise InputError(
            f"{prim.GetPath()} is too long to read",
            expected=f"at most {_MOST_FRAMES} frames",
            found=f"time samples from {min(times):g} to {max(times):g}",
        )


def _check_skeleton(reader: ClipReader, skeleton: Usd.Prim) -> None:
    """Refuse transforms that are no place or pose, on which arithmetic would fail further on."""
    placement = _read_placement(skeleton)
    for name, values in (("place", placement), *((name, _read_matrices(skeleton, name)) for name in _POSES)):
        # A pose with a number that is none is left to the reader, which takes the other pose.
        if values is not None and np.any(np.abs(values) > LARGEST):
            raise InputError(f"{skeleton.GetPath()}: its {name} has a number too large for any scene")
    if not np.all(np.isfinite(placement)):
        raise InputError(f"{skeleton.GetPath()}: its place is not finite", fix="Correct the transforms above it.")
    rest = reader.read_skeleton(skeleton)
    axes = rest.rest[:, :3, :3]
    volumes = np.abs(np.linalg.det(axes / np.linalg.norm(axes, axis=-1, keepdims=True)))
    if not np.all(volumes > _FLATTEST):
        joint = rest.joints[int(np.argmin(volumes))]
        raise InputError(f"{skeleton.GetPath()}: the rest pose of {joint} is flat, so that it has no rotation")


def _read_matrices(prim: Usd.Prim, name: str) -> FloatArray | None:
    value = prim.GetAttribute(name).Get()
    return None if value is None else np.array(value, dtype=np.float64)


def _record(file_path: Path, reader: ClipReader, prim: Usd.Prim, *, alone: bool) -> Recording:
    skeleton = reader.find_skeleton(prim)
    for part in (prim, skeleton) if skeleton else (prim,):
        _check_types(part)
    _check_length(prim)
    if skeleton:
        _check_skeleton(reader, skeleton)
    clip = reader.read_take(prim)
    stage = prim.GetStage()
    return Recording(
        source=file_path,
        names=tuple(joint.rpartition("/")[2] for joint in clip.joints),
        parents=tuple(map(int, clip.parents)),
        offsets=clip.skeleton.rest_translations,
        rate=clip.rate,
        rotations=clip.rotations,
        translations=clip.translations,
        scales=None if np.all(clip.scales == 1.0) else clip.scales,
        rest=clip.rest,
        bind=_read_bind(skeleton, clip) if skeleton else None,
        joint_paths=clip.joints,
        meters_per_unit=UsdGeom.GetStageMetersPerUnit(stage),
        up_axis=str(UsdGeom.GetStageUpAxis(stage)),
        placement=_read_placement(skeleton) if skeleton else None,
        clip="" if alone else str(prim.GetPath()),
        style=read_take_settings(prim).style,
        companions=_list_other_layers(stage),
        notes=_describe_loss(prim, skeleton) if skeleton else (),
    )


def _list_other_layers(stage: Usd.Stage) -> tuple[Path, ...]:
    """Give the files beside the root layer that the stage is composed of."""
    others = {
        layer.realPath for layer in stage.GetUsedLayers() if layer != stage.GetRootLayer() and not layer.anonymous
    }
    return tuple(Path(path) for path in sorted(others) if Path(path).is_file())


def _read_bind(skeleton: Usd.Prim, clip: Clip) -> FloatArray | None:
    value = UsdSkel.Skeleton(skeleton).GetBindTransformsAttr().Get()
    if value is None or len(value) != len(clip.joints):
        return None
    bind = np.array(value, dtype=np.float64)
    return bind if np.all(np.isfinite(bind)) else None


def _read_placement(skeleton: Usd.Prim) -> FloatArray:
    return np.array(UsdGeom.Imageable(skeleton).ComputeLocalToWorldTransform(Usd.TimeCode.Default()), dtype=np.float64)


def _describe_loss(prim: Usd.Prim, skeleton: Usd.Prim) -> tuple[str, ...]:
    """Say where the character moves by more than its joints."""
    above = skeleton
    while above and not above.IsPseudoRoot():
        if UsdGeom.Xformable(above) and UsdGeom.Xformable(above).TransformMightBeTimeVarying():
            return (f"{prim.GetPath()}: the transform of {above.GetPath()} moves too, which a take does not carry",)
        above = above.GetParent()
    return ()
