"""The committed schema files are what schemas/schema.usda gives."""

import json
from pathlib import Path

import pytest

pytest.importorskip("jinja2", reason="usdGenSchema needs jinja2")

from schemas.generate import FOLDER, find_drift, finish_plug_info, generate_files, main


@pytest.fixture(scope="module")
def generated() -> dict[str, str]:
    return generate_files(FOLDER / "schema.usda")


def test_committed_files_have_not_drifted(generated: dict[str, str]) -> None:
    assert find_drift(generated, FOLDER) == []


def test_check_passes() -> None:
    assert main(["--check"]) == 0


def test_generation_is_stable(generated: dict[str, str]) -> None:
    assert generate_files(FOLDER / "schema.usda") == generated


def test_drift_is_found(generated: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "plugInfo.json").write_text(generated["plugInfo.json"], encoding="utf-8")
    (tmp_path / "generatedSchema.usda").write_text("edited", encoding="utf-8")
    assert find_drift(generated, tmp_path) == ["generatedSchema.usda"]
    (tmp_path / "plugInfo.json").unlink()
    assert find_drift(generated, tmp_path) == ["generatedSchema.usda", "plugInfo.json"]


def test_edited_source_gives_other_files(generated: dict[str, str], tmp_path: Path) -> None:
    source = tmp_path / "schema.usda"
    text = (FOLDER / "schema.usda").read_text(encoding="utf-8")
    source.write_text(text.replace("mtex:paths = 5", "mtex:paths = 6"), encoding="utf-8")
    assert generate_files(source)["generatedSchema.usda"] != generated["generatedSchema.usda"]


def test_broken_source_is_reported(tmp_path: Path) -> None:
    source = tmp_path / "schema.usda"
    source.write_text("#usda 1.0\n", encoding="utf-8")
    with pytest.raises(RuntimeError, match="usdGenSchema failed"):
        generate_files(source)


def test_placeholders_are_filled_in() -> None:
    text = '# comment\n{"Plugins": [{"Name": "x", "Root": "@PLUG_INFO_ROOT@"}]}'
    plugin = json.loads(finish_plug_info(text))["Plugins"][0]
    assert plugin == {"Name": "x", "LibraryPath": "", "ResourcePath": ".", "Root": "."}
