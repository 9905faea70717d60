"""What ``usdmtex`` does not do: the reason, the exit code, and nothing written."""

from pathlib import Path

import pytest
from pxr import Sdf, Usd, UsdSkel

from mtex_usd import api
from mtex_usd.cli.usdmtex import main
from mtex_usd.cli.usdmtex_import import main as import_main
from mtex_usd.errors import InputError
from tests.cli.support import MODEL, SKETCH, Capture, contents, failing


@pytest.mark.parametrize("name", ["walk.mtex.usd", "walk.mtex.stage.usda"])
def test_files_of_somebody_else_are_left_alone(shot_folder: Path, capsys: Capture, name: str) -> None:
    Usd.Stage.CreateNew(name).Save()
    error = failing(capsys, shot_folder, "walk.usda", code=2)
    assert f"{name} exists and was not written by usdmtex; it is left alone. Choose another name" in error


def test_the_shot_itself_is_no_output(shot_folder: Path, capsys: Capture) -> None:
    error = failing(capsys, shot_folder, "walk.usda", "-o", "walk.usda", code=2)
    assert "walk.usda exists and was not written by usdmtex" in error


@pytest.mark.parametrize(
    ("out", "reason"),
    [
        ("walk.txt", "walk.txt is no layer name; expected a name ending in .usd, .usdc, .usda"),
        ("none/walk.usd", "cannot write none/walk.usd: there is no folder"),
        ("folder.usd", "cannot write folder.usd: it is a folder"),
    ],
)
def test_no_place_to_write(shot_folder: Path, capsys: Capture, out: str, reason: str) -> None:
    (shot_folder / "folder.usd").mkdir()
    before = sorted(shot_folder.iterdir())
    assert main(["walk.usda", "-o", out]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith(f"usdmtex: error: {reason}")
    assert sorted(shot_folder.iterdir()) == before


def test_a_folder_that_cannot_be_written(shot_folder: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    # Root may write anywhere, so the permissions themselves prove nothing where tests run as root.
    monkeypatch.setattr("os.access", lambda *_, **__: False)
    error = failing(capsys, shot_folder, "walk.usda", code=2)
    assert "cannot write walk.mtex.usd: folder" in error
    assert "is not writable" in error


def test_a_file_system_that_refuses(shot_folder: Path, capsys: Capture) -> None:
    if not Path("/proc/self").is_dir():
        pytest.skip("no /proc, which lets nobody make files")
    error = failing(capsys, shot_folder, "walk.usda", "-o", "/proc/walk.usd", code=2)
    assert "cannot write /proc/walk.usd: " in error
    assert ".cpp" not in error


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("gone.usda", None, "cannot open gone.usda; expected a USD file; found no such file"),
        (".", None, "cannot open .; expected a USD file; found a folder"),
        ("text.usda", b"hello", "cannot read text.usda: "),
        ("text.usd", b"hello", "cannot read text.usd"),
        ("empty.usda", b"", "cannot read empty.usda: "),
        ("broken.usda", b'#usda 1.0\ndef "A" {', "cannot read broken.usda: line 2: Expected }"),
        ("picture.png", b"hello", "cannot read picture.png"),
    ],
)
def test_not_a_stage(shot_folder: Path, capsys: Capture, name: str, content: bytes | None, reason: str) -> None:
    if content is not None:
        (shot_folder / name).write_bytes(content)
    error = failing(capsys, shot_folder, name, code=2)
    assert error.startswith(f"usdmtex: error: {reason}")
    assert ".cpp" not in error


def test_a_crate_cut_short(shot_folder: Path, capsys: Capture) -> None:
    Sdf.Layer.FindOrOpen("walk.usda").Export("whole.usdc")
    Path("cut.usdc").write_bytes(Path("whole.usdc").read_bytes()[:4000])
    assert "cannot read cut.usdc: " in failing(capsys, shot_folder, "cut.usdc", code=2)


def test_an_override_layer_is_no_shot(shot_folder: Path, capsys: Capture) -> None:
    assert main(["walk.usda", "-q"]) == 0
    error = failing(capsys, shot_folder, "walk.mtex.usd", code=2)
    assert "is an override layer, which holds no animation of its own. Give the shot or the thin root" in error


def test_joints_that_repeat_name_their_skeleton(shot_folder: Path, capsys: Capture) -> None:
    stage = Usd.Stage.Open("humanoid.usda")
    joints = UsdSkel.Skeleton(stage.GetPrimAtPath(f"{MODEL}/Skeleton")).GetJointsAttr()
    joints.Set([*joints.Get()[:-1], joints.Get()[0]])
    stage.Save()
    error = failing(capsys, shot_folder, "walk.usda", code=2)
    assert f"{MODEL}/Skeleton: joint paths are not unique; found Hips" in error


