"""Contacts moved: a step moves in time and space, all else stays, and the session layer alone changes."""

import numpy as np
import pytest
from pxr import Sdf, Usd

import mtex_usd
from mtex_usd.constraints.kinematics import place_points
from mtex_usd.constraints.planting.steps import prepare_steps
from mtex_usd.errors import InputError, StageError
from mtex_usd.usd.contact_edits import author_motion, keep_specs, put_back, read_motions
from mtex_usd.usd.variants import find_sets, select_path
from tests.usdview.walk import MESH, OUTPUT, SKELETON, STEP, copy_walk, joint_places, read_one, rotations

CM = 0.01


@pytest.fixture
def stage(walk):
    return Usd.Stage.Open(str(walk))


def test_heel_and_toes_are_one_step(prepared):
    _, mover = prepared
    assert [step.name for step in mover.steps][:4] == ["left.heel, left.toes", "right.heel, right.toes"] * 2
    firsts = [step.first for step in mover.steps]
    assert firsts == sorted(firsts)
    assert all(step.first <= step.last < after.last for step, after in zip(mover.steps, mover.steps[2:], strict=False))


def test_getting_ready_changes_no_bit(prepared):
    motion, mover = prepared
    np.testing.assert_array_equal(mover.solution.clips[0].rotations, motion.clip.rotations)


def points_of(hold, clip):
    poses = (clip.rotations[hold.frames], clip.translations[hold.frames])
    return place_points(clip.skeleton, [hold.joint], np.asarray(hold.offset)[None], *poses)[:, 0]


@pytest.mark.parametrize(
    ("by", "shift"), [((0, 10, 0), 0), ((6, 0, 0), 0), ((0, 0, 8), -2), ((0, 0, 0), 3), ((0, 4, 5), 2)]
)
def test_a_moved_step_stands_where_it_was_put_and_the_others_where_they_were(prepared, by, shift):
    motion, mover = prepared
    step = mover.steps[STEP]
    moved = mover.move(STEP, by=by, first=step.first + shift, last=step.last + shift)
    for hold in step.holds:
        (now,) = [each for each in moved.holds if each.name == hold.name]
        assert (now.first, now.last) == (hold.first + shift, hold.last + shift)
        expected = points_of(hold, motion.clip) + by
        assert np.abs(points_of(now, moved.clip) - expected).max() * CM < 5e-4
    for other in (step for i, step in enumerate(mover.steps) if i != STEP):
        for hold in other.holds:
            assert np.abs(points_of(hold, moved.clip) - points_of(hold, motion.clip)).max() * CM < 5e-4
    changed = np.flatnonzero((moved.clip.rotations != motion.clip.rotations).any(axis=(1, 2)))
    assert step.first - 20 < changed[0] < step.last + shift
    assert changed[-1] < step.last + 20


def test_a_step_made_shorter_and_longer_stays_a_foot(prepared):
    """Heel and toes are read at the same moments, or the shoe would have to change its length."""
    _, mover = prepared
    step = mover.steps[STEP]
    for first, last in ((step.first + 4, step.last), (step.first, step.last + 3), (step.first + 2, step.first + 2)):
        moved = mover.move(STEP, first=first, last=last)
        now = [hold for hold in moved.holds if hold.name in {each.name for each in step.holds}]
        assert min(hold.first for hold in now) == first
        assert max(hold.last for hold in now) == last
        for hold in now:
            assert np.abs(points_of(hold, moved.clip) - hold.places).max() * CM < 5e-4


def test_moves_start_from_where_the_step_was_given(prepared):
    _, mover = prepared
    step = mover.steps[STEP]
    once = mover.move(STEP, by=(0, 5, 0), first=step.first, last=step.last)
    mover.move(STEP, by=(8, 0, 0), first=step.first, last=step.last)
    again = mover.move(STEP, by=(0, 5, 0), first=step.first, last=step.last)
    np.testing.assert_array_equal(once.clip.rotations, again.clip.rotations)


