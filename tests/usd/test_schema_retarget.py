"""MtexRetargetAPI: the contract of its properties, and reading pairs of joints."""

import pytest
from pxr import Usd

from mtex_usd.constraints.retargeting import Pair
from mtex_usd.errors import InputError
from mtex_usd.usd.schema import RETARGET_API, read_pairs
from tests.usd.schema_support import PROJECT, check_presentation, open_text, property_contract, run_python

PAIRS = "mtex:retarget:pairs"


def read_text(body: str, *, schemas: str = f'"{RETARGET_API}"') -> tuple[Pair, ...]:
    stage = open_text(f'def SkelAnimation "Take" (prepend apiSchemas = [{schemas}])\n{{\n{body}\n}}\n')
    return read_pairs(stage.GetPrimAtPath("/Take"))


def read_names(*names: str) -> tuple[Pair, ...]:
    quoted = ", ".join(f'"{name}"' for name in names)
    return read_text(f"uniform token[] {PAIRS} = [{quoted}]")


def test_properties_are_the_contract() -> None:
    assert property_contract(RETARGET_API) == {PAIRS: ("token[]", ())}


def test_properties_present_themselves() -> None:
    check_presentation(RETARGET_API)


def test_applies_to_animations_only() -> None:
    stage = Usd.Stage.CreateInMemory()
    assert stage.DefinePrim("/Take", "SkelAnimation").CanApplyAPI(RETARGET_API)
    assert not stage.DefinePrim("/Model", "Xform").CanApplyAPI(RETARGET_API)


def test_applies_beside_the_others() -> None:
    schemas = f'"MtexSketchAPI", "{RETARGET_API}", "MtexSegmentAPI:late"'
    assert read_text(f'uniform token[] {PAIRS} = ["Head", "skull"]', schemas=schemas) == (Pair("Head", "skull"),)


def test_nothing_authored() -> None:
    assert read_text("") == ()
    assert read_names() == ()


def test_names_in_turn() -> None:
    pairs = read_names("Head", "skull", "Hips/Tail", "root/tail1", "Jaw", "")
    assert pairs == (Pair("Head", "skull"), Pair("Hips/Tail", "root/tail1"), Pair("Jaw", ""))


def test_one_joint_of_a_take_may_drive_several() -> None:
    assert read_names("A", "x", "B", "x") == (Pair("A", "x"), Pair("B", "x"))


def test_joints_left_at_rest_may_be_several() -> None:
    assert read_names("A", "", "B", "") == (Pair("A", ""), Pair("B", ""))


def test_pairs_of_a_schema_not_applied_do_not_count() -> None:
    assert read_text(f'uniform token[] {PAIRS} = ["Head", "skull"]', schemas='"MtexTakeAPI"') == ()


def test_the_strongest_opinion_is_the_whole_list() -> None:
    stage = open_text(
        f'class "Rig"\n{{\nuniform token[] {PAIRS} = ["Head", "skull"]\n}}\n'
        f'def SkelAnimation "Take" (prepend apiSchemas = ["{RETARGET_API}"]\n inherits = </Rig>)\n'
        f'{{\nuniform token[] {PAIRS} = ["Jaw", "chin"]\n}}\n'
    )
    assert read_pairs(stage.GetPrimAtPath("/Take")) == (Pair("Jaw", "chin"),)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (
            f'uniform token[] {PAIRS} = ["Head", "skull", "Jaw"]',
            rf"/Take\.{PAIRS}: a joint lacks its partner; expected names in pairs; found 3 names, the last being 'Jaw'",
        ),
        (
            f'uniform token[] {PAIRS} = ["Head", "a", "Head", "b"]',
            rf"/Take\.{PAIRS}: the character's joints have to be named once; found 'Head' in \['Head', 'Head'\]",
        ),
        (f'uniform token[] {PAIRS} = ["", "a"]', rf"{PAIRS}: the character's joints have to be named once; found ''"),
        (f'uniform token {PAIRS} = "Head"', rf"/Take\.{PAIRS} has the wrong type; expected token\[\]"),
        (
            'uniform token[] mtex:retarget:pair = ["Head", "skull"]',
            rf"mtex:retarget:pair is not a property of the mtex schemas; .*Did you mean {PAIRS}\?",
        ),
        (
            f'token[] {PAIRS}.timeSamples = {{ 1: ["Head", "a"], 2: ["Head", "b"] }}',
            rf"/Take\.{PAIRS} changes over time",
        ),
    ],
)
def test_bad_pairs(body: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_text(body)


def test_reads_where_the_schema_is_not_registered() -> None:
    """A stage opened before our plugin was there: the metadata and the authored attribute say it all."""
    text = (
        f'#usda 1.0\ndef SkelAnimation "T" (prepend apiSchemas = ["{RETARGET_API}"])\n'
        f'{{\nuniform token[] {PAIRS} = ["Head", "skull"]\n}}\n'
    )
    code = (
        "from pxr import Usd, Sdf\n"
        "layer = Sdf.Layer.CreateAnonymous('s.usda')\n"
        f"layer.ImportFromString({text!r})\n"
        "stage = Usd.Stage.Open(layer)\n"
        f"known = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition('{RETARGET_API}') is not None\n"
        "from mtex_usd.usd.schema import read_pairs\n"
        "print(known, read_pairs(stage.GetPrimAtPath('/T')))"
    )
    assert run_python(code, folder=PROJECT) == "False (Pair(joint='Head', source='skull'),)"
