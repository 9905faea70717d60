"""Constraints on a whole motion: each kind is met, what need not change does not, and what cannot be is said."""

from dataclasses import replace

import numpy as np
import pytest

from mtex_usd.constraints.spacetime import (
    DistanceBetween,
    MassOver,
    OrientationAt,
    PathFollow,
    PlaneAbove,
    PlaneOn,
    Point,
    PointAt,
    PointStill,
    RotationRange,
    measure_energy_above,
    solve_spacetime,
)
from mtex_usd.constraints.spacetime.mass import bone_masses, find_support_sides
from mtex_usd.errors import InputError, NoSolutionError
from mtex_usd.motion import quaternion
from tests.spacetime_support import follow
from tests.synthetic import (
    HEAD,
    HIPS,
    LEFT_ARM,
    LEFT_FOREARM,
    LEFT_KNEE,
    LEFT_LEG,
    RIGHT_ARM,
    RIGHT_FOREARM,
    RIGHT_KNEE,
    RIGHT_LEG,
    SPINE,
    UP,
    walk,
)

FRAMES = 40
HAND, FOOT = Point(LEFT_FOREARM, (25.0, 0.0, 0.0)), Point(LEFT_KNEE, (0.0, -45.0, 0.0))
OTHER_FOOT = Point(RIGHT_KNEE, (0.0, -45.0, 0.0))
CM = 0.01


@pytest.fixture(scope="module")
def clip():
    return walk(FRAMES)


def changed_joints(clip, result):
    differ = (clip.rotations != result.rotations).any(axis=(0, 2)) | (clip.translations != result.translations).any(
        (0, 2)
    )
    return {clip.joints[joint] for joint in np.flatnonzero(differ)}


def test_no_constraint_changes_no_bit(clip):
    (result,) = solve_spacetime(clip, []).clips
    assert result.rotations.tobytes() == clip.rotations.tobytes()
    assert result.translations.tobytes() == clip.translations.tobytes()


def test_constraints_that_are_met_change_no_bit(clip):
    foot = follow(clip, FOOT)
    kept = [PointAt("foot", FOOT, [10], foot[10]), PlaneAbove("floor", FOOT, np.arange(FRAMES), foot[:, 1].min() - 1.0)]
    solution = solve_spacetime(clip, kept)
    assert solution.clips[0].rotations.tobytes() == clip.rotations.tobytes()
    assert solution.iterations == 0
    assert solution.residuals["foot"] < 1e-12


def test_a_point_is_brought_to_its_place_and_only_its_chain_moves(clip):
    place = follow(clip, HAND)[20] + [4.0, 6.0, 3.0]
    solution = solve_spacetime(clip, [PointAt("hand", HAND, [20], place)])
    assert np.linalg.norm(follow(solution.clips[0], HAND)[20] - place) * CM < 1e-4
    assert changed_joints(clip, solution.clips[0]) == {HIPS, SPINE, LEFT_ARM, LEFT_FOREARM}
    assert solution.residuals["hand"] < 1e-4
    assert solution.displacements[0].rotations.shape == (FRAMES, len(clip.joints), 3)


def test_the_displacement_is_composed_with_the_motion(clip):
    solution = solve_spacetime(clip, [PointAt("hand", HAND, [20], follow(clip, HAND)[20] + 5.0)])
    (change,), (result,) = solution.displacements, solution.clips
    composed = quaternion.multiply(clip.rotations, quaternion.exp(change.rotations))
    np.testing.assert_allclose(composed, result.rotations, atol=1e-14)
    np.testing.assert_allclose(clip.translations[:, 0] + change.translation, result.translations[:, 0], atol=1e-12)
    assert change.root == 0


def test_a_planted_foot_keeps_still_where_it_likes(clip):
    frames = np.arange(12, 24)
    solution = solve_spacetime(clip, [PointStill("step", FOOT, frames)])
    before, after = follow(clip, FOOT)[frames], follow(solution.clips[0], FOOT)[frames]
    assert np.linalg.norm(before - before.mean(axis=0), axis=1).max() > 3.0
    assert np.linalg.norm(after - after.mean(axis=0), axis=1).max() * CM < 1e-4
    np.testing.assert_allclose(solution.places["step"], after.mean(axis=0), atol=0.01)
    assert np.linalg.norm(after.mean(axis=0) - before.mean(axis=0)) < 10.0


