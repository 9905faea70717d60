"""Small valid files to be damaged: those of the test helpers, and real ones cut down where the data folder is there."""

import json
import os
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from pxr import Sdf, UsdUtils

from mtex_usd.importing import import_takes
from tests.acclaim import AMC, ASF
from tests.conftest import PROJECT
from tests.fuzz.containers import pack_glb, pack_usdz
from tests.gltf_files import Builder, build_arm, unit

__all__ = ["KINDS", "KNOWN_GOOD", "USD_KINDS", "Specimen", "collect"]

KINDS = ("bvh", "asf", "amc", "gltf", "glb", "usda", "usdc", "usdz")
"""What is damaged, one reader each."""

USD_KINDS = ("usda", "usdc", "usdz")

_LARGEST = 26_000  # bytes of a real file that is taken whole

_WALK = """HIERARCHY
ROOT Hips
{
  OFFSET 0 1 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation
  JOINT Leg
  {
    OFFSET 1 -2 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT Foot
    {
      OFFSET 0 -3 0.5
      CHANNELS 1 Xrotation
      End Site
      {
        OFFSET 0 0 1
      }
    }
  }
}
MOTION
Frames: 4
Frame Time: 0.0333333
0 1 2 10 20 30 1 2 3 5
0.1 1.1 2.1 11 21 31 2 3 4 6
0.2 1.2 2.2 12 22 32 3 4 5 7
0.3 1.3 2.3 13 23 33 4 5 6 8
"""

KNOWN_GOOD = _WALK.replace("Hips", "Pelvis")
"""A file that is not among the damaged ones, to be imported beside them."""

_STAGE = """#usda 1.0
(
    customLayerData = { string note = "made for a test" }
    defaultPrim = "Hero"
    framesPerSecond = 24
    metersPerUnit = 0.01
    timeCodesPerSecond = 48
    upAxis = "Z"
)

def SkelRoot "Hero" (
    kind = "component"
)
{
    def Skeleton "Rig" (
        prepend apiSchemas = ["SkelBindingAPI"]
    )
    {
        rel skel:animationSource = </Hero/Walk>
        uniform token[] joints = ["L", "L/Hand", "R"]
        uniform matrix4d[] restTransforms = [
            ((0, 1, 0, 0), (-1, 0, 0, 0), (0, 0, 1, 0), (1, 2, 3, 1)),
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (4, 0, 0, 1)),
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (5, 0, 0, 1))]
        uniform matrix4d[] bindTransforms = [
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (1, 0, 0, 1)),
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (2, 0, 0, 1)),
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (4, 0, 0, 1))]
        double3 xformOp:translate = (0, 7, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }

    def SkelAnimation "Walk" (
        prepend apiSchemas = ["MtexTakeAPI"]
    )
    {
        uniform token[] joints = ["R", "L"]
        uniform timecode mtex:take:start = 10
        uniform timecode mtex:take:end = 16
        uniform token mtex:take:style = "brisk"
        quatf[] rotations.timeSamples = {
            10: [(1, 0, 0, 0), (0.8, 0.6, 0, 0)],
            12: [(1, 0, 0, 0), (0.6, 0.8, 0, 0)],
            14: [(1, 0, 0, 0), (0, 1, 0, 0)],
            16: [(0.6, 0, 0.8, 0), (0, 1, 0, 0)],
        }
        float3[] translations.timeSamples = {
            10: [(9, 9, 9), (8, 8, 8)],
            16: [(9, 9.5, 9), (8, 8, 7)],
        }
        half3[] scales = [(1, 1, 1), (1, 2, 1)]
    }
}

def "Crowd" (
    instanceable = true
    references = </Hero>
    variants = { string size = "small" }
    prepend variantSets = "size"
)
{
    variantSet "size" = {
        "large" {
            double3 xformOp:scale = (2, 2, 2)
        }
        "small" {
            uniform token[] xformOpOrder = []
        }
    }
}
"""


@dataclass(frozen=True)
class Specimen:
    """A valid file, and what has to lie beside it.

    Parameters
    ----------
    name
        For messages, without suffix.
    content
        The file.
    companions
        Other files by name.
    """

    name: str
    content: bytes
    companions: dict[str, bytes] = field(default_factory=dict)


def collect(kind: str) -> tuple[Specimen, ...]:
    """Give the files of a kind, always in the same order."""
    return (*_made(kind), *_real(kind))


def _made(kind: str) -> Iterator[Specimen]:
    arm, sparse = build_arm(), _build_sparse()
    match kind:
        case "bvh":
            yield Specimen("made", _WALK.encode())
        case "asf":
            yield Specimen("made", ASF.encode(), {"take.amc": AMC.encode()})
        case "amc":
            yield Specimen("made", AMC.encode(), {"take.asf": ASF.encode()})
        case "gltf":
            yield Specimen("made", arm.to_json())
            yield Specimen("sparse", sparse.to_json())
            yield Specimen("beside", arm.to_json(uri="arm.bin"), {"arm.bin": arm.data})
        case "glb":
            yield Specimen("made", arm.to_glb())
            yield Specimen("sparse", sparse.to_glb())
        case "usda":
            yield Specimen("made", _STAGE.encode())
            yield Specimen("library", _write_library(".usda"))
        case "usdc":
            yield Specimen("made", _to_crate(_STAGE.encode()))
            yield Specimen("library", _write_library(".usdc"))
        case "usdz":
            yield Specimen("crate", pack_usdz([("a.usdc", _to_crate(_STAGE.encode()))]))
            shot = b"#usda 1.0\n(\n    subLayers = [@./a.usdc@]\n)\n"
            yield Specimen("layers", pack_usdz([("shot.usda", shot), ("a.usdc", _to_crate(_STAGE.encode()))]))


