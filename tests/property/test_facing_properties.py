"""Laws of the facing frame: which way the whole motion goes does not matter."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mtex_usd.motion import quaternion
from mtex_usd.texture.facing import Facing, measure_heading, replace_yaw
from mtex_usd.texture.reading import read_sketch
from tests.synthetic import UP, make_skeleton, random_rotations, turned, walk

SEEDS = st.integers(0, 2**32 - 1)
DEGREES = st.floats(-720.0, 720.0)


def winding_walk(seed, oriented=None):
    heading = 90.0 * np.sin(np.linspace(0.0, 4.0, 90))
    return walk(90, seed=seed, heading=heading, skeleton=make_skeleton(oriented=oriented))


@given(SEEDS, DEGREES, st.none() | st.integers(0, 50))
def test_a_motion_turned_about_up_reads_the_same(seed, degrees, oriented):
    clip = winding_walk(seed, oriented)
    one, other = read_sketch(clip, 0, 4), read_sketch(turned(clip, degrees), 0, 4)
    np.testing.assert_allclose(np.abs(np.sum(one.rotations * other.rotations, axis=-1)), 1.0, atol=1e-12)
    # The path begins elsewhere; its course along the facing is the same.
    np.testing.assert_allclose(one.travel, other.travel, rtol=0, atol=1e-9)
    assert quaternion.angle_between(one.rotations, other.rotations).max() < 1e-7


@given(SEEDS, DEGREES)
def test_heading_follows_the_turn(seed, degrees):
    clip = winding_walk(seed)
    ahead = measure_heading(turned(clip, degrees), 0) - measure_heading(clip, 0)
    np.testing.assert_allclose(np.sin(ahead), np.sin(np.radians(degrees)), atol=1e-9)
    np.testing.assert_allclose(np.ptp(ahead), 0.0, atol=1e-9)


@given(SEEDS)
def test_rolling_undoes_unrolling(seed):
    rng = np.random.default_rng(seed)
    facing = Facing(np.cumsum(rng.standard_normal(40)), UP)
    positions = np.cumsum(rng.standard_normal((40, 3)), axis=0)
    np.testing.assert_allclose(facing.roll_travel(facing.unroll_travel(positions)), positions, atol=1e-9)


@given(SEEDS)
def test_out_of_undoes_into(seed):
    rng = np.random.default_rng(seed)
    facing, turns = Facing(np.cumsum(rng.standard_normal(40)), UP), random_rotations(rng, 40)
    np.testing.assert_allclose(facing.out_of(facing.into(turns)), turns, atol=1e-12)


@given(SEEDS)
def test_unrolled_travel_keeps_heights_and_step_lengths(seed):
    rng = np.random.default_rng(seed)
    facing = Facing(np.cumsum(rng.standard_normal(40)), UP)
    positions = np.cumsum(rng.standard_normal((40, 3)), axis=0)
    travel = facing.unroll_travel(positions)
    np.testing.assert_allclose(travel[:, 1], positions[:, 1], atol=1e-9)
    steps = [np.linalg.norm(np.diff(curve, axis=0), axis=1) for curve in (travel, positions)]
    np.testing.assert_allclose(*steps, atol=1e-9)


@given(SEEDS)
def test_replacing_the_yaw_keeps_the_tilt_and_takes_the_other_turn(seed):
    rng = np.random.default_rng(seed)
    mine, other = random_rotations(rng, 30), random_rotations(rng, 30)
    mixed = replace_yaw(mine, other, UP)
    np.testing.assert_allclose(np.cos(quaternion.twist(mixed, UP) - quaternion.twist(other, UP)), 1.0, atol=1e-9)
    # Where up points, seen from the body, is its tilt.
    seen = [quaternion.rotate(quaternion.conjugate(turns), UP) for turns in (mixed, mine)]
    np.testing.assert_allclose(*seen, atol=1e-9)
