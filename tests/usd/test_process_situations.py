"""The whole job in every situation: recipe to override layer, and what plays is what was computed."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

import mtex_usd
from mtex_usd.usd.source_stage import open_source
from tests.usd.playback import animation_arrays, local_transforms, no_diagnostics, select_variant
from tests.usd.situations import SITUATIONS, Situation

TOLERANCE = 2e-5  # of single precision, on offsets near 100


@pytest.fixture(params=SITUATIONS)
def situation(request: pytest.FixtureRequest, tmp_path: Path) -> Situation:
    """Build each of the situations."""
    return SITUATIONS[request.param](tmp_path)


def _matrices(variant: mtex_usd.PathVariant, frame: int) -> dict[str, np.ndarray]:
    """What the method computed for every joint of the skeleton, as USD matrices."""
    clip = variant.motion.clip
    matrices = {}
    for j, joint in enumerate(clip.joints):
        w, x, y, z = clip.rotations[frame, j]
        rows = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
                [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
                [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
        matrices[joint] = np.eye(4)
        matrices[joint][:3, :3] = np.diag(clip.scales[frame, j]) @ rows
        matrices[joint][3, :3] = clip.translations[frame, j]
    return matrices


def test_every_variant_plays_as_computed(situation: Situation) -> None:
    """Every variant, read through UsdSkel on the thin root, equals the motion the method gave."""
    before = {path: path.read_bytes() for path in situation.source_files}
    with no_diagnostics():
        results = mtex_usd.process(situation.shot)
        stage = Usd.Stage.Open(str(results[0].stage))
    assert [(r.anim, r.model, r.variantSet) for r in results] == [
        (e.animation, e.model, e.variant_set) for e in situation.expected
    ]
    for result, expected in zip(results, situation.expected, strict=True):
        assert result.variants
        for variant in result.variants:
            select_variant(stage, result.model, result.variantSet, variant.name)
            times = variant.motion.clip.time_codes
            for frame in (0, len(times) // 2, len(times) - 1):
                played = local_transforms(stage, expected.skeletons[0], float(times[frame]))
                for joint, matrix in _matrices(variant, frame).items():
                    np.testing.assert_allclose(played[joint], matrix, atol=TOLERANCE, err_msg=joint)
    assert {path: path.read_bytes() for path in situation.source_files} == before


def test_untouched_joints_keep_their_bits(situation: Situation) -> None:
    """Joints without a role are in every variant what they are in the sketch, to the bit."""
    results = mtex_usd.process(situation.shot)
    source = open_source(situation.shot).stage
    stage = Usd.Stage.Open(str(results[0].stage))
    for result, expected in zip(results, situation.expected, strict=True):
        touched = {name.rpartition(".")[0] for name in result.texturing.channels}
        times = stage.GetPrimAtPath(expected.output).GetAttribute("rotations").GetTimeSamples()
        np.testing.assert_allclose(times, result.texturing.sketch.time_codes)
        joints, rotations, translations = animation_arrays(source, result.anim, times)
        kept = [j for j, joint in enumerate(joints) if joint not in touched]
        assert kept
        for variant in result.variants:
            select_variant(stage, result.model, result.variantSet, variant.name)
            own, now_rotations, now_translations = animation_arrays(stage, expected.output, times)
            assert own[: len(joints)] == joints
            np.testing.assert_array_equal(now_rotations[:, kept], rotations[:, kept])
            np.testing.assert_array_equal(now_translations[:, kept], translations[:, kept])


@pytest.mark.parametrize("rerun_on", ["shot", "thin root"])
def test_a_second_run_gives_equal_bytes(situation: Situation, rerun_on: str) -> None:
    """A second run, on the shot or on the thin root, works from the original and writes the same."""
    first = mtex_usd.process(situation.shot)[0]
    before = first.layer.read_bytes(), first.stage.read_bytes()
    again = mtex_usd.process(situation.shot if rerun_on == "shot" else first.stage)[0]
    assert (again.layer, again.stage) == (first.layer, first.stage)
    assert (again.layer.read_bytes(), again.stage.read_bytes()) == before
