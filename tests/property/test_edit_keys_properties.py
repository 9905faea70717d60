"""Laws of key reduction on random motion: within the tolerance everywhere, nothing else touched."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mtex_usd.edit import reduce_keys, reduce_poses
from mtex_usd.motion import quaternion
from tests.cleaning_support import add_noise
from tests.oracle import edit_keys as oracle
from tests.synthetic import walk


@st.composite
def clips(draw):
    clip = walk(draw(st.integers(2, 40)), seed=draw(st.integers(0, 999)), rate=draw(st.sampled_from([24.0, 60.0])))
    return add_noise(clip, draw(st.sampled_from([0.0, 0.3, 3.0])), seed=draw(st.integers(0, 9)))


@settings(max_examples=25)
@given(clips(), st.floats(0.05, 5.0), st.floats(0.001, 0.1), st.sampled_from([reduce_keys, reduce_poses]))
def test_rotations_stay_within_the_tolerance_at_sub_frames(clip, degrees, metres, reduce):
    reduced = reduce(clip, tolerance_deg=degrees, tolerance_m=metres)
    assert reduced.max_degrees <= degrees * (1.0 + 1e-9)
    assert reduced.max_metres <= metres * (1.0 + 1e-9)
    times = np.arange(4 * clip.frame_count - 3) / 4.0
    found = reduced.evaluate(per_frame=4)
    for joint in range(len(clip.joints)):
        expected = oracle.play_rotations(np.arange(clip.frame_count), clip.rotations[:, joint], times)
        assert oracle.angles_between(expected, found.rotations[:, joint]).max() <= degrees + 1e-5


@settings(max_examples=25)
@given(clips(), st.sets(st.integers(0, 39), max_size=4), st.sampled_from([reduce_keys, reduce_poses]))
def test_contacts_and_ends_are_exact(clip, contacts, reduce):
    contacts = sorted(frame for frame in contacts if frame < clip.frame_count)
    again = reduce(clip, tolerance_deg=5.0, tolerance_m=0.1, contact_frames=contacts).evaluate()
    for frame in {0, clip.frame_count - 1, *contacts}:
        assert np.degrees(quaternion.angle_between(clip.rotations[frame], again.rotations[frame])).max() < 1e-6
        np.testing.assert_allclose(clip.translations[frame], again.translations[frame], atol=1e-8)


@settings(max_examples=15)
@given(clips(), st.integers(2, 12), st.sampled_from([reduce_keys, reduce_poses]))
def test_no_more_keys_than_allowed(clip, count, reduce):
    reduced = reduce(clip, key_count=count)
    used = max(len(c.values) for c in reduced.curves) if reduce is reduce_keys else reduced.key_count
    assert used <= count
