"""Writing layers whole, and never over somebody else's file."""

from pathlib import Path

import pytest
from pxr import Sdf

from mtex_usd import files
from mtex_usd.errors import InputError
from mtex_usd.usd.atomic import LayerKind, check_target, file_kind, is_ours, mark_layer, write_layer
from mtex_usd.usd.diagnostics import open_layer

KINDS: dict[LayerKind, str] = {
    "takes": "take library",
    "clip": "clip",
    "override": "override layer",
    "stage": "thin root",
}


def forbid(*_: object) -> None:
    raise PermissionError(13, "Permission denied")


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


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ('#usda 1.0\ndef "Shot" {}\n', "exists and was not written by usdmtex; it is left alone. Choose another name"),
        ("not a layer", r"exists and cannot be read, .* found .*shot\.usda> is not a valid usda layer\. Delete it if"),
        (
            "",
            "exists and cannot be read, so that it is left alone; .* found an empty file. Delete it if nobody needs it",
        ),
    ],
)
def test_never_overwrites_a_file_it_did_not_write(tmp_path: Path, content: str, reason: str) -> None:
    file_path = tmp_path / "shot.usda"
    file_path.write_text(content)
    with pytest.raises(InputError, match=reason):
        write_layer(make_layer(), file_path)
    assert file_path.read_text() == content


@pytest.mark.parametrize("there", KINDS)
@pytest.mark.parametrize("wanted", KINDS)
def test_only_a_layer_of_its_own_kind_is_replaced(tmp_path: Path, there: LayerKind, wanted: LayerKind) -> None:
    layer = make_layer()
    mark_layer(layer, there)
    write_layer(layer, tmp_path / "x.usd")
    assert file_kind(tmp_path / "x.usd") == there
    if there == wanted:
        check_target(tmp_path / "x.usd", wanted)
        return
    expected = f"expected an? {KINDS[wanted]} to replace, or no file; found an? {KINDS[there]}. Choose another name"
    with pytest.raises(InputError, match=rf"x\.usd exists and is left alone; {expected}"):
        check_target(tmp_path / "x.usd", wanted)
    mark_layer(layer, wanted)
    with pytest.raises(InputError, match=expected):
        write_layer(layer, tmp_path / "x.usd")


@pytest.mark.parametrize("size", [0, 7, 8, 200])
def test_its_own_file_cut_short_says_so(tmp_path: Path, size: int) -> None:
    """Nobody can tell any more whose it was."""
    file_path = tmp_path / "x.usd"
    write_layer(make_layer(), file_path)
    file_path.write_bytes(file_path.read_bytes()[:size])
    reason = "an empty file" if size == 0 else "a crate file that is damaged" if size > 7 else "something that USD does"
    with pytest.raises(InputError, match=rf"x\.usd exists and cannot be read.*found {reason}.*Delete it"):
        check_target(file_path, "takes")
    assert len(file_path.read_bytes()) == size


def test_a_file_that_may_not_be_read_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever runs the tests may read everything, perhaps."""
    write_layer(make_layer(), tmp_path / "x.usd")
    monkeypatch.setattr(Path, "open", forbid)
    with pytest.raises(InputError, match=r"x\.usd exists and cannot be read.*found permission denied"):
        check_target(tmp_path / "x.usd", "takes")
    with pytest.raises(InputError, match=r"cannot open .*x\.usd; expected a USD file; found permission denied"):
        open_layer(tmp_path / "x.usd")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('#usda 1.0\n(\n    doc = "cut', "line 3: parse error at '"),
        ('#usda 1.0\ndef "A"\n{\n    double x = "bla"\n}\n', "line 4: Error parsing simple value: Failed to parse"),
        ('#usda 1.0\ndef "A" {', "line 2: Expected }"),
    ],
)
def test_what_does_not_parse_is_told_by_line_and_reason_alone(tmp_path: Path, text: str, reason: str) -> None:
    (tmp_path / "x.usda").write_text(text)
    with pytest.raises(InputError, match=rf"cannot read [^ ]*x\.usda: {reason}") as caught:
        open_layer(tmp_path / "x.usda")
    assert not any(word in str(caught.value) for word in ("pxr", "::", ".cpp", "Failed to open", ";"))


def test_refuses_targets_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"x\.usdz is no layer name; expected a name ending in \.usd, "):
        check_target(tmp_path / "x.usdz", "takes")
    with pytest.raises(InputError, match="there is no folder"):
        check_target(tmp_path / "nowhere" / "x.usd", "takes")
    (tmp_path / "folder.usd").mkdir()
    with pytest.raises(InputError, match="it is a folder"):
        check_target(tmp_path / "folder.usd", "takes")


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file_path = tmp_path / "takes.usd"
    write_layer(make_layer(), file_path)
    before = file_path.read_bytes()

    def fail(_: Path) -> None:
        raise OSError("No space left on device")

    monkeypatch.setattr(files, "_sync", fail)
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
