"""USD text, written by hand so that its bytes depend on nothing but the numbers: no USD version, no float printing.

Numbers are rounded to few decimals, far above the last bits in which machines' cosines differ, and well below what a
joint angle means: 5 decimals of a quaternion are 0.001 degrees, 3 decimals of a centimetre are 10 micrometres.
"""

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from tests.samples import humanoid
from tests.samples.contacts import Motion

__all__ = ["animation", "character", "indent", "layer", "number", "shot_character", "skeleton", "tokens"]

FloatArray = npt.NDArray[np.float64]

METERS_PER_UNIT = 0.01


def number(value: float, decimals: int) -> str:
    """Write a number with at most so many decimals, without trailing zeros or a negative zero."""
    text = f"{value:.{decimals}f}"
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def indent(lines: Iterable[str], depth: int = 1) -> list[str]:
    """Indent lines by steps of four spaces."""
    return ["    " * depth + line if line else line for line in lines]


def tokens(names: Iterable[str]) -> str:
    """Write an array of tokens or strings."""
    return "[" + ", ".join(f'"{name}"' for name in names) + "]"


def _tuple(values: Iterable[float], decimals: int) -> str:
    return "(" + ", ".join(number(value, decimals) for value in values) + ")"


def _tuples(rows: Iterable[Iterable[float]], decimals: int) -> str:
    return "[" + ", ".join(_tuple(row, decimals) for row in rows) + "]"


def _matrices(places: FloatArray) -> str:
    rows = "(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), "
    return "[" + ", ".join(f"({rows}({', '.join(number(v, 3) for v in place)}, 1))" for place in places) + "]"


def layer(default_prim: str, end: int, rate: int, body: Sequence[str], doc: str) -> str:
    """Write a whole layer with all root metadata; time codes are frames from 0 to end."""
    head = [
        "#usda 1.0",
        "(",
        f'    defaultPrim = "{default_prim}"',
        f'    doc = """{doc}"""',
        f"    endTimeCode = {end}",
        f"    framesPerSecond = {rate}",
        f"    metersPerUnit = {METERS_PER_UNIT}",
        "    startTimeCode = 0",
        f"    timeCodesPerSecond = {rate}",
        '    upAxis = "Y"',
        ")",
        "",
    ]
    return "\n".join([*head, *body, ""])


def skeleton(purpose: str = "default") -> list[str]:
    """Write the Skeleton; purpose "guide" keeps one that moves nothing out of renders and imports."""
    identity = np.tile([1.0, 0.0, 0.0, 0.0], (1, len(humanoid.JOINTS), 1))
    bind, _ = humanoid.forward(identity, humanoid.OFFSETS[:1])
    shown = [] if purpose == "default" else [f'    uniform token purpose = "{purpose}"']
    return [
        'def Skeleton "Skeleton"',
        "{",
        f"    uniform matrix4d[] bindTransforms = {_matrices(bind[0])}",
        f"    uniform token[] joints = {tokens(humanoid.JOINTS)}",
        *shown,
        f"    uniform matrix4d[] restTransforms = {_matrices(humanoid.OFFSETS)}",
        "}",
    ]


def _body() -> list[str]:
    points, faces, joints = humanoid.skin()
    extent = _tuples([points.min(axis=0), points.max(axis=0)], 2)
    return [
        'def Mesh "Body" (',
        '    prepend apiSchemas = ["SkelBindingAPI"]',
        ")",
        "{",
        f"    float3[] extent = {extent}",
        f"    int[] faceVertexCounts = [{', '.join(str(len(face)) for face in faces)}]",
        f"    int[] faceVertexIndices = [{', '.join(str(point) for face in faces for point in face)}]",
        f"    point3f[] points = {_tuples(points, 2)}",
        "    color3f[] primvars:displayColor = [(0.55, 0.6, 0.7)] (",
        '        interpolation = "constant"',
        "    )",
        f"    int[] primvars:skel:jointIndices = [{', '.join(map(str, joints))}] (",
        "        elementSize = 1",
        '        interpolation = "vertex"',
        "    )",
        f"    float[] primvars:skel:jointWeights = [{', '.join(['1'] * len(joints))}] (",
        "        elementSize = 1",
        '        interpolation = "vertex"',
        "    )",
        "    rel skel:skeleton = </Humanoid/Skeleton>",
        '    uniform token subdivisionScheme = "catmullClark"',
        "}",
    ]


def character() -> list[str]:
    """Write the character's asset: SkelRoot, Skeleton and a body of rigidly skinned tubes."""
    height = number(humanoid.STATURE + 5.0, 1)
    return [
        'def SkelRoot "Humanoid" (',
        '    kind = "component"',
        ")",
        "{",
        f"    float3[] extent = [(-90, -5, -30), (90, {height}, 30)]",
        "",
        *indent(skeleton()),
        "",
        *indent(_body()),
        "}",
    ]


def _samples(values: FloatArray, decimals: int) -> list[str]:
    rows = [f"    {frame}: {_tuples(value, decimals)}," for frame, value in enumerate(values)]
    return ["{", *rows, "}"]


def _timed(declaration: str, values: FloatArray, decimals: int) -> list[str]:
    first, *rest = _samples(values, decimals)
    return [f"{declaration}.timeSamples = {first}", *rest]


def animation(
    name: str, motion: Motion, joints: Sequence[str], header: Sequence[str], properties: Sequence[str]
) -> list[str]:
    """Write a SkelAnimation of some joints, one sample a frame from time code 0.

    Parameters
    ----------
    joints
        Last names of the joints to write, in order.
    header
        Lines of the prim's metadata.
    properties
        Lines to put before the animation's own properties.
    """
    index = [humanoid.index_of(joint) for joint in joints]
    places = np.tile(humanoid.OFFSETS[index], (len(motion.root), 1, 1))
    if 0 in index:
        places[:, index.index(0)] = motion.root
    return [
        f'def SkelAnimation "{name}" (',
        *indent(header),
        ")",
        "{",
        *indent(properties),
        f"    uniform token[] joints = {tokens(humanoid.JOINTS[i] for i in index)}",
        *indent(_timed("quatf[] rotations", motion.rotations[:, index], 5)),
        f"    half3[] scales = [{', '.join(['(1, 1, 1)'] * len(index))}]",
        *indent(_timed("float3[] translations", places, 3)),
        "}",
    ]


def shot_character(sketch: Sequence[str]) -> list[str]:
    """Write the character in a shot: the referenced asset, the sketch and its binding."""
    return [
        'def SkelRoot "Humanoid" (',
        '    kind = "component"',
        "    prepend references = @./humanoid.usda@",
        ")",
        "{",
        '    over "Skeleton" (',
        '        prepend apiSchemas = ["SkelBindingAPI"]',
        "    )",
        "    {",
        "        rel skel:animationSource = </Humanoid/Sketch>",
        "    }",
        "",
        *indent(sketch),
        "}",
    ]
