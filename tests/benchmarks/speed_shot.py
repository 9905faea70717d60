"""The shot that the speed benchmark works on: made here, from nothing but formulas and a seed.

A 31-joint humanoid with a 440-frame walk sketch at 24 frames a second and 12 takes as long, every joint of every take
moving as in a recording. What matters is the amount of data and that the method has real choices, not looks.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

__all__ = ["FRAMES", "FRAME_RATE", "JOINTS", "SKETCH", "TAKE_COUNT", "write_shot"]

FloatArray = npt.NDArray[np.float64]

FRAME_RATE = 24.0
FRAMES = 440
TAKE_COUNT = 12
SKETCH = "/Character/Sketch"

_SEED = 2002
_STRIDE = 0.9  # per second
_HARMONICS = 8  # of the stride: up to 7.2 a second, where recorded walks have little left

_SPINE = ("LowerBack", "Spine", "Spine1", "Neck", "Neck1", "Head")
_LEG = ("HipJoint", "UpLeg", "Leg", "Foot", "ToeBase")
_ARM = ("Shoulder", "Arm", "ForeArm", "Hand", "FingerBase", "HandIndex1", "Thumb")
_LOWER_BODY = ("Hips", "*UpLeg", "*Leg", "*Foot")
_UPPER_BODY = (*_SPINE, "*Shoulder", "*Arm", "*ForeArm")


def _chain(parent: str, names: Sequence[str]) -> list[str]:
    out = []
    for name in names:
        parent = f"{parent}/{name}"
        out.append(parent)
    return out


def _build_joints() -> tuple[str, ...]:
    spine = _chain("Hips", _SPINE)
    legs = [joint for side in ("Left", "Right") for joint in _chain("Hips", [side + name for name in _LEG])]
    arms = [joint for side in ("Left", "Right") for joint in _chain(spine[2], [side + name for name in _ARM])]
    return ("Hips", *legs, *spine, *arms)


JOINTS = _build_joints()
_SIDE = np.array([-1.0 if "Right" in joint.rpartition("/")[2] else 1.0 for joint in JOINTS])


@dataclass(frozen=True)
class _Motion:
    """Arrays as USD wants them: time codes [F], rotations [F, J, 4] (real last), translations [F, J, 3]."""

    time_codes: FloatArray
    rotations: npt.NDArray[np.float32]
    translations: npt.NDArray[np.float32]


def _offsets() -> FloatArray:
    offsets = np.zeros((len(JOINTS), 3))
    for i, joint in enumerate(JOINTS):
        name = joint.rpartition("/")[2].removeprefix("Left").removeprefix("Right")
        side = [0.09, -0.05, 0.0] if name in _LEG[:2] else [0.12, 0.0, 0.0]
        down = [0.0, -0.42, 0.0] if name in _LEG[2:4] else side
        offsets[i] = [0.0, 0.12, 0.0] if name in _SPINE else np.multiply(down, [_SIDE[i], 1.0, 1.0])
    offsets[0] = [0.0, 0.95, 0.0]
    return offsets


_OFFSETS = _offsets()
# One performer: every take is a variation of the same walk, or nothing would match.
_WALK = np.random.default_rng(_SEED).normal(size=(_HARMONICS, len(JOINTS), 3, 2))


def _make_motion(seed: int, rate: float) -> _Motion:
    """Make a walk; the right side runs half a stride behind the left."""
    noise = np.random.default_rng(seed)
    seconds = np.arange(round((FRAMES - 1) * rate / FRAME_RATE) + 1) / rate
    stride = _STRIDE * (1.0 + 0.03 * noise.normal())
    drift = 0.1 * np.sin(2.0 * np.pi * (0.05 * seconds + noise.uniform()))
    phase = 2.0 * np.pi * (stride * seconds + noise.uniform())[:, None] + drift[:, None] + np.pi / 2.0 * (1.0 - _SIDE)
    swing = np.zeros((len(seconds), len(JOINTS), 3))
    for k in range(_HARMONICS):
        waves = (_WALK[k] + 0.2 * noise.normal(size=_WALK[k].shape)) / (k + 1) ** 1.5
        angle = (k + 1) * phase[..., None]
        swing += waves[..., 0] * np.cos(angle) + waves[..., 1] * np.sin(angle)
    translations = np.broadcast_to(_OFFSETS, swing.shape).copy()
    translations[:, 0, 2] += 1.3 * seconds
    translations[:, 0, 1] += 0.02 * np.cos(2.0 * phase[:, 0])
    return _Motion(seconds * rate, _to_quaternions(0.15 * swing), translations.astype(np.float32))


def _to_quaternions(vectors: FloatArray) -> npt.NDArray[np.float32]:
    """Turn rotation vectors, radians, into quaternions with the real part last."""
    angle = np.linalg.norm(vectors, axis=-1, keepdims=True)
    imaginary = vectors * 0.5 * np.sinc(angle / (2.0 * np.pi))
    return np.concatenate([imaginary, np.cos(angle / 2.0)], axis=-1).astype(np.float32)


def write_shot(folder: Path, *, take_rate: float) -> Path:
    """Write a library of takes and a shot that references it, both crate.

    Parameters
    ----------
    folder
        Where to write ``takes.usd`` and ``shot.usd``.
    take_rate
        Frames per second the takes were recorded at.

    Returns
    -------
    Path
        The shot.
    """
    takes = _open_stage(folder / "takes.usd", take_rate)
    takes.SetDefaultPrim(UsdSkel.Root.Define(takes, "/Takes").GetPrim())
    _author_skeleton(takes, "/Takes/Skeleton", "/Takes/take_01")
    for i in range(1, TAKE_COUNT + 1):
        _author_animation(takes, f"/Takes/take_{i:02d}", _make_motion(_SEED + i, take_rate))
    takes.Save()
    shot = _open_stage(folder / "shot.usd", FRAME_RATE)
    _author_character(shot)
    shot.Save()
    return folder / "shot.usd"


def _open_stage(file_path: Path, rate: float) -> Usd.Stage:
    stage = Usd.Stage.CreateNew(str(file_path))
    stage.SetTimeCodesPerSecond(rate)
    stage.SetFramesPerSecond(rate)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    return stage


def _author_character(shot: Usd.Stage) -> None:
    shot.SetDefaultPrim(UsdSkel.Root.Define(shot, "/Character").GetPrim())
    _author_skeleton(shot, "/Character/Skeleton", SKETCH)
    sketch = _author_animation(shot, SKETCH, _make_motion(_SEED, FRAME_RATE))
    shot.DefinePrim("/Takes").GetReferences().AddReference("./takes.usd")
    sketch.AddAppliedSchema("MtexSketchAPI")
    sketch.CreateRelationship("mtex:takes", custom=False).SetTargets([Sdf.Path("/Takes")])
    for name, channels in (
        ("match", ("LeftUpLeg.rx", "LeftLeg.rx")),
        ("texture", _LOWER_BODY),
        ("synthesize", _UPPER_BODY),
    ):
        kind = Sdf.ValueTypeNames.TokenArray
        sketch.CreateAttribute(f"mtex:{name}", kind, False, Sdf.VariabilityUniform).Set(channels)


def _author_skeleton(stage: Usd.Stage, prim_path: str, animation: str) -> None:
    skeleton = UsdSkel.Skeleton.Define(stage, prim_path)
    local = [Gf.Matrix4d().SetTranslate(Gf.Vec3d(*offset)) for offset in _OFFSETS.tolist()]
    skeleton.CreateJointsAttr(JOINTS)
    skeleton.CreateRestTransformsAttr(local)
    skeleton.CreateBindTransformsAttr(local)
    binding = UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
    binding.CreateAnimationSourceRel().SetTargets([Sdf.Path(animation)])


def _author_animation(stage: Usd.Stage, prim_path: str, motion: _Motion) -> Usd.Prim:
    """Write all three attributes at every frame, as recordings come."""
    animation = UsdSkel.Animation.Define(stage, prim_path)
    animation.CreateJointsAttr(JOINTS)
    scales = Vt.Vec3hArray.FromNumpy(np.ones((len(JOINTS), 3), dtype=np.float16))
    attributes = (animation.CreateRotationsAttr(), animation.CreateTranslationsAttr(), animation.CreateScalesAttr())
    with Sdf.ChangeBlock():
        for time_code, rotations, translations in zip(
            motion.time_codes.tolist(), motion.rotations, motion.translations, strict=True
        ):
            values = (Vt.QuatfArray.FromNumpy(rotations), Vt.Vec3fArray.FromNumpy(translations), scales)
            for attribute, value in zip(attributes, values, strict=True):
                attribute.Set(value, time_code)
    return animation.GetPrim()
