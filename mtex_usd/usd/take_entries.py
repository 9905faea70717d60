"""What a take library says about its takes: where each comes from, and under which terms."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from pxr import Sdf, Tf, Vt

from mtex_usd.edit.cleaning import Finding
from mtex_usd.errors import InputError
from mtex_usd.formats.recording import Recording
from mtex_usd.usd.atomic import layer_kind
from mtex_usd.usd.custom_data import to_metadata
from mtex_usd.usd.diagnostics import describe_error

__all__ = [
    "ROOT",
    "Provenance",
    "TakeEntry",
    "custom_data",
    "default_of",
    "describe_capture",
    "list_entries",
    "open_library_layer",
]

ROOT = Sdf.Path("/Takes")
"""The default prim of a library; takes and Skeletons are its children."""


@dataclass(frozen=True, kw_only=True)
class Provenance:
    """Where a take comes from, beyond what its recording says.

    Parameters
    ----------
    sha256
        Of the file's content, hexadecimal.
    companions
        Name and SHA-256 of each further file that its content came from, as ``"91.asf 5f1c…"``.
    options
        What was asked of the import and changes the take; the same content with the same options is the same take.
    licence
        A note on the terms it may be used under; may be empty.
    changes, left
        What the clean-up changed, and what it found and left; frames count from 0 in the file.
    """

    sha256: str
    companions: tuple[str, ...] = ()
    options: str = ""
    licence: str = ""
    changes: tuple[Finding, ...] = ()
    left: tuple[Finding, ...] = ()

    @property
    def identity(self) -> tuple[object, ...]:
        """What makes it the same file read in the same way."""
        return self.sha256, self.companions, self.options


@dataclass(frozen=True, kw_only=True)
class TakeEntry:
    """One take of a library as its provenance describes it; empty or 0 where it does not say.

    Parameters
    ----------
    prim_path, skeleton_path
        The SkelAnimation and its Skeleton.
    source, clip
        Name of the file it was read from, and which of the motions there it is.
    sha256, companions, options, licence
        As in :class:`Provenance`.
    frame_count, rate
        How many frames it has, and how many per second.
    joint_count
        How many joints.
    style
        ``mtex:take:style``.
    """

    prim_path: str
    skeleton_path: str
    source: str
    clip: str
    sha256: str
    companions: tuple[str, ...]
    options: str
    licence: str
    frame_count: int
    rate: float
    joint_count: int
    style: str

    @property
    def identity(self) -> tuple[object, ...]:
        """What makes it the same take: as in :class:`Provenance`, and which motion of the file it is."""
        return self.sha256, self.companions, self.options, self.clip


def open_library_layer(file_path: Path) -> Sdf.Layer:
    """Open a library's layer, apart from the file.

    Parameters
    ----------
    file_path
        A library that this project wrote.

    Raises
    ------
    InputError
        Where USD cannot read it, or it is no take library.
    """
    if not file_path.is_file():
        raise InputError(f"cannot read {file_path}", found="a folder" if file_path.is_dir() else "no such file")
    try:
        layer = Sdf.Layer.OpenAsAnonymous(str(file_path))
    except Tf.ErrorException as error:
        raise InputError(f"cannot read {file_path}: {describe_error(error)}") from error
    root = layer.GetPrimAtPath(ROOT) if layer and layer_kind(layer) == "takes" else None
    if not root or layer.defaultPrim != ROOT.name:
        raise InputError(
            f"{file_path} is no take library of usdmtex",
            expected=f"a file that usdmtex-import wrote, with the default prim {ROOT}",
            fix="Choose another name with -o, or --replace it if this project wrote it.",
        )
    return layer


def list_entries(layer: Sdf.Layer) -> tuple[TakeEntry, ...]:
    """List the takes of a library's layer in their order."""
    children = layer.GetPrimAtPath(ROOT).nameChildren
    return tuple(_read_entry(spec) for spec in children if spec.typeName == "SkelAnimation")


def default_of(spec: Sdf.PrimSpec, name: str) -> Any:
    """Give an attribute's default; None where it has none."""
    attribute = spec.attributes.get(name)
    return None if attribute is None else attribute.default


def custom_data(spec: Sdf.PrimSpec) -> dict[str, Any]:
    """Give what we keep in a prim's customData."""
    data = spec.customData.get("mtex")
    return dict(data) if isinstance(data, dict) else {}


def _read_entry(spec: Sdf.PrimSpec) -> TakeEntry:
    """Read what a library says about a take, a SkelAnimation."""
    data = custom_data(spec)
    texts = {name: str(data.get(name, "")) for name in ("source", "clip", "sha256", "options", "licence")}
    relationship = spec.relationships.get("mtex:take:skeleton")
    targets = relationship.targetPathList.GetAppliedItems() if relationship else []
    samples = spec.layer.GetNumTimeSamplesForPath(spec.path.AppendProperty("rotations"))
    return TakeEntry(
        prim_path=str(spec.path),
        skeleton_path=str(targets[0]) if targets else "",
        companions=tuple(map(str, data.get("companions", ()))),
        frame_count=int(data.get("frames", samples)),
        rate=float(data.get("rate", spec.layer.framesPerSecond)),
        joint_count=len(default_of(spec, "joints") or ()),
        style=str(default_of(spec, "mtex:take:style") or ""),
        **texts,
    )


def describe_capture(recording: Recording, provenance: Provenance | None) -> dict[str, object]:
    """Give what :func:`list_entries` reads, for a take's customData."""
    # The file's name alone: with its folder the same takes would give other bytes on another machine.
    data: dict[str, object] = {
        "source": recording.source.name,
        "rate": recording.rate,
        "frames": recording.frame_count,
        "skippedFrames": recording.skipped_frames,
    }
    if provenance is not None:
        optional = {
            "clip": recording.clip,
            "sha256": provenance.sha256,
            "companions": Vt.StringArray(provenance.companions),
            "options": provenance.options,
            "licence": provenance.licence,
            "changes": _describe_findings(provenance.changes),
            "left": _describe_findings(provenance.left),
        }
        data |= {name: value for name, value in optional.items() if value}
    return data


def _describe_findings(findings: Sequence[Finding]) -> object:
    return to_metadata([asdict(finding) for finding in findings]) if findings else None
