"""The container of glTF 2.0: the JSON document, its buffers, and accessors as arrays (glTF 2.0, sections 3.6 and 4.4).

pygltflib reads the document; everything it gives is checked here before it is used, since a damaged file may hold
anything of any type anywhere.
"""

import base64
import json
import struct
import warnings
from dataclasses import is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote, urlsplit

import numpy as np
import numpy.typing as npt

from mtex_usd.formats.recording import FormatError
from mtex_usd.formats.source_text import LARGEST, read_bytes

if TYPE_CHECKING:
    from pygltflib import GLTF2

__all__ = ["GltfFile", "open_gltf"]

FloatArray = npt.NDArray[np.float64]

_MAGIC = b"glTF"
_JSON_CHUNK, _BINARY_CHUNK = 0x4E4F534A, 0x004E4942
_COMPONENTS: dict[int, Any] = {
    5120: np.int8,
    5121: np.uint8,
    5122: np.int16,
    5123: np.uint16,
    5125: np.uint32,
    5126: np.float32,
}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_MOST_ELEMENTS = 10_000_000  # of an accessor without bytes of its own, whose count nothing else bounds


def open_gltf(file_path: Path) -> "GltfFile":
    """Open a .gltf or .glb file.

    Parameters
    ----------
    file_path
        Text or binary, whatever its suffix.

    Raises
    ------
    FormatError
        Where it cannot be opened or is no glTF 2.0.
    """
    data = read_bytes(file_path)
    document, blob = _split_glb(file_path, data) if data[:4] == _MAGIC else (data, None)
    return GltfFile(file_path, _parse_document(file_path, document), blob)


def _split_glb(file_path: Path, data: bytes) -> tuple[bytes, bytes | None]:
    """Give the JSON and the binary chunk of a binary file."""
    if len(data) < 20:
        raise FormatError(file_path, None, f"truncated: {len(data)} bytes are no binary glTF file")
    _, version, length = struct.unpack("<4sII", data[:12])
    if version != 2:
        raise FormatError(file_path, None, f"expected binary glTF version 2, found version {version}")
    if length > len(data):
        raise FormatError(file_path, None, f"truncated: {length} bytes declared, {len(data)} found")
    chunks: dict[int, bytes] = {}
    start = 12
    while start + 8 <= length:
        size, kind = struct.unpack("<II", data[start : start + 8])
        if start + 8 + size > length:
            raise FormatError(
                file_path, None, f"truncated: a chunk of {size} bytes at byte {start} ends after the file"
            )
        chunks.setdefault(kind, data[start + 8 : start + 8 + size])
        start += 8 + size
    if _JSON_CHUNK not in chunks:
        raise FormatError(file_path, None, "the binary glTF file has no JSON chunk")
    return chunks[_JSON_CHUNK], chunks.get(_BINARY_CHUNK)


def _parse_document(file_path: Path, document: bytes) -> "GLTF2":
    from pygltflib import GLTF2  # noqa: PLC0415  (needed for glTF alone)

    try:
        text = document.decode("utf-8-sig")
        _check_version(file_path, json.loads(text))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return GLTF2.gltf_from_json(text)
    except FormatError:
        raise
    except json.JSONDecodeError as error:
        raise FormatError(file_path, error.lineno, f"not a glTF document: {error.msg}") from error
    except UnicodeDecodeError as error:
        raise FormatError(file_path, None, "not a glTF document: no UTF-8 text") from error
    except Exception as error:  # whatever a decoder makes of values of the wrong type
        raise FormatError(file_path, None, f"not a glTF document: {type(error).__name__}: {error}"[:300]) from error


def _check_version(file_path: Path, document: object) -> None:
    asset = document.get("asset") if isinstance(document, dict) else None
    if not isinstance(asset, dict):
        raise FormatError(file_path, None, "not a glTF document: it has no asset")
    version = str(asset.get("version"))
    if not version.startswith("2."):
        raise FormatError(file_path, None, f"expected glTF version 2, found {version[:40]!r}")


