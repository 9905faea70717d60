"""MtexEditAPI and MtexEditStackAPI: the contract of their properties, and reading edits, registered or not."""

import inspect
import math
from collections.abc import Callable

import pytest
from pxr import Sdf, Usd

from mtex_usd import edit
from mtex_usd.edit.stack.operations import OPERATIONS
from mtex_usd.edit.stack.span import span_weights
from mtex_usd.errors import InputError, StageError
from mtex_usd.usd.schema import EDIT_API, EDIT_STACK_API, EditSettings, EditStacks, read_edit, read_stacks
from tests.synthetic import walk
from tests.usd.schema_support import check_presentation, open_sublayer, open_text, property_contract, run_python

PREFIX = "mtex:edit:__INSTANCE_NAME__:"
SETTINGS = {
    "op": ("token", ""),
    "channels": ("token[]", ()),
    "start": ("timecode", None),
    "end": ("timecode", None),
    "ramp": ("double", 0.4),
    "frequencies": ("double[]", ()),
    "order": ("int", 4),
    "gains": ("double[]", ()),
    "residualGain": ("double", 0.0),
    "window": ("double", None),
    "discard": ("double", 1.0 / 3.0),
    "points": ("double2[]", ()),
    "about": ("token", "mean"),
    "limits": ("double2", None),
    "softness": ("double", 10.0),
    "plane": ("token", "rest"),
    "factor": ("double", 1.0),
    "from": ("timecode[]", ()),
    "to": ("timecode[]", ()),
    "ends": ("token", "hold"),
    "with": ("rel", None),
    "weights": ("double[]", ()),
    "keys": ("timecode[]", ()),
    "align": ("bool", False),
    "place": ("token", "first"),
    "maxSlope": ("int", 3),
    "band": ("double", 1.0),
    "free": ("double", 0.0),
    "joinTime": ("double", 0.4),
    "method": ("token", "auto"),
    "rotations": ("double3[]", ()),
    "translations": ("double3[]", ()),
    "scope": ("double2", None),
    "tolerance": ("double", 0.5),
    "distance": ("double", 0.005),
    "keyCount": ("int", 0),
    "form": ("token", "curves"),
    "contacts": ("token", "declared"),
    "robust": ("bool", False),
}
STACKS = dict.fromkeys(("mtex:edits", "mtex:edits:before", "mtex:edits:after"), ("token[]", ()))

