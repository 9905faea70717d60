"""MtexSketchAPI: the contract of its properties, and reading a recipe with and without it registered."""

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pxr import Gf, Sdf, Usd

from mtex_usd.errors import InputError
from mtex_usd.texture.recipe import PATH_COSTS, Recipe
from mtex_usd.usd.schema import SKETCH_API, TAKES_PROPERTY, api_instances, authored, has_api, read_recipe
from tests.usd.schema_support import check_presentation, open_text, property_contract, run_python

CONTRACT = {
    "mtex:takes": ("rel", None),
    "mtex:match": ("token[]", ()),
    "mtex:texture": ("token[]", ()),
    "mtex:synthesize": ("token[]", ()),
    "mtex:break": ("token", ""),
    "mtex:matchBand": ("int", 0),
    "mtex:matchLower": ("bool", Recipe().match_lower),
    "mtex:pathCost": ("token", Recipe().path_cost),
    "mtex:pathWeight": ("double", Recipe().path_weight),
    "mtex:diversity": ("double", 0.0),
    "mtex:textureBands": ("int2", (0, 0)),
    "mtex:synthesisBand": ("int", 0),
    "mtex:derivativeWeight": ("double", 1.0),
    "mtex:candidates": ("int", 0),
    "mtex:paths": ("int", 5),
    "mtex:maxStretch": ("double", 4.0),
    "mtex:scale": ("bool", False),
    "mtex:joinTime": ("double", 0.4),
    "mtex:contacts": ("token", "off"),
}

EVERYTHING = """
    uniform token[] mtex:match = ["LeftLeg.rx", "RightLeg.rx"]
    uniform token[] mtex:texture = ["*Leg*"]
    uniform token[] mtex:synthesize = ["Spine", "*Arm*"]
    uniform token mtex:break = "RightLeg.rx"
    uniform int mtex:matchBand = 4
    uniform bool mtex:matchLower = false
    uniform token mtex:pathCost = "consecutive"
    uniform double mtex:pathWeight = 0.25
    uniform double mtex:diversity = 6.5
    uniform int2 mtex:textureBands = (2, 3)
    uniform int mtex:synthesisBand = 2
    uniform double mtex:derivativeWeight = 0.5
    uniform int mtex:candidates = 12
    uniform int mtex:paths = 3
    uniform double mtex:maxStretch = 2.5
    uniform bool mtex:scale = true
    uniform double mtex:joinTime = 0.75
    uniform token mtex:contacts = "off"
"""
EVERYTHING_READ = Recipe(
    match=("LeftLeg.rx", "RightLeg.rx"),
    texture=("*Leg*",),
    synthesize=("Spine", "*Arm*"),
    break_channel="RightLeg.rx",
    match_band=4,
    match_lower=False,
    path_cost="consecutive",
    path_weight=0.25,
    diversity=6.5,
    texture_bands=(2, 3),
    synthesis_band=2,
    derivative_weight=0.5,
    candidates=12,
    paths=3,
    max_stretch=2.5,
    scale=True,
    join_time=0.75,
)


def sketch_text(body: str = "") -> str:
    return f'def SkelAnimation "Sketch" (prepend apiSchemas = ["{SKETCH_API}"])\n{{\n{body}\n}}\n'


def read_text(body: str) -> Recipe:
    stage = open_text(sketch_text(body))
    return read_recipe(stage.GetPrimAtPath("/Sketch"))


def test_properties_are_the_contract() -> None:
    assert property_contract(SKETCH_API) == CONTRACT


def test_properties_present_themselves() -> None:
    check_presentation(SKETCH_API)


def test_applies_to_animations_only() -> None:
    stage = Usd.Stage.CreateInMemory()
    assert stage.DefinePrim("/Sketch", "SkelAnimation").CanApplyAPI(SKETCH_API)
    assert not stage.DefinePrim("/Model", "Xform").CanApplyAPI(SKETCH_API)


def test_fallbacks_are_the_recipe_defaults() -> None:
    stage = open_text(sketch_text())
    prim = stage.GetPrimAtPath("/Sketch")
    attributes = [prim.GetAttribute(name) for name in CONTRACT if name != TAKES_PROPERTY]
    for attribute in attributes:
        attribute.Set(attribute.Get())
    assert len(attributes) == len(dataclasses.fields(Recipe)) - 1  # all but the segments
    assert read_recipe(prim) == Recipe()


def test_path_costs_are_the_allowed_tokens() -> None:
    definition = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(SKETCH_API)
    assert tuple(definition.GetPropertyMetadata("mtex:pathCost", "allowedTokens")) == PATH_COSTS
    assert tuple(definition.GetPropertyMetadata("mtex:contacts", "allowedTokens")) == ("off", "detect", "declared")