def test_heel_and_toe_of_one_bone_are_held_together(clip):
    """Their distance is fixed by the bone, so one of the six coordinates is asked for twice."""
    frames, toe = np.arange(12, 24), Point(LEFT_KNEE, (0.0, -45.0, 14.0))
    solution = solve_spacetime(clip, [PointStill("heel", FOOT, frames), PointStill("toe", toe, frames)])
    for point in (FOOT, toe):
        held = follow(solution.clips[0], point)[frames]
        assert np.linalg.norm(held - held.mean(axis=0), axis=1).max() * CM < 2e-4


def test_a_foot_is_kept_above_the_floor_and_pushed_no_further(clip):
    floor = np.sort(follow(clip, FOOT)[:, 1])[12]
    (result,) = solve_spacetime(clip, [PlaneAbove("floor", FOOT, np.arange(FRAMES), floor)]).clips
    before, after = follow(clip, FOOT)[:, 1], follow(result, FOOT)[:, 1]
    assert (before < floor - 0.1).sum() > 5
    assert after.min() > floor - 0.011
    assert after.min() < floor + 0.011


def test_a_plane_may_have_any_normal(clip):
    normal, hand = np.array([1.0, 1.0, 0.0]), follow(clip, HAND)[20]
    heights = hand @ normal / np.sqrt(2.0) + 3.0
    (result,) = solve_spacetime(clip, [PlaneOn("wall", HAND, [20], heights, normal)]).clips
    assert follow(result, HAND)[20] @ normal / np.sqrt(2.0) == pytest.approx(heights, abs=0.01)


def test_a_joint_is_turned_as_asked(clip):
    target = quaternion.exp(np.array([0.3, -0.2, 0.5]))
    (result,) = solve_spacetime(clip, [OrientationAt("head", HEAD, [5, 6], target)]).clips
    world = result.skeleton.world_rotations(result.rotations)[5:7, result.joints.index(HEAD)]
    assert np.degrees(quaternion.angle_between(world, target)).max() < 0.06


def test_angles_keep_their_range_and_locked_axes_stay_locked(clip):
    """Knees bend about x only: the hand-made walk bends them up to 2 * 30 degrees."""
    every = np.arange(FRAMES)
    limits = [RotationRange("knee", LEFT_KNEE, every, [0.0, 0.0, 0.0], [40.0, 0.0, 0.0])]
    pull = PointAt("foot", FOOT, [20], follow(clip, FOOT)[20] + [8.0, 5.0, 0.0])
    (result,) = solve_spacetime(clip, [*limits, pull]).clips
    knee = quaternion.to_euler(result.rotations[:, clip.joints.index(LEFT_KNEE)], "XYZ")
    assert quaternion.to_euler(clip.rotations[:, clip.joints.index(LEFT_KNEE)], "XYZ")[:, 0].max() > 45.0
    assert knee[:, 0].max() < 40.06
    assert knee[:, 0].min() > -0.06
    assert np.abs(knee[:, 1:]).max() < 0.06
    assert np.linalg.norm(follow(result, FOOT)[20] - np.asarray(pull.place)) * CM < 1e-4


def test_a_range_may_be_about_other_axes(clip):
    """With the axes a quarter turn about up, the bend about the skeleton's x is one about z."""
    quarter = (np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0)
    every, free = np.arange(FRAMES), np.full(3, np.inf)
    about_x = RotationRange("knee", LEFT_KNEE, every, -free, [40.0, np.inf, np.inf])
    about_z = RotationRange("knee", LEFT_KNEE, every, -free, [np.inf, np.inf, 40.0], order="ZYX", axes=quarter)
    results = [solve_spacetime(clip, [limit]).clips[0].rotations for limit in (about_x, about_z)]
    assert (results[0] != clip.rotations).any()
    np.testing.assert_allclose(results[0], results[1], atol=1e-6)


