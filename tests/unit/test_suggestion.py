"""Choosing match channels and band by finding held-out takes again, on walks made of sines."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import Channel, resolve_channels
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.engine import texture_motion
from mtex_usd.texture.recipe import Recipe, Segment
from mtex_usd.texture.suggestion import Choice, Score, evaluate_choice, rank_choices, set_task
from mtex_usd.texture.suggestion.choices import MOST_CHANNELS, list_bands, list_pairs, moving_channels
from mtex_usd.texture.suggestion.measuring import Ends, Measure, combine_scores
from mtex_usd.texture.suggestion.rehearsal import rehearse_choices
from mtex_usd.texture.suggestion.sampling import read_cast
from mtex_usd.texture.suggestion.trials import MOST_TRIALS, make_trials, sketch_take
from tests.oracle import suggestion as twin
from tests.synthetic import (
    HEAD,
    HIPS,
    JOINTS,
    LEFT_ARM,
    LEFT_KNEE,
    LEFT_LEG,
    RIGHT_KNEE,
    RIGHT_LEG,
    SPINE,
    block,
    make_skeleton,
    on_joints,
    walk,
)

RECIPE = Recipe(match=("LeftUpLeg.rx", "RightUpLeg.rx"), texture=("*Leg",), synthesize=("Spine", "Head", "*Arm"))
SKETCHED = resolve_channels([HIPS, f"{HIPS}.t", "*Leg"], JOINTS, source="test")


@lru_cache
def takes(count=4, *, oriented=None):
    skeleton = make_skeleton(oriented=oriented)
    paces = (0.75, 0.9, 1.0, 1.15, 0.85, 1.05)
    return tuple(
        walk(
            90 + 7 * i,
            seed=i,
            leg=22.0 + 4.0 * i,
            arm=12.0 + 5.0 * i,
            stride_hz=paces[i % 6],
            skeleton=skeleton,
            name=f"/Takes/t{i}",
        )
        for i in range(count)
    )


@lru_cache
def sketch(*, oriented=None):
    return block(walk(100, seed=77, detail=0.0, skeleton=make_skeleton(oriented=oriented)))


@lru_cache
def task():
    return set_task(sketch(), takes(), RECIPE)


@lru_cache
def ranking():
    return rank_choices(task(), count=6)


# ---------------------------------------------------------------- trials


def test_a_take_is_sketched_as_an_animator_would() -> None:
    take = takes()[0]
    made = sketch_take(take, SKETCHED)
    keyed = [JOINTS.index(joint) for joint in (HIPS, LEFT_LEG, LEFT_KNEE, RIGHT_LEG, RIGHT_KNEE)]
    others = [joint for joint in range(len(JOINTS)) if joint not in keyed]
    keys = [*range(0, take.frame_count, 6), take.frame_count - 1]
    assert quaternion.angle_between(made.rotations[keys][:, keyed], take.rotations[keys][:, keyed]).max() < 1e-7
    assert np.allclose(made.translations[keys, 0], take.translations[keys, 0], atol=1e-12)
    apart = np.degrees(quaternion.angle_between(made.rotations[:, keyed], take.rotations[:, keyed]))
    assert 0.01 < apart.max() < 6.0  # between keys it is near, but not the take
    assert (made.rotations[:, others] == take.skeleton.rest_rotations[others]).all()
    assert (made.translations[:, 1:] == take.skeleton.rest_translations[1:]).all()


def test_every_take_is_held_out_once_and_copied_from_otherwise() -> None:
    trials = make_trials(takes(), SKETCHED)
    assert [trial.truth.name for trial in trials] == ["/Takes/t0", "/Takes/t1", "/Takes/t2", "/Takes/t3"]
    for trial in trials:
        assert {trial.truth.name} | {take.name for take in trial.takes} == {take.name for take in takes()}
        assert len(trial.takes) == 3


def test_of_many_takes_some_are_held_out() -> None:
    many = takes() * 10
    trials = make_trials(many, SKETCHED)
    assert len(trials) == MOST_TRIALS
    assert all(len(trial.takes) == len(many) - 1 for trial in trials)


def test_one_take_is_too_few() -> None:
    with pytest.raises(InputError, match=r"by holding one take out .* expected at least two takes .* found 1"):
        set_task(sketch(), takes()[:1], RECIPE)


def test_short_takes_are_not_held_out_but_copied_from() -> None:
    short = replace(
        takes()[0],
        rotations=takes()[0].rotations[:9],
        translations=takes()[0].translations[:9],
        scales=takes()[0].scales[:9],
        name="/Takes/short",
    )
    trials = make_trials([short, *takes()], SKETCHED)
    assert len(trials) == 4
    assert all(short in trial.takes for trial in trials)
    with pytest.raises(InputError, match=r"no take is long enough .* expected more than 12 frames .* found 9"):
        make_trials([short, short], SKETCHED)


def test_takes_on_another_skeleton_are_the_same_trials() -> None:
    """Joint orientations and joints without a part in it change nothing."""
    oriented = set_task(sketch(oriented=3), takes(oriented=3), RECIPE)
    assert oriented.channels == task().channels
    choice = Choice(task().channels[:2], task().channels[0], 4)
    found = evaluate_choice(oriented, choice)
    assert found.error == pytest.approx(evaluate_choice(task(), choice).error, rel=1e-6)
    shuffled = [on_joints(take, tuple(sorted(JOINTS))) for take in takes()]
    assert evaluate_choice(set_task(sketch(), shuffled, RECIPE), choice).error == pytest.approx(found.error, rel=1e-6)


def test_of_a_long_take_the_middle_is_held_out() -> None:
    long = walk(700, seed=5, name="/Takes/long")
    trial = make_trials([long, takes()[0]], SKETCHED)[0]
    assert trial.held == 0
    assert trial.truth.frame_count == trial.sketch.frame_count == 480
    assert (trial.truth.rotations == long.rotations[110:590]).all()
    assert trial.truth.start == 110.0
    assert trial.takes == (takes()[0],)


# ---------------------------------------------------------------- measuring


def make_measure(filled: tuple[str, ...]) -> Measure:
    trial = make_trials(takes(2), SKETCHED)[0]
    joints = [JOINTS.index(joint) for joint in filled]
    return Measure(trial, Ends.of_joints(trial.truth.skeleton, joints), 2)


def test_the_truth_is_without_error() -> None:
    measure = make_measure((SPINE, LEFT_ARM))
    score = measure.score(measure.trial.truth)
    assert score.error == 0.0
    assert score.smoothness >= 1.0  # band 1 is in it, which no result has


@pytest.mark.parametrize("filled", [(SPINE, LEFT_ARM), (HEAD,), (HIPS,)])
def test_measures_equal_the_slow_twin(filled: tuple[str, ...]) -> None:
    measure = make_measure(filled)
    truth = measure.trial.truth
    other = takes(2)[1]
    frames = truth.frame_count
    result = replace(truth, rotations=other.rotations[:frames], translations=other.translations[:frames])
    skeleton = truth.skeleton
    expected = twin.mean_error(
        (truth.rotations, truth.translations),
        (result.rotations, result.translations),
        skeleton.parents,
        (skeleton.rest_rotations, skeleton.rest_translations),
        [JOINTS.index(joint) for joint in filled],
        skeleton.meters_per_unit,
    )
    assert expected > 1e-3
    assert measure.score(result).error == pytest.approx(expected, rel=1e-9)
    joints = [JOINTS.index(joint) for joint in filled]
    ratio = measure.score(result).smoothness / measure.score(truth).smoothness
    rough = [twin.third_difference(clip.rotations[:, joints]) for clip in (result, truth)]
    assert ratio == pytest.approx(rough[0] / rough[1], rel=1e-6)


def test_stillness_and_roughness_count_against_a_choice() -> None:
    even = Score(0.02, 1.0)
    assert even.merit == 0.02
    assert Score(0.02, 2.0).merit == pytest.approx(0.021)
    assert Score(0.02, 0.5).merit == pytest.approx(0.021)
    assert np.isfinite(Score(0.02, 0.0).merit)
    assert combine_scores([Score(0.01, 0.5), Score(0.03, 2.0)]) == Score(0.02, pytest.approx(1.0))


# ---------------------------------------------------------------- what there is to choose from


def test_channels_are_those_that_are_sketched_and_swing() -> None:
    names = [channel.name(JOINTS) for channel in task().channels]
    assert names[0].endswith("Leg.rx")
    assert set(names) == {f"{joint}.rx" for joint in (LEFT_LEG, RIGHT_LEG, LEFT_KNEE, RIGHT_KNEE)}
    arm = Channel(JOINTS.index(LEFT_ARM), "rx")
    assert arm in moving_channels(task().takes, (*SKETCHED, arm), 0, task().bands)
    assert len(moving_channels(task().takes, [arm] * 40, 0, task().bands)) == MOST_CHANNELS


def test_bands_follow_frequency_and_length() -> None:
    assert list_bands([200, 300], 24.0) == (3, 4, 5, 6)
    assert list_bands([1000], 48.0) == (4, 5, 6, 7)
    assert list_bands([200, 20], 24.0) == (3, 4)
    assert list_bands([4], 24.0) == (1,)


def test_pairs_come_in_either_order() -> None:
    a, b, c = SKETCHED[:3]
    pairs = list_pairs((a, b, c), (4, 5))
    assert len(pairs) == len(set(pairs)) == 12
    assert Choice((a, b), a, 4) in pairs
    assert Choice((b, a), b, 4) in pairs


def test_segments_and_paths_play_no_part_in_trials() -> None:
    segment = Segment(name="stop", start=40.0, end=60.0, match=("LeftLeg.rx",), synthesize=("Head",), texture=())
    recipe = replace(RECIPE, synthesize=("Spine", "*Arm"), segments=(segment,), diversity=5.0)
    made = set_task(sketch(), takes(), recipe)
    assert made.recipe.segments == ()
    assert made.recipe.paths == 1
    assert made.recipe.diversity == 0.0
    assert set(made.recipe.synthesize) == set(task().recipe.synthesize)


def in_place(clip: Clip) -> Clip:
    return replace(clip, translations=np.tile(clip.translations[:1], (clip.frame_count, 1, 1)))


def test_nothing_to_choose_from_is_said() -> None:
    still = in_place(block(takes()[0], joints=()))
    with pytest.raises(InputError, match=r"/Sketch: there is no channel to choose from; expected .* found none"):
        set_task(still, takes(), RECIPE)
    frozen = [in_place(block(take, joints=(SPINE, HEAD), name=take.name)) for take in takes()]
    with pytest.raises(InputError, match=r"no channel to choose from; .* still in the takes"):
        set_task(in_place(sketch()), frozen, RECIPE)


def test_takes_without_joints_are_left_out_and_said() -> None:
    legs = on_joints(takes()[0], [joint for joint in JOINTS if "Spine" not in joint])
    made = set_task(sketch(), [*takes(), replace(legs, name="/Takes/legs")], RECIPE)
    assert len(made.takes) == 4
    assert any("/Takes/legs is left out" in note for note in made.notes)


# ---------------------------------------------------------------- ranking


def test_full_evaluations_equal_the_plain_method() -> None:
    """What a ranking says is what texturing by hand with that recipe, and measuring the slow way, gives."""
    for each in ranking()[:2]:
        names = [channel.name(JOINTS).rpartition("/")[2] for channel in each.choice.match]
        recipe = replace(RECIPE, match=tuple(names), break_channel=names[0], match_band=each.choice.band, paths=1)
        errors = []
        for held in takes():
            others = [take for take in takes() if take is not held]
            made = texture_motion(sketch_take(held, SKETCHED), others, recipe).variants[0].clip
            skeleton = held.skeleton
            filled = [joint for joint, name in enumerate(JOINTS) if "Spine" in name and not name.endswith("Leg")]
            errors.append(
                twin.mean_error(
                    (held.rotations, held.translations),
                    (made.rotations, made.translations),
                    skeleton.parents,
                    (skeleton.rest_rotations, skeleton.rest_translations),
                    filled,
                    skeleton.meters_per_unit,
                )
            )
        assert each.score.error == pytest.approx(np.mean(errors), rel=1e-6)


def test_the_ranking_is_sorted_and_repeats_itself() -> None:
    first = ranking()
    merits = [each.score.merit for each in first[:6]]
    assert merits == sorted(merits)
    assert [each.rank for each in first[:6]] == [1, 2, 3, 4, 5, 6]
    assert first == rank_choices(set_task(sketch(), takes(), RECIPE), count=6)
    assert len({each.choice for each in first}) == len(first)
    assert sum(each.is_own for each in first) == 1


def test_the_first_is_within_5_percent_of_the_best_pair() -> None:
    made = task()
    best = min(evaluate_choice(made, choice).error for choice in list_pairs(made.channels, made.bands))
    assert ranking()[0].score.error <= 1.05 * best


def test_rehearsals_foretell_the_error() -> None:
    made = task()
    choices = list_pairs(made.channels, made.bands)[::5]
    rehearsed = rehearse_choices(read_cast(made.takes, made.trials, made.ends), choices, made.root, made.recipe)
    for choice in choices:
        assert rehearsed[choice] == pytest.approx(evaluate_choice(made, choice).error, rel=0.15)


def test_a_choice_rehearses_alone_as_among_others() -> None:
    made = task()
    cast = read_cast(made.takes, made.trials, made.ends)
    choices = list_pairs(made.channels, made.bands)[:12]
    together = rehearse_choices(cast, choices, made.root, made.recipe)
    for choice in choices[::5]:
        (alone,) = rehearse_choices(cast, [choice], made.root, made.recipe).values()
        assert alone == pytest.approx(together[choice], rel=1e-9)


@pytest.mark.parametrize(
    "change",
    [{"path_cost": "consecutive"}, {"match_lower": False}, {"candidates": 3}, {"scale": True}, {"max_stretch": 1.0}],
)
def test_rankings_follow_the_rest_of_the_recipe(change: dict[str, object]) -> None:
    ranked = rank_choices(set_task(sketch(), takes(3), replace(RECIPE, **change)), count=1)
    assert 0.0 < ranked[0].score.error < 0.5


def test_progress_is_told() -> None:
    told: list[tuple[int, int, str]] = []
    rank_choices(task(), count=1, report=lambda *each: told.append(each))
    assert {what for _, _, what in told} >= {"rehearsing channels", "trying the best"}
    assert all(0 <= done <= total for done, total, _ in told)