EVERYTHING = """
    uniform token mtex:edit:e:op = "lowpass"
    uniform token[] mtex:edit:e:channels = ["*Arm*", "Hips.tx"]
    uniform timecode mtex:edit:e:start = 5
    uniform timecode mtex:edit:e:end = 6.5
    uniform double mtex:edit:e:ramp = 0
    uniform double[] mtex:edit:e:frequencies = [1.5, 3]
    uniform int mtex:edit:e:order = 2
    uniform double[] mtex:edit:e:gains = [0, -inf, 6]
    uniform double mtex:edit:e:residualGain = -inf
    uniform double mtex:edit:e:window = 0.2
    uniform double mtex:edit:e:discard = 0.25
    uniform double2[] mtex:edit:e:points = [(-10, -5), (10, 20)]
    uniform token mtex:edit:e:about = "rest"
    uniform double2 mtex:edit:e:limits = (-inf, 30)
    uniform double mtex:edit:e:softness = 5
    uniform token mtex:edit:e:plane = "facing"
    uniform double mtex:edit:e:factor = 1.25
    uniform timecode[] mtex:edit:e:from = [1, 2]
    uniform timecode[] mtex:edit:e:to = [1, 3]
    uniform token mtex:edit:e:ends = "extrapolate"
    uniform double[] mtex:edit:e:weights = [-0.5, 1.5]
    uniform timecode[] mtex:edit:e:keys = [4, 8]
    uniform bool mtex:edit:e:align = true
    uniform token mtex:edit:e:place = "mean"
    uniform int mtex:edit:e:maxSlope = 2
    uniform double mtex:edit:e:band = 2
    uniform double mtex:edit:e:free = 0.5
    uniform double mtex:edit:e:joinTime = 0.3
    uniform token mtex:edit:e:method = "blend"
    uniform double3[] mtex:edit:e:rotations = [(1, 2, 3)]
    uniform double3[] mtex:edit:e:translations = [(4, 5, 6)]
    uniform double2 mtex:edit:e:scope = (0.5, 1)
    uniform double mtex:edit:e:tolerance = 1
    uniform double mtex:edit:e:distance = 0.01
    uniform int mtex:edit:e:keyCount = 12
    uniform token mtex:edit:e:form = "poses"
    uniform token mtex:edit:e:contacts = "off"
    uniform bool mtex:edit:e:robust = true
"""
EVERYTHING_READ = {
    "channels": ("*Arm*", "Hips.tx"),
    "start": 5.0,
    "end": 6.5,
    "ramp": 0.0,
    "frequencies": (1.5, 3.0),
    "order": 2,
    "gains": (0.0, -math.inf, 6.0),
    "residualGain": -math.inf,
    "window": 0.2,
    "discard": 0.25,
    "points": ((-10.0, -5.0), (10.0, 20.0)),
    "about": "rest",
    "limits": (-math.inf, 30.0),
    "softness": 5.0,
    "plane": "facing",
    "factor": 1.25,
    "from": (1.0, 2.0),
    "to": (1.0, 3.0),
    "ends": "extrapolate",
    "weights": (-0.5, 1.5),
    "keys": (4.0, 8.0),
    "align": True,
    "place": "mean",
    "maxSlope": 2,
    "band": 2.0,
    "free": 0.5,
    "joinTime": 0.3,
    "method": "blend",
    "rotations": ((1.0, 2.0, 3.0),),
    "translations": ((4.0, 5.0, 6.0),),
    "scope": (0.5, 1.0),
    "tolerance": 1.0,
    "distance": 0.01,
    "keyCount": 12,
    "form": "poses",
    "contacts": "off",
    "robust": True,
}


def edit_text(body: str, *, schemas: str = f'"{EDIT_API}:e"') -> str:
    others = 'def SkelAnimation "Other"\n{\n}\ndef Xform "Door"\n{\n}\n'
    return f'def SkelAnimation "Anim" (prepend apiSchemas = [{schemas}])\n{{\n{body}\n}}\n{others}'


def read_text(body: str) -> EditSettings:
    """Read the edit `e`; properties may be named without their prefix, and the operation left out."""
    stage = open_text(edit_text(body))
    return read_edit(stage.GetPrimAtPath("/Anim"), "e")


def read_one(type_name: str, name: str, value: str) -> EditSettings:
    operation = "" if name == "op" else 'token mtex:edit:e:op = "lowpass"\n'
    return read_text(f"{operation}{type_name} mtex:edit:e:{name} = {value}")


def stacks_of(body: str, *, edits: str = "abc") -> EditStacks:
    schemas = ", ".join(f'"{name}"' for name in [EDIT_STACK_API, *(f"{EDIT_API}:{each}" for each in edits)])
    stage = open_text(edit_text(body, schemas=schemas))
    return read_stacks(stage.GetPrimAtPath("/Anim"))


# --- the registered schemas ---


def test_properties_are_the_contract() -> None:
    assert property_contract(EDIT_API) == {f"{PREFIX}{name}": value for name, value in SETTINGS.items()}
    assert property_contract(EDIT_STACK_API) == STACKS


@pytest.mark.parametrize("api_name", [EDIT_API, EDIT_STACK_API])
def test_properties_present_themselves(api_name: str) -> None:
    check_presentation(api_name)


