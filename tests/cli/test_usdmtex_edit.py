"""``usdmtex-edit``: contacts found, written, edited and held, read back through UsdSkel."""

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdSkel

import mtex_usd
from mtex_usd.cli.usdmtex import main as texture
from mtex_usd.cli.usdmtex_edit import main
from tests.cli.support import MODEL, SKETCH, Capture, contents

HELD_MM = 0.5


def stack(folder: Path, *layers: str) -> str:
    """Write a shot over some layers; gives its name."""
    layer = Sdf.Layer.CreateNew(str(folder / "shot.usda"))
    layer.subLayerPaths = list(layers)
    layer.timeCodesPerSecond = layer.framesPerSecond = 24.0
    layer.Save()
    return "shot.usda"


def track(stage: Usd.Stage, joint: str, offset: Sequence[float], time_codes: Sequence[float]) -> np.ndarray:
    """Where a point of a joint is, through UsdSkel, metres, [N, 3]."""
    query = UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath("/Humanoid/Skeleton")))
    index = [str(name) for name in query.GetJointOrder()].index(joint)
    matrices = [np.array(query.ComputeJointSkelTransforms(time)[index]) for time in time_codes]
    return np.array([([*offset, 1.0] @ matrix)[:3] for matrix in matrices]) * 0.01


def contacts_of(file_path: str) -> dict[str, tuple[str, tuple[float, ...], list[tuple[float, float]]]]:
    """Joint, offset and intervals by contact."""
    stage = Usd.Stage.Open(file_path)
    prim = stage.GetPrimAtPath(SKETCH)
    found = {}
    for name in {str(p).split(":")[2] for p in prim.GetAuthoredPropertyNames() if str(p).startswith("mtex:contact:")}:
        get = lambda what, name=name: prim.GetAttribute(f"mtex:contact:{name}:{what}").Get()  # noqa: E731
        times = [code.GetValue() for code in get("intervals")]
        found[name] = (str(get("joint")), tuple(get("offset")), list(zip(times[::2], times[1::2], strict=True)))
    return found


@pytest.fixture
def constrained(shot_folder: Path, capsys: Capture) -> Path:
    """A walk with its contacts found, written and held."""
    assert main(["contacts", "walk.usda", "--anim", SKETCH, "-o", "contacts.usda"]) == 0
    stack(shot_folder, "contacts.usda", "walk.usda")
    assert main(["constrain", "shot.usda"]) == 0
    capsys.readouterr()
    return shot_folder


def test_contacts_are_written_for_editing(shot_folder: Path, capsys: Capture) -> None:
    before = contents(shot_folder)
    assert main(["contacts", "walk.usda", "--anim", SKETCH, "-o", "contacts.usda"]) == 0
    assert SKETCH in capsys.readouterr().out
    assert {name: data for name, data in contents(shot_folder).items() if name in before} == before
    stack(shot_folder, "contacts.usda", "walk.usda")
    found = contacts_of("shot.usda")
    assert set(found) == {"left_heel", "left_toes", "right_heel", "right_toes"}
    for joint, _, intervals in found.values():
        assert joint.endswith(("Foot", "Toe"))
        assert 5 <= len(intervals) <= 7  # six steps of either foot in seven seconds, cut at the ends
        assert all(a < b for a, b in intervals)


def test_what_is_held_stands_still(constrained: Path) -> None:
    stage = Usd.Stage.Open("shot.constrain.stage.usda")
    before = Usd.Stage.Open("shot.usda")
    slid = []
    for joint, offset, intervals in contacts_of("shot.usda").values():
        for start, end in intervals:
            times = np.arange(start, end + 1.0)
            places = track(stage, joint, offset, times)
            assert np.linalg.norm(places - places.mean(axis=0), axis=1).max() * 1000.0 < HELD_MM
            slid.append(np.ptp(track(before, joint, offset, times), axis=0).max() * 1000.0)
    assert max(slid) > 5.0 * HELD_MM  # there was something to hold


