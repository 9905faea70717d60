"""Blending and joining: known cases and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.edit import Displacement, PoseChange, Transition, blend, displace, join, scale_time
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.motion.timing import resample_clip
from tests.synthetic import JOINTS, LEFT_LEG, on_joints, turned, walk


def leaning(degrees, frames=20):
    clip = walk(frames)
    rotations = np.tile(clip.skeleton.rest_rotations, (frames, 1, 1))
    rotations[:, JOINTS.index(LEFT_LEG)] = quaternion.exp(np.radians([degrees, 0.0, 0.0]))
    return replace(clip, rotations=rotations)


def cut(clip, first, last):
    names = ("rotations", "translations", "scales")
    return replace(clip, **{name: getattr(clip, name)[first : last + 1] for name in names})


class TestBlend:
    @pytest.mark.parametrize(("weight", "expected"), [(0.5, 20.0), (1.5, 40.0), (-0.5, 0.0), (3.0, 70.0)])
    def test_goes_between_and_beyond(self, weight, expected):
        mixed = blend(leaning(10.0), leaning(30.0), weights=weight).clip
        np.testing.assert_allclose(
            np.degrees(quaternion.log(mixed.rotations)[:, JOINTS.index(LEFT_LEG), 0]), expected, atol=1e-9
        )

    def test_turns_past_half_a_turn_do_not_flip(self):
        """Apart by 170 to 190 degrees: what is half way stays half way."""
        clip = leaning(0.0, 21)
        rotations = np.array(clip.rotations)
        apart = np.radians(np.linspace(170.0, 190.0, 21))
        rotations[:, JOINTS.index(LEFT_LEG)] = quaternion.exp(apart[:, None] * np.array([1.0, 0.0, 0.0]))
        mixed = blend(clip, replace(clip, rotations=rotations), weights=0.5).clip
        steps = quaternion.angle_between(mixed.rotations[1:], mixed.rotations[:-1])
        assert np.degrees(steps.max()) < 0.6

    def test_walks_that_go_different_ways_give_one_between(self):
        ahead, aside = walk(40, seed=1, heading=0.0), walk(40, seed=1, heading=60.0)
        mixed = blend(ahead, aside, weights=0.5).clip
        way = mixed.translations[-1, 0] - mixed.translations[0, 0]
        assert np.degrees(np.arctan2(way[0], way[2])) == pytest.approx(30.0, abs=2.0)
        lengths = [np.linalg.norm(np.diff(each.translations[:, 0], axis=0), axis=1).sum() for each in (ahead, mixed)]
        assert lengths[1] == pytest.approx(lengths[0], rel=0.02)

    def test_begins_where_it_is_told(self):
        clip, other = walk(40, seed=1), walk(40, seed=2)
        other = replace(other, translations=other.translations + np.array([100.0, 0.0, 0.0]))
        mean, first = (blend(clip, other, weights=0.5, place=place).clip for place in ("mean", "first"))
        gap = mean.translations[0, 0, 0] - first.translations[0, 0, 0]
        np.testing.assert_allclose(gap, 0.5 * (other.translations[0, 0, 0] - clip.translations[0, 0, 0]))
        assert first.translations[0, 0, 0] == pytest.approx(clip.translations[0, 0, 0])

    def test_weights_may_change_over_time_for_many(self):
        motions = [walk(30, seed=seed) for seed in range(3)]
        weights = np.random.default_rng(0).uniform(-0.2, 0.6, (30, 2))
        result = blend(motions[0], motions[1:], weights=weights)
        np.testing.assert_array_equal(result.weights[:, 1:], weights)
        np.testing.assert_allclose(result.weights.sum(axis=1), 1.0)

    def test_aligned_first_it_has_the_clips_time(self):
        clip, other = walk(60, seed=1), walk(80, seed=1, stride_hz=0.7)
        result = blend(clip, other, weights=0.5, align_first=True)
        assert result.clip.frame_count == 60

    def test_poses_far_apart_are_noted(self):
        clip = walk(40, seed=1, leg=50.0)
        other = walk(40, seed=1, leg=-50.0)
        result = blend(clip, other, weights=0.5)
        assert result.distances.max() > 0.2
        assert "the poses are up to" in str(result.notes[0])
        assert result.distances[result.notes[0].first] > 0.2
        assert not blend(clip, other, weights=0.0).notes

    def test_a_root_below_other_joints_is_placed_in_space(self):
        """A joint above the hips that is turned on its side: the blend moves the hips over the same floor."""
        clip, other = walk(30, seed=1), walk(30, seed=2, heading=40.0)
        joints = ("World", *(f"World/{joint}" for joint in JOINTS))
        turn = quaternion.exp(np.radians([90.0, 0.0, 0.0]))

        def below(motion):
            rest = np.concatenate([np.eye(4)[None], motion.skeleton.rest])
            rotations = np.concatenate([np.tile(turn, (30, 1, 1)), motion.rotations], axis=1)
            rotations[:, 1] = quaternion.multiply(quaternion.conjugate(turn), motion.rotations[:, 0])
            translations = np.concatenate([np.zeros((30, 1, 3)), motion.translations], axis=1)
            translations[:, 1] = quaternion.rotate(quaternion.conjugate(turn), motion.translations[:, 0])
            return Clip(
                skeleton=Skeleton(joints=joints, rest=rest),
                rate=24.0,
                rotations=rotations,
                translations=translations,
                scales=np.ones_like(translations),
            )

        plain = blend(clip, other, weights=0.4).clip
        lower = blend(below(clip), below(other), weights=0.4).clip
        places = [
            each.skeleton.world_pose(each.rotations, each.translations)[0][:, -len(JOINTS) :] for each in (plain, lower)
        ]
        np.testing.assert_allclose(places[1], places[0], atol=1e-6)

    @pytest.mark.parametrize(
        ("others", "weights", "found"),
        [
            (1, [0.1, 0.2], r"shape \(2,\)"),
            (2, 0.5, r"shape \(\)"),
            (2, [0.1, 0.2, 0.3], r"shape \(3,\)"),
            (2, np.zeros((20, 3)), r"shape \(20, 3\)"),
            (1, np.nan, "nan"),
            (1, 1e9, r"1e\+09"),
        ],
    )
    def test_refuses_weights_that_do_not_fit(self, others, weights, found):
        with pytest.raises(InputError, match=f"weights do not fit.*found {found}"):
            blend(walk(20), [walk(20, seed=k) for k in range(others)], weights=weights)

    def test_refuses_other_lengths(self):
        with pytest.raises(InputError, match="is not as long as /Take; expected 20 frames; found 25"):
            blend(walk(20), walk(25), weights=0.5)

    def test_refuses_other_joints(self):
        clip = walk(20)
        with pytest.raises(InputError, match="are not on the same joints; expected 11 joints in one order; found 5"):
            blend(clip, on_joints(clip, JOINTS[:5]), weights=0.5)

    def test_refuses_other_rates(self):
        with pytest.raises(InputError, match="have different rates"):
            blend(walk(20), resample_clip(walk(20), 30.0), weights=0.5)

    def test_refuses_no_other_and_no_place(self):
        with pytest.raises(InputError, match="nothing to blend /Take with"):
            blend(walk(20), [], weights=[])
        with pytest.raises(InputError, match="unknown place; expected mean or first; found 'last'"):
            blend(walk(20), walk(20), weights=0.5, place="last")


class TestJoin:
    def test_shared_frames_are_joined_without_a_trace(self):
        whole = walk(100, seed=3)
        result = join(cut(whole, 0, 60), turned(cut(whole, 30, 99), 90.0))
        assert result.method == "blend"
        assert result.clip.frame_count == 100
        assert quaternion.angle_between(result.clip.rotations[:, 1:], whole.rotations[:, 1:]).max() < 1e-6

    def test_goes_on_where_and_as_it_faced(self):
        one, other = walk(60, seed=3, heading=0.0), walk(60, seed=4, heading=120.0)
        result = join(one, other)
        way = result.clip.translations[-1, 0] - result.clip.translations[result.last, 0]
        assert abs(np.degrees(np.arctan2(way[0], way[2]))) < 8.0
        steps = np.linalg.norm(np.diff(result.clip.translations[:, 0], axis=0), axis=1)
        sources = [np.linalg.norm(np.diff(each.translations[:, 0], axis=0), axis=1).max() for each in (one, other)]
        assert steps.max() < 1.2 * max(sources)

    def test_nowhere_alike_is_interpolated_from_end_to_beginning(self):
        calm = walk(40, seed=3)
        change = PoseChange(frame=0, rotations={"Spine": (60.0, 0.0, 0.0), "LeftArm": (0.0, 0.0, 80.0)})
        wild = displace(walk(30, seed=4), Displacement(keys=[change]))
        result = join(calm, wild)
        assert result.method == "interpolate"
        assert (result.transition.frame, result.transition.other_frame) == (39, 0)
        np.testing.assert_array_equal(result.clip.rotations[:40], calm.rotations)
        np.testing.assert_array_equal(result.clip.rotations[result.last + 1 :, 1:], wild.rotations[:, 1:])
        assert not result.notes

    def test_what_turns_too_fast_all_the_same_is_noted(self):
        still, bent = leaning(0.0), leaning(0.0)
        rotations = np.array(bent.rotations)
        rotations[:, JOINTS.index(LEFT_LEG)] = quaternion.exp(
            np.radians(np.linspace(150.0, 151.0, 20))[:, None] * np.array([1.0, 0.0, 0.0])
        )
        result = join(still, replace(bent, rotations=rotations), method="interpolate")
        assert [note.joint for note in result.notes] == [LEFT_LEG]
        assert "times as fast as anywhere in the two motions" in result.notes[0].what

    def test_a_closed_loop_goes_round_smoothly(self):
        clip = walk(90, seed=3, detail=0.0)
        cycle = join(clip, clip).clip
        long = scale_time(cycle, factor=1.0, frame_count=4 * cycle.frame_count, ends="loop")
        fastest = [
            quaternion.angle_between(each.rotations[1:], each.rotations[:-1]).max(axis=0) for each in (clip, long)
        ]
        assert (fastest[1] <= 1.2 * fastest[0] + 1e-9).all()
        steps = np.linalg.norm(np.diff(long.translations[:, 0], axis=0), axis=1)
        assert steps.max() < 1.3 * np.linalg.norm(np.diff(clip.translations[:, 0], axis=0), axis=1).max()

    def test_leaves_and_enters_where_it_is_told(self):
        clip, other = walk(60, seed=3), walk(60, seed=4)
        given = Transition(frame=30, other_frame=20, distance=0.0)
        result = join(clip, other, transition=given, blend_s=0.25)
        assert result.clip.frame_count == 30 + 60 - 20
        assert result.transition == given

    @pytest.mark.parametrize(("frame", "other_frame"), [(1, 30), (30, 1), (59, 30), (30, 59)])
    def test_refuses_a_transition_without_room(self, frame, other_frame):
        with pytest.raises(InputError, match="no room for the transition"):
            join(
                walk(60),
                walk(60, seed=1),
                transition=Transition(frame=frame, other_frame=other_frame, distance=0.0),
                method="blend",
            )

    @pytest.mark.parametrize(("frame", "other_frame", "found"), [(70, 30, "70"), (30, -5, "-5"), (3.5, 30, "3.5")])
    def test_refuses_a_transition_at_no_frame(self, frame, other_frame, found):
        at = Transition(frame=frame, other_frame=other_frame, distance=0.0)
        with pytest.raises(InputError, match=f"bad transition.*expected a whole number, 0 to 59; found {found}"):
            join(walk(60), walk(60, seed=1), transition=at)

    def test_refuses_an_unknown_method_and_an_empty_window(self):
        with pytest.raises(InputError, match="unknown method; expected auto or blend or interpolate; found 'cut'"):
            join(walk(60), walk(60, seed=1), method="cut")
        with pytest.raises(InputError, match="bad window; expected a window above 0 seconds"):
            join(walk(60), walk(60, seed=1), blend_s=0.0)
