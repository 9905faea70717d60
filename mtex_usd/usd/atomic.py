"""Writing layers whole: a temporary file beside the target, synced, then renamed over it.

A reader sees the old file or the new one, never half of one; a failure leaves what stood there. Layers this project
writes carry ``customLayerData["mtex"]`` with ``generator`` and ``kind``; an existing file without that mark is somebody
else's work and is never overwritten.
"""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal

from pxr import Sdf, Tf, UsdUtils

from mtex_usd.errors import InputError
from mtex_usd.usd.diagnostics import describe_error

__all__ = ["check_target", "is_ours", "mark_layer", "write_layer"]

LayerKind = Literal["takes", "override", "stage"]

_GENERATOR = "usdmtex"
_FORMATS = {".usd": "usdc", ".usdc": "usdc", ".usda": "usda"}


def mark_layer(layer: Sdf.Layer, kind: LayerKind) -> None:
    """Record in the layer's own metadata that this project wrote it, and what it is.

    Parameters
    ----------
    layer
        Changed in place; other custom layer data stays.
    kind
        ``"takes"``, ``"override"`` or ``"stage"``.
    """
    layer.customLayerData = {**layer.customLayerData, "mtex": {"generator": _GENERATOR, "kind": kind}}


def is_ours(file_path: Path) -> bool:
    """Tell whether a file is a layer that this project wrote.

    Parameters
    ----------
    file_path
        Only the metadata is read; False where there is no file or USD cannot read it.
    """
    if not file_path.is_file():
        return False
    try:
        layer = Sdf.Layer.OpenAsAnonymous(str(file_path), metadataOnly=True)
    except Tf.ErrorException:
        return False
    mark = layer.customLayerData.get("mtex") if layer else None
    return isinstance(mark, dict) and mark.get("generator") == _GENERATOR


def check_target(file_path: Path) -> None:
    """Make sure that a layer may be written here, before any work is done for it.

    Parameters
    ----------
    file_path
        Where :func:`write_layer` is going to write.

    Raises
    ------
    InputError
        Where the ending is not USD's, the folder is missing or not writable, the name is a folder's, the file there was
        not written by this project, or this process holds unsaved edits of it.
    """
    if file_path.suffix not in _FORMATS:
        raise InputError(f"{file_path} is no layer name", expected=f"a name ending in {', '.join(_FORMATS)}")
    folder = _real_path(file_path).parent
    if not folder.is_dir():
        raise InputError(f"cannot write {file_path}: there is no folder {folder}", fix="Make it first.")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"cannot write {file_path}: folder {folder} is not writable")
    _check_existing(file_path)


def _check_existing(file_path: Path) -> None:
    if file_path.is_dir():
        raise InputError(f"cannot write {file_path}: it is a folder", expected="a file name")
    if file_path.exists() and not is_ours(file_path):
        raise InputError(
            f"{file_path} exists and was not written by {_GENERATOR}; it is left alone",
            fix="Choose another name with -o.",
        )
    held = Sdf.Layer.Find(str(_real_path(file_path)))
    if held and held.dirty:
        raise InputError(f"{file_path} has unsaved edits in this process", fix="Save or reload that layer first.")


def write_layer(layer: Sdf.Layer, file_path: Path) -> None:
    """Write a layer to a file, all or nothing.

    Parameters
    ----------
    layer
        Usually anonymous; not changed.
    file_path
        ``.usd`` and ``.usdc`` become crate, ``.usda`` text. Equal layers give equal bytes. If this process has the file
        open as a layer, that layer is reloaded.

    Raises
    ------
    InputError
        As :func:`check_target`, and where the file system refuses.
    """
    check_target(file_path)
    target = _real_path(file_path)
    # The temporary name keeps the suffix (USD picks the format by it) and starts with a dot (file browsers skip it).
    temporary = target.with_name(f".{target.stem}.{os.getpid()}-{secrets.token_hex(4)}{target.suffix}")
    try:
        _export(layer, temporary)
        _sync(temporary)
        temporary.replace(target)
        _sync(target.parent)
    except (OSError, Tf.ErrorException) as error:
        raise InputError(f"cannot write {file_path}: {describe_error(error)}") from error
    finally:
        temporary.unlink(missing_ok=True)
    _reload_held(target)


def _export(layer: Sdf.Layer, file_path: Path) -> None:
    with _without_upgrade_warning():
        exported = layer.Export(str(file_path), args={"format": _FORMATS[file_path.suffix]})
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


def _sync(file_path: Path) -> None:
    descriptor = os.open(file_path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _reload_held(file_path: Path) -> None:
    held = Sdf.Layer.Find(str(file_path))
    if held:
        held.Reload(force=True)


def _real_path(file_path: Path) -> Path:
    # Through links: replacing the link itself would leave the file it names untouched.
    return Path(os.path.realpath(file_path))
