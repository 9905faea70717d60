"""Writing layers whole, and never over somebody else's file."""

from pathlib import Path

import pytest
from pxr import Sdf

from mtex_usd.errors import InputError
from mtex_usd.usd import atomic
from mtex_usd.usd.atomic import check_target, is_ours, mark_layer, write_layer


def make_layer(prim_path: str = "/World") -> Sdf.Layer:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    spec = Sdf.CreatePrimInLayer(layer, prim_path)
    attribute = Sdf.AttributeSpec(spec, "when", Sdf.ValueTypeNames.TimeCode, Sdf.VariabilityUniform)
    attribute.default = Sdf.TimeCode(3.0)
    layer.customLayerData = {"studio": "kept"}
    mark_layer(layer, "takes")
    return layer


@pytest.mark.parametrize(("name", "head"), [("a.usd", b"PXR-USDC"), ("a.usdc", b"PXR-USDC"), ("a.usda", b"#usda 1.0")])
def test_writes_the_format_of_the_ending_and_the_same_bytes_again(
    tmp_path: Path, name: str, head: bytes, capfd: pytest.CaptureFixture[str]
) -> None:
    file_path = tmp_path / name
    write_layer(make_layer(), file_path)
    first = file_path.read_bytes()
    assert first.startswith(head)
    write_layer(make_layer(), file_path)
    assert file_path.read_bytes() == first
    assert list(tmp_path.iterdir()) == [file_path]
    assert Sdf.Layer.OpenAsAnonymous(str(file_path)).customLayerData["studio"] == "kept"
    assert capfd.readouterr() == ("", "")


def test_knows_its_own_files(tmp_path: Path) -> None:
    write_layer(make_layer(), tmp_path / "ours.usd")
    Sdf.Layer.CreateNew(str(tmp_path / "theirs.usda")).Save()
    (tmp_path / "junk.usda").write_text("not a layer")
    assert is_ours(tmp_path / "ours.usd")
    assert not any(is_ours(tmp_path / name) for name in ("theirs.usda", "junk.usda", "nowhere.usd", "."))


@pytest.mark.parametrize("content", ['#usda 1.0\ndef "Shot" {}\n', "not a layer", ""])
def test_never_overwrites_a_file_it_did_not_write(tmp_path: Path, content: str) -> None:
    file_path = tmp_path / "shot.usda"
    file_path.write_text(content)
    with pytest.raises(InputError, match="exists and was not written by usdmtex"):
        write_layer(make_layer(), file_path)
    assert file_path.read_text() == content


def test_refuses_targets_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"x\.usdz is no layer name; expected a name ending in \.usd, "):
        check_target(tmp_path / "x.usdz")
    with pytest.raises(InputError, match="there is no folder"):
        check_target(tmp_path / "nowhere" / "x.usd")
    (tmp_path / "folder.usd").mkdir()
    with pytest.raises(InputError, match="it is a folder"):
        check_target(tmp_path / "folder.usd")


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file_path = tmp_path / "takes.usd"
    write_layer(make_layer(), file_path)
    before = file_path.read_bytes()

    def fail(_: Path) -> None:
        raise OSError("No space left on device")

    monkeypatch.setattr(atomic, "_sync", fail)
    with pytest.raises(InputError, match=r"cannot write .*takes\.usd: No space left on device"):
        write_layer(make_layer("/Other"), file_path)
    assert file_path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [file_path]


def test_writes_through_a_link(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    link = tmp_path / "takes.usd"
    link.symlink_to(tmp_path / "real" / "takes.usd")
    write_layer(make_layer(), link)
    assert link.is_symlink()
    assert is_ours(tmp_path / "real" / "takes.usd")


def test_a_layer_open_in_this_process_is_reloaded_unless_edited(tmp_path: Path) -> None:
    file_path = tmp_path / "takes.usd"
    write_layer(make_layer("/Old"), file_path)
    held = Sdf.Layer.FindOrOpen(str(file_path))
    write_layer(make_layer("/New"), file_path)
    assert [spec.name for spec in held.rootPrims] == ["New"]
    Sdf.CreatePrimInLayer(held, "/Edit")
    with pytest.raises(InputError, match="has unsaved edits in this process"):
        write_layer(make_layer(), file_path)
