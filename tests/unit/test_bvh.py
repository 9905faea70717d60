"""The BVH reader: values, the oddities it takes and the mistakes it reports."""

from pathlib import Path

import numpy as np
import pytest

from mtex_usd.formats.bvh import read_bvh
from mtex_usd.formats.bvh_motion import frame_time_to_rate
from mtex_usd.formats.recording import FormatError

GOOD = """HIERARCHY
ROOT Hips
{
  OFFSET 0 1 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation
  JOINT Spine
  {
    OFFSET 0 2 0.5
    CHANNELS 3 Zrotation Yrotation Xrotation
    End Site
    {
      OFFSET 0 1 0
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.0333333
1 2 3 90 0 0 0 0 10
4 5 6 0 90 0 0 0 20
"""


def write(folder: Path, text: str | bytes) -> Path:
    file_path = folder / "take.bvh"
    file_path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return file_path


def replace_once(old: str, new: str) -> str:
    assert GOOD.count(old) >= 1
    return GOOD.replace(old, new, 1)


def test_reads_the_hierarchy_and_the_motion(tmp_path: Path) -> None:
    recording = read_bvh(write(tmp_path, GOOD))
    assert recording.names == ("Hips", "Spine")
    assert recording.parents == (-1, 0)
    assert recording.rate == 30.0
    np.testing.assert_array_equal(recording.offsets, [[0, 1, 0], [0, 2, 0.5]])
    np.testing.assert_array_equal(recording.translations, [[[1, 2, 3], [0, 2, 0.5]], [[4, 5, 6], [0, 2, 0.5]]])
    half = np.sqrt(0.5)
    np.testing.assert_allclose(recording.rotations[:, 0], [[half, 0, 0, half], [half, 0, half, 0]], atol=1e-15)
    spine = [[np.cos(angle / 2), np.sin(angle / 2), 0, 0] for angle in np.radians([10, 20])]
    np.testing.assert_allclose(recording.rotations[:, 1], spine, atol=1e-15)


@pytest.mark.parametrize(
    "text",
    [
        GOOD.replace("\n", "\r\n"),
        GOOD.replace("\n", "\r"),
        GOOD.replace("  ", "\t"),
        GOOD.replace("\n", "\n\n"),
        GOOD + "\n \t\n\n",
        GOOD.rstrip("\n"),
        "\ufeff" + GOOD,
        GOOD.replace("ROOT Hips\n{", "ROOT Hips {").replace("    }\n  }\n}\n", "}}}\n"),
        GOOD.replace("    End Site\n    {\n      OFFSET 0 1 0\n    }\n", ""),
        GOOD.replace("End Site", "End Effector"),
        GOOD.replace("90 0 0 0 0 10", "90 0 0\n 0 0 10"),
        GOOD.replace("Frame Time: ", "Frame Time:\t").replace("Frames: ", "Frames : "),
        GOOD.replace("0.0333333", "3.33333e-02"),
        GOOD.lower().replace("hips", "Hips").replace("spine", "Spine"),
    ],
    ids=[
        "Windows line ends", "old Macintosh line ends", "tabs", "blank lines", "trailing blank lines",
        "no last line end", "byte order mark", "braces anywhere", "no End Site", "End Effector", "wrapped frame",
        "colons", "exponent", "lower case",
    ],
)  # fmt: skip
def test_reads_the_oddities_of_exporters_alike(tmp_path: Path, text: str) -> None:
    plain = read_bvh(write(tmp_path, GOOD))
    odd = read_bvh(write(tmp_path, text))
    assert (odd.names, odd.parents, odd.rate) == (plain.names, plain.parents, plain.rate)
    np.testing.assert_array_equal(odd.offsets, plain.offsets)
    np.testing.assert_array_equal(odd.rotations, plain.rotations)
    np.testing.assert_array_equal(odd.translations, plain.translations)


def test_keeps_joint_names_as_written(tmp_path: Path) -> None:
    text = GOOD.replace("Hips", "mixamorig:Hips").replace("Spine", "Lower Back.001")
    assert read_bvh(write(tmp_path, text)).names == ("mixamorig:Hips", "Lower Back.001")
    latin = GOOD.replace("Hips", "Hüfte").encode("latin-1")
    assert read_bvh(write(tmp_path, latin)).names == ("Hüfte", "Spine")


def test_reads_two_roots(tmp_path: Path) -> None:
    second = "ROOT Prop { OFFSET 7 8 9 CHANNELS 1 Yrotation }\nMOTION"
    text = GOOD.replace("MOTION", second).replace("10\n", "10 30\n").replace("20\n", "20 40\n")
    recording = read_bvh(write(tmp_path, text))
    assert recording.parents == (-1, 0, -1)
    np.testing.assert_array_equal(recording.translations[0, 2], [7, 8, 9])
    expected = [np.cos(np.radians(20)), 0, np.sin(np.radians(20)), 0]
    np.testing.assert_allclose(recording.rotations[1, 2], expected, atol=1e-15)


