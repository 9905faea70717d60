"""Key reduction in stacks: what is written plays within the tolerances between frames."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd

import mtex_usd
from mtex_usd import edit
from tests.captures import load_capture
from tests.usd.edit_support import ANIMATION, FEW, FRAMES, by_variant, play, write_shot
from tests.usd.playback import select_variant


def test_poses_play_within_tolerance_at_sub_frames(tmp_path: Path) -> None:
    """What is written are the poses alone; UsdSkel's own slerp between them stays within both tolerances."""
    found = by_variant(mtex_usd.apply_edits(write_shot(tmp_path, FEW, ["calm", "few"])))
    few = found["edited"]
    stage = Usd.Stage.Open(str(few.stage))
    times = stage.GetPrimAtPath(f"{ANIMATION}_mtex").GetAttribute("rotations").GetTimeSamples()
    assert isinstance(few.keys, edit.ReducedPoses)
    assert times == few.keys.time_codes.tolist()
    assert {0.0, 17.0, 43.0, 59.0} <= set(times)
    assert len(times) < 0.75 * FRAMES
    sub_frames = np.linspace(0.0, 59.0, 59 * 5 + 1).tolist()
    whole, sparse = (play(few.stage, sub_frames, name) for name in ("all", "edited"))
    assert degrees_between(whole, sparse).max() <= 1.0 + 2e-3
    places = [place_matrices(few.clip.parents.tolist(), poses) for poses in (whole, sparse)]
    assert np.linalg.norm(places[0] - places[1], axis=-1).max() <= 1.0 + 1e-2


def degrees_between(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Angles between the rotations of matrices; from their difference, since an arc cosine loses small ones."""
    apart = np.linalg.norm(one[..., :3, :3] - two[..., :3, :3], axis=(-2, -1)) / np.sqrt(8.0)
    return 2.0 * np.degrees(np.arcsin(np.clip(apart, 0.0, 1.0)))


def place_matrices(parents: list[int], poses: np.ndarray) -> np.ndarray:
    """Where the joints of local matrices [F, J, 4, 4] are, [F, J, 3]."""
    world = np.array(poses)
    for joint, parent in enumerate(parents):
        if parent >= 0:
            world[:, joint] = poses[:, joint] @ world[:, parent]
    return world[..., 3, :3]


@pytest.mark.parametrize(("contacts", "kept"), [("declared", True), ("off", False)])
def test_borders_of_declared_contacts_are_kept(tmp_path: Path, contacts: str, kept: bool) -> None:
    contact = """
    uniform token mtex:contact:hand:joint = "LeftForeArm"
    uniform timecode[] mtex:contact:hand:intervals = [11, 12, 36, 37]
"""
    body = FEW.replace('["calm", "few"]', '["few"]').replace("tolerance = 1", "tolerance = 20").replace("0.01", "0.2")
    body += f'{contact}\nuniform token mtex:edit:few:contacts = "{contacts}"'
    shot = write_shot(tmp_path, body, ["calm", "few"], schemas=["MtexContactAPI:hand"])
    keys = by_variant(mtex_usd.apply_edits(shot))["edited"].keys
    assert ({11, 12, 36, 37} <= set(keys.frames.tolist())) == kept


def test_poses_between_which_something_is_edited_are_samples_again(tmp_path: Path) -> None:
    body = FEW.replace('["calm", "few"]', '["few", "calm"]')
    found = by_variant(mtex_usd.apply_edits(write_shot(tmp_path, body, ["calm", "few"])))
    assert found["edited"].keys is None
    stage = Usd.Stage.Open(str(found["edited"].stage))
    assert len(stage.GetPrimAtPath(f"{ANIMATION}_mtex").GetAttribute("rotations").GetTimeSamples()) == FRAMES


CAPTURE = """#usda 1.0
(
    subLayers = [@./walk.usd@]
    timeCodesPerSecond = 120
    framesPerSecond = 120
    metersPerUnit = 0.05644
    upAxis = "Y"
)
over "Walk"
{
    over "walk" (
        prepend apiSchemas = ["MtexEditStackAPI", "MtexEditAPI:curves", "MtexEditAPI:poses", "MtexEditAPI:calm"]
    )
    {
        uniform token[] mtex:edits:few = ["calm", "poses"]
        uniform token mtex:edit:calm:op = "lowpass"
        uniform double[] mtex:edit:calm:frequencies = [6]
        uniform token[] mtex:edits:curves = ["curves"]
        uniform token[] mtex:edits:poses = ["poses"]
        uniform token mtex:edit:curves:op = "reduceKeys"
        uniform token mtex:edit:poses:op = "reduceKeys"
        uniform token mtex:edit:poses:form = "poses"
    }
}
"""


@pytest.fixture(scope="module")
def capture(data_dir: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Reduce CMU 07_01 with the tolerances that the schema falls back to, half a degree and 5 mm."""
    folder = tmp_path_factory.mktemp("capture")
    mtex_usd.write_clip(load_capture(data_dir, "07_01"), folder / "walk.usd", "/Walk/walk")
    (folder / "shot.usda").write_text(CAPTURE, encoding="utf-8")
    return by_variant(mtex_usd.apply_edits(folder / "shot.usda"))


@pytest.mark.parametrize("variant", ["curves", "poses"])
def test_reduced_captures_play_within_tolerance_at_sub_frames(capture: dict[str, Any], variant: str) -> None:
    """Against the capture itself, both through UsdSkel, at every quarter of a frame."""
    result, times = capture[variant], capture[variant].clip.time_codes
    sub_frames = np.linspace(times[0], times[-1], 4 * (len(times) - 1) + 1).tolist()
    named = {"skeleton": "/Walk/Skeleton", "model": "/Walk"}
    whole, reduced = (play(result.stage, sub_frames, name, **named) for name in ("original", variant))
    assert degrees_between(whole, reduced).max() <= 0.5 + 2e-3
    places = [place_matrices(result.clip.parents.tolist(), poses) for poses in (whole, reduced)]
    assert np.linalg.norm(places[0] - places[1], axis=-1).max() * 0.05644 <= 0.005 + 2e-5
    assert np.abs(whole - reduced).max() > 1e-4


def test_reduced_captures_have_few_poses(capture: dict[str, Any]) -> None:
    """Once what shakes in the fingers is out; as recorded they leave almost every frame."""
    stage = Usd.Stage.Open(str(capture["few"].stage))
    select_variant(stage, "/Walk", "mtex", "few")
    times = stage.GetPrimAtPath("/Walk/walk_mtex").GetAttribute("rotations").GetTimeSamples()
    assert len(times) == len(capture["few"].keys.frames) <= 0.4 * capture["few"].clip.frame_count
