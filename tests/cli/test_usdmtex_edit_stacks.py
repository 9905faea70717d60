"""``usdmtex-edit STAGE``: stacks of edits run into an override layer, options, exit codes and files left alone."""

import shutil
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdSkel

import mtex_usd
from mtex_usd.cli.usdmtex import main as texture
from mtex_usd.cli.usdmtex_edit import main
from tests.cli.conftest import SAMPLES
from tests.cli.support import MODEL, SKETCH, Capture, contents, selection, variant_names

SKELETON = "/Humanoid/Skeleton"
CALM = """
    uniform token[] mtex:edits = ["calm"]
    uniform token[] mtex:edits:slower = ["slow"]
    uniform token mtex:edit:calm:op = "lowpass"
    uniform double[] mtex:edit:calm:frequencies = [1]
    uniform token mtex:edit:slow:op = "scaleTime"
    uniform double mtex:edit:slow:factor = 1.25
"""


def declare(folder: Path, body: str = CALM, *, edits: tuple[str, ...] = ("calm", "slow"), sketch: str = "") -> str:
    """Write a shot over ``walk.usda`` with edits declared on its sketch; gives its name."""
    schemas = ", ".join(f'"{name}"' for name in ("MtexEditStackAPI", *(f"MtexEditAPI:{edit}" for edit in edits)))
    text = "#usda 1.0\n(\n subLayers = [@./walk.usda@]\n timeCodesPerSecond = 24\n framesPerSecond = 24\n)\n"
    text += f'over "Humanoid"\n{{\nover "Sketch" (prepend apiSchemas = [{schemas}])\n{{\n{body}\n{sketch}\n}}\n}}\n'
    (folder / "shot.usda").write_text(text, encoding="utf-8")
    return "shot.usda"


def poses(file_path: str, variant: str | None = None, *, times: Sequence[float] = range(0, 171, 10)) -> np.ndarray:
    """Joint transforms through UsdSkel, [T, J, 4, 4]."""
    stage = Usd.Stage.Open(file_path)
    if variant:
        with Usd.EditContext(stage, stage.GetSessionLayer()):
            assert stage.GetPrimAtPath(MODEL).GetVariantSet("mtex").SetVariantSelection(variant)
    query = UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath(SKELETON)))
    return np.array([[np.array(matrix) for matrix in query.ComputeJointLocalTransforms(time)] for time in times])


@pytest.fixture
def shot(shot_folder: Path) -> str:
    return declare(shot_folder)


def fails(capsys: Capture, *arguments: str, code: int) -> str:
    """Run what must fail: the exit code is right, nothing is written or printed; gives the message."""
    before = contents(Path())
    assert main(arguments) == code
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("usdmtex-edit: error: ")
    assert "Traceback" not in captured.err
    assert contents(Path()) == before
    return captured.err


# --- the command ---


def test_what_is_printed_and_written(shot: str, capsys: Capture) -> None:
    before = contents(Path())
    assert main([shot]) == 0
    out = capsys.readouterr().out.splitlines()
    assert out[:2] == [
        f"{SKETCH}\t{MODEL}\t{{mtex}}\tedited\t0 to 170",
        f"{SKETCH}\t{MODEL}\t{{mtex}}\tslower\t0 to 212",
    ]
    assert [line.split()[0] for line in out[2:]] == ["wrote", "open"]
    assert [Path(line.split()[1]).name for line in out[2:]] == ["shot.edit.usd", "shot.edit.stage.usda"]
    after = contents(Path())
    assert {name: after[name] for name in before} == before
    assert set(after) - set(before) == {"shot.edit.usd", "shot.edit.stage.usda"}
    assert variant_names("shot.edit.usd") == ["edited", "original", "slower"]
    np.testing.assert_array_equal(poses("shot.edit.stage.usda", "original"), poses(shot))
    for one, two in (("original", "edited"), ("edited", "slower")):
        assert np.abs(poses("shot.edit.stage.usda", one) - poses("shot.edit.stage.usda", two)).max() > 0.01


def test_a_second_run_gives_equal_bytes(shot: str) -> None:
    assert main([shot, "-q"]) == 0
    before = contents(Path())
    assert main([shot, "-q"]) == 0
    assert main(["shot.edit.stage.usda", "-q"]) == 0
    assert contents(Path()) == before


def test_quiet_prints_nothing(shot: str, capsys: Capture) -> None:
    assert main([shot, "-q"]) == 0
    assert capsys.readouterr() == ("", "")


def test_dry_run_does_everything_but_write(shot: str, capsys: Capture) -> None:
    before = contents(Path())
    assert main([shot, "--dry-run"]) == 0
    out = capsys.readouterr().out
    assert "edited\t0 to 170" in out
    assert "wrote" not in out
    assert contents(Path()) == before