def test_joints_that_hold_nothing_keep_their_bits(constrained: Path) -> None:
    shot, edited = Usd.Stage.Open("shot.usda"), Usd.Stage.Open("shot.constrain.stage.usda")
    before, after = shot.GetPrimAtPath(SKETCH), edited.GetPrimAtPath(f"{MODEL}/Sketch_mtex")
    times = before.GetAttribute("rotations").GetTimeSamples()
    assert after.GetAttribute("rotations").GetTimeSamples() == times
    joints = list(before.GetAttribute("joints").Get())
    assert list(after.GetAttribute("joints").Get())[: len(joints)] == joints
    scales = [prim.GetAttribute("scales").Get(10.0) for prim in (before, after)]
    np.testing.assert_array_equal(np.array(scales[1])[: len(joints)], np.array(scales[0]))


def test_the_original_is_a_variant(constrained: Path) -> None:
    layer = Sdf.Layer.OpenAsAnonymous("shot.constrain.usd")
    model = layer.GetPrimAtPath(MODEL)
    assert set(model.variantSets["mtex"].variants.keys()) == {"original", "constrained"}
    assert model.variantSelections["mtex"] == "constrained"


def test_a_second_run_gives_equal_bytes(constrained: Path) -> None:
    before = contents(constrained)
    assert main(["constrain", "shot.usda", "-q"]) == 0
    assert contents(constrained) == before


def test_detect_needs_no_declarations(shot_folder: Path, capsys: Capture) -> None:
    assert main(["constrain", "walk.usda", "--detect", "--anim", SKETCH, "--dry-run"]) == 0
    assert "constraints, met within" in capsys.readouterr().out
    assert not Path("walk.constrain.usd").exists()


def test_a_variant_that_there_is_not_cannot_be_selected(shot_folder: Path, capsys: Capture) -> None:
    assert main(["constrain", "walk.usda", "--detect", "--anim", SKETCH, "--select", "path_01", "--dry-run"]) == 2
    assert f"{SKETCH} gets no variant 'path_01'; expected one of original, constrained" in capsys.readouterr().err


def test_a_hand_touches_a_point(shot_folder: Path, capsys: Capture) -> None:
    text = """#usda 1.0
over "Humanoid" {
    over "Sketch" (prepend apiSchemas = ["MtexContactAPI:knob"]) {
        uniform token mtex:contact:knob:joint = "Hips"
        uniform token mtex:contact:knob:mode = "touch"
        uniform point3d mtex:contact:knob:point = (3, 92, 10)
        uniform timecode[] mtex:contact:knob:intervals = [60, 60]
    }
}
"""
    (shot_folder / "knob.usda").write_text(text, encoding="utf-8")
    stack(shot_folder, "knob.usda", "walk.usda")
    assert main(["constrain", "shot.usda"]) == 0
    stage = Usd.Stage.Open("shot.constrain.stage.usda")
    (place,) = track(stage, "Hips", (0.0, 0.0, 0.0), [60.0])
    np.testing.assert_allclose(place, (0.03, 0.92, 0.10), atol=HELD_MM / 1000.0)


def knob(point: str, name: str) -> str:
    """A contact of the hips with a point at frame 60."""
    return f"""        uniform token mtex:contact:{name}:joint = "Hips"
        uniform token mtex:contact:{name}:mode = "touch"
        uniform point3d mtex:contact:{name}:point = {point}
        uniform timecode[] mtex:contact:{name}:intervals = [60, 60]
"""