class GltfFile:
    """A glTF document with its buffers; reads accessors.

    Parameters
    ----------
    file_path
        The file.
    document
        As pygltflib gives it.
    blob
        The binary chunk of a .glb file.
    """

    def __init__(self, file_path: Path, document: "GLTF2", blob: bytes | None) -> None:
        self.file_path = file_path
        self.document = document
        self.companions: list[Path] = []
        self._blob = blob
        self._buffers: dict[int, bytes] = {}

    def error(self, reason: str) -> FormatError:
        """Make the error for this file."""
        return FormatError(self.file_path, None, reason)

    def pick(self, kind: str, index: object) -> Any:
        """Give an element of one of the document's lists, such as ``pick("nodes", 3)``.

        Raises
        ------
        FormatError
            Where the index is none of the list's.
        """
        elements = self._list(kind)
        if isinstance(index, bool) or not isinstance(index, int) or not 0 <= index < len(elements):
            raise self.error(f"there is no {kind}[{str(index)[:20]}]; the file has {len(elements)} {kind}")
        return self.check_object(elements[index], f"{kind}[{index}]")

    def pick_all(self, kind: str) -> list[Any]:
        """Give one of the document's lists, such as ``pick_all("nodes")``.

        Raises
        ------
        FormatError
            Where an element is no object.
        """
        return [self.check_object(element, f"{kind}[{i}]") for i, element in enumerate(self._list(kind))]

    def _list(self, kind: str) -> list[Any]:
        elements = getattr(self.document, kind)
        return elements if isinstance(elements, list) else []

    def check_object(self, element: Any, what: str) -> Any:
        """Give an element back, once it is sure to be an object with named parts.

        Raises
        ------
        FormatError
            Where it is a number, a text or nothing.
        """
        if not is_dataclass(element):
            raise self.error(f"{what} should be an object, found {str(element)[:40]!r}")
        return element

    def whole(self, value: object, what: str, *, default: int = 0) -> int:
        """Give a whole number from 0 on, or the default where the document has none.

        Raises
        ------
        FormatError
            Where it is something else.
        """
        if value is None:
            return default
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**53:
            raise self.error(f"{what} should be a whole number, found {str(value)[:40]!r}")
        return value

    def read_accessor(self, index: object, *, width: int) -> FloatArray:
        """Read an accessor; normalised integers become floats, sparse values are put in.

        Parameters
        ----------
        index
            Of the accessor.
        width
            How many numbers an element must have.

        Returns
        -------
        FloatArray
            Shape [N, width].

        Raises
        ------
        FormatError
            Where it is of another kind, reaches beyond its buffer, or a number is not finite.
        """
        accessor = self.pick("accessors", index)
        what = f"accessors[{index}]"
        count = self.whole(accessor.count, f"{what}.count")
        if _WIDTHS.get(accessor.type if isinstance(accessor.type, str) else "") != width:
            raise self.error(f"{what} should have {width} numbers an element, found type {str(accessor.type)[:20]!r}")
        values = self._read_dense(accessor, what, count, width)
        if accessor.sparse is not None:
            values = self._put_sparse(accessor, what, values)
        if not np.all(np.abs(values) < LARGEST):
            raise self.error(f"{what} holds a number that is not finite")
        return values

    def _read_dense(self, accessor: Any, what: str, count: int, width: int) -> FloatArray:
        if accessor.bufferView is None:
            if count > _MOST_ELEMENTS:
                raise self.error(f"{what} has {count} elements without bytes; at most {_MOST_ELEMENTS} are read")
            return np.zeros((count, width))
        offset = self.whole(accessor.byteOffset, f"{what}.byteOffset")
        raw = self._read_view(accessor.bufferView, accessor.componentType, what, offset, count, width)
        return _to_floats(raw, normalized=accessor.normalized is True)

    def _put_sparse(self, accessor: Any, what: str, values: FloatArray) -> FloatArray:
        """Replace the elements that the sparse part names."""
        sparse = self.check_object(accessor.sparse, f"{what}.sparse")
        count = self.whole(sparse.count, f"{what}.sparse.count")
        parts = []
        for part, kind, width in ((sparse.indices, None, 1), (sparse.values, accessor.componentType, values.shape[1])):
            if not is_dataclass(type(part)):
                raise self.error(f"{what}.sparse lacks its indices or values")
            offset = self.whole(part.byteOffset, f"{what}.sparse byteOffset")
            component = part.componentType if kind is None else kind
            parts.append(self._read_view(part.bufferView, component, f"{what}.sparse", offset, count, width))
        where = parts[0][:, 0]
        if where.dtype.kind != "u" or (where.size and where.max() >= len(values)):
            raise self.error(f"{what}.sparse names an element beyond its {len(values)}")
        values = values.copy()
        values[where] = _to_floats(parts[1], normalized=accessor.normalized is True)
        return values

    def _read_view(
        self, index: object, component: object, what: str, offset: int, count: int, width: int
    ) -> npt.NDArray[Any]:
        """Read elements of a buffer view, those that lie apart included; shape [count, width]."""
        view = self.pick("bufferViews", index)
        dtype = np.dtype(_COMPONENTS.get(component) if isinstance(component, int) else None).newbyteorder("<")
        if not isinstance(component, int) or component not in _COMPONENTS:
            raise self.error(f"{what} has an unknown componentType {str(component)[:20]!r}")
        data = self._read_buffer(view.buffer)
        start = self.whole(view.byteOffset, f"bufferViews[{index}].byteOffset")
        length = self.whole(view.byteLength, f"bufferViews[{index}].byteLength")
        size = dtype.itemsize * width
        stride = self.whole(view.byteStride, f"bufferViews[{index}].byteStride") or size
        needed = offset + stride * (count - 1) + size if count else 0
        if stride < size or needed > length or start + length > len(data):
            found = f"{length} at byte {start} of a buffer of {len(data)}"
            raise self.error(f"{what} reaches beyond its bytes: it needs {needed}, found {found}")
        shape, strides = (count, width), (stride, dtype.itemsize)
        return np.ndarray(shape, dtype, buffer=data, offset=start + offset if count else 0, strides=strides)

    def _read_buffer(self, index: object) -> bytes:
        buffer = self.pick("buffers", index)
        assert isinstance(index, int)  # what pick has just made sure of
        if index not in self._buffers:
            self._buffers[index] = self._load_buffer(index, buffer.uri)
        return self._buffers[index]

    def _load_buffer(self, index: int, uri: object) -> bytes:
        if uri is None:
            if index == 0 and self._blob is not None:
                return self._blob
            raise self.error(f"buffers[{index}] has no bytes")
        if not isinstance(uri, str):
            raise self.error(f"buffers[{index}].uri is no text")
        if uri.startswith("data:"):
            return self._decode_data(index, uri)
        return self._read_companion(index, uri)

    def _decode_data(self, index: int, uri: str) -> bytes:
        head, _, body = uri.partition(",")
        if not head.endswith(";base64"):
            raise self.error(f"buffers[{index}] should be base64, found {head[:40]!r}")
        try:
            return base64.b64decode(body, validate=True)
        except ValueError as error:  # of base64, or of letters that are not ASCII
            raise self.error(f"buffers[{index}] is no base64: {error}") from error

    def _read_companion(self, index: int, uri: str) -> bytes:
        try:
            parts = urlsplit(uri)
            companion = self.file_path.parent / unquote(parts.path)
            if parts.scheme or parts.netloc or not parts.path or parts.path.startswith("/") or not companion.is_file():
                raise self.error(f"buffers[{index}]: cannot read {uri[:80]!r} beside the file")
        except (ValueError, OSError) as error:  # an address that is none, a name longer than names may be
            raise self.error(f"buffers[{index}]: bad name {uri[:80]!r}") from error
        if companion not in self.companions:
            self.companions.append(companion)
        return read_bytes(companion)


def _to_floats(raw: npt.NDArray[Any], *, normalized: bool) -> FloatArray:
    with np.errstate(invalid="ignore"):  # of a NaN that signals; what is not finite is refused further on
        values = raw.astype(np.float64)
    if not normalized or raw.dtype.kind == "f":
        return values
    values /= np.iinfo(raw.dtype).max
    return np.maximum(values, -1.0)  # the lowest signed value has no positive counterpart
