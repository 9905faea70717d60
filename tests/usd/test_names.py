"""Names: valid, unique, close to the original."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pxr import Sdf

from mtex_usd.usd.names import build_joint_paths, make_prim_name, make_unique, make_unique_names


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("07_01", "take_07_01"),
        ("walk", "walk"),
        ("walk fast", "take_walk_fast"),
        ("a.b-c+d", "take_a_b_c_d"),
        ("läuft", "läuft"),
        ("歩く", "歩く"),
        ("", "take_"),
        ("😀", "take__"),
    ],
)
def test_prim_names(name: str, expected: str) -> None:
    assert make_prim_name(name, prefix="take_") == expected


def test_taken_names_get_a_number() -> None:
    assert make_unique("walk", {"run"}) == "walk"
    assert make_unique("walk", {"walk", "walk_2"}) == "walk_3"


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["Bone", "Bone.002", "Bone_002"], ("Bone", "Bone_002_2", "Bone_002")),
        (["mixamorig:Hips", "Left Arm", "3rd"], ("mixamorig_Hips", "Left_Arm", "_3rd")),
        (["Toe", "Toe", "Toe_2", "Toe"], ("Toe", "Toe_3", "Toe_2", "Toe_4")),
        (["a b", "a.b", "a_b"], ("a_b_2", "a_b_3", "a_b")),
    ],
)
def test_joint_names(names: list[str], expected: tuple[str, ...]) -> None:
    assert make_unique_names(names) == expected


def test_joint_paths_follow_the_parents() -> None:
    paths = build_joint_paths(["Hips", "Leg.L", "Toe", "Leg.R", "Toe", "Prop"], [-1, 0, 1, 0, 3, -1])
    assert paths == ("Hips", "Hips/Leg_L", "Hips/Leg_L/Toe", "Hips/Leg_R", "Hips/Leg_R/Toe_2", "Prop")


@given(st.lists(st.text(max_size=6) | st.sampled_from(["a", "a_2", "a.2", "a 2", "2", "_2"]), max_size=12))
def test_any_names_become_valid_and_unique(names: list[str]) -> None:
    unique = make_unique_names(names)
    assert len(unique) == len(names) == len(set(unique))
    assert all(Sdf.Path.IsValidIdentifier(name) for name in unique)
    for name in names:
        if Sdf.Path.IsValidIdentifier(name):
            assert unique[names.index(name)] == name
