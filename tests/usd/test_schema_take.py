"""MtexTakeAPI: the contract of its properties, and reading the settings of a take."""

from pathlib import Path

import pytest
from pxr import Sdf, Usd

from mtex_usd.errors import InputError, StageError
from mtex_usd.usd.schema import TAKE_API, TakeSettings, read_take_settings
from tests.usd.schema_support import check_presentation, open_sublayer, open_text, property_contract

CONTRACT = {
    "mtex:take:start": ("timecode", None),
    "mtex:take:end": ("timecode", None),
    "mtex:take:style": ("token", ""),
    "mtex:take:skeleton": ("rel", None),
}


def take_text(body: str, *, schemas: str = f'"{TAKE_API}"') -> str:
    return f'def SkelAnimation "Take" (prepend apiSchemas = [{schemas}])\n{{\n{body}\n}}\n'


def read_text(body: str, *, schemas: str = f'"{TAKE_API}"') -> TakeSettings:
    stage = open_text(take_text(body, schemas=schemas))
    return read_take_settings(stage.GetPrimAtPath("/Take"))


def test_properties_are_the_contract() -> None:
    assert property_contract(TAKE_API) == CONTRACT


def test_properties_present_themselves() -> None:
    check_presentation(TAKE_API)


def test_applies_to_animations_only() -> None:
    stage = Usd.Stage.CreateInMemory()
    assert stage.DefinePrim("/Take", "SkelAnimation").CanApplyAPI(TAKE_API)
    assert not stage.DefinePrim("/Model", "Xform").CanApplyAPI(TAKE_API)


def test_nothing_authored() -> None:
    assert read_text("") == TakeSettings(start=None, end=None, style="", skeleton=None)


def test_everything_authored() -> None:
    settings = read_text(
        "timecode mtex:take:start = 1\ntimecode mtex:take:end = 99.5\n"
        'token mtex:take:style = "sad"\nrel mtex:take:skeleton = </Rig/Skeleton>'
    )
    assert settings == TakeSettings(start=1.0, end=99.5, style="sad", skeleton=Sdf.Path("/Rig/Skeleton"))


def test_properties_of_a_schema_not_applied_do_not_count() -> None:
    assert read_text("timecode mtex:take:start = 1", schemas='"SkelBindingAPI"') == TakeSettings()


def test_layer_offset_moves_the_range() -> None:
    text = take_text("timecode mtex:take:start = 10\ntimecode mtex:take:end = 20")
    stage = open_sublayer(text, Sdf.LayerOffset(100.0, 0.5))
    settings = read_take_settings(stage.GetPrimAtPath("/Take"))
    assert (settings.start, settings.end) == (105.0, 110.0)


def test_empty_skeleton_is_none() -> None:
    assert read_text("rel mtex:take:skeleton = []").skeleton is None
    assert read_text("rel mtex:take:skeleton").skeleton is None


def test_skeleton_target_dropped_by_a_reference(tmp_path: Path) -> None:
    asset = tmp_path / "takes.usda"
    asset.write_text(f"#usda 1.0\n{take_text('rel mtex:take:skeleton = </Rig/Skeleton>')}", encoding="utf-8")
    stage = open_text(f'def "Take" (references = @{asset}@</Take>)\n{{\n}}\n')
    with pytest.raises(StageError, match=r"dropped the target /Rig/Skeleton; .*takes\.usda.*referencing layer"):
        read_take_settings(stage.GetPrimAtPath("/Take"))


def test_skeleton_taken_back_by_a_stronger_layer(tmp_path: Path) -> None:
    asset = tmp_path / "takes.usda"
    asset.write_text(f"#usda 1.0\n{take_text('rel mtex:take:skeleton = </Rig/Skeleton>')}", encoding="utf-8")
    stage = open_text(f'def "Take" (references = @{asset}@</Take>)\n{{\nrel mtex:take:skeleton = []\n}}\n')
    assert read_take_settings(stage.GetPrimAtPath("/Take")).skeleton is None


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (
            "timecode mtex:take:start = 9\ntimecode mtex:take:end = 2",
            r"/Take: the take ends before it starts; expected start before end; found 9 to 2",
        ),
        ("double mtex:take:end = 2", r"/Take\.mtex:take:end has the wrong type; expected timecode; found double 2.0"),
        ("timecode mtex:take:end = inf", r"mtex:take:end is not allowed; expected a finite time code"),
        ("timecode mtex:take:begin = 2", r"mtex:take:begin is not a property of the mtex schemas"),
        (
            "rel mtex:take:skeleton = [</A>, </B>]",
            r"mtex:take:skeleton is ambiguous; expected one Skeleton; found /A, /B",
        ),
    ],
)
def test_bad_settings(body: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_text(body)
