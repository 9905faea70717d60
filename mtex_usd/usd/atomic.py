"""Writing layers whole, each over nothing but a layer of its own kind.

Layers this project writes carry ``customLayerData["mtex"]`` with ``generator`` and ``kind``; an existing file without
that mark is somebody else's work and is never overwritten.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal, cast

from pxr import Sdf, Tf, UsdUtils

from mtex_usd.errors import InputError
from mtex_usd.files import GENERATOR, check_ours, check_place, real_path, replacing
from mtex_usd.usd.diagnostics import describe_damage, describe_error, find_obstacle

__all__ = ["LayerKind", "check_target", "file_kind", "file_maker", "is_ours", "layer_kind", "mark_layer", "write_layer"]

LayerKind = Literal["takes", "clip", "override", "stage", "contacts", "accepted", "recipe"]
"""What a layer of ours is: takes, what ``write_clip`` writes, overrides, a root, contacts, accepted paths, a recipe."""

_KINDS = {
    "takes": "a take library",
    "clip": "a clip",
    "override": "an override layer",
    "stage": "a thin root",
    "contacts": "a layer of contacts",
    "accepted": "a layer of accepted paths",
    "recipe": "a layer of suggested recipes",
}

_FORMATS = {".usd": "usdc", ".usdc": "usdc", ".usda": "usda"}


def mark_layer(layer: Sdf.Layer, kind: LayerKind, *, maker: str = "") -> None:
    """Record in the layer's own metadata that this project wrote it, and what it is.

    Parameters
    ----------
    layer
        Changed in place; other custom layer data stays.
    kind
        What it is.
    maker
        Which command made it, where several make layers of the same kind.
    """
    mark = {"generator": GENERATOR, "kind": kind, **({"maker": maker} if maker else {})}
    layer.customLayerData = {**layer.customLayerData, "mtex": mark}


def layer_kind(layer: Sdf.Layer) -> str:
    """Tell what we wrote a layer as, one of ``LayerKind``; empty for a layer not ours."""
    mark = layer.customLayerData.get("mtex")
    return str(mark.get("kind", "")) if isinstance(mark, dict) and mark.get("generator") == GENERATOR else ""


def file_kind(file_path: Path) -> str:
    """Tell what we wrote a file as; empty where there is none, USD cannot read it, or it is not ours.

    Parameters
    ----------
    file_path
        Only the metadata is read.
    """
    if find_obstacle(file_path):
        return ""
    try:
        return layer_kind(layer) if (layer := _read_metadata(file_path)) else ""
    except Tf.ErrorException:
        return ""


def file_maker(file_path: Path) -> str:
    """Tell which command made a file of ours; empty where there is none or it does not say.

    Parameters
    ----------
    file_path
        Only the metadata is read.
    """
    if not file_kind(file_path):
        return ""
    layer = _read_metadata(file_path)
    return str(layer.customLayerData["mtex"].get("maker", "")) if layer else ""


def is_ours(file_path: Path) -> bool:
    """Tell whether a file is a layer that this project wrote, of any kind."""
    return bool(file_kind(file_path))


def _read_metadata(file_path: Path) -> Sdf.Layer | None:
    return Sdf.Layer.OpenAsAnonymous(str(file_path), metadataOnly=True)


def check_target(file_path: Path, kind: LayerKind) -> None:
    """Make sure that a layer may be written here, before any work is done for it.

    Parameters
    ----------
    file_path
        Where :func:`write_layer` is going to write.
    kind
        What it is going to be; only one of its own kind is replaced.

    Raises
    ------
    InputError
        Where the ending is not USD's, the folder is missing or not writable, the name is a folder's, the file there was
        not written by this project or is a layer of another kind, or this process holds unsaved edits of it.
    """
    check_place(file_path, what="layer", endings=tuple(_FORMATS))
    if file_path.exists():
        _check_existing(file_path, kind)
    held = Sdf.Layer.Find(str(real_path(file_path)))
    if held and held.dirty:
        raise InputError(f"{file_path} has unsaved edits in this process", fix="Save or reload that layer first.")


def _check_existing(file_path: Path, kind: LayerKind) -> None:
    found = layer_kind(_read_existing(file_path))
    check_ours(file_path, what="output", is_ours=lambda _: bool(found))
    if found != kind:
        # A library of takes, say, is ours too and would be lost.
        raise InputError(
            f"{file_path} exists and is left alone",
            expected=f"{_KINDS[kind]} to replace, or no file",
            found=_KINDS.get(found, found),
            fix="Choose another name for the output.",
        )


def _read_existing(file_path: Path) -> Sdf.Layer:
    """Read the metadata of a file in the way; one that nobody can read may be somebody's all the same."""
    found = find_obstacle(file_path)
    cause: Exception | None = None
    if not found:
        try:
            layer = _read_metadata(file_path)
        except Tf.ErrorException as error:
            layer, cause = None, error
        if layer:
            return layer
        found = describe_damage(file_path, cause)
    raise InputError(
        f"{file_path} exists and cannot be read, so that it is left alone",
        expected=f"a layer that {GENERATOR} wrote",
        found=found,
        fix="Delete it if nobody needs it, or choose another name for the output.",
    ) from cause


def write_layer(layer: Sdf.Layer, file_path: Path) -> None:
    """Write a layer to a file, all or nothing.

    Parameters
    ----------
    layer
        Usually anonymous; not changed. :func:`mark_layer` has said what it is.
    file_path
        ``.usd`` and ``.usdc`` become crate, ``.usda`` text. Equal layers give equal bytes. If this process has the file
        open as a layer, that layer is reloaded.

    Raises
    ------
    InputError
        As :func:`check_target`, and where the file system refuses.
    """
    check_target(file_path, cast(LayerKind, layer_kind(layer)))
    try:
        with replacing(file_path) as temporary:
            _export(layer, temporary)
    except (OSError, Tf.ErrorException) as error:
        raise InputError(f"cannot write {file_path}: {describe_error(error)}") from error
    _reload_held(real_path(file_path))


def _export(layer: Sdf.Layer, file_path: Path) -> None:
    with _without_upgrade_warning():
        exported = layer.Export(str(file_path), args={"format": _FORMATS[file_path.suffix.lower()]})
    if not exported:
        raise OSError("USD could not export the layer")


@contextmanager
def _without_upgrade_warning() -> Iterator[None]:
    """Keep USD from warning, on every file, that timecode values need crate version 0.9 (of 2019); show the rest."""
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        yield
    finally:
        diagnostics = delegate.TakeUncoalescedDiagnostics()
        del delegate
        for diagnostic in diagnostics:
            if not diagnostic.commentary.startswith("Upgrading crate file"):
                Tf.Warn(diagnostic.commentary)


def _reload_held(file_path: Path) -> None:
    held = Sdf.Layer.Find(str(file_path))
    if held:
        held.Reload(force=True)
