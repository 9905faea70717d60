"""Any skeleton and motion, written as ASF/AMC by this file's own writer, moves as the slow reader says."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mtex_usd.formats.amc import read_amc
from mtex_usd.formats.recording import FormatError
from mtex_usd.motion import quaternion
from tests.acclaim import AMC, ASF, write_take
from tests.oracle import asf_amc as oracle

ROTATIONS = ("rx", "ry", "rz")
TRANSLATIONS = ("TX", "TY", "TZ")

angles = st.floats(-360.0, 360.0).map(lambda value: round(value, 4))
lengths = st.floats(-50.0, 50.0).map(lambda value: round(value, 4))
triples = st.tuples(angles, angles, angles)


@dataclass(frozen=True)
class Document:
    """What is written: bone 0 is the root, parents point back."""

    parents: tuple[int, ...]
    directions: tuple[tuple[float, ...], ...]
    lengths: tuple[float, ...]
    axes: tuple[tuple[float, ...], ...]
    orders: tuple[str, ...]
    dofs: tuple[tuple[str, ...], ...]
    frames: tuple[tuple[tuple[float, ...], ...], ...]


@st.composite
def documents(draw: st.DrawFn) -> Document:
    count = draw(st.integers(1, 6))
    parents = [draw(st.integers(0, bone)) for bone in range(count)]
    root = tuple(draw(st.permutations(TRANSLATIONS + tuple(name.upper() for name in ROTATIONS))))
    dofs = [tuple(draw(st.lists(st.sampled_from(ROTATIONS), unique=True))) for _ in range(count)]
    widths = [6, *map(len, dofs)]
    row = st.tuples(*(st.tuples(*[angles] * width) for width in widths))
    units = [draw(st.sampled_from([(1.0, 0, 0), (0, 0, -1.0), (0.6, -0.8, 0), (0, 0.28, 0.96)])) for _ in range(count)]
    return Document(
        parents=tuple(parents),
        directions=tuple(units),
        lengths=tuple(draw(st.lists(lengths, min_size=count, max_size=count))),
        axes=tuple(draw(st.lists(triples, min_size=count, max_size=count))),
        orders=tuple("".join(draw(st.permutations("XYZ"))) for _ in range(count)),
        dofs=(root, *dofs),
        frames=tuple(draw(st.lists(row, min_size=1, max_size=3))),
    )


def write_asf(document: Document) -> str:
    lines = [":units", "angle deg", ":root", f"order {' '.join(document.dofs[0])}", "axis XYZ"]
    lines += ["position 0 0 0", "orientation 0 0 0", ":bonedata"]
    for bone in range(len(document.parents)):
        numbers = " ".join(map(repr, document.axes[bone]))
        lines += ["begin", f"name b{bone + 1}", f"direction {' '.join(map(repr, document.directions[bone]))}"]
        lines += [f"length {document.lengths[bone]!r}", f"axis {numbers} {document.orders[bone]}"]
        lines += [f"dof {' '.join(document.dofs[bone + 1])}"] if document.dofs[bone + 1] else []
        lines.append("end")
    lines += [":hierarchy", "begin"]
    for bone, parent in enumerate(document.parents):
        lines.append(f"{'root' if parent == 0 else f'b{parent}'} b{bone + 1}")
    return "\n".join([*lines, "end", ""])


def write_amc(document: Document) -> str:
    lines = [":FULLY-SPECIFIED", ":DEGREES"]
    for number, frame in enumerate(document.frames, start=1):
        lines.append(str(number))
        for bone, values in enumerate(frame):
            name = f"b{bone}" if bone else "root"
            lines += [" ".join([name, *map(repr, values)])] if values else []
    return "\n".join([*lines, ""])


@given(documents())
def test_bones_are_where_the_slow_reader_says(tmp_path_factory, document: Document) -> None:
    folder: Path = tmp_path_factory.mktemp("amc")
    file_path = write_take(folder, asf=write_asf(document), amc=write_amc(document))
    recording = read_amc(file_path)
    bones, frames = oracle.read_skeleton(folder / "tester.asf"), oracle.read_frames(file_path)
    assert recording.frame_count == len(frames) == len(document.frames)
    for i, frame in enumerate(frames):
        world: list[tuple[np.ndarray, np.ndarray]] = []
        expected = oracle.world_positions(bones, frame)
        for j, (name, parent) in enumerate(zip(recording.names, recording.parents, strict=True)):
            rotation, place = recording.rotations[i, j], recording.translations[i, j]
            if parent >= 0:
                place = world[parent][0] + quaternion.rotate(world[parent][1], place)
                rotation = quaternion.multiply(world[parent][1], rotation)
            world.append((place, rotation))
            np.testing.assert_allclose(place, expected[name], atol=1e-9)


@given(st.data())
def test_a_damaged_file_is_read_or_reported_with_its_line(tmp_path_factory, data) -> None:
    texts = {"asf": ASF, "amc": AMC}
    which = data.draw(st.sampled_from(sorted(texts)))
    content = texts[which]
    start = data.draw(st.integers(0, len(content)))
    stop = data.draw(st.integers(start, min(len(content), start + 20)))
    words = ["\n", " ", " 1 ", "nan", "1e308", "-", "begin", "end", ":", "#", "9" * 30, "(", "root", "\0"]
    damage = data.draw(st.sampled_from(words) | st.text(max_size=5))
    texts[which] = content[:start] + damage + content[stop:]
    folder: Path = tmp_path_factory.mktemp("amc")
    (folder / "tester.asf").write_text(texts["asf"], encoding="utf-8", errors="surrogatepass")
    (folder / "tester_01.amc").write_text(texts["amc"], encoding="utf-8", errors="surrogatepass")
    try:
        recording = read_amc(folder / "tester_01.amc")
    except FormatError as error:
        assert error.line is not None
        assert 1 <= error.line <= len(texts["asf"]) + len(texts["amc"])
    else:
        assert np.all(np.isfinite(recording.rotations)) and np.all(np.isfinite(recording.translations))
        assert recording.rotations.shape == (recording.frame_count, len(recording.names), 4)
