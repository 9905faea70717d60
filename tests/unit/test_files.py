"""Files are written whole, where they are asked for, over nothing but our own."""

import os
from pathlib import Path

import pytest

from mtex_usd import files
from mtex_usd.errors import InputError
from mtex_usd.files import check_distinct, check_ours, check_place, replace_file


def says_ours(file_path: Path) -> bool:
    return file_path.read_bytes().startswith(b"ours")


@pytest.mark.parametrize(("mask", "mode"), [(0o022, 0o644), (0o027, 0o640), (0o002, 0o664)])
def test_permissions_are_those_of_any_new_file(tmp_path: Path, mask: int, mode: int) -> None:
    before = os.umask(mask)
    try:
        replace_file(tmp_path / "a.txt", b"one")
        replace_file(tmp_path / "a.txt", b"two")
    finally:
        os.umask(before)
    assert (tmp_path / "a.txt").read_bytes() == b"two"
    assert (tmp_path / "a.txt").stat().st_mode & 0o777 == mode
    assert [file.name for file in tmp_path.iterdir()] == ["a.txt"]


def test_links_are_followed(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    link = tmp_path / "a.txt"
    link.symlink_to(tmp_path / "real" / "b.txt")
    check_place(link, what="table")
    check_ours(link, what="table", is_ours=says_ours)
    replace_file(link, b"ours")
    assert link.is_symlink()
    assert (tmp_path / "real" / "b.txt").read_bytes() == b"ours"
    link.unlink()
    link.symlink_to(tmp_path / "none" / "b.txt")
    with pytest.raises(InputError, match=r"a\.txt: there is no folder .*none\. Make it first"):
        check_place(link, what="table")


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: Path) -> None:
        raise OSError(28, "No space left on device")

    replace_file(tmp_path / "a.txt", b"old")
    monkeypatch.setattr(files, "_sync", fail)
    with pytest.raises(InputError, match=r"cannot write .*a\.txt: No space left on device"):
        replace_file(tmp_path / "a.txt", b"new")
    assert (tmp_path / "a.txt").read_bytes() == b"old"
    assert [file.name for file in tmp_path.iterdir()] == ["a.txt"]


def test_places_that_will_not_do(tmp_path: Path) -> None:
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(InputError, match=r"a\.txt is no picture name; expected a name ending in \.png, \.jpg"):
        check_place(tmp_path / "a.txt", what="picture", endings=(".png", ".jpg"))
    with pytest.raises(InputError, match=r"folder\.png: it is a folder; expected a file name"):
        check_place(tmp_path / "folder.png", what="picture", endings=(".png",))
    check_place(tmp_path / "A.PNG", what="picture", endings=(".png",))
    check_place(tmp_path / "any", what="table")


def test_a_folder_that_may_not_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever runs the tests may write everywhere, perhaps."""
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(InputError, match=rf"cannot write .*a\.txt: folder {tmp_path} is not writable"):
        check_place(tmp_path / "a.txt", what="table")


def forbid(_: Path) -> bool:
    raise PermissionError(13, "Permission denied")


def test_what_is_not_known_to_be_ours_is_left_alone(tmp_path: Path) -> None:
    file_path, loop = tmp_path / "a.txt", tmp_path / "loop"
    check_ours(file_path, what="table", is_ours=forbid)
    file_path.write_bytes(b"ours")
    loop.symlink_to(loop)
    check_ours(file_path, what="table", is_ours=says_ours)
    message = "exists and was not written by usdmtex; it is left alone. Choose another name for the table"
    with pytest.raises(InputError, match=message):
        check_ours(file_path, what="table", is_ours=forbid)
    with pytest.raises(InputError, match=message):
        check_ours(loop, what="table", is_ours=says_ours)
    file_path.write_bytes(b"theirs")
    with pytest.raises(InputError, match=message):
        check_ours(file_path, what="table", is_ours=says_ours)


def test_one_file_is_one_thing_by_whatever_name(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "a.txt")
    others = [tmp_path / "b.txt", tmp_path / "a.txt"]
    check_distinct(tmp_path / "c.txt", others, what="table")
    for name in ("a.txt", "x/../a.txt", "link"):
        with pytest.raises(InputError, match=r"is another file of this run\. Choose another name for the table"):
            check_distinct(tmp_path / name, others, what="table")
