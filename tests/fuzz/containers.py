"""The containers of binary glTF and USD packages, taken apart and put together for damage inside."""

import struct
import zlib
from collections.abc import Sequence

__all__ = ["pack_glb", "pack_usdz", "split_glb"]

_ALIGNMENT = 64


def split_glb(data: bytes) -> tuple[bytes, bytes]:
    """Give the JSON and the binary chunk of a valid file."""
    (length,) = struct.unpack("<I", data[12:16])
    return data[20 : 20 + length], data[20 + length + 8 :]


def pack_glb(document: bytes, binary: bytes) -> bytes:
    """Put chunks together with lengths that are right."""
    document += b" " * (-len(document) % 4)
    binary += b"\0" * (-len(binary) % 4)
    body = struct.pack("<I4s", len(document), b"JSON") + document
    body += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def pack_usdz(entries: Sequence[tuple[str, bytes]]) -> bytes:
    """Put files together uncompressed, the content of each at a multiple of 64 bytes, as packages have to be."""
    body, directory = b"", b""
    for name, content in entries:
        raw, start = name.encode(), len(body)
        gap = -(start + 30 + len(raw) + 4) % _ALIGNMENT
        extra = struct.pack("<HH", 0x1986, gap) + b"\0" * gap
        fields = struct.pack(
            "<HHHHIIIHH", 0, 0, 0, 0, zlib.crc32(content), len(content), len(content), len(raw), len(extra)
        )
        body += struct.pack("<4sH", b"PK\3\4", 10) + fields + raw + extra + content
        directory += struct.pack("<4sHH", b"PK\1\2", 10, 10) + fields + struct.pack("<HHHII", 0, 0, 0, 0, start)
        directory += raw + extra
    end = struct.pack("<4sHHHHIIH", b"PK\5\6", 0, 0, len(entries), len(entries), len(directory), len(body), 0)
    return body + directory + end
