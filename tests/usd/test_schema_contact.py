"""MtexContactAPI: the contract of its properties, and reading the contacts of an animation."""

from pathlib import Path

import pytest
from pxr import Sdf, Usd

from mtex_usd.errors import InputError, StageError
from mtex_usd.usd.schema import CONTACT_API, CONTACT_MODES, ContactSettings, read_contacts
from tests.usd.schema_support import check_presentation, open_sublayer, open_text, property_contract

PREFIX = "mtex:contact:__INSTANCE_NAME__:"
CONTRACT = {
    f"{PREFIX}joint": ("token", ""),
    f"{PREFIX}offset": ("point3d", (0.0, 0.0, 0.0)),
    f"{PREFIX}intervals": ("timecode[]", ()),
    f"{PREFIX}mode": ("token", "plant"),
    f"{PREFIX}target": ("rel", None),
    f"{PREFIX}point": ("point3d", None),
    f"{PREFIX}tolerance": ("double", 0.0005),
    f"{PREFIX}frequency": ("double", 6.0),
}


def contact_text(body: str, *, schemas: str = f'"{CONTACT_API}:left"') -> str:
    lines = "\n".join(f"    {line}" for line in body.splitlines())
    return f'def SkelAnimation "Anim" (prepend apiSchemas = [{schemas}])\n{{\n{lines}\n}}\ndef Xform "Door"\n{{\n}}\n'


def read_text(body: str, *, schemas: str = f'"{CONTACT_API}:left"') -> tuple[ContactSettings, ...]:
    stage = open_text(contact_text(body, schemas=schemas))
    return read_contacts(stage.GetPrimAtPath("/Anim"))


def test_properties_are_the_contract() -> None:
    assert property_contract(CONTACT_API) == CONTRACT


def test_properties_present_themselves() -> None:
    check_presentation(CONTACT_API)


def test_modes_are_those_of_the_schema() -> None:
    definition = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(CONTACT_API)
    assert tuple(definition.GetPropertyMetadata(f"{PREFIX}mode", "allowedTokens")) == CONTACT_MODES


def test_applies_to_animations_only() -> None:
    stage = Usd.Stage.CreateInMemory()
    assert stage.DefinePrim("/Anim", "SkelAnimation").CanApplyAPI(CONTACT_API, "left")
    assert not stage.DefinePrim("/Model", "Xform").CanApplyAPI(CONTACT_API, "left")


def test_defaults() -> None:
    assert read_text('token mtex:contact:left:joint = "Foot"') == (ContactSettings(name="left", joint="Foot"),)


def test_everything_authored() -> None:
    body = (
        'token mtex:contact:left:joint = "Hand"\npoint3d mtex:contact:left:offset = (1, 2, 3)\n'
        'timecode[] mtex:contact:left:intervals = [1, 5, 9, 9]\ntoken mtex:contact:left:mode = "follow"\n'
        "rel mtex:contact:left:target = </Door>\npoint3d mtex:contact:left:point = (0, 1, 0)\n"
        "double mtex:contact:left:tolerance = 0.002\ndouble mtex:contact:left:frequency = 3"
    )
    (contact,) = read_text(body)
    assert contact == ContactSettings(
        name="left",
        joint="Hand",
        offset=(1.0, 2.0, 3.0),
        intervals=(1.0, 5.0, 9.0, 9.0),
        mode="follow",
        target=Sdf.Path("/Door"),
        point=(0.0, 1.0, 0.0),
        tolerance=0.002,
        frequency=3.0,
    )


def test_contacts_come_by_name() -> None:
    body = 'token mtex:contact:b:joint = "B"\ntoken mtex:contact:a:joint = "A"'
    contacts = read_text(body, schemas=f'"{CONTACT_API}:b", "{CONTACT_API}:a"')
    assert [contact.name for contact in contacts] == ["a", "b"]


def test_contacts_of_a_schema_not_applied_do_not_count() -> None:
    assert read_text('token mtex:contact:left:joint = "Foot"', schemas='"SkelBindingAPI"') == ()


def test_layer_offset_moves_the_intervals() -> None:
    text = contact_text('token mtex:contact:left:joint = "Foot"\ntimecode[] mtex:contact:left:intervals = [10, 20]')
    stage = open_sublayer(text, Sdf.LayerOffset(100.0, 0.5))
    (contact,) = read_contacts(stage.GetPrimAtPath("/Anim"))
    assert contact.intervals == (105.0, 110.0)


def test_target_dropped_by_a_reference(tmp_path: Path) -> None:
    asset = tmp_path / "anim.usda"
    body = 'token mtex:contact:left:joint = "Hand"\nrel mtex:contact:left:target = </Door>'
    asset.write_text(f"#usda 1.0\n{contact_text(body)}", encoding="utf-8")
    stage = open_text(f'def "Anim" (references = @{asset}@</Anim>)\n{{\n}}\n')
    with pytest.raises(StageError, match=r"dropped the target /Door"):
        read_contacts(stage.GetPrimAtPath("/Anim"))


JOINT = 'token mtex:contact:left:joint = "Hand"\n'


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("", r"/Anim: contact left names no joint; expected token mtex:contact:left:joint"),
        ('token mtex:contact:left:joint = ""', r"joint is not allowed; expected the name of a joint"),
        (JOINT + "timecode[] mtex:contact:left:intervals = [1, 2, 3]", r"intervals is not allowed; expected start and"),
        (JOINT + "timecode[] mtex:contact:left:intervals = [3, 2]", r"intervals is not allowed; expected start and"),
        (JOINT + "timecode[] mtex:contact:left:intervals = [1, 5, 4, 8]", r"intervals is not allowed"),
        (
            JOINT + "double[] mtex:contact:left:intervals = [1, 5]",
            r"intervals has the wrong type",
        ),
        (JOINT + 'token mtex:contact:left:mode = "glue"', r'mode is not allowed; expected "plant" or "slide" or'),
        (
            JOINT + "double mtex:contact:left:tolerance = 0",
            r"tolerance is not allowed; expected a finite",
        ),
        (JOINT + "double mtex:contact:left:frequency = inf", r"frequency is not allowed"),
        (JOINT + "point3d mtex:contact:left:offset = (0, nan, 0)", r"offset is not allowed; expected finite"),
        (JOINT + "point3d mtex:contact:left:ofset = (0, 0, 0)", r"ofset is not a property.*mtex:contact:left:offset"),
        (JOINT + 'token mtex:contact:left:mode = "follow"', r"contact left follows nothing; expected rel"),
        (JOINT + 'token mtex:contact:left:mode = "touch"', r"contact left touches nothing; expected rel"),
        (
            JOINT + 'token mtex:contact:left:mode = "touch"\npoint3d mtex:contact:left:point = (0, 0, 0)',
            r"contact left has no time",
        ),
        (JOINT + "rel mtex:contact:left:target = [</Door>, </Anim>]", r"target is ambiguous; expected one prim"),
    ],
)
def test_bad_contacts(body: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_text(body)


def test_a_target_that_is_not_there() -> None:
    with pytest.raises(StageError, match=r"target names a prim that is not there; found /Window"):
        read_text(JOINT + "rel mtex:contact:left:target = </Window>")
