"""How near the method comes to real motion, with one set of defaults and with the paper's own settings."""

import numpy as np
import pytest

from mtex_usd.texture.recipe import Recipe
from tests.benchmarks.quality.baselines import hold_mean_pose, regress_pose
from tests.benchmarks.quality.cases import CASES, DANCE, HELD_OUT, RUN, WALK
from tests.benchmarks.quality.metrics import position_error, remove_top_band, score_variants, variant_distance
from tests.benchmarks.quality.settings import DEFAULT, LITERAL, SETTINGS, make_recipe, run_method
from tests.benchmarks.quality.usd_check import process_fold
from tests.quality.real import case_folds, case_results


def mean_error(results):
    return np.mean([position_error(fold, result.variants[0].clip) for fold, result in results])


class TestAcceptance:
    @pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
    def test_defaults_keep_the_limit(self, data_dir, case):
        assert mean_error(case_results(case, data_dir, DEFAULT)) <= case.limit

    @pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
    def test_defaults_are_the_recipes_own(self, case):
        recipe = make_recipe(case, **SETTINGS[DEFAULT])
        assert recipe == Recipe(match=case.match, match_band=case.band, synthesize=case.rig.synthesized)

    @pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
    def test_defaults_beat_the_paper_and_the_mean_pose(self, data_dir, case):
        ours = mean_error(case_results(case, data_dir, DEFAULT))
        assert ours < 0.9 * mean_error(case_results(case, data_dir, LITERAL))
        assert ours < 0.75 * np.mean([position_error(f, hold_mean_pose(f)) for f in case_folds(case, data_dir)])

    def test_smoother_than_regression_at_no_more_error(self, data_dir):
        folds = case_folds(WALK, data_dir)
        ours = [score_variants(f, [r.variants[0].clip]) for f, r in case_results(WALK, data_dir, DEFAULT)]
        ridge = [score_variants(f, [regress_pose(f)]) for f in folds]
        assert np.mean([s.jerk for s in ours]) < 1.2
        assert np.mean([s.jerk for s in ours]) < 0.6 * np.mean([s.jerk for s in ridge])
        assert np.mean([s.error for s in ours]) < np.mean([s.error for s in ridge])


class TestPaperSettings:
    # What a literal reading gives here, a tenth to either side.
    @pytest.mark.parametrize(
        ("case", "error"), [(WALK, 0.045), (DANCE, 0.244), (RUN, 0.0515)], ids=lambda v: str(v)[:20]
    )
    def test_literal_numbers(self, data_dir, case, error):
        assert mean_error(case_results(case, data_dir, LITERAL)) == pytest.approx(error, rel=0.1)

    @pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
    def test_most_joins_are_consecutive(self, data_dir, case):
        literal, default = (
            [result.variants[0].zero_cost_joins for _, result in case_results(case, data_dir, setting)]
            for setting in (LITERAL, DEFAULT)
        )
        assert sum(literal) > 0
        # Only the number of joins is comparable: candidates differ with the features.
        assert sum(literal) >= sum(default) - len(default)

    def test_matching_the_pose_too_is_what_helps(self, data_dir):
        for case in CASES:
            lower = mean_error(case_results(case, data_dir, "band and below"))
            assert lower < 0.87 * mean_error(case_results(case, data_dir, LITERAL))


class TestProtocol:
    def test_error_of_the_truth_is_none(self, data_dir):
        fold = case_folds(WALK, data_dir)[0]
        assert position_error(fold, fold.truth) == 0.0
        assert 0.0 < position_error(fold, remove_top_band(fold)) < 0.01

    @pytest.mark.parametrize(
        ("case", "error"), [(WALK, 0.100), (DANCE, 0.276), (RUN, 0.097)], ids=lambda v: str(v)[:20]
    )
    def test_mean_pose_as_in_the_table(self, data_dir, case, error):
        errors = [position_error(fold, hold_mean_pose(fold)) for fold in case_folds(case, data_dir)]
        assert np.mean(errors) == pytest.approx(error, abs=0.002)

    def test_walks_by_regression_as_in_the_table(self, data_dir):
        errors = [position_error(fold, regress_pose(fold)) for fold in case_folds(WALK, data_dir)]
        assert np.mean(errors) == pytest.approx(0.039, abs=0.001)

    def test_sketch_says_nothing_of_the_upper_body(self, data_dir):
        fold = case_folds(DANCE, data_dir)[0]
        keyed = [joint.rpartition("/")[2] in DANCE.rig.sketched for joint in fold.sketch.joints]
        still = fold.sketch.rotations[:, ~np.array(keyed)]
        np.testing.assert_array_equal(still, np.broadcast_to([1.0, 0.0, 0.0, 0.0], still.shape))


class TestHeldOut:
    def test_more_walks_of_the_same_performer(self, data_dir):
        case = HELD_OUT[0]
        ours, literal = (
            np.mean([position_error(f, run_method(f, paths=1, **SETTINGS[s]).variants[0].clip) for f in folds])
            for folds in [case_folds(case, data_dir)]
            for s in (DEFAULT, LITERAL)
        )
        assert ours < 0.052
        assert ours < literal


class TestThroughUsd:
    @pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
    def test_first_variant_as_played_is_the_array_result(self, data_dir, tmp_path, case):
        fold, expected = case_results(case, data_dir, DEFAULT)[1]
        result, played = process_fold(fold, tmp_path)
        own = expected.variants[0].clip
        assert variant_distance(fold, [played, own]) < 1e-5
        assert position_error(fold, played) == pytest.approx(position_error(fold, own), abs=1e-5)
        fragments = [(f["start"], f["end"], f["takeStart"], f["takeEnd"]) for f in result.variants[0].fragments]
        assert fragments == [(f.start, f.end, f.take_start, f.take_end) for f in expected.variants[0].fragments]
