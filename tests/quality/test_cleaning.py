"""The clean-up on the CMU captures: flipped legs are turned back, clean takes come back as they are.

Swivel and positions are measured here with scipy, not with the package. The runs of `KNOWN_RUNS` are those the data's
own README lists; frames count from 0, the added T-pose.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mtex_usd.edit.cleaning import CLEANING_STEPS, clean_auto, clean_clip
from tests.captures import UNIT_M, load_with_t_pose

KNOWN_RUNS = {
    "05_05": [(323, 328), (333, 337)],
    "05_06": [(122, 128), (147, 156)],
    "05_08": [(133, 149), (156, 164)],
    "05_10": [(245, 253)],
}
FLIPPED = tuple(KNOWN_RUNS)
CLEAN = tuple(f"05_{number:02d}" for number in (1, 2, 3, 4, 7, 9, 11, 12)) + tuple(
    f"07_{number:02d}" for number in range(1, 12)
)
FOOT_STEPS = {"05_05": (329, 381, 865), "05_06": (122, 176), "05_08": (150, 180), "05_10": ()}


@cache
def cleaned(data_dir, name):
    clip = load_with_t_pose(data_dir, name)
    return clip, clean_auto(clip)


def index(clip, joint):
    return [path.rpartition("/")[2] for path in clip.joints].index(joint)


def places_in(clip, frame_joint, joints):
    """Positions in metres from, and in the frame of, another joint, by name, [F, 3] each."""
    world, positions = [], []
    for j, parent in enumerate(clip.parents):
        local = Rotation.from_quat(clip.rotations[:, j], scalar_first=True)
        world.append(local if parent < 0 else world[parent] * local)
        offset = clip.translations[:, j]
        positions.append(offset if parent < 0 else positions[parent] + world[parent].apply(offset))
    frame = index(clip, frame_joint)
    return {name: UNIT_M * world[frame].inv().apply(positions[index(clip, name)] - positions[frame]) for name in joints}


def measure_swivel(clip, side, run):
    """Swivel in degrees through a run with a frame on either side, and how far the knee is off the line, metres.

    Zero is carried along with the hip-ankle line from frame to frame by its shortest turn, in the pelvis' frame.
    """
    first, last = run
    names = [f"{side}{joint}" for joint in ("UpLeg", "Leg", "Foot")]
    hip, knee, ankle = (places[first - 1 : last + 2] for places in places_in(clip, "Hips", names).values())
    lines = (ankle - hip) / np.linalg.norm(ankle - hip, axis=1, keepdims=True)
    off = knee - hip - np.sum((knee - hip) * lines, axis=1, keepdims=True) * lines
    reference, angles = off[0], []
    for frame, line in enumerate(lines):
        if frame:
            turn = np.cross(lines[frame - 1], line)
            sine = np.linalg.norm(turn)
            reference = Rotation.from_rotvec(turn * (np.arcsin(sine) / max(sine, 1e-12))).apply(reference)
        angles.append(np.arctan2(np.dot(np.cross(reference, off[frame]), line), np.dot(reference, off[frame])))
    return np.degrees(np.unwrap(angles)), np.linalg.norm(off, axis=1)


def deviation_from_interpolation(clip, side, run):
    """Largest distance in degrees of the swivel from the line across the run, where the knee is 3 cm off."""
    swivel, off = measure_swivel(clip, side, run)
    line = np.linspace(swivel[0], swivel[-1], len(swivel))
    return float(np.abs(swivel - line)[off > 0.03].max())


def flipped_runs(clip, result):
    """Side and frames in the cleaned clip of every repair of a leg."""
    dropped = result.dropped_frames
    hips = [change for change in result.changes if change.joint.endswith("UpLeg")]
    return [("Right" if "Right" in c.joint else "Left", (c.first - dropped, c.last - dropped)) for c in hips]


@pytest.mark.parametrize("name", FLIPPED)
def test_knee_goes_straight_through_every_flipped_run(data_dir, name):
    raw, result = cleaned(data_dir, name)
    known = [("Right", (first - 1, last - 1)) for first, last in KNOWN_RUNS[name]]
    runs = flipped_runs(raw, result)
    assert set(known) <= set(runs)
    assert max(deviation_from_interpolation(result.clip, *run) for run in runs) < 20.0


@pytest.mark.parametrize("name", FLIPPED)
def test_known_runs_are_flipped_in_the_capture(data_dir, name):
    raw, _ = cleaned(data_dir, name)
    assert min(deviation_from_interpolation(raw, "Right", run) for run in KNOWN_RUNS[name]) > 60.0


@pytest.mark.parametrize("name", FLIPPED)
def test_no_jump_of_the_knee_is_left(data_dir, name):
    _, result = cleaned(data_dir, name)
    for side in ("Left", "Right"):
        knee = places_in(result.clip, "Hips", [f"{side}Leg"])[f"{side}Leg"]
        assert np.linalg.norm(np.diff(knee, axis=0), axis=1).max() < 0.1  # raw: 0.16 to 0.39


@pytest.mark.parametrize("name", FLIPPED)
def test_feet_stay_where_the_capture_has_them(data_dir, name):
    raw, result = cleaned(data_dir, name)
    feet = ["LeftFoot", "RightFoot"]
    before, after = places_in(raw, "Hips", feet), places_in(result.clip, "Hips", feet)
    for foot in feet:
        assert np.linalg.norm(before[foot][result.dropped_frames :] - after[foot], axis=1).max() < 1e-6


@pytest.mark.parametrize("name", FLIPPED)
def test_steps_of_the_foot_are_reported(data_dir, name):
    _, result = cleaned(data_dir, name)
    steps = [note.first for note in result.notes if note.step == "jumps" and "place" in note.what]
    assert steps == list(FOOT_STEPS[name])


@pytest.mark.parametrize("name", FLIPPED)
def test_all_else_keeps_its_bits(data_dir, name):
    raw, result = cleaned(data_dir, name)
    dropped = result.dropped_frames
    allowed = np.zeros(raw.rotations.shape[:2], dtype=bool)
    for change in result.changes[1:]:
        allowed[change.first : change.last + 1, raw.joints.index(change.joint)] = True
    differs = (raw.rotations[dropped:] != result.clip.rotations).any(axis=-1)
    assert not (differs & ~allowed[dropped:]).any()
    assert (raw.translations[dropped:] == result.clip.translations).all()


@pytest.mark.parametrize("name", FLIPPED)
def test_ankle_turns_smoothly_where_the_foot_did_not_step(data_dir, name):
    raw, result = cleaned(data_dir, name)
    feet = [change for change in result.changes if change.joint.endswith("RightFoot")]
    calm = [c for c in feet if not {c.first, c.last + 1} & set(FOOT_STEPS[name])]
    turns = Rotation.from_quat(result.clip.rotations[:, index(raw, "RightFoot")], scalar_first=True)
    steps = np.degrees((turns[:-1].inv() * turns[1:]).magnitude())
    for change in calm:
        assert steps[change.first - 2 : change.last + 1].max() < 12.0


@pytest.mark.parametrize("name", CLEAN)
def test_clean_takes_lose_the_leading_frame_only(data_dir, name):
    raw, result = cleaned(data_dir, name)
    assert [(change.step, change.first, change.last) for change in result.changes] == [("leading", 0, 0)]
    assert (result.clip.rotations == raw.rotations[1:]).all()
    assert (result.clip.translations == raw.translations[1:]).all()
    assert result.clip.start == 1.0


def test_junk_after_the_t_pose_is_leading_too(data_dir):
    _, result = cleaned(data_dir, "07_12")
    assert [(change.step, change.first, change.last) for change in result.changes] == [("leading", 0, 1)]


def test_a_second_run_changes_nothing(data_dir):
    for name in FLIPPED:
        _, result = cleaned(data_dir, name)
        assert clean_auto(result.clip).changes == ()


def test_no_step_runs_unless_asked_for(data_dir):
    raw, _ = cleaned(data_dir, "05_05")
    assert clean_clip(raw, ()).clip is raw
    assert [change.step for change in clean_clip(raw, ("leading",)).changes] == ["leading"]
    assert {change.step for change in clean_clip(raw, ("flips",)).changes} == {"flips"}


@pytest.mark.parametrize("step", sorted(set(CLEANING_STEPS) - {"leading", "noise"}))
def test_single_steps_leave_a_clean_take_alone(data_dir, step):
    _, result = cleaned(data_dir, "05_09")
    assert clean_clip(result.clip, (step,)).clip is result.clip


def keep_every(clip, step):
    """Leave out the frames between, as a capture at a lower rate has them, but not the leading T-pose."""
    kept = [0, *range(1, clip.frame_count, step)]
    arrays = {name: getattr(clip, name)[kept] for name in ("rotations", "translations", "scales")}
    return replace(clip, rate=clip.rate / step, **arrays)


@pytest.mark.parametrize("step", [2, 4, 5])
def test_clean_takes_are_clean_at_lower_rates(data_dir, step):
    for name in CLEAN:
        changes = clean_auto(keep_every(cleaned(data_dir, name)[0], step)).changes
        assert [(change.step, change.first, change.last) for change in changes] == [("leading", 0, 0)], name


@pytest.mark.parametrize("step", [2, 4, 5])
@pytest.mark.parametrize("name", FLIPPED)
def test_flips_are_repaired_at_lower_rates(data_dir, name, step):
    raw = keep_every(cleaned(data_dir, name)[0], step)
    result = clean_auto(raw)
    turned = np.zeros(raw.frame_count, dtype=bool)
    for change in result.changes[1:]:
        turned[change.first : change.last + 1] = True
    kept = np.array([0, *range(1, cleaned(data_dir, name)[0].frame_count, step)])
    for first, last in KNOWN_RUNS[name]:
        assert turned[(kept >= first) & (kept <= last)].all()
    assert not [note for note in result.notes if note.step == "flips"]
