"""Any hierarchy and motion, written as BVH by this file's own writer, reads back as it was."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mtex_usd.formats.bvh import read_bvh
from mtex_usd.formats.recording import FormatError
from tests.oracle import bvh as oracle

POSITIONS = ("Xposition", "Yposition", "Zposition")
ROTATIONS = ("Xrotation", "Yrotation", "Zrotation")

numbers = st.floats(-1e4, 1e4, allow_subnormal=False)
offsets = st.tuples(numbers, numbers, numbers)
names = st.text("abcXYZ019_.:-", min_size=1, max_size=8).filter(lambda name: name.upper() != "MOTION")


@dataclass(frozen=True)
class Document:
    """What is written: parents point back, and joints come depth first."""

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: tuple[tuple[float, float, float], ...]
    channels: tuple[tuple[str, ...], ...]
    rows: tuple[tuple[float, ...], ...]
    indent: str
    line_end: str
    values_per_line: int


@st.composite
def documents(draw: st.DrawFn) -> Document:
    count = draw(st.integers(1, 8))
    parents = [-1]
    for joint in range(1, count):
        # Depth first: the parent is the joint before or one of its ancestors.
        chain = [joint - 1]
        while parents[chain[-1]] >= 0:
            chain.append(parents[chain[-1]])
        parents.append(draw(st.sampled_from(chain)))
    channels = [tuple(draw(st.lists(st.sampled_from(POSITIONS + ROTATIONS), unique=True))) for _ in range(count)]
    if not any(channels):
        channels[0] = ("Zrotation",)
    width = sum(map(len, channels))
    return Document(
        names=tuple(draw(st.lists(names, min_size=count, max_size=count))),
        parents=tuple(parents),
        offsets=tuple(draw(st.lists(offsets, min_size=count, max_size=count))),
        channels=tuple(channels),
        rows=tuple(draw(st.lists(st.tuples(*[numbers] * width), min_size=1, max_size=4))),
        indent=draw(st.sampled_from(["", " ", "\t"])),
        line_end=draw(st.sampled_from(["\n", "\r\n"])),
        values_per_line=draw(st.integers(1, width)),
    )


def write_bvh(document: Document) -> bytes:
    lines = ["HIERARCHY"]
    for joint, parent in enumerate(document.parents):
        if parent < 0:
            lines += _write_joint(document, joint, 0)
    lines += ["MOTION", f"Frames: {len(document.rows)}", "Frame Time: 0.04"]
    step = document.values_per_line
    for row in document.rows:
        words = [repr(value) for value in row]
        lines += [" ".join(words[i : i + step]) for i in range(0, len(words), step)]
    return (document.line_end.join(lines) + document.line_end).encode()


def _write_joint(document: Document, joint: int, depth: int) -> list[str]:
    channels = document.channels[joint]
    children = [child for child, parent in enumerate(document.parents) if parent == joint]
    body = [
        "OFFSET " + " ".join(map(repr, document.offsets[joint])),
        " ".join(["CHANNELS", str(len(channels)), *channels]),
        *(line for child in children for line in _write_joint(document, child, depth + 1)),
        *(() if children else ("End Site", "{", "OFFSET 1 2 3", "}")),
    ]
    head = f"{'ROOT' if depth == 0 else 'JOINT'} {document.names[joint]}"
    return [head, "{", *(document.indent + line for line in body), "}"]


def place(document: Document, joint: int, frame: int) -> list[float]:
    """Where the joint is relative to its parent, by the writer's own bookkeeping."""
    first = sum(map(len, document.channels[:joint]))
    position = list(document.offsets[joint])
    for column, channel in enumerate(document.channels[joint], start=first):
        if channel in POSITIONS:
            position[POSITIONS.index(channel)] = document.rows[frame][column]
    return position


@given(documents())
def test_what_is_written_is_read(tmp_path_factory, document: Document) -> None:
    file_path: Path = tmp_path_factory.mktemp("bvh") / "take.bvh"
    file_path.write_bytes(write_bvh(document))
    recording = read_bvh(file_path)
    assert (recording.names, recording.parents, recording.rate) == (document.names, document.parents, 25.0)
    np.testing.assert_array_equal(recording.offsets, document.offsets)
    frames, joints = range(len(document.rows)), range(len(document.names))
    np.testing.assert_array_equal(
        recording.translations, [[place(document, joint, frame) for joint in joints] for frame in frames]
    )
    np.testing.assert_allclose(np.linalg.norm(recording.rotations, axis=-1), 1.0, atol=1e-12)
    assert np.all(np.sum(recording.rotations[1:] * recording.rotations[:-1], axis=-1) >= 0.0)


@given(documents())
def test_rotations_turn_as_the_slow_reader_says(tmp_path_factory, document: Document) -> None:
    file_path: Path = tmp_path_factory.mktemp("bvh") / "take.bvh"
    file_path.write_bytes(write_bvh(document))
    recording = read_bvh(file_path)
    motion = oracle.read(file_path)
    assert len(motion.frames) == recording.frame_count
    for frame in range(recording.frame_count):
        world = oracle.world_transforms(motion, frame)[:, :3, :3]
        for joint, parent in enumerate(recording.parents):
            local = world[joint] if parent < 0 else world[parent].T @ world[joint]
            np.testing.assert_allclose(to_matrix(recording.rotations[frame, joint]), local, atol=1e-9)


@given(documents(), st.data())
def test_a_damaged_file_is_read_or_reported_with_its_line(tmp_path_factory, document: Document, data) -> None:
    content = write_bvh(document)
    start = data.draw(st.integers(0, len(content)))
    stop = data.draw(st.integers(start, min(len(content), start + 20)))
    damage = data.draw(st.binary(max_size=6) | st.sampled_from([b"{", b"}", b"\n", b" 1 ", b" nan ", b"JOINT", b"-"]))
    file_path: Path = tmp_path_factory.mktemp("bvh") / "take.bvh"
    file_path.write_bytes(content[:start] + damage + content[stop:])
    try:
        recording = read_bvh(file_path)
    except FormatError as error:
        assert error.line is not None
        assert 1 <= error.line <= file_path.read_bytes().count(b"\n") + file_path.read_bytes().count(b"\r") + 1
    else:
        shape = (recording.frame_count, len(recording.names))
        assert recording.rotations.shape == (*shape, 4)
        assert recording.translations.shape == (*shape, 3)
        assert np.all(np.isfinite(recording.rotations)) and np.all(np.isfinite(recording.translations))


def to_matrix(q: np.ndarray) -> np.ndarray:
    """Rotate the three axes by v + 2 w (u x v) + 2 u x (u x v)."""
    real, axis = q[0], q[1:]
    columns = [v + 2 * real * np.cross(axis, v) + 2 * np.cross(axis, np.cross(axis, v)) for v in np.eye(3)]
    return np.stack(columns, axis=1)
