"""Next, Previous and Original show other paths of exactly the characters that are selected."""

import numpy as np
import pytest
from pxr import Sdf, Usd

from mtex_usd.usd.variants import choose_sets, describe_path, find_sets
from tests.usdview.shots import CHAR, OTHER, shown

SKELETONS = (f"{CHAR}/Rig/Skel", f"{CHAR}/Rig/FaceSkel", f"{OTHER}/Rig/Skel")


def selections(usdview):
    stage = usdview.model.stage
    places = ((CHAR, "mtex"), (CHAR, "mtex_Face"), (OTHER, "mtex"))
    return [stage.GetPrimAtPath(model).GetVariantSet(name).GetVariantSelection() for model, name in places]


def poses(stage):
    return [shown(stage, skeleton) for skeleton in SKELETONS]


def changed(before, after):
    return [not np.array_equal(a, b) for a, b in zip(before, after, strict=True)]


# What is picked, and which of (Char's Anim, Char's Face, Other's Anim) it stands for.
PICKS = {
    "mesh": ([f"{CHAR}/Rig/Body"], [1, 0, 0]),
    "other mesh of the model": ([f"{CHAR}/Rig/FaceMesh"], [0, 1, 0]),
    "skeleton": ([f"{CHAR}/Rig/Skel"], [1, 0, 0]),
    "animation": ([f"{CHAR}/Face"], [0, 1, 0]),
    "output": ([f"{CHAR}/Anim_mtex"], [1, 0, 0]),
    "SkelRoot": ([f"{OTHER}/Rig"], [0, 0, 1]),
    "model with two sets": ([CHAR], [1, 1, 0]),
    "two characters": ([f"{CHAR}/Rig/Body", OTHER], [1, 0, 1]),
    "a character and a stranger": (["/World/Box", OTHER], [0, 0, 1]),
    "parts of one character": ([f"{OTHER}/Rig/Body", f"{OTHER}/Rig/Skel", OTHER], [0, 0, 1]),
}


@pytest.mark.parametrize("pick", PICKS)
def test_next_changes_what_the_selected_skeletons_play_and_nothing_else(usdview, boxes, pick):
    paths, expected = PICKS[pick]
    before = poses(usdview.model.stage)
    usdview.select(*paths)
    usdview.trigger("Next Path")
    assert boxes == []
    assert selections(usdview) == [f"path_0{1 + step}" for step in expected]
    assert changed(before, poses(usdview.model.stage)) == [bool(step) for step in expected]


def test_previous_takes_next_back_and_both_go_round_the_ends(usdview):
    usdview.select(OTHER)
    before = poses(usdview.model.stage)
    names = []
    for entry in ("Next Path", "Next Path", "Next Path", "Previous Path", "Previous Path"):
        usdview.trigger(entry)
        names.append(selections(usdview)[2])
    assert names == ["path_02", "path_03", "path_01", "path_03", "path_02"]
    usdview.trigger("Previous Path")
    assert changed(before, poses(usdview.model.stage)) == [False, False, False]


def test_original_shows_what_the_animator_made(usdview, processed):
    shot = Usd.Stage.Open(str(processed.with_name("shot.usda")))
    usdview.select(OTHER)
    usdview.trigger("Original")
    assert selections(usdview) == ["path_01", "path_01", "original"]
    np.testing.assert_array_equal(shown(usdview.model.stage, SKELETONS[2]), shown(shot, SKELETONS[2]))
    usdview.trigger("Next Path")
    assert selections(usdview)[2] == "path_01"
    usdview.trigger("Original")
    usdview.trigger("Previous Path")
    assert selections(usdview)[2] == "path_03"


def test_what_is_selected_stands_in_the_session_layer_alone(usdview):
    stage = usdview.model.stage
    usdview.select(CHAR)
    usdview.trigger("Next Path")
    spec = stage.GetSessionLayer().GetPrimAtPath(CHAR)
    assert dict(spec.variantSelections.items()) == {"mtex": "path_02", "mtex_Face": "path_02"}
    assert not stage.GetSessionLayer().GetPrimAtPath(OTHER)
    assert not [layer.identifier for layer in stage.GetUsedLayers() if layer.dirty and not layer.anonymous]