def test_dry_run_finds_what_is_wrong(shot_folder: Path, capsys: Capture) -> None:
    shot = declare(shot_folder, CALM.replace("[1]", "[-1]"))
    assert "edit calm (lowpass): bad frequency" in fails(capsys, shot, "--dry-run", code=2)


@pytest.mark.parametrize("variant", ["original", "slower", "edited"])
def test_select(shot: str, variant: str) -> None:
    assert main([shot, "--select", variant, "-q"]) == 0
    assert selection("shot.edit.usd") == variant
    assert main([shot, "-q"]) == 0
    assert selection("shot.edit.usd") == variant


def test_output(shot: str) -> None:
    Path("there").mkdir()
    assert main([shot, "-o", "there/mine.usd", "-q"]) == 0
    assert sorted(contents(Path("there"))) == ["mine.stage.usda", "mine.usd"]
    np.testing.assert_array_equal(poses("there/mine.stage.usda", "original"), poses(shot))


def test_anim(shot: str, capsys: Capture) -> None:
    assert main([shot, "--anim", SKETCH, "--anim", SKETCH, "--dry-run"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 2


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("nothing.usda",), 2, "nothing.usda"),
        (
            ("walk.usda",),
            3,
            "no animation to edit; expected an animation with MtexEditStackAPI; found /Humanoid/Sketch",
        ),
        (("shot.usda", "--anim", "/Nobody"), 3, "there is no animation /Nobody"),
        (("shot.usda", "--anim", MODEL), 3, f"there is no animation {MODEL}"),
        (("shot.usda", "--anim", "no path"), 3, "there is no animation no path"),
        (("shot.usda", "--anim", "/Takes/walk_slow"), 3, "/Takes/walk_slow has no stack of edits"),
        (
            ("shot.usda", "--select", "path_01"),
            2,
            f"{SKETCH} gets no variant 'path_01'; expected one of original, edited",
        ),
        (("shot.usda", "-o", "shot.usda"), 2, "shot.usda"),
        (("shot.usda", "-o", "walk.usda"), 2, "walk.usda"),
        (("shot.usda", "-o", "nowhere/x.usd"), 2, "nowhere"),
        (("shot.usda", "-o", "x.txt"), 2, "x.txt"),
    ],
)
def test_refusals(shot: str, capsys: Capture, arguments: tuple[str, ...], code: int, message: str) -> None:
    assert message in fails(capsys, *arguments, code=code)


