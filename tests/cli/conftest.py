"""A shot to run the commands on."""

import shutil
from pathlib import Path

import pytest

SAMPLES = Path(__file__).resolve().parents[2] / "sample_stages"


@pytest.fixture
def shot_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Give a working folder with ``walk.usda`` and what it references, and go there."""
    for name in ("humanoid.usda", "takes.usda", "walk.usda"):
        shutil.copy(SAMPLES / name, tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path