def limited_properties() -> list[tuple[str, str, float]]:
    if not hasattr(Usd.Attribute, "GetLimits"):
        return []
    definition = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(SKETCH_API)
    limits = {name: definition.GetPropertyMetadata(name, "limits") or {} for name in CONTRACT}
    return [(name, end, value) for name, both in limits.items() for end, value in both.get("hard", {}).items()]


@pytest.mark.skipif(not hasattr(Usd.Attribute, "GetLimits"), reason="this version of USD has no attribute limits")
def test_limits_are_there() -> None:
    assert {name for name, _, _ in limited_properties()} == {
        name for name, (kind, _) in CONTRACT.items() if kind in {"int", "double"}
    }


@pytest.mark.parametrize(("name", "end", "value"), limited_properties())
def test_reader_keeps_the_hard_limits(name: str, end: str, value: float) -> None:
    beyond = value + 1 if end == "maximum" else value - 1
    with pytest.raises(InputError, match=rf"/Sketch\.{name} is not allowed; expected .*; found {beyond}"):
        read_text(f"uniform {CONTRACT[name][0]} {name} = {beyond}")


def test_nothing_authored_gives_the_defaults() -> None:
    assert read_text("") == Recipe()


def test_everything_authored() -> None:
    assert read_text(EVERYTHING) == EVERYTHING_READ


FIELDS = {
    "mtex:match": "match",
    "mtex:texture": "texture",
    "mtex:synthesize": "synthesize",
    "mtex:break": "break_channel",
    "mtex:matchBand": "match_band",
    "mtex:matchLower": "match_lower",
    "mtex:pathCost": "path_cost",
    "mtex:pathWeight": "path_weight",
    "mtex:diversity": "diversity",
    "mtex:textureBands": "texture_bands",
    "mtex:synthesisBand": "synthesis_band",
    "mtex:derivativeWeight": "derivative_weight",
    "mtex:candidates": "candidates",
    "mtex:paths": "paths",
    "mtex:maxStretch": "max_stretch",
    "mtex:scale": "scale",
    "mtex:joinTime": "join_time",
    "mtex:contacts": "contacts",
}
BANDS = st.integers(0, 12)
TOKENS = st.lists(st.sampled_from(["Hips", "*Arm*", "Spine.rx", "Hips/LeftUpLeg.r"]), max_size=4).map(tuple)
RECIPES = st.builds(
    Recipe,
    match=TOKENS,
    texture=TOKENS,
    synthesize=TOKENS,
    break_channel=st.sampled_from(["", "Hips.rx"]),
    match_band=BANDS,
    match_lower=st.booleans(),
    path_cost=st.sampled_from(PATH_COSTS),
    path_weight=st.floats(0.0, 1e6),
    diversity=st.floats(0.0, 180.0),
    texture_bands=st.tuples(BANDS, BANDS).filter(lambda bands: 0 in bands or bands[0] <= bands[1]),
    synthesis_band=BANDS,
    derivative_weight=st.floats(0.0, 1e6),
    candidates=st.integers(0, 1000),
    paths=st.integers(1, 1000),
    max_stretch=st.floats(1.0, 1e6),
    scale=st.booleans(),
    join_time=st.floats(1e-6, 1e6),
    contacts=st.sampled_from(["off", "detect", "declared"]),
)


@given(recipe=RECIPES)
def test_what_is_written_is_read(recipe: Recipe) -> None:
    stage = open_text(sketch_text())
    prim = stage.GetPrimAtPath("/Sketch")
    for name, field in FIELDS.items():
        value = getattr(recipe, field)
        prim.GetAttribute(name).Set(Gf.Vec2i(*value) if field == "texture_bands" else value)
    assert read_recipe(prim) == recipe


def test_plain_attributes_count_too() -> None:
    assert read_text(EVERYTHING.replace("uniform", "custom")) == EVERYTHING_READ