def test_an_axis_without_position_channel_keeps_the_offset(tmp_path: Path) -> None:
    text = replace_once("CHANNELS 3 Zrotation Yrotation Xrotation", "CHANNELS 2 Xrotation Yposition")
    text = text.replace("90 0 0 0 0 10", "90 0 0 30 5").replace("0 90 0 0 0 20", "0 90 0 40 6")
    recording = read_bvh(write(tmp_path, text))
    np.testing.assert_array_equal(recording.translations[:, 1], [[0, 5, 0.5], [0, 6, 0.5]])
    assert recording.rotations[0, 1, 1] == pytest.approx(np.sin(np.radians(15)))


def test_a_turn_past_half_a_circle_keeps_its_side(tmp_path: Path) -> None:
    angles = range(0, 1081, 15)
    rows = "".join(f"0 0 0 {angle} 0 0 0 0 0\n" for angle in angles)
    text = GOOD[: GOOD.index("Frames")] + f"Frames: {len(angles)}\nFrame Time: 0.04\n{rows}"
    rotations = read_bvh(write(tmp_path, text)).rotations[:, 0]
    assert np.all(np.sum(rotations[1:] * rotations[:-1], axis=-1) > 0.99)


@pytest.mark.parametrize(
    ("old", "new", "line", "reason"),
    [
        ("HIERARCHY", "SOMETHING", 1, "not a BVH file: expected HIERARCHY, found 'SOMETHING'"),
        ("ROOT Hips", "ROOT", 2, "ROOT without a name"),
        ("ROOT", "JOINT", 2, "JOINT outside a ROOT"),
        ("JOINT", "ROOT", 6, "ROOT Spine inside Hips: a '}' is missing"),
        ("JOINT", "BONE", 6, "unexpected 'BONE' in the hierarchy"),
        ("{", "", 4, "expected '{' after Hips, found 'OFFSET'"),
        ("OFFSET 0 1 0", "", 2, "Hips has no OFFSET"),
        ("OFFSET 0 1 0", "OFFSET 0 1", 5, "expected a number, found 'CHANNELS'"),
        ("OFFSET 0 1 0", "OFFSET 0 nan 0", 4, "expected a finite number .* found 'nan'"),
        ("OFFSET 0 1 0", "OFFSET 0 1 0 0", 4, "unexpected '0' in the hierarchy"),
        ("OFFSET 0 1 0", "OFFSET 0 1 0\n OFFSET 0 1 0", 5, "Hips has a second OFFSET"),
        ("CHANNELS 3 Zrotation Yrotation Xrotation", "", 6, "Spine has no CHANNELS"),
        ("CHANNELS 3", "CHANNELS three", 9, "expected the number of channels, found 'three'"),
        ("CHANNELS 3", "CHANNELS -3", 9, "expected the number of channels, found '-3'"),
        ("CHANNELS 3", "CHANNELS 4", 10, "Spine should have 4 channels .* found 'End'"),
        ("CHANNELS 3", "CHANNELS 2", 9, "unexpected 'Xrotation'"),
        ("CHANNELS 3", "CHANNELS 0 CHANNELS 3", 9, "Spine has a second CHANNELS"),
        ("Xposition Yposition", "Xposition Xposition", 5, "the same position channel twice"),
        ("Xposition", "Xscale", 5, "Hips should have 6 channels .* found 'Xscale'"),
        ("End Site\n    {", "End Site\n    { JOINT Tip { }", 11, "JOINT inside an End Site"),
        ("End Site\n    {", "End Site\n    { CHANNELS 0", 11, "CHANNELS inside an End Site"),
        ("}\nMOTION", "}}\nMOTION", 15, "'}' closes nothing"),
        ("}\nMOTION", "\nMOTION", 16, "ends inside Hips, opened on line 2: a '}' is missing"),
        ("MOTION", "", 17, "unexpected 'Frames:' in the hierarchy"),
        ("Frames: 2", "Frames: two", 17, "expected the number of frames, found 'two'"),
        ("Frames: 2", f"Frames: {'9' * 5000}", 17, "expected the number of frames"),
        ("Frames: 2", "Frames: 0", 17, "the file has no frames"),
        ("Frames: 2\n", "", 17, "expected 'Frames: N', found 'Frame Time: 0.0333333'"),
        ("Frames: 2", "Frames: 3", 20, "truncated: 3 frames declared, 2 found"),
        ("Frames: 2", "Frames: 1", 20, "1 frames declared, 2 found"),
        ("Frame Time: 0.0333333", "Frame Time:", 18, "expected 'Frame Time: S', found 'Frame Time:'"),
        ("Frame Time: 0.0333333", "Frame Time: 0", 18, "expected a frame time above 0 seconds, found '0'"),
        ("Frame Time: 0.0333333", "Frame Time: -0.1", 18, "expected a frame time above 0 seconds, found '-0.1'"),
        ("Frame Time: 0.0333333", "Frame Time: 1e-320", 18, "expected a frame time above 0 seconds"),
        ("Frame Time: 0.0333333", "Frame Time: inf", 18, "expected a finite number .* found 'inf'"),
        ("Frame Time: 0.0333333", "Frame Time: fast", 18, "expected a number, found 'fast'"),
        ("1 2 3 90", "1 2 3", 19, "expected 9 values in a frame, found 8"),
        ("1 2 3 90", "1 2 3 4 90", 19, "expected 9 values in a frame, found 10"),
        ("4 5 6 0", "4 5 6", 20, "truncated: frame 2 of 2 has 8 of 9 values"),
        ("4 5 6", "4 x 6", 20, "expected a number, found 'x'"),
        ("4 5 6", "4 nan 6", 20, "expected a finite number .* found 'nan'"),
        ("4 5 6", "4 -inf 6", 20, "expected a finite number .* found '-inf'"),
        ("4 5 6", "4 1e39 6", 20, "expected a finite number in single precision's range, found '1e39'"),
    ],
)
def test_reports_mistakes_with_line_and_reason(tmp_path: Path, old: str, new: str, line: int, reason: str) -> None:
    file_path = write(tmp_path, replace_once(old, new))
    with pytest.raises(FormatError, match=reason) as caught:
        read_bvh(file_path)
    assert (caught.value.file_path, caught.value.line, caught.value.exit_code) == (file_path, line, 2)
    assert str(caught.value).startswith(f"{file_path}:{line}: ")


