"""The written stages pass every validator that USD has, whichever variant is selected."""

import shutil
from pathlib import Path

import pytest
from pxr import Usd, UsdValidation

from mtex_usd.cli.usdmtex import main
from tests.cli.support import MODEL

SAMPLES = Path(__file__).resolve().parents[2] / "sample_stages"
SHOTS = ("walk", "walk_to_stop", "phrase")


def complaints(stage: Usd.Stage) -> list[str]:
    """Run all validators; gives what they report, warnings included."""
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert len(validators) >= 20
    found = UsdValidation.ValidationContext(validators).Validate(stage)
    return [f"{error.GetType()} {error.GetName()}: {error.GetMessage()}" for error in found]


@pytest.mark.parametrize("shot", SHOTS)
def test_the_thin_root_is_valid_with_every_variant(shot: str, tmp_path: Path) -> None:
    for file in SAMPLES.glob("*.usda"):
        shutil.copy(file, tmp_path)
    assert main([str(tmp_path / f"{shot}.usda"), "-q"]) == 0
    stage = Usd.Stage.Open(str(tmp_path / f"{shot}.mtex.stage.usda"))
    variants = stage.GetPrimAtPath(MODEL).GetVariantSet("mtex")
    names = variants.GetVariantNames()
    assert names[0] == "original"
    assert len(names) >= 3
    stage.SetEditTarget(stage.GetSessionLayer())
    for name in names:
        assert variants.SetVariantSelection(name)
        assert complaints(stage) == []


def test_the_validators_do_complain() -> None:
    stage = Usd.Stage.CreateInMemory()
    stage.DefinePrim("/Animation", "SkelAnimation")
    assert any("defaultPrim" in complaint or "Metadata" in complaint for complaint in complaints(stage))