def test_reads_the_same_unregistered() -> None:
    code = f"""
from pxr import Sdf, Usd
layer = Sdf.Layer.CreateAnonymous(".usda")
layer.ImportFromString('''#usda 1.0\n{sketch_text(EVERYTHING)}''')
stage = Usd.Stage.Open(layer)
prim = stage.GetPrimAtPath("/Sketch")
assert not prim.GetAppliedSchemas()
from mtex_usd.usd.plugin import registration_status
from mtex_usd.usd.schema import has_api, read_recipe
assert not registration_status().registered
print(has_api(prim, "{SKETCH_API}"), has_api(prim, "MtexTakeAPI"), read_recipe(prim))
"""
    assert run_python(code) == f"True False {EVERYTHING_READ}"


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (
            'string[] mtex:match = ["a"]',
            r"/Sketch\.mtex:match has the wrong type; expected token\[\]; found string\[\]",
        ),
        ('token mtex:match = "a"', r"mtex:match has the wrong type; expected token\[\]; found string a"),
        ("bool mtex:paths = 1", r"mtex:paths has the wrong type; expected int; found bool True"),
        ("double mtex:paths = 2.5", r"mtex:paths has the wrong type; expected int; found double 2.5"),
        ("int mtex:scale = 1", r"mtex:scale has the wrong type; expected bool; found int 1"),
        ("int[] mtex:textureBands = [2, 3]", r"mtex:textureBands has the wrong type; expected int2; found int\[\]"),
        ('string mtex:joinTime = "0.4"', r"mtex:joinTime has the wrong type; expected double; found string 0.4"),
        ("double mtex:joinTime = 0", r"mtex:joinTime is not allowed; expected seconds above 0; found 0.0"),
        ("double mtex:joinTime = nan", r"mtex:joinTime is not allowed; expected seconds above 0; found nan"),
        ("double mtex:pathWeight = inf", r"mtex:pathWeight is not allowed; expected a finite number, at least 0"),
        ("double mtex:maxStretch = 0.5", r"mtex:maxStretch is not allowed; expected a finite number, at least 1"),
        ("int2 mtex:textureBands = (3, 2)", r"mtex:textureBands is not allowed; expected .*first not above last"),
        ("int2 mtex:textureBands = (-1, 2)", r"mtex:textureBands is not allowed; .*found \(-1, 2\)"),
        ('token mtex:pathCost = "cheap"', r'mtex:pathCost is not allowed; expected "consecutive" or "continuity"'),
        ('token mtex:contacts = "always"', r"mtex:contacts is not allowed; .* found always"),
        ("int mtex:paths.timeSamples = { 1: 2 }", r"mtex:paths changes over time; expected one value for all time"),
        ('token[] mtex:synthesise = ["a"]', r"mtex:synthesise is not a property.*Did you mean mtex:synthesize\?"),
        ("int mtex:zzz = 1", r"mtex:zzz is not a property.*expected one of mtex:break, .*Remove it"),
    ],
)
def test_bad_values(body: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_text(body)


def test_narrow_numbers_are_widened() -> None:
    recipe = read_text("float mtex:joinTime = 0.5\nint mtex:pathWeight = 2\nstring mtex:break = 'Hips.rx'")
    assert (recipe.join_time, recipe.path_weight, recipe.break_channel) == (0.5, 2.0, "Hips.rx")
    assert isinstance(recipe.path_weight, float)


def test_one_of_two_texture_bands_may_be_left_open() -> None:
    assert read_text("int2 mtex:textureBands = (3, 0)").texture_bands == (3, 0)


def test_blocked_value_is_the_default() -> None:
    assert read_text("int mtex:paths = None").paths == Recipe().paths


def test_other_namespaces_below_ours_are_left_alone() -> None:
    assert read_text("double mtex:other:thing = 1") == Recipe()


def test_stronger_layer_wins_and_deletes() -> None:
    weak = Sdf.Layer.CreateAnonymous("weak.usda")
    weak.ImportFromString(f"#usda 1.0\n{sketch_text('int mtex:paths = 7')}")
    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().subLayerPaths.append(weak.identifier)
    prim = stage.GetPrimAtPath("/Sketch")
    assert has_api(prim, SKETCH_API)
    assert read_recipe(prim).paths == 7
    stage.OverridePrim("/Sketch").CreateAttribute("mtex:paths", Sdf.ValueTypeNames.Int).Set(2)
    assert read_recipe(prim).paths == 2
    prim.SetMetadata("apiSchemas", Sdf.TokenListOp.Create(deletedItems=[SKETCH_API]))
    assert not has_api(prim, SKETCH_API)


def test_built_in_schemas_count_as_applied() -> None:
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/Light", "SphereLight")
    assert has_api(prim, "LightAPI")
    assert api_instances(prim, "CollectionAPI") == ("lightLink", "shadowLink")


def test_authored_tells_nothing_from_something() -> None:
    stage = open_text(sketch_text("int mtex:paths = 5"))
    prim = stage.GetPrimAtPath("/Sketch")
    assert authored(prim, "mtex:paths") == 5
    assert authored(prim, "mtex:candidates") is None
    assert authored(prim, "mtex:missing") is None
