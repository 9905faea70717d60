"""Who plays a sketch where it is not plain, and names that outlive a run."""

from pathlib import Path

import pytest
from pxr import Sdf, Usd, UsdSkel

from mtex_usd.errors import StageError
from mtex_usd.usd.characters import Character, find_characters
from mtex_usd.usd.override import write_override
from mtex_usd.usd.source_stage import open_source
from tests.usd.base_situations import build_local, build_unbound
from tests.usd.more_situations import build_two_instances, build_two_sketches
from tests.usd.synthetic import make_result


def _find(file_path: Path, *animations: str, previous: Path | None = None) -> tuple[Character, ...]:
    paths = [Sdf.Path(animation) for animation in animations]
    return find_characters(open_source(file_path).stage, paths, previous=previous)


def _edit(file_path: Path) -> Usd.Stage:
    return Usd.Stage.Open(str(file_path))


def test_missing_animation_is_named(tmp_path: Path) -> None:
    """A path that is not on the stage."""
    shot = build_local(tmp_path, "Skeleton").shot
    with pytest.raises(StageError, match="there is no prim /World/Gone"):
        _find(shot, "/World/Gone")


def test_unbound_outside_any_skel_root_is_an_error(tmp_path: Path) -> None:
    """Nothing says whom the animation is for."""
    shot = build_unbound(tmp_path).shot
    stage = _edit(shot)
    UsdSkel.Animation.Define(stage, "/World/Loose")
    stage.Save()
    with pytest.raises(StageError, match=r"no Skeleton plays /World/Loose.*found no Skeleton beside it"):
        _find(shot, "/World/Loose")


def test_unbound_with_two_skeletons_is_an_error_that_lists_them(tmp_path: Path) -> None:
    """Two Skeletons in the SkelRoot: guessing would be wrong half the time."""
    shot = build_unbound(tmp_path).shot
    stage = _edit(shot)
    UsdSkel.Skeleton.Define(stage, "/World/Char/Rig/Other")
    stage.Save()
    with pytest.raises(StageError, match=r"Skel playing nothing, /World/Char/Rig/Other playing nothing"):
        _find(shot, "/World/Char/Rig/Anim")


def _name_skeleton(stage: Usd.Stage, animation: str, skeleton: str) -> None:
    prim = stage.GetPrimAtPath(animation)
    prim.AddAppliedSchema("MtexTakeAPI")
    prim.CreateRelationship("mtex:take:skeleton", custom=False).SetTargets([skeleton])


def test_unbound_is_played_by_the_skeleton_it_names(tmp_path: Path) -> None:
    """Restyling inside a take library of several Skeletons; a name that leads nowhere else helps nobody."""
    shot = build_unbound(tmp_path).shot
    stage = _edit(shot)
    UsdSkel.Skeleton.Define(stage, "/World/Char/Rig/Other")
    _name_skeleton(stage, "/World/Char/Rig/Anim", "/World/Char/Rig/Other")
    stage.Save()
    (character,) = _find(shot, "/World/Char/Rig/Anim")
    assert character.skeletons == (Sdf.Path("/World/Char/Rig/Other"),)
    _name_skeleton(stage, "/World/Char/Rig/Anim", "/World/Char/Rig/Anim")
    stage.Save()
    with pytest.raises(StageError, match=r"no Skeleton plays .*name the Skeleton in the sketch's mtex:take:skeleton"):
        _find(shot, "/World/Char/Rig/Anim")


def test_a_skeleton_plays_one_unbound_sketch_and_the_one_that_names_it_first(tmp_path: Path) -> None:
    """Of two that name the same the first has it; one that names nothing gets what is left."""
    shot = build_unbound(tmp_path).shot
    stage = _edit(shot)
    UsdSkel.Skeleton.Define(stage, "/World/Char/Rig/Other")
    for name in ("Second", "Third"):
        UsdSkel.Animation.Define(stage, f"/World/Char/Rig/{name}")
        _name_skeleton(stage, f"/World/Char/Rig/{name}", "/World/Char/Rig/Other")
    stage.Save()
    unnamed, named = _find(shot, "/World/Char/Rig/Anim", "/World/Char/Rig/Second")
    assert (unnamed.skeletons[0].name, named.skeletons[0].name) == ("Skel", "Other")
    with pytest.raises(StageError, match=r"no Skeleton plays .*/Third.*Other playing /World/Char/Rig/Second"):
        _find(shot, "/World/Char/Rig/Second", "/World/Char/Rig/Third")


