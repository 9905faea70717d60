"""Curves beside an animation: USD splines that evaluate to the very curves, named so that joints are found again."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Sdf, Ts, Usd

import mtex_usd
from mtex_usd import edit
from mtex_usd.usd.control_curves import CONTROLS_SUFFIX, author_curves
from tests.synthetic import walk
from tests.usd.edit_support import ANIMATION, FRAMES, MODEL, play, play_clip, write_shot
from tests.usd.playback import no_diagnostics, select_variant

CONTROLS = f"{ANIMATION}_mtex{CONTROLS_SUFFIX}"
KEYS = """
    uniform token[] mtex:edits = ["keys"]
    uniform token[] mtex:edits:calm = ["calm"]
    uniform token mtex:edit:keys:op = "reduceKeys"
    uniform double mtex:edit:keys:tolerance = 1
    uniform double mtex:edit:keys:distance = 0.01
    uniform token mtex:edit:calm:op = "lowpass"
    uniform double[] mtex:edit:calm:frequencies = [1]
"""
SUB_FRAMES = np.linspace(0.0, FRAMES - 1.0, 5 * (FRAMES - 1) + 1)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Any:
    shot = write_shot(tmp_path_factory.mktemp("curves"), KEYS, ["keys", "calm"])
    return next(result for result in mtex_usd.apply_edits(shot) if result.variant == "edited")


def attributes_of(stage: Usd.Stage) -> dict[tuple[str, str], Usd.Attribute]:
    """Give the control attributes by joint and kind, as their custom data says."""
    prim = stage.GetPrimAtPath(CONTROLS)
    data = {attribute.GetName(): attribute.GetCustomDataByKey("mtex") for attribute in prim.GetAuthoredAttributes()}
    return {(each["joint"], each["kind"]): prim.GetAttribute(name) for name, each in data.items()}


def test_every_curve_is_a_spline(written: Any) -> None:
    stage = Usd.Stage.Open(str(written.stage))
    found = attributes_of(stage)
    assert isinstance(written.keys, edit.ReducedKeys)
    assert set(found) == {(curve.joint, curve.kind) for curve in written.keys.curves}
    assert stage.GetPrimAtPath(CONTROLS).GetTypeName() == "Scope"
    for curve in written.keys.curves:
        attribute = found[curve.joint, curve.kind]
        assert attribute.GetTypeName() == Sdf.ValueTypeNames.Double
        assert attribute.GetName() == f"{curve.joint.replace('/', ':')}:{curve.kind}"
        unit = {"r": "degrees", "t": "stage units"}[curve.kind[0]]
        assert attribute.GetCustomDataByKey("mtex") == {"joint": curve.joint, "kind": curve.kind, "unit": unit}
        knots = attribute.GetSpline().GetKnots()
        np.testing.assert_array_equal(list(knots.keys()), curve.time_codes)


def test_splines_are_the_curves_at_sub_frames(written: Any) -> None:
    """Attribute.Get, as any application reads them; before and after the keys the value holds."""
    stage = Usd.Stage.Open(str(written.stage))
    found = attributes_of(stage)
    times = np.concatenate([[-20.0], SUB_FRAMES, [FRAMES + 20.0]])
    with no_diagnostics():
        for curve in written.keys.curves:
            values = [found[curve.joint, curve.kind].Get(float(time)) for time in times]
            np.testing.assert_allclose(values, curve.evaluate(times), atol=1e-6, err_msg=f"{curve.joint} {curve.kind}")


def test_samples_are_the_curves_at_frames(written: Any) -> None:
    """What the animation plays is what the curves say."""
    played = play(written.stage, range(FRAMES), "edited")
    np.testing.assert_allclose(played, play_clip(written.keys.evaluate()), atol=2e-4)


def test_controls_come_with_their_variant_alone(written: Any) -> None:
    stage = Usd.Stage.Open(str(written.stage))
    for variant, there in (("edited", True), ("calm", False), ("original", False), ("edited", True)):
        select_variant(stage, MODEL, "mtex", variant)
        assert bool(stage.GetPrimAtPath(CONTROLS)) == there


def test_splines_move_with_the_layer(written: Any, tmp_path: Path) -> None:
    root = Sdf.Layer.CreateNew(str(tmp_path / "moved.usda"))
    root.subLayerPaths.append(str(written.stage))
    root.subLayerOffsets[0] = Sdf.LayerOffset(100.0, 2.0)
    root.timeCodesPerSecond = 24.0
    root.Save()
    stage = Usd.Stage.Open(str(tmp_path / "moved.usda"))
    found = attributes_of(stage)
    curve = max(written.keys.curves, key=lambda each: len(each.values))
    values = [found[curve.joint, curve.kind].Get(float(100.0 + 2.0 * time)) for time in SUB_FRAMES]
    np.testing.assert_allclose(values, curve.evaluate(SUB_FRAMES), atol=1e-6)


# --- any curve ---


def make_curve(joint: str = "Hips", kind: str = "rx", **values: Any) -> edit.KeyCurve:
    given = {name: np.asarray(value, dtype=np.float64) for name, value in values.items()}
    given.setdefault("frames", given["time_codes"])
    for name in ("slopes_before", "slopes_after"):
        given.setdefault(name, np.zeros(len(given["values"])))
    return edit.KeyCurve(joint=joint, kind=kind, **given)


def author(*curves: edit.KeyCurve) -> tuple[Sdf.Layer, list[Sdf.AttributeSpec]]:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    model = Sdf.PrimSpec(layer, "Hero", Sdf.SpecifierDef)
    author_curves(Sdf.PrimSpec(model, "Walk", Sdf.SpecifierDef, "SkelAnimation"), curves)
    return layer, list(layer.GetPrimAtPath(f"/Hero/Walk{CONTROLS_SUFFIX}").attributes)


def read(layer: Sdf.Layer, name: str, times: np.ndarray) -> np.ndarray:
    stage = Usd.Stage.Open(layer)
    attribute = stage.GetPrimAtPath(f"/Hero/Walk{CONTROLS_SUFFIX}").GetAttribute(name)
    return np.array([attribute.Get(float(time)) for time in times])


@pytest.mark.parametrize(
    "curve",
    [
        make_curve(time_codes=[5.0], values=[3.5]),
        make_curve(time_codes=[0.0, 1.0], values=[1.0, -1.0]),
        make_curve(
            time_codes=[-8.0, -2.5, 40.0], values=[0, 90, -90], slopes_before=[9, -3, 1], slopes_after=[2, 30, 0]
        ),
        make_curve(time_codes=[0, 4, 4.001, 9], values=[0, 1, 80, 81]),
        make_curve(time_codes=[0, 1000.0], values=[1e6, -1e6], slopes_after=[1e5, 0], slopes_before=[0, -1e5]),
    ],
    ids=["constant", "two keys", "corners", "jump", "steep"],
)
def test_any_curve(curve: edit.KeyCurve) -> None:
    layer, (attribute,) = author(curve)
    times = np.linspace(curve.time_codes[0] - 1.0, curve.time_codes[-1] + 1.0, 501)
    size = max(1.0, float(np.abs(curve.values).max()))
    np.testing.assert_allclose(read(layer, attribute.name, times) / size, curve.evaluate(times) / size, atol=1e-6)
    assert attribute.default == curve.values[0]


def test_names_are_made_valid_and_unique() -> None:
    joints = ("Hips/Left Leg", "Hips/Left-Leg", "Hips/Left_Leg", "1st", "mixamorig:Hips")
    layer, attributes = author(*(make_curve(joint, time_codes=[0.0], values=[1.0]) for joint in joints))
    names = [attribute.name for attribute in attributes]
    assert len(set(names)) == len(joints)
    assert all(Sdf.Path.IsValidNamespacedIdentifier(name) for name in names)
    assert [attribute.customData["mtex"]["joint"] for attribute in attributes] == list(joints)
    assert Sdf.Layer.CreateAnonymous(".usda").ImportFromString(layer.ExportToString())


def test_knots_are_cubics_with_tangents_of_a_third() -> None:
    """What a curve editor shows."""
    clip = walk(30, seed=3)
    curve = max(edit.reduce_keys(clip).curves, key=lambda each: len(each.values))
    _, (attribute,) = author(curve)
    knots = list(attribute.GetSpline().GetKnots().values())
    widths = np.diff(curve.time_codes) / 3.0
    assert {knot.GetNextInterpolation() for knot in knots} == {Ts.InterpCurve}
    np.testing.assert_allclose([knot.GetPostTanWidth() for knot in knots[:-1]], widths)
    np.testing.assert_allclose([knot.GetPreTanWidth() for knot in knots[1:]], widths)
    np.testing.assert_allclose([knot.GetPreTanSlope() for knot in knots], curve.slopes_before)
    np.testing.assert_allclose([knot.GetPostTanSlope() for knot in knots], curve.slopes_after)
