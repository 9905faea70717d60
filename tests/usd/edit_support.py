"""A shot with edits: a walking character of eleven joints, another walk, and what is declared on the two as text."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

import mtex_usd
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from tests.synthetic import walk
from tests.usd.playback import select_variant, skeleton_query

__all__ = [
    "ANIMATION",
    "BEFORE",
    "FEW",
    "FRAMES",
    "HALF",
    "HEADER",
    "MODEL",
    "NAMES",
    "OTHER",
    "SKELETON",
    "STACKS",
    "angles",
    "by_variant",
    "declare",
    "play",
    "play_clip",
    "read",
    "read_custom_data",
    "variants_of",
    "write_animation",
    "write_base",
    "write_shot",
    "write_skeleton",
]

FloatArray = npt.NDArray[np.float64]

MODEL, SKELETON, ANIMATION, OTHER = "/Hero", "/Hero/Rig", "/Hero/Walk", "/Takes/Other"
FRAMES = 60

HEADER = "#usda 1.0\n(\n timeCodesPerSecond = {rate}\n framesPerSecond = 24\n metersPerUnit = 0.01\n upAxis = 'Y'\n"

# Three stacks of four edits, one of them with another motion.
STACKS = """
    uniform token[] mtex:edits = ["calm", "raise"]
    uniform token[] mtex:edits:slower = ["slow"]
    uniform token[] mtex:edits:other = ["half"]
    uniform token mtex:edit:calm:op = "lowpass"
    uniform double[] mtex:edit:calm:frequencies = [1.5]
    uniform token[] mtex:edit:calm:channels = ["*Arm"]
    uniform token mtex:edit:raise:op = "displace"
    uniform timecode[] mtex:edit:raise:keys = [30]
    uniform token[] mtex:edit:raise:channels = ["LeftArm"]
    uniform double3[] mtex:edit:raise:rotations = [(0, 0, 40)]
    uniform double2 mtex:edit:raise:scope = (0.5, 0.5)
    uniform token mtex:edit:slow:op = "scaleTime"
    uniform double mtex:edit:slow:factor = 1.5
    uniform token mtex:edit:half:op = "blend"
    rel mtex:edit:half:with = </Takes/Other>
    uniform double[] mtex:edit:half:weights = [0.5]
"""
NAMES = ("calm", "raise", "slow", "half")
# A blend with the animation at a path, and its weight.
HALF = """
    uniform token[] mtex:edits = ["half"]
    uniform token mtex:edit:half:op = "blend"
    rel mtex:edit:half:with = <%s>
    uniform double[] mtex:edit:half:weights = [%s]
"""
# Edits to be made of a take before it is used.
BEFORE = """
    uniform token[] mtex:edits:before = ["quick"]
    uniform token mtex:edit:quick:op = "scaleTime"
    uniform double mtex:edit:quick:factor = 0.5
    uniform timecode mtex:edit:quick:end = 59
    uniform token mtex:edit:quick:ends = "loop"
"""
# Sparse poses of a smoothed motion.
FEW = """
    uniform token[] mtex:edits = ["calm", "few"]
    uniform token[] mtex:edits:all = ["calm"]
    uniform token mtex:edit:calm:op = "lowpass"
    uniform double[] mtex:edit:calm:frequencies = [3]
    uniform token mtex:edit:few:op = "reduceKeys"
    uniform token mtex:edit:few:form = "poses"
    uniform double mtex:edit:few:tolerance = 1
    uniform double mtex:edit:few:distance = 0.01
    uniform timecode[] mtex:edit:few:keys = [17, 43]
