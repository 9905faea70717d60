"""Take libraries: USD files of recorded takes, one Skeleton per distinct skeleton and one SkelAnimation per recording.

The layer is::

    def SkelRoot "Takes"                 the default prim
        def Skeleton "Skeleton"          rest and bind pose of the file; customData mtex:jointNames
        def SkelAnimation "take_07_01"   MtexTakeAPI; customData mtex:source, sha256, rate, frames, skippedFrames, …
        ...

A Skeleton shared by takes is bound to none of them; each take names its Skeleton by ``mtex:take:skeleton``. The values
are those of the file: where its unit, up axis or place differ from the library's, the Skeleton has a transform. A
library grows: what is in it stays as it is, bit for bit.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
from pxr import Sdf

from mtex_usd.formats.recording import Recording
from mtex_usd.motion.skeleton import parents_of
from mtex_usd.usd.atomic import mark_layer, write_layer
from mtex_usd.usd.names import build_joint_paths, make_prim_name, make_unique
from mtex_usd.usd.take_entries import (
    ROOT,
    Provenance,
    TakeEntry,
    custom_data,
    default_of,
    describe_capture,
    list_entries,
    open_library_layer,
)
from mtex_usd.usd.take_specs import (
    author_samples,
    author_skeleton,
    author_take_api,
    define_prim,
    read_matrices,
    set_uniform,
)

__all__ = ["TakeLibrary", "WrittenTake"]

FloatArray = npt.NDArray[np.float64]

# Offsets of one performer differ in the last digits from file to file; more than this part of the largest is another.
_SAME_OFFSETS = 1e-5
_SAME_PLACE = 1e-12
_TO_Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # row vectors


@dataclass(frozen=True, kw_only=True)
class WrittenTake:
    """One take that was added to a library.

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
class _Frame:
    """A Skeleton of the library, to compare recordings with."""

    prim_path: Sdf.Path
    names: tuple[str, ...]
    parents: tuple[int, ...]
    rest: FloatArray
    joints: tuple[str, ...]
    placement: FloatArray
    limits: frozenset[tuple[str, float, float]]

    def fits(self, other: "_Frame") -> bool:
        mine = (self.names, self.parents, self.joints, self.limits)
        return mine == (other.names, other.parents, other.joints, other.limits) and self._is_near(other)

    def _is_near(self, other: "_Frame") -> bool:
        tolerance = _SAME_OFFSETS * np.abs(self.rest[:, 3, :3]).max(initial=0.0)
        apart = np.abs(self.rest - other.rest)
        same_rest = apart[:, 3].max(initial=0.0) <= tolerance and apart[:, :3].max(initial=0.0) <= _SAME_OFFSETS
        return bool(same_rest) and np.allclose(self.placement, other.placement, rtol=1e-9, atol=_SAME_PLACE)


