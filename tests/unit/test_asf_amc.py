"""ASF/AMC: what the format leaves open, and every way a file can be wrong."""

from pathlib import Path

import numpy as np
import pytest

from mtex_usd.formats.amc import find_skeleton, read_amc
from mtex_usd.formats.asf import read_asf
from mtex_usd.formats.recording import ChannelLimit, FormatError, Recording
from mtex_usd.motion.skeleton import Skeleton
from tests.acclaim import AMC, ASF, write_take
from tests.oracle import asf_amc as oracle


def place_joints(recording: Recording) -> dict[str, np.ndarray]:
    """Joint positions over time by name, shape [F, 3] each."""
    joints: list[str] = []
    for name, parent in zip(recording.names, recording.parents, strict=True):
        joints.append(name if parent < 0 else f"{joints[parent]}/{name}")
    skeleton = Skeleton(joints=tuple(joints), rest=recording.rest_transforms)
    positions, _ = skeleton.world_pose(recording.rotations, recording.translations)
    return {name: positions[:, i] for i, name in enumerate(recording.names)}


def test_bones_turn_about_their_own_axes_as_the_slow_reader_says(tmp_path: Path) -> None:
    file_path = write_take(tmp_path)
    found = place_joints(read_amc(file_path))
    bones = oracle.read_skeleton(tmp_path / "tester.asf")
    for bone in bones.values():
        length = np.linalg.norm(bone.direction)
        bone.direction = tuple(x / length for x in bone.direction) if length else bone.direction
    for i, frame in enumerate(oracle.read_frames(file_path)):
        for name, expected in oracle.world_positions(bones, frame).items():
            np.testing.assert_allclose(found[name][i], expected, atol=1e-12)


def test_the_skeleton_is_in_order_and_directions_are_unit(tmp_path: Path) -> None:
    recording = read_amc(write_take(tmp_path))
    assert recording.names == ("root", "thigh", "shin", "spine")
    assert recording.parents == (-1, 0, 1, 0)
    np.testing.assert_allclose(recording.offsets, [[0, 0, 0], [0, 0, 0], [0, -4, 0], [0, 0, 0]], atol=1e-12)
    assert recording.meters_per_unit == pytest.approx(0.0254 / 0.5)
    assert recording.companions == (tmp_path / "tester.asf",)


def test_a_bone_that_the_motion_leaves_out_stays_at_rest(tmp_path: Path) -> None:
    short = "".join(line for line in AMC.splitlines(keepends=True) if not line.startswith("shin"))
    recording = read_amc(write_take(tmp_path, amc=short))
    np.testing.assert_allclose(recording.rotations[:, 2], np.tile([1.0, 0, 0, 0], (2, 1)), atol=1e-15)


def test_limits_are_kept_where_there_are_some(tmp_path: Path) -> None:
    recording = read_amc(write_take(tmp_path))
    assert recording.limits == (
        ChannelLimit(joint=1, channel="rx", lower=-160.0, upper=20.0),
        ChannelLimit(joint=1, channel="ry", lower=-70.0, upper=70.0),
        ChannelLimit(joint=1, channel="rz", lower=-np.inf, upper=70.0),
    )
    assert recording.dof_axes is not None
    half = np.radians(10.0)
    np.testing.assert_allclose(recording.dof_axes[1], [np.cos(half), 0, 0, np.sin(half)], atol=1e-15)


def test_radians_give_the_same_motion_as_degrees(tmp_path: Path) -> None:
    plain = read_amc(write_take(tmp_path))
    asf, amc = ASF.replace("angle deg", "angle rad"), AMC.replace(":DEGREES", ":RADIANS")
    for written in ("0 0 20 XYZ", "10 20 30 ZXY", "-160.0 20.0", "-70.0 70.0"):
        asf = asf.replace(written, " ".join(_to_radians(word) for word in written.split()))
    asf = asf.replace("-inf 70.0", f"-inf {_to_radians('70')}")
    lines = [line.split() for line in amc.splitlines()]
    skip = {"root": 4, "thigh": 1, "shin": 1}
    turned = [
        " ".join([*words[: skip[words[0]]], *map(_to_radians, words[skip[words[0]] :])])
        if words[0] in skip
        else " ".join(words)
        for words in lines
    ]
    other = read_amc(write_take(tmp_path, asf=asf, amc="\n".join(turned)))
    np.testing.assert_allclose(other.rotations, plain.rotations, atol=1e-12)
    assert [limit.lower for limit in other.limits] == pytest.approx([limit.lower for limit in plain.limits])
    # Without a line of its own the motion follows its skeleton.
    silent = read_amc(write_take(tmp_path, asf=asf, amc="\n".join(turned).replace(":RADIANS", "")))
    np.testing.assert_array_equal(silent.rotations, other.rotations)


