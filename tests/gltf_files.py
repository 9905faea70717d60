"""Small glTF documents built number by number, to be read and to be damaged."""

import base64
import json
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

FLOAT = 5126
DTYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", FLOAT: "<f4"}
TYPES = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}


class Builder:
    """A document with one buffer."""

    def __init__(self, nodes: Sequence[dict[str, Any]], joints: Sequence[Sequence[int]] = ()) -> None:
        self.data = b""
        self.document: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "nodes": list(nodes),
            "skins": [{"joints": list(skin)} for skin in joints],
            "animations": [],
            "accessors": [],
            "bufferViews": [],
            "buffers": [{"byteLength": 0}],
        }

    def view(self, values: Any, component: int = FLOAT, *, stride: int = 0) -> int:
        """Add bytes, elements apart by a stride where one is given; give the buffer view."""
        rows = np.atleast_2d(np.asarray(values, dtype=DTYPES[component]))
        packed = b"".join(row.tobytes().ljust(stride, b"\xaa") for row in rows)
        self.data += b"\0" * (-len(self.data) % 4)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(packed)}
        self.document["bufferViews"].append(view | ({"byteStride": stride} if stride else {}))
        self.data += packed
        return len(self.document["bufferViews"]) - 1

    def accessor(self, values: Any, component: int = FLOAT, *, stride: int = 0, **more: Any) -> int:
        """Add an accessor of values, shape [N, W]; give its index."""
        rows = np.asarray(values)
        accessor = {
            "bufferView": self.view(rows, component, stride=stride),
            "componentType": component,
            "count": len(rows),
            "type": TYPES[rows.shape[1]],
        }
        self.document["accessors"].append(accessor | more)
        return len(self.document["accessors"]) - 1

    def times(self, values: Sequence[float]) -> int:
        """Add an accessor of key times."""
        return self.accessor(np.array(values)[:, None])

    def animate(self, *channels: tuple[int, str, int, int, str], name: str = "") -> None:
        """Add an animation of (node, path, times accessor, values accessor, interpolation)."""
        animation: dict[str, Any] = {"channels": [], "samplers": []} | ({"name": name} if name else {})
        for i, (node, path, times, values, interpolation) in enumerate(channels):
            animation["channels"].append({"sampler": i, "target": {"node": node, "path": path}})
            animation["samplers"].append({"input": times, "output": values, "interpolation": interpolation})
        self.document["animations"].append(animation)

    def to_json(self, *, uri: str = "") -> bytes:
        """Give the document as text, the buffer embedded unless it has a name."""
        embedded = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
        self.document["buffers"] = [{"byteLength": len(self.data), "uri": uri or embedded}]
        return json.dumps(self.document).encode()

    def to_glb(self) -> bytes:
        """Give the document in one binary file."""
        self.document["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps(self.document).encode()
        text += b" " * (-len(text) % 4)
        body = (
            struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(self.data), b"BIN\0") + self.data
        )
        return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body

    def write(self, folder: Path, name: str = "take.gltf") -> Path:
        """Write the file, text or binary by its name."""
        (folder / name).write_bytes(self.to_glb() if name.endswith(".glb") else self.to_json())
        return folder / name


def unit(*values: float) -> list[float]:
    """Bring a quaternion to unit length."""
    return list(np.array(values) / np.linalg.norm(values))


def build_arm() -> Builder:
    """Two joints with nodes that are none above and between, moved in every way there is."""
    builder = Builder(
        [
            {"name": "Armature", "scale": [0.01] * 3, "rotation": unit(1, 0, 0, 1), "children": [1]},
            {"name": "Upper", "translation": [0, 100, 0], "children": [2]},
            {"name": "Helper", "translation": [0, 10, 0], "rotation": unit(0, 0, 1, 2), "children": [3]},
            {"name": "Lower", "translation": [0, 20, 5], "children": [4]},
            {"name": "Tip", "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 0, 0, 1]},
        ],
        joints=[[1, 3, 4]],
    )
    turns = [unit(0, 0, 0, 1), unit(1, 2, 3, 4), unit(-3, 1, 0, 2)]
    moves = [[0, 100, 0], [5, 101, 2], [9, 99, 3]]
    cubic = [[0, 0, 1], [0, 10, 0], [1, 0, 0], [2, 0, 0], [3, 12, 0], [0, 4, 0], [0, 0, 0], [1, 9, 1], [9, 9, 9]]
    times, uneven = builder.times([0.0, 0.5, 1.0]), builder.times([0.1, 0.2, 0.9])
    builder.animate(
        (1, "rotation", times, builder.accessor(turns), "LINEAR"),
        (1, "translation", times, builder.accessor(moves, stride=20), "LINEAR"),
        (2, "translation", uneven, builder.accessor(cubic), "CUBICSPLINE"),
        (3, "rotation", uneven, builder.accessor(turns[::-1]), "STEP"),
    )
    return builder
