"""What all tests share: USD with our schemas, the real data, and hypothesis settings."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

# Before any test opens a stage, or the schemas would come too late for the whole process.
import mtex_usd.usd  # noqa: F401

PROJECT = Path(__file__).resolve().parent.parent

settings.register_profile("local", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "local")


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """Give the folder of real motion capture, which is not part of the repository."""
    folder = Path(os.environ.get("MTEX_TEST_DATA", PROJECT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no real data in {folder}; set MTEX_TEST_DATA to the folder that has it")
    return folder.resolve()
