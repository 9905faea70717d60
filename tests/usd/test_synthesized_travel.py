"""A root whose way is synthesized, through a stage: where it begins, and feet that are held on the way."""

from pathlib import Path

import numpy as np
import pytest

import mtex_usd
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip

SAMPLES = Path(__file__).resolve().parents[2] / "sample_stages"
STAGE = """#usda 1.0
(
    subLayers = [@{shot}@]
    defaultPrim = "Humanoid"
    metersPerUnit = 0.01
    framesPerSecond = 24
    timeCodesPerSecond = 24
    upAxis = "Y"
    startTimeCode = 0
    endTimeCode = 170
)

over "Humanoid"
{{
    over "Sketch"
    {{
        uniform token mtex:contacts = "{contacts}"
        uniform token[] mtex:synthesize = ["Hips.t", "Spine*", "Neck", "Head", "*Shoulder", "*Arm", "*Hand"]
    }}
}}
"""


def run(folder: Path, contacts: str) -> tuple[Clip, list[Clip]]:
    """Process the sample walk with its way synthesized; give the sketch and the variants."""
    stage = folder / "shot.usda"
    stage.write_text(STAGE.format(shot=(SAMPLES / "walk.usda").as_posix(), contacts=contacts))
    (result,) = mtex_usd.process(stage, paths=2)
    return mtex_usd.read_clip(stage, "/Humanoid/Sketch"), [variant.clip for variant in result.variants]


def test_the_character_starts_where_the_sketch_does(tmp_path: Path) -> None:
    sketch, variants = run(tmp_path, "off")
    for clip in variants:
        np.testing.assert_allclose(clip.translations[0, 0], sketch.translations[0, 0], atol=1e-5)
        assert 600.0 < clip.translations[-1, 0, 2] < 1000.0


def test_feet_go_with_the_body_and_are_held_on_the_way(tmp_path: Path) -> None:
    """The takes' way is a metre shorter than the sketch's; feet left where the sketch has them would pull it down."""
    sketch, variants = run(tmp_path, "detect")
    legs = [index for index, joint in enumerate(sketch.joints) if joint.endswith("Leg")]
    for clip in variants:
        shared = [clip.joints.index(sketch.joints[leg]) for leg in legs]
        assert abs(clip.translations[-1, 0, 2] - sketch.translations[-1, 0, 2]) > 50.0
        assert clip.translations[:, 0, 1].min() > sketch.translations[:, 0, 1].min() - 4.0
        turned = quaternion.angle_between(clip.rotations[:, shared], sketch.rotations[:, legs])
        assert np.degrees(turned).max() < 35.0
        assert np.linalg.norm(clip.translations[0, 0] - sketch.translations[0, 0]) == pytest.approx(0.0, abs=5.0)
