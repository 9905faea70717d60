"""A second, slow glTF reader for checking the fast one: one number, one node and one time at a time.

It shares no code and no idea with the package: the JSON as it is, `struct` for every number, and world matrices by
walking up from a node. It reads well-formed files.
"""

import base64
import json
import math
import struct
from pathlib import Path
from typing import Any

import numpy as np

CODES = {5120: "b", 5121: "B", 5122: "h", 5123: "H", 5125: "I", 5126: "f"}
TOPS = {5120: 127, 5121: 255, 5122: 32767, 5123: 65535}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


class Document:
    """A file with its buffers."""

    def __init__(self, file_path: Path) -> None:
        data = file_path.read_bytes()
        blob = b""
        if data[:4] == b"glTF":
            size = struct.unpack_from("<I", data, 12)[0]
            blob = data[20 + size + 8 :]
            data = data[20 : 20 + size]
        self.json: dict[str, Any] = json.loads(data)
        self.buffers = [self._load(buffer.get("uri"), file_path, blob) for buffer in self.json.get("buffers", [])]

    def _load(self, uri: str | None, file_path: Path, blob: bytes) -> bytes:
        if uri is None:
            return blob
        if uri.startswith("data:"):
            return base64.b64decode(uri.split(",", 1)[1])
        return (file_path.parent / uri).read_bytes()

    def elements(self, index: int) -> list[list[float]]:
        """All elements of an accessor, sparse ones put in."""
        accessor = self.json["accessors"][index]
        width, code = WIDTHS[accessor["type"]], accessor["componentType"]
        values = [[0.0] * width for _ in range(accessor["count"])]
        if "bufferView" in accessor:
            values = self._view(accessor["bufferView"], accessor.get("byteOffset", 0), code, accessor["count"], width)
        if "sparse" in accessor:
            sparse = accessor["sparse"]
            where, what = sparse["indices"], sparse["values"]
            places = self._view(
                where["bufferView"], where.get("byteOffset", 0), where["componentType"], sparse["count"], 1
            )
            news = self._view(what["bufferView"], what.get("byteOffset", 0), code, sparse["count"], width)
            for (place,), new in zip(places, news, strict=True):
                values[int(place)] = new
        if accessor.get("normalized"):
            values = [[max(value / TOPS[code], -1.0) for value in element] for element in values]
        return values

    def _view(self, index: int, offset: int, code: int, count: int, width: int) -> list[list[float]]:
        view = self.json["bufferViews"][index]
        form = f"<{width}{CODES[code]}"
        stride = view.get("byteStride", struct.calcsize(form))
        start = view.get("byteOffset", 0) + offset
        data = self.buffers[view["buffer"]]
        return [list(map(float, struct.unpack_from(form, data, start + i * stride))) for i in range(count)]

    def value(self, animation: int, node: int, path: str, time: float) -> list[float] | None:
        """What an animation gives one property of a node at a time; None where it leaves it alone."""
        described = self.json["animations"][animation]
        for channel in described["channels"]:
            if channel["target"].get("node") == node and channel["target"]["path"] == path:
                return self._interpolate(described["samplers"][channel["sampler"]], path, time)
        return None

    def _interpolate(self, sampler: dict[str, Any], path: str, time: float) -> list[float]:
        times = [element[0] for element in self.elements(sampler["input"])]
        values = self.elements(sampler["output"])
        kind = sampler.get("interpolation", "LINEAR")
        cubic = kind == "CUBICSPLINE"
        keys = values[1::3] if cubic else values
        if time <= times[0] or time >= times[-1]:
            return _unit(keys[0] if time <= times[0] else keys[-1], path)
        left = max(i for i, key in enumerate(times) if key <= time)
        span = times[left + 1] - times[left]
        t = (time - times[left]) / span
        if kind == "STEP":
            return _unit(keys[left], path)
        if cubic:
            out, into = values[3 * left + 2], values[3 * left + 3]
            weights = (2 * t**3 - 3 * t**2 + 1, span * (t**3 - 2 * t**2 + t), 3 * t**2 - 2 * t**3, span * (t**3 - t**2))
            parts = (keys[left], out, keys[left + 1], into)
            return _unit(
                [sum(w * part[i] for w, part in zip(weights, parts, strict=True)) for i in range(len(out))], path
            )
        if path == "rotation":
            return _slerp(_unit(keys[left], path), _unit(keys[left + 1], path), t)
        return [a + t * (b - a) for a, b in zip(keys[left], keys[left + 1], strict=True)]

    def world_matrix(self, animation: int, node: int, time: float) -> np.ndarray:
        """World matrix of a node at a time, column vectors."""
        matrix = self._local(animation, node, time)
        for parent, described in enumerate(self.json["nodes"]):
            if node in described.get("children", []):
                return self.world_matrix(animation, parent, time) @ matrix
        return matrix

    def _local(self, animation: int, node: int, time: float) -> np.ndarray:
        described = self.json["nodes"][node]
        if "matrix" in described:
            return np.array(described["matrix"]).reshape(4, 4).T
        rest = {"translation": [0, 0, 0], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}
        move, turn, scale = (
            self.value(animation, node, path, time) or described.get(path, rest[path]) for path in rest
        )
        matrix = np.eye(4)
        matrix[:3, :3] = _to_matrix(turn) @ np.diag(scale)
        matrix[:3, 3] = move
        return matrix


def _unit(value: list[float], path: str) -> list[float]:
    if path != "rotation":
        return value
    length = math.sqrt(sum(x * x for x in value))
    return [x / length for x in value]


def _slerp(a: list[float], b: list[float], t: float) -> list[float]:
    cosine = sum(x * y for x, y in zip(a, b, strict=True))
    if cosine < 0:
        b, cosine = [-x for x in b], -cosine
    angle = math.acos(min(cosine, 1.0))
    if angle < 1e-9:
        return a
    return [
        (math.sin((1 - t) * angle) * x + math.sin(t * angle) * y) / math.sin(angle) for x, y in zip(a, b, strict=True)
    ]


def _to_matrix(q: list[float]) -> np.ndarray:
    x, y, z, w = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