def test_hands_are_held_apart(clip):
    other = Point(RIGHT_FOREARM, (-25.0, 0.0, 0.0))
    frames = np.arange(10, 30)
    (result,) = solve_spacetime(clip, [DistanceBetween("box", HAND, other, frames, 90.0)]).clips
    apart = np.linalg.norm(follow(result, HAND) - follow(result, other), axis=1)
    np.testing.assert_allclose(apart[frames], 90.0, atol=0.01)


@pytest.mark.parametrize(("fixed", "moved"), [((), {0, 1}), ((0,), {1}), ((1,), {0})])
def test_two_characters_meet_and_one_may_be_kept(clip, fixed, moved):
    partner = walk(FRAMES, seed=4, heading=20.0)
    other = Point(RIGHT_FOREARM, (-25.0, 0.0, 0.0), clip=1)
    frames = np.arange(15, 25)
    solution = solve_spacetime([clip, partner], [DistanceBetween("hands", HAND, other, frames, 0.0)], fixed=fixed)
    gap = follow(solution.clips[0], HAND) - follow(solution.clips[1], other)
    assert np.linalg.norm(gap[frames], axis=1).max() * CM < 1e-4
    pairs = enumerate(zip((clip, partner), solution.clips, strict=True))
    assert {n for n, (a, b) in pairs if changed_joints(a, b)} == moved


def test_a_path_is_followed_between_its_places(clip):
    hand = follow(clip, HAND)
    places = hand[[10, 18, 26]] + [[0.0, 2.0, 0.0], [0.0, 6.0, 0.0], [0.0, 2.0, 0.0]]
    (result,) = solve_spacetime(clip, [PathFollow("wave", HAND, [10.0, 18.0, 26.0], places)]).clips
    after = follow(result, HAND)
    np.testing.assert_allclose(after[[10, 18, 26]], places, atol=0.01)
    along = np.linalg.norm(np.diff(after[10:27], n=3, axis=0), axis=1).max()
    assert along < 0.5


def test_the_mass_is_brought_over_the_feet(clip):
    frames = np.arange(18, 22)
    foot = follow(clip, FOOT)[20]
    corners = foot + np.array(
        [[-6.0, 0.0, -8.0], [6.0, 0.0, -8.0], [6.0, 0.0, 16.0], [-6.0, 0.0, 16.0], [0.0, 3.0, 0.0]]
    )
    kept = PointAt("foot", FOOT, frames, foot)
    solution = solve_spacetime(clip, [MassOver("balance", corners, frames, margin=1.0), kept])
    (result,) = solution.clips
    positions, _ = result.skeleton.world_pose(result.rotations, result.translations)
    masses = bone_masses(result)
    centre = np.einsum("j,fji->fi", masses, positions)[frames] / masses.sum() - foot
    assert np.abs(centre[:, 0]).max() < 5.02
    assert centre[:, 2].min() > -7.02
    assert centre[:, 2].max() < 15.02


def test_support_is_the_hull_seen_from_above():
    corners = np.array(
        [[0.0, 0.0, 0.0], [4.0, 9.0, 0.0], [4.0, -3.0, 2.0], [0.0, 1.0, 2.0], [2.0, 5.0, 1.0], [2.0, 0.0, 0.0]]
    )
    normals, bounds = find_support_sides(corners, UP)
    assert len(bounds) == 4
    inside, outside = np.array([3.9, 50.0, 1.9]), np.array([4.1, 0.0, 1.0])
    assert (normals @ inside < bounds).all()
    assert (normals @ outside - bounds).max() == pytest.approx(0.1)
    assert find_support_sides(corners[:2], UP) is None
    assert find_support_sides(np.outer(np.arange(4.0), [1.0, 5.0, 2.0]), UP) is None


