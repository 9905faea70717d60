"""The check after writing: it finds what is wrong, and names who blocks."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdSkel, Vt

from mtex_usd.errors import ResultError, StageError
from mtex_usd.usd.check import check_override
from mtex_usd.usd.override import CharacterResult, VariantSamples, write_override
from mtex_usd.usd.source_stage import open_source
from tests.usd.base_situations import build_instanceable, build_local, build_unbound
from tests.usd.stage_parts import Situation
from tests.usd.synthetic import make_results


def _write(situation: Situation) -> tuple[tuple[CharacterResult, ...], Path]:
    stage = open_source(situation.shot).stage
    results = make_results(stage, situation)
    _, thin_root = write_override(stage, results, situation.shot.with_name("shot.mtex.usd"))
    return results, thin_root


def _turned(samples: VariantSamples) -> VariantSamples:
    rotations = samples.rotations.copy()
    rotations[-1, 0] = [0, 1, 0, 0]
    return replace(samples, rotations=rotations)


DAMAGE: dict[str, Callable[[VariantSamples], VariantSamples]] = {
    "rotations": _turned,
    "translations": lambda v: replace(v, translations=v.translations + np.float32(0.001)),
    "scales": lambda v: replace(v, scales=v.scales * np.float16(1.01)),
    "joints": lambda v: replace(v, joints=v.joints[::-1]),
    "times": lambda v: replace(v, time_codes=np.concatenate([v.time_codes[:1] - 0.5, v.time_codes[1:]])),
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE)
def test_any_difference_is_found(tmp_path: Path, damage: Callable[[VariantSamples], VariantSamples]) -> None:
    """The last variant of three differs in one respect."""
    (result,), thin_root = _write(build_local(tmp_path, "Skeleton"))
    check_override(thin_root, [result])
    wrong = replace(result, variants=(*result.variants[:2], damage(result.variants[2])))
    with pytest.raises(ResultError, match="variant path_03 of /World/Char/Anim differs from what was computed"):
        check_override(thin_root, [wrong])


def test_changed_original_is_found(tmp_path: Path) -> None:
    """Somebody adds a pose to the variant that should add nothing."""
    results, thin_root = _write(build_local(tmp_path, "Skeleton"))
    layer = Sdf.Layer.FindOrOpen(str(thin_root.with_name("shot.mtex.usd")))
    output = layer.GetPrimAtPath("/World/Char{mtex=original}Anim_mtex")
    Sdf.AttributeSpec(output, "joints", Sdf.ValueTypeNames.TokenArray).default = ["Hips"]
    with pytest.raises(ResultError, match="variant original of /World/Char/Anim differs"):
        check_override(thin_root, results)


def test_local_opinion_on_the_output_is_named(tmp_path: Path) -> None:
    """The shot has opinions of its own on the prim we define, and local ones beat variants."""
    situation = build_local(tmp_path, "Skeleton")
    results, thin_root = _write(situation)
    stage = Usd.Stage.Open(str(situation.shot))
    UsdSkel.Animation(stage.OverridePrim("/World/Char/Anim_mtex")).CreateRotationsAttr(Vt.QuatfArray(6))
    stage.Save()
    with pytest.raises(StageError, match=r"stronger opinion in .*shot\.usda at /World/Char/Anim_mtex\.rotations"):
        check_override(thin_root, results)


def test_class_binding_on_an_instance_is_named(tmp_path: Path) -> None:
    """Inherits beat variants, and inside an instance the local binding does not count."""
    situation = build_instanceable(tmp_path, "Skeleton")
    stage = Usd.Stage.Open(str(situation.shot))
    stage.CreateClassPrim("/_cast")
    skeleton = stage.OverridePrim("/_cast/Rig/Skel")
    UsdSkel.BindingAPI.Apply(skeleton).CreateAnimationSourceRel().SetTargets(["/_cast/Anim"])
    stage.GetPrimAtPath("/World/Char").GetInherits().AddInherit("/_cast")
    stage.Save()
    results, thin_root = _write(situation)
    with pytest.raises(StageError, match=r"shot\.usda at /_cast/Rig/Skel\.skel:animationSource"):
        check_override(thin_root, results)


def test_binding_in_the_shots_root_layer_is_named(tmp_path: Path) -> None:
    """The override layer lies below the shot's root layer, whose local binding is stronger there."""
    situation = build_local(tmp_path, "Skeleton")
    _write(situation)
    shot = Sdf.Layer.FindOrOpen(str(situation.shot))
    shot.subLayerPaths.append("./shot.mtex.usd")
    shot.Save()
    results, thin_root = _write(situation)
    with pytest.raises(
        StageError,
        match=r"on /World/Char/Rig/Skel is blocked .*shot\.usda at /World/Char/Rig/Skel\.skel:animationSource.*"
        r"stack the override layer over that layer",
    ):
        check_override(thin_root, results)


def test_unbound_inside_an_instance_passes(tmp_path: Path) -> None:
    """The original plays nothing there, as before; the paths play."""
    build_unbound(tmp_path).shot.rename(tmp_path / "asset.usda")
    stage = Usd.Stage.CreateNew(str(tmp_path / "shot.usda"))
    stage.SetStartTimeCode(1)
    stage.SetEndTimeCode(61)
    prim = stage.DefinePrim("/Char")
    prim.GetReferences().AddReference("./asset.usda", "/World/Char")
    prim.SetInstanceable(True)
    stage.Save()
    situation = Situation(shot=tmp_path / "shot.usda", animations=("/Char/Rig/Anim",), expected=())
    results, thin_root = _write(situation)
    check_override(thin_root, results)