def test_impossible_places_and_times_are_refused(prepared):
    _, mover = prepared
    step = mover.steps[STEP]
    with pytest.raises(
        InputError, match=r"cannot be moved so far; expected at most [\d.]+, the size of the body; found 300"
    ):
        mover.move(STEP, by=(0, 300, 0), first=step.first, last=step.last)
    after = mover.steps[STEP + 2]
    with pytest.raises(InputError, match=rf"apart from {after.first} to {after.last}, when it stands elsewhere"):
        mover.move(STEP, first=step.first, last=after.first)
    with pytest.raises(InputError, match=r"cannot be held then; expected frames in order from 0 to 170; found 9 to 3"):
        mover.move(STEP, first=9, last=3)


def test_a_motion_without_contacts_has_none_to_move(prepared):
    with pytest.raises(InputError, match="has no contact to move"):
        prepare_steps(prepared[0].clip, ())


# --- what stands on the stage ---


def test_what_is_authored_composes_in_its_variant_alone(stage, prepared):
    motion, mover = prepared
    before = rotations(stage)
    step = mover.steps[STEP]
    moved = mover.move(STEP, by=(0, 10, 0), first=step.first, last=step.last)
    author_motion(stage, motion, moved.clip, moved.holds)
    raised = joint_places(stage, "RightFoot", [step.first, step.last])
    (found,) = find_sets(stage)
    select_path(stage, found, "path_02")
    other = rotations(stage)
    select_path(stage, found, "path_01")
    assert (rotations(stage) != before).any()
    assert (other != rotations(stage)).any()
    put_back(stage, motion, Sdf.Layer.CreateAnonymous())
    np.testing.assert_array_equal(rotations(stage), before)
    lifted = raised - joint_places(stage, "RightFoot", [step.first, step.last])
    np.testing.assert_allclose(lifted[:, 1], 10.0, atol=0.6)


def test_joints_off_the_legs_keep_their_bits(stage, prepared):
    motion, mover = prepared
    step = mover.steps[STEP]
    moved = mover.move(STEP, by=(0, 10, 0), first=step.first, last=step.last)
    before = rotations(stage)
    author_motion(stage, motion, moved.clip, moved.holds)
    changed = (rotations(stage) != before).any(axis=(0, 2))
    joints = stage.GetPrimAtPath(OUTPUT).GetAttribute("joints").Get()
    names = {joint.rpartition("/")[2] for joint, was in zip(joints, changed, strict=True) if was}
    assert "RightLeg" in names
    assert not names & {"Head", "LeftForeArm", "RightHand", "Spine1"}


def test_the_edit_is_read_back_with_its_contacts(stage, prepared):
    motion, mover = prepared
    step = mover.steps[STEP]
    moved = mover.move(STEP, by=(0, 10, 0), first=step.first + 1, last=step.last + 1)
    author_motion(stage, motion, moved.clip, moved.holds)
    again = read_one(stage, SKELETON)
    np.testing.assert_allclose(again.clip.rotations, moved.clip.rotations, atol=1e-6)
    assert [(hold.name, hold.first, hold.last) for hold in again.holds] == [
        (hold.name, hold.first, hold.last) for hold in moved.holds
    ]
    rank = stage.GetPrimAtPath(OUTPUT).GetCustomDataByKey("mtex")["rank"]
    assert rank == 1


def test_putting_back_leaves_what_others_authored(stage, prepared):
    motion, _ = prepared
    session = stage.GetSessionLayer()
    (found,) = find_sets(stage)
    empty = session.ExportToString()
    before = keep_specs(stage)
    author_motion(stage, motion, motion.clip, motion.holds)
    put_back(stage, motion, before)
    assert session.ExportToString() == empty
    author_motion(stage, motion, motion.clip, motion.holds)
    select_path(stage, found, "path_02")
    put_back(stage, motion, before)
    assert dict(session.GetPrimAtPath("/Humanoid").variantSelections.items()) == {"mtex": "path_02"}
    assert not session.GetPrimAtPath("/Humanoid").variantSets