def test_bones_may_change_their_length(clip):
    """What holds is the clip's translations, not the rest pose."""
    shrink = np.linspace(1.0, 0.6, FRAMES)[:, None, None]
    smaller = replace(clip, translations=clip.translations * shrink)
    frames = np.arange(10, 30)
    (result,) = solve_spacetime(smaller, [PointStill("step", FOOT, frames)]).clips
    held = follow(result, FOOT)[frames]
    assert np.linalg.norm(held - held.mean(axis=0), axis=1).max() * CM < 1e-4
    np.testing.assert_array_equal(result.translations[:, 1:], smaller.translations[:, 1:])


def test_units_do_not_matter(clip):
    skeleton = clip.skeleton
    rest = np.array(skeleton.rest)
    rest[:, 3, :3] *= 0.01
    metric = replace(
        clip, skeleton=replace(skeleton, rest=rest, meters_per_unit=1.0), translations=clip.translations * 0.01
    )
    place = follow(clip, HAND)[20] + 5.0
    (centimetres,) = solve_spacetime(clip, [PointAt("hand", HAND, [20], place)]).clips
    hand = Point(HAND.joint, tuple(0.01 * np.array(HAND.offset)))
    (metres,) = solve_spacetime(metric, [PointAt("hand", hand, [20], 0.01 * place)]).clips
    np.testing.assert_allclose(centimetres.rotations, metres.rotations, atol=1e-9)


def test_weights_say_what_moves(clip):
    wish = [PointAt("hand", HAND, [20], follow(clip, HAND)[20] + 5.0)]
    plain, kept = (
        solve_spacetime(clip, wish, joint_weights=weights, translation_weight=root)
        for weights, root in (({}, 1.0), ({"LeftForeArm": np.inf, "Spine": 10.0}, np.inf))
    )
    assert changed_joints(clip, kept.clips[0]) == {HIPS, SPINE, LEFT_ARM}
    np.testing.assert_array_equal(kept.clips[0].translations, clip.translations)
    spine = clip.joints.index(SPINE)
    turned = [np.abs(solution.displacements[0].rotations[:, spine]).max() for solution in (plain, kept)]
    assert turned[1] < 0.5 * np.abs(kept.displacements[0].rotations).max()
    assert turned[0] > 0.0


def test_far_away_nothing_changes_much():
    """The basis reaches four knots, and what neighbouring coefficients pass on dies away."""
    clip = walk(240)
    solution = solve_spacetime(clip, [PointAt("hand", HAND, [120], follow(clip, HAND)[120] + 10.0)])
    size = np.abs(solution.displacements[0].rotations).max(axis=(1, 2))
    assert size[120] > np.radians(1.0)
    assert size[:60].max() < 1e-6 * size[120]
    assert size[180:].max() < 1e-6 * size[120]


def test_the_change_is_slow(clip):
    frames = np.arange(12, 24)
    (change,) = solve_spacetime(clip, [PointStill("step", FOOT, frames)]).displacements
    assert 0.0 < measure_energy_above(change, clip.rate, 6.0) < 0.01
    assert measure_energy_above(replace(change, rotations=0.0 * change.rotations), clip.rate, 6.0) == 0.0


def test_smoothness_and_highpass_take_energy_from_above(clip):
    wish = [PointStill("step", FOOT, np.arange(12, 24))]
    options = ({"smoothness": 0.0}, {"smoothness": 0.0, "highpass": 10.0}, {"smoothness": 100.0})
    above = [
        measure_energy_above(solve_spacetime(clip, wish, **option).displacements[0], clip.rate, 4.0)
        for option in options
    ]
    assert above[0] > 2.0 * above[1]
    assert above[0] > 2.0 * above[2]


def test_knots_are_added_only_where_they_are_needed():
    clip = walk(120, detail=0.0)
    jitter = np.random.default_rng(3).uniform(-2.0, 2.0, (10, 3))
    frames = np.arange(50, 60)
    wish = PointAt("shake", HAND, frames, follow(clip, HAND)[frames] + jitter)
    solution = solve_spacetime(clip, [wish], smoothness=0.0, joint_weights={"Spine": np.inf, "Hips": np.inf})
    steps = np.diff(solution.knots)
    assert steps.min() == 1.0
    assert (steps[solution.knots[:-1] < 40] == 2.0).all()
    assert solution.residuals["shake"] < 1e-4