@pytest.mark.parametrize("kept_lines", range(1, 20))
def test_reports_a_file_cut_anywhere(tmp_path: Path, kept_lines: int) -> None:
    lines = GOOD.splitlines()[:kept_lines]
    with pytest.raises(FormatError, match=r"ends|truncated|is expected") as caught:
        read_bvh(write(tmp_path, "\n".join(lines) + "\n"))
    assert caught.value.line == kept_lines


@pytest.mark.parametrize(
    ("content", "line", "reason"),
    [
        (b"", 1, "the file is empty"),
        (b" \n\n", 1, "the file is empty"),
        (b"HIERARCHY\nROOT\x00", 2, "not a text file"),
        (bytes(range(1, 256)), 1, "not a BVH file"),
        (b"HIERARCHY\nMOTION\nFrames: 1\nFrame Time: 1\n", 2, "the hierarchy ends without a ROOT"),
        (b"HIERARCHY ROOT a\n{OFFSET 0 0 0 CHANNELS 0}\nMOTION\nFrames: 1\nFrame Time: 1", 3, "no joint has a channel"),
    ],
)  # fmt: skip
def test_reports_what_is_no_motion_file(tmp_path: Path, content: bytes, line: int, reason: str) -> None:
    with pytest.raises(FormatError, match=reason) as caught:
        read_bvh(write(tmp_path, content))
    assert caught.value.line == line


def test_reports_what_cannot_be_opened(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"nowhere\.bvh: cannot be read: No such file") as caught:
        read_bvh(tmp_path / "nowhere.bvh")
    assert caught.value.line is None
    with pytest.raises(FormatError, match="cannot be read: Is a directory"):
        read_bvh(tmp_path)


@pytest.mark.parametrize(
    ("written", "rate"),
    [
        (".0083333", 120.0),
        ("0.008333", 120.0),
        ("8.333333e-03", 120.0),
        ("0.033333", 30.0),
        (".03333", 30.0),
        ("0.033", 30.0),
        ("0.016666666666666666", 60.0),
        ("0.016667", 60.0),
        ("0.04", 25.0),
        ("1", 1.0),
        ("0.008342", 120000.0 / 1001.0),
        ("0.0333667", 30000.0 / 1001.0),
        ("0.0417083333333333", 24000.0 / 1001.0),
        ("0.0417083750417", 23.976),
        ("0.0123456789", 1.0 / 0.0123456789),
        ("2.5", 0.4),
    ],
)
def test_frame_rates_are_what_the_rounded_frame_time_came_from(written: str, rate: float) -> None:
    assert frame_time_to_rate(written) == pytest.approx(rate, rel=1e-12)
