"""glTF: every way of storing a curve against the slow reader, and every way a file can be wrong."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mtex_usd.formats.gltf import read_gltf
from mtex_usd.formats.recording import FormatError, NoMotionError, Recording
from mtex_usd.motion import quaternion
from tests.gltf_files import FLOAT, Builder, build_arm, unit
from tests.oracle import gltf as oracle


def check_against_oracle(file_path: Path, recording: Recording, nodes: list[int], *, animation: int = 0) -> None:
    """Compare the joints' places and turns in the world at every frame."""
    document = oracle.Document(file_path)
    keys = [document.elements(s["input"]) for s in document.json["animations"][animation]["samplers"]]
    start = min(times[0][0] for times in keys)
    for frame in range(recording.frame_count):
        world: list[tuple[np.ndarray, np.ndarray]] = []
        for j, (node, parent) in enumerate(zip(nodes, recording.parents, strict=True)):
            rotation, place = recording.rotations[frame, j], recording.translations[frame, j]
            if parent >= 0:
                place = world[parent][0] + quaternion.rotate(world[parent][1], place)
                rotation = quaternion.multiply(world[parent][1], rotation)
            world.append((place, rotation))
            expected = document.world_matrix(animation, node, start + frame / recording.rate)
            np.testing.assert_allclose(place, expected[:3, 3], atol=2e-6 * max(1.0, np.abs(expected[:3, 3]).max()))
            axes = expected[:3, :3] / np.linalg.norm(expected[:3, :3], axis=0)
            turned = np.stack([quaternion.rotate(rotation, axis) for axis in np.eye(3)], axis=1)
            np.testing.assert_allclose(turned, axes, atol=2e-6)


@pytest.mark.parametrize("name", ["take.gltf", "take.glb"])
def test_every_interpolation_and_what_is_no_joint(tmp_path: Path, name: str) -> None:
    file_path = build_arm().write(tmp_path, name)
    (recording,) = read_gltf(file_path, rate=50.0)
    assert (recording.names, recording.parents) == (("Upper", "Lower", "Tip"), (-1, 0, 1))
    assert (recording.frame_count, recording.rate, recording.clip) == (51, 50.0, "")
    assert recording.scales is None
    check_against_oracle(file_path, recording, [1, 3, 4])