def test_a_frequency_above_the_frames_is_one_knot_a_frame(clip):
    solution = solve_spacetime(clip, [PointAt("hand", HAND, [20], follow(clip, HAND)[20] + 5.0)], frequency=100.0)
    assert (np.diff(solution.knots) == 1.0).all()


def test_a_clip_of_one_frame_can_be_solved(clip):
    one = replace(clip, rotations=clip.rotations[:1], translations=clip.translations[:1], scales=clip.scales[:1])
    place = follow(one, HAND)[0] + 5.0
    (result,) = solve_spacetime(one, [PointAt("hand", HAND, [0], place)]).clips
    np.testing.assert_allclose(follow(result, HAND)[0], place, atol=0.01)


def test_constraints_that_fight_are_named_with_how_much(clip):
    hand = follow(clip, HAND)[20]
    wishes = [
        PointAt("up", HAND, [20], hand + np.array([0.0, 10.0, 0.0])),
        PointAt("down", HAND, [20], hand - [0.0, 10.0, 0.0]),
        PointAt("foot", OTHER_FOOT, [20], follow(clip, OTHER_FOOT)[20] + 1.0),
    ]
    with pytest.raises(NoSolutionError, match=r"2 of 3 constraints cannot be met together") as caught:
        solve_spacetime(clip, wishes)
    assert "up by 100 mm" in caught.value.found
    assert "down by 100 mm" in caught.value.found
    assert "foot" not in caught.value.found
    assert caught.value.exit_code == 4


def test_a_range_and_an_orientation_fight_in_degrees(clip):
    angle = quaternion.exp(np.radians([0.0, 0.0, 40.0]))
    below = clip.skeleton.world_rotations(clip.rotations)[8, clip.joints.index(SPINE)]
    wishes = [
        OrientationAt("tilt", HEAD, [8], quaternion.multiply(below, angle)),
        RotationRange("neck", HEAD, [8], [-np.inf, -np.inf, -5.0], [np.inf, np.inf, 5.0]),
    ]
    weights = {"Hips": np.inf, "Spine": np.inf}
    with pytest.raises(NoSolutionError, match=r"(tilt|neck) by 17\.\d degrees"):
        solve_spacetime(clip, wishes, joint_weights=weights)


def test_nothing_may_move_and_something_should(clip):
    wish = PointAt("hand", HAND, [20], follow(clip, HAND)[20] + 5.0)
    with pytest.raises(NoSolutionError, match=r"hand by 86\.6 mm"):
        solve_spacetime(clip, [wish], fixed=(0,))


@pytest.mark.parametrize(
    ("constraint", "message"),
    [
        (PointAt("p", HAND, [FRAMES], np.zeros(3)), r"constraint p: bad frames; expected whole numbers from 0 to 39"),
        (PointAt("p", HAND, [0.5], np.zeros(3)), r"constraint p: bad frames.*found 1 of type float64"),
        (PointAt("p", HAND, [], np.zeros(3)), r"constraint p: bad frames"),
        (
            PointAt("p", HAND, [1, 2], np.zeros((3, 3))),
            r"constraint p: bad numbers.*\(3,\) or \(2, 3\); found \(3, 3\)",
        ),
        (PointAt("p", HAND, [1], [0.0, np.nan, 0.0]), r"constraint p: bad numbers"),
        (PointAt("p", Point("Tail"), [1], np.zeros(3)), r"no single joint Tail in clip /Take; found Hips, "),
        (PointAt("p", Point(HIPS, clip=1), [1], np.zeros(3)), r"constraint p: no such character; .*below 1; found 1"),
        (PlaneOn("p", HAND, [1], 0.0, [0.0, 0.0, 0.0]), r"constraint p: bad normal"),
        (DistanceBetween("p", HAND, FOOT, [1], -1.0), r"constraint p: bad distance; expected above 0"),
        (DistanceBetween("p", HAND, FOOT, [1, 2], [0.0, 1.0]), r"constraint p: bad distance"),
        (PathFollow("p", HAND, [3.0, 1.0], np.zeros((2, 3))), r"constraint p: bad path; expected at least two incr"),
        (RotationRange("p", HEAD, [1], [5.0, 0, 0], [1.0, 0, 0]), r"constraint p: bad range"),
        (
            RotationRange("p", HEAD, [1], np.zeros(3), np.ones(3), order="XYX"),
            r"constraint p: bad range; expected an o",
        ),
        (MassOver("p", np.zeros((3, 3)), [1]), r"constraint p: no area to stand on"),
        (MassOver("p", np.eye(3), [1], masses=[1.0]), r"bad masses for clip /Take; expected 11 numbers"),
    ],
)
def test_constraints_that_make_no_sense_are_refused(clip, constraint, message):
    with pytest.raises(InputError, match=message):
        solve_spacetime(clip, [constraint])


