"""Aligning motions and finding transitions: known cases and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.edit import align, find_transition, warp_time
from mtex_usd.edit.dynamic_warping import find_path
from mtex_usd.errors import InputError
from mtex_usd.motion.timing import resample_clip
from tests.synthetic import HIPS, LEFT_LEG, RIGHT_LEG, make_skeleton, on_joints, turned, walk


class TestAlign:
    def test_what_comes_late_is_found_late(self):
        clip = walk(60, seed=3)
        late = warp_time(clip, pairs=[(0, 0), (30, 36), (59, 59)])
        found = align(clip, late)
        assert abs(np.interp(30.0, found.pairs[:, 0], found.pairs[:, 1]) - 36.0) < 1.0

    @pytest.mark.parametrize("channels", [[LEFT_LEG, RIGHT_LEG], ["*Leg.rx", f"{HIPS}.t"]])
    def test_channels_alone_tell_it_too(self, channels):
        clip = walk(60, seed=3)
        late = warp_time(clip, pairs=[(0, 0), (30, 36), (59, 59)])
        found = align(clip, late, channels=channels)
        assert abs(np.interp(30.0, found.pairs[:, 0], found.pairs[:, 1]) - 36.0) < 1.0

    def test_ends_left_free_are_skipped(self):
        clip = walk(80, seed=3)
        part = replace(
            clip, rotations=clip.rotations[10:], translations=clip.translations[10:], scales=clip.scales[10:]
        )
        found = align(clip, part, free_s=0.5)
        np.testing.assert_allclose(found.pairs[:, 0] - found.pairs[:, 1], 10.0, atol=0.6)
        assert found.cost < 0.01 < align(clip, part).cost

    def test_other_joint_orders_and_orientations_do_not_matter(self):
        clip = walk(40, seed=3)
        twin = on_joints(clip, tuple(sorted(clip.joints)))
        assert align(clip, twin).cost < 1e-9

    def test_two_frames(self):
        found = align(walk(2), walk(2, seed=5))
        np.testing.assert_array_equal(found.pairs, [[0.0, 0.0], [1.0, 1.0]])

    def test_refuses_lengths_too_different(self):
        with pytest.raises(
            InputError, match="cannot be aligned with /Take; expected lengths that differ at most 2 times"
        ):
            align(walk(20), walk(60), max_slope=2)

    def test_refuses_other_rates(self):
        with pytest.raises(InputError, match="have different rates; expected 24 frames/s; found 30 frames/s"):
            align(walk(20), resample_clip(walk(20), 30.0))

    def test_refuses_a_single_frame(self):
        with pytest.raises(InputError, match="is too short; expected at least 2 frames"):
            align(walk(1), walk(20))

    def test_refuses_skeletons_that_share_nothing(self):
        strange = make_skeleton(("Box",), positions={"Box": (0.0, 0.0, 0.0)})
        clip = walk(20)
        other = replace(
            clip,
            skeleton=strange,
            rotations=clip.rotations[:, :1],
            translations=clip.translations[:, :1],
            scales=clip.scales[:, :1],
        )
        with pytest.raises(InputError, match="have no joint in common"):
            align(clip, other)

    def test_refuses_channels_that_only_one_has(self):
        clip = walk(20)
        other = on_joints(clip, clip.joints[:6])
        with pytest.raises(InputError, match="the channels are not the same on both motions"):
            align(clip, other, channels=["*Arm"])

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            ({"max_slope": 0}, "bad max_slope; expected a whole number, 1 to 100; found 0"),
            ({"band_s": 0.0}, "bad band_s; expected seconds above 0; found 0"),
            ({"free_s": -1.0}, "bad free_s"),
            ({"free_s": 10.0}, "bad free_s"),
        ],
    )
    def test_refuses_numbers_out_of_range(self, options, message):
        with pytest.raises(InputError, match=message):
            align(walk(20), walk(20, seed=1), **options)


def test_a_path_keeps_to_its_band_and_slopes():
    rng = np.random.default_rng(0)
    distances = rng.uniform(0.0, 1.0, (50, 60))
    path = find_path(lambda row, begin, end: distances[row, begin:end], (50, 60), band=6, steepest=2)
    off = path.cells[:, 1] - np.round(path.cells[:, 0] * 59.0 / 49.0)
    assert np.abs(off).max() <= 6
    steps = np.diff(path.cells, axis=0)
    straight = (steps == 1).all(axis=1)
    assert (straight[:-1] | straight[1:]).all()  # never two in a row along one motion alone: slopes from 1/2 to 2


def test_memory_grows_with_the_band_only():
    """Rows ask for the distances of their band, nothing else."""
    asked = []

    def distances(row, begin, end):
        asked.append(end - begin)
        return np.zeros(end - begin)

    find_path(distances, (300, 300), band=5, steepest=3)
    assert max(asked) == 11


class TestFindTransition:
    def test_finds_the_frames_two_motions_share(self):
        clip = walk(80, seed=3)
        part = replace(
            clip, rotations=clip.rotations[30:], translations=clip.translations[30:], scales=clip.scales[30:]
        )
        other = turned(part, 75.0)
        found = find_transition(clip, other)
        assert found.distance < 0.01
        assert found.frame - found.other_frame == 30

    def test_looks_where_it_is_told(self):
        clip, other = walk(80, seed=3), walk(80, seed=4)
        found = find_transition(clip, other, frames=(50, 60), other_frames=(10, 30))
        assert 50 <= found.frame <= 60
        assert 10 <= found.other_frame <= 30

    def test_a_loop_of_sines_is_a_stride(self):
        found = find_transition(clip := walk(90, seed=3, detail=0.0), clip)
        assert (found.frame - found.other_frame) / 24.0 == pytest.approx(1.0 / 0.9, abs=0.15)

    @pytest.mark.parametrize("window", [0.0, -1.0, np.nan])
    def test_refuses_an_empty_window(self, window):
        with pytest.raises(InputError, match="bad window; expected a window above 0 seconds"):
            find_transition(walk(30), walk(30), window_s=window)

    def test_refuses_a_window_longer_than_the_motion(self):
        with pytest.raises(InputError, match=r"no frame of /Take is left to look at.*found the whole clip"):
            find_transition(walk(30), walk(5), window_s=0.4)

    def test_refuses_an_empty_range(self):
        with pytest.raises(InputError, match=r"no frame of /Take is left to look at.*found 20 to 10"):
            find_transition(walk(30), walk(30), frames=(20, 10))

    def test_refuses_a_loop_that_is_too_short(self):
        clip = walk(18)
        with pytest.raises(InputError, match="/Take has no loop in the range; expected frames to leave at least 12"):
            find_transition(clip, clip)