def test_the_edit_target_of_the_user_does_not_count_and_stays(usdview):
    stage = usdview.model.stage
    target = Sdf.Layer.CreateAnonymous()
    stage.GetSessionLayer().subLayerPaths.append(target.identifier)
    stage.SetEditTarget(target)
    usdview.select(OTHER)
    usdview.trigger("Next Path")
    assert target.empty
    assert stage.GetEditTarget().GetLayer() == target


def test_the_status_line_says_what_is_shown(usdview):
    usdview.select(CHAR)
    usdview.trigger("Next Path")
    assert usdview.last_message == f"{CHAR}: path_02 (2 of 3); {CHAR} {{mtex_Face}}: path_02 (2 of 3)"
    usdview.trigger("Original")
    assert usdview.last_message == f"{CHAR}: original; {CHAR} {{mtex_Face}}: original"
    assert usdview.inner.redraws == 2


@pytest.mark.parametrize("entry", ["Next Path", "Original", "Paths...", "Show Fragments...", "Accept Path..."])
@pytest.mark.parametrize(
    ("picked", "message"),
    [
        (["/"], "nothing is selected; expected a character. Select a mesh"),
        (["/World/Box"], "nothing selected has paths to choose from; expected a character that was processed"),
        (["/World"], f"There are paths on {CHAR}, {OTHER}."),
    ],
)
def test_a_selection_without_paths_is_said_in_a_box(usdview, boxes, capfd, entry, picked, message):
    before = selections(usdview)
    usdview.select(*picked)
    usdview.trigger(entry)
    (text,) = boxes
    assert message in text
    assert "Traceback" not in text + capfd.readouterr().err
    assert selections(usdview) == before


def test_a_shot_that_was_not_processed_says_what_to_do(processed, boxes):
    from tests.usdview.usdview import Usdview

    plain = Usdview(Usd.Stage.Open(str(processed.with_name("shot.usda")))).load()
    plain.select(CHAR)
    plain.trigger("Next Path")
    assert boxes[0].endswith("Process the animation first.")


def test_a_bug_is_a_box_too_and_its_details_go_to_the_terminal(usdview, boxes, capfd, monkeypatch):
    from mtex_usd.usdview import commands

    monkeypatch.setattr(commands, "step_path", lambda *_: 1 / 0)
    usdview.select(CHAR)
    usdview.trigger("Next Path")
    assert boxes == ["This is a bug in usdmtex: ZeroDivisionError: division by zero. The terminal has the details."]
    assert "Traceback" in capfd.readouterr().err


def test_an_animation_stands_for_every_character_that_plays_it(tmp_path):
    from mtex_usd import process
    from tests.usd.more_situations import build_two_characters

    stage = Usd.Stage.Open(str(process(build_two_characters(tmp_path).shot)[0].stage))
    pick = [stage.GetPrimAtPath("/World/Pair/Anim")]
    assert [found.model for found in choose_sets(stage, pick)] == ["/World/Pair/A", "/World/Pair/B"]
    pick = [stage.GetPrimAtPath("/World/Pair/B/Skel")]
    assert [found.model for found in choose_sets(stage, pick)] == ["/World/Pair/B"]


def test_instances_are_switched_one_by_one(tmp_path):
    from mtex_usd import process
    from mtex_usd.usd.variants import step_path
    from tests.usd.more_situations import build_two_instances

    stage = Usd.Stage.Open(str(process(build_two_instances(tmp_path).shot)[0].stage))
    before = [shown(stage, f"/World/{name}/Rig/Skel") for name in ("One", "Two")]
    proxy = stage.GetPrimAtPath("/World/Two/Rig/Skel")
    assert proxy.IsInstanceProxy()
    step_path(stage, choose_sets(stage, [proxy]), 1)
    assert changed(before, [shown(stage, f"/World/{name}/Rig/Skel") for name in ("One", "Two")]) == [False, True]


def test_sets_of_others_are_left_alone(tmp_path):
    from tests.usd.base_situations import build_asset_variants

    stage = Usd.Stage.Open(str(build_asset_variants(tmp_path, "Skeleton").shot))
    stage.GetPrimAtPath("/World").GetVariantSets().AddVariantSet("mtex").AddVariant("original")
    assert find_sets(stage) == ()


def test_every_variant_says_what_it_is_whichever_is_shown(usdview):
    stage = usdview.model.stage
    found = find_sets(stage)[0]
    ranks = [describe_path(stage, found, f"path_0{number}")["rank"] for number in (1, 2, 3)]
    assert ranks == [1, 2, 3]
    assert describe_path(stage, found, "original") == {}