def _to_radians(word: str) -> str:
    try:
        return repr(float(np.radians(float(word))))
    except ValueError:
        return word


def test_the_order_of_channels_is_the_order_of_values_and_turns(tmp_path: Path) -> None:
    asf = ASF.replace("TX TY TZ RX RY RZ", "RZ RX RY TZ TY TX").replace("dof rx ry rz", "dof rz ry rx")
    recording = read_amc(write_take(tmp_path, asf=asf, amc="1\nroot 90 90 0 7 8 9\nthigh 0 0 0\nshin 0\n"))
    np.testing.assert_allclose(recording.translations[0, 0], [9, 8, 7])
    # About z first: x becomes y; then about x: y becomes z.
    x_axis = recording.rotations[0, 0]
    real, axis = x_axis[0], x_axis[1:]
    turned = [1, 0, 0] + 2 * real * np.cross(axis, [1, 0, 0]) + 2 * np.cross(axis, np.cross(axis, [1, 0, 0]))
    np.testing.assert_allclose(turned, [0, 0, 1], atol=1e-12)


def test_the_preset_of_the_root_offsets_the_motion(tmp_path: Path) -> None:
    asf = ASF.replace("position 0 0 0", "position 10 0 0").replace("orientation 0 0 0", "orientation 0 90 0")
    recording = read_amc(write_take(tmp_path, asf=asf, amc="1\nroot 1 2 3 90 0 0\nthigh 0 0 0\nshin 0\n"))
    np.testing.assert_allclose(recording.translations[0, 0], [11, 2, 3])
    half = np.sqrt(0.5)
    # Turned about its own x axis, which the preset laid on global -z.
    np.testing.assert_allclose(recording.rotations[0, 0], [half, 0, 0, -half], atol=1e-12)


def test_translations_and_stretch_of_bones(tmp_path: Path) -> None:
    asf = ASF.replace("axis 0 0 20 XYZ\n     dof rx ry rz", "axis 0 0 90 XYZ\n     dof tx l rx").replace(
        "dof rx\n", "dof tz\n"
    )
    recording = read_amc(write_take(tmp_path, asf=asf, amc="1\nroot 0 0 0 0 0 0\nthigh 2 0.5 0\nshin 0\n"))
    np.testing.assert_allclose(recording.translations[0, 1], [0, 2, 0], atol=1e-12)  # its own x lies along global y
    np.testing.assert_allclose(recording.translations[0, 2], [0, -4.5, 0], atol=1e-12)


def test_rates(tmp_path: Path) -> None:
    assert read_amc(write_take(tmp_path)).rate == 120.0
    assert read_amc(write_take(tmp_path), rate=60.0).rate == 60.0
    timed = write_take(tmp_path, amc=":SAMPLES-PER-SECOND 30\n" + AMC)
    assert read_amc(timed).rate == 30.0
    assert read_amc(timed, rate=60.0).rate == 60.0


def test_the_skeleton_beside_the_motion_is_found(tmp_path: Path) -> None:
    motion = tmp_path / "91_13.amc"
    with pytest.raises(FormatError, match=r"no skeleton beside it: there is no \.asf file; name one with --skeleton"):
        find_skeleton(motion)
    (tmp_path / "other.ASF").touch()
    assert find_skeleton(motion).name == "other.ASF"
    (tmp_path / "third.asf").touch()
    with pytest.raises(FormatError, match=r"none of other\.ASF, third\.asf has its name; name one with --skeleton"):
        find_skeleton(motion)
    (tmp_path / "9.asf").touch()
    (tmp_path / "91.asf").touch()
    assert find_skeleton(motion).name == "91.asf"
    (tmp_path / "91_13.asf").touch()
    assert find_skeleton(motion).name == "91_13.asf"


def test_a_named_skeleton_counts(tmp_path: Path) -> None:
    motion = write_take(tmp_path)
    other = tmp_path / "elsewhere.asf"
    other.write_text(ASF.replace("length 4", "length 8"))
    assert read_amc(motion, skeleton=other).offsets[2][1] == -8.0


