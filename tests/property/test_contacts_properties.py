"""Laws of the contact detection: neither axes, size, place nor frame rate change what is found."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mtex_usd.constraints.contacts import Effector, detect_contacts
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from tests.oracle import contacts as oracle
from tests.unit.test_contacts import POINT, foot_skeleton, point_clip

SEEDS = st.integers(0, 2**32 - 1)


def hops(seed, *, rate=120.0):
    """Stand, hop, stand and so on at random places and times; places [F, 3] in centimetres and the hops' times."""
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.35, 0.8, 8))
    places = np.cumsum(rng.uniform(30.0, 90.0, (5, 3)) * [1.0, 0.0, 1.0], axis=0)
    # As long at every rate.
    at = np.arange(int(times[-1] * 6.0) * round(rate / 6.0) + 1) / rate
    out = np.tile(places[0], (len(at), 1))
    for step in range(3):
        phase = np.clip((at - times[2 * step]) / (times[2 * step + 1] - times[2 * step]), 0.0, 1.0)[:, None]
        ease = phase * phase * (3.0 - 2.0 * phase)
        out += ease * (places[step + 1] - places[step])
        out[:, 1] += 100.0 * (ease * (1.0 - ease))[:, 0]
    return out


def stepping_clip(seed, skeleton, *, rate=120.0):
    """The hops as the motion of a whole body on stiff legs."""
    places = hops(seed, rate=rate)
    translations = np.tile(skeleton.rest_translations, (len(places), 1, 1))
    translations[:, 0] += places
    return Clip(
        skeleton=skeleton,
        rate=rate,
        rotations=np.tile(skeleton.rest_rotations, (len(places), 1, 1)),
        translations=translations,
        scales=np.ones(translations.shape),
    )


def frames(contacts):
    return [(c.effector.name, c.first, c.last) for c in contacts]


@settings(max_examples=15)
@given(seed=SEEDS, scale=st.floats(1e-3, 1e3), turn=SEEDS)
def test_neither_scale_nor_axes_change_anything(seed, scale, turn):
    skeleton = foot_skeleton()
    clip = stepping_clip(seed, skeleton)
    q = quaternion.normalize(np.random.default_rng(turn).standard_normal(4))
    rest = np.array(skeleton.rest)
    rest[:, 3, :3] *= scale
    rest[0, :3, :3] = quaternion.rotate(q, np.eye(3))
    rest[0, 3, :3] = quaternion.rotate(q, rest[0, 3, :3])
    other = replace(skeleton, rest=rest, up=quaternion.rotate(q, skeleton.up))
    translations = clip.translations * scale
    translations[:, 0] = quaternion.rotate(q, translations[:, 0])
    rotations = np.array(clip.rotations)
    rotations[:, 0] = quaternion.multiply(q, rotations[:, 0])
    turned = replace(clip, skeleton=other, rotations=rotations, translations=translations)
    own, found = detect_contacts(clip), detect_contacts(turned)
    assert frames(own) == frames(found)
    assert len(own) == 16
    for a, b in zip(own, found, strict=True):
        np.testing.assert_allclose(b.point, quaternion.rotate(q, scale * a.point), atol=1e-6 * scale)


@settings(max_examples=15)
@given(seed=SEEDS, rate=st.sampled_from([24.0, 30.0, 60.0, 90.0]))
def test_frame_rate_changes_no_border_by_a_24th(seed, rate):
    fast = detect_contacts(point_clip(hops(seed)), effectors=POINT)
    slow = detect_contacts(point_clip(hops(seed, rate=rate), rate=rate), effectors=POINT)
    assert len(fast) == len(slow) == 4
    for a, b in zip(fast, slow, strict=True):
        assert abs(a.first / 120.0 - b.first / rate) <= 1.0 / 24.0
        assert abs(a.last / 120.0 - b.last / rate) <= 1.0 / 24.0


@settings(max_examples=10)
@given(seed=SEEDS, noise=st.floats(0.0, 0.5))
def test_noise_of_five_millimetres_loses_no_contact(seed, noise):
    places = hops(seed)
    noisy = places + np.random.default_rng(seed).normal(0.0, noise, places.shape)
    clean, found = (detect_contacts(point_clip(p), effectors=POINT) for p in (places, noisy))
    assert len(clean) == len(found)
    for a, b in zip(clean, found, strict=True):
        assert max(abs(a.first - b.first), abs(a.last - b.last)) <= 5
        assert np.linalg.norm(a.point - b.point) <= 0.5


@settings(max_examples=10)
@given(seed=SEEDS, rate=st.sampled_from([24.0, 48.0, 120.0, 180.0]))
def test_equals_the_slow_twin(seed, rate):
    places = hops(seed, rate=rate)
    other = Effector(name="other", joint=0, offset=np.array([1.0, 0.5, 0.0]))
    found = detect_contacts(point_clip(places, rate=rate), effectors=(*POINT, other))
    tracks = [places + effector.offset for effector in (*POINT, other)]
    expected = oracle.detect(tracks, rate, np.array([0.0, 1.0, 0.0]), scale=100.0)
    for effector, contacts in zip((*POINT, other), expected, strict=True):
        own = [(c.first, c.last) for c in found if c.effector is effector]
        assert own == [(first, last) for first, last, _ in contacts]
