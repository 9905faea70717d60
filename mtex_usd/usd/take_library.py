"""Take libraries: USD files of recorded takes, one Skeleton per distinct skeleton and one SkelAnimation per recording.

The layer is::

    def SkelRoot "Takes"                 the default prim
        def Skeleton "Skeleton"          rest and bind pose from the file's offsets; customData mtex:jointNames
        def SkelAnimation "take_07_01"   MtexTakeAPI; customData mtex:source, rate, frames, skippedFrames
        ...

A Skeleton shared by takes is bound to none of them; each take names its Skeleton by ``mtex:take:skeleton``. Authored on
the layer with Sdf, because a layer has no schemas to register and writing samples this way is fastest.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from pxr import Gf, Sdf, Vt

from mtex_usd.formats.recording import Recording
from mtex_usd.usd.atomic import mark_layer, write_layer
from mtex_usd.usd.names import build_joint_paths, make_prim_name, make_unique

__all__ = ["TakeLibrary", "WrittenTake"]

FloatArray = npt.NDArray[np.float64]

_ROOT = Sdf.Path("/Takes")
_UNIFORM = Sdf.VariabilityUniform
# Offsets of one performer differ in the last digits from file to file; more than this part of the largest is another.
_SAME_OFFSETS = 1e-5


@dataclass(frozen=True, kw_only=True)
class WrittenTake:
    """One take of a library.

    Parameters
    ----------
    prim_path, skeleton_path
        The SkelAnimation and its Skeleton.
    source
        The file it was read from.
    frame_count
        How many frames were written.
    rate
        Frames per second of the recording.
    start, end
        Time codes of the first and last frame.
    """

    prim_path: str
    skeleton_path: str
    source: Path
    frame_count: int
    rate: float
    start: float
    end: float


@dataclass(frozen=True, eq=False, kw_only=True)
class _WrittenSkeleton:
    prim_path: Sdf.Path
    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: FloatArray
    joints: tuple[str, ...]

    def fits(self, recording: Recording) -> bool:
        if (self.names, self.parents) != (recording.names, recording.parents):
            return False
        tolerance = _SAME_OFFSETS * np.abs(self.offsets).max(initial=0.0)
        return bool(np.all(np.abs(self.offsets - recording.offsets) <= tolerance))


class TakeLibrary:
    """A take library that is being filled; nothing touches the disk before :meth:`write`.

    Parameters
    ----------
    meters_per_unit
        Length in metres of one unit of the recordings.
    up_axis
        ``"Y"`` or ``"Z"``, the recordings' up.
    """

    def __init__(self, *, meters_per_unit: float, up_axis: str = "Y") -> None:
        self._layer = Sdf.Layer.CreateAnonymous("takes.usda")
        self._skeletons: list[_WrittenSkeleton] = []
        self._takes: list[WrittenTake] = []
        mark_layer(self._layer, "takes")
        _define_prim(self._layer, _ROOT, "SkelRoot")
        self._layer.defaultPrim = _ROOT.name
        self._layer.pseudoRoot.SetInfo("upAxis", up_axis)
        self._layer.pseudoRoot.SetInfo("metersPerUnit", meters_per_unit)

    @property
    def takes(self) -> tuple[WrittenTake, ...]:
        """The takes so far, in the order they were added."""
        return tuple(self._takes)

    def add(self, recording: Recording, *, style: str = "") -> WrittenTake:
        """Add a take, and its Skeleton unless an equal one is there.

        Parameters
        ----------
        recording
            Its first frame goes to time code 0. The first recording's rate becomes the layer's timeCodesPerSecond and
            framesPerSecond; samples of recordings at other rates go to the fractional time codes that keep real time.
        style
            ``mtex:take:style``; not authored where empty.
        """
        with Sdf.ChangeBlock():
            if not self._takes:
                self._layer.timeCodesPerSecond = self._layer.framesPerSecond = recording.rate
            skeleton = self._find_skeleton(recording) or self._add_skeleton(recording)
            take = self._describe(recording, skeleton)
            spec = _define_prim(self._layer, Sdf.Path(take.prim_path), "SkelAnimation")
            _set_uniform(spec, "joints", Sdf.ValueTypeNames.TokenArray, skeleton.joints)
            _author_take_api(spec, take, style)
            spec.SetInfo("customData", {"mtex": _describe_capture(recording)})
            self._author_samples(spec, recording)
        self._takes.append(take)
        return take

    def write(self, file_path: Path) -> None:
        """Write the layer as :func:`mtex_usd.usd.atomic.write_layer` does.

        Parameters
        ----------
        file_path
            Where to.

        Raises
        ------
        InputError
            Where the file may not or cannot be written.
        """
        self._layer.startTimeCode = 0.0
        self._layer.endTimeCode = max((take.end for take in self._takes), default=0.0)
        write_layer(self._layer, file_path)

    def _find_skeleton(self, recording: Recording) -> _WrittenSkeleton | None:
        return next((skeleton for skeleton in self._skeletons if skeleton.fits(recording)), None)

    def _add_skeleton(self, recording: Recording) -> _WrittenSkeleton:
        skeleton = _WrittenSkeleton(
            prim_path=self._free_path("Skeleton"),
            names=recording.names,
            parents=recording.parents,
            offsets=recording.offsets,
            joints=build_joint_paths(recording.names, recording.parents),
        )
        _author_skeleton(_define_prim(self._layer, skeleton.prim_path, "Skeleton"), skeleton)
        self._skeletons.append(skeleton)
        return skeleton

    def _free_path(self, name: str) -> Sdf.Path:
        taken = [child.name for child in self._layer.GetPrimAtPath(_ROOT).nameChildren]
        return _ROOT.AppendChild(make_unique(name, taken))

    def _describe(self, recording: Recording, skeleton: _WrittenSkeleton) -> WrittenTake:
        prim_path = self._free_path(make_prim_name(recording.source.stem, prefix="take_"))
        return WrittenTake(
            prim_path=str(prim_path),
            skeleton_path=str(skeleton.prim_path),
            source=recording.source,
            frame_count=recording.frame_count,
            rate=recording.rate,
            start=0.0,
            end=float(self._time_codes(recording)[-1]),
        )

    def _time_codes(self, recording: Recording) -> FloatArray:
        return np.arange(recording.frame_count, dtype=np.float64) * (self._layer.timeCodesPerSecond / recording.rate)

    def _author_samples(self, spec: Sdf.PrimSpec, recording: Recording) -> None:
        time_codes = self._time_codes(recording).tolist()
        # Vt's quaternion buffers hold the real part last.
        rotations = np.ascontiguousarray(recording.rotations[..., [1, 2, 3, 0]], dtype=np.float32)
        translations = np.ascontiguousarray(recording.translations, dtype=np.float32)
        path = _define_attribute(spec, "rotations", Sdf.ValueTypeNames.QuatfArray).path
        _set_samples(self._layer, path, time_codes, map(Vt.QuatfArray.FromNumpy, rotations))
        path = _define_attribute(spec, "translations", Sdf.ValueTypeNames.Float3Array).path
        _set_samples(self._layer, path, time_codes, map(Vt.Vec3fArray.FromNumpy, translations))
        # UsdSkel reads no transforms at all where one of the three is missing.
        scales = _define_attribute(spec, "scales", Sdf.ValueTypeNames.Half3Array)
        scales.default = Vt.Vec3hArray([Gf.Vec3h(1.0)] * len(recording.names))


def _define_prim(layer: Sdf.Layer, prim_path: Sdf.Path, type_name: str) -> Sdf.PrimSpec:
    spec = Sdf.CreatePrimInLayer(layer, prim_path)
    spec.specifier = Sdf.SpecifierDef
    spec.typeName = type_name
    return spec


def _define_attribute(spec: Sdf.PrimSpec, name: str, type_name: Sdf.ValueTypeName) -> Sdf.AttributeSpec:
    return Sdf.AttributeSpec(spec, name, type_name)


def _set_uniform(spec: Sdf.PrimSpec, name: str, type_name: Sdf.ValueTypeName, value: object) -> None:
    Sdf.AttributeSpec(spec, name, type_name, _UNIFORM).default = value


def _set_samples(layer: Sdf.Layer, path: Sdf.Path, time_codes: Iterable[float], values: Iterable[object]) -> None:
    for time_code, value in zip(time_codes, values, strict=True):
        layer.SetTimeSample(path, time_code, value)


def _author_skeleton(spec: Sdf.PrimSpec, skeleton: _WrittenSkeleton) -> None:
    world = skeleton.offsets.copy()
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            world[joint] += world[parent]
    _set_uniform(spec, "joints", Sdf.ValueTypeNames.TokenArray, skeleton.joints)
    _set_uniform(spec, "restTransforms", Sdf.ValueTypeNames.Matrix4dArray, _translate(skeleton.offsets))
    _set_uniform(spec, "bindTransforms", Sdf.ValueTypeNames.Matrix4dArray, _translate(world))
    spec.SetInfo("customData", {"mtex": {"jointNames": Vt.StringArray(skeleton.names)}})


def _translate(translations: FloatArray) -> Vt.Matrix4dArray:
    matrices = np.tile(np.eye(4), (len(translations), 1, 1))
    matrices[:, 3, :3] = translations
    return Vt.Matrix4dArray.FromNumpy(matrices)  # type: ignore[no-any-return, no-untyped-call]


def _author_take_api(spec: Sdf.PrimSpec, take: WrittenTake, style: str) -> None:
    """Apply MtexTakeAPI by its metadata, so that the schema need not be registered."""
    schemas = Sdf.TokenListOp()
    schemas.prependedItems = ["MtexTakeAPI"]
    spec.SetInfo("apiSchemas", schemas)
    _set_uniform(spec, "mtex:take:start", Sdf.ValueTypeNames.TimeCode, Sdf.TimeCode(take.start))
    _set_uniform(spec, "mtex:take:end", Sdf.ValueTypeNames.TimeCode, Sdf.TimeCode(take.end))
    if style:
        _set_uniform(spec, "mtex:take:style", Sdf.ValueTypeNames.Token, style)
    relationship = Sdf.RelationshipSpec(spec, "mtex:take:skeleton", False, _UNIFORM)  # noqa: FBT003
    relationship.targetPathList.explicitItems = [Sdf.Path(take.skeleton_path)]


def _describe_capture(recording: Recording) -> dict[str, object]:
    # The file's name alone: with its folder the same takes would give other bytes on another machine.
    return {
        "source": recording.source.name,
        "rate": recording.rate,
        "frames": recording.frame_count,
        "skippedFrames": recording.skipped_frames,
    }