def test_the_rest_is_that_of_the_nodes_in_metres(tmp_path: Path) -> None:
    (recording,) = read_gltf(build_arm().write(tmp_path))
    assert (recording.meters_per_unit, recording.up_axis) == (1.0, "Y")
    world = recording.bind_transforms
    np.testing.assert_allclose(world[0, 3, :3], [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(world[:, :3, :3]), 1.0, atol=1e-9)
    np.testing.assert_allclose(recording.offsets[2], [0.07, 0, 0], atol=1e-12)


def test_a_buffer_beside_the_file(tmp_path: Path) -> None:
    builder = build_arm()
    (tmp_path / "the data.bin").write_bytes(builder.data)
    (tmp_path / "take.gltf").write_bytes(builder.to_json(uri="the%20data.bin"))
    (recording,) = read_gltf(tmp_path / "take.gltf")
    assert recording.companions == (tmp_path / "the data.bin",)
    (plain,) = read_gltf(build_arm().write(tmp_path, "other.gltf"))
    np.testing.assert_array_equal(recording.rotations, plain.rotations)


@pytest.mark.parametrize(("component", "top"), [(5120, 127), (5121, 255), (5122, 32767), (5123, 65535)])
def test_rotations_as_normalised_integers(tmp_path: Path, component: int, top: int) -> None:
    turns = np.array([unit(0, 0, 0, 1), unit(1, 2, 3, 4)])
    builder = Builder([{}], joints=[[0]])
    values = builder.accessor(np.round(turns * top), component, normalized=True)
    builder.animate((0, "rotation", builder.times([0.0, 0.5]), values, "LINEAR"))
    file_path = builder.write(tmp_path)
    (recording,) = read_gltf(file_path)
    check_against_oracle(file_path, recording, [0])
    np.testing.assert_allclose(recording.rotations[-1, 0], turns[1][[3, 0, 1, 2]], atol=2.0 / top)


@pytest.mark.parametrize("dense", [True, False])
def test_sparse_values_replace_some(tmp_path: Path, dense: bool) -> None:
    builder = Builder([{}], joints=[[0]])
    values = builder.accessor(np.ones((3, 3)))
    accessor = builder.document["accessors"][values]
    accessor["sparse"] = {
        "count": 2,
        "indices": {"bufferView": builder.view([[0], [2]], 5123), "componentType": 5123},
        "values": {"bufferView": builder.view([[5, 6, 7], [8, 9, 10]])},
    }
    if not dense:
        del accessor["bufferView"]
    builder.animate((0, "translation", builder.times([0.0, 0.5, 1.0]), values, "STEP"))
    (recording,) = read_gltf(builder.write(tmp_path), rate=2.0)
    middle = [1, 1, 1] if dense else [0, 0, 0]
    np.testing.assert_array_equal(recording.translations[:, 0], [[5, 6, 7], middle, [8, 9, 10]])


@pytest.mark.parametrize(
    ("times", "rate"),
    [
        (np.arange(9) / 24.0, 24.0),
        (np.round(np.arange(9) / 30.0, 4), 30.0),
        (np.arange(9) * 1001.0 / 24000.0, 24000.0 / 1001.0),
        ([0.0, 0.3, 1.1], 30.0),
        ([0.0, 1.0, 2.0], 30.0),
        ([0.5], 30.0),
    ],
)
def test_the_rate_is_that_of_even_keys_or_30(tmp_path: Path, times: list[float], rate: float) -> None:
    builder = Builder([{}], joints=[[0]])
    builder.animate((0, "translation", builder.times(times), builder.accessor(np.zeros((len(times), 3))), "LINEAR"))
    (recording,) = read_gltf(builder.write(tmp_path))
    assert recording.rate == pytest.approx(rate, rel=1e-6)
    assert recording.frame_count == int((times[-1] - times[0]) * rate + 1.001)


def test_each_animation_is_a_take_for_each_skeleton_it_moves(tmp_path: Path) -> None:
    builder = Builder([{"name": "A"}, {"name": "B"}, {"name": "A2"}], joints=[[0], [1]])
    builder.document["nodes"][0]["children"] = [2]
    builder.document["skins"].append({"joints": [2]})  # hangs on the first: the same skeleton
    times, values = builder.times([0.0, 0.5]), builder.accessor(np.zeros((2, 3)))
    builder.animate(
        (0, "translation", times, values, "LINEAR"), (1, "translation", times, values, "LINEAR"), name="walk"
    )
    builder.animate((1, "translation", times, values, "LINEAR"))
    builder.animate((0, "weights", times, times, "LINEAR"), name="face")
    recordings = read_gltf(builder.write(tmp_path))
    assert [(r.clip, r.names) for r in recordings] == [
        ("walk_A", ("A", "A2")),
        ("walk_B", ("B",)),
        ("animation_1_B", ("B",)),
    ]


def test_without_skins_the_nodes_that_move_are_joints(tmp_path: Path) -> None:
    builder = Builder([{"translation": [1, 0, 0], "children": [1]}, {"name": "Moved"}])
    builder.animate((1, "translation", builder.times([0.0, 0.5]), builder.accessor(np.zeros((2, 3))), "LINEAR"))
    (recording,) = read_gltf(builder.write(tmp_path))
    assert recording.names == ("Moved",)
    np.testing.assert_array_equal(recording.translations[:, 0], np.tile([1.0, 0, 0], (len(recording.rotations), 1)))


def test_scales_that_change_are_kept(tmp_path: Path) -> None:
    builder = Builder([{"children": [1]}, {"translation": [0, 1, 0]}], joints=[[0, 1]])
    scales = builder.accessor([[1, 1, 1], [1, 2, 3]])
    builder.animate((0, "scale", builder.times([0.0, 1.0]), scales, "LINEAR"))
    (recording,) = read_gltf(builder.write(tmp_path), rate=2.0)
    assert recording.scales is not None
    np.testing.assert_allclose(recording.scales[:, 0], [[1, 1, 1], [1, 1.5, 2], [1, 2, 3]])
    np.testing.assert_allclose(recording.translations[:, 1], np.tile([0.0, 1, 0], (3, 1)))
    assert recording.without_first(1).scales.shape == (2, 2, 3)  # type: ignore[union-attr]


def test_shear_that_cannot_be_kept_is_said(tmp_path: Path) -> None:
    builder = Builder([{"scale": [1, 3, 1], "children": [1]}, {"rotation": unit(0, 0, 1, 2)}], joints=[[1]])
    builder.animate((1, "translation", builder.times([0.0]), builder.accessor(np.zeros((1, 3))), "LINEAR"))
    (recording,) = read_gltf(builder.write(tmp_path))
    assert recording.notes == ("shear above a joint is left out, which USD animations cannot hold",)


def edit(*path: Any, to: Any) -> Callable[[dict[str, Any]], None]:
    """Make a change to the document: the place by its keys, and the new value."""

    def change(document: Any) -> None:
        for key in path[:-1]:
            document = document[key]
        document[path[-1]] = to

    return change


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (edit("asset", "version", to="1.0"), "expected glTF version 2, found '1.0'"),
        (edit("asset", to=3), "not a glTF document: it has no asset"),
        (edit("nodes", 4, "children", to=[1]), r"nodes\[1\] has two parents, nodes\[0\] and nodes\[4\]"),
        (edit("nodes", 4, "children", to=[0]), r"nodes\[0\] is its own ancestor"),
        (edit("nodes", 4, "children", to=[9]), r"there is no nodes\[9\]; the file has 5 nodes"),
        (
            edit("nodes", 1, "translation", to=[1, 2]),
            r"nodes\[1\]\.translation should be 3 numbers, found \[1\.0, 2\.0\]",
        ),
        (edit("nodes", 1, "rotation", to=[0, 0, 0, 0]), r"nodes\[1\]\.rotation has no length"),
        (edit("nodes", 4, "matrix", to=[0] * 16), r"nodes\[4\] is scaled to nothing, so it has no rotation"),
        (edit("skins", 0, "joints", to=[1, 77]), r"there is no nodes\[77\]"),
        (edit("skins", 0, "joints", to=[]), r"skins\[0\] has no joints"),
        (edit("animations", to=[]), "has no animation of joints"),
        (
            edit("animations", 0, "channels", 0, "sampler", to=9),
            r"animations\[0\]\.channels\[0\]: there is no sampler 9",
        ),
        (edit("animations", 0, "channels", 0, "target", "node", to=9), r"there is no nodes\[9\]"),
        (edit("animations", 0, "channels", 2, "target", "node", to=1), r"moves the translation of nodes\[1\] twice"),
        (edit("animations", 0, "samplers", 0, "interpolation", to="BEZIER"), "unknown interpolation 'BEZIER'"),
        (
            edit("animations", 0, "samplers", 0, "interpolation", to="CUBICSPLINE"),
            "should have 9 values for 3 times, found 3",
        ),
        (edit("animations", 0, "samplers", 0, "output", to=0), r"accessors\[0\] should have 4 numbers an element"),
        (edit("animations", 0, "samplers", 0, "input", to=99), r"there is no accessors\[99\]"),
        (
            edit("accessors", 2, "count", to=10**9),
            r"accessors\[2\] reaches beyond its bytes: it needs 16000000000, found 48",
        ),
        (edit("accessors", 2, "count", to=-3), r"accessors\[2\]\.count should be a whole number, found '-3'"),
        (edit("accessors", 0, "count", to=0), "has no keys"),
        (edit("accessors", 2, "componentType", to=5124), r"accessors\[2\] has an unknown componentType '5124'"),
        (edit("bufferViews", 2, "byteOffset", to=10**6), "reaches beyond its bytes"),
        (edit("bufferViews", 2, "byteStride", to=4), "reaches beyond its bytes"),
        (edit("buffers", 0, "uri", to="gone.bin"), r"buffers\[0\]: cannot read 'gone\.bin' beside the file"),
        (edit("buffers", 0, "uri", to="http://example.org/a.bin"), r"buffers\[0\]: cannot read 'http://example"),
        (edit("buffers", 0, "uri", to="data:x;base64,@@@"), r"buffers\[0\] is no base64"),
        (edit("buffers", 0, "uri", to="data:x;base64,ä"), r"buffers\[0\] is no base64"),
        (edit("buffers", 0, "uri", to="a" * 5000), r"buffers\[0\]: bad name 'aaa"),
        (edit("buffers", 0, "uri", to="data:text/plain,abc"), r"buffers\[0\] should be base64"),
        (edit("buffers", 0, to={"byteLength": 1}), r"buffers\[0\] has no bytes"),
    ],
)
def test_damaged_documents_are_reported(tmp_path: Path, change: Callable[[Any], None], reason: str) -> None:
    document = json.loads(build_arm().to_json())
    change(document)
    (tmp_path / "bad.gltf").write_text(json.dumps(document))
    with pytest.raises(FormatError, match=reason):
        read_gltf(tmp_path / "bad.gltf")