@pytest.mark.parametrize(
    ("old", "new", "line", "reason"),
    [
        (":version 1.10", "version 1.10", 2, "not an ASF file: expected a section such as :version, found 'version'"),
        (":name tester", ":version 1.10", 3, "a second :version section"),
        ("angle deg", "angle grad", 7, "expected angle deg or rad, found 'grad'"),
        ("length 0.5", "length 0", 6, "expected a length above 0"),
        (":root", ":toor", 48, "the file has no :root section"),
        ("order TX TY TZ RX RY RZ", "", 11, "the root has no order"),
        ("order TX TY TZ RX RY RZ", "order TX TX", 12, "the same channel twice in order"),
        ("order TX TY TZ RX RY RZ", "order TX TW", 12, "expected one of rx ry rz tx ty tz l, found 'tw'"),
        ("axis XYZ\n   pos", "axis XYX\n   pos", 13, "expected an axis order such as XYZ, found 'xyx'"),
        ("position 0 0 0", "position 0 0", 14, "position should have 3 numbers, found 2"),
        ("position 0 0 0", "position 0 nan 0", 14, "expected a finite number in single precision's range, found 'nan'"),
        ("direction 0 -1 0", "direction 0 -1 1e99", 20, "expected a finite number"),
        ("direction 0 -1 0", "direction 0 0 0", 17, "thigh has a length and no direction"),
        ("direction 0 -1 0\n", "\n", 17, "the bone thigh has no direction"),
        ("     length 5\n", "\n", 29, "the bone shin has no length"),
        ("name shin", "name", 29, "the bone here has no name"),
        ("name shin", "name thigh", 29, "a second bone thigh"),
        ("dof rx ry rz", "dof rx ry", 24, "thigh has 2 degrees of freedom and 6 numbers of limits"),
        ("(-70.0 70.0)", "(-70.0 x)", 24, "expected a number, found 'x'"),
        ("  end\n  begin\n     id 2", "  begin\n     id 2", 28, "begin before the end of the block before"),
        ("  begin\n     id 2", "     id 2", 29, "expected begin, found 'id'"),
        ("    thigh shin\n  end\n", "    thigh shin\n", 47, "a block of :hierarchy is not ended; it begins on line 45"),
        ("root thigh spine", "root thigh tail", 46, "the hierarchy names 'tail', which is no bone"),
        ("thigh shin\n", "thigh shin spine\n", 47, "spine has a second place in the hierarchy"),
        ("root thigh spine", "root thigh", 37, "spine does not hang on the root in the hierarchy"),
        ("    thigh shin\n", "    shin shin\n", 29, "shin does not hang on the root in the hierarchy"),
    ],
)
def test_damaged_skeletons_are_reported_with_their_line(
    tmp_path: Path, old: str, new: str, line: int, reason: str
) -> None:
    assert ASF.count(old) == 1
    (tmp_path / "bad.asf").write_text(ASF.replace(old, new))
    with pytest.raises(FormatError) as caught:
        read_asf(tmp_path / "bad.asf")
    assert reason in caught.value.reason
    assert caught.value.line == line


@pytest.mark.parametrize(
    ("old", "new", "line", "reason"),
    [
        ("\n1\nroot", "\nroot", 4, "not an AMC file: expected the number of the first frame, found 'root'"),
        ("shin 41", "tail 41", 11, "'tail' is no bone of tester.asf"),
        ("thigh 6 -7 8", "thigh 6 -7", 10, "thigh should have 3 values (rx ry rz), found 2"),
        ("shin 41", "spine 41", 11, "spine should have 0 values (it does not move), found 1"),
        ("shin 41\n", "", 10, "frame 2 has no line for shin"),
        ("shin 41", "thigh 1 2 3", 11, "frame 2 has thigh twice"),
        ("shin 40\n", "", 10, "frame 2 has shin, which the first frame has not"),
        ("\n2\n", "\n3\n", 8, "frame 3 comes after frame 1"),
        ("\n2\n", "\n2\n:DEGREES\n", 9, ":DEGREES among the frames"),
        ("-7", "-7x", 10, "expected a number, found '-7x'"),
        ("1.5", "inf", 9, "expected a finite number in single precision's range, found 'inf'"),
        (":DEGREES", ":SAMPLES-PER-SECOND 0", 3, "expected samples per second above 0"),
    ],
)
def test_damaged_motion_is_reported_with_its_line(tmp_path: Path, old: str, new: str, line: int, reason: str) -> None:
    assert AMC.count(old) == 1
    with pytest.raises(FormatError) as caught:
        read_amc(write_take(tmp_path, amc=AMC.replace(old, new)))
    assert reason in caught.value.reason
    assert caught.value.line == line


def test_motion_without_frames_or_text_is_reported(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"tester_01\.amc:1: the file has no frames"):
        read_amc(write_take(tmp_path, amc=":DEGREES\n"))
    with pytest.raises(FormatError, match=r"tester_01\.amc:1: the file is empty"):
        read_amc(write_take(tmp_path, amc=" \n"))
    with pytest.raises(FormatError, match=r"gone\.amc: cannot be read: No such file"):
        read_amc(tmp_path / "gone.amc")