def test_applies_to_animations_only() -> None:
    stage = Usd.Stage.CreateInMemory()
    animation, model = stage.DefinePrim("/Anim", "SkelAnimation"), stage.DefinePrim("/Model", "Xform")
    assert animation.CanApplyAPI(EDIT_API, "e")
    assert animation.CanApplyAPI(EDIT_STACK_API)
    assert not model.CanApplyAPI(EDIT_API, "e")
    assert not model.CanApplyAPI(EDIT_STACK_API)


def test_operations_are_the_allowed_tokens() -> None:
    definition = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(EDIT_API)
    assert tuple(definition.GetPropertyMetadata(f"{PREFIX}op", "allowedTokens")) == ("", *OPERATIONS)


def test_every_setting_is_taken_by_an_operation() -> None:
    """And no operation takes one that the schema does not have."""
    taken = {name for operation in OPERATIONS.values() for name in operation.settings}
    assert taken == set(SETTINGS) - {"op"}


# By property: the functions that fall back, and the name of their argument.
FALLBACKS: dict[str, tuple[str, list[Callable[..., object]]]] = {
    "channels": (
        "channels",
        [edit.lowpass, edit.equalize, edit.median, edit.robust_mean, edit.align, edit.reduce_keys],
    ),
    "order": ("order", [edit.lowpass, edit.highpass, edit.bandpass]),
    "residualGain": ("residual_gain", [edit.equalize]),
    "discard": ("discard", [edit.robust_mean]),
    "about": ("about", [edit.waveshape]),
    "softness": ("softness", [edit.make_soft_limits]),
    "plane": ("plane", [edit.mirror]),
    "ends": ("ends", [edit.shift_time, edit.scale_time, edit.warp_time]),
    "maxSlope": ("max_slope", [edit.align]),
    "band": ("band_s", [edit.align]),
    "free": ("free_s", [edit.align]),
    "joinTime": ("blend_s", [edit.join]),
    "method": ("method", [edit.join]),
    "tolerance": ("tolerance_deg", [edit.reduce_keys, edit.reduce_poses]),
    "distance": ("tolerance_m", [edit.reduce_keys, edit.reduce_poses]),
    "robust": ("robust", [edit.reduce_keys, edit.reduce_poses]),
}


@pytest.mark.parametrize("name", FALLBACKS)
def test_fallbacks_are_those_of_the_functions(name: str) -> None:
    argument, functions = FALLBACKS[name]
    for function in functions:
        assert inspect.signature(function).parameters[argument].default == SETTINGS[name][1], function


# What falls back in the stack itself, or may not be said beside something else, is left to its own tests.
SAID = {
    "lowpass": {"frequencies": (3.0,)},
    "highpass": {"frequencies": (1.0,)},
    "bandpass": {"frequencies": (1.0, 3.0)},
    "equalize": {"gains": (3.0,)},
    "median": {"window": 0.2},
    "robustMean": {"window": 0.3},
    "waveshape": {"channels": ("LeftArm",), "points": ((-10.0, -5.0), (10.0, 9.0))},
    "mirror": {},
    "shiftTime": {"from": (2.0,), "to": (5.0,)},
    "scaleTime": {"factor": 1.5, "end": 70.0},
    "warpTime": {"from": (0.0, 20.0, 39.0), "to": (0.0, 25.0, 39.0), "end": 45.0},
    "align": {},
    "blend": {"weights": (0.5,)},
    "join": {},
    "displace": {"keys": (20.0,), "channels": ("LeftArm",), "rotations": ((0.0, 0.0, 30.0),)},
    "reduceKeys": {},
}
# Fallbacks that mean "not said", and those that say nothing beside what SAID says.
UNSAID = {"start", "end", "window", "limits", "scope", "softness", "frequencies", "gains", "points", "from", "to"}
UNSAID |= {"weights", "keys", "rotations", "translations", "with", "op"}