@pytest.mark.parametrize("kind", ["takes", "clip"])
def test_other_layers_of_ours_are_no_output(shot_folder: Path, capsys: Capture, kind: str) -> None:
    if kind == "takes":
        api.import_takes("takes.usda", out="mine.usd")
    else:
        api.write_clip(api.read_clip("walk.usda", SKETCH), "mine.usd", "/walk")
    error = failing(capsys, shot_folder, "walk.usda", "-o", "mine.usd", code=2)
    assert "mine.usd exists and is left alone; expected an override layer to replace" in error


@pytest.mark.parametrize("name", ["walk.mtex.usd", "walk.mtex.stage.usda"])
def test_outputs_are_no_library_and_no_clip(shot_folder: Path, capsys: Capture, name: str) -> None:
    assert main(["walk.usda", "-q"]) == 0
    before = contents(shot_folder)
    assert import_main(["takes.usda", "-o", name]) == 2
    assert f"{name} exists and is left alone; expected a take library" in capsys.readouterr().err
    assert import_main(["takes.usda", "-o", name, "--replace"]) == 2
    with pytest.raises(InputError, match=f"{name} exists and is left alone; expected a clip"):
        api.write_clip(api.read_clip("walk.usda", SKETCH), name, "/walk")
    assert contents(shot_folder) == before


def test_a_thin_root_whose_shot_is_gone(shot_folder: Path, capsys: Capture) -> None:
    assert main(["walk.usda", "-q"]) == 0
    Path("walk.usda").unlink()
    error = failing(capsys, shot_folder, "walk.mtex.stage.usda", code=2)
    assert "walk.usda; expected a USD file; found no such file" in error


@pytest.mark.parametrize("name", ["humanoid.usda", "takes.usda"])
def test_a_stage_without_a_recipe(shot_folder: Path, capsys: Capture, name: str) -> None:
    error = failing(capsys, shot_folder, name, code=3)
    assert f"{name} has no recipe; expected a SkelAnimation with MtexSketchAPI applied" in error


@pytest.mark.parametrize("role", ["match", "texture", "synthesize"])
def test_an_unknown_joint_lists_those_there_are(shot_folder: Path, capsys: Capture, role: str) -> None:
    head, tail = (shot_folder / "walk.usda").read_text().split(f"mtex:{role} = [", 1)
    (shot_folder / "walk.usda").write_text(f'{head}mtex:{role} = ["LeftWing", {tail}')
    error = failing(capsys, shot_folder, "walk.usda", code=2)
    assert "'LeftWing'" in error
    assert "Hips, LeftUpLeg, LeftLeg" in error


def test_takes_that_composition_dropped(shot_folder: Path, capsys: Capture) -> None:
    (shot_folder / "shot.usda").write_text(
        '#usda 1.0\n( defaultPrim = "A" )\ndef "A" ( references = @./walk.usda@ ) {}\n'
    )
    error = failing(capsys, shot_folder, "shot.usda", code=3)
    assert "/Takes" in error
    assert "walk.usda" in error


def test_takes_that_cannot_be_read(shot_folder: Path, capsys: Capture) -> None:
    (shot_folder / "takes.usda").write_text("not a stage")
    error = failing(capsys, shot_folder, "walk.usda", code=3)
    assert "/Takes" in error


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ([], "the following arguments are required: STAGE"),
        (["walk.usda", "other.usda"], "unrecognized arguments: other.usda"),
        (["walk.usda", "--nonsense"], "unrecognized arguments: --nonsense"),
        (["walk.usda", "-q", "-v"], "not allowed with argument"),
        (["walk.usda", "--json"], "argument --json: expected one argument"),
    ],
)
def test_bad_usage(shot_folder: Path, capsys: Capture, arguments: list[str], reason: str) -> None:
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2
    assert reason in capsys.readouterr().err


def test_a_bug_says_so(shot_folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    def fail(*_: object, **__: object) -> None:
        raise ZeroDivisionError("oh")

    monkeypatch.setattr(api, "finish_job", fail)
    before = contents(shot_folder)
    assert main(["walk.usda"]) == 70
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("usdmtex: error: ZeroDivisionError: oh\nTraceback")
    assert "this is a bug; report it" in captured.err.splitlines()[-1]
    assert contents(shot_folder) == before
