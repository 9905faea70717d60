"""The import benchmark measures what it says; the times are for ``python -m tests.benchmarks.import_speed``."""

from pathlib import Path

import numpy as np
import pytest

import mtex_usd
from mtex_usd.formats.bvh import read_bvh
from tests.benchmarks import import_speed
from tests.benchmarks.import_speed import compare_import, parse_bare, write_files


def test_the_files_are_as_large_as_agreed(tmp_path: Path) -> None:
    assert (import_speed.FILES, import_speed.FRAMES) == (100, 1000)
    file_paths = write_files(tmp_path, count=2, frames=7)
    for file_path in file_paths:
        recording = read_bvh(file_path)
        assert recording.rotations.shape == (7, 31, 4)
        assert recording.rate == 120.0
        motion = file_path.read_text().rpartition("Frame Time: .0083333")[2]
        assert len(motion.split()) == 7 * 96
    assert len({file_path.read_text() for file_path in file_paths}) == 2


def test_the_yardstick_reads_every_number(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file_paths = write_files(tmp_path, count=2, frames=3)
    counts = []
    array = np.array
    monkeypatch.setattr(import_speed.np, "array", lambda words, kind: counts.append(array(words, kind).shape))
    parse_bare(file_paths)
    assert counts == [(3 * 96,)] * 2


def test_what_is_measured_is_a_written_library(tmp_path: Path) -> None:
    found = compare_import(tmp_path, count=2, frames=5, runs=1)
    assert list(found) == ["reading the files", "reading, filling a library", "import_takes to a written library"]
    assert [entry.frame_count for entry in mtex_usd.list_takes(tmp_path / "takes.usd")] == [5, 5]
    assert all(comparison.ratio > 0.0 for comparison in found.values())
