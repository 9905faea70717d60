"""Looking at what a run of ``usdmtex`` did."""

from pathlib import Path

import pytest
from pxr import Sdf, Usd

from mtex_usd.cli.usdmtex import main
from mtex_usd.usd.custom_data import from_metadata

__all__ = ["MODEL", "SKETCH", "Capture", "contents", "failing", "read_custom_data", "selection", "variant_names"]

SKETCH, MODEL = "/Humanoid/Sketch", "/Humanoid"

Capture = pytest.CaptureFixture[str]


def contents(folder: Path) -> dict[str, bytes]:
    """Give the bytes of every file in a folder."""
    return {file.name: file.read_bytes() for file in folder.iterdir() if file.is_file()}


def selection(file_path: str) -> str:
    """Give the variant an override layer selects."""
    layer = Sdf.Layer.OpenAsAnonymous(file_path)
    return layer.GetPrimAtPath(MODEL).variantSelections["mtex"]


def variant_names(file_path: str, model: str = MODEL) -> list[str]:
    """Give the variants in an override layer, sorted."""
    layer = Sdf.Layer.OpenAsAnonymous(file_path)
    return sorted(layer.GetPrimAtPath(model).variantSets["mtex"].variants.keys())


def read_custom_data(thin_root: str, variant: str) -> object:
    """Read what a variant carries, through the composed stage."""
    stage = Usd.Stage.Open(thin_root)
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        assert stage.GetPrimAtPath(MODEL).GetVariantSet("mtex").SetVariantSelection(variant)
    return from_metadata(stage.GetPrimAtPath(f"{SKETCH}_mtex").GetCustomDataByKey("mtex"))


def failing(capsys: Capture, folder: Path, *arguments: str, code: int) -> str:
    """Run what must fail: the exit code is right, nothing is written or printed; gives the message."""
    before = contents(folder)
    assert main(arguments) == code
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("usdmtex: error: ")
    assert "Traceback" not in captured.err
    assert contents(folder) == before
    return captured.err
