"""Formats told by content, and the files behind folders and patterns."""

import os
from pathlib import Path

import pytest

from mtex_usd.formats.detect import detect_format, find_sources
from mtex_usd.formats.recording import FormatError


@pytest.mark.parametrize(
    ("content", "kind"),
    [
        (b"HIERARCHY\nROOT Hips", "bvh"),
        (b"\xef\xbb\xbf\r\n hierarchy\r\nROOT", "bvh"),
        (b"# comment\n\n:version 1.10\n", "asf"),
        (b":UNITS\n", "asf"),
        (b"#!OML:ASF x.asf\n:FULLY-SPECIFIED\n", "amc"),
        (b"# only comments\r1\rroot 0 0 0", "amc"),
        (b"glTF\2\0\0\0", "gltf"),
        (b' \n{"asset": {}}', "gltf"),
        (b"#usda 1.0\n", "usd"),
        (b"PXR-USDC\0", "usd"),
        (b"PK\3\4", "usd"),
    ],
)
def test_the_name_does_not_matter(tmp_path: Path, content: bytes, kind: str) -> None:
    (tmp_path / "take.txt").write_bytes(content)
    assert detect_format(tmp_path / "take.txt") == kind


@pytest.mark.parametrize("content", [b"hello\n", b"1 2 3\n", b"# nothing else\n", b"HIER\0ARCHY", b":unknown\n"])
def test_anything_else_is_no_motion_file(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "take.bvh").write_bytes(content)
    with pytest.raises(FormatError, match=r"take\.bvh: is no motion file: expected BVH, ASF/AMC, glTF or USD"):
        detect_format(tmp_path / "take.bvh")


def test_files_that_are_not_there_or_empty(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"gone: cannot be read: No such file"):
        detect_format(tmp_path / "gone")
    (tmp_path / "empty.bvh").write_text(" \n")
    with pytest.raises(FormatError, match=r"empty\.bvh:1: the file is empty"):
        detect_format(tmp_path / "empty.bvh")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Give a working folder with motion, other files, and a hidden folder."""
    for name in ("b/two.bvh", "b/one.txt", "b/c/three.BVH", ".hidden/four.bvh", "b/.five.bvh"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("HIERARCHY\n")
    (tmp_path / "b" / "readme.md").write_text("hello\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def list_names(*names: str, leave_out: Path | None = None) -> list[str]:
    sources, errors = find_sources([Path(name) for name in names], leave_out=leave_out)
    assert not errors
    return [f"{source.file_path}{'*' if source.found else ''}".replace(os.sep, "/") for source in sources]


def test_folders_are_searched_for_known_content(folder: Path) -> None:
    assert list_names("b") == ["b/c/three.BVH*", "b/one.txt*", "b/two.bvh*"]
    assert list_names("b", leave_out=Path("b/two.bvh")) == ["b/c/three.BVH*", "b/one.txt*"]


def test_patterns_are_expanded_and_files_come_once(folder: Path) -> None:
    assert list_names("b/*.bvh") == ["b/two.bvh*"]
    assert list_names("b/**/*.BVH") == ["b/c/three.BVH*"]
    assert list_names("b/two.bvh", "./b", "b/*.txt") == ["b/two.bvh", "b/c/three.BVH*", "b/one.txt*"]
    assert list_names("*/c") == ["b/c/three.BVH*"]


def test_a_file_named_like_a_pattern_is_a_file(folder: Path) -> None:
    (folder / "take[1].bvh").write_text("HIERARCHY\n")
    assert list_names("take[1].bvh") == ["take[1].bvh"]


def test_a_named_file_that_is_not_there_is_left_to_the_reader(folder: Path) -> None:
    assert list_names("gone.bvh") == ["gone.bvh"]


def test_what_leads_to_nothing_is_reported(folder: Path) -> None:
    (folder / "empty").mkdir()
    _, errors = find_sources([Path("empty"), Path("x*.bvh")])
    assert [error.reason for error in errors] == [
        "the folder holds no BVH, ASF/AMC, glTF or USD file",
        "the pattern leads to no BVH, ASF/AMC, glTF or USD file",
    ]