def test_names_must_differ(clip):
    twice = [PointAt("p", HAND, [1], np.zeros(3)), PointStill("p", FOOT, [1, 2])]
    with pytest.raises(InputError, match="constraints share a name; found p"):
        solve_spacetime(clip, twice)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"frequency": 0.0}, "bad options of the spacetime solve"),
        ({"smoothness": -1.0}, "bad options of the spacetime solve"),
        ({"translation_weight": 0.0}, "bad options of the spacetime solve"),
        ({"joint_weights": {"Head": 0.0}}, "bad weight of joint Head; expected above 0"),
        ({"joint_weights": {"Tail": 1.0}}, "no single joint Tail"),
        ({"fixed": (2,)}, "no such character to keep; expected numbers below 1"),
    ],
)
def test_options_that_make_no_sense_are_refused(clip, options, message):
    with pytest.raises(InputError, match=message):
        solve_spacetime(clip, [PointAt("p", HAND, [1], np.zeros(3))], **options)


def test_clips_must_fit_each_other(clip):
    with pytest.raises(InputError, match="no clip to solve for"):
        solve_spacetime([], [])
    with pytest.raises(InputError, match=r"clips do not fit each other.*found 40 frames, 24/s, 0.01; 30 frames"):
        solve_spacetime([clip, walk(30)], [])


def test_joints_go_by_their_last_name_where_it_is_unique(clip):
    place = follow(clip, HAND)[20] + 5.0
    short, full = (
        solve_spacetime(clip, [PointAt("hand", Point(name, HAND.offset), [20], place)]).clips[0]
        for name in ("LeftForeArm", LEFT_FOREARM)
    )
    np.testing.assert_array_equal(short.rotations, full.rotations)


def test_a_root_below_a_still_joint_is_moved_in_its_parents_axes():
    """As on rigs whose topmost joint stands still and whose hips travel."""
    clip = walk(20)
    assert {LEFT_LEG, RIGHT_LEG, RIGHT_ARM} < set(clip.joints)
    turn = quaternion.exp(np.array([0.2, 0.9, -0.3]))
    placed = _below_a_still_joint(clip, turn)
    hand = replace(HAND, joint=f"Root/{HAND.joint}")
    place = follow(placed, hand)[10] + [3.0, 1.0, 2.0]
    solution = solve_spacetime(placed, [PointAt("hand", hand, [10], place)], joint_weights={"Root": np.inf})
    np.testing.assert_allclose(follow(solution.clips[0], hand)[10], place, atol=0.01)
    assert solution.displacements[0].root == 1


def _below_a_still_joint(clip, turn):
    joints = ("Root", *(f"Root/{joint}" for joint in clip.joints))
    rest = np.concatenate([np.eye(4)[None], clip.skeleton.rest])
    frames = clip.frame_count
    return replace(
        clip,
        skeleton=replace(clip.skeleton, joints=joints, rest=rest),
        rotations=np.concatenate([np.tile(turn, (frames, 1, 1)), clip.rotations], axis=1),
        translations=np.concatenate([np.ones((frames, 1, 3)), clip.translations], axis=1),
        scales=np.ones((frames, len(joints), 3)),
    )