def test_an_animation_without_paths_is_edited_in_the_session_layer(walk):
    stage = Usd.Stage.Open(str(walk.with_name("walk.usda")))
    motion = read_one(stage, "/Humanoid")
    assert motion.spec_path == Sdf.Path("/Humanoid/Sketch")
    before = keep_specs(stage)
    author_motion(stage, motion, motion.clip, motion.holds)
    assert not stage.GetRootLayer().dirty
    assert stage.GetSessionLayer().GetPrimAtPath("/Humanoid/Sketch")
    put_back(stage, motion, before)
    assert not stage.GetSessionLayer().GetPrimAtPath("/Humanoid")


def test_declared_contacts_come_before_found_ones(walk):
    stage = Usd.Stage.Open(str(walk))
    source = stage.GetPrimAtPath("/Humanoid/Sketch")
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        source.AddAppliedSchema("MtexContactAPI:knob")
        source.CreateAttribute("mtex:contact:knob:joint", Sdf.ValueTypeNames.Token, custom=False).Set("RightHand")
        source.CreateAttribute("mtex:contact:knob:intervals", Sdf.ValueTypeNames.TimeCodeArray, custom=False).Set(
            Sdf.TimeCodeArray([Sdf.TimeCode(40.0), Sdf.TimeCode(44.0)])
        )
    motion = read_one(stage, MESH)
    assert [(hold.name, hold.first, hold.last) for hold in motion.holds] == [("knob 1", 40, 44)]


def test_contacts_that_the_variant_records_come_first(tmp_path):
    shot = copy_walk(tmp_path)
    text = shot.read_text().replace(
        "uniform token[] mtex:match", 'uniform token mtex:contacts = "detect"\n        uniform token[] mtex:match', 1
    )
    shot.write_text(text)
    (result,) = mtex_usd.process(shot, paths=1)
    motion = read_one(Usd.Stage.Open(str(result.stage)), MESH)
    recorded = result.variants[0].custom_data["contacts"]
    assert [hold.name for hold in motion.holds] == [contact["name"] for contact in recorded]
    assert [motion.clip.time_codes[hold.first] for hold in motion.holds] == [each["start"] for each in recorded]


def test_a_session_that_counts_otherwise_places_the_samples_right(walk, prepared, tmp_path):
    from mtex_usd.usd.accepting import accept_paths

    stage = Usd.Stage.Open(str(walk))
    stage.GetSessionLayer().timeCodesPerSecond = 48.0
    motion = read_one(stage, MESH)
    times = [float(each) for each in motion.clip.time_codes[[0, 40, 90]]]
    before = joint_places(stage, "RightHand", times)
    author_motion(stage, motion, motion.clip, motion.holds)
    np.testing.assert_allclose(joint_places(stage, "RightHand", times), before, atol=1e-4)
    accept_paths(stage, find_sets(stage), tmp_path / "accepted.usda")
    accepted = Usd.Stage.Open(str(tmp_path / "accepted.usda"))
    seconds = stage.GetTimeCodesPerSecond() / accepted.GetTimeCodesPerSecond()
    again = joint_places(accepted, "RightHand", [time / seconds for time in times])
    np.testing.assert_allclose(again, before, atol=1e-4)


def test_no_contact_found_and_instances_are_said(processed, tmp_path):
    from tests.usd.base_situations import build_instanceable

    stage = Usd.Stage.Open(str(processed))
    with pytest.raises(InputError, match=r"no contact was found|expected joints named"):
        read_motions(stage, [stage.GetPrimAtPath("/World/Other")])
    stage = Usd.Stage.Open(str(build_instanceable(tmp_path, "Skeleton").shot))
    with pytest.raises(StageError, match="lies inside an instance, where nothing can be edited"):
        read_motions(stage, [stage.GetPrimAtPath("/World/Char/Rig/Skel")])