class TakeLibrary:
    """A take library that is being filled; nothing touches the disk before :meth:`write`.

    Parameters
    ----------
    meters_per_unit
        Length in metres of one unit of the library.
    up_axis
        ``"Y"`` or ``"Z"``, the library's up.
    """

    def __init__(self, *, meters_per_unit: float, up_axis: str = "Y") -> None:
        self._layer = Sdf.Layer.CreateAnonymous("takes.usda")
        self._skeletons: list[_Frame] = []
        self._takes: list[WrittenTake] = []
        self._names: set[str] = set()
        self._known: dict[tuple[object, ...], str] = {}
        self._has_rate = False
        mark_layer(self._layer, "takes")
        define_prim(self._layer, ROOT, "SkelRoot")
        self._layer.defaultPrim = ROOT.name
        self._layer.pseudoRoot.SetInfo("upAxis", up_axis)
        self._layer.pseudoRoot.SetInfo("metersPerUnit", meters_per_unit)

    @classmethod
    def open(cls, file_path: Path) -> "TakeLibrary":
        """Open a library to add to it.

        Parameters
        ----------
        file_path
            A library that this project wrote.

        Raises
        ------
        InputError
            Where USD cannot read it, or it is no take library.
        """
        library = cls(meters_per_unit=1.0)
        library._layer = open_library_layer(file_path)
        library._has_rate = True
        root = library._layer.GetPrimAtPath(ROOT)
        library._skeletons = [_read_frame(spec) for spec in root.nameChildren if spec.typeName == "Skeleton"]
        library._names = {child.name for child in root.nameChildren}
        library._known = {entry.identity: entry.prim_path for entry in library.entries if entry.sha256}
        return library

    @property
    def takes(self) -> tuple[WrittenTake, ...]:
        """The takes added so far, in their order; not those that were there before."""
        return tuple(self._takes)

    @property
    def entries(self) -> tuple[TakeEntry, ...]:
        """All takes of the library."""
        return list_entries(self._layer)

    def find(self, recording: Recording, provenance: Provenance) -> str | None:
        """Find the take of the same content, clip and options.

        Parameters
        ----------
        recording
            Says which of the file's motions it is.
        provenance
            Says what the content and options are; the licence does not count.

        Returns
        -------
        str or None
            Path of the take.
        """
        return self._known.get((*provenance.identity, recording.clip))

    def add(self, recording: Recording, *, style: str = "", provenance: Provenance | None = None) -> WrittenTake:
        """Add a take, and its Skeleton unless an equal one is there.

        Parameters
        ----------
        recording
            Its first frame goes to time code 0. The first recording's rate becomes the layer's timeCodesPerSecond and
            framesPerSecond; samples of recordings at other rates go to the fractional time codes that keep real time.
        style
            ``mtex:take:style``; not authored where empty.
        provenance
            Where it comes from.
        """
        with Sdf.ChangeBlock():
            if not self._has_rate:
                self._layer.timeCodesPerSecond = self._layer.framesPerSecond = recording.rate
                self._has_rate = True
            skeleton = self._find_skeleton(recording)
            take = self._describe(recording, skeleton)
            spec = define_prim(self._layer, Sdf.Path(take.prim_path), "SkelAnimation")
            set_uniform(spec, "joints", Sdf.ValueTypeNames.TokenArray, skeleton.joints)
            author_take_api(spec, skeleton.prim_path, take.end, style)
            spec.SetInfo("customData", {"mtex": describe_capture(recording, provenance)})
            author_samples(spec, recording, self._time_codes(recording))
        self._takes.append(take)
        if provenance is not None:
            self._known[*provenance.identity, recording.clip] = take.prim_path
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
        before = self._layer.endTimeCode if self._layer.HasEndTimeCode() else 0.0
        self._layer.startTimeCode = min(self._layer.startTimeCode, 0.0)
        self._layer.endTimeCode = max([before, *(take.end for take in self._takes)])
        write_layer(self._layer, file_path)

    def _find_skeleton(self, recording: Recording) -> _Frame:
        frame = _make_frame(recording, self._place(recording))
        found = next((skeleton for skeleton in self._skeletons if skeleton.fits(frame)), None)
        return found or self._add_skeleton(recording, frame)

    def _add_skeleton(self, recording: Recording, frame: _Frame) -> _Frame:
        frame = replace(frame, prim_path=self._free_path("Skeleton"))
        moved = not np.allclose(frame.placement, np.eye(4), rtol=0.0, atol=_SAME_PLACE)
        spec = define_prim(self._layer, frame.prim_path, "Skeleton")
        author_skeleton(spec, recording, frame.joints, frame.placement if moved else None)
        self._skeletons.append(frame)
        return frame

    def _place(self, recording: Recording) -> FloatArray:
        """Give the transform from the recording's skeleton space to the library's world, shape [4, 4]."""
        root = self._layer.pseudoRoot
        unit, up = root.GetInfo("metersPerUnit"), root.GetInfo("upAxis")
        turn = np.eye(3)
        if recording.up_axis not in {None, up}:
            turn = _TO_Z_UP if up == "Z" else _TO_Z_UP.T
        to_library = np.eye(4)
        to_library[:3, :3] = turn * ((recording.meters_per_unit or unit) / unit)
        return to_library if recording.placement is None else recording.placement @ to_library

    def _free_path(self, name: str) -> Sdf.Path:
        unique = make_unique(name, self._names)
        self._names.add(unique)
        return ROOT.AppendChild(unique)

    def _describe(self, recording: Recording, skeleton: _Frame) -> WrittenTake:
        last = recording.clip.rpartition("/")[2]
        stem = f"{recording.source.stem}_{last}" if last else recording.source.stem
        return WrittenTake(
            prim_path=str(self._free_path(make_prim_name(stem, prefix="take_"))),
            skeleton_path=str(skeleton.prim_path),
            source=recording.source,
            frame_count=recording.frame_count,
            rate=recording.rate,
            start=0.0,
            end=float(self._time_codes(recording)[-1]),
        )

    def _time_codes(self, recording: Recording) -> FloatArray:
        return np.arange(recording.frame_count, dtype=np.float64) * (self._layer.timeCodesPerSecond / recording.rate)


def _make_frame(recording: Recording, placement: FloatArray) -> _Frame:
    joints = recording.joint_paths or build_joint_paths(recording.names, recording.parents)
    return _Frame(
        prim_path=Sdf.Path(),
        names=recording.names,
        parents=tuple(map(int, parents_of(joints))),
        rest=recording.rest_transforms,
        joints=joints,
        placement=placement,
        limits=frozenset(
            (f"{joints[limit.joint].rpartition('/')[2]}:{limit.channel}", limit.lower, limit.upper)
            for limit in recording.limits
        ),
    )


def _read_frame(spec: Sdf.PrimSpec) -> _Frame:
    joints = tuple(map(str, default_of(spec, "joints") or ()))
    names = custom_data(spec).get("jointNames") or [joint.rpartition("/")[2] for joint in joints]
    rest = read_matrices(spec, "restTransforms")
    placement = read_matrices(spec, "xformOp:transform")
    prefix = "mtex:limits:"
    limits = [attribute for attribute in spec.attributes if attribute.name.startswith(prefix)]
    return _Frame(
        prim_path=spec.path,
        names=tuple(map(str, names)),
        parents=tuple(map(int, parents_of(joints))),
        rest=np.tile(np.eye(4), (len(joints), 1, 1)) if rest is None else rest,
        joints=joints,
        placement=np.eye(4) if placement is None else placement,
        limits=frozenset((a.name.removeprefix(prefix), float(a.default[0]), float(a.default[1])) for a in limits),
    )
