"""Accept writes what is shown into a layer that says so in another process."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd

import mtex_usd
from mtex_usd.usdview import window as windows
from tests.usdview.shots import CHAR, OTHER, shown, write_processed
from tests.usdview.usdview import Usdview

# Nothing of ours is imported: what another department's tool sees.
FRESH = """
import sys
import numpy as np
from pxr import Usd, UsdSkel
stage = Usd.Stage.Open(sys.argv[1])
for model in ("/World/Char", "/World/Other"):
    for name in stage.GetPrimAtPath(model).GetVariantSets().GetNames():
        print(model, name, stage.GetPrimAtPath(model).GetVariantSet(name).GetVariantSelection())
query = UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath("/World/Other/Rig/Skel")))
order = sorted(range(len(query.GetJointOrder())), key=list(query.GetJointOrder()).__getitem__)
times = (1.0, 17.0, 30.0, 49.0)
np.save(sys.argv[2], np.array([np.array(query.ComputeJointLocalTransforms(t))[order] for t in times]))
"""


def open_fresh(layer, folder):
    """Open a layer in a process of its own; give the selections, and what Other's Skeleton plays."""
    environment = {k: v for k, v in os.environ.items() if k not in {"PYTHONPATH", "PXR_PLUGINPATH_NAME"}}
    command = [sys.executable, "-c", FRESH, str(layer), str(folder / "poses.npy")]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return [line.split() for line in done.stdout.splitlines()], np.load(folder / "poses.npy")


def accept(usdview, layer, *paths, stacked=True):
    usdview.select(*paths)
    usdview.trigger("Accept Path...")
    window = windows.open_window("accept")
    window.field.setText(str(layer))
    window.stacked.setChecked(stacked)
    window._accept()
    return window


@pytest.fixture
def accepting(usdview):
    """Give a usdview in which Other shows its third path, and the others their first."""
    usdview.select(OTHER)
    usdview.trigger("Previous Path")
    return usdview


def test_a_fresh_process_has_the_selection_and_plays_it(accepting, tmp_path):
    accept(accepting, tmp_path / "accepted.usda", CHAR, OTHER)
    said, played = open_fresh(tmp_path / "accepted.usda", tmp_path)
    assert said == [[CHAR, "mtex", "path_01"], [CHAR, "mtex_Face", "path_01"], [OTHER, "mtex", "path_03"]]
    np.testing.assert_array_equal(played, shown(accepting.model.stage, f"{OTHER}/Rig/Skel"))
    assert accepting.last_message == f"Accepted into {tmp_path / 'accepted.usda'}"
    assert windows.open_window("accept") is None


def test_only_what_is_selected_is_accepted(accepting, tmp_path):
    accepting.select(CHAR)
    accepting.trigger("Next Path")
    accept(accepting, tmp_path / "accepted.usda", OTHER)
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "accepted.usda"))
    assert not layer.GetPrimAtPath(CHAR)
    assert dict(layer.GetPrimAtPath(OTHER).variantSelections.items()) == {"mtex": "path_03"}


def test_accepting_again_keeps_what_was_accepted_of_others(accepting, tmp_path):
    accept(accepting, tmp_path / "accepted.usda", OTHER)
    accepting.select(f"{CHAR}/Face")
    accepting.trigger("Next Path")
    accept(accepting, tmp_path / "accepted.usda", f"{CHAR}/Face")
    said, _ = open_fresh(tmp_path / "accepted.usda", tmp_path)
    assert said == [[CHAR, "mtex", "path_01"], [CHAR, "mtex_Face", "path_02"], [OTHER, "mtex", "path_03"]]


def test_unstacked_it_goes_into_a_layer_stack(accepting, tmp_path, processed):
    accept(accepting, tmp_path / "choice.usda", OTHER, stacked=False)
    assert list(Sdf.Layer.FindOrOpen(str(tmp_path / "choice.usda")).subLayerPaths) == []
    root = Sdf.Layer.CreateNew(str(tmp_path / "root.usda"))
    root.subLayerPaths[:] = ["./choice.usda", str(processed)]
    root.Save()
    said, _ = open_fresh(tmp_path / "root.usda", tmp_path)
    assert said[2] == [OTHER, "mtex", "path_03"]


def test_a_thin_root_takes_the_selection_and_keeps_the_rest(tmp_path, boxes):
    thin = write_processed(tmp_path)
    usdview = Usdview(Usd.Stage.Open(str(thin))).load()
    shot = (tmp_path / "shot.usda").read_bytes()
    usdview.select(OTHER)
    usdview.trigger("Next Path")
    accept(usdview, thin, OTHER)
    assert boxes == []
    said, _ = open_fresh(thin, tmp_path)
    assert said[2] == [OTHER, "mtex", "path_02"]
    assert list(Sdf.Layer.FindOrOpen(str(thin)).subLayerPaths) == ["./shot.mtex.usd", "./shot.usda"]
    assert (tmp_path / "shot.usda").read_bytes() == shot
    # What the command does with it afterwards: the user's choice stays.
    mtex_usd.process(thin)
    assert open_fresh(thin, tmp_path)[0][2] == [OTHER, "mtex", "path_02"]


def test_the_name_that_is_suggested_lies_beside_the_shot(usdview, processed):
    usdview.select(OTHER)
    usdview.trigger("Accept Path...")
    assert Path(windows.open_window("accept").field.text()) == processed.with_name("shot.accepted.usda")


@pytest.mark.parametrize("stem", ["shot", "foreign"])
def test_a_layer_of_somebody_else_is_left_alone(accepting, tmp_path, boxes, stem):
    target = tmp_path / f"{stem}.usda"
    target.write_text("#usda 1.0\n")
    accept_refused(accepting, target)
    assert boxes == [
        f"{target} exists and was not written by usdmtex; it is left alone. Choose another name for the output."
    ]
    assert target.read_text() == "#usda 1.0\n"


def accept_refused(usdview, target):
    usdview.select(OTHER)
    usdview.trigger("Accept Path...")
    window = windows.open_window("accept")
    window.field.setText(str(target))
    (ok,) = [b for b in window.dialog.findChildren(_button_class()) if b.text() == "&Accept"]
    ok.click()
    assert window.dialog.isVisible()


def _button_class():
    from PySide6 import QtWidgets

    return QtWidgets.QPushButton


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("", "no layer is named; expected a name such as shot.accepted.usda"),
        ("accepted.txt", "is no layer name; expected a name ending in .usd, .usdc, .usda"),
        ("nowhere/accepted.usda", "there is no folder"),
    ],
)
def test_bad_names_are_said_and_the_window_stays(accepting, tmp_path, boxes, name, message):
    accept_refused(accepting, tmp_path / name if name else "")
    (text,) = boxes
    assert message in text


def test_the_thin_root_of_another_shot_is_refused(accepting, tmp_path, boxes):
    other = write_processed(tmp_path)
    before = other.read_bytes()
    accept_refused(accepting, other)
    assert "is the thin root of another shot" in boxes[0]
    assert other.read_bytes() == before


def test_an_override_layer_is_refused(accepting, tmp_path, boxes):
    other = write_processed(tmp_path).with_name("shot.mtex.usd")
    accept_refused(accepting, other)
    assert "expected a layer of accepted paths to replace, or no file; found an override layer" in boxes[0]


def test_a_shot_may_be_accepted_into_any_of_the_formats(accepting, tmp_path):
    for suffix in (".usd", ".usdc"):
        accept(accepting, tmp_path / f"accepted{suffix}", OTHER)
        assert open_fresh(tmp_path / f"accepted{suffix}", tmp_path)[0][2] == [OTHER, "mtex", "path_03"]