def test_a_folder_that_cannot_be_written(shot: str, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    # Root may write anywhere, so the permissions themselves prove nothing where tests run as root.
    monkeypatch.setattr("os.access", lambda *_, **__: False)
    assert "is not writable" in fails(capsys, shot, code=2)


def test_a_hand_made_file_is_not_replaced(shot: str, capsys: Capture) -> None:
    Sdf.Layer.CreateNew("shot.edit.usd").Save()
    assert "shot.edit.usd" in fails(capsys, shot, code=2)


def test_bad_usage() -> None:
    with pytest.raises(SystemExit) as caught:
        main(["shot.usda", "--paths", "3"])
    assert caught.value.code == 2
    with pytest.raises(SystemExit) as caught:
        main([])
    assert caught.value.code == 2


# --- beside the other commands ---


def test_other_commands_layers_are_not_replaced(shot: str, capsys: Capture) -> None:
    assert texture([shot, "--paths", "2", "-q"]) == 0
    assert "shot.mtex.usd holds what another command made" in fails(capsys, shot, "-o", "shot.mtex.usd", code=2)
    assert main([shot, "-q"]) == 0
    before = contents(Path())
    assert texture([shot, "-o", "shot.edit.usd"]) == 2
    assert "shot.edit.usd holds what another command made" in capsys.readouterr().err
    assert contents(Path()) == before


@pytest.mark.parametrize("order", [("shot.edit.usd", "shot.mtex.usd"), ("shot.mtex.usd", "shot.edit.usd")])
def test_versions_of_two_commands_stack(shot: str, order: tuple[str, str]) -> None:
    """Both layers over one shot: one set with the versions of both, and every one of them plays as on its own."""
    assert texture([shot, "--paths", "2", "-q"]) == 0
    assert main([shot, "-q"]) == 0
    both = Sdf.Layer.CreateNew("both.usda")
    both.subLayerPaths = [*order, shot]
    both.timeCodesPerSecond = both.framesPerSecond = 24.0
    both.Save()
    alone = {"shot.mtex.stage.usda": ("original", "path_01", "path_02"), "shot.edit.stage.usda": ("edited", "slower")}
    stage = Usd.Stage.Open("both.usda")
    names = stage.GetPrimAtPath(MODEL).GetVariantSet("mtex").GetVariantNames()
    assert sorted(names) == ["edited", "original", "path_01", "path_02", "slower"]
    shown = []
    for root, variants in alone.items():
        for variant in variants:
            shown.append(poses("both.usda", variant))
            np.testing.assert_array_equal(shown[-1], poses(root, variant), err_msg=variant)
    assert min(np.abs(a - b).max() for i, a in enumerate(shown) for b in shown[:i]) > 0.001


def test_edits_of_a_textured_shot_are_of_the_sketch(shot: str) -> None:
    """Over the layer of the other command: what the animator made is edited, not the version that is selected."""
    assert main([shot, "-q"]) == 0
    expected = poses("shot.edit.stage.usda", "edited")
    assert texture([shot, "--paths", "2", "-q"]) == 0
    over = Sdf.Layer.CreateNew("over.usda")
    over.subLayerPaths = ["shot.mtex.usd", shot]
    over.timeCodesPerSecond = over.framesPerSecond = 24.0
    over.Save()
    assert main(["over.usda", "-q"]) == 0
    np.testing.assert_array_equal(poses("over.edit.stage.usda", "edited"), expected)


# --- after texturing ---

AFTER = """
    uniform token[] mtex:edits:after = ["slow", "calm"]
    uniform token mtex:edit:calm:op = "lowpass"
    uniform double[] mtex:edit:calm:frequencies = [4]
    uniform token mtex:edit:slow:op = "scaleTime"
    uniform double mtex:edit:slow:factor = 1.25
"""
DETECT = 'uniform token mtex:contacts = "detect"'


def test_edits_that_change_the_frames_are_refused_with_contacts(shot_folder: Path, capsys: Capture) -> None:
    shot = declare(shot_folder, AFTER, sketch=DETECT)
    before = contents(Path())
    assert texture([shot, "--paths", "2"]) == 2
    message = capsys.readouterr().err
    assert f"{SKETCH}: contacts cannot be held after mtex:edits:after" in message
    assert "slow (scaleTime), calm (lowpass). Set mtex:contacts to off" in message
    assert contents(Path()) == before


def test_contacts_are_held_after_edits_that_keep_the_frames(shot_folder: Path) -> None:
    shot = declare(shot_folder, AFTER.replace('"slow", ', ""), sketch=DETECT)
    (result,) = mtex_usd.process(shot, paths=2)
    (plain,) = mtex_usd.process("walk.usda", paths=2)
    assert [variant.fragments for variant in result.variants] == [variant.fragments for variant in plain.variants]
    stage = Usd.Stage.Open(str(result.stage))
    query = UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath(SKELETON)))
    order = [str(name) for name in query.GetJointOrder()]
    stage.GetPrimAtPath(MODEL).GetVariantSet("mtex").SetVariantSelection(result.variants[0].name)
    query = UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath(SKELETON)))
    contacts = result.variants[0].custom_data["contacts"]
    assert len(contacts) >= 20
    for contact in contacts:
        times = np.arange(contact["start"], contact["end"] + 1.0)
        joint = order.index(contact["joint"])
        matrices = [np.array(query.ComputeJointSkelTransforms(time)[joint]) for time in times]
        places = np.array([([*contact["offset"], 1.0] @ matrix)[:3] for matrix in matrices])
        assert np.linalg.norm(places - places.mean(axis=0), axis=1).max() < 0.05  # centimetres


def test_variants_have_the_frames_that_edits_leave(shot_folder: Path) -> None:
    (result,) = mtex_usd.process(declare(shot_folder, AFTER), paths=2)
    stage = Usd.Stage.Open(str(result.stage))
    assert stage.GetEndTimeCode() == 212.0
    assert max(stage.GetPrimAtPath(f"{SKETCH}_mtex").GetAttribute("rotations").GetTimeSamples()) == 212.0


# --- the sample ---


def test_the_sample(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    for name in ("humanoid.usda", "takes.usda", "edits.usda"):
        shutil.copy(SAMPLES / name, tmp_path)
    monkeypatch.chdir(tmp_path)
    assert main(["edits.usda"]) == 0
    captured = capsys.readouterr()
    for line in ("edited\t0 to 297", "endless\t0 to 480", "keyed\t0 to 239", "livelier\t0 to 239"):
        assert line in captured.out
    assert "note: /Humanoid/Walk: keyed: keys: " in captured.err
    assert variant_names("edits.edit.usd") == ["edited", "endless", "keyed", "livelier", "original"]
    stage = Usd.Stage.Open("edits.edit.stage.usda")
    assert len(stage.GetPrimAtPath("/Humanoid/Walk").GetAttribute("mtex:edits").Get()) == 5