@pytest.mark.parametrize("op", OPERATIONS)
def test_authoring_the_fallbacks_changes_nothing(op: str) -> None:
    """What usdview shows for a property that is not authored is what is done."""
    clip, other = walk(40, seed=1), walk(40, seed=2)
    others = (other,) if OPERATIONS[op].others[0] else ()
    fallbacks = {name: SETTINGS[name][1] for name in OPERATIONS[op].settings if name not in UNSAID | set(SAID[op])}
    outcomes = [
        edit.run_stack(clip, [edit.Edit(name="e", op=op, settings=settings, others=others)])
        for settings in (SAID[op], {**fallbacks, **SAID[op]})
    ]
    assert outcomes[0].clip.rotations.tobytes() == outcomes[1].clip.rotations.tobytes()
    assert outcomes[0].clip.translations.tobytes() == outcomes[1].clip.translations.tobytes()
    assert outcomes[0].notes == outcomes[1].notes


def test_ramp_falls_back_as_the_schema_says() -> None:
    clip = walk(40)
    short, said = ({"start": 10.0}, {"start": 10.0, "ramp": SETTINGS["ramp"][1]})
    weights = [span_weights(edit.Edit(name="e", op="median", settings=each), clip) for each in (short, said)]
    assert weights[0] is not None
    assert weights[0].tolist() == weights[1].tolist()


def limited_properties() -> list[tuple[str, str, float]]:
    if not hasattr(Usd.Attribute, "GetLimits"):
        return []
    definition = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(EDIT_API)
    limits = {name: definition.GetPropertyMetadata(f"{PREFIX}{name}", "limits") or {} for name in SETTINGS}
    return [(name, end, value) for name, both in limits.items() for end, value in both.get("hard", {}).items()]


@pytest.mark.parametrize(("name", "end", "value"), limited_properties())
def test_reader_keeps_the_hard_limits(name: str, end: str, value: float) -> None:
    beyond = value + 1 if end == "maximum" else value - 1
    with pytest.raises(InputError, match=rf"/Anim\.mtex:edit:e:{name} is not allowed; expected .*; found {beyond}"):
        read_one(SETTINGS[name][0], name, str(beyond))


# --- reading one edit ---


def test_everything_authored() -> None:
    read = read_text(f"{EVERYTHING}\nrel mtex:edit:e:with = [</Other>, </Anim>]")
    assert (read.name, read.op) == ("e", "lowpass")
    assert read.settings == EVERYTHING_READ
    assert read.others == (Sdf.Path("/Other"), Sdf.Path("/Anim"))
    assert {"op", "with", *EVERYTHING_READ} == set(SETTINGS)


def test_nothing_but_the_operation() -> None:
    read = read_one("token", "op", '"mirror"')
    assert (read.op, read.settings, read.others) == ("mirror", {}, ())


def test_reads_the_same_unregistered() -> None:
    stacks = 'uniform token[] mtex:edits = ["e"]\nuniform token[] mtex:edits:calm = ["e"]'
    text = edit_text(EVERYTHING + stacks, schemas=f'"{EDIT_STACK_API}", "{EDIT_API}:e"')
    code = f"""
from pxr import Sdf, Usd
layer = Sdf.Layer.CreateAnonymous(".usda")
layer.ImportFromString('''#usda 1.0\n{text}''')
stage = Usd.Stage.Open(layer)
prim = stage.GetPrimAtPath("/Anim")
assert not prim.GetAppliedSchemas()
from mtex_usd.usd.plugin import registration_status
from mtex_usd.usd.schema import read_edit, read_stacks
assert not registration_status().registered
print(read_edit(prim, "e").settings, dict(read_stacks(prim).variants))
"""
    assert run_python(code) == f"{EVERYTHING_READ} {{'edited': ('e',), 'calm': ('e',)}}"