@pytest.mark.parametrize(
    ("values", "times", "reason"),
    [
        ([[0, 0, 0], [np.nan, 0, 0]], [0, 1], "holds a number that is not finite"),
        ([[0, 0, 0], [0, 0, 0]], [1, 1], "the times of its keys do not increase"),
        ([[0, 0, 0], [0, 0, 0]], [0, 1e9], "an animation lasts 1e.09 s, which at 30 frames/s is too long to read"),
    ],
)
def test_bad_keys_are_reported(tmp_path: Path, values: Any, times: Any, reason: str) -> None:
    builder = Builder([{}], joints=[[0]])
    builder.animate((0, "translation", builder.times(times), builder.accessor(values), "LINEAR"))
    with pytest.raises(FormatError, match=reason):
        read_gltf(builder.write(tmp_path))


def test_a_number_that_signals_is_refused_without_a_warning(tmp_path: Path) -> None:
    builder = build_arm()
    view = builder.document["bufferViews"][builder.document["accessors"][2]["bufferView"]]
    start = view["byteOffset"]
    builder.data = builder.data[:start] + b"\x01\x00\x80\x7f" + builder.data[start + 4 :]
    with pytest.raises(FormatError, match=r"accessors\[2\] holds a number that is not finite"):
        read_gltf(builder.write(tmp_path))