def _build_sparse() -> Builder:
    """Values that are stored sparse and as integers."""
    builder = Builder([{"children": [1]}, {"name": "b", "translation": [0, 1, 0]}], joints=[[0, 1]])
    times = builder.times([0.0, 0.25, 0.5, 1.0])
    turns = builder.accessor(np.array([[0, 0, 0, 127], [90, 0, 0, 90]] * 2), 5120, normalized=True)
    indices, values = builder.view([[1], [3]], 5123), builder.view([[0.0, 2.0, 0.0], [0.0, 3.0, 0.0]])
    moves = builder.accessor(np.tile([0.0, 1.0, 0.0], (4, 1)))
    builder.document["accessors"][moves]["sparse"] = {
        "count": 2,
        "indices": {"bufferView": indices, "componentType": 5123},
        "values": {"bufferView": values},
    }
    steady = builder.accessor(np.array([unit(0, 0, 1, 9)] * 4))
    builder.animate((0, "rotation", times, turns, "LINEAR"), (1, "translation", times, moves, "LINEAR"))
    builder.animate((1, "rotation", times, steady, "STEP"), name="other")
    return builder


def _write_library(suffix: str) -> bytes:
    """Give a take library of ours."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "walk.bvh").write_text(_WALK)
        (Path(folder) / "tester.asf").write_text(ASF)
        (Path(folder) / "tester_01.amc").write_text(AMC)
        out = Path(folder) / f"takes{suffix}"
        import_takes([Path(folder) / "walk.bvh", Path(folder) / "tester_01.amc"], out=out, licence="none")
        return out.read_bytes()


def _to_crate(text: bytes) -> bytes:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(text.decode())
    with tempfile.TemporaryDirectory() as folder:
        file_path = Path(folder) / "a.usdc"
        quiet = UsdUtils.CoalescingDiagnosticDelegate()  # about the crate version that time codes need
        layer.Export(str(file_path))
        quiet.TakeUncoalescedDiagnostics()
        return file_path.read_bytes()


def _real(kind: str) -> Iterator[Specimen]:
    folder = Path(os.environ.get("MTEX_TEST_DATA", PROJECT.parent / "shared" / "data"))
    if folder.is_dir():
        yield from _REAL[kind](folder)


def _small_files(folder: Path, pattern: str) -> list[Path]:
    return [path for path in sorted(folder.glob(pattern)) if path.stat().st_size <= _LARGEST]


def _real_bvh(folder: Path) -> Iterator[Specimen]:
    for file_path in _small_files(folder, "bvh_dialects/*.bvh"):
        yield Specimen(file_path.stem, file_path.read_bytes())
    for file_path in sorted(folder.glob("cmu_bvh/07/07_01.bvh")):
        head, _, rest = file_path.read_text().partition("Frames:")
        rows = rest.split("\n")[1:5]
        yield Specimen(file_path.stem, "\n".join([f"{head}Frames: 3", *rows, ""]).encode())


def _cut_amc(file_path: Path) -> bytes:
    head, _, _ = file_path.read_text().partition("\n4\n")
    return f"{head}\n".encode()


def _real_asf(folder: Path) -> Iterator[Specimen]:
    for file_path in sorted(folder.glob("cmu_asfamc/91/91.asf")):
        yield Specimen(file_path.stem, file_path.read_bytes(), {"take.amc": _cut_amc(file_path.with_name("91_13.amc"))})


def _real_amc(folder: Path) -> Iterator[Specimen]:
    for file_path in sorted(folder.glob("cmu_asfamc/91/91_13.amc")):
        yield Specimen(file_path.stem, _cut_amc(file_path), {"take.asf": file_path.with_name("91.asf").read_bytes()})


def _real_gltf(folder: Path) -> Iterator[Specimen]:
    for file_path in _small_files(folder, "gltf/*.gltf"):
        companions = {path.name: path.read_bytes() for path in file_path.parent.glob(f"{file_path.stem}*.bin")}
        yield Specimen(file_path.stem, file_path.read_bytes(), companions)


def _real_glb(folder: Path) -> Iterator[Specimen]:
    for file_path in sorted(folder.glob("gltf/03_skinned_cylinder.gltf")):
        document = json.loads(file_path.read_bytes())
        buffer = document["buffers"][0]
        binary = (file_path.parent / buffer.pop("uri")).read_bytes()
        yield Specimen(file_path.stem, pack_glb(json.dumps(document).encode(), binary))


def _usd_texts(folder: Path) -> list[Path]:
    names = ("usd/skelCube.usda", "usd/framerate.usda", "usd_pixar_tests/*rm.usda")
    return [path for name in names for path in _small_files(folder, name)]


def _real_usda(folder: Path) -> Iterator[Specimen]:
    for file_path in _usd_texts(folder):
        yield Specimen(file_path.stem, file_path.read_bytes())


def _real_usdc(folder: Path) -> Iterator[Specimen]:
    for file_path in _usd_texts(folder):
        yield Specimen(file_path.stem, _to_crate(file_path.read_bytes()))


def _real_usdz(folder: Path) -> Iterator[Specimen]:
    for file_path in _small_files(folder, "usd/Rigged*.usdz"):
        yield Specimen(file_path.stem, file_path.read_bytes())


_REAL: dict[str, Callable[[Path], Iterator[Specimen]]] = {
    "bvh": _real_bvh,
    "asf": _real_asf,
    "amc": _real_amc,
    "gltf": _real_gltf,
    "glb": _real_glb,
    "usda": _real_usda,
    "usdc": _real_usdc,
    "usdz": _real_usdz,
}