@pytest.mark.parametrize(
    ("type_name", "name", "value", "message"),
    [
        (
            "token",
            "op",
            '"smooth"',
            r'e:op is not allowed; expected "lowpass" or .*"reduceKeys"; found smooth',
        ),
        (
            "token",
            "op",
            '""',
            r"/Anim: edit e has no operation; expected token mtex:edit:e:op, one of lowpass, .*reduceKeys",
        ),
        ("int", "op", "1", r"mtex:edit:e:op has the wrong type; expected token; found int 1"),
        ("token", "channels", '"LeftArm"', r"e:channels has the wrong type; expected token\[\]; found string LeftArm"),
        ("double", "start", "5", r"e:start has the wrong type; expected timecode; found double 5"),
        ("double[]", "from", "[5]", r"e:from has the wrong type; expected timecode\[\]; found double\[\] \[5"),
        ("timecode", "keys", "5", r"e:keys has the wrong type; expected timecode\[\]; found timecode 5"),
        ("double", "frequencies", "5", r"e:frequencies has the wrong type; expected double\[\]; found double 5"),
        ("float[]", "gains", "[5]", r"e:gains has the wrong type; expected double\[\]; found float\[\] \[5"),
        ("float2[]", "points", "[(0, 0)]", r"e:points has the wrong type; expected double2\[\]; found float2\[\]"),
        ("float3[]", "rotations", "[(0, 0, 1)]", r"e:rotations has the wrong type; expected double3\[\]"),
        ("float2", "limits", "(0, 1)", r"e:limits has the wrong type; expected double2; found float2 \(0, 1\)"),
        ("int", "align", "1", r"e:align has the wrong type; expected bool; found int 1"),
        ("double", "order", "2.5", r"e:order has the wrong type; expected int; found double 2.5"),
        ("timecode", "start", "nan", r"e:start is not allowed; expected a finite time code; found nan"),
        ("timecode[]", "keys", "[1, inf]", r"e:keys is not allowed; expected finite time codes; found \(1.0, inf\)"),
        ("double", "ramp", "-0.1", r"e:ramp is not allowed; expected a finite number, at least 0; found -0.1"),
        ("double[]", "frequencies", "[nan]", r"e:frequencies is not allowed; expected finite numbers; found \(nan,\)"),
        ("double[]", "gains", "[inf]", r"e:gains is not allowed; expected decibels, -inf to mute; found \(inf,\)"),
        ("double[]", "gains", "[nan]", r"e:gains is not allowed; expected decibels, -inf to mute; found \(nan,\)"),
        ("double", "window", "0", r"e:window is not allowed; expected a finite number above 0; found 0.0"),
        ("double", "factor", "0", r"e:factor is not allowed; expected a finite number above 0; found 0.0"),
        ("double", "factor", "inf", r"e:factor is not allowed; expected a finite number above 0; found inf"),
        ("double2", "limits", "(20, 20)", r"e:limits is not allowed; expected the lower limit below the upper"),
        ("double2", "limits", "(nan, 20)", r"e:limits is not allowed; expected the lower limit below the upper"),
        ("double2", "scope", "(0, 1)", r"e:scope is not allowed; expected two numbers of seconds above 0"),
        ("double3[]", "rotations", "[(0, nan, 0)]", r"e:rotations is not allowed; expected finite numbers"),
        (
            "token",
            "ends",
            '"bounce"',
            r'e:ends is not allowed; expected "hold" or "loop" or "extrapolate"; found bounce',
        ),
        ("token", "about", '"zero"', r'e:about is not allowed; expected "mean" or "rest"'),
        ("token", "plane", '"xy"', r'e:plane is not allowed; expected "rest" or "facing"'),
        ("token", "place", '"last"', r'e:place is not allowed; expected "first" or "mean"'),
        ("token", "method", '"solve"', r'e:method is not allowed; expected "auto" or "blend" or "interpolate"'),
        ("token", "form", '"spline"', r'e:form is not allowed; expected "curves" or "poses"'),
        ("token", "contacts", '"always"', r'e:contacts is not allowed; expected "off" or "detect" or "declared"'),
        ("int", "keyCount", "-1", r"e:keyCount is not allowed; expected a finite number, at least 0; found -1"),
        ("double", "factr", "2", r"e:factr is not a property of the mtex schemas.*Did you mean mtex:edit:e:factor\?"),
        ("double", "frequency", "2", r"e:frequency is not a property.*Did you mean mtex:edit:e:frequencies\?"),
        ("int", "zzz", "2", r"e:zzz is not a property.*expected one of mtex:edit:e:about, .*Remove it"),
        ("double", "ramp.timeSamples", "{ 1: 2 }", r"e:ramp changes over time; expected one value for all time"),
    ],
)
def test_bad_settings(type_name: str, name: str, value: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_one(type_name, name, value)


def test_no_operation_is_said() -> None:
    with pytest.raises(
        InputError, match=r"/Anim: edit e has no operation; expected token mtex:edit:e:op, one of lowpass"
    ):
        read_text("double mtex:edit:e:factor = 2")


def test_a_blocked_setting_is_not_said() -> None:
    assert read_text('token mtex:edit:e:op = "scaleTime"\ndouble mtex:edit:e:factor = None').settings == {}


def test_names_of_edits_do_not_run_into_each_other() -> None:
    """`warm` and `warmer`; what is said of one is not said of the other."""
    body = 'token mtex:edit:e:op = "mirror"\ntoken mtex:edit:ee:op = "scaleTime"\ndouble mtex:edit:ee:factor = 2'
    stage = open_text(edit_text(body, schemas=f'"{EDIT_API}:e", "{EDIT_API}:ee"'))
    prim = stage.GetPrimAtPath("/Anim")
    assert (read_edit(prim, "e").op, read_edit(prim, "e").settings) == ("mirror", {})
    assert (read_edit(prim, "ee").op, read_edit(prim, "ee").settings) == ("scaleTime", {"factor": 2.0})


@pytest.mark.parametrize(
    ("target", "message"),
    [
        ("/Door", r"/Anim\.mtex:edit:e:with names no animation; expected SkelAnimations; found /Door, Xform"),
        (
            "/Nobody",
            r"/Anim\.mtex:edit:e:with names no animation; expected SkelAnimations; found /Nobody, which is not",
        ),
    ],
)
def test_targets_are_animations(target: str, message: str) -> None:
    with pytest.raises(StageError, match=message):
        read_text(f'token mtex:edit:e:op = "join"\nrel mtex:edit:e:with = [</Other>, <{target}>]')


def test_inactive_targets_are_refused() -> None:
    stage = open_text(edit_text('token mtex:edit:e:op = "join"\nrel mtex:edit:e:with = </Other>'))
    stage.GetPrimAtPath("/Other").SetActive(False)
    with pytest.raises(StageError, match=r"e:with names no animation; .*found /Other, which is inactive"):
        read_edit(stage.GetPrimAtPath("/Anim"), "e")


def open_referenced(targets: str) -> tuple[Usd.Stage, Sdf.Layer]:
    """Reference /Asset, whose animation names targets; gives the stage and the asset's layer."""
    layer = Sdf.Layer.CreateAnonymous("asset.usda")
    body = f'token mtex:edit:e:op = "blend"\nrel mtex:edit:e:with = {targets}'
    text = f'def Xform "Asset"\n{{\n{edit_text(body)}\n}}\ndef SkelAnimation "Take"\n{{\n}}\n'
    assert layer.ImportFromString(f"#usda 1.0\n{text}")
    stage = Usd.Stage.CreateInMemory()
    stage.DefinePrim("/Hero").GetReferences().AddReference(layer.identifier, "/Asset")
    return stage, layer


def test_a_target_that_composition_dropped_is_said() -> None:
    stage, layer = open_referenced("</Take>")
    message = (
        rf"/Hero/Anim\.mtex:edit:e:with: composition dropped the target /Take; .*{layer.identifier}.*Move the target"
    )
    with pytest.raises(StageError, match=message):
        read_edit(stage.GetPrimAtPath("/Hero/Anim"), "e")


def test_one_of_two_targets_that_composition_dropped_is_said() -> None:
    """With weights for two, one that vanished must not make another the first."""
    stage, _ = open_referenced("[</Take>, </Asset/Other>]")
    with pytest.raises(StageError, match=r"composition dropped the target /Take"):
        read_edit(stage.GetPrimAtPath("/Hero/Anim"), "e")


def test_times_are_moved_by_layer_offsets() -> None:
    stage = open_sublayer(edit_text(EVERYTHING), Sdf.LayerOffset(100.0, 2.0))
    settings = read_edit(stage.GetPrimAtPath("/Anim"), "e").settings
    moved = {
        name: (
            tuple(100.0 + 2.0 * time for time in value)
            if isinstance(value, tuple)
            else 100.0 + 2.0 * value
            if name in ("start", "end")
            else value
        )
        if SETTINGS[name][0].startswith("timecode")
        else value
        for name, value in EVERYTHING_READ.items()
    }
    assert settings == moved
    assert settings["keys"] == (108.0, 116.0)


# --- reading stacks ---


def test_stacks() -> None:
    body = """
    token[] mtex:edits = ["b", "a"]
    token[] mtex:edits:calm = ["a"]
    token[] mtex:edits:none = []
    token[] mtex:edits:before = ["c"]
    token[] mtex:edits:after = ["a", "c"]"""
    stacks = stacks_of(body)
    assert stacks == EditStacks(variants={"edited": ("b", "a"), "calm": ("a",)}, before=("c",), after=("a", "c"))
    assert list(stacks.variants) == ["edited", "calm"]


def test_no_stack_is_no_variant() -> None:
    assert stacks_of("") == EditStacks(variants={})
    assert stacks_of("token[] mtex:edits = []") == EditStacks(variants={})
    stage = open_text(edit_text('token[] mtex:edits = ["e"]'))
    assert read_stacks(stage.GetPrimAtPath("/Anim")) == EditStacks(variants={})


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (
            'token[] mtex:edits = ["a", "x"]',
            r"/Anim\.mtex:edits names an edit that is not there; expected instances of MtexEditAPI on this "
            r"prim: a, b, c; found x.*Apply MtexEditAPI:x",
        ),
        ('token[] mtex:edits:before = ["x"]', r"/Anim\.mtex:edits:before names an edit that is not there"),
        ('token[] mtex:edits:calm = ["a", "b", "a"]', r"/Anim\.mtex:edits:calm names a twice.*Apply a second edit"),
        ('token mtex:edits = "a"', r"/Anim\.mtex:edits has the wrong type; expected token\[\]; found string a"),
        ('string[] mtex:edits:after = ["a"]', r"mtex:edits:after has the wrong type; expected token\[\]"),
        ('token[] mtex:edits:original = ["a"]', r"mtex:edits:original cannot be the name of a stack; .*found original"),
        ('token[] mtex:edits:edited = ["a"]', r"mtex:edits:edited cannot be the name of a stack; .*found edited"),
        ('token[] mtex:edits:path_01 = ["a"]', r"cannot be the name of a stack; .*other commands make; found path_01"),
        ('token[] mtex:edits:constrained = ["a"]', r"mtex:edits:constrained cannot be the name of a stack"),
        ('token[] mtex:edits:one:two = ["a"]', r"mtex:edits:one:two cannot be the name of a stack; .*found one:two"),
        ('token[] mtex:edits.timeSamples = { 1: ["a"] }', r"/Anim\.mtex:edits changes over time"),
    ],
)
def test_bad_stacks(body: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        stacks_of(body)


def test_a_stack_of_an_animation_without_edits() -> None:
    with pytest.raises(InputError, match=r"expected instances of MtexEditAPI on this prim: there are none; found a"):
        stacks_of('token[] mtex:edits = ["a"]', edits="")