def test_unbound_leaves_a_skeleton_to_the_sketch_it_plays(tmp_path: Path) -> None:
    """A Skeleton that plays one sketch is not taken over by another."""
    shot = build_unbound(tmp_path).shot
    stage = _edit(shot)
    UsdSkel.Animation.Define(stage, "/World/Char/Walk")
    binding = UsdSkel.BindingAPI.Apply(stage.GetPrimAtPath("/World/Char/Rig/Skel"))
    binding.CreateAnimationSourceRel().SetTargets(["/World/Char/Walk"])
    stage.Save()
    with pytest.raises(StageError, match="Skel playing /World/Char/Walk"):
        _find(shot, "/World/Char/Walk", "/World/Char/Rig/Anim")
    (alone,) = _find(shot, "/World/Char/Rig/Anim")
    assert alone.skeletons == (Sdf.Path("/World/Char/Rig/Skel"),)


def test_a_binding_without_its_schema_counts_as_none(tmp_path: Path) -> None:
    """UsdSkel ignores it, and so must we."""
    shot = build_local(tmp_path, "Skeleton").shot
    stage = _edit(shot)
    stage.GetPrimAtPath("/World/Char/Rig/Skel").RemoveAppliedSchema("SkelBindingAPI")
    stage.Save()
    with pytest.raises(StageError, match="no Skeleton plays /World/Char/Anim"):
        _find(shot, "/World/Char/Anim")


def test_set_keeps_its_name_when_a_sketch_is_added_before_it(tmp_path: Path) -> None:
    """The face was there first, so it stays ``mtex``; the body, found first later, gets its own."""
    situation = build_two_sketches(tmp_path)
    stage = open_source(situation.shot).stage
    (face,) = find_characters(stage, [Sdf.Path("/World/Char/Face")])
    assert face.variant_set == "mtex"
    out, thin_root = write_override(stage, [make_result(stage, face, 0)], tmp_path / "shot.mtex.usd")
    both = _find(situation.shot, *situation.animations, previous=out)
    assert [c.variant_set for c in both] == ["mtex_Anim", "mtex"]
    assert _find(thin_root, *situation.animations) == both


def test_set_of_a_sketch_that_is_gone_is_free_again(tmp_path: Path) -> None:
    """Nobody can select its variants any more."""
    situation = build_two_sketches(tmp_path)
    stage = open_source(situation.shot).stage
    (body,) = find_characters(stage, [Sdf.Path("/World/Char/Anim")])
    out, _ = write_override(stage, [make_result(stage, body, 0)], tmp_path / "shot.mtex.usd")
    assert [c.variant_set for c in _find(situation.shot, "/World/Char/Face", previous=out)] == ["mtex_Face"]
    edited = _edit(situation.shot)
    edited.RemovePrim("/World/Char/Anim")
    edited.Save()
    assert [c.variant_set for c in _find(situation.shot, "/World/Char/Face", previous=out)] == ["mtex"]


def test_earlier_file_that_is_not_ours_says_nothing(tmp_path: Path) -> None:
    """Writing will refuse it; finding characters does not stumble over it."""
    shot = build_local(tmp_path, "Skeleton").shot
    (tmp_path / "shot.mtex.usd").write_text("no USD at all")
    (character,) = _find(shot, "/World/Char/Anim", previous=tmp_path / "shot.mtex.usd")
    assert character.variant_set == "mtex"


def test_names_of_others_are_left_to_them(tmp_path: Path) -> None:
    """A set ``mtex`` and a prim ``Anim_mtex`` that somebody else made are not merged into."""
    shot = build_local(tmp_path, "Skeleton").shot
    stage = _edit(shot)
    stage.DefinePrim("/World/Char/Anim_mtex")
    stage.GetPrimAtPath("/World/Char").GetVariantSets().AddVariantSet("mtex").AddVariant("theirs")
    stage.Save()
    (character,) = _find(shot, "/World/Char/Anim")
    assert (character.variant_set, character.output.name) == ("mtex_Anim", "Anim_2_mtex")


def test_one_animation_shared_by_two_instances_gives_two_characters(tmp_path: Path) -> None:
    """Bound from above, each instance gets a set of its own."""
    shot = build_two_instances(tmp_path).shot
    asset = _edit(tmp_path / "asset.usda")
    asset.GetPrimAtPath("/Char/Rig/Skel").RemoveProperty("skel:animationSource")
    asset.Save()
    stage = _edit(shot)
    UsdSkel.Animation.Define(stage, "/World/Walk")
    binding = UsdSkel.BindingAPI.Apply(stage.GetPrimAtPath("/World"))
    binding.CreateAnimationSourceRel().SetTargets(["/World/Walk"])
    stage.Save()
    found = _find(shot, "/World/Walk")
    assert [(str(c.model), c.variant_set) for c in found] == [("/World/One", "mtex"), ("/World/Two", "mtex")]
