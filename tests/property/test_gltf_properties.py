"""Curves of any kind in glTF against the slow reader, and damaged files."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mtex_usd.formats.gltf import read_gltf
from mtex_usd.formats.recording import FormatError
from mtex_usd.motion import quaternion
from tests.gltf_files import Builder, build_arm, unit
from tests.oracle import gltf as oracle

numbers = st.floats(-3.0, 3.0, width=32).map(lambda value: round(value, 3))
turns = st.tuples(numbers, numbers, numbers, st.just(1.0)).map(lambda q: unit(*q))
places = st.tuples(numbers, numbers, numbers).map(list)


@st.composite
def chains(draw: st.DrawFn) -> tuple[Builder, list[int]]:
    """A chain of nodes, some of them joints, some moving."""
    count = draw(st.integers(1, 5))
    nodes: list[dict[str, Any]] = []
    for i in range(count):
        nodes.append({"translation": draw(places), "rotation": draw(turns)})
        if draw(st.booleans()):
            nodes[-1]["scale"] = [draw(st.sampled_from([0.01, 0.5, 2.0]))] * 3
        if i + 1 < count:
            nodes[-1]["children"] = [i + 1]
    joints = sorted(draw(st.sets(st.integers(0, count - 1), min_size=1)))
    builder = Builder(nodes, joints=[joints])
    channels = []
    targets = st.sampled_from([(node, path) for node in range(joints[-1] + 1) for path in ("translation", "rotation")])
    for node, path in draw(st.lists(targets, min_size=1, max_size=4, unique=True)):
        steps = draw(st.lists(st.integers(1, 9), min_size=1, max_size=4))
        times = np.cumsum(steps) / 10.0
        kind = draw(st.sampled_from(["STEP", "LINEAR", "CUBICSPLINE"]))
        value = turns if path == "rotation" else places
        size = len(times) * (3 if kind == "CUBICSPLINE" else 1)
        values = np.array(draw(st.lists(value, min_size=size, max_size=size)))
        if kind == "CUBICSPLINE" and path == "rotation":
            values[0::3], values[2::3] = 0.1 * values[0::3], 0.1 * values[2::3]  # away from turns without length
            values[1::3] *= np.where(values[1::3] @ values[1] < 0.0, -1.0, 1.0)[:, None]
        channels.append((node, path, builder.times(times), builder.accessor(values), kind))
    builder.animate(*channels)
    return builder, joints


@given(chains(), st.sampled_from(["take.gltf", "take.glb"]))
def test_joints_are_where_the_slow_reader_says(tmp_path_factory, chain: tuple[Builder, list[int]], name: str) -> None:
    builder, joints = chain
    file_path = builder.write(tmp_path_factory.mktemp("gltf"), name)
    (recording,) = read_gltf(file_path, rate=7.0)
    document = oracle.Document(file_path)
    keys = [document.elements(sampler["input"])[0][0] for sampler in document.json["animations"][0]["samplers"]]
    for frame in range(recording.frame_count):
        world: list[tuple[np.ndarray, np.ndarray]] = []
        for j, node in enumerate(joints):
            rotation, place = recording.rotations[frame, j], recording.translations[frame, j]
            if recording.parents[j] >= 0:
                place = world[j - 1][0] + quaternion.rotate(world[j - 1][1], place)
                rotation = quaternion.multiply(world[j - 1][1], rotation)
            world.append((place, rotation))
            expected = document.world_matrix(0, node, min(keys) + frame / 7.0)
            np.testing.assert_allclose(place, expected[:3, 3], atol=1e-5, rtol=1e-5)


@given(st.data())
def test_a_damaged_file_is_read_or_reported(tmp_path_factory, data) -> None:
    content = build_arm().to_glb() if data.draw(st.booleans()) else build_arm().to_json()
    start = data.draw(st.integers(0, len(content)))
    stop = data.draw(st.integers(start, min(len(content), start + 12)))
    damage = data.draw(st.binary(max_size=6) | st.sampled_from([b"99999999", b"-1", b"null", b'"x"', b"[]", b"1e308"]))
    file_path: Path = tmp_path_factory.mktemp("gltf") / "take.gltf"
    file_path.write_bytes(content[:start] + damage + content[stop:])
    check_reading(file_path)


def places_of(document: Any) -> list[tuple[Any, Any]]:
    """Every place in a document, as the container and the key in it."""
    found = []
    waiting = [document]
    while waiting:
        container = waiting.pop()
        keys = container.keys() if isinstance(container, dict) else range(len(container))
        for key in keys:
            found.append((container, key))
            if isinstance(container[key], dict | list):
                waiting.append(container[key])
    return found


@given(st.data())
def test_any_value_of_a_wrong_kind_is_reported(tmp_path_factory, data) -> None:
    document = json.loads(build_arm().to_json())
    wrong = [
        None,
        True,
        -1,
        0,
        3,
        10**20,
        1.5,
        1e308,
        float("nan"),
        "x",
        "",
        [],
        {},
        [[]],
        [1, 2, 3],
        {"a": 1},
        ["x"] * 3,
    ]
    for _ in range(data.draw(st.integers(1, 2))):
        container, key = data.draw(st.sampled_from(places_of(document)))
        container[key] = data.draw(st.sampled_from(wrong))
    file_path: Path = tmp_path_factory.mktemp("gltf") / "take.gltf"
    file_path.write_text(json.dumps(document))
    check_reading(file_path)


def check_reading(file_path: Path) -> None:
    try:
        recordings = read_gltf(file_path)
    except FormatError as error:
        assert str(error).startswith(str(file_path))
    else:
        for recording in recordings:
            assert np.all(np.isfinite(recording.rotations)) and np.all(np.isfinite(recording.translations))
            assert recording.rotations.shape == (recording.frame_count, len(recording.names), 4)
