"""In every situation a sketch is found in, every variant plays through UsdSkel as computed, and the source is kept."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

from mtex_usd.usd.characters import Character
from mtex_usd.usd.check import check_override
from mtex_usd.usd.override import CharacterResult, VariantSamples, variant_names, write_override
from mtex_usd.usd.source_stage import SourceStage, open_source
from tests.usd.playback import (
    animation_arrays,
    local_transforms,
    no_diagnostics,
    rest_transforms,
    select_variant,
    skeleton_query,
    stack_over,
    transform,
)
from tests.usd.situations import BASE_SITUATIONS, SITUATIONS, Situation
from tests.usd.synthetic import VARIANTS, make_results

TOLERANCE = 2e-5  # of single precision, on offsets near 100


@dataclass(frozen=True)
class Written:
    """A situation with its results written."""

    situation: Situation
    source: SourceStage
    results: tuple[CharacterResult, ...]
    override: Path
    thin_root: Path


@pytest.fixture(params=SITUATIONS)
def situation(request: pytest.FixtureRequest, tmp_path: Path) -> Situation:
    """Build each of the situations."""
    return SITUATIONS[request.param](tmp_path)


@pytest.fixture
def written(situation: Situation) -> Iterator[Written]:
    """Write synthetic results over a situation; USD must have nothing to say about any of it."""
    with no_diagnostics():
        source = open_source(situation.shot)
        results = make_results(source.stage, situation)
        override, thin_root = write_override(source.stage, results, situation.shot.with_name("shot.mtex.usd"))
        yield Written(situation, source, results, override, thin_root)


def _assert_plays(stage: Usd.Stage, character: Character, samples: VariantSamples, frame: int) -> None:
    """Every joint follows the samples; those without any are at rest."""
    for skeleton in map(str, character.skeletons):
        wanted = rest_transforms(stage, skeleton)
        for j, joint in enumerate(samples.joints):
            wanted[joint] = transform(
                samples.rotations[frame, j], samples.translations[frame, j], samples.scales[frame, j]
            )
        played = local_transforms(stage, skeleton, float(samples.time_codes[frame]))
        for joint, matrix in wanted.items():
            np.testing.assert_allclose(played[joint], matrix, atol=TOLERANCE, err_msg=f"{skeleton} {joint}")


def _assert_original(stage: Usd.Stage, source: Usd.Stage, character: Character, time_code: float) -> None:
    """Every joint follows the source animation, at frames and between; where it was played, exactly as before."""
    joints, rotations, translations = animation_arrays(source, str(character.animation), [time_code])
    for skeleton in map(str, character.skeletons):
        played = local_transforms(stage, skeleton, time_code)
        if skeleton_query(source, skeleton).GetAnimQuery():
            np.testing.assert_equal(played, local_transforms(source, skeleton, time_code))
        for j, joint in enumerate(joints):
            wanted = transform(rotations[0, j], translations[0, j], np.ones(3))
            np.testing.assert_allclose(played[joint], wanted, atol=TOLERANCE, err_msg=f"{skeleton} {joint}")


def _assert_all_variants(written: Written, root_path: Path) -> None:
    stage = Usd.Stage.Open(str(root_path))
    for result in written.results:
        character = result.character
        for name, samples in zip(variant_names(VARIANTS), result.variants, strict=True):
            select_variant(stage, str(character.model), character.variant_set, name)
            for frame in (0, 5, len(samples.time_codes) - 1):
                _assert_plays(stage, character, samples, frame)
        select_variant(stage, str(character.model), character.variant_set, "original")
        times = result.variants[0].time_codes
        for time_code in (float(times[0]), float(times[3]), float(times[3]) + 0.37, float(times[-1])):
            _assert_original(stage, written.source.stage, character, time_code)


def test_the_21_base_situations_are_all_there() -> None:
    """The contract names 21; a missing one would be missed silently."""
    assert len(BASE_SITUATIONS) == 21


def test_finds_the_characters(situation: Situation) -> None:
    """Who plays which sketch, where the variants go and what they are called."""
    stage = open_source(situation.shot).stage
    found = [result.character for result in make_results(stage, situation)]
    as_text = [
        (str(c.animation), tuple(map(str, c.skeletons)), str(c.model), c.variant_set, str(c.output)) for c in found
    ]
    assert as_text == [(e.animation, e.skeletons, e.model, e.variant_set, e.output) for e in situation.expected]


def test_variants_play_on_the_thin_root(written: Written) -> None:
    """The file to open in a viewer shows every variant as computed."""
    _assert_all_variants(written, written.thin_root)


def test_variants_play_stacked_over_the_shot(written: Written) -> None:
    """The override layer does the same in a layer stack of somebody else's."""
    layers = [written.override, written.situation.shot]
    root = stack_over(written.override.with_name("sequence.mtex.usda"), layers, written.source.stage)
    _assert_all_variants(written, root)


def test_best_path_is_selected_and_the_own_check_agrees(written: Written) -> None:
    """The check accepts what the tests above accept."""
    stage = Usd.Stage.Open(str(written.thin_root))
    for result in written.results:
        variants = stage.GetPrimAtPath(result.character.model).GetVariantSet(result.character.variant_set)
        assert variants.GetVariantSelection() == "path_01"
        assert variants.GetVariantNames() == ["original", "path_01", "path_02", "path_03"]
    check_override(written.thin_root, written.results)


@pytest.mark.parametrize("rerun_on", ["shot", "thin root"])
def test_rerun_reads_the_original_and_gives_equal_bytes(written: Written, rerun_on: str) -> None:
    """A second run, also on our own output, sees the animator's work and writes the same files."""
    before = written.override.read_bytes(), written.thin_root.read_bytes()
    source = open_source(written.situation.shot if rerun_on == "shot" else written.thin_root)
    assert source.source_path == written.situation.shot
    results = make_results(source.stage, written.situation, previous=written.override)
    assert [r.character for r in results] == [r.character for r in written.results]
    write_override(source.stage, results, written.override)
    assert (written.override.read_bytes(), written.thin_root.read_bytes()) == before


def test_outputs_are_no_sketches(written: Written) -> None:
    """The recipe that comes along with the reference is taken off again, in every variant."""
    stage = Usd.Stage.Open(str(written.thin_root))
    for result in written.results:
        for name in ("original", *variant_names(VARIANTS)):
            select_variant(stage, str(result.character.model), result.character.variant_set, name)
            output = stage.GetPrimAtPath(result.character.output)
            assert output.GetTypeName() == "SkelAnimation"
            assert output.GetMetadata("apiSchemas").GetAppliedItems() == []


def test_source_files_keep_their_bytes(situation: Situation) -> None:
    """Nothing the animator made is written, by two runs and a check."""
    before = {file_path: file_path.read_bytes() for file_path in situation.source_files}
    for _ in range(2):
        stage = open_source(situation.shot).stage
        results = make_results(stage, situation)
        _, thin_root = write_override(stage, results, situation.shot.with_name("shot.mtex.usd"))
        check_override(thin_root, results)
    assert {file_path: file_path.read_bytes() for file_path in situation.source_files} == before