"""

_HEADER = """#usda 1.0
(
    defaultPrim = "Hero"
    metersPerUnit = 0.01
    upAxis = "Y"
    timeCodesPerSecond = 24
    framesPerSecond = 24
    startTimeCode = 0
    endTimeCode = 59
    subLayers = [@./base.usda@]
)
"""


def write_animation(stage: Usd.Stage, prim_path: str, clip: Clip) -> Usd.Prim:
    """Author a clip as a SkelAnimation, scales included."""
    animation = UsdSkel.Animation.Define(stage, prim_path)
    animation.CreateJointsAttr(clip.joints)
    rotations, translations = animation.CreateRotationsAttr(), animation.CreateTranslationsAttr()
    animation.CreateScalesAttr(Vt.Vec3hArray([Gf.Vec3h(1.0)] * len(clip.joints)))
    for i, time_code in enumerate(clip.time_codes.tolist()):
        # The constructor takes components real first.
        rotations.Set(Vt.QuatfArray([Gf.Quatf(*map(float, q)) for q in clip.rotations[i]]), time_code)
        translations.Set(Vt.Vec3fArray.FromNumpy(clip.translations[i].astype(np.float32)), time_code)
    return animation.GetPrim()


def write_skeleton(stage: Usd.Stage, prim_path: str, skeleton: Skeleton, animation: str) -> None:
    """Author a Skeleton that plays an animation."""
    prim = UsdSkel.Skeleton.Define(stage, prim_path)
    prim.CreateJointsAttr(skeleton.joints)
    rest = Vt.Matrix4dArray([Gf.Matrix4d(matrix.tolist()) for matrix in skeleton.rest])
    prim.CreateRestTransformsAttr(rest)
    prim.CreateBindTransformsAttr(UsdSkel.ConcatJointTransforms(UsdSkel.Topology(list(skeleton.joints)), rest))
    UsdSkel.BindingAPI.Apply(prim.GetPrim()).CreateAnimationSourceRel().SetTargets([animation])


def write_base(folder: Path, *, frames: int = FRAMES, take_frames: int = FRAMES) -> Path:
    """Write ``base.usda``: the character with its walk, and the other walk."""
    stage = Usd.Stage.CreateNew(str(folder / "base.usda"))
    stage.SetTimeCodesPerSecond(24.0)
    stage.SetMetadata("metersPerUnit", 0.01)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    clip = walk(frames, seed=1)
    Usd.ModelAPI(UsdSkel.Root.Define(stage, MODEL).GetPrim()).SetKind("component")
    write_skeleton(stage, SKELETON, clip.skeleton, ANIMATION)
    write_animation(stage, ANIMATION, clip)
    write_animation(stage, OTHER, walk(take_frames, seed=2))
    stage.GetRootLayer().Save()
    return folder / "base.usda"


def declare(prim_path: str, body: str, edits: Sequence[str], *, schemas: Sequence[str] = ()) -> str:
    """Give the overs that apply edits, and other schemas, to an animation two levels down."""
    names = ["MtexEditStackAPI", *(f"MtexEditAPI:{name}" for name in edits), *schemas]
    applied = ", ".join(f'"{name}"' for name in names)
    above, name = Sdf.Path(prim_path).GetParentPath().name, Sdf.Path(prim_path).name
    return f'over "{above}"\n{{\n over "{name}" (prepend apiSchemas = [{applied}])\n {{\n{body}\n }}\n}}\n'


def write_shot(
    folder: Path,
    body: str,
    edits: Sequence[str] = ("e",),
    *,
    more: str = "",
    schemas: Sequence[str] = (),
    name: str = "shot.usda",
) -> Path:
    """Write a shot over ``base.usda``, which is written where it is not there, with edits declared on the walk."""
    if not (folder / "base.usda").exists():
        write_base(folder)
    shot = folder / name
    text = declare(ANIMATION, body, edits, schemas=schemas)
    shot.write_text(_HEADER + text + more, encoding="utf-8")
    return shot


def variants_of(layer_path: Path) -> tuple[list[str], str]:
    """Give the variants in an override layer, sorted, and the one selected."""
    layer = Sdf.Layer.OpenAsAnonymous(str(layer_path))
    prim = layer.GetPrimAtPath(MODEL)
    return sorted(prim.variantSets["mtex"].variants.keys()), prim.variantSelections["mtex"]


def play(
    stage_path: Path,
    times: Sequence[float],
    variant: str | None = None,
    *,
    skeleton: str = SKELETON,
    model: str = MODEL,
) -> FloatArray:
    """Give the joints' local matrices [F, J, 4, 4] as UsdSkel poses the character."""
    stage = Usd.Stage.Open(str(stage_path))
    if variant is not None:
        select_variant(stage, model, "mtex", variant)
    query = skeleton_query(stage, skeleton)
    return np.array([[np.array(m) for m in query.ComputeJointLocalTransforms(time)] for time in times])


def play_clip(clip: Clip) -> FloatArray:
    """Give what UsdSkel should make of a clip, [F, J, 4, 4] (row vectors)."""
    w, x, y, z = np.moveaxis(clip.rotations, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
        [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
        [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
    ]
    out = np.zeros((*w.shape, 4, 4))
    out[..., :3, :3] = np.moveaxis(np.array(rows), (0, 1), (-2, -1)) * clip.scales[..., None]
    out[..., 3, :3], out[..., 3, 3] = clip.translations, 1.0
    return out


def read_custom_data(stage_path: Path, variant: str) -> Mapping[str, object]:
    """Read what a variant carries."""
    stage = Usd.Stage.Open(str(stage_path))
    select_variant(stage, MODEL, "mtex", variant)
    data: Mapping[str, object] = stage.GetPrimAtPath(f"{ANIMATION}_mtex").GetCustomDataByKey("mtex")
    return data


def by_variant(results: Sequence[Any]) -> dict[str, Any]:
    """Give results by the name of their variant."""
    return {result.variant: result for result in results}


def read(stage_path: Path, prim_path: str = ANIMATION) -> Clip:
    """Read an animation, the walk unless otherwise said."""
    return mtex_usd.read_clip(stage_path, prim_path)


def angles(one: Clip, two: Clip) -> FloatArray:
    """Degrees between the joints of clips on the same joints, [F, J]."""
    cosine = np.abs((one.rotations * two.rotations).sum(axis=-1))
    return 2.0 * np.degrees(np.arccos(np.clip(cosine, 0.0, 1.0)))
