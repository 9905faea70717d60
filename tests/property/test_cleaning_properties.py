"""Laws of the clean-up on random flips, gaps and spikes."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mtex_usd.edit.cleaning import CLEANING_STEPS, clean_clip, fill_gaps, repair_flips, repair_spikes
from mtex_usd.edit.cleaning.flips import find_flips
from mtex_usd.motion import quaternion
from tests.cleaning_support import chain_of, changed_frames, flip, make_walk, positions, turn_joint
from tests.oracle import flips as oracle
from tests.synthetic import LEFT_ARM, LEFT_KNEE, LEFT_LEG, RIGHT_ARM, RIGHT_LEG, turned

UPPERS = st.sampled_from([LEFT_LEG, RIGHT_LEG, LEFT_ARM, RIGHT_ARM])


@st.composite
def flipped_clips(draw):
    clip = make_walk(200, seed=draw(st.integers(0, 5)), oriented=draw(st.sampled_from([None, 1, 2])))
    upper = draw(UPPERS)
    first = draw(st.integers(20, 160))
    last = first + draw(st.integers(0, 15))
    degrees = draw(st.floats(150.0, 210.0))
    return clip, flip(clip, upper, first, last, degrees), upper, first, last


@settings(max_examples=40)
@given(flipped_clips())
def test_limb_ends_never_move_and_only_the_run_changes(case):
    _, flipped, upper, first, last = case
    result = repair_flips(flipped)
    end = chain_of(flipped, upper)[2]
    assert np.abs(positions(flipped)[:, end] - positions(result.clip)[:, end]).max() < 1e-8
    changed = changed_frames(flipped, result.clip).any(axis=1)
    assert set(np.flatnonzero(changed)) == set(range(first, last + 1))


@settings(max_examples=40)
@given(flipped_clips())
def test_the_middle_comes_back_near_where_it_was(case):
    clip, flipped, upper, _, _ = case
    middle = chain_of(clip, upper)[1]
    repaired = positions(repair_flips(flipped).clip)[:, middle]
    assert np.linalg.norm(positions(clip)[:, middle] - repaired, axis=-1).max() < 2.0


@settings(max_examples=20)
@given(flipped_clips(), st.floats(-180.0, 180.0))
def test_the_way_the_character_faces_makes_no_difference(case, heading):
    _, flipped, *_ = case
    here, there = repair_flips(flipped), repair_flips(turned(flipped, heading))
    assert [(c.joint, c.first, c.last) for c in here.changes] == [(c.joint, c.first, c.last) for c in there.changes]


@settings(max_examples=20)
@given(flipped_clips())
def test_repairing_twice_is_repairing_once(case):
    once = repair_flips(case[1]).clip
    assert repair_flips(once).clip is once


@settings(max_examples=30)
@given(st.integers(5, 190), st.integers(0, 2), st.floats(70.0, 170.0), st.integers(0, 3))
def test_spikes_are_found_where_they_are(first, more, degrees, seed):
    clip = make_walk(200, seed=seed)
    result = repair_spikes(turn_joint(clip, LEFT_KNEE, first, first + more, degrees))
    assert [(c.first, c.last) for c in result.changes] == [(first, first + more)]
    assert np.degrees(quaternion.angle_between(clip.rotations, result.clip.rotations)).max() < 20.0


@settings(max_examples=30)
@given(st.sets(st.integers(0, 99), min_size=1, max_size=60), st.integers(0, 10))
def test_filled_gaps_are_unit_quaternions_and_all_else_keeps_its_bits(frames, joint):
    clip = make_walk(100)
    rotations = np.array(clip.rotations)
    rotations[sorted(frames), joint] = np.nan
    filled = fill_gaps(replace(clip, rotations=rotations)).clip
    assert np.abs(np.linalg.norm(filled.rotations, axis=-1) - 1.0).max() < 1e-9
    changed = changed_frames(clip, filled)
    changed[sorted(frames), joint] = False
    assert not changed.any()


@settings(max_examples=15)
@given(st.sampled_from(sorted(CLEANING_STEPS)), st.integers(0, 100))
def test_no_step_touches_its_input(step, seed):
    clip = flip(make_walk(100, seed=seed), LEFT_LEG, 50, 55)
    before = clip.rotations.copy(), clip.translations.copy()
    clean_clip(clip, (step,))
    assert (clip.rotations == before[0]).all()
    assert (clip.translations == before[1]).all()


@settings(max_examples=60)
@given(
    st.lists(st.sampled_from([0.0, 0.1, 0.3, 2.9, 3.1, -3.0, -0.2, 1.6]), min_size=2, max_size=10),
    st.sampled_from([24.0, 120.0]),
    st.integers(1, 6),
)
def test_the_runs_chosen_are_the_cheapest_of_all(angles, rate, longest):
    steps = [0.0, *(abs((b - a + np.pi) % (2.0 * np.pi) - np.pi) for a, b in pairwise(angles))]
    jumps = [step > 1.0 for step in steps]
    runs = find_flips(np.array(angles), np.array(jumps), rate, longest_s=(longest + 0.5) / rate)
    flipped = [any(first <= frame <= last for first, last in runs) for frame in range(len(angles))]
    found = oracle.cost_of(flipped, angles, jumps, rate, longest)
    assert np.isclose(found, oracle.least_cost(angles, jumps, rate, longest))