def test_contacts_that_fight_are_named(shot_folder: Path, capsys: Capture) -> None:
    schemas = '["MtexContactAPI:here", "MtexContactAPI:there"]'
    body = knob("(3, 92, 10)", "here") + knob("(3, 92, 60)", "there")
    text = f'#usda 1.0\nover "Humanoid" {{\n over "Sketch" (prepend apiSchemas = {schemas}) {{\n{body} }}\n}}\n'
    (shot_folder / "fight.usda").write_text(text, encoding="utf-8")
    stack(shot_folder, "fight.usda", "walk.usda")
    before = contents(shot_folder)
    assert main(["constrain", "shot.usda"]) == 4
    message = capsys.readouterr().err
    assert "here" in message
    assert "there" in message
    assert contents(shot_folder) == before


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["constrain", "walk.usda"], 3, "no animation to edit; expected an animation with MtexContactAPI:<name>"),
        (["constrain", "walk.usda", "--anim", "/Nobody"], 3, "there is no animation /Nobody"),
        (["constrain", "nothing.usda"], 2, "nothing.usda"),
        (["contacts", "walk.usda", "-o", "walk.usda"], 2, "walk.usda"),
    ],
)
def test_refusals(shot_folder: Path, capsys: Capture, arguments: list[str], code: int, message: str) -> None:
    before = contents(shot_folder)
    assert main(arguments) == code
    captured = capsys.readouterr()
    assert message in captured.err
    assert captured.out == ""
    assert contents(shot_folder) == before


def test_a_character_carried_by_a_moving_prim_is_refused(shot_folder: Path, capsys: Capture) -> None:
    text = """#usda 1.0
over "Humanoid" {
    double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 100: (0, 0, 50) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""
    (shot_folder / "carried.usda").write_text(text, encoding="utf-8")
    stack(shot_folder, "carried.usda", "walk.usda")
    assert main(["constrain", "shot.usda", "--detect", "--anim", SKETCH]) == 3
    assert "/Humanoid moves, and with it the floor" in capsys.readouterr().err


def test_process_holds_contacts(shot_folder: Path) -> None:
    """With ``mtex:contacts`` detect the feet of every variant keep still, and with off they slide."""
    text = '#usda 1.0\nover "Humanoid" {\nover "Sketch" {\nuniform token mtex:contacts = "detect"\n}\n}\n'
    (shot_folder / "detect.usda").write_text(text, encoding="utf-8")
    stack(shot_folder, "detect.usda", "walk.usda")
    (held,) = mtex_usd.process("shot.usda", paths=2)
    (loose,) = mtex_usd.process("walk.usda", paths=2)
    assert [v.fragments for v in held.variants] == [v.fragments for v in loose.variants]
    stage = Usd.Stage.Open(str(held.stage))
    for variant in held.variants:
        stage.GetPrimAtPath(MODEL).GetVariantSet("mtex").SetVariantSelection(variant.name)
        contacts = variant.custom_data["contacts"]
        assert len(contacts) >= 20
        for contact in contacts:
            times = np.arange(contact["start"], contact["end"] + 1.0)
            places = track(stage, contact["joint"], contact["offset"], times)
            assert np.linalg.norm(places - places.mean(axis=0), axis=1).max() * 1000.0 < HELD_MM


def test_the_installed_command_says_what_it_can() -> None:
    done = subprocess.run(
        [sys.executable, "-c", "import sys; from mtex_usd.cli.usdmtex_edit import main; sys.exit(main(['--help']))"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0
    assert "constrain" in done.stdout
    assert "contacts" in done.stdout


def test_texturing_does_not_replace_an_edit_nor_the_other_way_round(constrained: Path, capsys: Capture) -> None:
    assert texture(["walk.usda", "-q"]) == 0
    before = contents(constrained)
    assert texture(["shot.constrain.stage.usda"]) == 2
    assert "shot.constrain.usd holds what another command made" in capsys.readouterr().err
    assert main(["constrain", "shot.usda", "-o", "walk.mtex.usd"]) == 2
    assert "walk.mtex.usd holds what another command made" in capsys.readouterr().err
    assert contents(constrained) == before


def test_nothing_to_hold_is_said(shot_folder: Path, capsys: Capture) -> None:
    """A character that never sets a foot down."""
    text = '#usda 1.0\nover "Humanoid" {\nover "Sketch" {\nuniform token[] joints = ["Spine"]\n}\n}\n'
    (shot_folder / "none.usda").write_text(text, encoding="utf-8")
    stack(shot_folder, "none.usda", "walk.usda")
    assert main(["constrain", "shot.usda", "--detect", "--anim", SKETCH]) in (2, 3)
    assert not Path("shot.constrain.usd").exists()