def test_scales_beyond_half_precision_are_refused(tmp_path: Path) -> None:
    builder = Builder([{"name": "A"}], joints=[[0]])
    times, scales = builder.times([0.0, 1.0]), builder.accessor(np.array([[1.0, 1.0, 1.0], [1.0, 7e4, 1.0]]))
    builder.animate((0, "scale", times, scales, "LINEAR"))
    with pytest.raises(FormatError, match="scales hold a number that is not finite or larger than 65504"):
        read_gltf(builder.write(tmp_path))


def test_a_scale_of_nothing_above_a_joint_is_refused_without_a_warning(tmp_path: Path) -> None:
    builder = build_arm()
    builder.document["nodes"][0]["scale"] = [0.01, 1e-320, 0.01]
    with pytest.raises(FormatError, match="scaled to nothing"):
        read_gltf(builder.write(tmp_path))


def test_a_rotation_without_length_is_reported(tmp_path: Path) -> None:
    builder = Builder([{}], joints=[[0]])
    builder.animate((0, "rotation", builder.times([0]), builder.accessor([[0, 0, 0, 0]]), "LINEAR"))
    with pytest.raises(FormatError, match=r"animations\[0\]\.samplers\[0\]: a rotation has no length"):
        read_gltf(builder.write(tmp_path))


def test_sparse_parts_beyond_the_accessor_are_reported(tmp_path: Path) -> None:
    builder = Builder([{}], joints=[[0]])
    values = builder.accessor(np.ones((2, 3)))
    sparse = {
        "count": 1,
        "indices": {"bufferView": builder.view([[7]], 5123), "componentType": 5123},
        "values": {"bufferView": builder.view([[5, 6, 7]])},
    }
    builder.document["accessors"][values]["sparse"] = sparse
    builder.animate((0, "translation", builder.times([0, 1]), values, "LINEAR"))
    with pytest.raises(FormatError, match=r"accessors\[0\]\.sparse names an element beyond its 2"):
        read_gltf(builder.write(tmp_path))
    del sparse["values"]
    with pytest.raises(FormatError, match=r"accessors\[0\]\.sparse lacks its indices or values"):
        read_gltf(builder.write(tmp_path))
    builder.document["accessors"][values] = {"componentType": FLOAT, "count": 10**12, "type": "VEC3"}
    with pytest.raises(FormatError, match="has 1000000000000 elements without bytes"):
        read_gltf(builder.write(tmp_path))


@pytest.mark.parametrize(
    ("cut", "reason"),
    [
        (slice(0, 10), "truncated: 10 bytes are no binary glTF file"),
        (slice(0, -9), "truncated: .* bytes declared, .* found"),
    ],
)
def test_cut_binary_files_are_reported(tmp_path: Path, cut: slice, reason: str) -> None:
    (tmp_path / "cut.glb").write_bytes(build_arm().to_glb()[cut])
    with pytest.raises(FormatError, match=reason):
        read_gltf(tmp_path / "cut.glb")


def test_other_binary_damage_is_reported(tmp_path: Path) -> None:
    good = build_arm().to_glb()
    for content, reason in (
        (good[:4] + b"\1" + good[5:], "expected binary glTF version 2, found version 1"),
        (
            good[:12] + b"\xff\xff\xff\0" + good[16:],
            "truncated: a chunk of 16777215 bytes at byte 12 ends after the file",
        ),
        (good[:16] + b"NOSJ" + good[20:], "the binary glTF file has no JSON chunk"),
        (good[:20] + b"\xff" + good[21:], "not a glTF document: no UTF-8 text"),
    ):
        (tmp_path / "bad.glb").write_bytes(content)
        with pytest.raises(FormatError, match=reason):
            read_gltf(tmp_path / "bad.glb")


def test_text_that_is_no_document_is_reported(tmp_path: Path) -> None:
    for content, reason in (
        ('{"asset":\n{"version": 2.0,}}', r"bad\.gltf:2: not a glTF document"),
        ('{"asset": {"version": "2.0"}, "nodes": 5}', "not a glTF document"),
        ("[" * 100_000, "not a glTF document: RecursionError"),
        ('{"asset": {"version": "2.0"}}', "has no animation of joints"),
    ):
        (tmp_path / "bad.gltf").write_text(content)
        with pytest.raises(FormatError, match=reason):
            read_gltf(tmp_path / "bad.gltf")
    with pytest.raises(NoMotionError):
        read_gltf(tmp_path / "bad.gltf")
